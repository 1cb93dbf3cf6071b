#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Renders a glTF scene with Blender's Cycles: same camera, box filter of width 1, no clamp, no denoising, no blurring of
caustics, linear Rec. 709 without a view transform. Writes R, G, B; prints seconds, with --warm those of rendering alone,
and samples/s.

Blender's glTF importer turns metallic-roughness into its Principled shader, whose plastic is another model than glTF's
at grazing angles (what it adds for light scattered between microfacets is turned off, as glTF has none); Lambert, smooth
glass, opacity and textures mean the same. So look at the pictures side by side, and compare block means as figures, not as
a test.

  python3.11 -m venv ~/eikon-cycles && ~/eikon-cycles/bin/pip install bpy==4.2.0    # looked for there
  tools/versus/cycles_render.py scenes/textured.gltf -o out/cycles.exr --size 480x320 --spp 64
"""

import argparse
import json
import math
import pathlib
import struct
import sys
import tempfile
import time

import modules

modules.need(["bpy"], "eikon-cycles", "bpy==4.2.0")  # needs exactly Python 3.11

import bpy  # noqa: E402
import mathutils  # noqa: E402
import numpy as np  # noqa: E402

import blender_picture  # noqa: E402
import runner  # noqa: E402


def document(path):
    """The JSON of a .gltf or .glb file."""
    data = path.read_bytes()
    if data[:4] == b"glTF":
        return json.loads(data[20:20 + struct.unpack_from("<I", data, 12)[0]])
    return json.loads(data)


def blender(v):
    """glTF's +Y up as Blender's +Z up."""
    return mathutils.Vector((v[0], -v[2], v[1]))


def load(path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=str(path), import_shading="NORMALS")
    # Lights keep candela and lux as W / sr and W / m^2: the importer assumes 683 lm/W by default.
    root = document(path)
    lights = root.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", [])
    for entry in lights:
        for data in bpy.data.lights:
            if data.name == entry.get("name"):
                data.energy = entry.get("intensity", 1.0) * (1.0 if data.type == "SUN" else 4 * math.pi)
                data.color = entry.get("color", (1, 1, 1))
                if data.type == "SUN":
                    data.angle = 0.0
                else:
                    data.shadow_soft_size = 0.0
    return root


def adjust_materials(root):
    """glTF's default for meshes without a material, white rough metal, which the importer leaves grey and diffuse; and
    Principled without what glTF's model lacks: multiple scattering between microfacets, a coat on plain Lambert."""
    default = bpy.data.materials.new("default of glTF")
    default.use_nodes = True
    inputs = default.node_tree.nodes["Principled BSDF"].inputs
    inputs["Base Color"].default_value, inputs["Metallic"].default_value = (1, 1, 1, 1), 1.0
    inputs["Roughness"].default_value = 1.0
    for mesh in bpy.data.meshes:
        if not mesh.materials:
            mesh.materials.append(default)
        for slot, material in enumerate(mesh.materials):
            if material is None:
                mesh.materials[slot] = default
    for material in bpy.data.materials:
        for node in material.node_tree.nodes if material.use_nodes else ():
            if node.type == "BSDF_PRINCIPLED":
                node.distribution = "GGX"
    for entry in root.get("materials", []):
        extension = entry.get("extensions", {}).get("KHR_materials_specular", {})
        surface = entry.get("pbrMetallicRoughness", {})
        if extension.get("specularFactor", 1.0) != 0 or surface.get("metallicFactor", 1.0) != 0:
            continue
        material = bpy.data.materials.get(entry.get("name", ""))
        if material is None or not material.use_nodes:
            continue
        for node in material.node_tree.nodes:
            if node.type == "BSDF_PRINCIPLED":
                node.inputs["Specular IOR Level"].default_value = 0.0
                node.inputs["Roughness"].default_value = 1.0


def set_environment(root, folder, text, scale, rotate_deg):
    """The environment named by --env, else the scene's extras.environment; black where neither is given."""
    entry = root["scenes"][root.get("scene", 0)].get("extras", {}).get("environment", {})
    if text is not None:
        try:
            entry = {"radiance": [float(v) for v in text.split(",")]}
        except ValueError:
            entry, folder = {"uri": text}, pathlib.Path.cwd()
        entry |= {"scale": scale, "rotate": rotate_deg}
    world = bpy.data.worlds.new("environment")
    bpy.context.scene.world = world
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    background = nodes["Background"]
    background.inputs["Strength"].default_value = entry.get("scale", 1.0)
    background.inputs["Color"].default_value = (*entry.get("radiance", (0, 0, 0)), 1)
    if "uri" in entry:
        image = bpy.data.images.load(str((folder / entry["uri"]).resolve()))
        image.colorspace_settings.name = "Linear Rec.709"
        texture, mapping = nodes.new("ShaderNodeTexEnvironment"), nodes.new("ShaderNodeMapping")
        coordinates = nodes.new("ShaderNodeTexCoord")
        texture.image = image
        # The middle of the picture is -Z of glTF, +Y of Blender; Blender's own has it at +X, and u
        # grows the same way.
        mapping.inputs["Rotation"].default_value[2] = math.radians(-90 - entry.get("rotate", 0.0))
        links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
        links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
        links.new(texture.outputs["Color"], background.inputs["Color"])


