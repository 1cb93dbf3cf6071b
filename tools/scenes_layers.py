# SPDX-License-Identifier: Apache-2.0
"""The shipped scenes of what lies on materials, and of materials beyond glTF's core. The first line of each docstring says what
the scene proves; it is kept in the file as well.
"""

import scene_pictures
from gltf_writer import GltfWriter
from scene_shapes import look_at
from scenes_materials import checker_floor, lamp, place, roughness_row, smooth_sphere, vase


def sheen(color, roughness):
    return {"KHR_materials_sheen": {"sheenColorFactor": list(color), "sheenRoughnessFactor": roughness}}


velvet = roughness_row(
    "velvet", "Sheen of roughness 0, 0.2, ... 1 under a sky and a lamp: velvet, with white fibres and coloured ones in turns.",
    lambda gltf, roughness, number: gltf.surface(
        f"velvet {roughness}", (0.25, 0.02, 0.05) if number % 2 else (0.02, 0.06, 0.2), roughness=1.0,
        extensions={**sheen((1.0, 0.5, 0.6) if number % 2 else (1.0, 1.0, 1.0), roughness),
                    "KHR_materials_specular": {"specularFactor": 0.0}}))


def lacquer():
    """Clearcoat: smooth lacquer on bumpy tiles, a coat that is bumpy itself, a rough one, lacquered metal and velvet."""
    gltf = GltfWriter(lacquer.__doc__)
    gltf.environment_map("sky.hdr", scene_pictures.sky())
    checker_floor(gltf, -8, 8, -8, 8, 0.5)
    lamp(gltf, (20.0, 19.0, 17.0), -0.5, 0.5, 0.5, 1.5, 3.5)
    bumps = gltf.texture("tiles normal", scene_pictures.tiles_normal())

    def coat(roughness, **more):
        return {"KHR_materials_clearcoat": {"clearcoatFactor": 1.0, "clearcoatRoughnessFactor": roughness, **more}}

    color = gltf.texture("tiles color", scene_pictures.tiles_color())
    tiles = gltf.surface("lacquered tiles", roughness=0.6, extensions=coat(0.0), doubleSided=True, baseColorTexture=color,
                         normalTexture=bumps)
    orange = gltf.surface("orange peel", (0.7, 0.2, 0.02), roughness=0.6, extensions=coat(0.0, clearcoatNormalTexture=bumps),
                          doubleSided=True)
    points, triangles, normals, uv, _ = vase(48, 24)
    for name, material, x in (("lacquered tiles", tiles, -2.1), ("orange peel", orange, -1.0)):
        gltf.mesh(name, [gltf.primitive(points, triangles, material, normals, uv)], translation=[x, 0.0, 0.0])
    satin = gltf.surface("satin lacquer", (0.02, 0.1, 0.05), roughness=0.6, extensions=coat(0.35))
    steel = gltf.surface("lacquered metal", (0.6, 0.05, 0.04), metallic=1.0, roughness=0.45, extensions=coat(0.0))
    fabric = gltf.surface("lacquered velvet", (0.15, 0.02, 0.2), roughness=1.0,
                          extensions={**coat(0.1), **sheen((0.8, 0.6, 1.0), 0.4)})
    ball = smooth_sphere(gltf, 4, satin)
    for name, material, x in (("satin", satin, 0.1), ("metal", steel, 1.2), ("velvet", fabric, 2.3)):
        place(gltf, name, ball, material, (x, 0.5, 0.0), 0.5)
    gltf.camera(0.36, 2.6, matrix=look_at((0.1, 1.8, 6.4), (0.1, 0.55, 0.0)))
    return gltf


MAKERS = {"velvet": velvet, "lacquer": lacquer}
