"""What ends a tool with words of its own."""


class ResultError(Exception):
    """The folder or file is not what it should be; the message says which and why."""
