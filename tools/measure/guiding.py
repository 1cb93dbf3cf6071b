#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures what guiding is worth: error times rays without it over the same with it, for as many samples.

  tools/measure/guiding.py [--eikon FILE] [--seeds N] [--spp N] [--reference-spp N] [--reference on|off] [--json FILE]
      [--decided] [--seconds] [SCENE[=WxH] ...]

For each scene a row: what the pilot predicts and decides, the mean relMSE of the seeds against a reference without
guiding, without and with `--guiding on`, the rays with guiding over those without, and the gain: the product of error and
rays without guiding over that with it, and its standard error over the seeds. The reference's own error, which it predicts,
is taken off both. Seconds do not count, so a busy machine does no harm, unless --seconds asks for two more columns: the
processor seconds of the whole command with guiding over those without, and that times the errors, which is the share of the
seconds that guiding needs for the same error. --reference on guides the reference, which then needs fewer samples. Scenes are
left out that have no pilot, unless --all asks for them. With --decided only the scenes are measured that `--guiding auto`
guides, since the others keep their bits. A file that eikon refuses is named and left out. The last line counts the files, and
has the least gain and the median of those that are guided. Without scenes, all of scenes/ are measured. Standard library only.
"""

import argparse
import json
import math
import pathlib
import statistics
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tools"))
from common import child_process  # noqa: E402
from common.child_process import run_or_exit  # noqa: E402
from common.flags import add_eikon_flag, at_least  # noqa: E402

REFERENCE_SEED = 1_000_003
USUAL_SIZE = "160x128"
INPUT_ERROR = 3  # exit code
LEAST_RELMSE = 1e-12  # keeps ratios finite where the reference states a larger error than the image has


def parse_scene(text):
    """(file, "WxH") of SCENE=WxH; a bare name is a shipped scene."""
    name, _, size = text.partition("=")
    path = pathlib.Path(name)
    if path.suffix not in (".gltf", ".glb"):
        path = ROOT / "scenes" / f"{name}.gltf"
    return path.resolve(), size or USUAL_SIZE


def is_refused(eikon, scene):
    """True if eikon does not load the file."""
    return child_process.run([eikon, "info", scene]).exit_code == INPUT_ERROR


def relmse(eikon, image, reference):
    """Returns the relMSE of an image against a reference, as `eikon compare` finds it."""
    return json.loads(run_or_exit(eikon, "compare", image, reference, "--json").stdout)["relmse"]


def without_gain(scene, size, decision, predicted):
    """The row of a scene that was not rendered with guiding."""
    return {"scene": scene.stem, "size": size, "decision": decision, "predicted": predicted, "gain": None}


def measure(eikon, scene, size, options):
    """The row of a scene as a dictionary."""
    if is_refused(eikon, scene):
        return without_gain(scene, size, "refused", None)
    with tempfile.TemporaryDirectory(prefix="eikon_guiding_") as name:
        folder = pathlib.Path(name)

        def job(name, guiding, spp, seed):
            return (f"render '{scene}' -o {name}.exr --stats {name}.json --size {size} --guiding {guiding} --spp {spp} "
                    f"--seed {seed}\n")

        def stats(name):
            return json.loads((folder / f"{name}.json").read_text())

        (folder / "first").write_text(job("auto", "auto", 1, 0))
        run_or_exit(eikon, "batch", folder / "first", "--quiet")
        pilot = stats("auto")["pilot"]
        if pilot is None and not options.all:
            return without_gain(scene, size, "no pilot", None)
        if options.decided and not (pilot and pilot["roulette_depth"]):
            return without_gain(scene, size, "off", pilot and pilot["gain"])
        (folder / "asked").write_text(job("on", "on", 1, 0))
        run_or_exit(eikon, "batch", folder / "asked", "--quiet")
        asked = stats("on")["pilot"]
        if asked is None:
            return without_gain(scene, size, "no pilot", None)
        seeds = range(options.seeds)
        (folder / "reference").write_text(job("reference", options.reference, options.reference_spp, REFERENCE_SEED))
        run_or_exit(eikon, "batch", folder / "reference", "--quiet")
        seconds = {"off": 0.0, "on": 0.0}
        # Programs are compiled here, and not in the seconds that are counted.
        (folder / "warm").write_text("".join(job(f"warm_{way}", way, 1, 0) for way in seconds))
        run_or_exit(eikon, "batch", folder / "warm", "--quiet")
        for seed in seeds:
            for way in seconds:
                (folder / "jobs").write_text(job(f"{way}{seed}", way, options.spp, seed))
                seconds[way] += run_or_exit(eikon, "batch", folder / "jobs", "--quiet").processor_s
        own = stats("reference")["relmse_predicted"]
        errors = {way: [max(relmse(eikon, folder / f"{way}{seed}.exr", folder / "reference.exr") - own, LEAST_RELMSE) for seed in seeds]
                  for way in ("off", "on")}
        rays = {way: statistics.fmean(stats(f"{way}{seed}")["rays"]["total"] for seed in seeds) for way in ("off", "on")}
    mean = {way: statistics.fmean(errors[way]) for way in errors}
    doubt = math.sqrt(sum((statistics.stdev(errors[way]) / mean[way]) ** 2 for way in errors) / options.seeds)
    ratio = rays["on"] / rays["off"]
    gain = mean["off"] / mean["on"] / ratio
    return {"scene": scene.stem, "size": size, "decision": "no pilot" if pilot is None else "on" if pilot["roulette_depth"] else "off",
            "predicted": asked["gain"], "reference": own,
            "off": mean["off"], "on": mean["on"], "rays": ratio, "gain": gain, "doubt": gain * doubt,
            "seconds": seconds["on"] / seconds["off"]}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("scenes", nargs="*", metavar="SCENE[=WxH]")
    add_eikon_flag(parser)
    parser.add_argument("--seeds", type=at_least(2), default=4)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--reference-spp", type=int, default=4096)
    parser.add_argument("--reference", choices=("on", "off"), default="off")
    parser.add_argument("--seconds", action="store_true")
    parser.add_argument("--all", action="store_true")
    parser.add_argument("--decided", action="store_true")
    parser.add_argument("--json", type=pathlib.Path)
    options = parser.parse_args()
    scenes = options.scenes or sorted(str(path) for path in (ROOT / "scenes").glob("*.gltf"))
    rows = []
    more = " seconds, times | seconds to equal error |" if options.seconds else ""
    print(f"| scene | auto | predicted | relMSE without | with | rays, times | gain |{more}\n"
          f"|---|---|---|---|---|---|---|{'---|---|' if more else ''}")
    for scene, size in map(parse_scene, scenes):
        row = measure(options.eikon, scene, size, options)
        rows.append(row)
        predicted = "" if row["predicted"] is None else f"{row['predicted']:.2f}"
        measured = "| | |" + ("| |" if more else "")
        if row["gain"] is not None:
            measured = (f"{row['off']:.3g} | {row['on']:.3g} | {row['rays']:.2f} | {row['gain']:.2f} +- {row['doubt']:.2f}")
            if more:
                measured += f" | {row['seconds']:.2f} | {row['seconds'] * row['on'] / row['off']:.2f}"
        print(f"| {row['scene']} | {row['decision']} | {predicted} | {measured} |", flush=True)
    guided = sorted(row["gain"] for row in rows if row["decision"] == "on")
    refused = sum(row["decision"] == "refused" for row in rows)
    print(f"\n{len(rows)} files, {refused} refused, {len(guided)} guided"
          + (f": least gain {guided[0]:.2f}, median {statistics.median(guided):.2f}" if guided else ""))
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
