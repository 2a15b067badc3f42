"""Habits of a command line."""

import json
import os
import pathlib

from harness import BERM, CASE, berm, shell, test, wrong


@test
def empty_words():
    """As of a variable in a script that was not set: a run must not begin anew for it."""
    if why := wrong(berm("run", "case.toml", "--set", "checkpoint.every_steps=1"), 0):
        return why
    before = pathlib.Path("out/case/history.csv").read_bytes()
    why = "".join(wrong(berm("run", "case.toml", "--force", option, ""), 2, option, "is empty") for option in ("--restart", "--out", "--set"))
    return why or ("" if pathlib.Path("out/case/history.csv").read_bytes() == before else "began anew")


@test
def words_of_help():
    return (wrong(berm("--version"), 0, "berm 0") or wrong(berm("rnu", "case.toml"), 2, 'did you mean "run"?') or wrong(berm("version"), 0, "berm 0")
            or wrong(berm("report", "--help"), 0, "--scale") or wrong(berm("sweep", "--help"), 0, "--jobs", "--short")
            or wrong(berm("factor_of_safety", "--help"), 0, "--tolerance") or wrong(berm("run", "--help"), 0, "--oversubscribe", "--force") or wrong(berm(), 2))


@test
def what_is_not_expected():
    return (wrong(berm("run", "case.toml", "--set", "steps.count=1", "title=x"), 2, "berm: ", "every override has its own --set") or wrong(berm("run"), 2, "see berm run --help")
            or wrong(berm("check", "case.toml", "--foo"), 2, "--foo; see berm check --help"))


def completed(line):
    """What bash offers for the last word of a line."""
    words = line.split(" ")
    listed = " ".join(f"'{w}'" for w in words)
    done = shell(f'set -u; eval "$("$BERM" completion bash)"; COMP_WORDS=({listed}); COMP_WORDS[0]=$BERM; COMP_CWORD={len(words) - 1}; _berm; echo "${{COMPREPLY[@]}}"')
    return done.stdout.split()


@test
def completion():
    pathlib.Path("case.toml").write_text(CASE)
    for line, offered in (("berm r", {"run", "report"}), ("berm run --ov", {"--oversubscribe"}), ("berm run c", {"case.toml"}), ("berm schema --format j", {"json"}),
                          ("berm sweep --sh", {"--short"}), ("berm check --fo", set()), ("berm completion b", {"bash"})):
        if set(completed(line)) != offered:
            return f"{line}: {completed(line)}, not {offered}"
    return ""


@test
def origin_of_results():
    for n in ("1", "2"):
        if why := wrong(berm("run", "case.toml", "-n", n, "--oversubscribe", "--force", "--set", 'title="a b"'), 0):
            return why
        summary = json.loads(pathlib.Path("out/case/summary.json").read_text())
        command = f"berm run case.toml -n {n} --oversubscribe --force --set 'title=\"a b\"'"
        head = pathlib.Path("out/case/log.txt").read_text().splitlines()[:2]
        if (summary["command"], summary["processes"], summary["host"]) != (command, int(n), os.uname().nodename) or not summary["version"]:
            return f"-n {n}: {summary}"
        if not head[0].startswith(f"berm {summary['version']}") or f"{n} process" not in head[0] or head[1] != "command: " + command:
            return f"-n {n}: {head}"
    return ""
