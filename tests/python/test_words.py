import os
import subprocess
import sys
import unittest

from berm import words

TOOL = """
import sys
from berm import words

def main():
    {body}

words.run(main, "berm tool")
"""


def run_tool(body, **environment):
    """(exit code, standard output, standard error) of a tool whose main() is `body`."""
    environment = {**{k: v for k, v in os.environ.items() if k != "BERM_TRACEBACK"}, "PYTHONIOENCODING": "utf-8:strict", **environment}
    done = subprocess.run(
        [sys.executable, "-c", TOOL.format(body=body)], capture_output=True, timeout=60, env=environment, check=False
    )
    return done.returncode, done.stdout, done.stderr


class EndOfATool(unittest.TestCase):
    def test_exit_code_is_that_of_main(self):
        self.assertEqual(run_tool("return 2"), (2, b"", b""))
        self.assertEqual(run_tool("sys.exit(2)"), (2, b"", b""))

    def test_what_nobody_foresaw_is_one_line(self):
        code, out, errors = run_tool("print('begun'); return {}['two\\nlines']")
        self.assertEqual((code, out), (1, b"begun\n"))
        self.assertEqual(errors, b"berm tool: KeyError: 'two\\nlines' (set BERM_TRACEBACK=1 for where)\n")
        code, _, errors = run_tool("raise ValueError('two\\nlines')")
        self.assertEqual((code, errors), (1, b"berm tool: ValueError: two lines (set BERM_TRACEBACK=1 for where)\n"))

    def test_where_it_was(self):
        code, _, errors = run_tool("raise ValueError('a')", BERM_TRACEBACK="1")
        self.assertEqual(code, 1)
        self.assertIn(b"Traceback", errors)

    def test_interrupted(self):
        self.assertEqual(run_tool("raise KeyboardInterrupt")[::2], (1, b"berm tool: interrupted\n"))

    def test_file_that_cannot_be_written(self):
        self.assertEqual(run_tool("open('/nowhere/a', 'w')")[::2], (1, b"error: /nowhere/a: No such file or directory\n"))

    def test_paths_go_out_as_they_came(self):
        body = "print(chr(0xdce9)); print(chr(0xdce9), file=sys.stderr); print(chr(0xd800)); return 0"
        self.assertEqual(run_tool(body), (0, b"\xe9\n\\ud800\n", b"\xe9\n"))
        self.assertEqual(words.readable("a\udce9\ud800"), "a\ufffd\ufffd")


if __name__ == "__main__":
    unittest.main()
