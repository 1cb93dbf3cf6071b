#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Renders a glTF scene with Mitsuba 3 as eikon would: same camera to the pixel, box filter of width 1, path tracing
with MIS, roulette from depth 5, no clamp, independent samples. Writes an EXR with R, G, B and the variance of each
pixel's mean (variance.R, variance.G, variance.B), from independent batches; prints the seconds of rendering alone and
samples/s.

  python3 -m venv ~/eikon-versus && ~/eikon-versus/bin/pip install mitsuba OpenEXR numpy
  apt-get install libllvm15
  ~/eikon-versus/bin/python tools/versus/mitsuba_render.py scenes/cornell.gltf -o out/mitsuba.exr --size 360x360
"""

import argparse
import glob
import math
import os
import pathlib
import re
import sys
import time

import numpy as np

import gltf_scene


def find_llvm():
    """Points Dr.Jit at the newest LLVM of the system, unless DRJIT_LIBLLVM_PATH already says which."""
    found = glob.glob("/usr/lib/*/libLLVM-*.so*") + glob.glob("/usr/lib/llvm-*/lib/libLLVM*.so*")
    if "DRJIT_LIBLLVM_PATH" not in os.environ and found:
        def version(path):
            return [int(part) for part in re.findall(r"\d+", pathlib.Path(path).name)]

        os.environ["DRJIT_LIBLLVM_PATH"] = max(found, key=version)


def build(mi, scene, width, height, max_depth, environment=None):
    """The Mitsuba scene of a gltf_scene.Scene. `environment` (R, G, B) replaces the file's."""
    camera = scene.camera
    if camera is None:
        raise ValueError("the scene has no camera")
    frame = camera.world_from_camera
    eye, forward, up = frame[:3, 3], -frame[:3, 2], frame[:3, 1]
    reach = np.ptp(np.concatenate([part.positions for part in scene.parts]), axis=0).max()
    description = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": max_depth, "rr_depth": 5},
        "sensor": {
            "type": "perspective",
            "fov_axis": "y",
            "fov": math.degrees(camera.yfov),
            "near_clip": float(reach) * 1e-6,
            "far_clip": float(reach) * 1e6,
            "to_world": mi.ScalarTransform4f().look_at(
                origin=[float(v) for v in eye], target=[float(v) for v in eye + forward], up=[float(v) for v in up]),
            "film": {"type": "hdrfilm", "width": width, "height": height, "pixel_format": "rgb",
                     "component_format": "float32", "rfilter": {"type": "box"}},
            "sampler": {"type": "independent"},
        },
    }
    radiance = environment or scene.environment
    if radiance is None and not any(max(part.emission) > 0 for part in scene.parts):
        raise ValueError("the scene has no light; name an environment with --env R,G,B")
    if radiance is not None:
        description["environment"] = {"type": "constant", "radiance": {"type": "rgb", "value": list(radiance)}}

    for number, part in enumerate(scene.parts):
        if part.double_sided and max(part.emission) > 0:
            raise ValueError(f"node {part.name}: emission on both sides has no counterpart in Mitsuba")
        bsdf = mi.load_dict({"type": "twosided", "bsdf": {
            "type": "diffuse", "reflectance": {"type": "rgb", "value": list(part.color)}}})
        properties = mi.Properties()
        properties["bsdf"] = bsdf
        if max(part.emission) > 0:
            properties["emitter"] = mi.load_dict({
                "type": "area", "radiance": {"type": "rgb", "value": list(part.emission)}})
        properties["face_normals"] = part.normals is None
        mesh = mi.Mesh(part.name, len(part.positions), len(part.triangles), has_vertex_normals=part.normals is not None,
                       props=properties)
        parameters = mi.traverse(mesh)
        parameters["vertex_positions"] = part.positions.astype(np.float32).ravel()
        parameters["faces"] = part.triangles.astype(np.uint32).ravel()
        if part.normals is not None:
            parameters["vertex_normals"] = part.normals.astype(np.float32).ravel()
        parameters.update()
        description[f"part{number}"] = mesh
    return mi.load_dict(description)


def render(mi, scene, spp, seed, batches):
    """(mean, variance of the mean, seconds): (h, w, 3) arrays from `batches` renders of spp / batches samples each."""
    total = squares = 0.0
    start = time.perf_counter()
    for batch in range(batches):
        image = np.array(mi.render(scene, spp=spp // batches, seed=seed * 65536 + batch), dtype=np.float64)
        total, squares = total + image, squares + image * image
    seconds = time.perf_counter() - start
    mean = total / batches
    variance = (squares / batches - mean * mean) / (batches - 1) if batches > 1 else np.full_like(mean, np.nan)
    return mean, np.maximum(variance, 0.0), seconds


def write_exr(path, mean, variance):
    import OpenEXR
    channels = {}
    for index, name in enumerate("RGB"):
        channels[name] = np.ascontiguousarray(mean[:, :, index], np.float32)
        channels[f"variance.{name}"] = np.ascontiguousarray(variance[:, :, index], np.float32)
    pathlib.Path(path).parent.mkdir(parents=True, exist_ok=True)
    OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, channels).write(str(path))


def parse_size(text):
    width, height = text.lower().split("x")
    return int(width), int(height)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", help=".gltf or .glb")
    parser.add_argument("-o", "--output", metavar="OUT.exr")
    parser.add_argument("--size", type=parse_size, default=(360, 360), metavar="WxH")
    parser.add_argument("--spp", type=int, default=64, help="samples per pixel (default 64)")
    parser.add_argument("--max-depth", type=int, default=-1, help="path edges from the camera; -1: no limit (default)")
    parser.add_argument("--env", type=lambda t: tuple(float(v) for v in t.split(",")), metavar="R,G,B")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--variant", default="llvm_ad_rgb", help="llvm_ad_rgb (default) or scalar_rgb")
    parser.add_argument("--threads", type=int, default=0, help="0: all")
    parser.add_argument("--batches", type=int, default=1, help="independent renders for the variance (default 1: none)")
    parser.add_argument("--rounds", type=int, default=1, help="render so often, print the best; the first compiles")
    arguments = parser.parse_args()
    if arguments.spp % arguments.batches:
        parser.error("--spp must be a multiple of --batches")

    find_llvm()
    import mitsuba as mi
    mi.set_variant(arguments.variant)
    if arguments.threads:
        mi.set_thread_count(arguments.threads)
    try:
        scene = build(mi, gltf_scene.load(arguments.scene), *arguments.size, arguments.max_depth, arguments.env)
    except ValueError as error:
        sys.exit(f"{arguments.scene}: {error}")

    best = math.inf
    for round_ in range(arguments.rounds):
        mean, variance, seconds = render(mi, scene, arguments.spp, arguments.seed, arguments.batches)
        best = min(best, seconds)
        label = " (with compiling)" if round_ == 0 else ""
        print(f"round {round_}: {seconds:.3f} s{label}", file=sys.stderr)
    samples = arguments.size[0] * arguments.size[1] * arguments.spp
    means = " ".join(f"{v:.6g}" for v in mean.mean((0, 1)))
    print(f"{best:.3f} s, {samples / best / 1e6:.3f} M samples/s, mean {means}")
    if arguments.output:
        write_exr(arguments.output, mean, variance)


if __name__ == "__main__":
    main()
