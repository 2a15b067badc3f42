#!/usr/bin/env python3
"""The command line and its habits: run.py BERM [NAMES ...]

Every test starts the program in a folder of its own, as a careless user, a script or an attacker would, and returns what is wrong ("" if nothing is). Exits with
1 if a test fails.
"""

import os
import pathlib
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent


def main():
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    os.environ |= {"BERM": str(pathlib.Path(sys.argv[1]).resolve()), "OPENBLAS_NUM_THREADS": "1"}
    sys.path[:0] = [str(HERE), str(HERE.parent)]
    import folders, habits, inputs, processes  # noqa: E401, F401
    from harness import tests

    failed = 0
    for test in tests:
        if sys.argv[2:] and test.__name__ not in sys.argv[2:]:
            continue
        start = time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            try:
                why = test()
            except RuntimeError as error:  # a run that did not begin
                why = str(error)
            os.chdir("/")
        failed += bool(why)
        print(f"{test.__name__:28} {time.monotonic() - start:5.1f} s  {'FAILED: ' + why if why else 'as it should'}", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
