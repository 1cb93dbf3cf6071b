#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Measures what the frames of a sequence take besides rendering: a figure of 50,000 triangles that walks.

The frames are rendered with N samples and with 3 N. Half of the difference in processor time is what N samples cost; the rest of
a frame is reading, posing, packing, trees, the pilot, prediction and files. Other work on the machine changes processor time little.

  tools/measure/sequence.py --eikon build-release/eikon --frames 100
"""

import argparse
import os
import pathlib
import subprocess
import sys
import tempfile
import time

TOOLS = pathlib.Path(__file__).resolve().parent.parent


def run(eikon, scene, folder, frames, spp, flags):
    """(processor seconds, seconds, peak MB) of a sequence."""
    command = [eikon, "render", str(scene), "-o", str(folder / "f_%04d.exr"), "--frames", f"0:{frames - 1}", 
               "--size", "320x240", "--spp", str(spp), "--quiet", *flags]
    for old in folder.glob("f_*"):
        old.unlink()
    begin = time.monotonic()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        sys.exit(f"sequence.py: {' '.join(command)} ended with status {status}")
    return usage.ru_utime + usage.ru_stime, time.monotonic() - begin, usage.ru_maxrss / 1024


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--eikon", default="build-release/eikon", help="program (default build-release/eikon)")
    parser.add_argument("--frames", type=int, default=100)
    parser.add_argument("--triangles", type=int, default=50000)
    parser.add_argument("--spp", type=int, default=4)
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        scene = folder / "figure.glb"
        subprocess.run([TOOLS / "make_scenes.py", "--figure", str(arguments.triangles), scene], check=True)
        for title, flags in (("with its pilots", []), ("--guiding off", ["--guiding=off"])):
            run(arguments.eikon, scene, folder, 2, arguments.spp, flags)  # compiles
            start, _, _ = run(arguments.eikon, scene, folder, 1, arguments.spp, flags)
            few, seconds, peak = run(arguments.eikon, scene, folder, arguments.frames, arguments.spp, flags)
            many, _, _ = run(arguments.eikon, scene, folder, arguments.frames, 3 * arguments.spp, flags)
            samples = (many - few) / 2
            print(f"{title}: {few:.2f} s of processor time ({seconds:.2f} s), of which samples {samples:.2f} s; outside of them "
                  f"{1 - samples / few:.2f}; a frame {1000 * (few - start) / max(arguments.frames - 1, 1):.1f} ms; peak {peak:.0f} MB")


if __name__ == "__main__":
    main()
