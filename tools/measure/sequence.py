#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Measures what the frames of a sequence take besides rendering: a figure of 50,000 triangles that walks.

The frames are rendered with N samples and with 3 N. Half of the difference in processor time is what N samples cost; the rest of
a frame is reading, posing, packing, trees, the pilot, prediction and files. Other work on the machine changes processor time little.

  tools/measure/sequence.py --eikon build-release/eikon --frames 100
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile

TOOLS = pathlib.Path(__file__).resolve().parents[1]
sys.path.append(str(TOOLS))
from common import child_process  # noqa: E402
from common.flags import add_eikon_flag  # noqa: E402


def run(eikon, scene, folder, frames, spp, flags):
    """Returns what rendering a sequence took, as a child_process.Finished."""
    for old in folder.glob("f_*"):
        old.unlink()
    return child_process.run_or_exit(eikon, "render", scene, "-o", folder / "f_%04d.exr", "--frames", f"0:{frames - 1}",
                                     "--size", "320x240", "--spp", spp, "--quiet", *flags)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_eikon_flag(parser)
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
            start_s = run(arguments.eikon, scene, folder, 1, arguments.spp, flags).processor_s
            few = run(arguments.eikon, scene, folder, arguments.frames, arguments.spp, flags)
            many = run(arguments.eikon, scene, folder, arguments.frames, 3 * arguments.spp, flags)
            samples_s = (many.processor_s - few.processor_s) / 2
            frame_s = (few.processor_s - start_s) / max(arguments.frames - 1, 1)
            print(f"{title}: {few.processor_s:.2f} s of processor time ({few.wall_s:.2f} s), of which samples {samples_s:.2f} s; "
                  f"outside of them {1 - samples_s / few.processor_s:.2f}; a frame {1000 * frame_s:.1f} ms; "
                  f"peak {few.peak_mib:.0f} MB")


if __name__ == "__main__":
    main()
