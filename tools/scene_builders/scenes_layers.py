# SPDX-License-Identifier: Apache-2.0
"""The shipped scenes of what lies on materials, and of materials beyond glTF's core. The first line of each docstring says what
the scene proves; it is kept in the file as well.
"""

import math

from . import scene_pictures
from .gltf_writer import GltfWriter
from .scene_shapes import join, look_at, quad
from .scenes_materials import checker_floor, lamp, place, roughness_row, smooth_sphere, solid, vase


def sheen(color, roughness):
    return {"KHR_materials_sheen": {"sheenColorFactor": list(color), "sheenRoughnessFactor": roughness}}


velvet = roughness_row(
    "velvet", "Sheen of roughness 0, 0.2, ... 1 under a sky and a lamp: velvet, with white fibres and coloured ones in turns.",
    lambda gltf, roughness, number: gltf.material(
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
    tiles = gltf.material("lacquered tiles", roughness=0.6, extensions=coat(0.0), doubleSided=True, baseColorTexture=color,
                          normalTexture=bumps)
    orange = gltf.material("orange peel", (0.7, 0.2, 0.02), roughness=0.6, extensions=coat(0.0, clearcoatNormalTexture=bumps),
                           doubleSided=True)
    points, triangles, normals, uv, _ = vase(48, 24)
    for name, material, x in (("lacquered tiles", tiles, -2.1), ("orange peel", orange, -1.0)):
        gltf.mesh(name, [gltf.primitive(points, triangles, material, normals, uv)], translation=[x, 0.0, 0.0])
    satin = gltf.material("satin lacquer", (0.02, 0.1, 0.05), roughness=0.6, extensions=coat(0.35))
    steel = gltf.material("lacquered metal", (0.6, 0.05, 0.04), metallic=1.0, roughness=0.45, extensions=coat(0.0))
    fabric = gltf.material("lacquered velvet", (0.15, 0.02, 0.2), roughness=1.0,
                           extensions={**coat(0.1), **sheen((0.8, 0.6, 1.0), 0.4)})
    ball = smooth_sphere(gltf, 4, satin)
    for name, material, x in (("satin", satin, 0.1), ("metal", steel, 1.2), ("velvet", fabric, 2.3)):
        place(gltf, name, ball, material, (x, 0.5, 0.0), 0.5)
    gltf.camera(0.36, 2.6, matrix=look_at((0.1, 1.8, 6.4), (0.1, 0.55, 0.0)))
    return gltf


def prism():
    """Dispersion: a prism of flint glass, and balls of dispersion 0, 1 and 5, before stripes and lamps."""
    gltf = GltfWriter(prism.__doc__)
    gltf.environment((0.25, 0.25, 0.28))
    checker_floor(gltf, -6, 6, -6, 6, 0.3)
    lamp(gltf, (60.0, 60.0, 60.0), -0.25, 0.25, -0.25, 0.25, 4.0)
    for i in range(-6, 7):
        x = 0.5 * i
        gltf.mesh(f"stripe {i}", [gltf.primitive(*quad((x, 0, -3), (x + 0.12, 0, -3), (x + 0.12, 3, -3), (x, 3, -3)),
                                                 gltf.lambert(f"stripe {i}", (0, 0, 0), (4.0, 4.0, 4.0)))])

    def flint(dispersion):
        return gltf.material(f"dispersion {dispersion}", roughness=0.0,
                             extensions={**solid(1.62), "KHR_materials_dispersion": {"dispersion": dispersion}})

    a, b, c = (-0.65, 0.02), (0.65, 0.02), (0.0, 1.15)
    near, far = 0.45, -0.45
    faces = [[(a[0], a[1], near), (b[0], b[1], near), (c[0], c[1], near)], [(b[0], b[1], far), (a[0], a[1], far), (c[0], c[1], far)]]
    sides = [quad((p[0], p[1], far), (q[0], q[1], far), (q[0], q[1], near), (p[0], p[1], near)) for p, q in ((a, b), (b, c), (c, a))]
    points, triangles = join(*((corners, [(0, 1, 2)]) for corners in faces), *sides)
    gltf.mesh("prism", [gltf.primitive(points, triangles, flint(0.6))], translation=[-1.1, 0.0, 0.0],
              rotation=[0.0, 0.258819045, 0.0, 0.965925826])
    ball = smooth_sphere(gltf, 4, 0)
    for dispersion, x in ((0.0, 0.15), (1.0, 1.15), (5.0, 2.15)):
        place(gltf, f"ball {dispersion}", ball, flint(dispersion), (x, 0.47, 0.0), 0.45)
    gltf.camera(0.4, 2.0, matrix=look_at((0.45, 1.3, 5.6), (0.45, 0.6, 0.0)))
    return gltf


def plate(segments):
    """A disc in the xz plane as (points, triangles, normals, uv, tangents), its tangents around it as on turned metal."""
    points, normals, uv, tangents = [(0.0, 0.0, 0.0)], [(0.0, 1.0, 0.0)], [(0.5, 0.5)], [(1.0, 0.0, 0.0, 1.0)]
    rings = (0.02, 1.0)
    for r in rings:
        for i in range(segments):
            phi = 2 * math.pi * i / segments
            s, c = round(math.sin(phi), 9), round(math.cos(phi), 9)
            points.append((r * c, 0.0, r * s))
            normals.append((0.0, 1.0, 0.0))
            uv.append((0.5 + 0.5 * r * c, 0.5 + 0.5 * r * s))
            tangents.append((-s, 0.0, c, 1.0))
    triangles = []
    for i in range(segments):
        j = (i + 1) % segments
        triangles += [(0, 1 + j, 1 + i), (1 + i, 1 + j, 1 + segments + i), (1 + j, 1 + segments + j, 1 + segments + i)]
    return points, triangles, normals, uv, tangents


def brushed_metal():
    """Anisotropy: turned discs whose highlights fan out, and balls brushed along and around, of steel and by metals' indices."""
    gltf = GltfWriter(brushed_metal.__doc__)
    gltf.environment_map("sky.hdr", scene_pictures.sky())
    checker_floor(gltf, -8, 8, -8, 8, 0.5)
    lamp(gltf, (25.0, 24.0, 22.0), -0.4, 0.4, -1.4, -0.6, 3.0)

    def brushed(strength, rotation=0.0, **more):
        return {"KHR_materials_anisotropy": {"anisotropyStrength": strength, "anisotropyRotation": rotation}, **more}

    def metal(name):
        return {"EIKON_materials_conductor": {"metal": name}}

    steel = gltf.material("turned steel", (0.75, 0.75, 0.78), metallic=1.0, roughness=0.2, extensions=brushed(0.8))
    copper = gltf.material("turned copper", roughness=0.2, extensions=brushed(0.8, **metal("Cu")))
    points, triangles, normals, uv, tangents = plate(96)
    for name, material, x in (("steel disc", steel, -0.75), ("copper disc", copper, 0.75)):
        gltf.mesh(name, [gltf.primitive(points, triangles, material, normals, uv, tangents)],
                  translation=[x, 0.35, 0.75], rotation=[0.130526192, 0.0, 0.0, 0.991444861], scale=[0.7, 0.7, 0.7])
    points, triangles, normals, uv, _ = vase(48, 24)
    for name, material, x in (
            ("gold, around",
             gltf.material("gold, around", roughness=0.25, doubleSided=True, extensions=brushed(0.9, **metal("Au"))), -1.8),
            ("gold, along", gltf.material("gold, along", roughness=0.25, doubleSided=True,
                                          extensions=brushed(0.9, round(math.pi / 2, 9), **metal("Au"))), -0.6),
            ("aluminium, not brushed", gltf.material("aluminium", roughness=0.25, doubleSided=True, extensions=metal("Al")), 0.6),
            ("plastic, along", gltf.material("brushed plastic", (0.05, 0.1, 0.3), roughness=0.3, doubleSided=True,
                                             extensions=brushed(0.9, round(math.pi / 2, 9))), 1.8)):
        gltf.mesh(name, [gltf.primitive(points, triangles, material, normals, uv)], translation=[x, 0.0, -0.7])
    gltf.camera(0.42, 2.0, matrix=look_at((0.0, 2.2, 5.6), (0.0, 0.5, 0.0)))
    return gltf


def paper():
    """Diffuse transmission: a lantern, sheets that pass 0, 0.25, ... 1 of the light behind them; variants: white, coloured."""
    gltf = GltfWriter(paper.__doc__)
    gltf.variants(("white", "coloured"))
    gltf.environment((0.06, 0.07, 0.09))
    checker_floor(gltf, -6, 6, -6, 6, 0.4)
    back = quad((-3.2, 2.6, -2.0), (3.2, 2.6, -2.0), (3.2, 3.2, -1.2), (-3.2, 3.2, -1.2))
    lamp = gltf.lambert("lamp", (0, 0, 0), (9.0, 8.5, 8.0), True)
    gltf.mesh("lamp behind", [gltf.primitive(back[0], [t[::-1] for t in back[1]], lamp)])

    def sheet(name, share, color, through):
        return gltf.material(name, color, roughness=0.7, extensions={"KHR_materials_diffuse_transmission": {
            "diffuseTransmissionFactor": share, "diffuseTransmissionColorFactor": list(through)}})

    for i in range(5):
        share = 0.25 * i
        white = sheet(f"white {share:g}", share, (0.85, 0.85, 0.85), (0.85, 0.85, 0.85))
        leaf = sheet(f"leaf {share:g}", share, (0.15, 0.35, 0.05), (0.45, 0.75, 0.05))
        x = -2.2 + 1.1 * i
        corners = quad((x - 0.45, 0.05, 0.0), (x + 0.45, 0.05, 0.0), (x + 0.45, 1.25, -0.3), (x - 0.45, 1.25, -0.3))
        gltf.mesh(f"sheet {share:g}", [gltf.variant_of(gltf.primitive(*corners, white), (white, leaf))])
    rice = sheet("rice paper", 0.5, (0.9, 0.9, 0.9), (0.9, 0.9, 0.9))
    red = sheet("red paper", 0.5, (0.6, 0.1, 0.05), (0.9, 0.15, 0.05))
    ball = smooth_sphere(gltf, 4, rice)
    gltf.mesh("lantern", [gltf.variant_of(ball, (rice, red))], translation=[0.6, 0.45, 1.5], scale=[0.45, 0.45, 0.45])
    bulb = gltf.lambert("bulb", (0, 0, 0), (40.0, 34.0, 26.0))
    place(gltf, "bulb", ball, bulb, (0.6, 0.45, 1.5), 0.1)
    gltf.camera(0.5, 2.0, matrix=look_at((0.0, 1.5, 6.2), (0.0, 0.55, 0.0)))
    return gltf


MAKERS = {"velvet": velvet, "lacquer": lacquer, "brushed_metal": brushed_metal, "prism": prism, "paper": paper}
