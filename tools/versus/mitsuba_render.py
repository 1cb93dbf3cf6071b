#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Renders a glTF scene with Mitsuba 3 as eikon would: same camera to the pixel, box filter of width 1, path tracing
with MIS, roulette from depth 5, no clamp. Writes R, G, B; prints seconds, with --warm those of rendering alone, and
samples/s.

  python3 -m venv ~/eikon-versus && ~/eikon-versus/bin/pip install mitsuba OpenEXR numpy    # looked for there
  apt-get install libllvm19       # 15 lacks instructions that Mitsuba 3.9 wants on AVX-512 machines
  tools/versus/mitsuba_render.py scenes/cornell.gltf -o out/mitsuba.exr --size 360x360
"""

import argparse
import dataclasses
import glob
import math
import os
import pathlib
import re
import sys
import time

import modules

modules.need(["numpy", "OpenEXR", "mitsuba"], "eikon-versus", "mitsuba OpenEXR numpy")

import numpy as np  # noqa: E402

import gltf_scene  # noqa: E402
import mitsuba_gltf  # noqa: E402
import runner  # noqa: E402


def find_llvm():
    """Points Dr.Jit at the newest LLVM of the system, unless DRJIT_LIBLLVM_PATH already says which."""
    found = glob.glob("/usr/lib/*/libLLVM[-.]*so*") + glob.glob("/usr/lib/llvm-*/lib/libLLVM*.so*")
    if "DRJIT_LIBLLVM_PATH" not in os.environ and found:
        def version(path):
            return [int(part) for part in re.findall(r"\d+", pathlib.Path(path).name)]

        os.environ["DRJIT_LIBLLVM_PATH"] = max(found, key=version)


def solid_bsdf(material, number):
    """Mitsuba's own dielectric for solid glass, with what glTF adds to it; the base colour tints every crossing."""
    alpha = material.roughness ** 2
    bsdf = {"type": "dielectric", "int_ior": material.ior, "ext_ior": 1.0,
            "specular_transmittance": {"type": "rgb", "value": list(material.base_color)}}
    if alpha >= mitsuba_gltf.SMOOTH_ALPHA:
        bsdf |= {"type": "roughdielectric", "distribution": "ggx", "alpha": alpha}
    return {"type": "gltf_solid", "material": number, "nested": bsdf}


def own_bsdf(material, flat, nearly):
    """The description of Mitsuba's own BSDF for a material, or None. Flat plain Lambert is the same in both; `nearly`
    also takes what differs by rules for shading normals or by Schlick's approximation: Lambert with normals, smooth
    clear glass, smooth metal."""
    if material.alpha_mode != "OPAQUE" or any((material.base_color_texture, material.metallic_roughness_texture,
                                               material.normal_texture)):
        return None
    color = {"type": "rgb", "value": list(material.base_color)}
    smooth = material.roughness ** 2 < mitsuba_gltf.SMOOTH_ALPHA
    if material.metallic == 0 and material.specular == 0 and material.transmission == 0 and (flat or nearly):
        return {"type": "twosided", "bsdf": {"type": "diffuse", "reflectance": color}}
    if not nearly or not smooth:
        return None
    if material.metallic == 1:
        return {"type": "twosided", "bsdf": {"type": "conductor", "material": "none", "specular_reflectance": color}}
    if material.transmission == 1 and material.metallic == 0 and material.solid and material.specular == 1 \
            and math.isinf(material.attenuation_distance):
        return {"type": "dielectric", "int_ior": material.ior, "ext_ior": 1.0, "specular_transmittance": color}
    return None


def bsdf_of(material, name, flat, nearly=False):
    """The description of a material's BSDF: Mitsuba's own where own_bsdf() has one, the rest from mitsuba_gltf.py."""
    own = own_bsdf(material, flat, nearly)
    if own is not None:
        return own
    textured = (material.base_color_texture, material.metallic_roughness_texture, material.normal_texture)
    number = len(mitsuba_gltf.MATERIALS)
    mitsuba_gltf.MATERIALS.append(material)
    if material.transmission > 0 and material.solid:
        if material.transmission < 1 or material.metallic > 0 or any(textured) or material.alpha_mode != "OPAQUE":
            raise ValueError(f"node {name}: solid transmission has a counterpart only untextured, opaque and whole")
        return solid_bsdf(material, number)
    return {"type": "gltf", "material": number}


