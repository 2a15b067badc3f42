"""Files that the tools read and write."""

import errno
import os


def may_never_end(path):
    """Whether what has that name is no regular file: a pipe would be waited for, a device read for ever."""
    return os.path.exists(path) and not os.path.isfile(path)


def new_file(path, binary=False):
    """Opens a file of its own for writing: what has that name makes way, so that nothing is written through a link to
    somewhere else. Text has the line ends that it is given, and a ? where a path has bytes that are no UTF-8."""
    try:
        if os.path.islink(path) or os.path.isfile(path):
            os.remove(path)
        mode = "w" if os.path.exists(path) else "x"  # a device is written to as it is
        return open(path, mode + "b") if binary else open(path, mode, newline="", encoding="utf-8", errors="replace")
    except OSError as error:
        if error.errno not in (errno.EACCES, errno.EPERM, errno.EROFS):
            raise
        raise OSError(error.errno, f"{error.strerror}: choose another place (--out)", path) from error
