#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tables of how much light the sheen lobe reflects in all, which has no closed form: writes kernels/bsdf/tables/sheen_table.h.

  tools/tables/make_sheen_table.py            integrate, write the header, print how far interpolation is off (needs numpy)
  tools/tables/make_sheen_table.py --check    fail unless the header is what this would write, to 2e-6

The lobe is that of kernels/bsdf/sheen.h: the Charlie distribution D with the fitted shadowing of Estevez and Kulla [2017,
"Production Friendly Microfacet Sheen BRDF"], as KHR_materials_sheen has it. Below a roughness of about 0.25 it would reflect more
light at grazing angles than arrives; there it is divided by the most that it reflects, for every pair of directions alike, which
keeps it reciprocal. Rows are roughnesses, columns the square root of the cosine; both evenly spaced and interpolated linearly."""

import argparse
import pathlib
import re
import sys

import numpy as np

from c_numbers import lines_of

HEADER = pathlib.Path(__file__).resolve().parents[2] / "kernels/bsdf/tables/sheen_table.h"
LEAST_ROUGHNESS = 0.09375
ROWS, COLUMNS = 30, 48
LEAST_COSINE = 1 / 1024  # smaller ones count as this in the shadowing, whose fit ends near there


def shadowing_exponent(x, alpha):
    """[Estevez and Kulla 2017, equation 3 and table 1]"""
    t = (1 - alpha) ** 2
    a, b, c, d, e = (t * p0 + (1 - t) * p1 for p0, p1 in (
        (25.3245, 21.5473), (3.32435, 3.82987), (0.16801, 0.19823), (-1.27393, -1.97760), (-4.85967, -4.32054)))
    return a / (1 + b * x ** c) + d * x + e


def shadowing(cosine, alpha):
    """Lambda."""
    return np.exp(np.where(cosine < 0.5, shadowing_exponent(np.minimum(cosine, 0.5), alpha),
                           2 * shadowing_exponent(0.5, alpha) - shadowing_exponent(np.minimum(1 - cosine, 0.5), alpha)))


def quadrature():
    node, weight = np.polynomial.legendre.leggauss(240)
    t = (node + 1) / 2
    return t ** 3, weight / 2 * 3 * t ** 2


Z, Z_WEIGHT = quadrature()
PHI = (np.arange(192) + 0.5) / 192 * np.pi


def albedo(roughness, cosine):
    alpha = roughness ** 2
    s_o, s_i = np.sqrt(1 - cosine ** 2), np.sqrt(1 - Z ** 2)[:, None]
    x, y, z = s_o + s_i * np.cos(PHI), s_i * np.sin(PHI), (cosine + Z)[:, None]
    sin2 = (x * x + y * y) / (x * x + y * y + z * z)
    d = (2 + 1 / alpha) / (2 * np.pi) * (sin2 ** (0.5 / alpha)).mean(axis=1) * 2 * np.pi
    c_o, c_i = max(cosine, LEAST_COSINE), np.maximum(Z, LEAST_COSINE)
    visibility = 1 / ((1 + shadowing(np.array(c_o), alpha) + shadowing(c_i, alpha)) * 4 * c_o * c_i)
    return float((Z_WEIGHT * visibility * Z * d).sum())


def table(rows, columns):
    roughness = LEAST_ROUGHNESS + (1 - LEAST_ROUGHNESS) * np.arange(rows) / (rows - 1)
    cosine = (np.arange(columns) / (columns - 1)) ** 2
    return roughness, cosine, np.array([[albedo(r, c) for c in cosine] for r in roughness])


def interpolate(values, roughness, cosine):
    def place(x, count):
        at = np.clip(x * (count - 1), 0, count - 1)
        low = np.minimum(at.astype(int), count - 2)
        return low, at - low
    i, u = place((roughness - LEAST_ROUGHNESS) / (1 - LEAST_ROUGHNESS), values.shape[0])
    j, v = place(np.sqrt(cosine), values.shape[1])
    return ((1 - u) * ((1 - v) * values[i, j] + v * values[i, j + 1]) +
            u * ((1 - v) * values[i + 1, j] + v * values[i + 1, j + 1]))


def text():
    """The header, and the errors of interpolation."""
    _, _, values = table(ROWS, COLUMNS)
    shrink = np.minimum(0.995 / values.max(axis=1), 1)  # the maximum may lie between the columns
    dense_r, dense_c, exact = table(2 * ROWS - 1, 2 * COLUMNS - 1)
    r, c = np.meshgrid(dense_r, dense_c, indexing="ij")
    exact = exact * interpolate(np.repeat(shrink[:, None], 2, 1), r, c)
    values = values * shrink[:, None]
    error = interpolate(values, r, c) - exact
    lift = np.ceil(-error.min() * 1e4) / 1e4 + 1e-4
    print(f"interpolation: from {error.min():+.2e} to {error.max():+.2e}; greatest albedo {exact.max():.6f}", file=sys.stderr)

    def numbers(array):
        flat = [f"{x:.6g}" for x in array.ravel()]
        return lines_of(x + "f" if "." in x or "e" in x else x + ".0f" for x in flat)

    return f"""// SPDX-License-Identifier: Apache-2.0
// Written by tools/tables/make_sheen_table.py, which says what it is.
#ifndef EK_SHEEN_TABLE_H
#define EK_SHEEN_TABLE_H

#define EK_SHEEN_LEAST_ROUGHNESS {LEAST_ROUGHNESS!r}f
#define EK_SHEEN_LEAST_COSINE {LEAST_COSINE!r}f
#define EK_SHEEN_ROWS {ROWS}u
#define EK_SHEEN_COLUMNS {COLUMNS}u
#define EK_SHEEN_LIFT {lift:.6g}f  // interpolation is less than the truth by at most this

// By roughness: what the lobe is multiplied by.
constant float sheen_shrink_table[EK_SHEEN_ROWS] = {{
{numbers(shrink)}
}};

// By roughness and the square root of the cosine: the albedo of the lobe, multiplied so.
constant float sheen_albedo_table[EK_SHEEN_ROWS * EK_SHEEN_COLUMNS] = {{
{numbers(values)}
}};

#endif
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="compare the header instead of writing it")
    arguments = parser.parse_args()
    made = text()
    if not arguments.check:
        HEADER.write_text(made)
        return
    found, expected = ([float(x) for x in re.findall(r"-?\d[0-9.e+-]*(?=f\b)", t)] for t in (HEADER.read_text(), made))
    if len(found) != len(expected) or max(abs(a - b) for a, b in zip(found, expected)) > 2e-6:
        sys.exit("make_sheen_table: kernels/bsdf/tables/sheen_table.h is not what this makes; run it without --check")


if __name__ == "__main__":
    main()
