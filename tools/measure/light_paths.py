#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures what light paths are worth, as the trial decides on them: error and cost without them and with them.

  tools/measure/light_paths.py [--eikon FILE] [--seeds N] [--spp N] [--reference-spp N] [--json FILE] [SCENE[=WxH] ...]

For each scene a row: how many light paths the image has for each path from the camera and what the trial predicts that they
gain, the mean relMSE of the seeds against a reference without and with them, rays and processor seconds of the whole command
with them over those without, and the gain: the product of error and seconds without them over that with them, and its standard
error over the seeds. The reference has a quarter of a light path for each path from the camera, unless the scene has none; its
own error, which it predicts, is taken off both. Scenes that the trial leaves without light paths keep their bits and have no
figures but what the trial costs: seconds with it over those without. Guiding is off. Standard library only.
"""

import argparse
import json
import math
import pathlib
import statistics
import sys
import tempfile

from guiding import LEAST_RELMSE, REFERENCE_SEED, ROOT, is_refused, parse_scene, relmse

sys.path.append(str(ROOT / "tools"))
from common.child_process import run_or_exit  # noqa: E402
from common.flags import add_eikon_flag, at_least  # noqa: E402


def measure(eikon, scene, size, options):
    """The row of a scene as a dictionary; None if eikon refuses it or it can have no light paths."""
    if is_refused(eikon, scene):
        return None
    with tempfile.TemporaryDirectory(prefix="eikon_light_paths_") as name:
        folder = pathlib.Path(name)

        def render(name, light_paths, spp, seed):
            """Its statistics, with the processor seconds of the command as "processor_s"."""
            flags = [] if light_paths == "auto" else ["--light-paths", light_paths]
            done = run_or_exit(eikon, "render", scene, "-o", folder / f"{name}.exr", "--stats", folder / f"{name}.json", "--size", size,
                               "--guiding", "off", "--spp", spp, "--seed", seed, "--quiet", *flags)
            return json.loads((folder / f"{name}.json").read_text()) | {"processor_s": done.processor_s}

        for way in ("off", "auto"):
            first = render("first", way, 1, 0)  # compiles
        pilot = first["pilot"]
        if pilot is None:
            return None
        count, predicted = pilot["light_path_count"], pilot["light_path_gain"]
        ways = ("off", "auto")
        runs = {way: [render(f"{way}{seed}", way, options.spp, seed) for seed in range(options.seeds)] for way in ways}
        seconds = {way: statistics.fmean(run["processor_s"] for run in runs[way]) for way in ways}
        width, height = map(int, size.split("x"))
        row = {"scene": scene.stem, "size": size, "ratio": count / (width * height), "predicted": predicted,
               "seconds": seconds["auto"] / seconds["off"]}
        if count == 0:
            return row
        own = render("reference", "0.25", options.reference_spp, REFERENCE_SEED)["relmse_predicted"]
        errors = {way: [max(relmse(eikon, folder / f"{way}{seed}.exr", folder / "reference.exr") - own, LEAST_RELMSE)
                        for seed in range(options.seeds)] for way in ways}
    mean = {way: statistics.fmean(errors[way]) for way in ways}
    doubt = math.sqrt(sum((statistics.stdev(errors[way]) / mean[way]) ** 2 for way in ways) / options.seeds)
    rays = {way: statistics.fmean(run["rays"]["total"] for run in runs[way]) for way in ways}
    gain = mean["off"] / mean["auto"] / row["seconds"]
    return row | {"off": mean["off"], "on": mean["auto"], "rays": rays["auto"] / rays["off"], "gain": gain, "doubt": gain * doubt}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("scenes", nargs="*", metavar="SCENE[=WxH]")
    add_eikon_flag(parser)
    parser.add_argument("--seeds", type=at_least(2), default=3)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--reference-spp", type=int, default=2048)
    parser.add_argument("--json", type=pathlib.Path)
    options = parser.parse_args()
    scenes = options.scenes or sorted(str(path) for path in (ROOT / "scenes").glob("*.gltf"))
    rows = []
    print("| scene | light paths | predicted | relMSE without | with | rays, times | seconds, times | gain |\n"
          "|---|---|---|---|---|---|---|---|")
    for scene, size in map(parse_scene, scenes):
        row = measure(options.eikon, scene, size, options)
        if row is None:
            continue
        rows.append(row)
        if row["ratio"] == 0:
            print(f"| {row['scene']} | none | | | | | {row['seconds']:.2f} | |", flush=True)
            continue
        print(f"| {row['scene']} | {row['ratio']:.3g} | {row['predicted']:.2f} | {row['off']:.3g} | {row['on']:.3g} | "
              f"{row['rays']:.2f} | {row['seconds']:.2f} | {row['gain']:.2f} +- {row['doubt']:.2f} |", flush=True)
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
