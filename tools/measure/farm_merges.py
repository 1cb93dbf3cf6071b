#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Merging an image of very many parts as the farm does it: seconds and memory of each level of the tree.

  tools/measure/farm_merges.py [--eikon FILE] [--parts N] [--size WxH]

The parts are real ones of one sample each, and the scripts are those that the nodes run, one after the other here."""
import argparse
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tools"))
from common.child_process import run_or_exit  # noqa: E402
from common.flags import add_eikon_flag  # noqa: E402


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_eikon_flag(parser)
    parser.add_argument("--parts", type=int, default=10000)
    parser.add_argument("--size", default="16x16")
    options = parser.parse_args()
    eikon, parts = options.eikon, options.parts
    with tempfile.TemporaryDirectory() as space:
        environment = dict(os.environ, EIKON_NODE_CACHE=f"{space}/kernels")
        whole = ["--size", options.size, "--spp", parts]
        written = run_or_exit(ROOT / "tools/eikon-farm", "openjd", ROOT / "scenes/cornell.gltf", "-o", "image.exr", *whole,
                              "--parts", parts, "--lines", 1000, "--eikon", eikon, "--folder", f"{space}/farm", cwd=space)
        print(f"writing the scripts: {written.wall_s:.1f} s", flush=True)
        farm = pathlib.Path(space) / "farm"
        tasks = sorted((farm / "tasks").glob("*.merges"))
        for file in tasks:  # so that no task merges
            file.write_text("")
        rendered = [run_or_exit("bash", farm / "openjd-task.sh", number, cwd=space, env=environment) for number in range(len(tasks))]
        print(f"rendering {parts} parts: {sum(task.wall_s for task in rendered):.1f} s", flush=True)
        for level, file in enumerate(sorted((farm / "merges").glob("r0-*.txt"))):
            merges = file.read_text().split()
            merged = [run_or_exit("bash", farm / "openjd-merge.sh", level, number, cwd=space, env=environment)
                      for number in range(len(merges))]
            wall_s, processor_s = sum(merge.wall_s for merge in merged), sum(merge.processor_s for merge in merged)
            print(f"level {level + 1}: {len(merges)} merges, {wall_s:.2f} s of the clock, {processor_s:.2f} of the processor; "
                  f"{1000 * processor_s / parts:.2f} ms for each part of the image, "
                  f"{max(merge.peak_mib for merge in merged):.0f} MB at most", flush=True)
        run_or_exit(eikon, "render", ROOT / "scenes/cornell.gltf", "-o", "reference.exr", *whole, "--quiet", cwd=space)
        said = subprocess.run([eikon, "compare", "image.exr", "reference.exr"], cwd=space, capture_output=True, text=True, check=False)
        print("the same bits as a render in one go" if "MSE 0.000000e+00" in said.stdout else "OTHER BITS: " + said.stdout + said.stderr)
        return 0 if "MSE 0.000000e+00" in said.stdout else 1


if __name__ == "__main__":
    sys.exit(main())
