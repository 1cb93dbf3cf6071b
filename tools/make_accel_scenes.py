#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Writes scenes in which acceleration structures differ in speed: `stadium`, a teapot of small triangles on the lawn of a stadium
of large ones, most of whose cells a grid leaves to one; and `grass`, a field of blades spread evenly, for which a grid is made; and
`meadow`, one tuft of grass at many places (EXT_mesh_gpu_instancing), which is stored once. The same bytes for the same
arguments. Needs numpy (Debian: python3-numpy).

  tools/make_accel_scenes.py stadium out/stadium.glb
  tools/make_accel_scenes.py grass out/grass.glb --triangles 200000
  tools/make_accel_scenes.py meadow out/meadow.glb --triangles 192 --places 100000
"""

import argparse
import math
import pathlib

import numpy as np

from scene_builders.gltf_writer import GltfWriter


def sheet(points, closed):
    """Triangles of a grid of points (rows, columns, 3); closed: the last column meets the first. (positions, normals, indices)"""
    rows, columns = points.shape[:2]
    last = columns if closed else columns - 1
    r, c = np.meshgrid(np.arange(rows - 1), np.arange(last), indexing="ij")
    a, b = r * columns + c, r * columns + (c + 1) % columns
    indices = np.stack([a, b, a + columns, b, b + columns, a + columns], axis=-1).reshape(-1, 3)
    along = np.gradient(points, axis=0)
    across = (np.roll(points, -1, 1) - np.roll(points, 1, 1)) if closed else np.gradient(points, axis=1)
    normals = np.cross(across, along).reshape(-1, 3)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.where(length > 1e-12, normals / np.maximum(length, 1e-12), [0.0, 1.0, 0.0])
    return points.reshape(-1, 3), normals, indices


def lathe(profile, columns):
    """A surface of revolution about y: profile (n, 2) of radius and height."""
    phi = np.arange(columns) * (2 * math.pi / columns)
    r, y = profile[:, :1], profile[:, 1:]
    return sheet(np.stack([r * np.cos(phi), np.broadcast_to(y, (len(profile), columns)), r * np.sin(phi)], axis=-1), True)


def tube(path, radii, columns):
    """A tube around a path in the plane z = 0: path (n, 2), radii (n,)."""
    tangent = np.gradient(path, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    side = np.stack([-tangent[:, 1], tangent[:, 0], np.zeros(len(path))], axis=1)
    phi = np.arange(columns) * (2 * math.pi / columns)
    ring = side[:, None, :] * np.cos(phi)[None, :, None] + np.array([0.0, 0.0, 1.0]) * np.sin(phi)[None, :, None]
    middle = np.concatenate([path, np.zeros((len(path), 1))], axis=1)
    return sheet(middle[:, None, :] + radii[:, None, None] * ring, True)


def curve(points, count):
    """A smooth curve through control points (Catmull-Rom), (count, dimensions)."""
    p = np.array([points[0], *points, points[-1]], dtype=float)
    at = np.linspace(0, len(points) - 1, count)
    i = np.minimum(at.astype(int), len(points) - 2)
    t = (at - i)[:, None]
    a, b, c, d = p[i], p[i + 1], p[i + 2], p[i + 3]
    return 0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - a - 3 * c + d) * t**3)


def teapot(detail):
    """Some 48 detail^2 triangles, 0.3 m wide, standing at the origin: body, lid, spout, handle."""
    body = curve([(0.0, 0.0), (0.075, 0.002), (0.1, 0.05), (0.085, 0.1), (0.07, 0.11), (0.066, 0.108)], 6 * detail)
    lid = curve([(0.066, 0.11), (0.04, 0.122), (0.012, 0.126), (0.012, 0.134), (0.014, 0.14), (0.0, 0.146)], 4 * detail)
    spout = curve([(0.08, 0.04), (0.115, 0.05), (0.13, 0.08), (0.16, 0.105)], 2 * detail)
    handle = curve([(-0.08, 0.095), (-0.13, 0.1), (-0.14, 0.065), (-0.085, 0.03)], 2 * detail)
    return [lathe(body, 2 * detail), lathe(lid, 2 * detail), tube(spout, np.linspace(0.02, 0.009, len(spout)), detail),
            tube(handle, np.full(len(handle), 0.007), detail)]


def bowl(steps, columns):
    """Rows of seats around an oval, 200 m by 150 m."""
    profile = [(60.0 + 0.8 * (i // 2 + i % 2), 1.0 + 0.5 * (i // 2)) for i in range(2 * steps)]
    positions, normals, indices = lathe(np.array(profile), columns)
    return positions * [1.0, 1.0, 0.75], normals, indices


def blades(count, seed):
    """Blades of three triangles, 0.3 m high and spread over 10 m x 10 m, with jitter; no two alike."""
    random = np.random.Generator(np.random.PCG64(seed)).random((count, 6))  # 53-bit uniforms alone: a stable stream
    side = math.ceil(math.sqrt(count))
    i = np.arange(count)
    x, z = ((i % side + random[:, 0]) / side - 0.5) * 10, ((i // side + random[:, 1]) / side - 0.5) * 10
    turn, lean, height = 2 * math.pi * random[:, 2], 0.15 * random[:, 3], 0.2 + 0.2 * random[:, 4]
    across = np.stack([np.cos(turn), np.zeros(count), np.sin(turn)], axis=1)
    ahead = np.stack([-np.sin(turn), np.zeros(count), np.cos(turn)], axis=1)
    foot = np.stack([x, np.zeros(count), z], axis=1)
    up = np.stack([np.zeros(count), height, np.zeros(count)], axis=1)
    half = (0.003 + 0.003 * random[:, 5:6]) * across
    middle, tip = foot + 0.6 * up + 0.4 * lean[:, None] * ahead, foot + up + lean[:, None] * ahead
    positions = np.stack([foot - half, foot + half, middle - 0.7 * half, middle + 0.7 * half, tip], axis=1)
    normals = np.repeat(ahead[:, None, :], 5, axis=1)
    indices = 5 * i[:, None, None] + np.array([[0, 1, 2], [1, 3, 2], [2, 3, 4]])
    return positions.reshape(-1, 3), normals.reshape(-1, 3), indices.reshape(-1, 3)


def add(gltf, name, color, parts):
    total = 0
    for positions, normals, indices in parts:
        positions = positions.astype("<f4")
        bounds = positions.min(axis=0).tolist(), positions.max(axis=0).tolist()
        gltf.mesh(name, [gltf.primitive_arrays(positions.tobytes(), normals.astype("<f4").tobytes(),
                                               indices.astype("<u4").tobytes(), bounds, gltf.lambert(name, color))])
        total += len(indices)
    return total


def lawn(gltf, half):
    up = gltf.lambert("ground", (0.12, 0.3, 0.08))
    gltf.mesh("ground", [gltf.primitive([(-half, 0, -half), (-half, 0, half), (half, 0, half), (half, 0, -half)],
                                        [(0, 1, 2), (0, 2, 3)], up)])
    return 2


def make_stadium(triangles):
    gltf = GltfWriter("A teapot in a stadium: nearly all triangles are in one cell of a grid.")
    gltf.environment((0.7, 0.85, 1.0))
    total = lawn(gltf, 110.0) + add(gltf, "seats", (0.6, 0.6, 0.65), [bowl(30, 120)])
    total += add(gltf, "teapot", (0.8, 0.75, 0.7), teapot(max(4, math.ceil(math.sqrt(triangles / 48)))))
    gltf.camera(0.7, 16 / 9, translation=[0.0, 0.12, 0.5])
    return gltf, total


def make_grass(triangles):
    gltf = GltfWriter("A field of grass: triangles of one size, spread evenly, for which a grid is made.")
    gltf.environment((0.7, 0.85, 1.0))
    total = lawn(gltf, 5.0) + add(gltf, "grass", (0.15, 0.5, 0.08), [blades(triangles // 3, 1)])
    down = math.sin(-0.2), math.cos(-0.2)
    gltf.camera(0.8, 16 / 9, translation=[0.0, 1.6, 4.5], rotation=[round(down[0], 9), 0.0, 0.0, round(down[1], 9)])
    return gltf, total


def make_meadow(triangles, places):
    gltf = GltfWriter("A meadow of one tuft of grass at many places: stored once, it takes a hundredth of the memory.")
    gltf.environment((0.7, 0.85, 1.0))
    side = 0.25 * math.sqrt(places)
    total = lawn(gltf, 0.5 * side)
    positions, normals, indices = blades(triangles // 3, 1)
    positions = (positions * [0.03, 1.0, 0.03]).astype("<f4")  # a tuft 0.3 m wide
    bounds = positions.min(axis=0).tolist(), positions.max(axis=0).tolist()
    tuft = gltf.mesh_alone("tuft", [gltf.primitive_arrays(positions.tobytes(), normals.astype("<f4").tobytes(),
                                                          indices.astype("<u4").tobytes(), bounds,
                                                          gltf.lambert("grass", (0.15, 0.5, 0.08)))])
    random = np.random.Generator(np.random.PCG64(2)).random((places, 4))
    rows, i = math.ceil(math.sqrt(places)), np.arange(places)
    zero = np.zeros(places)
    x, z = ((i % rows + random[:, 0]) / rows - 0.5) * side, ((i // rows + random[:, 1]) / rows - 0.5) * side
    half, size = math.pi * random[:, 2], 0.6 + 0.8 * random[:, 3]
    columns = [x, zero, z], [zero, np.sin(half), zero, np.cos(half)], [size, size, size]
    gltf.instances("tufts", tuft, *(np.stack(c, axis=1).astype("<f4").tobytes() for c in columns))
    tilt = -0.15
    gltf.camera(0.8, 16 / 9, translation=[0.0, 1.6, 0.45 * side],
                rotation=[round(math.sin(tilt / 2), 9), 0.0, 0.0, round(math.cos(tilt / 2), 9)])
    return gltf, total + len(indices) * places


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", choices=["stadium", "grass", "meadow"])
    parser.add_argument("output", type=pathlib.Path, metavar="OUT.glb", help="or OUT.gltf")
    parser.add_argument("--triangles", type=int, default=60000, help="about so many; of a tuft, in a meadow (default 60000)")
    parser.add_argument("--places", type=int, default=100_000, help="of tufts in a meadow")
    arguments = parser.parse_args()
    least = 3 if arguments.scene == "meadow" else 1000
    if arguments.triangles < least:
        parser.error(f"--triangles must be at least {least}")
    if arguments.scene == "meadow":
        gltf, total = make_meadow(arguments.triangles, arguments.places)
    else:
        gltf, total = {"stadium": make_stadium, "grass": make_grass}[arguments.scene](arguments.triangles)
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    gltf.write(arguments.output)
    print(f"{arguments.output}: {total} triangles, {arguments.output.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
