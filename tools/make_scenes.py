#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the scenes of scenes/, always the same bytes. Standard library only.

  tools/make_scenes.py             write every scene
  tools/make_scenes.py --check     fail if a committed scene differs from what this script makes
  tools/make_scenes.py --list      names, and what each proves
"""

import argparse
import math
import pathlib
import sys

import cornell_data
from gltf_writer import GltfWriter

SCENES = pathlib.Path(__file__).resolve().parent.parent / "scenes"
BLACK = (0.0, 0.0, 0.0)
GREY = (0.5, 0.5, 0.5)


# --- Geometry. Points are tuples in metres; faces are counter-clockwise seen from the side that is their front.

def quad(a, b, c, d):
    """A quadrilateral as (points, triangles)."""
    return [a, b, c, d], [(0, 1, 2), (0, 2, 3)]


def ring(outer, inner):
    """The quadrilateral `outer` with the hole `inner` (corners in the same order), no new points on either edge."""
    triangles = []
    for i in range(4):
        j = (i + 1) % 4
        triangles += [(i, j, 4 + j), (i, 4 + j, 4 + i)]
    return [*outer, *inner], triangles


def join(*shapes):
    """Several (points, triangles) as one."""
    points, triangles = [], []
    for more_points, more_triangles in shapes:
        base = len(points)
        points += more_points
        triangles += [tuple(base + i for i in t) for t in more_triangles]
    return points, triangles


def prism(base, height):
    """A block on y = 0: `base` [(x, z)] counter-clockwise seen from above (+x right, -z up); no bottom face."""
    low = [(x, 0.0, z) for x, z in base]
    high = [(x, height, z) for x, z in base]
    sides = [quad(low[i], low[(i + 1) % 4], high[(i + 1) % 4], high[i]) for i in range(4)]
    return join(quad(*high), *sides)


def box(lo, hi):
    """An axis-parallel box, all six faces, front outside."""
    (x0, y0, z0), (x1, y1, z1) = lo, hi
    return join(
        quad((x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)),  # +z
        quad((x1, y0, z0), (x0, y0, z0), (x0, y1, z0), (x1, y1, z0)),  # -z
        quad((x1, y0, z1), (x1, y0, z0), (x1, y1, z0), (x1, y1, z1)),  # +x
        quad((x0, y0, z0), (x0, y0, z1), (x0, y1, z1), (x0, y1, z0)),  # -x
        quad((x0, y1, z1), (x1, y1, z1), (x1, y1, z0), (x0, y1, z0)),  # +y
        quad((x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1)),  # -y
    )


def inside_out(shape):
    """The same surface with its front on the other side."""
    points, triangles = shape
    return points, [(a, c, b) for a, b, c in triangles]


def sphere(radius, subdivisions, centre=(0.0, 0.0, 0.0)):
    """A closed sphere by subdividing an icosahedron: 20 * 4^subdivisions triangles, front outside, shared points."""
    g = (1 + math.sqrt(5)) / 2
    points = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g), (0, -1, -g), (0, 1, -g),
              (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]
    triangles = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2),
                 (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11),
                 (6, 2, 10), (8, 6, 7), (9, 8, 1)]

    def unit(p):
        length = math.sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2])
        return (p[0] / length, p[1] / length, p[2] / length)

    points = [unit(p) for p in points]
    for _ in range(subdivisions):
        middle_of = {}

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middle_of:
                middle_of[key] = len(points)
                points.append(unit(tuple(p + q for p, q in zip(points[a], points[b]))))
            return middle_of[key]

        finer = []
        for a, b, c in triangles:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        triangles = finer
    return [tuple(radius * p + o for p, o in zip(point, centre)) for point in points], triangles


def look_at(eye, target, up=(0.0, 1.0, 0.0)):
    """matrix= of a camera at `eye` that looks at `target`, column by column as glTF has it."""
    def cross(a, b):
        return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])

    def unit(v):
        length = math.sqrt(sum(c * c for c in v))
        return tuple(c / length for c in v)

    back = unit(tuple(e - t for e, t in zip(eye, target)))
    right = unit(cross(up, back))
    return [*right, 0.0, *cross(back, right), 0.0, *back, 0.0, *eye, 1.0]


def field_of_view(size, distance):
    """Vertical field of view, radians, that sees `size` at `distance`; rounded so that every libm gives it."""
    return round(2 * math.atan2(size / 2, distance), 12)


# --- The scenes. The first line of each docstring says what the scene proves; it is kept in the file as well.

def cornell():
    """Colour bleeding, soft shadow and indirect light of the measured Cornell box."""
    def metres(x, y, z):
        return (x / 1000, y / 1000, z / 1000)

    gltf = GltfWriter(cornell.__doc__)
    white = gltf.material("white", cornell_data.reflectance(cornell_data.WHITE))
    red = gltf.material("red", cornell_data.reflectance(cornell_data.RED))
    green = gltf.material("green", cornell_data.reflectance(cornell_data.GREEN))
    lamp = gltf.material("light", [cornell_data.LIGHT_REFLECTANCE] * 3, cornell_data.emission())

    # Corners named by left (large x, where the camera has its left) or right, floor or ceiling, front or back.
    lff, rff, rfb, lfb = metres(552.8, 0, 0), metres(0, 0, 0), metres(0, 0, 559.2), metres(549.6, 0, 559.2)
    lcf, rcf, rcb, lcb = metres(556, 548.8, 0), metres(0, 548.8, 0), metres(0, 548.8, 559.2), metres(556, 548.8, 559.2)
    # Same turn as the ceiling's corners; the lamp fills the hole exactly, both at 548.8 as measured.
    hole = [metres(343, 548.8, 227), metres(343, 548.8, 332), metres(213, 548.8, 332), metres(213, 548.8, 227)]

    gltf.mesh("floor", [gltf.primitive(*quad(lff, rff, rfb, lfb), white)])
    gltf.mesh("ceiling", [gltf.primitive(*ring([lcf, lcb, rcb, rcf], hole), white)])
    gltf.mesh("back wall", [gltf.primitive(*quad(lfb, rfb, rcb, lcb), white)])
    gltf.mesh("left wall", [gltf.primitive(*quad(lff, lfb, lcb, lcf), red)])
    gltf.mesh("right wall", [gltf.primitive(*quad(rfb, rff, rcf, rcb), green)])
    for name, height, base in (("short block", 165, [(130, 65), (82, 225), (240, 272), (290, 114)]),
                               ("tall block", 330, [(423, 247), (265, 296), (314, 456), (472, 406)])):
        gltf.mesh(name, [gltf.primitive(*prism([(x / 1000, z / 1000) for x, z in base], height / 1000), white)])
    gltf.mesh("light", [gltf.primitive(*quad(*hole), lamp)])
    # Film 25 mm wide at 35 mm; half a turn about +Y looks along +Z.
    gltf.camera(field_of_view(0.025, 0.035), 1.0, translation=[0.278, 0.273, -0.8], rotation=[0.0, 1.0, 0.0, 0.0])
    return gltf


def furnace():
    """Energy: a closed white box that emits 1 and reflects 0.8 shows 1 / (1 - 0.8) = 5 everywhere."""
    gltf = GltfWriter(furnace.__doc__)
    wall = gltf.material("wall", (0.8, 0.8, 0.8), (1.0, 1.0, 1.0))
    gltf.mesh("box", [gltf.primitive(*inside_out(box((-1, -1, -1), (1, 1, 1))), wall)])
    gltf.camera(1.0, 1.0, translation=[0.0, 0.0, 0.5])
    return gltf


def sphere_kd_half():
    """Energy: inside a closed sphere that emits 1/2 and reflects 1/2 everything is 1."""
    gltf = GltfWriter(sphere_kd_half.__doc__)
    wall = gltf.material("wall", GREY, GREY)
    gltf.mesh("sphere", [gltf.primitive(*inside_out(sphere(1.0, 2)), wall)])
    gltf.camera(1.0, 1.0, translation=[0.0, 0.0, 0.5])
    return gltf


def sphere_in_sky():
    """Environment light: a convex Lambert body under a sky of radiance 1 shows exactly its reflectance."""
    gltf = GltfWriter(sphere_in_sky.__doc__)
    gltf.environment((1.0, 1.0, 1.0))
    gltf.mesh("sphere", [gltf.primitive(*sphere(1.0, 2), gltf.material("body", (0.2, 0.5, 0.8)))])
    gltf.camera(0.5, 1.0, translation=[0.0, 0.0, 5.0])
    return gltf


def square_light():
    """Direct light: E / L = 0.752274688 under the middle of a unit square at height 1; shows 0.5 / pi of it."""
    gltf = GltfWriter(square_light.__doc__)
    floor = gltf.material("floor", GREY)
    lamp = gltf.material("light", BLACK, (1.0, 1.0, 1.0))
    gltf.mesh("floor", [gltf.primitive(*quad((-10, 0, 10), (10, 0, 10), (10, 0, -10), (-10, 0, -10)), floor)])
    gltf.mesh("light", [gltf.primitive(*quad((-0.5, 1, -0.5), (0.5, 1, -0.5), (0.5, 1, 0.5), (-0.5, 1, 0.5)), lamp)])
    gltf.camera(1e-4, 1.0, matrix=look_at((0.0, 0.5, 1.5), (0.0, 0.0, 0.0)))
    return gltf


# Corners of the lights of the Nori renderer's test-direct.xml (polylum1 to 5), and the radiance it lists for the
# floor at the origin; Lambert's formula for a polygon gives the same numbers.
NORI_TRIANGLES = {
    1: (0.0898394, [(-0.443432, 0.596366, 0.495985), (-0.320397, 0.0677699, -0.229359),
                    (0.0341197, 0.11415, -0.343049)]),
    2: (0.02292, [(0.461963, 0.397843, 0.412747), (-0.0381582, 0.851323, -0.156872), (0.195443, 0.891957, -0.260672)]),
    3: (0.0534198, [(0.100871, 0.289075, -0.422609), (-0.308386, 0.629587, 0.423966), (-0.373132, 0.237287, 0.351592)]),
    4: (0.0205314, [(-0.17575, 0.639397, 0.151268), (0.318604, 0.732996, 0.459771), (0.139095, 0.294498, 0.478556)]),
    5: (0.26174, [(-0.17487, 0.447916, 0.367201), (-0.405259, 0.249607, -0.354079), (0.356029, 0.0918984, -0.132271)]),
}


def nori_triangle(number):
    """Returns the maker of the scene with Nori's triangle `number`."""
    radiance, corners = NORI_TRIANGLES[number]
    proves = f"Direct light of a slanted triangle over a floor of 0.5: the origin shows {radiance}."

    def make():
        gltf = GltfWriter(proves)
        floor = gltf.material("floor", GREY)
        lamp = gltf.material("light", BLACK, (1.0, 1.0, 1.0))
        gltf.mesh("floor", [gltf.primitive(*quad((-10, 0, 10), (10, 0, 10), (10, 0, -10), (-10, 0, -10)), floor)])
        a, b, c = corners
        u, v = [q - p for p, q in zip(a, b)], [q - p for p, q in zip(a, c)]
        normal = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
        faces_origin = sum(n * p for n, p in zip(normal, a)) < 0
        gltf.mesh("light", [gltf.primitive(corners, [(0, 1, 2) if faces_origin else (0, 2, 1)], lamp)])
        gltf.camera(1e-4, 1.0, matrix=look_at((0.0, 0.01, 0.0), (0.0, 0.0, 0.0), up=(0.0, 0.0, 1.0)))
        return gltf

    make.__doc__ = proves
    return make


