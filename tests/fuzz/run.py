#!/usr/bin/env python3
"""Mutated input: the program must refuse it with words and a place, or take it.

    run.py BERM [--cases N] [--meshes N] [--seed S] [--first K] [--seconds T] [--out DIR]

Cases: those of examples/ and tests/bad_input/ with numbers, strings, units, keys, tables or bytes changed: `berm check`, and for a part of those
that are taken `berm run`, stopped after some seconds. Meshes: Gmsh meshes, STL surfaces and checkpoints with numbers or bytes changed or cut short.
Every run has 4 GB of addresses, 20 s and files of 64 MB at most. A finding is a signal, no end in time, an exit code other than 0, 1 and 2,
code 2 without the name of a file, code 1 without "berm:" at the start of a line, and words of C++ ("std::bad_alloc", ...). Findings lie in DIR
(default: fuzz_findings in the folder for temporary files), each with its input and what was said; `--first K --cases 1` repeats number K.
Exits with 1 if there are any. --seconds ends each kind after that time however many are done.
"""

import argparse
import pathlib
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import zlib

from mutations import mutate_bytes, mutate_case, mutate_numbers
from samples import read_files, restarted_cases

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
ADDRESSES, FILE_SIZE, SECONDS = 4 << 30, 64 << 20, 20
RUN_SHARE, SHORT = 0.1, 3.0  # part of the good cases that is run, and for how long [s]
GOOD_SHARE = 0.7
HEAVY, HEAVY_SHARE = re.compile("examples/(05|06|09)_"), 0.1  # cases in space, of which a check takes seconds
CPP_WORDS = re.compile(
    r"bad_alloc|std::|basic_string|vector::|terminate called|Assertion|Sanitizer|runtime error:|Segmentation|PETSC ERROR|_M_|stoi|stod|bad_variant|"
    r"bad_optional|map::at|what\(\)"
)
FILE_NAME = re.compile(r"\.(toml|msh|stl|h5|csv)\b|override \"")


def limits():
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESSES, ADDRESSES))
    resource.setrlimit(resource.RLIMIT_FSIZE, (FILE_SIZE, FILE_SIZE))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # then it is an error of writing


def judge(code, said):
    """Empty if a program may end like that, else what is wrong."""
    if code is None:
        return f"no end after {SECONDS} s"
    if code not in (0, 1, 2):
        return f"signal {-code}" if code < 0 else f"exit code {code}"
    if words := CPP_WORDS.search(said):
        return f"words of C++: {words.group(0)}"
    if code == 2 and not FILE_NAME.search(said):
        return "code 2 and no file is named"
    if code == 1 and not re.search(r"^berm: ", said, re.MULTILINE):
        return "code 1 and no word of berm"
    return ""


