#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""eikon's motion blur against that of Blender's Cycles, on the shipped scenes that move. Exit code 0: all agree.

  tools/versus/check_cycles_motion.py [--eikon build-release/eikon] [--frame N] [--shutter FRAMES]

Every material becomes an unlit one with a colour of its own, so pictures show where things are while the shutter is open, and
nothing else: no light has to be translated. Nodes, skins, morph targets and cameras move as the file says, at 24 frames per
second, as Blender has it, with the shutter open around the frame. Means of blocks of 8 x 8 pixels are compared. For each
scene a row: the mean and the largest difference, and, beside them, the mean difference from the same frame without blur,
which shows how much there is to be seen."""

import argparse
import base64
import json
import os
import pathlib
import sys
import tempfile

import modules

modules.need(["bpy"], "eikon-cycles", "bpy==4.2.0")

import bpy  # noqa: E402
import numpy as np  # noqa: E402

import blender_picture  # noqa: E402
import cycles_render  # noqa: E402

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1]))
from common.child_process import run_or_exit  # noqa: E402
from common.flags import add_eikon_flag  # noqa: E402

SCENES = pathlib.Path(__file__).resolve().parents[2] / "scenes"
NAMES = ("bending_arm", "walking_figure", "morphing_blob", "spinning_wheel", "camera_path")
SIZE, SPP, BLOCK = (192, 144), 256, 8
KEYS_ON_THE_WAY = 32  # of a rotation between two keys of the file
MOST_MEAN, MOST = 0.0005, 0.015  # differences of blocks; colours are up to 1


def floats_of(root, number):
    """An accessor of tightly packed floats: (count, components)."""
    accessor = root["accessors"][number]
    view = root["bufferViews"][accessor["bufferView"]]
    uri = root["buffers"][view["buffer"]]["uri"]
    data = base64.b64decode(uri.split(",")[1]) if uri.startswith("data:") else (SCENES / uri).read_bytes()
    components = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
    begin = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
    return np.frombuffer(data, np.float32, accessor["count"] * components, begin).reshape(-1, components)


def add_accessor(root, values, kind):
    """Appends an accessor of floats with a buffer of its own; returns its number."""
    data = np.ascontiguousarray(values, np.float32).tobytes()
    root["buffers"].append({"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()})
    root["bufferViews"].append({"buffer": len(root["buffers"]) - 1, "byteLength": len(data)})
    limits = {"min": [float(values.min())], "max": [float(values.max())]} if kind == "SCALAR" else {}
    view = len(root["bufferViews"]) - 1
    root["accessors"].append({"bufferView": view, "componentType": 5126, "type": kind, "count": len(values), **limits})
    return len(root["accessors"]) - 1


def slerp(a, b, share):
    angle = np.arccos(np.clip(abs(a @ b), 0, 1))
    b = b if a @ b >= 0 else -b
    return a if angle < 1e-6 else (np.sin((1 - share) * angle) * a + np.sin(share * angle) * b) / np.sin(angle)


def adapt(root, sampler, path):
    """Makes a sampler one that Blender's importer reads as it is meant: it drops the tangents of CUBICSPLINE, so that the values
    are joined straight, and lets components of rotations go straight, so that there are keys on the way."""
    times, values = floats_of(root, sampler["input"]).ravel(), floats_of(root, sampler["output"])
    if sampler.get("interpolation") == "CUBICSPLINE":
        per_key = len(values) // len(times)
        values = np.concatenate([values[i + per_key // 3:i + 2 * per_key // 3] for i in range(0, len(values), per_key)])
        sampler |= {"interpolation": "LINEAR", "output": add_accessor(root, values, root["accessors"][sampler["output"]]["type"])}
    if path == "rotation" and sampler.get("interpolation", "LINEAR") == "LINEAR":
        shares = np.arange(KEYS_ON_THE_WAY) / KEYS_ON_THE_WAY
        keys = [(t + (u - t) * share, slerp(a, b, share)) for t, u, a, b in zip(times, times[1:], values, values[1:]) for share in shares]
        keys.append((times[-1], values[-1]))
        sampler |= {"input": add_accessor(root, np.array([time for time, _ in keys]), "SCALAR"),
                    "output": add_accessor(root, np.array([value for _, value in keys]), "VEC4")}


def unlit_copy(name, folder):
    """The scene with colours alone. Returns its path and its document."""
    root = json.loads((SCENES / f"{name}.gltf").read_text())
    for number, material in enumerate(root["materials"]):
        color = [0.2 + 0.8 * ((number * step) % 5) / 4 for step in (1, 2, 3)]
        material.clear()
        material |= {"name": f"m{number}", "pbrMetallicRoughness": {"baseColorFactor": [*color, 1], "metallicFactor": 0},
                     "extensions": {"KHR_materials_unlit": {}}, "doubleSided": True}
    whole = {"name": "all", "channels": [], "samplers": []}  # Blender plays one animation of a file
    for animation in root["animations"]:
        for channel in animation["channels"]:
            if channel["target"]["path"] != "pointer":
                whole["channels"].append({"sampler": len(whole["samplers"]), "target": channel["target"]})
                whole["samplers"].append(dict(animation["samplers"][channel["sampler"]]))
    root["animations"] = [whole]
    for channel, sampler in zip(whole["channels"], whole["samplers"]):
        adapt(root, sampler, channel["target"]["path"])
    root["extensionsUsed"] = ["KHR_materials_unlit"]
    root["scenes"][0].get("extras", {}).pop("environment", None)
    for buffer in root["buffers"]:
        if not buffer["uri"].startswith("data:"):
            (folder / buffer["uri"]).write_bytes((SCENES / buffer["uri"]).read_bytes())
    path = folder / f"{name}.gltf"
    path.write_text(json.dumps(root))
    return path, root


def by_eikon(eikon, path, frame, shutter):
    image = path.with_suffix(".eikon.exr")
    run_or_exit(eikon, "render", path, "-o", image, "--size", "{}x{}".format(*SIZE), "--spp", SPP, "--frame", frame,
                "--env", "0,0,0", "--fps", 24, "--shutter", shutter, "--shutter-at", "centre", "--quiet")
    return blender_picture.read(image)[:, :, :3].astype(np.float64)


def by_cycles(path, root, frame, shutter):
    cycles_render.load(path)
    arguments = argparse.Namespace(look_at=None, fov=None, size=SIZE, yfov=root["cameras"][0]["perspective"]["yfov"])
    cycles_render.set_camera(arguments)
    cycles_render.set_environment({"scenes": [{}]}, path.parent, None, 1.0, 0.0)
    scene = bpy.context.scene
    cycles_render.set_up(scene, SPP, 4)
    scene.render.use_motion_blur, scene.render.motion_blur_position = True, "CENTER"
    scene.render.motion_blur_shutter = shutter
    for thing in scene.objects:
        thing.cycles.use_deform_motion, thing.cycles.motion_steps = True, 4
    scene.frame_set(frame)
    return cycles_render.render(scene, 0)[0]


def block_means(image):
    rows, columns = image.shape[0] // BLOCK, image.shape[1] // BLOCK
    return image[:rows * BLOCK, :columns * BLOCK].reshape(rows, BLOCK, columns, BLOCK, 3).mean(axis=(1, 3))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_eikon_flag(parser)
    parser.add_argument("--frame", type=int, default=18)
    parser.add_argument("--shutter", type=float, default=4.0)
    options = parser.parse_args()
    failed = False
    print(f"{'scene':16} {'mean':>8} {'most':>8} {'without blur':>13}")
    for name in NAMES:
        with tempfile.TemporaryDirectory() as folder:
            path, root = unlit_copy(name, pathlib.Path(folder))
            blurred, still = (block_means(by_eikon(options.eikon, path, options.frame, shutter)) for shutter in (options.shutter, 0))
            reference = block_means(by_cycles(path, root, options.frame, options.shutter))
        difference = abs(blurred - reference)
        agrees = difference.mean() <= MOST_MEAN and difference.max() <= MOST
        failed = failed or not agrees
        print(f"{name:16} {difference.mean():8.4f} {difference.max():8.4f} {abs(still - reference).mean():13.4f}"
              f"{'' if agrees else '  differs'}")
    sys.stdout.flush()
    os._exit(1 if failed else 0)  # Blender's module does not bear to be unloaded


if __name__ == "__main__":
    main()
