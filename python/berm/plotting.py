"""matplotlib with its own settings: figures are the same everywhere, whatever the user has in a matplotlibrc."""

import os

os.environ["MPLBACKEND"] = "agg"
# The file of the current folder counts before all others.
_here = os.open(".", os.O_PATH)
os.chdir(os.path.dirname(os.path.abspath(__file__)))
try:
    import matplotlib.pyplot as plt
finally:
    os.fchdir(_here)
    os.close(_here)

__all__ = ["plt"]
