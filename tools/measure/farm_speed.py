#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures how much faster two one-core nodes are than one, with submission and merge, and what a task costs beside its rendering:
on a small Slurm cluster that it starts on this machine.

  tools/measure/farm_speed.py [--eikon FILE] [--rounds N] [--spp N] [--size WxH] [flags of submit]

One and two nodes take turns, so that what else the machine does meets both. Every run is told twice: as the clock has it,
and as the seconds of the processor, user's and system's, on the way from the call of submit to the image: of submit, of the
task that took most, and of the merge, with what the clock says of Slurm's own time between them. The second does not grow
with what else the machine does. Needs root and two processors."""
import argparse
import json
import pathlib
import re
import statistics
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.dont_write_bytecode = True
sys.path.append(str(ROOT / "tools"))
from common import slurm_cluster  # noqa: E402
from common.child_process import run_or_exit  # noqa: E402
from common.flags import add_eikon_flag  # noqa: E402

PHASES = ("submit", "slurm", "prepare", "render", "merge")


def stamps(log):
    """Returns {word: (moment, processor seconds until then)} of a task's log."""
    found = {}
    for moment, word, rest in re.findall(r"^== at (\S+) (ready|rendered|merged);.*\n((?:\S+ \S+\n){2})", log, re.MULTILINE):
        found[word] = float(moment), sum(60 * float(m) + float(s) for m, s in re.findall(r"(\d+)m([\d.]+)s", rest))
    moments = re.findall(r"^== at (\S+)", log, re.MULTILINE)
    found["begin"], found["node"] = (float(moments[0]), 0.0), re.search(r" on (\S+), job", log)[1]
    return found


def phases_of(tasks, submitted, image_at):
    """Returns two of {phase: seconds} after submit: by the clock, of the task that was rendered last, and of the processor, of the
    node that had most to do."""
    last = max(tasks, key=lambda task: task["rendered"][0])
    merger = next((task for task in tasks if task.get("merged", (0, 0))[0] >= image_at), last)
    nodes = [[task for task in tasks if task["node"] == node] for node in {task["node"] for task in tasks}]
    busiest = max(nodes, key=lambda own: sum(task["rendered"][1] for task in own))
    begun_at, ready_at = (min(task[word][0] for task in tasks) for word in ("begin", "ready"))
    wall = {"slurm": begun_at - submitted, "prepare": ready_at - begun_at, "render": last["rendered"][0] - ready_at,
            "merge": max(0.0, image_at - last["rendered"][0])}
    cpu = {"slurm": wall["slurm"], "prepare": sum(task["ready"][1] for task in busiest),
           "render": sum(task["rendered"][1] - task["ready"][1] for task in busiest),
           "merge": merger["merged"][1] - merger["rendered"][1] if "merged" in merger else 0.0}
    return wall, cpu


def one_run(cluster, folder, options, words):
    """Renders once; returns ({phase: seconds of the clock}, {phase: seconds of the processor}, [processor seconds of each task
    beside rendering], number of tasks)."""
    image = folder / "room.exr"
    submit = run_or_exit(ROOT / "tools/eikon-farm", "submit", ROOT / "scenes/window_room.gltf", "-o", image, "--size", options.size,
                         "--spp", options.spp, "--eikon", options.eikon, "--folder", folder / "farm", *words, *options.words,
                         env=cluster.environment)
    submitted = time.time()
    slurm_cluster.wait_until(lambda: image.exists() or not cluster.run("squeue", "-h"), 1800, "the image")
    image_at = image.stat().st_mtime
    slurm_cluster.wait_until(lambda: not cluster.run("squeue", "-h"), 60, "an empty queue")
    tasks, beside = [], []
    for file in sorted((folder / "farm/tasks").glob("*.ledger")):
        done = [entry for entry in map(json.loads, file.read_text().splitlines()) if entry["state"] == "done"]
        tasks.append(stamps((folder / "farm/logs" / f"{file.stem}.log").read_text()))
        share = sum(entry["render_seconds"] for entry in done) / max(tasks[-1]["rendered"][0] - tasks[-1]["ready"][0], 1e-9)
        beside.append(tasks[-1]["rendered"][1] - share * (tasks[-1]["rendered"][1] - tasks[-1]["ready"][1]))
    wall, cpu = phases_of(tasks, submitted, image_at)
    wall["submit"], cpu["submit"] = submit.wall_s, submit.processor_s
    return wall, cpu, beside, len(tasks)


def say(nodes, tasks, kind, seconds):
    """Prints a row of the timeline."""
    print(f"{nodes} nodes, {tasks} tasks, {kind:<9} {sum(seconds.values()):7.2f} s: "
          + ", ".join(f"{phase} {seconds[phase]:.2f}" for phase in PHASES), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_eikon_flag(parser)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--size", default="1280x720")
    options, options.words = parser.parse_known_args()
    totals = {(nodes, kind): [] for nodes in (1, 2) for kind in ("clock", "processor")}
    with slurm_cluster.Cluster() as cluster, tempfile.TemporaryDirectory() as space:
        cluster.environment["EIKON_NODE_CACHE"] = f"{space}/kernels"
        spp, options.spp = options.spp, 1
        for number in range(-1, options.rounds):  # the first round compiles, and does not count
            for nodes, words in ((1, ["--exclude", "n2"]), (2, [])):
                folder = pathlib.Path(space) / f"{number}-{nodes}"
                folder.mkdir()
                wall, cpu, beside, tasks = one_run(cluster, folder, options, words)
                if number < 0:
                    continue
                say(nodes, tasks, "clock", wall)
                say(nodes, tasks, "processor", cpu)
                print(f"  a task beside its rendering: {statistics.median(beside):.2f} s of the processor", flush=True)
                totals[nodes, "clock"].append(sum(wall.values()))
                totals[nodes, "processor"].append(sum(cpu.values()))
            options.spp = spp
    for kind in ("clock", "processor"):
        one, two = totals[1, kind], totals[2, kind]
        print(f"{kind}: least {min(one):.2f} and {min(two):.2f} s, {min(one) / min(two):.2f} times as fast; median of {len(one)} "
              f"{statistics.median(one):.2f} and {statistics.median(two):.2f} s, "
              f"{statistics.median(one) / statistics.median(two):.2f} times")


if __name__ == "__main__":
    main()
