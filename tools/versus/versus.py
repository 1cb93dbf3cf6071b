#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Error against time, beside other renderers: the same glTF scenes with the same camera, size, depth and box filter, no
clamp, no denoising. For each scene and renderer, relMSE against the seconds of rendering alone (scene, tree and kernels
ready) and against the seconds from the process's start; a table, a PNG per scene, and one HTML page with all of it.

The reference is each renderer's own: the mean of four renders with other seeds, whose own noise is taken off. So nobody
is charged for small differences between the models; that the pictures agree is checked apart, by the ratio of means
(within 1 % counts as agreeing) in the table.

Every number of samples is a process of its own, in turns through the renderers, with a new seed each round; of the times
the best round counts, of the errors the mean. What is measured is kept in --out and added to by the next call with the
same settings, so that rounds can be spread over quiet times.

  tools/versus/versus.py scenes/cornell.gltf --eikon build/eikon --out out/versus
  tools/versus/versus.py scenes/*.gltf --renderers eikon,mitsuba,cycles,luxcore --rounds 5 --out out/versus
  tools/versus/versus.py --out out/versus        # the page again, of what is there

--install makes the virtual environments that are missing, in the home folder. Mitsuba wants LLVM: libllvm19.
"""

import argparse
import hashlib
import json
import os
import pathlib
import subprocess
import sys

import modules

modules.need(["numpy", "OpenEXR", "matplotlib"], "eikon-versus", "mitsuba OpenEXR numpy matplotlib")

import numpy as np  # noqa: E402

import blocks_compare  # noqa: E402
import error_time  # noqa: E402
import gltf_scene  # noqa: E402
import runner  # noqa: E402
import versus_page  # noqa: E402

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1]))
from common.flags import add_eikon_flag  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
REFERENCE_PARTS = 4
REFERENCE_SEED = 1000

# name: (folder in the home folder, packages, Python that they need, script with its own arguments)
RENDERERS = {
    "eikon": None,
    "mitsuba": ("eikon-versus", "mitsuba OpenEXR numpy matplotlib", "python3", ["mitsuba_render.py", "--own"]),
    "mitsuba-multijitter": ("eikon-versus", "mitsuba OpenEXR numpy matplotlib", "python3",
                            ["mitsuba_render.py", "--own", "--sampler", "multijitter"]),
    "mitsuba-ptracer": ("eikon-versus", "mitsuba OpenEXR numpy matplotlib", "python3",
                        ["mitsuba_render.py", "--own", "--integrator", "ptracer"]),
    "cycles": ("eikon-cycles", "bpy==4.2.0 numpy", "python3.11", ["cycles_render.py"]),
    "cycles-guided": ("eikon-cycles", "bpy==4.2.0 numpy", "python3.11", ["cycles_render.py", "--guiding", "128"]),
    "luxcore": ("eikon-luxcore", "pyluxcore numpy", "python3", ["luxcore_render.py"]),
    "luxcore-hybrid": ("eikon-luxcore", "pyluxcore numpy", "python3", ["luxcore_render.py", "--engine", "hybrid"]),
    "luxcore-bidir": ("eikon-luxcore", "pyluxcore numpy", "python3", ["luxcore_render.py", "--engine", "bidir"]),
}
# Of whom a renderer borrows its reference: the same light transport, sampled in another way.
REFERENCE_OF = {"mitsuba-multijitter": "mitsuba", "mitsuba-ptracer": "mitsuba", "cycles-guided": "cycles"}


def python_of(renderer):
    return pathlib.Path.home() / RENDERERS[renderer][0] / "bin" / "python"


def install(renderers):
    for renderer in renderers:
        if renderer != "eikon":
            folder, packages, python, _ = RENDERERS[renderer]
            modules.install(pathlib.Path.home() / folder, packages, python)


class Bench:
    """One scene's folder: settings.json, reference images, runs.jsonl."""

    def __init__(self, arguments, path):
        self.arguments, self.path = arguments, path
        self.folder = arguments.out / path.stem
        self.folder.mkdir(parents=True, exist_ok=True)
        camera = gltf_scene.load(path).camera
        if camera is None:
            raise ValueError(f"{path}: the scene has no camera")
        size = arguments.size or (int(round(camera.aspect * arguments.rows / 8)) * 8, arguments.rows)
        settings = {"scene": path.name, "hash": hashlib.sha256(path.read_bytes()).hexdigest()[:16], "size": list(size),
                    "max_depth": arguments.max_depth, "reference_spp": arguments.ref_spp}
        known = self.folder / "settings.json"
        if known.exists() and json.loads(known.read_text()) != settings:
            raise ValueError(f"{self.folder} holds measurements of other settings: remove it, or name another --out")
        known.write_text(json.dumps(settings) + "\n")
        self.size = size

    def render(self, renderer, spp, seed, warm):
        """(image, stats) of one process."""
        image, stats = self.folder / "image.npy", self.folder / "stats.json"
        common = ["--size", f"{self.size[0]}x{self.size[1]}", "--spp", spp, "--seed", seed, "--max-depth",
                  self.arguments.max_depth, "--stats", stats]
        if renderer == "eikon":
            image = self.folder / "image.exr"
            command = [self.arguments.eikon, "render", self.path, "-o", image, "--quiet", *common]
        else:
            script = RENDERERS[renderer][3]
            command = [python_of(renderer), HERE / script[0], self.path, "-o", image, *script[1:], *common]
            if warm:
                command.append("--warm")
            if renderer.startswith("mitsuba") and spp > 256:  # memory
                # So many that they divide the samples.
                command += ["--batches", next(n for n in range(-(-spp // 256), spp + 1) if spp % n == 0)]
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
        if done.returncode != 0:
            raise RuntimeError(f"{' '.join(map(str, command))}\n{done.stderr[-2000:]}")
        report = json.loads(stats.read_text())
        if renderer == "eikon":
            seconds = report["seconds"]
            # What writing the file takes is no part of it: the others' images are counted when they
            # are in memory.
            report = {"seconds": seconds["render"], "seconds_from_start": seconds["total"] - seconds["write"]}
            return blocks_compare.read(str(image))[0], report
        return np.load(image).astype(np.float64), report

    def reference(self, renderer):
        """The renderer's own reference, made if it is not there."""
        renderer = REFERENCE_OF.get(renderer, renderer)
        parts = []
        for part in range(REFERENCE_PARTS):
            kept = self.folder / f"{renderer}.reference{part}.npy"
            if not kept.exists():
                print(f"{self.path.name}: reference of {renderer}, part {part + 1} of {REFERENCE_PARTS}", flush=True)
                image, _ = self.render(renderer, self.arguments.ref_spp // REFERENCE_PARTS, REFERENCE_SEED + part, False)
                np.save(kept, image.astype(np.float32))
            parts.append(np.load(kept).astype(np.float64))
        return error_time.Reference(parts)

    def measure(self, renderers):
        """One round: every number of samples of every renderer once."""
        references = {renderer: self.reference(renderer) for renderer in renderers}
        with (self.folder / "runs.jsonl").open("a+") as file:
            file.seek(0)
            seen = [json.loads(line) for line in file]
            for spp in self.arguments.spp:
                for renderer in renderers:
                    seed = sum(run["renderer"] == renderer and run["spp"] == spp for run in seen)
                    image, stats = self.render(renderer, spp, seed, True)
                    run = {"renderer": renderer, "spp": spp, "seed": seed, **stats,
                           "relmse": references[renderer].error_of(image)}
                    file.write(json.dumps(run) + "\n")
                    file.flush()
                    print(f"{self.path.name:24s} {renderer:20s} {spp:6d} spp  {run['seconds']:8.3f} s"
                          f" {run['seconds_from_start']:8.2f} s from start  relMSE {run['relmse']:.3e}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", type=pathlib.Path, metavar="SCENE", help=".gltf or .glb")
    parser.add_argument("--out", type=pathlib.Path, required=True, metavar="DIR", help="measurements, plots, index.html")
    add_eikon_flag(parser)
    parser.add_argument("--renderers", default="eikon,mitsuba,mitsuba-multijitter",
                        help=f"of {','.join(RENDERERS)}; default eikon,mitsuba,mitsuba-multijitter")
    parser.add_argument("--size", type=runner.parse_size, metavar="WxH", help="default: the camera's aspect at --rows")
    parser.add_argument("--rows", type=int, default=256, help="height without --size (default 256)")
    parser.add_argument("--spp", default="4,16,64", help="the curve's samples per pixel (default 4,16,64)")
    parser.add_argument("--ref-spp", type=int, default=2048, help="samples per pixel of a reference (default 2048)")
    parser.add_argument("--max-depth", type=int, default=16, help="path edges from the camera (default 16)")
    parser.add_argument("--rounds", type=int, default=3, help="more rounds to measure (default 3); 0: references only")
    parser.add_argument("--overview", type=pathlib.Path, metavar="PNG", help="a plot of all scenes in one picture")
    parser.add_argument("--install", action="store_true", help="install the renderers that are missing")
    arguments = parser.parse_args()
    arguments.spp = [int(word) for word in arguments.spp.split(",")]
    renderers = arguments.renderers.split(",")
    for renderer in renderers:
        if renderer not in RENDERERS:
            parser.error(f"--renderers: no {renderer}; there is {', '.join(RENDERERS)}")
    if arguments.install:
        install(renderers)
    if arguments.scenes:
        for renderer in renderers:
            if renderer != "eikon" and not python_of(renderer).exists():
                sys.exit(f"{renderer} is not installed: give --install")
        if "eikon" in renderers and not os.access(arguments.eikon, os.X_OK):
            sys.exit(f"no {arguments.eikon}: build eikon, or name the program with --eikon")

    failed = False
    for path in arguments.scenes:
        try:
            bench = Bench(arguments, path)
            if arguments.rounds == 0:
                for renderer in renderers:
                    bench.reference(renderer)
            for _ in range(arguments.rounds):
                bench.measure(renderers)
        except (ValueError, RuntimeError, OSError) as error:
            print(f"{path}: {error}", file=sys.stderr)
            failed = True
    versus_page.write(arguments.out, arguments.overview)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
