# SPDX-License-Identifier: Apache-2.0
"""Directional albedo of the GGX reflection lobe (height-correlated Smith, Schlick), by numerical integration: the table
that mitsuba_gltf.py couples its diffuse base with. Needs numpy. Knows nothing of eikon's own fits.

A lobe with Fresnel f0 + (f90 - f0) (1 - cos)^5 has the albedo f0 A + f90 B.
"""

import numpy as np

STEPS = 64  # of cos = x^2 and of alpha = y^2, x and y even in [0, 1]


def visible_normals(wo, alpha, u, v):
    """Half vectors in the frame n = +z, distributed as the normals that `wo` sees [Dupuy and Benyoub 2023]; arrays."""
    stretched = np.stack([alpha * wo[0], alpha * wo[1], wo[2]])
    stretched /= np.linalg.norm(stretched, axis=0)
    z = (1 - u) * (1 + stretched[2]) - stretched[2]
    s, phi = np.sqrt(np.clip(1 - z * z, 0, 1)), 2 * np.pi * v
    h = np.stack([s * np.cos(phi), s * np.sin(phi), z]) + stretched
    h = np.stack([alpha * h[0], alpha * h[1], np.maximum(h[2], 1e-9)])
    return h / np.linalg.norm(h, axis=0)


def _lambda(cos, alpha):
    return (np.sqrt(1 + alpha ** 2 * (1 - cos ** 2) / cos ** 2) - 1) / 2


def albedo(cos, alpha, side=160):
    """(A, B) of arrays `cos` in (0, 1] and `alpha`, from midpoints of the visible normals' square (half of it, by
    symmetry), dense towards u = 1, where a sharp lobe has its few oblique normals."""
    near, v = ((np.arange(n) + 0.5) / n for n in (side, 16))
    u, v = (g.ravel()[:, None] for g in np.meshgrid(1 - near ** 3, v / 2))
    share = 3 * (1 - u) ** (2 / 3)
    shape = np.broadcast(cos, alpha).shape
    cos, alpha = (np.broadcast_to(x, shape).ravel()[None, :] for x in (cos, alpha))
    ones = np.ones_like(u * cos)
    h = visible_normals(np.stack([np.sqrt(1 - cos ** 2) * ones, 0 * ones, cos * ones]), alpha * ones, u * ones, v * ones)
    dot = np.sqrt(1 - cos ** 2) * h[0] + cos * h[2]
    wi_z = 2 * dot * h[2] - cos
    seen = wi_z > 0
    lambda_o = _lambda(cos, alpha)
    weight = np.where(seen, (1 + lambda_o) / (1 + lambda_o + _lambda(np.where(seen, wi_z, 1.0), alpha)), 0.0)
    schlick = np.clip(1 - dot, 0, 1) ** 5
    weight *= share
    return tuple((weight * f).mean(axis=0).reshape(shape) for f in (1 - schlick, schlick))


def tables():
    """(directional, mean): (STEPS + 1, STEPS + 1, 2) of A, B over [alpha step, cos step], and (STEPS + 1, 2) of their
    means over the cosine-weighted hemisphere."""
    steps = np.arange(STEPS + 1) / STEPS
    cos = np.maximum(steps ** 2, 1e-6)
    directional = np.empty((STEPS + 1, STEPS + 1, 2))
    # A mirror: Schlick's term itself.
    directional[0, :, 1] = (1 - cos) ** 5
    directional[0, :, 0] = 1 - directional[0, :, 1]
    for row in range(1, STEPS + 1):
        directional[row] = np.stack(albedo(cos, steps[row] ** 2), axis=-1)
    nodes, weights = np.polynomial.legendre.leggauss(24)
    mu = (nodes + 1) / 2
    mean = np.empty((STEPS + 1, 2))
    mean[0] = 1 - 1 / 21, 1 / 21  # 2 integral of (1 - mu)^5 mu = 1 / 21
    for row in range(1, STEPS + 1):
        a, b = albedo(mu, steps[row] ** 2)
        mean[row] = [(f * mu * weights).sum() for f in (a, b)]
    return directional, mean
