#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures what a batch saves: small renders as one batch, as processes with an empty kernel cache, and with a warm one.

  tools/measure/batch.py [--eikon FILE] [--jobs 20] [--side 128] [--spp 16] [--rounds 2] [--cold-jobs 6]

Each round runs the batch and the processes with the warm cache in turn, so that what else the machine does meets both; the
processes with empty caches run once. Rendering alone is, of each job, from its first unit of work to its last: as the
processes of the same round took for it, which is what a batch is held against, and the least that any run took for it, in
which nothing disturbed it, a bound that no whole run of twenty jobs can meet. Empty caches are folders of their own
(POCL_CACHE_DIR); other drivers keep theirs, and are then not cold. Printed: wall seconds of each, and the two ratios that count.
"""
import argparse
import json
import os
import pathlib
import shlex
import statistics
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tools"))
from common.child_process import run_or_exit  # noqa: E402
from common.flags import add_eikon_flag, at_least  # noqa: E402


def jobs(count, folder, side, spp):
    """`count` small renders: three scenes, and seeds, sizes, sample counts and flags that vary."""
    made = []
    for i in range(count):
        name = ["cornell", "cornell_spheres", "window_room"][i % 3]
        size = f"{side}x{side}" if i % 4 else f"{side * 5 // 4}x{side * 3 // 4}"
        flags = ["--size", size, "--spp", str(spp), "--seed", str(i)]
        if i % 10 == 9:
            flags += ["--aov", "albedo,normal"]
        made.append([str(ROOT / f"scenes/{name}.gltf"), "-o", str(folder / f"{i}.exr"), *flags])
    return made


def timed(command, **environment):
    """Returns the seconds of the clock that a command takes with more environment variables."""
    return run_or_exit(*command, env={**os.environ, **environment}).wall_s


def report(batches, warm, cold, cold_batch, pure, cold_count):
    """Prints the seconds of each way, and the ratios that count.

    batches, warm: (seconds of the clock, of rendering) of each round; cold: seconds of all processes with empty caches, reckoned
    from `cold_count` of them; cold_batch: of a batch with an empty cache; pure: the least seconds of rendering of each job."""
    best, least = min(wall for wall, _ in batches), sum(pure)
    warmest = min(wall for wall, _ in warm)
    over = statistics.median(wall / rendering - 1 for (wall, _), (_, rendering) in zip(batches, warm))
    print(f"{'a batch':<42}{best:8.2f} s   of {', '.join(f'{wall:.2f}' for wall, _ in batches)}")
    print(f"{'a batch, empty kernel cache':<42}{cold_batch:8.2f} s")
    print(f"{'processes':<42}{warmest:8.2f} s   of {', '.join(f'{wall:.2f}' for wall, _ in warm)}")
    print(f"{'processes, each with an empty kernel cache':<42}{cold:8.2f} s   ({cold_count} measured)")
    print(f"{'rendering alone':<42}{least:8.2f} s   at the least; processes {', '.join(f'{t:.2f}' for _, t in warm)}, "
          f"within the batches {', '.join(f'{t:.2f}' for _, t in batches)}")
    print(f"the batch takes {100 * over:+.1f} % over what the processes of its round rendered for (median; "
          f"{100 * (best / least - 1):+.1f} % the best over the least), and has {cold / best:.1f} times the rate of processes "
          f"with empty caches ({cold / cold_batch:.1f} with an empty one itself), {warmest / best:.1f} times that of warm ones")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_eikon_flag(parser)
    parser.add_argument("--jobs", type=int, default=20)
    parser.add_argument("--side", type=int, default=128, help="of the images, in pixels")
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--rounds", type=int, default=2)
    parser.add_argument("--cold-jobs", type=at_least(1), default=6, help="of the processes with an empty cache, only so many; the rest is reckoned")
    arguments = parser.parse_args()
    eikon = arguments.eikon
    with tempfile.TemporaryDirectory() as work:
        folder = pathlib.Path(work)
        lines = jobs(arguments.jobs, folder, arguments.side, arguments.spp)
        file = folder / "jobs.txt"
        file.write_text("".join("render " + shlex.join(line) + "\n" for line in lines))
        stats = folder / "stats.json"

        pure = [float("inf")] * len(lines)  # seconds of rendering alone

        def processes():
            wall, rendering = 0.0, 0.0
            for i, line in enumerate(lines):
                wall += timed([eikon, "render", *line, "--quiet", "--stats", str(stats)])
                seconds = json.loads(stats.read_text())["seconds"]["render"]
                rendering += seconds
                pure[i] = min(pure[i], seconds)
            return wall, rendering

        def batch(**environment):
            ledger = folder / "jobs.txt.ledger"
            ledger.unlink(missing_ok=True)
            wall = timed([eikon, "batch", str(file), "--quiet"], **environment)
            done = [entry for entry in map(json.loads, ledger.read_text().splitlines()) if entry["state"] == "done"]
            assert len(done) == len(lines)
            for entry in done:
                pure[entry["line"] - 1] = min(pure[entry["line"] - 1], entry["render_seconds"])
            return wall, sum(entry["render_seconds"] for entry in done)

        batch()  # compiles
        batches, warm = [], []
        for _ in range(arguments.rounds):
            warm.append(processes())
            batches.append(batch())
        few = lines[: arguments.cold_jobs]
        cold = 0.0
        for i, line in enumerate(few):
            cold += timed([eikon, "render", *line, "--quiet"], POCL_CACHE_DIR=str(folder / f"cache{i}"))
        cold *= len(lines) / len(few)
        cold_batch = batch(POCL_CACHE_DIR=str(folder / "cache"))[0]

    report(batches, warm, cold, cold_batch, pure, len(few))


if __name__ == "__main__":
    main()
