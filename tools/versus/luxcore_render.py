#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Renders a glTF scene with LuxCore: same camera, box filter of one pixel, no clamp, no denoising, light
sampled by power, Sobol samples. --engine says how: `path`, its path tracer; `hybrid`, the same with light paths for
caustics, for which path tracing is left out; `bidir`, bidirectional path tracing with all connections; `opencl`, its path
tracer on GPUs, by OpenCL or CUDA as it chooses, or on what other OpenCL device there is; exit code 77 if there is none.
Writes R, G, B as .npy: what it brings along for memory does not live in one process with OpenEXR.

Plain Lambert, smooth clear glass, smooth metal, emission and constant environments have the same meaning in both; any
other material is refused by name.

  python3 -m venv ~/eikon-luxcore && ~/eikon-luxcore/bin/pip install pyluxcore numpy    # looked for there
  tools/versus/luxcore_render.py scenes/cornell.gltf -o out/luxcore.npy --size 256x256 --spp 64
"""

import argparse
import math
import os
import pathlib
import shutil
import sys
import tempfile
import time

import modules

modules.need(["numpy", "pyluxcore"], "eikon-luxcore", "pyluxcore numpy")



def drivers_without_pocl(folder):
    """Fills a folder with those OpenCL drivers of this machine that are not PoCL. returns  the folder"""
    for driver in pathlib.Path(os.environ.get("OCL_ICD_VENDORS", "/etc/OpenCL/vendors")).glob("*.icd"):
        if "pocl" not in driver.read_text():
            shutil.copy(driver, folder)
    return folder


# It asks OpenCL for devices even to render on the CPU, and PoCL's LLVM and its own do not live in
# one process: it finds none of PoCL's, and of others only where it is to use them.
WANTS_DEVICES = "opencl" in sys.argv or "--engine=opencl" in sys.argv
drivers = tempfile.TemporaryDirectory()
os.environ["OCL_ICD_VENDORS"] = drivers_without_pocl(drivers.name) if WANTS_DEVICES else os.devnull

import numpy as np  # noqa: E402
import pyluxcore  # noqa: E402

import gltf_scene  # noqa: E402
import runner  # noqa: E402


def material_of(material, part):
    """LuxCore's properties of a material, keys without their prefix."""
    color = list(material.base_color)
    textured = (material.base_color_texture, material.metallic_roughness_texture, material.normal_texture,
                material.emissive_texture)
    if any(textured) or material.alpha_mode != "OPAQUE":
        raise ValueError(f"node {part}: textures and opacity are not carried over")
    smooth = material.roughness ** 2 < 2.0 ** -13
    if material.metallic == 0 and material.specular == 0 and material.transmission == 0:
        properties = {"type": "matte", "kd": color}
    elif material.metallic == 1 and smooth:
        properties = {"type": "mirror", "kr": color}
    elif material.transmission == 1 and smooth and material.solid and math.isinf(material.attenuation_distance):
        properties = {"type": "glass", "kr": [1, 1, 1], "kt": color, "interiorior": material.ior, "exteriorior": 1.0}
    else:
        raise ValueError(f"node {part}: only Lambert, smooth metal and smooth clear glass are carried over")
    if material.emits:
        properties |= {"emission": list(material.emission), "emission.power": 0.0, "emission.efficency": 0.0}
    return properties


def scene_of(loaded, width, height):
    scene = pyluxcore.Scene()
    properties = pyluxcore.Properties()

    def put(key, values):
        properties.Set(pyluxcore.Property(key, values))

    camera = loaded.camera
    if camera is None:
        raise ValueError("the scene has no camera")
    frame = camera.world_from_camera
    eye, forward, up = frame[:3, 3], -frame[:3, 2], frame[:3, 1]
    put("scene.camera.type", "perspective")
    put("scene.camera.lookat.orig", [float(v) for v in eye])
    put("scene.camera.lookat.target", [float(v) for v in eye + forward])
    put("scene.camera.up", [float(v) for v in up])
    # The angle is that of the window from -1 to 1; without a window it would be the larger side's.
    aspect = width / height
    put("scene.camera.screenwindow", [-aspect, aspect, -1.0, 1.0])
    put("scene.camera.fieldofview", math.degrees(camera.yfov))
    put("scene.camera.autofocus.enable", False)
    put("scene.camera.cliphither", 1e-5)
    put("scene.camera.clipyon", 1e6)

    if loaded.lights:
        raise ValueError("punctual lights are not carried over")
    if loaded.environment is not None:
        if loaded.environment.radiance is None:
            raise ValueError("pictures as environment are not carried over")
        put("scene.lights.sky.type", "constantinfinite")
        put("scene.lights.sky.color", list(loaded.environment.radiance))
    for number, part in enumerate(gltf_scene.merged(loaded.parts)):
        name = f"part{number}"
        for key, value in material_of(part.material, part.name).items():
            put(f"scene.materials.{name}.{key}", value)
        normals = None if part.normals is None else [tuple(map(float, n)) for n in part.normals]
        scene.DefineMesh(name, [tuple(map(float, p)) for p in part.positions],
                         [tuple(map(int, t)) for t in part.triangles], normals, None, None, None)
        put(f"scene.objects.{name}.ply", name)
        put(f"scene.objects.{name}.shape", name)
        put(f"scene.objects.{name}.material", name)
    scene.Parse(properties)
    return scene


