#!/usr/bin/env python3
"""The JSON Schema of `berm schema --format json` is valid, accepts every example and refuses misspelt keys.

check_schema.py BERM: exit code 77 (skipped) without the Debian package python3-jsonschema.
"""

import copy
import json
import pathlib
import subprocess
import sys
import tomllib

try:
    import jsonschema
except ImportError:
    print("skipped: install python3-jsonschema")
    sys.exit(77)

ROOT = pathlib.Path(__file__).resolve().parents[3]


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    text = subprocess.run([sys.argv[1], "schema", "--format", "json"], capture_output=True, check=True).stdout
    schema = json.loads(text)
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    files = [p for p in sorted(ROOT.glob("examples/**/*.toml")) if not p.name.startswith("sweep")]
    failures = []
    good = [ROOT / "tests/bad_input" / name for name in ("good.toml", "good_solid.toml")]
    for path in files + good:
        case = tomllib.loads(path.read_text(encoding="utf-8"))
        failures += [f"{path}: {error.json_path}: {error.message}" for error in validator.iter_errors(case)]
        wrong = copy.deepcopy(case)
        wrong.setdefault("solver", {})["integratoin"] = "implicit"
        if validator.is_valid(wrong):
            failures.append(f"{path}: a misspelt key is accepted")
    print("\n".join(failures))
    print(f"{len(files) + len(good)} files, {len(failures)} failures")
    return 1 if failures or not files else 0


if __name__ == "__main__":
    sys.exit(main())
