#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Writes a dense mesh: bumpy terrain and three bumpy spheres under a sky, with a lamp. The same bytes for the same
arguments. Needs numpy (Debian: python3-numpy).

  tools/make_dense.py --triangles 1000000 out/dense.glb
"""

import argparse
import math
import pathlib

import numpy as np

from scene_builders.gltf_writer import GltfWriter


def waves(points, seed, octaves, frequency):
    """A sum of `octaves` rounds of six plane waves, each round of twice the frequency and half the height; about +-1.
    points: (n, 3) float64; returns (value (n,), gradient (n, 3))."""
    random = np.random.Generator(np.random.PCG64(seed))
    value, gradient = np.zeros(len(points)), np.zeros_like(points)
    height = 0.5
    for _ in range(octaves):
        for _ in range(6):
            # 53-bit uniforms only: numpy keeps this stream stable between versions.
            u, v, phase = random.random(3)
            z, turn = 2 * u - 1, 2 * math.pi * v
            r = math.sqrt(1 - z * z)
            k = frequency * np.array([r * math.cos(turn), z, r * math.sin(turn)])
            angle = points @ k + 2 * math.pi * phase
            value += height / 3 * np.sin(angle)
            gradient += height / 3 * np.cos(angle)[:, None] * k
        height, frequency = height / 2, frequency * 2
    return value, gradient


def grid_triangles(rows, columns, stride):
    """Two triangles per cell of a grid of points numbered row by row, `stride` points per row."""
    r, c = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    a = (r * stride + c).ravel()
    return np.stack([a, a + stride, a + 1, a + 1, a + stride, a + stride + 1], axis=1).reshape(-1, 3)


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def terrain(side):
    """(positions, normals, triangles) of side x side cells over 20 m x 20 m."""
    line = np.linspace(-10, 10, side + 1)
    z, x = np.meshgrid(line, line, indexing="ij")
    points = np.stack([x.ravel(), np.zeros(x.size), z.ravel()], axis=1)
    height, slope = waves(points, 1, 5, 0.7)
    points[:, 1] = height
    normals = unit(np.stack([-slope[:, 0], np.ones(len(points)), -slope[:, 2]], axis=1))
    return points, normals, grid_triangles(side, side, side + 1)


def bumpy_sphere(rings, centre, radius, seed):
    """(positions, normals, triangles) of rings x 2 rings cells; seam and poles share their points, so it is closed."""
    columns = 2 * rings
    theta = np.linspace(0, math.pi, rings + 1)[1:-1]
    phi = np.arange(columns) * (2 * math.pi / columns)
    t, p = np.meshgrid(theta, phi, indexing="ij")
    body = np.stack([np.sin(t) * np.cos(p), np.cos(t), np.sin(t) * np.sin(p)], axis=-1).reshape(-1, 3)
    directions = np.concatenate([[[0.0, 1.0, 0.0]], body, [[0.0, -1.0, 0.0]]])
    bump, slope = waves(directions, seed, 5, 5.0)
    scale = radius * (1 + 0.12 * bump)
    # Normal of r(d) d: d - grad(r) / r, the gradient taken along the sphere.
    along = slope - (slope * directions).sum(axis=1, keepdims=True) * directions
    normals = unit(directions - 0.12 * along / (1 + 0.12 * bump)[:, None])

    band, last = rings - 1, len(directions) - 1
    j = np.arange(columns)
    k = (j + 1) % columns
    caps = np.concatenate([
        np.stack([np.zeros_like(j), 1 + k, 1 + j], axis=1),
        np.stack([np.full_like(j, last), 1 + (band - 1) * columns + j, 1 + (band - 1) * columns + k], axis=1)])
    i, j = np.meshgrid(np.arange(band - 1), j, indexing="ij")
    a, b = 1 + i * columns + j, 1 + i * columns + (j + 1) % columns
    sides = np.stack([a, b, a + columns, b, b + columns, a + columns], axis=-1).reshape(-1, 3)
    return directions * scale[:, None] + centre, normals, np.concatenate([caps, sides])


def make(triangles):
    """The scene with at least `triangles` triangles, and their number."""
    gltf = GltfWriter("Speed and memory on a dense mesh: bumpy terrain and spheres under a sky.")
    gltf.environment((0.6, 0.8, 1.1))
    share = triangles // 4  # a quarter for each of terrain and three spheres
    side = math.ceil(math.sqrt(share / 2))
    rings = math.ceil(math.sqrt(share / 4)) + 1
    objects = [("terrain", (0.35, 0.3, 0.2), terrain(side))]
    spheres = [((-3.2, 1.7, -1.0), (0.7, 0.2, 0.15)), ((0.3, 1.9, -2.5), (0.75, 0.75, 0.7)),
               ((3.4, 1.5, 0.0), (0.15, 0.3, 0.7))]
    for number, (centre, color) in enumerate(spheres):
        objects.append((f"sphere {number}", color, bumpy_sphere(rings, np.array(centre), 1.5, 2 + number)))
    total = 2
    for name, color, (positions, normals, indices) in objects:
        positions = positions.astype("<f4")
        bounds = positions.min(axis=0).tolist(), positions.max(axis=0).tolist()
        gltf.mesh(name, [gltf.primitive_arrays(positions.tobytes(), normals.astype("<f4").tobytes(),
                                               indices.astype("<u4").tobytes(), bounds, gltf.lambert(name, color))])
        total += len(indices)
    lamp = gltf.lambert("lamp", (0.0, 0.0, 0.0), (30.0, 24.0, 16.0))
    gltf.mesh("lamp", [gltf.primitive([(2, 7, 3), (4, 7, 3), (4, 7, 5), (2, 7, 5)], [(0, 1, 2), (0, 2, 3)], lamp)])
    downwards_0_3_rad = [round(math.sin(-0.15), 9), 0.0, 0.0, round(math.cos(0.15), 9)]
    gltf.camera(0.8, 16 / 9, translation=[0.0, 4.6, 11.0], rotation=downwards_0_3_rad)
    return gltf, total


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--triangles", type=int, default=1000000, help="at least so many (default 1000000)")
    parser.add_argument("output", type=pathlib.Path, metavar="OUT.glb", help="or OUT.gltf")
    arguments = parser.parse_args()
    if arguments.triangles < 100:
        parser.error("--triangles must be at least 100")
    gltf, total = make(arguments.triangles)
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    gltf.write(arguments.output)
    print(f"{arguments.output}: {total} triangles, {arguments.output.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