def environment_of(mi, environment):
    """The description of an environment. Mitsuba's map has its rows at the poles and its middle at +Z; ours is sampled
    again at its places, so densely that bilinear interpolation between them is ours exactly."""
    if environment.radiance is not None:
        return {"type": "constant", "radiance": {"type": "rgb", "value": list(environment.radiance)}}
    picture = mi.Bitmap(str(environment.path)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32)
    source = np.array(picture, np.float64) * environment.scale
    height, width = source.shape[:2]
    x = (np.arange(3 * width) + 0.5) / 3 - 0.5
    y = np.clip(np.arange(2 * height + 1) / 2 - 0.5, 0, height - 1)
    x0, y0 = np.floor(x).astype(int), np.minimum(np.floor(y).astype(int), height - 2)
    fx, fy = (x - x0)[None, :, None], (y - y0)[:, None, None]
    rows = source[y0] * (1 - fy) + source[y0 + 1] * fy
    finer = rows[:, x0 % width] * (1 - fx) + rows[:, (x0 + 1) % width] * fx
    turn = mi.ScalarTransform4f().rotate([0, 1, 0], 180 + environment.rotate_deg)
    return {"type": "envmap", "bitmap": mi.Bitmap(finer.astype(np.float32)), "to_world": turn}


def light_of(light):
    if light.kind == "directional":
        return {"type": "directional", "direction": [float(v) for v in light.direction],
                "irradiance": {"type": "rgb", "value": list(light.intensity)}}
    return {"type": "point", "position": [float(v) for v in light.position],
            "intensity": {"type": "rgb", "value": list(light.intensity)}}


def vertex_tangents(part):
    """(n, 4) tangents where the file has none: means over the triangles around a vertex, weighted by their angles, as
    MikkTSpace has them where no mirrored coordinates meet."""
    corners, uv = part.positions[part.triangles], part.uv[part.triangles]
    e1, e2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    d1, d2 = uv[:, 1] - uv[:, 0], uv[:, 2] - uv[:, 0]
    area = d1[:, 0] * d2[:, 1] - d1[:, 1] * d2[:, 0]
    # v grows downwards in the picture and its bitangent upwards, so the sign is that of v turned
    # over.
    sign = -np.sign(area)
    tangent = (e1 * d2[:, 1:] - e2 * d1[:, 1:]) * np.sign(area)[:, None]
    total, signs = np.zeros_like(part.positions), np.zeros(len(part.positions))
    for k in range(3):
        index = part.triangles[:, k]
        n = part.normals[index]
        a, b = corners[:, (k + 1) % 3] - corners[:, k], corners[:, (k + 2) % 3] - corners[:, k]
        angle = np.arccos(np.clip((a * b).sum(1) / np.linalg.norm(a, axis=1) / np.linalg.norm(b, axis=1), -1, 1))
        t = tangent - n * (n * tangent).sum(1, keepdims=True)
        t /= np.linalg.norm(t, axis=1, keepdims=True)
        np.add.at(total, index, t * angle[:, None])
        np.add.at(signs, index, sign)
    total /= np.maximum(np.linalg.norm(total, axis=1, keepdims=True), 1e-30)
    return np.concatenate([total, np.sign(signs)[:, None]], axis=1)


def mesh_of(mi, part, nearly=False):
    """A Mitsuba mesh with its BSDF and, if it shines, its emitter; `nearly` as of own_bsdf()."""
    material = part.material
    if material.double_sided and material.emits:
        raise ValueError(f"node {part.name}: emission on both sides has no counterpart in Mitsuba")
    if part.uv is None and any((material.base_color_texture, material.metallic_roughness_texture,
                                material.normal_texture, material.emissive_texture)):
        raise ValueError(f"node {part.name}: textured, but without texture coordinates")
    bsdf = bsdf_of(material, part.name, part.normals is None, nearly)
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict(bsdf)
    if material.emits:
        radiance = {"type": "rgb", "value": list(material.emission)}
        if material.emissive_texture:
            mitsuba_gltf.MATERIALS.append(material)
            radiance = {"type": "gltf_emission", "material": len(mitsuba_gltf.MATERIALS) - 1}
        properties["emitter"] = mi.load_dict({"type": "area", "radiance": radiance})
    flat = part.normals is None
    if flat and material.normal_texture:
        # Normals of its own for every corner, so that tangents have vertices to stand on.
        corners = part.positions[part.triangles]
        n = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        n /= np.linalg.norm(n, axis=1, keepdims=True)
        part = dataclasses.replace(
            part, positions=corners.reshape(-1, 3), normals=np.repeat(n, 3, axis=0),
            uv=part.uv[part.triangles].reshape(-1, 2),
            tangents=None if part.tangents is None else part.tangents[part.triangles].reshape(-1, 4),
            triangles=np.arange(part.triangles.size, dtype=np.uint32).reshape(-1, 3))
    properties["face_normals"] = flat
    mesh = mi.Mesh(part.name, len(part.positions), len(part.triangles), has_vertex_normals=not flat,
                   has_vertex_texcoords=part.uv is not None, props=properties)
    parameters = mi.traverse(mesh)
    parameters["vertex_positions"] = part.positions.astype(np.float32).ravel()
    parameters["faces"] = part.triangles.astype(np.uint32).ravel()
    if not flat:
        parameters["vertex_normals"] = part.normals.astype(np.float32).ravel()
    if part.uv is not None:
        parameters["vertex_texcoords"] = part.uv.astype(np.float32).ravel()
    parameters.update()
    if material.normal_texture:
        tangents = part.tangents if part.tangents is not None else vertex_tangents(part)
        mesh.add_attribute("vertex_tangent", 3, tangents[:, :3].astype(np.float32).ravel())
        mesh.add_attribute("vertex_sign", 1, tangents[:, 3].astype(np.float32))
    return mesh