class Fuzz:
    def __init__(self, options):
        self.berm = pathlib.Path(options.berm).resolve()
        self.seed, self.first, self.seconds = options.seed, options.first, options.seconds
        self.out = pathlib.Path(options.out or pathlib.Path(tempfile.gettempdir()) / "fuzz_findings")
        self.findings, self.codes = 0, {}
        self.scratch = pathlib.Path(tempfile.mkdtemp(prefix="berm_fuzz_"))

    def call(self, arguments, stop_after=None):
        """(exit code, None for none in time; what was said). stop_after: as Ctrl-C does it."""
        with tempfile.TemporaryFile() as said:
            environment = {"PATH": "/usr/bin:/bin", "OPENBLAS_NUM_THREADS": "1", "HOME": str(self.scratch)}
            process = subprocess.Popen([self.berm, *arguments], stdin=subprocess.DEVNULL, stdout=said, stderr=said,
                                       cwd=self.scratch, env=environment, preexec_fn=limits)  # fmt: skip
            try:
                code = process.wait(stop_after or SECONDS)
            except subprocess.TimeoutExpired:
                code = self.end(process, stop_after is not None)
            said.seek(0)
            return code, said.read(1 << 20).decode("utf-8", "replace")

    @staticmethod
    def end(process, kindly):
        if kindly:
            process.send_signal(signal.SIGINT)
            try:
                return process.wait(SECONDS)
            except subprocess.TimeoutExpired:
                pass
        process.kill()
        process.wait()
        return None

    def attempt(self, name, files, arguments, stop_after=None):
        """One call; a finding keeps the files and the words. Returns the exit code."""
        code, said = self.call([str(a) for a in arguments], stop_after)
        self.codes[code] = self.codes.get(code, 0) + 1
        if why := judge(code, said):
            self.findings += 1
            folder = self.out / f"{self.seed}_{name}"
            folder.mkdir(parents=True, exist_ok=True)
            for file in files:
                shutil.copy(file, folder)
            words = f"{why}\nberm {' '.join(map(str, arguments))}\n\n{said}"
            (folder / "said.txt").write_text(words, encoding="utf-8")
            print(f"{folder}: {why}", flush=True)
        return code

    def each(self, kind, count, try_one):
        """Calls try_one(its name, its own random numbers) that often, or until the time is over. Returns how often."""
        end = time.monotonic() + self.seconds if self.seconds else None
        for k in range(self.first, self.first + count):
            if end and time.monotonic() > end:
                return k - self.first
            try_one(f"{kind}_{k}", random.Random(f"{self.seed} {kind} {k}"))
        return count

    def cases(self, count):
        work = self.scratch / "cases"
        for folder in ("examples", "tests/bad_input"):  # beside the others, so that files are found
            shutil.copytree(ROOT / folder, work / folder, ignore=shutil.ignore_patterns("images", "*.md", "*.py"))
        sources = sorted([*work.glob("examples/*/*.toml"), *work.glob("tests/bad_input/*.toml")])
        texts = {source: source.read_bytes() for source in sources}
        good = [s for s in sources if "examples" in s.parts or s.name.startswith("good")]  # in others the first fault hides the rest

        def try_one(name, rng):
            among = good if rng.random() < GOOD_SHARE else sources
            source = rng.choice(among)
            while HEAVY.search(str(source)) and rng.random() > HEAVY_SHARE:
                source = rng.choice(among)
            mutant = source.with_name("mutant.toml")
            mutant.write_bytes(mutate_case(texts[source], [texts[rng.choice(sources)] for _ in range(2)], rng))
            code = self.attempt(name, [mutant], ["check", mutant])
            if code == 0 and rng.random() < RUN_SHARE:
                self.attempt(f"{name}_run", [mutant], ["run", mutant, "--out", self.scratch / "out", "--quiet", "--force"], SHORT)
                shutil.rmtree(self.scratch / "out", ignore_errors=True)
            mutant.unlink()

        return self.each("case", count, try_one)

    def meshes(self, count):
        samples = read_files()
        case = self.scratch / "case.toml"
        for name, content, text in samples:  # what is wrong with a sample itself would hide everything
            (self.scratch / name).write_bytes(content)
            case.write_text(text.replace("FILE", name), encoding="utf-8")
            if self.attempt("sample", [case, self.scratch / name], ["check", case]) != 0:
                sys.exit(f"berm check refuses a good file: {name}, {self.call(['check', str(case)])[1]}")

        def try_one(name, rng):
            file_name, content, text = rng.choice(samples)
            file = self.scratch / file_name
            file.write_bytes(rng.choice((mutate_bytes, mutate_numbers))(content, rng))
            case.write_text(text.replace("FILE", file_name), encoding="utf-8")
            if self.attempt(name, [case, file], ["check", case]) == 0 and rng.random() < RUN_SHARE:
                self.attempt(f"{name}_run", [case, file], ["run", case, "--out", self.scratch / "out", "--quiet", "--force"], SHORT)

        return self.each("mesh", count, try_one)

    def checkpoints(self, count):
        samples = []
        case, out, file = self.scratch / "restarted.toml", self.scratch / "restarted", self.scratch / "mutant.h5"
        for text in restarted_cases():
            case.write_text(text, encoding="utf-8")
            if self.attempt("sample", [case], ["run", case, "--out", out, "--quiet", "--force"]) != 0:
                sys.exit("berm run refuses a good case")
            samples.append((text, (out / "checkpoint.h5").read_bytes()))

        def try_one(name, rng):
            text, content = rng.choice(samples)
            case.write_text(text, encoding="utf-8")
            mutant = mutate_bytes(content, rng)
            # Half of them with a checksum that fits, so that what lies behind it is reached.
            file.write_bytes(sealed(mutant) if rng.random() < 0.5 else mutant)
            self.attempt(name, [case, file], ["run", case, "--out", out, "--restart", file, "--quiet", "--force"], SHORT)

        return self.each("checkpoint", count, try_one)


def sealed(content):
    """As src/comm/seal.cpp does it."""
    rest = content[512:]
    return f"berm checkpoint: {len(rest)} bytes follow, crc32 {zlib.crc32(rest):08x}\n".encode().ljust(512, b"\0") + rest


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("berm")
    parser.add_argument("--cases", type=int, default=200)
    parser.add_argument("--meshes", type=int, default=100, help="meshes and surfaces, and half as many checkpoints")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first mutant")
    parser.add_argument("--seconds", type=float, help="at most for each kind")
    parser.add_argument("--out")
    options = parser.parse_args()
    fuzz = Fuzz(options)
    try:
        done = fuzz.cases(options.cases), fuzz.meshes(options.meshes), fuzz.checkpoints(options.meshes // 2)
    finally:
        shutil.rmtree(fuzz.scratch, ignore_errors=True)
    ends = ", ".join(f"{n} with {code}" for code, n in sorted(fuzz.codes.items(), key=str))
    print(f"{done[0]} cases, {done[1]} meshes, {done[2]} checkpoints ({ends}): {fuzz.findings} findings")
    return 1 if fuzz.findings or min(done) == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
