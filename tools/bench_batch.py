#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What a batch saves: small renders as one batch, as processes with an empty kernel cache, and as processes with a warm one.

  tools/bench_batch.py build-release/eikon [--jobs 20] [--rounds 3]

Each round runs, in turn, the batch, the processes with the warm cache, and (once) the cold ones, so that what else the machine
does meets all. Printed: wall seconds of each, the seconds that single processes spent rendering alone (from --stats), and the
two ratios. Empty caches are folders of their own (POCL_CACHE_DIR); other drivers keep theirs, and are then not cold.
"""
import argparse
import json
import os
import shlex
import subprocess
import tempfile
import time
from pathlib import Path

SCENES = Path(__file__).resolve().parent.parent / "scenes"


def jobs(count, folder):
    """`count` small renders: three scenes, and seeds, sizes, sample counts and flags that vary."""
    made = []
    for i in range(count):
        name = ["cornell", "cornell_spheres", "window_room"][i % 3]
        flags = ["--size", "128x128" if i % 4 else "160x96", "--spp", "16", "--seed", str(i)]
        if i % 10 == 9:
            flags += ["--aov", "albedo,normal"]
        made.append([str(SCENES / f"{name}.gltf"), "-o", str(folder / f"{i}.exr"), *flags])
    return made


def timed(command, **environment):
    begin = time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env={**os.environ, **environment})
    return time.perf_counter() - begin


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("eikon", type=Path)
    parser.add_argument("--jobs", type=int, default=20)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--cold-jobs", type=int, help="of the processes with an empty cache, only so many; the rest is estimated")
    arguments = parser.parse_args()
    eikon = str(arguments.eikon.resolve())
    with tempfile.TemporaryDirectory() as work:
        folder = Path(work)
        lines = jobs(arguments.jobs, folder)
        file = folder / "jobs.txt"
        file.write_text("".join("render " + shlex.join(line) + "\n" for line in lines))
        stats = folder / "stats.json"

        def processes():
            wall = pure = 0.0
            for line in lines:
                wall += timed([eikon, "render", *line, "--quiet", "--stats", str(stats)])
                pure += json.loads(stats.read_text())["seconds"]["render"]
            return wall, pure

        timed([eikon, "batch", str(file), "--quiet"])  # compiles
        batch, warm, pure = [], [], []
        for _ in range(arguments.rounds):
            wall, rendering = processes()
            warm.append(wall)
            pure.append(rendering)
            batch.append(timed([eikon, "batch", str(file), "--force", "--quiet"]))
        few = lines[: arguments.cold_jobs or len(lines)]
        cold = 0.0
        for i, line in enumerate(few):
            cold += timed([eikon, "render", *line, "--quiet"], POCL_CACHE_DIR=str(folder / f"cache{i}"))
        cold *= len(lines) / len(few)
        cache = folder / "cache"
        cold_batch = timed([eikon, "batch", str(file), "--force", "--quiet"], POCL_CACHE_DIR=str(cache))

    best = {"batch": min(batch), "warm": min(warm), "pure": min(pure)}
    print(f"{'a batch':<42}{best['batch']:8.2f} s   of {', '.join(f'{t:.2f}' for t in batch)}")
    print(f"{'a batch, empty kernel cache':<42}{cold_batch:8.2f} s")
    print(f"{'processes':<42}{best['warm']:8.2f} s   of {', '.join(f'{t:.2f}' for t in warm)}")
    print(f"{'processes, each with an empty kernel cache':<42}{cold:8.2f} s   ({len(few)} measured)")
    print(f"{'rendering alone, in the processes':<42}{best['pure']:8.2f} s   of {', '.join(f'{t:.2f}' for t in pure)}")
    print(f"the batch has {cold / best['batch']:.1f} times the rate of processes with empty caches "
          f"({cold / cold_batch:.1f} with an empty one itself), {best['warm'] / best['batch']:.1f} times that of warm ones, "
          f"and takes {100 * (best['batch'] / best['pure'] - 1):+.1f} % over rendering alone")


if __name__ == "__main__":
    main()
