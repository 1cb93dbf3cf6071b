#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tables of how much light GGX microfacets lose to each other: writes kernels/bsdf/tables/energy_table.h.

  tools/tables/make_energy_table.py            integrate, write the header, print how far off it is (needs numpy; three minutes)
  tools/tables/make_energy_table.py --check    whether the header is as close to the integrals at other places

Single scattering leaves out light that meets a second microfacet. What is lost of a direction, 1 minus the albedo, is what
--energy-compensation gives back (kernels/bsdf/multiple_scattering.h). Of microfacets that reflect everything it depends on alpha and
the cosine; of a clear dielectric, which reflects and refracts, on the index of refraction too, and on the side. Rows and columns
are square roots of alpha and of the cosine, layers the square root of the reflectance at normal incidence between indices of 1.1 and
2.6, all evenly spaced and interpolated linearly. The mean of every row over all directions is that of its own interpolation, so
that what is given back is what the table says is lost."""

import argparse
import pathlib
import re
import sys

import numpy as np

from c_numbers import lines_of

HEADER = pathlib.Path(__file__).resolve().parents[2] / "kernels/bsdf/tables/energy_table.h"
ROWS, COLUMNS = 32, 32
GLASS_LAYERS, GLASS_ROWS, GLASS_COLUMNS = 10, 14, 18
LEAST_INDEX, GREATEST_INDEX = 1.1, 2.6
STEPS = 192
_u = (np.arange(STEPS) + 0.5) / STEPS
TURN, HEIGHT = np.meshgrid(np.pi * _u, _u)  # half of the turn: the lobe is symmetric
COS, SIN = np.cos(TURN), np.sin(TURN)


def reflectance(cosine, eta):
    """Fresnel's, unpolarised; eta: index of the far side over that of this one."""
    sine2 = (1 - cosine * cosine) / (eta * eta)
    beyond = np.sqrt(np.maximum(1 - sine2, 0))
    s, p = (cosine - eta * beyond) / (cosine + eta * beyond), (eta * cosine - beyond) / (eta * cosine + beyond)
    return np.where(sine2 >= 1, 1, 0.5 * (s * s + p * p))


def albedo(alpha, cosine, eta=None):
    """By the midpoint rule over visible normals [Dupuy and Benyoub 2023], weighted by G2 / G1; without eta all is reflected."""
    cosine, alpha = max(cosine, 1e-6), max(alpha, 1e-7)
    o = np.array([np.sqrt(1 - cosine * cosine), 0, cosine])
    w = np.array([alpha, alpha, 1]) * o
    length_o = np.linalg.norm(w)
    w = w / length_o
    z = (1 - HEIGHT) * (1 + w[2]) - w[2]
    r = np.sqrt(np.maximum(1 - z * z, 0))
    h = np.array([alpha * (r * COS + w[0]), alpha * (r * SIN + w[1]), np.maximum(z + w[2], 1e-12)])
    h /= np.linalg.norm(h, axis=0)
    along = np.minimum(np.tensordot(o, h, 1), 1)
    up = 2 * along * h - o[:, None, None]
    length_i = np.sqrt(alpha * alpha * (up[0] ** 2 + up[1] ** 2) + up[2] ** 2)
    c = np.maximum(up[2], 0)
    reflected = c * (cosine + length_o) / (cosine * length_i + c * length_o)
    if eta is None:
        return reflected.mean()
    f = reflectance(np.maximum(along, 0), eta)
    beyond = np.sqrt(np.maximum(1 - (1 - along**2) / eta**2, 0))
    down = (along / eta - beyond) * h - o[:, None, None] / eta
    c = np.maximum(-down[2], 0)
    length_i = np.sqrt(alpha * alpha * (down[0] ** 2 + down[1] ** 2) + c**2)
    refracted = 2 * c / np.maximum(c + length_i, 1e-30)
    return (f * reflected + (1 - f) * refracted).mean()


def root_f0(index):
    return (index - 1) / (index + 1)


def index_at(x, inside):
    """x: [0, 1], among the layers."""
    root = root_f0(LEAST_INDEX) + x * (root_f0(GREATEST_INDEX) - root_f0(LEAST_INDEX))
    index = (1 + root) / (1 - root)
    return 1 / index if inside else index


def lost(alpha, cosine, eta=None):
    return max(round(1 - albedo(alpha, cosine, eta), 6), 0)


def squares(count):
    return (np.arange(count) / (count - 1)) ** 2


