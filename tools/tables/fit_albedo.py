#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Fits the directional albedo of the GGX lobe and prints the constants of kernels/bsdf/ggx_albedo.h. Needs python3-numpy.

  tools/tables/fit_albedo.py            the constants, and the errors of the fit (about two minutes)
  tools/tables/fit_albedo.py --check    whether the constants in the header keep the bounds that the header states (seconds)

With c the cosine of the viewer, alpha = r^2, l = sqrt(alpha^2 (1 - c^2) + c^2), q = c / l, p = sqrt(1 - q^2):
  full     albedo where every microfacet reflects all light, 1 - loss; loss is q times a rational function of p, q, alpha
  grazing  albedo where a microfacet at angle x reflects (1 - cos x)^5; full (1 - x)^5, where x (the effective cosine) is c plus
           (l - c) times a rational function of q, c, r
Near grazing incidence the lobe depends on c / alpha however small alpha is, which polynomials of c and alpha cannot follow;
q can. Both are raised by constants, so that they are never less than the truth.
"""
import argparse
import pathlib
import re
import sys

import numpy as np

HEADER = pathlib.Path(__file__).resolve().parents[2] / "kernels/bsdf/ggx_albedo.h"
SMOOTH_ALPHA = 2.0 ** -13  # EK_SMOOTH_ALPHA: smoother ones are mirrors


def albedo(c, alpha, points_v=160, points_phi=64):
    """(full, grazing) by quadrature over the visible normals [Dupuy and Benyoub 2023]."""
    s = np.sqrt(max(0.0, 1 - c * c))
    x, z = alpha * s, c
    length = np.hypot(x, z)
    x, z = x / length, z / length
    phi = (np.arange(points_phi) + 0.5) / points_phi * np.pi
    node, weight = np.polynomial.legendre.leggauss(points_v)
    t = (node + 1) / 2
    rest = ((1 - t) ** 3)[:, None]  # 1 - v: graded towards 0, where the slopes are steep
    weight = (weight / 2 * 3 * (1 - t) ** 2)[:, None] / points_phi
    ring = np.sqrt(np.maximum(0, (1 - rest) * (1 + z) * ((1 - z) + rest * (1 + z))))
    hx, hy, hz = (ring * np.cos(phi) + x) * alpha, ring * np.sin(phi) * alpha, rest * (1 + z) + 0 * phi
    norm = np.sqrt(hx * hx + hy * hy + hz * hz)
    hx, hy, hz = hx / norm, hy / norm, hz / norm
    cos_h = s * hx + c * hz
    ix, iy, iz = 2 * cos_h * hx - s, 2 * cos_h * hy, 2 * cos_h * hz - c
    length_o, length_i = np.hypot(alpha * s, c), np.sqrt(alpha ** 2 * (ix * ix + iy * iy) + iz * iz)
    g = np.where(iz > 0, iz * (c + length_o) / (c * length_i + iz * length_o), 0) * weight
    return g.sum(), (g * np.clip(1 - cos_h, 0, 1) ** 5).sum()


def table(roughnesses, steps):
    """Rows r, c, full, grazing; c dense near 0 on the scale of alpha, and over [0, 1]."""
    rows = []
    for r in roughnesses:
        a = r * r
        q = np.linspace(1e-4, 1, steps)
        cosines = a * q / np.sqrt(1 - q * q * (1 - a * a))
        for c in np.unique(np.concatenate([np.minimum(cosines, 1), np.linspace(0.01, 1, steps + 5), [1e-5]])):
            rows.append((r, c, *albedo(c, a)))
    return np.array(rows).T


def loss_basis(r, c):
    a = r * r
    length = np.sqrt(a * a * (1 - c * c) + c * c)
    q = c / length
    p = np.sqrt(np.maximum(0, 1 - q * q))
    top = [p * q, p * q * a, p * p * q, p * p * q * a, q * a ** 2, q * a ** 3, q * q * a ** 2, q * q * a ** 3]
    bottom = [a, q, q * a, q * q, q * q * a]
    return np.array(top).T, np.array(bottom).T


COSINE_TOP = [(i, 0, j) for i in range(2) for j in range(3)] + [(0, 1, 0), (0, 1, 1), (0, 2, 0), (0, 1, 2)]  # powers of q, c, r
COSINE_BOTTOM = [(0, 1), (0, 2), (1, 0), (1, 1), (1, 2)]  # powers of q, r


def cosine_basis(r, c):
    a = r * r
    length = np.sqrt(a * a * (1 - c * c) + c * c)
    q = c / length
    top = [(length - c) * q ** i * c ** k * r ** j for i, k, j in COSINE_TOP]
    bottom = [q ** i * r ** j for i, j in COSINE_BOTTOM]
    return np.array(top).T, np.array(bottom).T


def rational(basis, constants):
    top, bottom = basis
    n = top.shape[1]
    return (top @ constants[:n]) / (1 + bottom @ constants[n:])


def fit_rational(basis, y, weight, starts=3, steps=400):
    """Least squares by Levenberg and Marquardt, reweighted towards the least greatest error [Lawson 1961]."""
    top, bottom = basis
    n = top.shape[1]
    random = np.random.default_rng(0)
    best = (np.inf, None)
    for start in range(starts):
        k = np.zeros(n + bottom.shape[1])
        k[n:] = random.random(bottom.shape[1]) * start * 0.7
        under = 1 + bottom @ k[n:]
        k[:n] = np.linalg.lstsq(top / under[:, None], y, rcond=1e-10)[0]
        damping, w, f = 1e-3, weight.copy(), rational(basis, k)
        for step in range(steps):
            error = np.abs(f - y) * weight
            if error.max() < best[0] and under.min() > 0.05:
                best = (error.max(), k.copy())
            if step % 5 == 4:
                w = w * (error / error.max() + 0.02) ** 0.15
                w /= w.max()
            jacobian = np.hstack([top / under[:, None], -(f / under)[:, None] * bottom]) * w[:, None]
            gradient, normal = jacobian.T @ ((f - y) * w), jacobian.T @ jacobian
            for _ in range(8):
                trial = k - np.linalg.solve(normal + damping * np.diag(np.diag(normal) + 1e-12), gradient)
                under_trial = 1 + bottom @ trial[n:]
                f_trial = rational(basis, trial)
                if under_trial.min() > 0.05 and (((f_trial - y) * w) ** 2).sum() < (((f - y) * w) ** 2).sum():
                    k, f, under = trial, f_trial, under_trial
                    damping = max(damping * 0.3, 1e-9)
                    break
                damping = min(damping * 4, 1e3)
    return best[1]


class Fit:
    """full and grazing as the kernel computes them, but for rounding."""

    def __init__(self, loss, cosine, lift_full=0.0, lift_grazing=0.0):
        self.loss, self.cosine, self.lift_full, self.lift_grazing = loss, cosine, lift_full, lift_grazing

    def __call__(self, r, c):
        full = 1 - rational(loss_basis(r, c), self.loss)
        x = c + rational(cosine_basis(r, c), self.cosine)
        grazing = full * np.maximum(1 - x, 0) ** 5
        return np.minimum(full + self.lift_full, 1), np.minimum(grazing + self.lift_grazing, 1)

    def means(self, roughnesses):
        """2 times the integral over c of full c and of grazing c."""
        node, weight = np.polynomial.legendre.leggauss(200)
        t = (node + 1) / 2
        c, w = t ** 3, weight / 2 * 3 * t ** 2
        return np.array([[(2 * w * c * a).sum() for a in self(np.full_like(c, r), c)] for r in roughnesses]).T


def check(fit, mean_loss, mean_grazing, roughnesses, steps):
    r, c, full, grazing = table(roughnesses, steps)
    f, g = fit(r, c)
    means = fit.means(roughnesses)
    power = np.array([roughnesses ** i for i in range(len(mean_loss))])
    return {
        "full, least": (f - full).min(), "full, most": (f - full).max(),
        "grazing, least": (g - grazing).min(), "grazing, most": (g - grazing).max(),
        "mean of full, least": (means[0] - (1 - mean_loss @ power)).min(),
        "mean of full, most": (means[0] - (1 - mean_loss @ power)).max(),
        "mean of grazing, least": (means[1] - mean_grazing @ power).min(),
        "mean of grazing, most": (means[1] - mean_grazing @ power).max(),
        # What the coupled base of a dielectric of index 1.5 loses at most.
        "reflectance .04, most": (0.04 * (f - full) + 0.96 * (g - grazing)).max(),
    }


def read_header():
    found = dict(re.findall(r"#define EK_ALBEDO_(\w+) (-?[0-9.e+-]+)f", HEADER.read_text()))

    def group(name):
        return np.array([float(found[k]) for k in sorted((k for k in found if re.fullmatch(name + r"_\d+", k)),
                                                         key=lambda k: int(k.rsplit("_", 1)[1]))])
    fit = Fit(group("LOSS"), group("COSINE"), float(found["LIFT_FULL"]), float(found["LIFT_GRAZING"]))
    return fit, group("MEAN_LOSS"), group("MEAN_GRAZING")


def print_errors(errors, file):
    for name, error in errors.items():
        print(f"{name:24} {error:+.2e}", file=file)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="check the header instead of fitting anew")
    arguments = parser.parse_args()
    r_least = SMOOTH_ALPHA ** 0.5

    if arguments.check:
        errors = check(*read_header(), np.concatenate([[r_least, 0.017, 0.029], np.linspace(0.04, 1, 29)]), 23)
        print_errors(errors, sys.stdout)
        kept = all(error > -5e-5 for error in errors.values()) and errors["reflectance .04, most"] < BOUND
        sys.exit(0 if kept else "fit_albedo: kernels/bsdf/ggx_albedo.h does not keep its bounds; run without --check and copy")

    roughnesses = np.concatenate([[r_least, 0.02, 0.035], np.linspace(0.05, 1, 39)])
    r, c, full, grazing = table(roughnesses, 25)
    # Where grazing reflection is weak, so is the weight of full in all but metals, which have no
    # base.
    loss = fit_rational(loss_basis(r, c), 1 - full, np.maximum(grazing / full, 0.15)).astype(np.float32).astype(float)
    fitted = np.maximum(1 - rational(loss_basis(r, c), loss), 0.05)
    x = 1 - (grazing / fitted) ** 0.2
    # The slope of grazing over x, with a floor: it is not linear where it vanishes.
    weight = np.maximum(5 * np.maximum(1 - x, 0) ** 4 * fitted, 0.01)
    cosine = fit_rational(cosine_basis(r, c), x - c, weight).astype(np.float32).astype(float)
    fit = Fit(loss, cosine)
    f, g = fit(r, c)
    fit.lift_full = float(np.ceil((full - f).max() * 2e4) + 2) / 2e4
    fit.lift_grazing = float(np.ceil((grazing - g).max() * 2e4) + 2) / 2e4

    dense = np.linspace(r_least, 1, 200)
    means = fit.means(dense)
    power = np.array([dense ** i for i in range(7)])
    mean_loss = np.linalg.lstsq(power.T, 1 - means[0], rcond=None)[0]
    mean_loss[0] += (1 - means[0] - mean_loss @ power).max() + 1e-6
    mean_grazing = np.linalg.lstsq(power.T, means[1], rcond=None)[0]
    mean_grazing[0] -= (mean_grazing @ power - means[1]).max() + 1e-6

    for name, values in (("LOSS", loss), ("COSINE", cosine), ("MEAN_LOSS", mean_loss), ("MEAN_GRAZING", mean_grazing)):
        for i, value in enumerate(values):
            print(f"#define EK_ALBEDO_{name}_{i} {value:.9g}f")
    print(f"#define EK_ALBEDO_LIFT_FULL {fit.lift_full:.9g}f")
    print(f"#define EK_ALBEDO_LIFT_GRAZING {fit.lift_grazing:.9g}f")
    print_errors(check(fit, mean_loss, mean_grazing, roughnesses, 25), sys.stderr)


BOUND = 5e-3  # of E for a reflectance of .04, as kernels/bsdf/ggx_albedo.h states

if __name__ == "__main__":
    main()
