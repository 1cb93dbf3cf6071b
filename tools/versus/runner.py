# SPDX-License-Identifier: Apache-2.0
"""Holds what the scripts that render with another renderer have in common: their options, and what they write. Needs numpy."""

import json
import os
import pathlib
import sys

import numpy as np

from process_time import process_seconds


def parse_size(text):
    width, height = text.lower().split("x")
    return int(width), int(height)


def add_options(parser):
    parser.add_argument("scene", type=pathlib.Path, help=".gltf or .glb")
    parser.add_argument("-o", "--output", metavar="OUT.npy|OUT.exr", help="(height, width, 3) array, or picture")
    parser.add_argument("--size", type=parse_size, default=(360, 360), metavar="WxH")
    parser.add_argument("--spp", type=int, default=64, help="samples per pixel (default 64)")
    parser.add_argument("--max-depth", type=int, default=16, help="path edges from the camera (default 16)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--threads", type=int, default=0, help="0: all")
    parser.add_argument("--warm", action="store_true",
                        help="render twice, the second time with another seed: its seconds are without compiling and building")
    parser.add_argument("--stats", metavar="OUT.json", help="write seconds and seconds_from_start there")


def write_image(path, mean, variance=None):
    """(h, w, 3) arrays, to .npy (the mean alone) or .exr: R, G, B and the variance of each pixel's mean."""
    path = pathlib.Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.suffix == ".npy":
        np.save(path, mean.astype(np.float32))
        return
    import OpenEXR  # not every renderer bears it in its process
    planes = {name: mean[:, :, index] for index, name in enumerate("RGB")}
    if variance is not None:
        planes |= {f"variance.{name}": variance[:, :, index] for index, name in enumerate("RGB")}
    planes = {name: np.ascontiguousarray(plane, np.float32) for name, plane in planes.items()}
    OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, planes).write(str(path))


def run(arguments, render):
    """render(seed) -> (image, variance or None, seconds). From the process's start to the first image counts as
    seconds_from_start; with --warm the second render's seconds as those of rendering alone. Prints and writes what was
    asked for, of images the first."""
    image, variance, seconds = render(arguments.seed)
    from_start = process_seconds()
    if arguments.warm:
        seconds = render(arguments.seed + 10000)[2]
    samples = arguments.size[0] * arguments.size[1] * arguments.spp
    means = " ".join(f"{v:.6g}" for v in image.mean((0, 1)))
    print(f"{seconds:.3f} s, {samples / seconds / 1e6:.3f} M samples/s, {from_start:.2f} s from start, mean {means}")
    if arguments.output:
        write_image(arguments.output, image, variance)
    if arguments.stats:
        pathlib.Path(arguments.stats).write_text(json.dumps({"seconds": seconds, "seconds_from_start": from_start,
                                                            "mean": [float(v) for v in image.mean((0, 1))]}))


def leave():
    """Ends the process at once, for renderers whose libraries crash while Python takes itself apart."""
    sys.stdout.flush()
    os._exit(0)