def mean(table):
    """2 times the integral of lost(c) c over c of tables that are linear in x = sqrt(c): 4 x^3 lost(x) over x, exactly."""
    n = table.shape[-1] - 1
    a = np.arange(n) / n
    b = a + 1 / n
    # lost = l0 + (l1 - l0) (x - a) n over [a, b].
    cubes, fourths = b**4 - a**4, 0.8 * (b**5 - a**5)
    second = n * (fourths - a * cubes)
    return (table[..., :-1] * (cubes - second) + table[..., 1:] * second).sum(axis=-1)


def make():
    mirror = np.array([[lost(a, c) for c in squares(COLUMNS)] for a in squares(ROWS)])
    glass = np.array([[[[lost(a, c, index_at(k / (GLASS_LAYERS - 1), inside)) for c in squares(GLASS_COLUMNS)]
                        for a in squares(GLASS_ROWS)] for k in range(GLASS_LAYERS)] for inside in (False, True)])
    return mirror, glass


def interpolate(values, *places):
    for x in places:  # in [0, 1]
        at = x * (values.shape[0] - 1)
        low = min(int(at), values.shape[0] - 2)
        values = values[low] + (at - low) * (values[low + 1] - values[low])
    return values


def check(mirror, glass):
    """returns whether the tables are close, but at directions that graze surfaces that are hardly rough"""
    random = np.random.default_rng(1)
    kept = True
    for name, places, error_of in (
            ("all is reflected", 2, lambda r, m: interpolate(mirror, r, m) - lost(r * r, m * m)),
            ("glass from outside", 3, lambda x, r, m: interpolate(glass[0], x, r, m) - lost(r * r, m * m, index_at(x, False))),
            ("glass from inside", 3, lambda x, r, m: interpolate(glass[1], x, r, m) - lost(r * r, m * m, index_at(x, True)))):
        at = random.random((1500, places))
        error = np.array([error_of(*place) for place in at])
        wide = (at[:, -1] ** 2 > 0.03) | (at[:, -2] > 0.3)
        print(f"{name}: off by {np.abs(error).max():.4f} at most, {np.abs(error[wide]).max():.4f} where the cosine is above .03 "
              f"or the roughness above .3, {np.abs(error).mean():.5f} in the mean")
        kept = kept and np.abs(error[wide]).max() < (0.004 if places == 2 else 0.02)
    return kept


def numbers(array, form=".6f"):
    return lines_of(f"{x:{form}}f" for x in array.ravel())


def text(mirror, glass):
    return f"""// SPDX-License-Identifier: Apache-2.0
// Written by tools/tables/make_energy_table.py, which says what it is.
#ifndef EK_ENERGY_TABLE_H
#define EK_ENERGY_TABLE_H

#define EK_ENERGY_ROWS {ROWS}u
#define EK_ENERGY_COLUMNS {COLUMNS}u
#define EK_ENERGY_GLASS_LAYERS {GLASS_LAYERS}u
#define EK_ENERGY_GLASS_ROWS {GLASS_ROWS}u
#define EK_ENERGY_GLASS_COLUMNS {GLASS_COLUMNS}u
#define EK_ENERGY_GLASS_FIRST {root_f0(LEAST_INDEX):.9g}f  // square root of the reflectance at normal incidence of the first layer
#define EK_ENERGY_GLASS_LAST {root_f0(GREATEST_INDEX):.9g}f

// What microfacets that reflect everything lose, by alpha and the cosine; and each row's mean.
constant float energy_lost_table[EK_ENERGY_ROWS * EK_ENERGY_COLUMNS] = {{
{numbers(mirror)}
}};
constant float energy_lost_mean_table[EK_ENERGY_ROWS] = {{
{numbers(mean(mirror), '.6e')}
}};

// What a dielectric loses from outside and inside, by index, alpha and the cosine; rows' means.
constant float energy_glass_table[2u * EK_ENERGY_GLASS_LAYERS * EK_ENERGY_GLASS_ROWS * EK_ENERGY_GLASS_COLUMNS] = {{
{numbers(glass)}
}};
constant float energy_glass_mean_table[2u * EK_ENERGY_GLASS_LAYERS * EK_ENERGY_GLASS_ROWS] = {{
{numbers(mean(glass), '.6e')}
}};

#endif
"""


def read():
    parts = re.findall(r"\{\n(.*?)\n\};", HEADER.read_text(), re.S)
    found = [np.array([float(x) for x in re.findall(r"[0-9.e+-]+(?=f\b)", part)]) for part in parts]
    return found[0].reshape(ROWS, COLUMNS), found[2].reshape(2, GLASS_LAYERS, GLASS_ROWS, GLASS_COLUMNS)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="check the header instead of writing it")
    if not parser.parse_args().check:
        HEADER.write_text(text(*make()))
    if not check(*read()):
        sys.exit("make_energy_table: kernels/bsdf/tables/energy_table.h is not as close as it should be")


if __name__ == "__main__":
    main()