def perpendicular_squares():
    """Form factor 0.2000438 of unit squares that share an edge: the mean is half of it, finite at the edge."""
    gltf = GltfWriter(perpendicular_squares.__doc__)
    floor = gltf.material("floor", GREY)
    lamp = gltf.material("light", BLACK, (1.0, 1.0, 1.0))
    gltf.mesh("floor", [gltf.primitive(*quad((0, 0, 1), (1, 0, 1), (1, 0, 0), (0, 0, 0)), floor)])
    gltf.mesh("light", [gltf.primitive(*quad((0, 0, 1), (0, 0, 0), (0, 1, 0), (0, 1, 1)), lamp)])
    # The picture is exactly the floor, so its mean is the mean over the floor.
    gltf.camera(field_of_view(1.0, 2.0), 1.0, matrix=look_at((0.5, 2.0, 0.5), (0.5, 0.0, 0.5), up=(0.0, 0.0, -1.0)))
    return gltf


def coincident():
    """Ties: of two coincident triangles, emitting red and green, the first wins at every pixel, on every device."""
    gltf = GltfWriter(coincident.__doc__)
    red = gltf.material("red", BLACK, (1.0, 0.0, 0.0))
    green = gltf.material("green", BLACK, (0.0, 1.0, 0.0))
    triangle = ([(-1.0, -0.7, 0.1), (1.1, -0.6, -0.2), (0.1, 1.0, 0.3)], [(0, 1, 2)])
    gltf.mesh("pair", [gltf.primitive(*triangle, red), gltf.primitive(*triangle, green)])
    gltf.camera(0.7, 1.0, translation=[0.0, 0.0, 4.0])
    return gltf


