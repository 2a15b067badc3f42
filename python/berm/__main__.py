"""python3 -m berm TOOL ...: what `berm report` and the other tools start. They are loaded here, so that what is wrong with Python's packages is told in a line."""

import importlib
import sys

from berm import words


def main():
    return importlib.import_module(f"berm.{sys.argv[1]}").main(sys.argv[2:])


if __name__ == "__main__":
    words.run(main, f"berm {sys.argv[1]}")