def set_camera(arguments):
    scene = bpy.context.scene
    if arguments.look_at:
        data = bpy.data.cameras.new("given")
        camera = bpy.data.objects.new("given", data)
        scene.collection.objects.link(camera)
        eye, target = (blender([float(v) for v in part.split(",")]) for part in arguments.look_at.split(":")[:2])
        camera.location = eye
        camera.rotation_mode = "QUATERNION"
        camera.rotation_quaternion = (target - eye).to_track_quat("-Z", "Y")
        scene.camera = camera
    else:
        cameras = [o for o in scene.objects if o.type == "CAMERA"]
        if not cameras:
            sys.exit("the scene has no camera; give one with --look-at EYE:TARGET --fov DEG")
        scene.camera = cameras[0]
    data = scene.camera.data
    width, height = arguments.size
    # Blender's angle is that of the larger side; eikon keeps the vertical one.
    if arguments.fov:
        yfov = math.radians(arguments.fov)
    else:
        yfov = arguments.yfov
    data.sensor_fit = "VERTICAL"
    data.angle_y = yfov
    data.clip_start, data.clip_end = 1e-4, 1e5
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.render.resolution_percentage = 100


def render(scene, seed):
    """(image, None, seconds); through a file, the only way out of Blender without a window."""
    scene.cycles.seed = seed
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "image.exr"
        scene.render.filepath = str(path)
        start = time.perf_counter()
        bpy.ops.render.render(write_still=True)
        seconds = time.perf_counter() - start
        pixels = blender_picture.read(path)
    return pixels[:, :, :3].astype(np.float64), None, seconds


def set_up(scene, spp, max_depth):
    """Sets what every render has in common. max_depth: path edges from the camera"""
    scene.render.engine = "CYCLES"
    scene.render.film_transparent = False
    scene.view_settings.view_transform = "Raw"
    scene.view_settings.look = "None"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.render.image_settings.color_mode = "RGB"
    scene.render.dither_intensity = 0
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.samples = spp
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.blur_glossy = 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.pixel_filter_type = "BOX"
    cycles.filter_width = 1.0
    for kind in ("max", "diffuse", "glossy", "transmission", "transparent_max", "volume"):
        setattr(cycles, f"{kind}_bounces", max(max_depth - 2, 0))  # without the camera's edge and the light's
    scene.render.use_persistent_data = True  # the second render of --warm has its scene ready


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    runner.add_options(parser)
    parser.add_argument("--look-at", metavar="EYE:TARGET", help="as eikon's: x,y,z:x,y,z in glTF's axes")
    parser.add_argument("--fov", type=float, metavar="DEG", help="vertical; default the camera's, else 40")
    parser.add_argument("--env", metavar="R,G,B|FILE", help="replaces the file's environment")
    parser.add_argument("--env-scale", type=float, default=1.0)
    parser.add_argument("--env-rotate", type=float, default=0.0, metavar="DEG")
    parser.add_argument("--guiding", type=int, default=0, metavar="SAMPLES",
                        help="path guiding (OpenPGL) that learns from so many samples per pixel; 0: none; Blender's default is 128")
    arguments = parser.parse_args()

    root = load(arguments.scene)
    adjust_materials(root)
    cameras = [c["perspective"]["yfov"] for c in root.get("cameras", []) if "perspective" in c]
    arguments.yfov = math.radians(40.0) if arguments.look_at or not cameras else cameras[0]
    set_camera(arguments)
    set_environment(root, arguments.scene.parent, arguments.env, arguments.env_scale, arguments.env_rotate)

    scene = bpy.context.scene
    set_up(scene, arguments.spp, arguments.max_depth)
    if arguments.threads:
        scene.render.threads_mode, scene.render.threads = "FIXED", arguments.threads
    scene.cycles.use_guiding = arguments.guiding > 0
    scene.cycles.guiding_training_samples = arguments.guiding
    runner.run(arguments, lambda seed: render(scene, seed))
    runner.leave()


if __name__ == "__main__":
    main()
