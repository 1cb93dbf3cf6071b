#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Writes a hall with 1,000 small lights: lamps of 20 triangles hang between balls on pillars, in 20 colours and over one
decade of power, so that what is near a point matters more than what is strong. Everything is exactly Lambert and flat.
The same bytes for the same arguments. Standard library only.

  tools/make_many_lights.py out/many_lights.glb
"""

import argparse
import math
import pathlib
import random

from scene_builders.gltf_writer import GltfWriter
from scene_builders.scene_shapes import box, inside_out, look_at, sphere

SIDE, HEIGHT = 18.0, 4.0  # of the hall, metres
BALLS = 9                 # along each side
COLORS = 20
BALL_RADIUS = 0.55
GAP = 0.25  # between the middle of a lamp and what it lights, at least


def hue(turn):
    """A light colour of that hue (0 to 1), the largest channel 1."""
    return [round(max(0.25, min(1.0, 0.25 + 0.75 * (abs(((turn + shift) % 1.0) * 6 - 3) - 1))), 6)
            for shift in (0.0, 2 / 3, 1 / 3)]


def make(lights):
    """The scene with that many lamps, and its number of triangles."""
    stream = random.Random(5)  # only random() is drawn: its stream is the same in every version
    gltf = GltfWriter("Many lights: a thousand lamps of which a few matter at each point.")
    plaster = gltf.lambert("plaster", (0.7, 0.68, 0.65))
    stone = gltf.lambert("stone", (0.45, 0.43, 0.4))
    clay = [gltf.lambert(f"clay {n}", color) for n, color in
            enumerate(((0.6, 0.25, 0.15), (0.2, 0.35, 0.6), (0.65, 0.6, 0.5), (0.25, 0.5, 0.2)))]
    hall = inside_out(box((0, 0, 0), (SIDE, HEIGHT, SIDE)))
    gltf.mesh("hall", [gltf.primitive(*hall, plaster)])
    total = len(hall[1])

    pitch = SIDE / BALLS
    pillar, ball = box((-0.3, -0.05, -0.3), (0.3, 0.7, 0.3)), sphere(BALL_RADIUS, 3)
    pillar_mesh = gltf.mesh_alone("pillar", [gltf.primitive(*pillar, stone)])
    ball_meshes = [gltf.mesh_alone(f"ball {n}", [gltf.primitive(*ball, material)]) for n, material in enumerate(clay)]
    centres = []
    for i in range(BALLS):
        for j in range(BALLS):
            x, z = (i + 0.5) * pitch, (j + 0.5) * pitch
            centres.append((x, 0.7 + BALL_RADIUS, z))
            gltf.place_mesh("pillar", pillar_mesh, translation=[x, 0.0, z])
            gltf.place_mesh("ball", ball_meshes[(i + 2 * j) % len(clay)], translation=list(centres[-1]))
            total += len(pillar[1]) + len(ball[1])

    # A lamp of radius r and radiance L has the power 4 pi^2 r^2 L: both vary, each by half a
    # decade.
    lamp = sphere(1.0, 0)
    lamp_meshes = []
    for n in range(COLORS):
        radiance = 40.0 * 10 ** (n % 5 / 8)
        material = gltf.lambert(f"lamp {n}", (0.0, 0.0, 0.0), [round(radiance * c, 6) for c in hue(n / COLORS)])
        lamp_meshes.append(gltf.mesh_alone(f"lamp {n}", [gltf.primitive(*lamp, material)]))
    hung = 0
    while hung < lights:
        x, y, z = (GAP + stream.random() * (size - 2 * GAP) for size in (SIDE, HEIGHT, SIDE))
        radius = 0.02 * 10 ** (stream.random() / 4)
        if any(math.dist((x, y, z), centre) < BALL_RADIUS + GAP for centre in centres):
            continue
        if y < 0.7 + GAP and max(abs(x % pitch - pitch / 2), abs(z % pitch - pitch / 2)) < 0.3 + GAP:
            continue  # inside a pillar, or near
        gltf.place_mesh(f"lamp {hung}", lamp_meshes[hung % COLORS], translation=[round(v, 6) for v in (x, y, z)],
                        scale=[round(radius, 6)] * 3)
        total += len(lamp[1])
        hung += 1
    gltf.camera(0.9, 1.5, matrix=look_at((0.6, 2.9, 0.8), (9.0, 1.0, 9.5)))
    return gltf, total


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--lights", type=int, default=1000, help="lamps (default 1000)")
    parser.add_argument("output", type=pathlib.Path, metavar="OUT.glb", help="or OUT.gltf")
    arguments = parser.parse_args()
    if not 1 <= arguments.lights <= 1000000:
        parser.error("--lights must lie between 1 and 1000000")
    gltf, total = make(arguments.lights)
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    gltf.write(arguments.output)
    print(f"{arguments.output}: {total} triangles, {arguments.lights} lights,"
          f" {arguments.output.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
