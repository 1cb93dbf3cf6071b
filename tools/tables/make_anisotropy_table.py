#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Tables of how much light anisotropic GGX microfacets reflect in all: writes kernels/bsdf/tables/anisotropy_table.h.

  tools/tables/make_anisotropy_table.py            integrate, write the header, print what the bounds leave (needs numpy; two minutes)
  tools/tables/make_anisotropy_table.py --check    whether the bounds hold at other places than those that they were made from

Two albedos, as in kernels/bsdf/ggx_albedo.h: of microfacets that reflect everything, and of those that reflect (1 - cos)^5. They depend
on both alphas and on both angles of the direction. Seen from it the slopes of the microfacets have standard deviations in proportion to
  p = sqrt((alpha_x cos)^2 + (alpha_y sin)^2) along it and q = sqrt((alpha_x sin)^2 + (alpha_y cos)^2) across it,
and a correlation rho, 1 - rho^2 = (alpha_x alpha_y / (p q))^2. The table is that of rho = 0, by p, q and the angle with the normal; what
correlation adds (it takes nothing) is bounded by `lift`. So the albedo is never less than the truth, and a base below that
receives what the layer leaves never makes light. The mean over all directions, by both alphas, is never more than that of the bound.
Rows and columns are square roots of alphas and of the cosine, evenly spaced and interpolated linearly."""

import argparse
import pathlib
import sys

import numpy as np

from c_numbers import lines_of

HEADER = pathlib.Path(__file__).resolve().parents[2] / "kernels/bsdf/tables/anisotropy_table.h"
ROWS, COLUMNS = 11, 20
STEPS = 128
_u = (np.arange(STEPS) + 0.5) / STEPS
TURN, HEIGHT = np.meshgrid(2 * np.pi * _u, _u)
COS, SIN = np.cos(TURN), np.sin(TURN)


def albedos(alpha_x, alpha_y, cosine, turn=0.0):
    """(full, grazing) by the midpoint rule over visible normals [Dupuy and Benyoub 2023], weighted by G2 / G1."""
    cosine = max(cosine, 1e-6)
    sine = np.sqrt(1 - cosine * cosine)
    o = np.array([sine * np.cos(turn), sine * np.sin(turn), cosine])
    w = np.array([alpha_x, alpha_y, 1]) * o
    length_o = np.linalg.norm(w)
    w = w / length_o
    z = (1 - HEIGHT) * (1 + w[2]) - w[2]
    r = np.sqrt(np.maximum(1 - z * z, 0))
    h = np.array([alpha_x * (r * COS + w[0]), alpha_y * (r * SIN + w[1]), np.maximum(z + w[2], 1e-12)])
    h /= np.linalg.norm(h, axis=0)
    along = np.tensordot(o, h, 1)
    i = 2 * along * h - o[:, None, None]
    length_i = np.sqrt((alpha_x * i[0]) ** 2 + (alpha_y * i[1]) ** 2 + i[2] ** 2)
    c = np.maximum(i[2], 0)
    weight = c * (cosine + length_o) / (cosine * length_i + c * length_o)
    return weight.mean(), (weight * np.maximum(1 - along, 0) ** 5).mean()


def table():
    a = (np.arange(ROWS) / (ROWS - 1)) ** 2
    c = (np.arange(COLUMNS) / (COLUMNS - 1)) ** 2
    return np.array([[[albedos(p, q, k) for k in c] for q in a] for p in a])


def place(x, count):
    at = np.clip(x * (count - 1), 0, count - 1)
    low = np.minimum(np.asarray(at).astype(int), count - 2)
    return low, at - low


def interpolate(values, *places):
    """Multilinear; values[..., 2]."""
    if not places:
        return values
    (low, weight), rest = places[0], places[1:]
    weight = np.asarray(weight)[..., None]
    if values.ndim == len(places) + 1 and np.ndim(low) == 0:
        return interpolate((1 - weight) * values[low] + weight * values[low + 1], *rest)
    total = 0
    for corner in range(2 ** len(places)):
        index, factor = [], 1.0
        for k, (lo, w) in enumerate(places):
            up = corner >> k & 1
            index.append(lo + up)
            factor = factor * (w if up else 1 - w)
        total = total + values[tuple(index)] * np.asarray(factor)[..., None]
    return total


def seen(alpha_x, alpha_y, turn):
    """p, q, rho^2."""
    p = np.hypot(alpha_x * np.cos(turn), alpha_y * np.sin(turn))
    q = np.hypot(alpha_x * np.sin(turn), alpha_y * np.cos(turn))
    return p, q, np.maximum(1 - (alpha_x * alpha_y / (p * q)) ** 2, 0)


def without_lift(values, p, q, cosine):
    return interpolate(values, place(np.sqrt(p), ROWS), place(np.sqrt(q), ROWS), place(np.sqrt(cosine), COLUMNS))


def shapes_of_lift(rho2, cosine):
    """Returns the factors of the three lifts, for the full and the grazing albedo; the second covers interpolation, which is
    worst where the albedo of sharp lobes drops, the third correlation."""
    grazing = 1 - cosine
    g2 = grazing * grazing
    return np.stack([np.ones_like(rho2 * cosine), g2 * g2 * g2 * g2 * np.ones_like(rho2), rho2 * grazing]), \
        np.stack([np.ones_like(rho2 * cosine), g2 * g2 * g2 * g2 * np.ones_like(rho2), rho2 * rho2 * g2])


def bound(values, lift, alpha_x, alpha_y, cosine, turn):
    p, q, rho2 = seen(alpha_x, alpha_y, turn)
    raised = np.stack([np.tensordot(lift[:, k], shape, 1) for k, shape in enumerate(shapes_of_lift(rho2, cosine))], axis=-1)
    return np.minimum(without_lift(values, p, q, cosine) + raised, 1)


def mean_of_bound(values, lift, alpha_x, alpha_y):
    x = (np.arange(64) + 0.5) / 64
    cosine, turn = np.meshgrid(np.sqrt(x), x * np.pi / 2)
    return bound(values, lift, alpha_x, alpha_y, cosine, turn).mean(axis=(0, 1))


def places(count, seed):
    """Random (alpha_x, alpha_y, cosine, turn), alpha_x > alpha_y; grazing directions and sharp lobes as often as others."""
    random = np.random.default_rng(seed)
    big = random.random(count) ** 2
    ratio = random.random(count) ** 2
    return np.maximum(big, 2.0 ** -12), np.maximum(big * ratio, 2.0 ** -13), random.random(count) ** 2, \
        random.random(count) * np.pi / 2


def make():
    values = table()
    x, y, c, t = places(6000, 1)
    exact = np.array([albedos(*k) for k in zip(x, y, c, t)])
    p, q, rho2 = seen(x, y, t)
    missing = exact - without_lift(values, p, q, c)
    lift = np.zeros((3, 2))
    evenly = 1 / (np.sqrt(c) + 0.05)  # cosines and not their square roots
    for k, shape in enumerate(shapes_of_lift(rho2, c)):  # those that cover all and lift least in the mean
        options = []
        for second in np.linspace(0, 0.1, 41):
            for third in np.linspace(0, 0.2, 41):
                first = max(np.max(missing[:, k] - second * shape[1] - third * shape[2]), 0)
                options.append((np.sum(evenly * (first + second * shape[1] + third * shape[2])), first, second, third))
        lift[:, k] = min(options)[1:]
    lift = np.ceil(lift * 1.05 * 1e4) / 1e4 + np.array([[5e-4], [0], [0]])
    a = (np.arange(ROWS) / (ROWS - 1)) ** 2
    mean = np.array([[mean_of_bound(values, lift, max(p, 2.0 ** -13), max(q, 2.0 ** -13)) for q in a] for p in a])
    x, y, _, _ = places(600, 2)
    above = np.max([interpolate(mean, place(np.sqrt(s), ROWS), place(np.sqrt(t), ROWS)) -
                    mean_of_bound(values, lift, s, t) for s, t in zip(x, y)], axis=0)
    mean = np.maximum(mean - 1.05 * np.maximum(above, 0) - 1e-4, 0)
    return values, lift, mean


def check(values, lift, mean):
    x, y, c, t = places(4000, 3)
    exact = np.array([albedos(*k) for k in zip(x, y, c, t)])
    left = bound(values, lift, x, y, c, t) - exact
    x, y, _, _ = places(400, 4)
    below = np.array([mean_of_bound(values, lift, s, t) -
                      interpolate(mean, place(np.sqrt(s), ROWS), place(np.sqrt(t), ROWS)) for s, t in zip(x, y)])
    print(f"above the albedo by {left.min(axis=0)} to {left.max(axis=0)}, in the mean {left.mean(axis=0)} (full, grazing)")
    print(f"the mean is below that of the bound by {below.min(axis=0)} to {below.max(axis=0)}")
    return left.min() >= 0 and below.min() >= 0


def numbers(array):
    return lines_of(f"{x:.5f}f" for x in array.ravel())


def text(values, lift, mean):
    return f"""// SPDX-License-Identifier: Apache-2.0
