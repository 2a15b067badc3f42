"""The words of a tool: numbers that it takes, paths that it shows, and how it ends."""

import argparse
import codecs
import errno
import math
import os
import re
import sys
import warnings


def _finite(text, good, what):
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and good(value)):
        raise argparse.ArgumentTypeError(f"{text} is not {what}")
    return value


def positive(text):
    """For argparse: a finite positive number."""
    return _finite(text, lambda value: value > 0.0, "a finite positive number")


def at_least_zero(text):
    """For argparse: a finite number that is not negative."""
    return _finite(text, lambda value: value >= 0.0, "a finite number of at least 0")


def given(text):
    """For argparse: an empty word is a variable of a script that was not set, and another result than was meant."""
    if not text:
        raise argparse.ArgumentTypeError("is empty: a variable that is not set?")
    return text


def readable(text):
    """The text with a sign in the place of what is no UTF-8 in a path."""
    return re.sub("[\ud800-\udfff]", "\N{REPLACEMENT CHARACTER}", text)


def _as_it_came(error):
    """For codecs: bytes of a path go out as they came, and what the terminal has no letter for as \\u1234."""
    of_path = all("\udc80" <= letter <= "\udcff" for letter in error.object[error.start : error.end])
    return codecs.lookup_error("surrogateescape" if of_path else "backslashreplace")(error)


codecs.register_error("as_it_came", _as_it_came)


def _flush_words():
    try:
        sys.stdout.flush()
    except OSError as error:
        error.filename = "standard output"
        raise


def _last_words(name, error):
    if isinstance(error, BrokenPipeError):
        return ""  # a reader that has gone
    if isinstance(error, KeyboardInterrupt):
        return f"{name}: interrupted"
    if isinstance(error, OSError):
        where = f"{readable(str(error.filename))}: " if error.filename else ""
        remedy = ": make room on the disk of the output, or choose another (--out)" if error.errno in (errno.ENOSPC, errno.EDQUOT) else ""
        return f"error: {where}{error.strerror or error}{remedy}"
    if isinstance(error, ImportError):
        return f"{name}: {error}: install python3-numpy, python3-matplotlib and python3-vtk9, or name a Python that has them (BERM_PYTHON)"
    text = " ".join(f"{type(error).__name__}: {error}".split())
    return f"{name}: {text} (set BERM_TRACEBACK=1 for where)"


def run(main, name):
    """Runs the tool of that name and ends the process with its exit code; with 1 and one line in the place of a traceback if
    it fails in a way that it does not foresee, or if standard output is full, closed, or a reader that has gone."""
    if not os.environ.get("BERM_TRACEBACK"):
        warnings.simplefilter("ignore")  # of Python and its packages: they name lines of sources
    for stream in (sys.stdout, sys.stderr):
        if stream:  # None: closed
            stream.reconfigure(errors="as_it_came")
    try:
        try:
            code = main()
        except SystemExit as end:  # argparse
            code = end.code
        if sys.stdout:
            _flush_words()
    except (Exception, KeyboardInterrupt) as error:
        if os.environ.get("BERM_TRACEBACK"):
            raise
        code, line = 1, _last_words(name, error)
        if line:
            print(line, file=sys.stderr)
        if isinstance(error, OSError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # Python flushes once more
    sys.exit(code)
