"""The end of a tool: exit codes when nobody takes its words."""

import os
import sys


def run(main):
    """Runs the tool and ends the process with its exit code; with 1 and no traceback if standard output is full, closed, or
    a reader that has gone."""
    try:
        try:
            code = main()
        except SystemExit as end:  # argparse
            code = end.code
        if sys.stdout:  # None: closed
            sys.stdout.flush()
        sys.exit(code)
    except OSError as error:
        if not isinstance(error, BrokenPipeError):
            print(f"error: {error}", file=sys.stderr)
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # Python flushes once more
        sys.exit(1)