ENGINES = {"path": "PATHCPU", "hybrid": "PATHCPU", "bidir": "BIDIRCPU", "opencl": "PATHOCL"}


def chosen_devices():
    """A digit for each device that LuxCore lists, 1 for those to use: GPUs, or else what other OpenCL devices there are."""
    kinds = [device[1] for device in pyluxcore.GetOpenCLDeviceList()]
    wanted = [kind.endswith("_GPU") for kind in kinds]
    if not any(wanted):
        wanted = [kind.startswith("OPENCL_") for kind in kinds]
    return "".join(str(int(want)) for want in wanted) if any(wanted) else ""


def configure(scene, arguments, seed):
    width, height = arguments.size
    config = pyluxcore.Properties()
    settings = {
        "renderengine.type": ENGINES[arguments.engine],
        "sampler.type": "SOBOL",
        "sampler.sobol.adaptive.strength": 0.0,
        "renderengine.seed": seed + 1,
        "film.width": width, "film.height": height,
        "film.filter.type": "BOX", "film.filter.width": 0.5,
        "film.imagepipelines.0.0.type": "NOP",
        "film.outputs.0.type": "RGB", "film.outputs.0.filename": "unused.exr", "film.outputs.0.index": 0,
        "path.pathdepth.total": arguments.max_depth,
        "path.pathdepth.diffuse": arguments.max_depth,
        "path.pathdepth.glossy": arguments.max_depth,
        "path.pathdepth.specular": arguments.max_depth,
        "path.clamping.variance.maxvalue": 0.0,
        "path.russianroulette.depth": 5,
        "path.hybridbackforward.enable": arguments.engine == "hybrid",
        "path.hybridbackforward.partition": 0.8,  # of all samples, those that are paths from the camera: as LuxCore has it
        "path.maxdepth": arguments.max_depth,  # of bidirectional paths, from the camera and from the light
        "light.maxdepth": arguments.max_depth,
        "lightstrategy.type": "LOG_POWER",
        "batch.haltspp": [arguments.spp, 0],
        "batch.halttime": 0,
    }
    if arguments.engine == "opencl":  # these devices alone, and no threads of the processor beside them
        settings |= {"opencl.devices.select": chosen_devices(), "opencl.native.threads.count": 0}
    if arguments.threads:
        settings["native.threads.count"] = arguments.threads
    for key, value in settings.items():
        config.Set(pyluxcore.Property(key, value))
    return pyluxcore.RenderConfig(config, scene)


def render(scene, arguments, seed):
    """(image, None, seconds): from the engine's start, which builds the tree as well, to the last sample."""
    config = configure(scene, arguments, seed)  # lives as long as the session, which does not keep it alive
    session = pyluxcore.RenderSession(config)
    begin = time.perf_counter()
    session.Start()
    while not session.HasDone():
        time.sleep(0.002)
        session.UpdateStats()
    seconds = time.perf_counter() - begin
    width, height = arguments.size
    buffer = np.zeros(width * height * 3, np.float32)
    session.GetFilm().GetOutputFloat(pyluxcore.FilmOutputType.RGB, buffer, 0, True)
    session.Stop()
    return buffer.reshape(height, width, 3)[::-1].astype(np.float64), None, seconds


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    runner.add_options(parser)
    parser.add_argument("--engine", choices=tuple(ENGINES), default="path", help="default: path")
    arguments = parser.parse_args()
    pyluxcore.Init(lambda message: None)
    pyluxcore.GetOpenCLDeviceList()  # drivers are looked for once in a process
    drivers.cleanup()
    if arguments.engine == "opencl" and not chosen_devices():
        print("LuxCore finds no GPU (PoCL is not offered to it)", file=sys.stderr, flush=True)
        os._exit(77)
    try:
        scene = scene_of(gltf_scene.load(arguments.scene), *arguments.size)
    except ValueError as error:
        sys.exit(f"{arguments.scene}: {error}")
    runner.run(arguments, lambda seed: render(scene, arguments, seed))
    runner.leave()


if __name__ == "__main__":
    main()
