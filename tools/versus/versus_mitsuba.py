#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Samples per second of `eikon render` and of Mitsuba 3 on the same scene, settings and machine, in turns; best of
several rounds. Rendering alone counts on both sides: no loading, building, or compiling. Ends with the ratio of the
means and the block test of blocks_compare.py, since a faster wrong picture is worth nothing.

Runs in the virtual environment that mitsuba_render.py describes:

  ~/eikon-versus/bin/python tools/versus/versus_mitsuba.py scenes/cornell.gltf --eikon build-release/eikon
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

import blocks_compare
import gltf_scene
import mitsuba_render


def run_eikon(arguments, folder, seed):
    """Renders once; returns (samples per second, image, variance)."""
    image, stats = folder / "eikon.exr", folder / "eikon.json"
    size = f"{arguments.size[0]}x{arguments.size[1]}"
    command = [arguments.eikon, "render", arguments.scene, "-o", image, "--stats", stats, "--aov", "variance",
               "--quiet", "--size", size, "--spp", arguments.spp, "--seed", seed]
    if arguments.max_depth > 0:
        command += ["--max-depth", arguments.max_depth]
    if arguments.threads:
        command += ["--threads", arguments.threads]
    done = subprocess.run([str(word) for word in command], stdout=subprocess.DEVNULL)
    if done.returncode != 0:
        sys.exit(f"{' '.join(str(word) for word in command)}: exit code {done.returncode}")
    report = json.loads(stats.read_text())
    return report["samples"] / report["seconds"]["render"], *blocks_compare.read(str(image))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", help=".gltf or .glb")
    parser.add_argument("--eikon", default="build-release/eikon", help="the binary (default build-release/eikon)")
    parser.add_argument("--size", type=mitsuba_render.parse_size, default=(360, 360), metavar="WxH")
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--max-depth", type=int, default=16, help="path edges; -1: no limit (default 16)")
    parser.add_argument("--rounds", type=int, default=5, help="counted rounds after one that warms both up (default 5)")
    parser.add_argument("--variant", default="llvm_ad_rgb")
    parser.add_argument("--threads", type=int, default=0, help="for both; 0: all")
    parser.add_argument("--json", metavar="OUT.json", help="write the figures there")
    arguments = parser.parse_args()

    mitsuba_render.find_llvm()
    import mitsuba as mi
    mi.set_variant(arguments.variant)
    if arguments.threads:
        mi.set_thread_count(arguments.threads)
    try:
        scene = mitsuba_render.build(mi, gltf_scene.load(arguments.scene), *arguments.size, arguments.max_depth)
    except ValueError as error:
        sys.exit(f"{arguments.scene}: {error}")

    samples = arguments.size[0] * arguments.size[1] * arguments.spp
    rates = {"eikon": [], "mitsuba": []}
    images = {"eikon": [], "mitsuba": []}
    variances = []
    with tempfile.TemporaryDirectory() as folder:
        for round_ in range(arguments.rounds + 1):
            rate, image, variance = run_eikon(arguments, pathlib.Path(folder), round_)
            mean, _, seconds = mitsuba_render.render(mi, scene, arguments.spp, round_, 1)
            images["eikon"].append(image)
            images["mitsuba"].append(mean)
            variances.append(variance)
            note = "  (warms up, not counted)" if round_ == 0 else ""
            figures = f"eikon {rate / 1e6:7.3f}   mitsuba {samples / seconds / 1e6:7.3f}  M samples/s"
            print(f"round {round_}: {figures}{note}")
            if round_ > 0:
                rates["eikon"].append(rate)
                rates["mitsuba"].append(samples / seconds)

    # Each round has its own seed, so the mean over rounds is the better image and the rounds give Mitsuba's variance.
    eikon, mitsuba = np.mean(images["eikon"], axis=0), np.mean(images["mitsuba"], axis=0)
    variance = np.mean(variances, axis=0) / len(variances) + np.var(images["mitsuba"], axis=0, ddof=1) / len(variances)
    z = blocks_compare.block_z(eikon, mitsuba, variance, 16)
    p = blocks_compare.sidak(blocks_compare.p_values(z).min(), z.size)
    result = {
        "scene": arguments.scene, "size": list(arguments.size), "spp": arguments.spp, "max_depth": arguments.max_depth,
        "variant": arguments.variant, "eikon_samples_per_second": max(rates["eikon"]),
        "mitsuba_samples_per_second": max(rates["mitsuba"]), "ratio": max(rates["eikon"]) / max(rates["mitsuba"]),
        "ratio_of_means": eikon.mean() / mitsuba.mean(), "p_blocks": p,
    }
    print(f"best:    eikon {max(rates['eikon']) / 1e6:7.3f}   mitsuba {max(rates['mitsuba']) / 1e6:7.3f}  M samples/s,"
          f" ratio {result['ratio']:.3f}")
    print(f"means:   eikon {eikon.mean():.6g}, mitsuba {mitsuba.mean():.6g}, ratio {result['ratio_of_means']:.5f}")
    print(f"blocks:  {z.size} tests, p = {p:.4g}: {'differ' if p < 0.01 else 'agree'}")
    if arguments.json:
        pathlib.Path(arguments.json).write_text(json.dumps(result, indent=1) + "\n")
    return 1 if p < 0.01 else 0


if __name__ == "__main__":
    sys.exit(main())