def window_room():
    """Mostly indirect light: a room that the sky lights only through a window."""
    gltf = GltfWriter(window_room.__doc__)
    gltf.environment((12.0, 14.0, 17.0))
    plaster = gltf.material("plaster", (0.75, 0.73, 0.7))
    wood = gltf.material("wood", (0.4, 0.25, 0.13))
    blue = gltf.material("blue", (0.1, 0.2, 0.5))
    clay = gltf.material("clay", (0.6, 0.25, 0.15))
    grass = gltf.material("grass", (0.15, 0.25, 0.08))

    width, height, depth, wall = 4.0, 2.8, 5.0, 0.3
    window = {"y": (0.9, 2.1), "z": (-3.4, -1.8)}
    x0, x1, y0, y1, z0, z1 = 0.0, width, 0.0, height, -depth, 0.0
    gltf.mesh("floor", [gltf.primitive(*quad((x0, y0, z1), (x1, y0, z1), (x1, y0, z0), (x0, y0, z0)), wood)])
    gltf.mesh("ceiling", [gltf.primitive(*quad((x0, y1, z0), (x1, y1, z0), (x1, y1, z1), (x0, y1, z1)), plaster)])
    gltf.mesh("back wall", [gltf.primitive(*quad((x0, y0, z0), (x1, y0, z0), (x1, y1, z0), (x0, y1, z0)), plaster)])
    gltf.mesh("front wall", [gltf.primitive(*quad((x1, y0, z1), (x0, y0, z1), (x0, y1, z1), (x1, y1, z1)), plaster)])
    gltf.mesh("right wall", [gltf.primitive(*quad((x1, y0, z0), (x1, y0, z1), (x1, y1, z1), (x1, y1, z0)), blue)])
    (wy0, wy1), (wz0, wz1) = window["y"], window["z"]
    outer = [(x0, y0, z1), (x0, y0, z0), (x0, y1, z0), (x0, y1, z1)]
    inner = [(x0, wy0, wz1), (x0, wy0, wz0), (x0, wy1, wz0), (x0, wy1, wz1)]
    gltf.mesh("window wall", [gltf.primitive(*ring(outer, inner), plaster)])
    # The reveal: the wall's thickness, seen from inside the opening.
    beyond = [(-wall, y, z) for _, y, z in inner]
    reveal = [quad(inner[i], inner[(i + 1) % 4], beyond[(i + 1) % 4], beyond[i]) for i in range(4)]
    gltf.mesh("reveal", [gltf.primitive(*join(*reveal), plaster)])
    ground = quad((-20, -0.3, 10), (-wall, -0.3, 10), (-wall, -0.3, -15), (-20, -0.3, -15))
    gltf.mesh("ground", [gltf.primitive(*ground, grass)])

    table = [box((1.5, 0.70, -3.6), (3.1, 0.75, -2.6))]
    table += [box((x, 0.0, z), (x + 0.06, 0.70, z + 0.06)) for x in (1.54, 3.0) for z in (-3.56, -2.7)]
    gltf.mesh("table", [gltf.primitive(*join(*table), wood)])
    gltf.mesh("ball", [gltf.primitive(*sphere(0.18, 2, (2.6, 0.93, -3.1)), clay)])
    gltf.mesh("crate", [gltf.primitive(*box((1.75, 0.75, -3.4), (2.1, 1.05, -3.05)), blue)])
    gltf.mesh("shelf", [gltf.primitive(*join(*[box((2.6, y, -5.0), (3.9, y + 0.04, -4.7)) for y in (1.3, 1.7)]), wood)])
    gltf.camera(0.95, 1.5, matrix=look_at((3.1, 1.55, -0.25), (1.75, 1.0, -3.6)))
    return gltf


