#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Writes a cloud of spheres, or the same cloud with two triangles in the place of each, a square of the same area across a random
axis, or a box of six such squares, or two triangles across the sphere's own box from edge to opposite edge: what a sphere or a box costs
beside the triangles that it replaces. A square is half as wide as a sphere when seen from anywhere, and flat, so that its box is met by
fewer rays; triangles across the box have its very box, and nine tenths of the sphere's width on average. The same bytes for the same arguments. Standard library only.

  tools/make_balls.py spheres out/balls.glb
  tools/make_balls.py squares out/squares.glb --count 10000
"""

import argparse
import math
import pathlib
import random

from scene_builders.gltf_writer import GltfWriter
from scene_builders.scene_shapes import look_at


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("spheres", "boxes", "squares", "diagonals"))
    parser.add_argument("out", type=pathlib.Path, metavar="FILE.glb")
    parser.add_argument("--count", type=int, default=10000, help="of them (default: 10000)")
    arguments = parser.parse_args()
    gltf = GltfWriter("What a sphere or a box costs beside two triangles.")
    gltf.environment((1.0, 1.0, 1.0))
    grey = gltf.lambert("grey", (0.6, 0.6, 0.6))
    dice = random.Random(1)
    points, triangles = [], []
    for number in range(arguments.count):
        centre = [dice.uniform(-1, 1) for _ in range(3)]
        radius = 0.6 * arguments.count ** (-1 / 3) * dice.uniform(0.5, 1.5)
        axis, half = dice.randrange(3), radius * math.sqrt(math.pi) / 2
        if arguments.what == "spheres":
            gltf.shape(f"ball {number}", "sphere", grey, {"radius": radius}, translation=centre)
            continue
        if arguments.what == "boxes":
            gltf.shape(f"box {number}", "box", grey, {"size": [2 * half] * 3}, translation=centre)
            continue
        first = len(points)
        for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            corner = list(centre)
            if arguments.what == "diagonals":
                corner[axis] += a * radius
                corner[(axis + 1) % 3] += b * radius
                corner[(axis + 2) % 3] += b * radius
            else:
                corner[(axis + 1) % 3] += a * half
                corner[(axis + 2) % 3] += b * half
            points.append(tuple(corner))
        triangles += [(first, first + 1, first + 2), (first, first + 2, first + 3)]
    if triangles:
        gltf.mesh("squares", [gltf.primitive(points, triangles, grey)])
    gltf.camera(0.7, 1.0, matrix=look_at((1.0, 1.5, 3.5), (0.0, 0.0, 0.0)))
    arguments.out.parent.mkdir(parents=True, exist_ok=True)
    gltf.write(arguments.out)


if __name__ == "__main__":
    main()
