#!/usr/bin/env python3
"""Writes the expected_*.csv of this folder from the closed form of README.md."""

import math
import pathlib

E, NU, FT, N, GF, L = 35.5e9, 0.2, 3.05e6, 12.3, 100.0, 0.1
A = 1.0 / (E * GF / (L * FT**2) - 0.5)
STEPS, REACH = 120, 12.0  # the runs go to 12 times the strain at the peak

K_SHEAR = 0.5 + 0.5 / N  # share of tension 1/2
PEAK = {"tension": FT, "compression": N * FT, "shear": FT / (K_SHEAR * math.sqrt(2.0 * (1.0 + NU)))}
MODULUS = {"tension": E, "compression": E, "shear": E / (2.0 * (1.0 + NU))}
SOURCE = "closed form, README.md"


def stress(path, x):
    """Stress at x times the strain of the peak [Pa]."""
    return PEAK[path] * (x if x <= 1.0 else math.exp(A * (1.0 - x)))


def damage(x):
    return 0.0 if x <= 1.0 else 1.0 - math.exp(A * (1.0 - x)) / x


def rows(path):
    yield "peak_stress", PEAK[path], 1e-8, "relative"
    yield "displacement_at_peak", PEAK[path] / MODULUS[path] * L, 1e-8, "relative"
    for x in (0.5, 1.5, 2.0, 5.0, 10.0):
        yield f"history:nominal_stress@{x / REACH!r}", stress(path, x), 1e-8, "relative"
    probe, sign = ("stress_xy", 1.0) if path == "shear" else ("stress_xx", -1.0 if path == "compression" else 1.0)
    yield f"last:probe:{probe}", sign * stress(path, REACH), 1e-8, "relative"
    yield "last:probe:damage", damage(REACH), 1e-8, "absolute"


def main():
    folder = pathlib.Path(__file__).parent
    for path in PEAK:
        lines = ["quantity,value,tolerance,kind,source"]
        lines += [f"{quantity},{value!r},{tolerance},{kind},\"{SOURCE}\"" for quantity, value, tolerance, kind in rows(path)]
        for name in (path, path + "_fem"):
            (folder / f"expected_{name}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
