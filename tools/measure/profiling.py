#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures what the profile costs: renders in turns, with and without --profile, and with and without the processor's counter in
the kernels (EIKON_TICKS=off). Prints the best time of each and how much longer it is than without; exit code 1 above --fail-above.

    tools/measure/profiling.py [--eikon build-release/eikon] [--rounds 7] [SCENE]

A script and no test: on a machine that does other things too, two runs of the same differ by more than what is measured."""

import argparse
import json
import os
import pathlib
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tools"))
from common.child_process import run_or_exit  # noqa: E402
from common.flags import add_eikon_flag  # noqa: E402

CASES = {"plain": ([], {"EIKON_TICKS": "off"}), "counter": ([], {}), "counter, --profile": (["--profile", "trace.json"], {})}


def seconds(options, folder, flags, variables):
    run_or_exit(options.eikon, "render", options.scene, "-o", "out.exr", "--size", options.size, "--spp", options.spp, "--stats",
                "stats.json", "--quiet", *flags, cwd=folder, env={**os.environ, **variables})
    stats = json.loads((folder / "stats.json").read_text())
    # What stands in for the counter is work of its own, which a processor that has one does not do.
    sampling = sum(s["seconds"] for s in stats["stages"] if s["stage"] == "sampling")
    return stats["seconds"]["render"] - sampling


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", nargs="?", type=lambda p: pathlib.Path(p).resolve(), default=ROOT / "scenes/cornell.gltf")
    add_eikon_flag(parser)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--size", default="256x256")
    parser.add_argument("--fail-above", type=float, default=1.0, help="percent")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        best = {}
        for round_number in range(options.rounds + 1):
            for case, (flags, variables) in CASES.items():
                taken = seconds(options, folder, flags, variables)
                if round_number > 0:  # the first one compiles
                    best[case] = min(best.get(case, taken), taken)
    worst = 0.0
    for case, taken in best.items():
        more = 100 * (taken / best["plain"] - 1)
        worst = max(worst, more)
        print(f"{case:20} {taken:8.4f} s {more:+6.2f} %")
    sys.exit(1 if worst > options.fail_above else 0)


if __name__ == "__main__":
    main()
