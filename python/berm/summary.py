"""summary.json of a run, with the types that docs/output.md promises."""

import json
import sys

from berm.errors import ResultError


def _is_text(value):
    return isinstance(value, str)


def _is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) <= sys.float_info.max


def _is_number_or_null(value):
    return value is None or _is_number(value)


def _list_of(fits, length=None):
    return lambda value: isinstance(value, list) and all(map(fits, value)) and len(value) == (length or len(value))


def _table_of(fits):
    return lambda value: isinstance(value, dict) and all(map(fits, value.values()))


def _is_ring(value):
    return _list_of(_list_of(_is_number, 2))(value) and len(value) > 0


def _is_reference(value):
    return _is_text(value) or _table_of(_is_text)(value) and "file" in value


TEXT, NUMBER = (_is_text, "a text"), (_is_number, "a number")
KEYS = {
    **dict.fromkeys(("title", "method", "case", "status", "reason"), TEXT),
    **dict.fromkeys(("dofs", "points", "steps", "wall_seconds", "processes"), NUMBER),
    "thickness": (lambda value: _is_number(value) and value > 0, "a positive number"),
    "dimension": (lambda value: value in (2, 3), "2 or 3"),
    "axisymmetric": (lambda value: isinstance(value, bool), "true or false"),
    "references": (_list_of(_is_reference), "a list of files, or of tables of texts with a file"),
    "body_rings": (_table_of(_list_of(_is_ring)), "a table of lists of rings of [x, y]"),
    "body_surfaces": (_table_of(_is_text), "a table of files"),
    "rigid_motion": (_table_of(_list_of(_list_of(_is_number_or_null, 4))), "a table of lists of [time, x, y, z]"),
    "metrics": (_table_of(_is_number_or_null), "a table of numbers"),
}
REMEDY = "run the case again, or remove the file: the report does without"


def _short(value):
    text = json.dumps(value)
    return text if len(text) <= 40 else text[:37] + "..."


def read_summary(path):
    """The keys that have a value. Raises ResultError for a file that is not as a run writes it."""
    try:
        with open(path, encoding="utf-8", errors="replace") as file:
            summary = json.load(file)
    except OSError as error:
        raise ResultError(f"cannot read {path}: {error}") from None
    except (ValueError, RecursionError) as error:
        raise ResultError(f"{path} is damaged: {error} ({REMEDY})") from None
    if not isinstance(summary, dict):
        raise ResultError(f"{path} is damaged: it must hold a table, not {_short(summary)} ({REMEDY})")
    summary = {key: value for key, value in summary.items() if value is not None}
    for key, (fits, words) in KEYS.items():
        if key in summary and not fits(summary[key]):
            raise ResultError(f'{path} is damaged: "{key}" must be {words}, not {_short(summary[key])} ({REMEDY})')
    return summary
