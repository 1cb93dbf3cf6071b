#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How much faster two one-core nodes are than one, with submission and merge, and what a task costs beside its rendering:
on the cluster that the tests of the farm start on this machine.

  tools/measure/farm_speed.py EIKON [--rounds N] [--spp N] [--size WxH]

One and two nodes take turns, so that what else the machine does meets both. Needs root and two processors."""
import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path.insert(0, str(ROOT / "tests/farm"))
import cluster as test_cluster  # noqa: E402


def one_run(cluster, folder, options, words):
    """(seconds from the call of submit to the last file, seconds of each task beside its rendering)"""
    image = folder / "room.exr"
    begin = time.monotonic()
    subprocess.run([ROOT / "tools/eikon-farm", "submit", ROOT / "scenes/window_room.gltf", "-o", image, "--size", options.size,
                    "--spp", str(options.spp), "--eikon", options.eikon, "--folder", folder / "farm", *words],
                   env=cluster.environment, check=True, stdout=subprocess.DEVNULL)
    submitted = time.monotonic() - begin
    test_cluster.wait_until(lambda: image.exists() or not cluster.run("squeue", "-h"), 900, "the image")
    test_cluster.wait_until(lambda: not cluster.run("squeue", "-h"), 60, "an empty queue")
    seconds = time.monotonic() - begin
    overheads = []
    for file in (folder / "farm/tasks").glob("*.ledger"):
        done = [entry for entry in map(json.loads, file.read_text().splitlines()) if entry["state"] == "done"]
        overheads.append(task_seconds(folder / "farm/logs" / f"{file.stem}.log") - sum(entry["render_seconds"] for entry in done))
    return seconds, submitted, overheads


def task_seconds(log):
    """From the first to the last line of a task's log: "== 1795590958.123 ..."."""
    times = [float(line.split()[2]) for line in log.read_text().splitlines() if line.startswith("== at ")]
    return times[-1] - times[0] if len(times) > 1 else float("nan")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("eikon")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--size", default="1280x720")
    options = parser.parse_args()
    options.eikon = pathlib.Path(options.eikon).resolve()
    ratios = []
    with test_cluster.Cluster() as cluster, tempfile.TemporaryDirectory() as space:
        cluster.environment["EIKON_NODE_CACHE"] = f"{space}/kernels"
        for number in range(-1, options.rounds):  # the first round compiles, and does not count
            took = {}
            for nodes, words in ((1, ["--exclude", "n2"]), (2, [])):
                folder = pathlib.Path(space) / f"{number}-{nodes}"
                folder.mkdir()
                took[nodes], submitted, overheads = one_run(cluster, folder, options, words)
                print(f"{nodes} nodes: {took[nodes]:.2f} s, {submitted:.2f} s of them until submit returned; a task beside its "
                      f"rendering: {statistics.median(overheads):.2f} s", flush=True)
            if number >= 0:
                ratios.append(took[1] / took[2])
                print(f"two nodes are {ratios[-1]:.2f} times as fast", flush=True)
    print(f"median of {len(ratios)}: {statistics.median(ratios):.2f} times")


if __name__ == "__main__":
    main()
