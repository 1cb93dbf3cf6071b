#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures whether the error that images state is true: renders scenes with many seeds and compares with a reference.

  tools/measure/coverage.py [--eikon FILE] [--seeds N] [--most-seeds N] [--spp 4,16,64] [--json FILE] [SCENE=WxH[@REFERENCE_SPP] ...]

For each scene and number of samples a row: the median of predicted over true relMSE, the share of seeds whose 95 %
interval holds the truth, those of which only a lower end is stated, and how much wider the intervals are than the
narrowest that would hold 95 % of these seeds (the ratio of their logarithms). The truth is what `eikon compare` finds on average
over the seeds, which is what the prediction is for (host/film/film_error.cpp), less the reference's own error, which it predicts.
Where rare outliers carry most of it, the average of a few seeds is no truth: of 24 seeds of sun_room with 2 samples it was 1.4 times
that of 400. So seeds are added until its standard error is 2 %. Without scenes, ten of scenes/ are measured. Standard library only.
"""

import argparse
import json
import math
import pathlib
import shlex
import statistics
import sys
import tempfile
import typing

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tools"))
from common.child_process import run_or_exit  # noqa: E402
from common.flags import add_eikon_flag  # noqa: E402

USUAL = ["cornell=96x96@16384", "window_room=96x64@16384", "cornell_spheres=96x96@32768", "lamps=96x64@8192", "prism=96x64@32768",
         "alpha=96x64@8192", "sun_room=96x64@32768", "shelf_lamp_room=96x64@32768", "sphere_in_sky=96x64@8192", "tumbler=96x64@16384"]
REFERENCE_SEED = 1_000_003
STANDARD_ERROR = 0.02  # of the truth, relative


def parse_scene(text):
    """(file, "WxH", samples of the reference) of SCENE=WxH@SPP; a bare name is a shipped scene."""
    name, _, rest = text.partition("=")
    size, _, spp = rest.partition("@")
    path = pathlib.Path(name)
    if path.suffix not in (".gltf", ".glb"):
        path = ROOT / "scenes" / f"{name}.gltf"
    return path.resolve(), size or "96x96", int(spp or 16384)


class Image(typing.NamedTuple):
    """An image of one scene that is rendered with many seeds."""
    scene: pathlib.Path
    size: str  # "WxH"
    spp: int


def measured(options, folder, image, reference):
    """Returns [(true relMSE of the image, predicted, lo, hi)] of each seed, of which there are enough for the mean of the first."""
    results = []
    while len(results) < options.most_seeds:
        next_seeds = range(len(results), min(options.most_seeds, max(1, options.seeds, 2 * len(results))))
        results += measured_seeds(options.eikon, folder, image, next_seeds, reference)
        errors = [error for error, *_ in results]
        if len(errors) > 1 and statistics.stdev(errors) <= STANDARD_ERROR * len(errors) ** 0.5 * statistics.fmean(errors):
            break
    return results


def measured_seeds(eikon, folder, image, seeds, reference):
    """Returns the results of some seeds, as measured() does."""
    names = [f"{image.spp}.{seed}" for seed in seeds]
    jobs = folder / f"{image.spp}.jobs"
    jobs.write_text("".join(f"render {shlex.quote(str(image.scene))} -o {name}.exr --stats {name}.json --size {image.size} "
                            f"--spp {image.spp} --seed {seed}\n" for seed, name in zip(seeds, names)))
    run_or_exit(eikon, "batch", jobs, "--quiet")
    results = []
    for name in names:
        error = json.loads(run_or_exit(eikon, "compare", folder / f"{name}.exr", reference, "--json").stdout)["relmse"]
        stats = json.loads((folder / f"{name}.json").read_text())
        interval = find(stats, "relmse_interval")
        if interval is None:
            sys.exit(f"coverage.py: {image.scene.name} at {image.spp} samples: no error is predicted; "
                     "it takes two samples per pixel")
        low, high = interval
        results.append((error, find(stats, "relmse_predicted"), low, math.inf if high is None else high))
    return results


def find(tree, key):
    """The value of a key anywhere in a tree."""
    if isinstance(tree, dict):
        if key in tree:
            return tree[key]
        tree = list(tree.values())
    for child in tree if isinstance(tree, list) else ():
        value = find(child, key)
        if value is not None:
            return value
    return None


def find_reference(eikon, folder, scene, size, spp):
    """(file of the reference, its own error), which is rendered if the folder does not have it."""
    image = folder / f"{scene.stem}.{size}.{spp}.exr"
    stats = image.with_suffix(".json")
    if not image.exists() or not stats.exists():
        run_or_exit(eikon, "render", scene, "-o", image, "--stats", stats, "--size", size, "--spp", spp, "--seed", REFERENCE_SEED,
                    "--quiet")
    return image, find(json.loads(stats.read_text()), "relmse_predicted")


def row(results, reference_error):
    """Median of predicted over true, share of intervals that hold the truth, their width over the narrowest that would do.

    The first and the last are of those that state an upper end."""
    truth = statistics.fmean(error for error, *_ in results) - reference_error
    held = [lo <= truth <= hi for _, _, lo, hi in results]
    both_ends = [r for r in results if math.isfinite(r[3])]
    outcome = {"truth": truth, "ratio": math.nan, "held": sum(held), "seeds": len(results),
               "at_least": len(results) - len(both_ends), "width": math.nan}
    if both_ends:
        off = sorted(abs(math.log(predicted / truth)) for _, predicted, _, _ in both_ends)
        narrowest = off[min(len(off) - 1, math.ceil(0.95 * len(off)) - 1)]
        width = statistics.median(math.log(hi / lo) / 2 for _, _, lo, hi in both_ends)
        outcome["ratio"] = statistics.median(predicted for _, predicted, _, _ in both_ends) / truth
        outcome["width"] = width / narrowest if narrowest > 0 else math.inf
    return outcome


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", default=USUAL)
    add_eikon_flag(parser)
    parser.add_argument("--seeds", type=int, default=24, help="least number of seeds")
    parser.add_argument("--most-seeds", type=int, default=480)
    parser.add_argument("--spp", default="4,16,64")
    parser.add_argument("--references", type=pathlib.Path, help="folder that keeps the references for the next run")
    parser.add_argument("--json", type=pathlib.Path)
    args = parser.parse_args()
    rows = []
    print("| scene | spp | true relMSE | predicted / true | held | only at least | width / narrowest |\n|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        for text in args.scenes:
            scene, size, reference_spp = parse_scene(text)
            kept = args.references or folder
            kept.mkdir(parents=True, exist_ok=True)
            reference, reference_error = find_reference(args.eikon, kept, scene, size, reference_spp)
            for spp in (int(n) for n in args.spp.split(",")):
                result = row(measured(args, folder, Image(scene, size, spp), reference), reference_error)
                rows.append({"scene": scene.stem, "size": size, "spp": spp, **result})
                print(f"| {scene.stem} {size} | {spp} | {result['truth']:.3e} | {result['ratio']:.2f} | "
                      f"{result['held']} of {result['seeds']} | {result['at_least']} | {result['width']:.2f} |", flush=True)
    # Each row counts as much as any other, however many seeds it took.
    held = statistics.fmean(r["held"] / r["seeds"] for r in rows)
    print(f"\n{100 * held:.1f} % of the intervals of {sum(r['seeds'] for r in rows)} images hold the truth, in the mean of all rows")
    if args.json:
        args.json.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main()