// Written by tools/tables/make_anisotropy_table.py, which says what it is.
#ifndef EK_ANISOTROPY_TABLE_H
#define EK_ANISOTROPY_TABLE_H

#define EK_ANISOTROPY_ROWS {ROWS}u
#define EK_ANISOTROPY_COLUMNS {COLUMNS}u
#define EK_ANISOTROPY_LIFT_FULL {lift[0][0]:.6g}f
#define EK_ANISOTROPY_LIFT_GRAZING {lift[0][1]:.6g}f
#define EK_ANISOTROPY_SHARP_FULL {lift[1][0]:.6g}f  // times (1 - cosine)^8
#define EK_ANISOTROPY_SHARP_GRAZING {lift[1][1]:.6g}f
#define EK_ANISOTROPY_SKEW_FULL {lift[2][0]:.6g}f  // times rho^2 (1 - cosine)
#define EK_ANISOTROPY_SKEW_GRAZING {lift[2][1]:.6g}f  // times rho^4 (1 - cosine)^2

// By p, q and the cosine: both albedos.
constant float anisotropy_albedo_table[2u * EK_ANISOTROPY_ROWS * EK_ANISOTROPY_ROWS * EK_ANISOTROPY_COLUMNS] = {{
{numbers(values)}
}};

// By both alphas: their means.
constant float anisotropy_mean_table[2u * EK_ANISOTROPY_ROWS * EK_ANISOTROPY_ROWS] = {{
{numbers(mean)}
}};

#endif
"""


def main():
    import re
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="check the header instead of writing it")
    if not parser.parse_args().check:
        made = make()
        HEADER.write_text(text(*made))
        check(*made)
        return
    found = [float(x) for x in re.findall(r"-?\d[0-9.e+-]*(?=f\b)", HEADER.read_text())]
    size = 2 * ROWS * ROWS * COLUMNS
    kept = check(np.reshape(found[6:6 + size], (ROWS, ROWS, COLUMNS, 2)), np.reshape(found[:6], (3, 2)),
                 np.reshape(found[6 + size:], (ROWS, ROWS, 2)))
    sys.exit(0 if kept else "make_anisotropy_table: kernels/bsdf/tables/anisotropy_table.h does not keep its bounds; run without --check")


if __name__ == "__main__":
    main()