MAKERS = {
    "cornell": cornell,
    "furnace": furnace,
    "sphere_kd_half": sphere_kd_half,
    "sphere_in_sky": sphere_in_sky,
    "square_light": square_light,
    **{f"nori_triangle_{n}": nori_triangle(n) for n in NORI_TRIANGLES},
    "perpendicular_squares": perpendicular_squares,
    "coincident": coincident,
    "window_room": window_room,
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 if a committed scene differs")
    parser.add_argument("--list", action="store_true", help="print each scene's name and what it proves")
    parser.add_argument("--out", type=pathlib.Path, default=SCENES, metavar="DIR", help="where to (default: scenes)")
    arguments = parser.parse_args()
    if arguments.list:
        for name, make in MAKERS.items():
            print(f"{name + '.gltf':28s} {make.__doc__}")
        return 0

    wrong = 0
    readme = (SCENES / "README.md").read_text() if arguments.check else ""
    for name, make in MAKERS.items():
        path, data = arguments.out / f"{name}.gltf", make().gltf()
        if not arguments.check:
            arguments.out.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
            continue
        if not path.exists() or path.read_bytes() != data:
            print(f"{path}: not what tools/make_scenes.py makes; run it, or undo the change", file=sys.stderr)
            wrong += 1
        if f"{name}.gltf" not in readme:
            print(f"scenes/README.md does not say what {name}.gltf proves", file=sys.stderr)
            wrong += 1
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