def build(mi, scene, width, height, max_depth, environment=None, sampler="independent", nearly=False, integrator="path"):
    """The Mitsuba scene of a gltf_scene.Scene. `environment`, a gltf_scene.Environment, replaces the file's; `nearly`
    as of own_bsdf(); `integrator` is path or ptracer, which follows paths from the lights alone."""
    camera = scene.camera
    if camera is None:
        raise ValueError("the scene has no camera")
    mitsuba_gltf.register(mi)
    frame = camera.world_from_camera
    eye, forward, up = frame[:3, 3], -frame[:3, 2], frame[:3, 1]
    reach = np.ptp(np.concatenate([part.positions for part in scene.parts]), axis=0).max()
    description = {
        "type": "scene",
        "integrator": {"type": integrator, "max_depth": max_depth, "rr_depth": 5},
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
            "sampler": {"type": sampler},
        },
    }
    environment = environment or scene.environment
    if environment is None and not scene.lights and not any(part.material.emits for part in scene.parts):
        raise ValueError("the scene has no light; name an environment with --env R,G,B or --env FILE.hdr")
    if environment is not None:
        description["environment"] = environment_of(mi, environment)
    for number, light in enumerate(scene.lights):
        description[f"light{number}"] = light_of(light)
    for number, part in enumerate(gltf_scene.merged(scene.parts)):  # Dr.Jit pays for every mesh with its emitter
        description[f"part{number}"] = mesh_of(mi, part, nearly)
    return mi.load_dict(description)


def parse_environment(text):
    """R,G,B or a file."""
    try:
        radiance = tuple(float(v) for v in text.split(","))
        return gltf_scene.Environment(radiance)
    except ValueError:
        return gltf_scene.Environment(None, pathlib.Path(text))


def render(mi, scene, spp, seed, batches):
    """(mean, variance of the mean or None, seconds): (h, w, 3) arrays from `batches` renders of spp / batches samples
    each."""
    total = squares = 0.0
    start = time.perf_counter()
    for batch in range(batches):
        image = np.array(mi.render(scene, spp=spp // batches, seed=seed * 65536 + batch), dtype=np.float64)
        total, squares = total + image, squares + image * image
    seconds = time.perf_counter() - start
    mean = total / batches
    variance = np.maximum(squares / batches - mean * mean, 0.0) / (batches - 1) if batches > 1 else None
    return mean, variance, seconds


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    runner.add_options(parser)
    parser.add_argument("--env", type=parse_environment, metavar="R,G,B|FILE")
    parser.add_argument("--variant", default="llvm_ad_rgb", help="llvm_ad_rgb (default) or scalar_rgb")
    parser.add_argument("--sampler", default="independent", help="independent (default), multijitter, ldsampler, ...")
    parser.add_argument("--integrator", choices=("path", "ptracer"), default="path",
                        help="path (default), or ptracer: paths from the lights, which see no mirror and no glass")
    parser.add_argument("--own", action="store_true", help="Mitsuba's own BSDFs also where they are only nearly glTF's:"
                        " faster; differs at grazing angles and at edges of coarse meshes")
    parser.add_argument("--batches", type=int, default=1, help="render in so many independent parts: less memory, and the"
                        " EXR holds the variance of each pixel's mean (variance.R, .G, .B)")
    arguments = parser.parse_args()
    if arguments.spp % arguments.batches:
        parser.error("--spp must be a multiple of --batches")

    find_llvm()
    import mitsuba as mi
    mi.set_variant(arguments.variant)
    mi.set_log_level(mi.LogLevel.Error)
    if arguments.threads:
        mi.set_thread_count(arguments.threads)
    try:
        scene = build(mi, gltf_scene.load(arguments.scene), *arguments.size, arguments.max_depth, arguments.env,
                      arguments.sampler, arguments.own, arguments.integrator)
    except ValueError as error:
        sys.exit(f"{arguments.scene}: {error}")

    runner.run(arguments, lambda seed: render(mi, scene, arguments.spp, seed, arguments.batches))


if __name__ == "__main__":
    main()
