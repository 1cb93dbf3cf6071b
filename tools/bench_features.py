#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measures what each feature costs per sample: renders the same geometry with one feature off and on, interleaved, and prints a
Markdown table (kernels/FEATURES.md holds one). Best of --rounds renders each; only on a machine with nothing else to do, or with
--cpu: this takes the processor time of --spp samples less that of a sixteenth of them, which other work disturbs less.

  tools/bench_features.py [--eikon build-release/eikon] [--rounds 7] [--spp 64] [--size 256x256] [--cpu] [--only NAME...]
                          [-o FILE.md]

The scene: twelve spheres of 1280 triangles on a floor under a sky, four edges per path at most. A feature that changes where
paths go (mirrors, glass, masks) also changes how many rays there are, so both are listed. `twelve materials` is against one
material with the same lobe and textures."""

import argparse
import json
import os
import pathlib
import platform
import sys
import tempfile

from common.child_process import run_or_exit
from common.flags import add_eikon_flag
from scene_builders import scene_pictures
from scene_builders.gltf_writer import GltfWriter
from scene_builders.scene_shapes import look_at, quad, sphere

FLAT_SPECULAR = {"KHR_materials_specular": {"specularFactor": 0.0}}
PICTURES = {"color": scene_pictures.tiles_color, "metal": scene_pictures.tiles_metallic_roughness,
            "normal": scene_pictures.tiles_normal, "leaf": scene_pictures.leaf}


class Variant:
    """One scene: what its spheres are made of, and what lights it. measured: the surface that table.binary beside it is measured
    from."""

    def __init__(self, smooth=False, coordinates=False, colors=False, lights=(), sky_map=False, materials=None, flags=(),
                 measured=None, moving=0, **surface):
        self.moving = moving  # of the balls, by .4 m in a second
        self.flags = list(flags)  # of eikon render
        self.measured = measured
        self.smooth, self.coordinates, self.colors = smooth, coordinates, colors
        self.lights, self.sky_map = lights, sky_map
        self.materials = materials or [surface]

    def write(self, path):
        gltf = GltfWriter(__doc__)
        pictures = {}

        def picture(name):
            pictures.setdefault(name, PICTURES[name]())
            return gltf.texture(name, pictures[name])

        made = []
        for number, surface in enumerate(self.materials):
            # True or a number stands for a texture; the rest is as GltfWriter.material has it.
            arguments = {"extensions": dict(FLAT_SPECULAR), "color": (0.7, 0.6, 0.5), **surface}
            for key, value in list(arguments.items()):
                if key.endswith("Texture"):
                    arguments[key] = picture(value)
            made.append(gltf.material(f"ball {number}", **arguments))
        points, triangles = sphere(0.45, 3)
        normals = [tuple(c / 0.45 for c in p) for p in points] if self.smooth else None
        coordinates = [(2 * p[0] + 0.3 * p[2], 2 * p[1]) for p in points] if self.coordinates else None
        tangents = [(1.0, 0.0, 0.0, 1.0)] * len(points) if self.coordinates and self.smooth else None
        ball = gltf.primitive(points, triangles, made[0], normals=normals, uv=coordinates, tangents=tangents)
        if self.colors:
            ball["attributes"]["COLOR_0"] = gltf.vertex_colors([tuple(0.5 + c for c in p) for p in points])
        for i in range(12):
            gltf.mesh(f"ball {i}", [{**ball, "material": made[i % len(made)]}],
                      translation=[i % 4 - 1.5, 0.45, i // 4 - 1.0])
        for i in range(self.moving):
            gltf.channel("roll", {"node": gltf.node_index(f"ball {i}"), "path": "translation"}, [0.0, 1.0],
                         [(i % 4 - 1.5, 0.45, i // 4 - 1.0), (i % 4 - 1.1, 0.45, i // 4 - 1.0)])
        floor = quad((-4, 0, 4), (4, 0, 4), (4, 0, -4), (-4, 0, -4))
        gltf.mesh("floor", [gltf.primitive(*floor, gltf.lambert("floor", (0.5, 0.5, 0.5)))])
        for kind in self.lights:
            gltf.punctual_light(kind, kind, (1, 1, 1), 20 if kind != "directional" else 2,
                                spot={"outerConeAngle": 1.2} if kind == "spot" else None,
                                matrix=look_at((2, 4, 3), (0, 0, 0)))
        if self.sky_map:
            gltf.environment_map("sky.hdr", scene_pictures.sky())
        else:
            gltf.environment((1, 1, 1))
        gltf.camera(0.7, 1.0, matrix=look_at((0, 3.2, 5), (0, 0.3, 0)))
        gltf.write(path)


def features():
    """[(name, off, on)]"""
    compensated = ["--energy-compensation", "on"]
    lambert, smooth = {}, {"smooth": True}
    textured = {"smooth": True, "coordinates": True, "baseColorTexture": "color"}
    rough = {"extensions": {}, "metallic": 0.0, "roughness": 0.4}
    glass = {"KHR_materials_transmission": {"transmissionFactor": 1.0}}
    solid = {**glass, "KHR_materials_volume": {"thicknessFactor": 1.0}}
    tinted = {**glass, "KHR_materials_volume": {"thicknessFactor": 1.0, "attenuationColor": [0.5, 0.8, 0.9],
                                                "attenuationDistance": 0.5}}
    everything = {**textured, **rough, "metallic": 1.0, "metallicRoughnessTexture": "metal", "normalTexture": "normal"}
    metal = {**smooth, **rough, "metallic": 1.0}
    gold = {"EIKON_materials_conductor": {"metal": "Au"}}
    film = {"KHR_materials_iridescence": {"iridescenceFactor": 1.0, "iridescenceThicknessMaximum": 380.0}}
    brushed = {"KHR_materials_anisotropy": {"anisotropyStrength": 0.8}}

    shutter = ["--shutter", "12"]
    lamp = {**smooth, **rough, "roughness": 0.0, "extensions": solid, "lights": ["point"]}
    light_paths = ["--light-paths", "0.0625"]

    def under_film(surface):
        return {**surface, "extensions": {**surface.get("extensions", {}), **film}}

    def with_flags(surface):
        return {**surface, "flags": compensated}

    twelve = [{**{k: v for k, v in everything.items() if k not in ("smooth", "coordinates")},
               "roughness": 0.2 + 0.05 * i, "color": (1 - 0.05 * i, 0.5 + 0.04 * i, 0.7)} for i in range(12)]
    return [
        ("culling of backs", {**lambert, "flags": ["--cull", "none"]}, lambert),
        ("normals of the mesh", lambert, smooth),
        ("vertex colours", lambert, {"colors": True}),
        ("base colour texture", {**smooth, "coordinates": True}, textured),
        ("normal map", textured, {**textured, "normalTexture": "normal"}),
        ("emissive texture, no light of its own", textured, {**textured, "emissiveTexture": "color",
                                                             "emission": (1e-3, 1e-3, 1e-3)}),
        ("plastic (GGX over diffuse)", smooth, {**smooth, **rough}),
        ("metal (GGX)", smooth, {**smooth, **rough, "metallic": 1.0}),
        ("mirror", smooth, {**smooth, **rough, "metallic": 1.0, "roughness": 0.0}),
        ("metallic-roughness texture", {**textured, **rough}, {**textured, **rough, "metallic": 1.0,
                                                               "metallicRoughnessTexture": "metal"}),
        ("specular factor", {**smooth, **rough}, {**smooth, **rough, "extensions": {
            "KHR_materials_specular": {"specularFactor": 0.5}}}),
        ("clearcoat", {**smooth, **rough}, {**smooth, **rough, "extensions": {
            "KHR_materials_clearcoat": {"clearcoatFactor": 1.0, "clearcoatRoughnessFactor": 0.2}}}),
        ("clearcoat of its own normal", {**textured, **rough, "normalTexture": "normal", "extensions": {
            "KHR_materials_clearcoat": {"clearcoatFactor": 0.0}}}, {**textured, **rough, "normalTexture": "normal", "extensions": {
                "KHR_materials_clearcoat": {"clearcoatFactor": 1.0, "clearcoatRoughnessFactor": 0.2}}}),
        ("sheen", {**smooth, **rough}, {**smooth, **rough, "extensions": {
            "KHR_materials_sheen": {"sheenColorFactor": [0.9, 0.9, 0.9], "sheenRoughnessFactor": 0.4}}}),
        ("anisotropy", {**textured, **rough, "metallic": 1.0}, {**textured, **rough, "metallic": 1.0, "extensions": brushed}),
        ("conductor", smooth, {**smooth, **rough, "extensions": gold}),
        ("measured", {**smooth, **rough, "extensions": gold}, {
            **smooth, "extensions": {"EIKON_materials_measured": {"uri": "table.binary"}},
            "measured": {**rough, "extensions": gold}}),
        ("iridescence of plastic", {**smooth, **rough}, under_film({**smooth, **rough})),
        ("iridescence of metal", metal, under_film(metal)),
        ("iridescence of a conductor", {**smooth, **rough, "extensions": gold}, under_film({**smooth, **rough, "extensions": gold})),
        ("iridescence of rough glass", {**smooth, **rough, "extensions": solid}, under_film({**smooth, **rough, "extensions": solid})),
        ("transmission, thin", {**smooth, **rough}, {**smooth, **rough, "extensions": glass}),
        ("transmission, solid and rough", {**smooth, **rough}, {**smooth, **rough, "extensions": solid}),
        ("transmission, solid and smooth", {**smooth, **rough}, {**smooth, **rough, "roughness": 0.0, "extensions": solid}),
        ("diffuse transmission", {**smooth, **rough}, {**smooth, **rough, "extensions": {
            "KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.5}}}),
        ("Blinn's highlights", smooth, {**smooth, "extensions": {"EIKON_materials_phong": {"specular": [0.3, 0.3, 0.3]}}}),
        ("dispersion", {**smooth, **rough, "roughness": 0.0, "extensions": solid}, {**smooth, **rough, "roughness": 0.0, "extensions": {
            **solid, "KHR_materials_dispersion": {"dispersion": 1.0}}}),
        ("energy compensation of metal", metal, with_flags(metal)),
        ("energy compensation of brushed metal", {**textured, **metal, "extensions": brushed},
         with_flags({**textured, **metal, "extensions": brushed})),
        ("energy compensation of a conductor", {**smooth, **rough, "extensions": gold},
         with_flags({**smooth, **rough, "extensions": gold})),
        ("energy compensation of a thin wall", {**smooth, **rough, "extensions": glass},
         with_flags({**smooth, **rough, "extensions": glass})),
        ("energy compensation of glass", {**smooth, **rough, "extensions": solid},
         with_flags({**smooth, **rough, "extensions": solid})),
        ("energy compensation of metal under a film", under_film(metal), with_flags(under_film(metal))),
        ("energy compensation of a conductor under a film", under_film({**smooth, **rough, "extensions": gold}),
         with_flags(under_film({**smooth, **rough, "extensions": gold}))),
        ("absorption", {**smooth, **rough, "extensions": solid}, {**smooth, **rough, "extensions": tinted}),
        ("absorption by priority", {**smooth, **rough, "extensions": tinted}, {**smooth, **rough, "extensions": tinted, "extras": {
            "mediumPriority": 1}}),
        ("opacity, BLEND of a factor", smooth, {**smooth, "opacity": 0.5, "alphaMode": "BLEND"}),
        ("opacity, MASK of a texture", textured, {**textured, "baseColorTexture": "leaf", "alphaMode": "MASK"}),
        ("unlit", smooth, {**smooth, "extensions": {"KHR_materials_unlit": {}}}),
        ("point light", lambert, {"lights": ["point"]}),
        ("spot light", lambert, {"lights": ["spot"]}),
        ("directional light", lambert, {"lights": ["directional"]}),
        ("environment map", lambert, {"sky_map": True}),
        ("paths guided by 2^16 of a pilot", {**smooth, "flags": ["--guiding", "off"]}, {**smooth, "flags": ["--guiding", "65536"]}),
        ("light paths, a sixteenth", {**lamp, "flags": ["--light-paths", "off"]}, {**lamp, "flags": light_paths}),
        ("caustics by merging", {**lamp, "flags": light_paths}, {**lamp, "flags": [*light_paths, "--caustics", "merge"]}),
        ("one ball of twelve moves", {**smooth, "moving": 1}, {**smooth, "moving": 1, "flags": shutter}),
        ("all balls move", {**smooth, "moving": 12}, {**smooth, "moving": 12, "flags": shutter}),
        ("twelve materials", everything, {"smooth": True, "coordinates": True, "materials": twelve}),
    ]


def render(options, scene, flags, folder, spp):
    """(ns per sample, rays per sample, the device) of one render; with --cpu (ns of processor time, ...) of all samples."""
    stats = folder / "stats.json"
    command = [options.eikon, "render", scene, "-o", folder / "out.exr", "--size", options.size, "--spp", spp, "--max-depth", "4",
               "--stats", stats, "--quiet", *flags]
    if "merge" not in flags:  # which --strict does not allow, because it has a bias
        command.append("--strict")
    if options.devices:
        command += ["--devices", options.devices]
    user_ns = 1e9 * run_or_exit(*command).user_s
    found = json.loads(stats.read_text())
    return user_ns if options.cpu else 1e9 / found["samples_per_second"], found["rays"]["total"] / found["samples"], found["devices"][0]["name"]


def make_table(options, surface, folder):
    """table.binary in that folder, measured from a ball of this surface."""
    scene = folder / "known.gltf"
    Variant(**surface).write(scene)
    run_or_exit(options.eikon, "measure", scene, "--material", "ball 0", "-o", folder / "table.binary")


def measure(options, off, on):
    """Best times of both, taken in turns, so that what else the machine does falls on both."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        scenes = [folder / "off.gltf", folder / "on.gltf"]
        variants = [Variant(**off), Variant(**on)]
        for scene, variant in zip(scenes, variants):
            if variant.measured:
                make_table(options, variant.measured, folder)
            variant.write(scene)
            render(options, scene, variant.flags, folder, options.spp)  # compiles
        best, few, rays, device = [1e30, 1e30], [1e30, 1e30], [0.0, 0.0], ""
        few_spp = max(options.spp // 16, 1)
        for _ in range(options.rounds):
            for i in (0, 1):
                if options.cpu:
                    few[i] = min(few[i], render(options, scenes[i], variants[i].flags, folder, few_spp)[0])
                time_ns, rays[i], device = render(options, scenes[i], variants[i].flags, folder, options.spp)
                best[i] = min(best[i], time_ns)
        if options.cpu:
            width, height = map(int, options.size.split("x"))
            best = [(best[i] - few[i]) / (width * height * (options.spp - few_spp)) for i in (0, 1)]
    return best, rays, device


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_eikon_flag(parser)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--size", default="256x256")
    parser.add_argument("--devices", default="")
    parser.add_argument("--cpu", action="store_true", help="processor time instead of the clock's")
    parser.add_argument("--only", nargs="*", help="features whose names contain one of these")
    parser.add_argument("-o", "--output", help="Markdown file, else standard output")
    options = parser.parse_args()
    lines = []
    for name, off, on in features():
        if options.only and not any(part in name for part in options.only):
            continue
        best, rays, device = measure(options, off, on)
        lines.append(f"| {name} | {best[0]:.0f} | {best[1]:.0f} | {best[1] - best[0]:+.0f} | {best[0] / best[1]:.2f} | "
                     f"{rays[0]:.2f} | {rays[1]:.2f} |")
        print(lines[-1], file=sys.stderr, flush=True)
    if not lines:
        sys.exit("bench_features: --only names no feature")
    model = next((line.split(":", 1)[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")),
                 platform.machine())
    text = "\n".join([
        "# What features cost", "",
        f"Made by `tools/bench_features.py` on {device} ({model}, {os.cpu_count()} processors): {options.size}, "
        f"{options.spp} samples per pixel, best of {options.rounds}, in turns{', in processor time' if options.cpu else ''}.",
        "A scene that does not use a feature pays nothing: its code is not compiled (tests/zero_cost.py).", "",
        "| feature | off, ns per sample | on | difference | speed, on / off | rays per sample, off | on |",
        "|---|---|---|---|---|---|---|", *lines, ""])
    if options.output:
        pathlib.Path(options.output).write_text(text)
    else:
        print(text)


if __name__ == "__main__":
    main()
