#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Writes a figure that walks for two seconds, of any number of triangles, as scenes/walking_figure.gltf shows it. The same
bytes for the same arguments.

  tools/make_figure.py --triangles 50000 out/figure.glb
"""

import argparse
import pathlib

from scene_builders.scenes_figure import figure


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--triangles", type=int, default=50000, help="of the figure, about (default 50000)")
    parser.add_argument("output", type=pathlib.Path, metavar="OUT.glb", help="or OUT.gltf")
    arguments = parser.parse_args()
    if arguments.triangles < 400:
        parser.error("--triangles must be at least 400")
    gltf, count = figure(arguments.triangles, "Speed of sequences: a figure that walks.")
    arguments.output.parent.mkdir(parents=True, exist_ok=True)
    gltf.write(arguments.output)
    print(f"{arguments.output}: {count} triangles, {arguments.output.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    main()
