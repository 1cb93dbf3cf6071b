#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Do `eikon render` and Mitsuba 3 agree on scenes, and how fast is each? For every scene: the ratio of the means, the
block test of blocks_compare.py (sigma: nine of ten blocks know their mean better than that), and samples per second (best
of several rounds in turns; rendering alone counts on both sides: no loading, building, or compiling), since a faster
wrong picture is worth nothing. Speed is compared by versus.py, which gives Mitsuba its own compiled BSDFs where it can: the
rates here are those of glTF's, which are traced from Python.

The models are the same (mitsuba_gltf.py says which is written anew and which is Mitsuba's own) but for two things. eikon's
albedo of the dielectric layer is a fit that lies above the truth by up to 0.005, which makes plastic darker by as
much at some angles: hence --tolerance, a relative difference of a block's mean that is forgiven, by default 0.003 in
scenes with plastic and 0 in others. And Mitsuba's smooth glass knows nothing of interpolated normals that disagree with
the triangles: hence --flat, which leaves the normals out for both.

Finds its Python modules by itself, or says what is missing.

  tools/versus/versus_mitsuba.py scenes/roughness_metal.gltf scenes/textured.gltf --eikon build-release/eikon
  tools/versus/versus_mitsuba.py --flat scenes/ior_row.gltf
"""

import argparse
import json
import pathlib
import sys
import tempfile

import modules

modules.need(["numpy", "OpenEXR", "mitsuba"], "eikon-versus", "mitsuba OpenEXR numpy")

import numpy as np  # noqa: E402

import blocks_compare  # noqa: E402
import gltf_scene  # noqa: E402
import mitsuba_render  # noqa: E402
import runner  # noqa: E402

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1]))
from common.child_process import run_or_exit  # noqa: E402
from common.flags import add_eikon_flag  # noqa: E402


def without_normals(path, folder):
    """A copy of a .gltf file without vertex normals and tangents, beside copies of the files that it names."""
    root = json.loads(path.read_text())
    for mesh in root["meshes"]:
        for primitive in mesh["primitives"]:
            primitive["attributes"].pop("NORMAL", None)
            primitive["attributes"].pop("TANGENT", None)
    environment = root["scenes"][0].get("extras", {}).get("environment", {})
    for entry in [*root.get("images", []), *root.get("buffers", []), environment]:
        if "uri" in entry and not entry["uri"].startswith("data:"):
            (folder / entry["uri"]).write_bytes((path.parent / entry["uri"]).read_bytes())
    copy = folder / path.name
    copy.write_text(json.dumps(root))
    return copy


def has_plastic(scene):
    """Tells whether some material has a diffuse base under a dielectric layer."""
    return any((p.material.metallic < 1 or p.material.metallic_roughness_texture) and p.material.specular > 0
               and not (p.material.transmission == 1 and p.material.solid) for p in scene.parts)


def run_eikon(arguments, path, folder, seed):
    """Renders once; returns (samples per second, image, variance)."""
    image, stats = folder / "eikon.exr", folder / "eikon.json"
    size = f"{arguments.size[0]}x{arguments.size[1]}"
    command = [arguments.eikon, "render", path, "-o", image, "--stats", stats, "--aov", "variance",
               "--quiet", "--size", size, "--spp", arguments.spp, "--seed", seed]
    if arguments.env:
        command += ["--env", arguments.env]
    if arguments.max_depth > 0:
        command += ["--max-depth", arguments.max_depth]
    if arguments.light_paths:
        command += ["--light-paths", arguments.light_paths]
    if arguments.threads:
        command += ["--threads", arguments.threads]
    run_or_exit(*command)
    report = json.loads(stats.read_text())
    return report["samples"] / report["seconds"]["render"], *blocks_compare.read(str(image))


def compare(mi, arguments, path, folder):
    """Renders one scene with both in turns; prints and returns the figures."""
    path = without_normals(path, folder) if arguments.flat else path
    loaded = gltf_scene.load(path)
    scene = mitsuba_render.build(mi, loaded, *arguments.size, arguments.max_depth,
                                 mitsuba_render.parse_environment(arguments.env) if arguments.env else None)
    tolerance = arguments.tolerance if arguments.tolerance is not None else 0.003 if has_plastic(loaded) else 0.0

    samples = arguments.size[0] * arguments.size[1] * arguments.spp
    rates = {"eikon": [], "mitsuba": []}
    images = {"eikon": [], "mitsuba": []}
    variances = []
    for round_ in range(arguments.rounds + 1):
        rate, image, variance = run_eikon(arguments, path, folder, round_)
        mean, _, seconds = mitsuba_render.render(mi, scene, arguments.spp, round_, 1)
        images["eikon"].append(image)
        images["mitsuba"].append(mean)
        variances.append(variance)
        if round_ > 0:  # the first warms both up
            rates["eikon"].append(rate)
            rates["mitsuba"].append(samples / seconds)

    # Each round has its own seed, so the mean over rounds is the better image and the rounds give
    # Mitsuba's variance.
    eikon, mitsuba = np.mean(images["eikon"], axis=0), np.mean(images["mitsuba"], axis=0)
    mitsuba_variance = np.var(images["mitsuba"], axis=0, ddof=1) / len(variances)
    variance = np.mean(variances, axis=0) / len(variances) + mitsuba_variance
    z, sigma = blocks_compare.block_z(eikon, mitsuba, variance, 16, tolerance)
    p = blocks_compare.sidak(blocks_compare.p_values(z).min(), z.size)
    worst = np.unravel_index(np.argmax(np.abs(z)), z.shape)
    name = path.name + (" without normals" if arguments.flat else "")
    result = {
        "scene": name, "size": list(arguments.size), "spp": arguments.spp * len(variances),
        "max_depth": arguments.max_depth, "variant": arguments.variant, "tolerance": tolerance,
        "eikon_samples_per_second": max(rates["eikon"]), "mitsuba_samples_per_second": max(rates["mitsuba"]),
        "ratio": max(rates["eikon"]) / max(rates["mitsuba"]), "ratio_of_means": eikon.mean() / mitsuba.mean(),
        "block_sigma": float(np.quantile(sigma, 0.9)), "p_blocks": p,
    }
    print(f"{name:34s} {result['ratio_of_means']:9.5f} {z.size:6d} {100 * result['block_sigma']:6.2f} %"
          f" {100 * tolerance:5.2f} % {p:9.3g}  {'differ' if p < 0.01 else 'agree ':6s}"
          f" {max(rates['eikon']) / 1e6:7.3f} {max(rates['mitsuba']) / 1e6:7.3f}", flush=True)
    if p < 0.01:
        block = tuple(slice(16 * worst[k], 16 * worst[k] + 16) for k in (0, 1)) + (worst[2],)
        print(f"  most in the block of row {worst[0]}, column {worst[1]}, channel {'RGB'[worst[2]]}: z = {z[worst]:+.2f},"
              f" eikon {eikon[block].mean():.6g}, mitsuba {mitsuba[block].mean():.6g}")
    if arguments.keep:
        arguments.keep.mkdir(parents=True, exist_ok=True)
        stem = path.stem + ("_flat" if arguments.flat else "")
        runner.write_image(arguments.keep / f"{stem}.eikon.exr", eikon, np.mean(variances, axis=0) / len(variances))
        runner.write_image(arguments.keep / f"{stem}.mitsuba.exr", mitsuba, mitsuba_variance)
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+", type=pathlib.Path, metavar="SCENE", help=".gltf or .glb")
    add_eikon_flag(parser)
    parser.add_argument("--size", type=runner.parse_size, default=(360, 360), metavar="WxH")
    parser.add_argument("--spp", type=int, default=64, help="samples per pixel of a round (default 64)")
    parser.add_argument("--max-depth", type=int, default=-1, help="path edges; -1: no limit (default)")
    parser.add_argument("--light-paths", metavar="NAME", help="of eikon; off for scenes where glass or a mirror reflects a sun or a "
                        "point light, whose caustics paths from the camera, and so Mitsuba's, cannot find")
    parser.add_argument("--env", metavar="R,G,B|FILE", help="replaces the file's environment")
    parser.add_argument("--rounds", type=int, default=5, help="counted rounds after one that warms both up (default 5)")
    parser.add_argument("--tolerance", type=float, help="relative difference of a block that is forgiven")
    parser.add_argument("--flat", action="store_true", help="without vertex normals")
    parser.add_argument("--variant", default="llvm_ad_rgb")
    parser.add_argument("--threads", type=int, default=0, help="for both; 0: all")
    parser.add_argument("--json", type=pathlib.Path, metavar="OUT.json", help="write the figures there")
    parser.add_argument("--keep", type=pathlib.Path, metavar="DIR", help="write both images there")
    arguments = parser.parse_args()
    if not pathlib.Path(arguments.eikon).exists():
        sys.exit(f"no {arguments.eikon}: build eikon, or name the program with --eikon")

    mitsuba_render.find_llvm()
    import mitsuba as mi
    mi.set_variant(arguments.variant)
    if arguments.threads:
        mi.set_thread_count(arguments.threads)
    print(f"{'scene':34s} {'means':>9s} {'tests':>6s} {'sigma':>8s} {'forgiven':>7s} {'p':>9s}  {'':6s}"
          f" {'eikon':>7s} {'mitsuba':>7s}  (M samples/s)", flush=True)
    results, failed = [], False
    for path in arguments.scenes:
        with tempfile.TemporaryDirectory() as folder:
            try:
                results.append(compare(mi, arguments, path, pathlib.Path(folder)))
            except (ValueError, OSError) as error:
                print(f"{path}: {error}", file=sys.stderr)
                failed = True
    if arguments.json:
        arguments.json.write_text(json.dumps(results, indent=1) + "\n")
    return 1 if failed or any(result["p_blocks"] < 0.01 for result in results) else 0


if __name__ == "__main__":
    sys.exit(main())
