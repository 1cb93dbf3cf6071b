#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes about fifty small glTF files of the kinds that people have: single assets without camera or light, assets that
glow a little, rooms, and each feature of glTF in the form in which exporters write it. Their first pictures are for eyes:

  tools/make_sample_files.py out/samples
  for f in out/samples/*.gl*; do eikon render $f -o out/$(basename $f).exr --png out/$(basename $f).png --size 160x120 --spp 16; done

The same bytes for the same arguments. Standard library only.
"""

import argparse
import base64
import json
import math
import pathlib
import struct

from scene_builders.gltf_writer import GltfWriter
from scene_builders.scene_pictures import png
from scene_builders.scene_shapes import box, inside_out, join, look_at, quad, sphere

WHITE, GREY, RED, BLUE, GREEN, WOOD = (0.8,) * 3, (0.4,) * 3, (0.8, 0.1, 0.08), (0.1, 0.2, 0.7), (0.15, 0.6, 0.2), (0.5, 0.3, 0.15)
SAMPLES = {}


def sample(make):
    """Registers a function that fills a writer (or returns finished bytes); its docstring says what the file is like."""
    SAMPLES[make.__name__] = make
    return make


def lathe(profile, segments=32):
    """A surface of revolution about +Y through [(radius, height)] from bottom to top, front outside."""
    points, triangles = [], []
    for radius, height in profile:
        for k in range(segments):
            angle = 2 * math.pi * k / segments
            points.append((radius * math.sin(angle), height, radius * math.cos(angle)))
    for row in range(len(profile) - 1):
        for k in range(segments):
            a, b = row * segments + k, row * segments + (k + 1) % segments
            triangles += [(a, b, b + segments), (a, b + segments, a + segments)]
    return points, triangles


def smooth(shape):
    """Normals of a shape: the mean over the faces of each point."""
    points, triangles = shape
    sums = [[0.0, 0.0, 0.0] for _ in points]
    for a, b, c in triangles:
        u = [points[b][i] - points[a][i] for i in range(3)]
        v = [points[c][i] - points[a][i] for i in range(3)]
        n = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        for k in (a, b, c):
            for i in range(3):
                sums[k][i] += n[i]
    lengths = [math.sqrt(sum(c * c for c in n)) or 1.0 for n in sums]
    return [tuple(c / length for c in n) for n, length in zip(sums, lengths)]


def globe_uv(points):
    """Texture coordinates around the origin."""
    return [(0.5 + math.atan2(x, z) / (2 * math.pi), 0.5 - math.asin(max(-1.0, min(1.0, y / math.sqrt(x * x + y * y + z * z)))) / math.pi)
            for x, y, z in points]


def moved(shape, by, scale=1.0):
    points, triangles = shape
    return [tuple(scale * p + d for p, d in zip(point, by)) for point in points], triangles


def checker(light=(230, 230, 230), dark=(60, 90, 160), cells=8, size=64):
    return png(size, size, lambda x, y: light if (x * cells // size + y * cells // size) % 2 else dark)


def solid_mesh(w, name, shape, material, **transform):
    w.mesh(name, [w.primitive(*shape, material, normals=smooth(shape))], **transform)


FLOOR = quad((-3, 0, 3), (3, 0, 3), (3, 0, -3), (-3, 0, -3))
BALL = sphere(0.5, 3)
VASE = lathe([(0.0, 0.0), (0.3, 0.0), (0.45, 0.3), (0.4, 0.6), (0.2, 0.9), (0.18, 1.1), (0.26, 1.2)])
CHAIR = join(box((-0.25, 0.42, -0.25), (0.25, 0.46, 0.25)), box((-0.25, 0.46, -0.25), (0.25, 1.0, -0.21)),
             *[box((x, 0, z), (x + 0.04, 0.42, z + 0.04)) for x in (-0.25, 0.21) for z in (-0.25, 0.21)])


# Single assets without camera or light.

@sample
def white_box(w):
    """A box of glTF's default material."""
    w.mesh("box", [{k: v for k, v in w.primitive(*box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)), 0).items() if k != "material"}])
    del w.root["materials"]


@sample
def white_vase(w):
    solid_mesh(w, "vase", VASE, w.material("china", WHITE, roughness=0.4))


@sample
def mirror_ball(w):
    """Everything it shows is its surroundings."""
    solid_mesh(w, "ball", BALL, w.material("chrome", WHITE, metallic=1.0, roughness=0.0))


@sample
def metal_balls(w):
    for k in range(5):
        material = w.material(f"metal {k}", (0.9, 0.6, 0.3), metallic=1.0, roughness=k / 4)
        solid_mesh(w, f"ball {k}", BALL, material, translation=[1.1 * k, 0, 0])


@sample
def glass_ball(w):
    solid_mesh(w, "ball", BALL, w.material("glass", (1, 1, 1), roughness=0.0, extensions={
        "KHR_materials_transmission": {"transmissionFactor": 1.0}, "KHR_materials_volume": {"thicknessFactor": 1.0}}))


@sample
def chair(w):
    w.mesh("chair", [w.primitive(*CHAIR, w.material("wood", WOOD, roughness=0.6))])


@sample
def flat_picture(w):
    """A single upright rectangle with a texture."""
    texture = w.texture("checker", checker())
    w.mesh("picture", [w.primitive(*quad((-0.8, 0, 0), (0.8, 0, 0), (0.8, 0.9, 0), (-0.8, 0.9, 0)),
                                   w.material("paint", baseColorTexture=texture), uv=[(0, 1), (1, 1), (1, 0), (0, 0)])])


@sample
def floor_alone(w):
    w.mesh("floor", [w.primitive(*FLOOR, w.material("stone", GREY))])


@sample
def tall_tower(w):
    w.mesh("tower", [w.primitive(*box((-0.5, 0, -0.5), (0.5, 20, 0.5)), w.material("brick", RED))])


@sample
def long_bridge(w):
    w.mesh("bridge", [w.primitive(*join(box((-30, 1, -1), (30, 1.3, 1)), *[box((x, 0, -0.3), (x + 0.5, 1, 0.3)) for x in range(-30, 31, 6)]),
                                  w.material("steel", BLUE))])


@sample
def tiny_bolt(w):
    """In metres, as the specification wants it: two millimetres."""
    solid_mesh(w, "bolt", moved(lathe([(0, 0), (1, 0), (1, 0.6), (0.5, 0.6), (0.5, 2.5), (0, 2.5)], 6), (0, 0, 0), 0.001),
               w.material("steel", GREY, metallic=1.0, roughness=0.4))


@sample
def huge_in_millimetres(w):
    """A chair whose author worked in millimetres."""
    w.mesh("chair", [w.primitive(*moved(CHAIR, (0, 0, 0), 1000.0), w.material("wood", WOOD))])


@sample
def far_from_the_origin(w):
    w.mesh("chair", [w.primitive(*CHAIR, w.material("wood", WOOD))], translation=[5000, 200, -7000])


@sample
def many_parts_deep_in_the_graph(w):
    mesh = w.mesh_alone("link", [w.primitive(*box((-0.1, 0, -0.1), (0.1, 0.9, 0.1)), w.material("arm", GREEN))])
    w.place_mesh("link 0", mesh)
    for k in range(1, 8):
        w.root["nodes"].append({"name": f"link {k}", "mesh": mesh, "translation": [0, 1, 0], "rotation": [0, 0, math.sin(0.2), math.cos(0.2)]})
        w.root["nodes"][-2]["children"] = [len(w.root["nodes"]) - 1]


# Assets that glow a little, and are black by their own light.

@sample
def helmet_with_glowing_marks(w):
    """Its emissive texture is black but for a few marks."""
    marks = w.texture("marks", png(64, 64, lambda x, y: (255, 200, 80) if 30 <= y < 33 and x % 16 < 3 else (0, 0, 0)))
    material = w.material("shell", GREY, metallic=0.6, roughness=0.4, emissiveTexture=marks, emissiveFactor=[1, 1, 1])
    w.mesh("helmet", [w.primitive(*BALL, material, normals=smooth(BALL), uv=globe_uv(BALL[0]))])


@sample
def bottle_with_a_black_emissive_texture(w):
    black = w.texture("black", png(4, 4, lambda x, y: (0, 0, 0)))
    material = w.material("bottle", BLUE, roughness=0.3, emissiveTexture=black, emissiveFactor=[1, 1, 1])
    w.mesh("bottle", [w.primitive(*VASE, material, normals=smooth(VASE), uv=globe_uv([(x, y + 0.01, z) for x, y, z in VASE[0]]))])


@sample
def lamp_with_a_hidden_bulb(w):
    """A barn lamp: the bulb stands in an opaque shade that opens downwards."""
    shade = lathe([(0.6, 0.0), (0.2, 0.5), (0.0, 0.6)])
    solid_mesh(w, "shade", shade, w.material("enamel", RED, roughness=0.5, doubleSided=True), translation=[0, 0.5, 0])
    solid_mesh(w, "bulb", sphere(0.08, 2, (0, 0.8, 0)), w.material("bulb", WHITE, emission=(8, 7, 5)))


@sample
def toy_car_with_head_lamps(w):
    body = join(box((-1, 0.2, -0.45), (1, 0.5, 0.45)), box((-0.5, 0.5, -0.4), (0.5, 0.85, 0.4)))
    w.mesh("car", [w.primitive(*body, w.material("paint", RED, roughness=0.3))])
    for z in (-0.3, 0.3):
        solid_mesh(w, "lamp", sphere(0.06, 2, (1.0, 0.35, z)), w.material("lamp", WHITE, emission=(1, 1, 0.8)))
    for x in (-0.6, 0.6):
        for z in (-0.45, 0.45):
            solid_mesh(w, "wheel", sphere(0.2, 2, (x, 0.2, z)), w.material("rubber", (0.05,) * 3))


@sample
def radio_with_a_display(w):
    w.mesh("radio", [w.primitive(*box((-0.6, 0, -0.2), (0.6, 0.5, 0.2)), w.material("case", GREY))])
    w.mesh("display", [w.primitive(*quad((-0.2, 0.3, 0.21), (0.1, 0.3, 0.21), (0.1, 0.4, 0.21), (-0.2, 0.4, 0.21)),
                                   w.material("display", WHITE, emission=(0.1, 0.9, 0.4)))])


@sample
def neon_sign(w):
    """Nothing but light."""
    w.mesh("sign", [w.primitive(*join(box((-1, 0, 0), (-0.9, 1, 0.1)), box((-0.9, 0, 0), (-0.3, 0.1, 0.1)), box((0, 0, 0), (0.1, 1, 0.1))),
                                w.material("tube", WHITE, emission=(1, 0.2, 0.6)))])


# Files with light of their own, which get no other.

@sample
def room_with_a_ceiling_lamp(w):
    """Single-sided walls, whose fronts are inside: the camera looks in from outside."""
    w.mesh("room", [w.primitive(*inside_out(box((-2, 0, -2), (2, 2.5, 2))), w.material("wall", WHITE))])
    w.mesh("lamp", [w.primitive(*quad((-0.4, 2.45, -0.4), (0.4, 2.45, -0.4), (0.4, 2.45, 0.4), (-0.4, 2.45, 0.4)),
                                w.material("lamp", WHITE, emission=(12, 12, 11)))])
    w.mesh("table", [w.primitive(*box((-0.6, 0, -0.6), (0.6, 0.75, 0.6)), w.material("wood", WOOD))])


@sample
def room_seen_from_inside(w):
    room_with_a_ceiling_lamp(w)
    w.camera(1.0, 4 / 3, matrix=look_at((1.6, 1.4, 1.7), (0, 0.7, 0)))


@sample
def desk_lamp_on_a_floor(w):
    w.mesh("floor", [w.primitive(*FLOOR, w.material("floor", WHITE))])
    solid_mesh(w, "lamp", sphere(0.15, 2, (0, 1, 0)), w.material("lamp", WHITE, emission=(30, 28, 22)))


@sample
def point_lights(w):
    w.mesh("floor", [w.primitive(*FLOOR, w.material("floor", WHITE))])
    solid_mesh(w, "ball", moved(BALL, (0, 0.5, 0)), w.material("ball", BLUE))
    w.punctual_light("left", "point", (1, 0.6, 0.4), 20.0, translation=[-2, 2, 1])
    w.punctual_light("right", "point", (0.4, 0.6, 1), 20.0, translation=[2, 2, 1])


@sample
def spot_on_a_stage(w):
    w.mesh("floor", [w.primitive(*FLOOR, w.material("floor", WHITE))])
    solid_mesh(w, "singer", moved(VASE, (0, 0, 0)), w.material("dress", RED))
    turn = math.sin(-math.pi / 4), math.cos(-math.pi / 4)
    w.punctual_light("spot", "spot", (1, 1, 1), 60.0, {"innerConeAngle": 0.15, "outerConeAngle": 0.2},
                     translation=[0, 4, 0], rotation=[turn[0], 0, 0, turn[1]])


@sample
def sun(w):
    w.mesh("floor", [w.primitive(*FLOOR, w.material("floor", WHITE))])
    w.mesh("chair", [w.primitive(*CHAIR, w.material("wood", WOOD))])
    w.punctual_light("sun", "directional", (1, 0.95, 0.85), 3.0, rotation=[-0.35, 0.3, 0.1, 0.88])


@sample
def light_of_no_intensity(w):
    w.mesh("chair", [w.primitive(*CHAIR, w.material("wood", WOOD))])
    w.punctual_light("off", "point", (1, 1, 1), 0.0, translation=[0, 2, 0])


@sample
def unlit_toon(w):
    solid_mesh(w, "ball", BALL, w.material("toon", GREEN, extensions={"KHR_materials_unlit": {}}))


# Features, as exporters write them.

@sample
def vertex_colors(w):
    primitive = w.primitive(*BALL, w.material("painted", (1, 1, 1)), normals=smooth(BALL))
    primitive["attributes"]["COLOR_0"] = w.vertex_colors([tuple(c + 0.5 for c in p) for p in BALL[0]])
    w.mesh("ball", [primitive])


@sample
def no_normals(w):
    """Facets, as the specification says."""
    w.mesh("ball", [w.primitive(*sphere(0.5, 1), w.material("facets", RED))])


@sample
def leaf_with_cut_outs(w):
    leaf = w.texture("leaf", png(64, 64, lambda x, y: (60, 160, 50, 255 if (x - 32) ** 2 + (y - 32) ** 2 * 2 < 900 else 0)))
    material = w.material("leaf", alphaMode="MASK", doubleSided=True, baseColorTexture=leaf)
    w.mesh("leaf", [w.primitive(*quad((-1, 0, 0), (1, 0, 0), (1, 1, -0.3), (-1, 1, -0.3)), material,
                                uv=[(0, 1), (1, 1), (1, 0), (0, 0)])])
    w.mesh("floor", [w.primitive(*FLOOR, w.material("floor", WHITE))])


@sample
def panes_that_blend(w):
    for k in range(3):
        tint = w.material(f"tint {k}", (RED, GREEN, BLUE)[k], opacity=0.4, alphaMode="BLEND", doubleSided=True)
        w.mesh(f"pane {k}", [w.primitive(*quad((-1, 0, 0), (1, 0, 0), (1, 1, 0), (-1, 1, 0)), tint)],
               translation=[0.3 * k, 0.2 * k, -0.5 * k])


@sample
def single_sided_backs(w):
    """The left square shows its front; the right one its back, and is not seen."""
    square = quad((-0.5, 0, 0), (0.5, 0, 0), (0.5, 1, 0), (-0.5, 1, 0))
    paint = w.material("front", GREEN)
    w.mesh("front", [w.primitive(*square, paint)], translation=[-0.6, 0, 0])
    w.mesh("back", [w.primitive(*square, w.material("back", RED))], translation=[0.6, 0, 0], rotation=[0, 1, 0, 0])
    w.mesh("floor", [w.primitive(*FLOOR, w.material("floor", WHITE))])


@sample
def mirrored_node(w):
    """A negative scale turns the winding, not the front."""
    w.mesh("chair", [w.primitive(*CHAIR, w.material("wood", WOOD))])
    w.mesh("twin", [w.primitive(*CHAIR, w.material("dark", GREY))], scale=[-1, 1, 1], translation=[0.8, 0, 0])


@sample
def texture_settings(w):
    """Clamped, mirrored and repeated, nearest and linear."""
    for k, (wrap, mag) in enumerate([(10497, 9729), (33071, 9729), (33648, 9728)]):
        texture = w.texture("checker", checker(cells=4, size=8), sampler={"wrapS": wrap, "wrapT": wrap, "magFilter": mag})
        material = w.material(f"wrap {k}", baseColorTexture=texture)
        w.mesh(f"square {k}", [w.primitive(*quad((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)), material,
                                           uv=[(-0.5, 1.5), (1.5, 1.5), (1.5, -0.5), (-0.5, -0.5)])], translation=[1.1 * k, 0, 0])


@sample
def texture_transform(w):
    texture = w.texture("checker", checker(), transform={"scale": [3, 3], "rotation": 0.4, "offset": [0.1, 0.2]})
    w.mesh("ball", [w.primitive(*BALL, w.material("cloth", baseColorTexture=texture), normals=smooth(BALL), uv=globe_uv(BALL[0]))])


@sample
def normal_map(w):
    bumps = w.texture("bumps", png(64, 64, lambda x, y: (127.5 + 80 * math.sin(x / 4), 127.5 + 80 * math.sin(y / 4), 220)))
    w.mesh("plate", [w.primitive(*quad((-1, 0, 0), (1, 0, 0), (1, 1, 0), (-1, 1, 0)),
                                 w.material("bumpy", GREY, metallic=1.0, roughness=0.3, normalTexture=bumps),
                                 normals=[(0, 0, 1)] * 4, uv=[(0, 1), (1, 1), (1, 0), (0, 0)])])


def material_ball(name, **arguments):
    """A ball on a floor, of a material with extensions."""
    def make(w):
        solid_mesh(w, "ball", moved(BALL, (0, 0.5, 0)), w.material(name, **arguments))
        w.mesh("floor", [w.primitive(*FLOOR, w.material("floor", GREY))])
    make.__name__ = name
    return sample(make)


material_ball("clearcoat", color=RED, roughness=0.6, extensions={"KHR_materials_clearcoat": {"clearcoatFactor": 1.0}})
material_ball("sheen", color=BLUE, extensions={"KHR_materials_sheen": {"sheenColorFactor": [0.9, 0.9, 1.0], "sheenRoughnessFactor": 0.4}})
material_ball("iridescence", color=GREY, metallic=1.0, roughness=0.15, extensions={"KHR_materials_iridescence": {"iridescenceFactor": 1.0}})
material_ball("anisotropy", color=GREY, metallic=1.0, roughness=0.4, extensions={"KHR_materials_anisotropy": {"anisotropyStrength": 0.9}})
material_ball("thin_glass", color=(0.7, 0.9, 0.8), roughness=0.0, extensions={"KHR_materials_transmission": {"transmissionFactor": 0.9}})
material_ball("amber", color=(1, 1, 1), roughness=0.1, extensions={
    "KHR_materials_transmission": {"transmissionFactor": 1.0},
    "KHR_materials_volume": {"thicknessFactor": 1.0, "attenuationColor": [0.9, 0.5, 0.1], "attenuationDistance": 0.3}})
material_ball("specular_glossiness", color=(1, 1, 1), metallic=1.0, extensions={
    "KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [0.6, 0.1, 0.1, 1.0], "specularFactor": [0.2, 0.2, 0.2], "glossinessFactor": 0.7}})


@sample
def morph_target(w):
    """A bulge at three quarters of its weight."""
    primitive = w.primitive(*BALL, w.material("clay", WOOD), normals=smooth(BALL))
    target = [(0.0, 0.6 * max(0.0, p[1]), 0.0) for p in BALL[0]]
    primitive["targets"] = [{"POSITION": w._vectors(struct.pack(f"<{3 * len(target)}f", *[c for p in target for c in p]))}]
    w.mesh("blob", [primitive])
    w.root["meshes"][-1]["weights"] = [0.75]


@sample
def hidden_node(w):
    """KHR_node_visibility: the red ball is not shown."""
    solid_mesh(w, "ball", BALL, w.material("blue", BLUE))
    solid_mesh(w, "hidden", BALL, w.material("red", RED), translation=[1.2, 0, 0])
    w.root["nodes"][-1]["extensions"] = {"KHR_node_visibility": {"visible": False}}
    w._use_extension("KHR_node_visibility")


@sample
def instances(w):
    tree = w.mesh_alone("tree", [w.primitive(*lathe([(0.0, 0.0), (0.3, 0.3), (0.0, 1.0)], 8), w.material("leaf", GREEN))])
    places = [(x * 0.8, 0.0, z * 0.8) for x in range(8) for z in range(8)]
    w.instances("forest", tree, struct.pack(f"<{3 * len(places)}f", *[c for p in places for c in p]),
                struct.pack("<4f", 0, 0, 0, 1) * len(places), struct.pack("<3f", 1, 1, 1) * len(places))


@sample
def orthographic_camera(w):
    w.mesh("chair", [w.primitive(*CHAIR, w.material("wood", WOOD))])
    w.root["cameras"] = [{"type": "orthographic", "orthographic": {"xmag": 0.8, "ymag": 0.6, "znear": 0.01, "zfar": 100}}]
    w._node({"name": "view", "camera": 0, "matrix": list(look_at((2, 1.5, 2), (0, 0.5, 0)))})


@sample
def points_and_lines(w):
    """What is not drawn is named, and the rest shows."""
    primitive = w.primitive(*BALL, w.material("ball", BLUE))
    w.mesh("ball", [primitive, {"attributes": primitive["attributes"], "mode": 0}])


@sample
def upper_case_data_uri(w):
    """DATA:...;BASE64, and integers written with a point."""
    w.mesh("chair", [w.primitive(*CHAIR, w.material("wood", WOOD))])
    root = {**w.root, "buffers": [{"byteLength": float(len(w.buffer)), "uri": "DATA:application/octet-stream;BASE64,"
                                   + base64.b64encode(w.buffer).decode()}]}
    return json.dumps(root).encode()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    args = parser.parse_args()
    args.folder.mkdir(parents=True, exist_ok=True)
    for name, make in SAMPLES.items():
        writer = GltfWriter(make.__doc__ or name.replace("_", " "))
        finished = make(writer)
        if finished is None:
            writer.write(args.folder / f"{name}.gltf")
        else:
            (args.folder / f"{name}.gltf").write_bytes(finished)


if __name__ == "__main__":
    main()
