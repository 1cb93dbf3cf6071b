#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Merging an image of very many parts as the farm does it: seconds and memory of each level of the tree.

  tools/measure/farm_merges.py EIKON [--parts N] [--size WxH]

The parts are real ones of one sample each, and the scripts are those that the nodes run, one after the other here."""
import argparse
import os
import pathlib
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]


def run(*words, **more):
    """(seconds of the clock, of the processor, megabytes at most) of a command."""
    begin = time.monotonic()
    with tempfile.TemporaryFile("w+") as said:
        child = subprocess.Popen([str(word) for word in words], stdout=subprocess.DEVNULL, stderr=said, **more)
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode != 0:
            said.seek(0)
            sys.exit(f"{words[0]} ended with {child.returncode}: {said.read()}")
    return time.monotonic() - begin, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("eikon")
    parser.add_argument("--parts", type=int, default=10000)
    parser.add_argument("--size", default="16x16")
    options = parser.parse_args()
    eikon, parts = pathlib.Path(options.eikon).resolve(), options.parts
    with tempfile.TemporaryDirectory() as space:
        environment = dict(os.environ, EIKON_NODE_CACHE=f"{space}/kernels")
        whole = ["--size", options.size, "--spp", parts]
        took = run(ROOT / "tools/eikon-farm", "openjd", ROOT / "scenes/cornell.gltf", "-o", "image.exr", *whole, "--parts", parts,
                   "--lines", 1000, "--eikon", eikon, "--folder", f"{space}/farm", cwd=space)
        print(f"writing the scripts: {took[0]:.1f} s", flush=True)
        farm = pathlib.Path(space) / "farm"
        tasks = sorted((farm / "tasks").glob("*.merges"))
        for file in tasks:  # so that no task merges
            file.write_text("")
        took = [run("bash", farm / "openjd-task.sh", number, cwd=space, env=environment) for number in range(len(tasks))]
        print(f"rendering {parts} parts: {sum(one[0] for one in took):.1f} s", flush=True)
        for level, file in enumerate(sorted((farm / "merges").glob("r0-*.txt"))):
            merges = file.read_text().split()
            took = [run("bash", farm / "openjd-merge.sh", level, number, cwd=space, env=environment) for number in range(len(merges))]
            wall, cpu, memory = sum(one[0] for one in took), sum(one[1] for one in took), max(one[2] for one in took)
            print(f"level {level + 1}: {len(merges)} merges, {wall:.2f} s of the clock, {cpu:.2f} of the processor; "
                  f"{1000 * cpu / parts:.2f} ms for each part of the image, {memory:.0f} MB at most", flush=True)
        run(eikon, "render", ROOT / "scenes/cornell.gltf", "-o", "reference.exr", *whole, "--quiet", cwd=space)
        said = subprocess.run([eikon, "compare", "image.exr", "reference.exr"], cwd=space, capture_output=True, text=True, check=False)
        print("the same bits as a render in one go" if "MSE 0.000000e+00" in said.stdout else "OTHER BITS: " + said.stdout + said.stderr)
        return 0 if "MSE 0.000000e+00" in said.stdout else 1


if __name__ == "__main__":
    sys.exit(main())
