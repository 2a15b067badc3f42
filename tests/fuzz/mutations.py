"""Changes of a text or of bytes, chosen by a random.Random."""

import re

NUMBER = re.compile(rb"(?<![\w.\"])[-+]?(?:\d+\.\d*|\.\d+|\d+)(?:[eE][-+]?\d+)?(?![\w.])")
TEXT = re.compile(rb"\"[^\"\n]*\"")
VALUE = re.compile(rb"(?<== )[^\n{\[#]+|(?<== )[\[{][^\n]*[\]}](?=\s*(?:\n|$))")
HEADER = re.compile(rb"^\[", re.MULTILINE)
NUMBERS = (
    b"0", b"0.0", b"-1", b"1", b"-0.0", b"1e-300", b"1e-12", b"1e12", b"1e300", b"1e308", b"-1e308", b"nan", b"inf", b"-inf",
    b"1000000", b"2147483647", b"2147483648", b"-2147483648", b"9223372036854775807", b"99999999999999999999", b"0.5", b"1e-5",
    b"3", b"100000",
)  # fmt: skip
TEXTS = (
    "", " ", "\\", "\\u0000", "\\t", "ä", "💥", "x" * 5000, "../../../etc/passwd", "/dev/null", "/dev/zero", "/", ".", "%s%n", "{}", "t", "1/0", "0/t",
    "1/(t - 1)", "ln(t)", "sqrt(-1)", "sin(", "((((((", "x^1e9", "1e308*10", "y*t", "min()", "if(1,2", "t ? 1", "a=1", "t, t", "35 GPa", "5 mm", "GPa",
    "5 furlong", "1e999 MPa", "nan m", "-5 mm", "0 m", "1e300 km", "1 kN", "5", "1_000 m", "0x10 m", "1 MPa MPa", "20 deg", "1 m2", "t" * 2000,
    "(" * 3000 + "t" + ")" * 3000, "-" * 4000 + "1", "t" + "+t" * 3000, "fem", "mpm", "quads", "triangles", "hexahedra", "dynamic", "gimp", "cpdi",
    "linear_elastic", "rankine", "mohr_coulomb", "newtonian", "neo_hookean", "strain", "stress", "axisymmetric", "finite", "small", "mixed", "f_bar",
    "gauss", "friction", "tie", "no_slip", "shared_nodes", "following", "impl_ex", "lagged", "iterative", "gauge", "quadratic_bspline",
    "cubic_bspline", "b2gimp", "-help", "-log_view", "-pc_type none -ksp_type nonsense",
)  # fmt: skip
VALUES = (
    b"true", b"false", b"[]", b"{}", b"[[]]", b"[{}]", b"[1, 2]", b"[1.0, 2.0, 3.0]", b"[\"a\", 1]", b"1979-05-27", b"07:32:00",
    b"\"text\"", b"7", b"-7", b"0.5", b"{ a = 1 }", b"[0.0, \"t\"]", b"[nan, inf]", b"[" * 200 + b"]" * 200, b"\"\"\"a\nb\"\"\"",
    b"[ { box = { min = [0.0, 0.0], max = [0.0, 0.0] } } ]", b"0x7fffffff", b"[1e308, 1e308]", b"",
)  # fmt: skip


def swap_in(text, pattern, new, rng):
    """One of the matches replaced by new(match)."""
    found = list(pattern.finditer(text))
    if not found:
        return text
    match = rng.choice(found)
    return text[: match.start()] + new(match.group(0)) + text[match.end() :]


def other_number(number, rng):
    """A special one, or one not far from it."""
    if rng.random() < 0.6:
        return rng.choice(NUMBERS)
    value = float(number)
    factor = rng.choice((-1.0, 0.5, 2.0, 1e-3, 1e3, 1e6, 1.0 + 1e-9, 0.999))
    return str(round(factor * value) if b"." not in number and abs(value) < 1e9 else factor * value).encode()


def lines_of(text):
    return text.split(b"\n")


def tables_of(text):
    """Pieces that begin with a header; the first one is what stands before."""
    starts = [0, *(m.start() for m in HEADER.finditer(text)), len(text)]
    return [text[a:b] for a, b in zip(starts, starts[1:])]


def mutate_list(pieces, rng, other):
    """One piece left out, doubled, moved, or taken from another list."""
    if not pieces:
        return pieces
    k, pieces = rng.randrange(len(pieces)), list(pieces)
    kind = rng.randrange(5)
    if kind == 0:
        del pieces[k]
    elif kind == 1:
        pieces.insert(rng.randrange(len(pieces) + 1), pieces[k])
    elif kind == 2:
        i = rng.randrange(len(pieces))
        pieces[k], pieces[i] = pieces[i], pieces[k]
    elif kind == 3 and other:
        pieces.insert(k, rng.choice(other))
    elif other:
        pieces[k] = rng.choice(other)
    return pieces


def mutate_bytes(data, rng):
    """Bits turned, bytes put in, left out, repeated, or the end cut off."""
    data = bytearray(data)
    kind = rng.randrange(6)
    if not data or kind == 0:
        return bytes(data[: rng.randrange(len(data) + 1)])
    for _ in range(rng.choice((1, 1, 2, 8, 64))):
        at = rng.randrange(len(data))
        if kind == 1:
            data[at] ^= 1 << rng.randrange(8)
        elif kind == 2:
            data[at] = rng.choice((0, 255, 127, 128, rng.randrange(256)))
        elif kind == 3:
            data[at:at] = bytes(rng.randrange(256) for _ in range(rng.choice((1, 4, 8))))
        elif kind == 4 and len(data) > 8:
            del data[at : at + rng.choice((1, 4, 8))]
        else:
            data[at : at + 8] = rng.choice((b"\0" * 8, b"\xff" * 8, b"\x7f\xf0\0\0\0\0\0\0"[::-1], b"\0\0\0\x80" * 2))
        if len(data) == 0:
            break
    return bytes(data)


def mutate_numbers(data, rng):
    for _ in range(rng.choice((1, 1, 1, 2, 5))):
        data = swap_in(data, NUMBER, lambda n: other_number(n, rng), rng)
    return data


def mutate_case(text, others, rng):
    """One to three changes; `others`: texts that lines and tables may be taken from."""
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        kind = rng.random()
        if kind < 0.35:
            text = mutate_numbers(text, rng)
        elif kind < 0.5:
            text = swap_in(text, TEXT, lambda _: b'"' + rng.choice(TEXTS).encode() + b'"', rng)
        elif kind < 0.6:
            text = swap_in(text, VALUE, lambda _: rng.choice(VALUES), rng)
        elif kind < 0.66:  # a number becomes an expression or carries a unit
            text = swap_in(text, NUMBER, lambda _: b'"' + rng.choice(TEXTS).encode() + b'"', rng)
        elif kind < 0.8:
            text = b"\n".join(mutate_list(lines_of(text), rng, lines_of(rng.choice(others))))
        elif kind < 0.92:
            text = b"".join(mutate_list(tables_of(text), rng, tables_of(rng.choice(others))))
        else:
            text = mutate_bytes(text, rng)
    return text
