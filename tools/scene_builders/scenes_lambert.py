# SPDX-License-Identifier: Apache-2.0
"""The shipped scenes that are exactly Lambert. The first line of each docstring says what the scene proves; it is kept
in the file as well.
"""

from . import cornell_data
from .gltf_writer import GltfWriter
from .scene_shapes import box, field_of_view, inside_out, join, look_at, prism, quad, ring, sphere

BLACK = (0.0, 0.0, 0.0)
GREY = (0.5, 0.5, 0.5)


def cornell_walls(gltf):
    """The measured Cornell box without blocks and lamp. Returns (white material, lamp material, corners of the lamp)."""
    def metres(x, y, z):
        return (x / 1000, y / 1000, z / 1000)

    white = gltf.lambert("white", cornell_data.reflectance(cornell_data.WHITE))
    red = gltf.lambert("red", cornell_data.reflectance(cornell_data.RED))
    green = gltf.lambert("green", cornell_data.reflectance(cornell_data.GREEN))
    lamp = gltf.lambert("light", [cornell_data.LIGHT_REFLECTANCE] * 3, cornell_data.emission())

    # Corners named by left (large x, where the camera has its left) or right, floor or ceiling,
    # front or back.
    lff, rff, rfb, lfb = metres(552.8, 0, 0), metres(0, 0, 0), metres(0, 0, 559.2), metres(549.6, 0, 559.2)
    lcf, rcf, rcb, lcb = metres(556, 548.8, 0), metres(0, 548.8, 0), metres(0, 548.8, 559.2), metres(556, 548.8, 559.2)
    # Same turn as the ceiling's corners; the lamp fills the hole exactly, both at 548.8 as
    # measured.
    hole = [metres(343, 548.8, 227), metres(343, 548.8, 332), metres(213, 548.8, 332), metres(213, 548.8, 227)]

    gltf.mesh("floor", [gltf.primitive(*quad(lff, rff, rfb, lfb), white)])
    gltf.mesh("ceiling", [gltf.primitive(*ring([lcf, lcb, rcb, rcf], hole), white)])
    gltf.mesh("back wall", [gltf.primitive(*quad(lfb, rfb, rcb, lcb), white)])
    gltf.mesh("left wall", [gltf.primitive(*quad(lff, lfb, lcb, lcf), red)])
    gltf.mesh("right wall", [gltf.primitive(*quad(rfb, rff, rcf, rcb), green)])
    return white, lamp, hole


def cornell_camera(gltf):
    """Film 25 mm wide at 35 mm; half a turn about +Y looks along +Z."""
    gltf.camera(field_of_view(0.025, 0.035), 1.0, translation=[0.278, 0.273, -0.8], rotation=[0.0, 1.0, 0.0, 0.0])


def cornell():
    """Colour bleeding, soft shadow and indirect light of the measured Cornell box."""
    gltf = GltfWriter(cornell.__doc__)
    white, lamp, hole = cornell_walls(gltf)
    for name, height, base in (("short block", 165, [(130, 65), (82, 225), (240, 272), (290, 114)]),
                               ("tall block", 330, [(423, 247), (265, 296), (314, 456), (472, 406)])):
        gltf.mesh(name, [gltf.primitive(*prism([(x / 1000, z / 1000) for x, z in base], height / 1000), white)])
    gltf.mesh("light", [gltf.primitive(*quad(*hole), lamp)])
    cornell_camera(gltf)
    return gltf


def furnace():
    """Energy: a closed white box that emits 1 and reflects 0.8 shows 1 / (1 - 0.8) = 5 everywhere."""
    gltf = GltfWriter(furnace.__doc__)
    wall = gltf.lambert("wall", (0.8, 0.8, 0.8), (1.0, 1.0, 1.0))
    gltf.mesh("box", [gltf.primitive(*inside_out(box((-1, -1, -1), (1, 1, 1))), wall)])
    gltf.camera(1.0, 1.0, translation=[0.0, 0.0, 0.5])
    return gltf


def sphere_kd_half():
    """Energy: inside a closed sphere that emits 1/2 and reflects 1/2 everything is 1."""
    gltf = GltfWriter(sphere_kd_half.__doc__)
    wall = gltf.lambert("wall", GREY, GREY)
    gltf.mesh("sphere", [gltf.primitive(*inside_out(sphere(1.0, 2)), wall)])
    gltf.camera(1.0, 1.0, translation=[0.0, 0.0, 0.5])
    return gltf


def sphere_in_sky():
    """Environment light: a convex Lambert body under a sky of radiance 1 shows exactly its reflectance."""
    gltf = GltfWriter(sphere_in_sky.__doc__)
    gltf.environment((1.0, 1.0, 1.0))
    gltf.mesh("sphere", [gltf.primitive(*sphere(1.0, 2), gltf.lambert("body", (0.2, 0.5, 0.8)))])
    gltf.camera(0.5, 1.0, translation=[0.0, 0.0, 5.0])
    return gltf


def square_light():
    """Direct light: E / L = 0.752274688 under the middle of a unit square at height 1; shows 0.5 / pi of it."""
    gltf = GltfWriter(square_light.__doc__)
    floor = gltf.lambert("floor", GREY)
    lamp = gltf.lambert("light", BLACK, (1.0, 1.0, 1.0))
    gltf.mesh("floor", [gltf.primitive(*quad((-10, 0, 10), (10, 0, 10), (10, 0, -10), (-10, 0, -10)), floor)])
    gltf.mesh("light", [gltf.primitive(*quad((-0.5, 1, -0.5), (0.5, 1, -0.5), (0.5, 1, 0.5), (-0.5, 1, 0.5)), lamp)])
    gltf.camera(1e-4, 1.0, matrix=look_at((0.0, 0.5, 1.5), (0.0, 0.0, 0.0)))
    return gltf


# Corners of the lights of the Nori renderer's test-direct.xml (polylum1 to 5), and the radiance it
# lists for the floor at the origin; Lambert's formula for a polygon gives the same numbers.
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
        floor = gltf.lambert("floor", GREY)
        lamp = gltf.lambert("light", BLACK, (1.0, 1.0, 1.0))
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
    floor = gltf.lambert("floor", GREY)
    lamp = gltf.lambert("light", BLACK, (1.0, 1.0, 1.0))
    gltf.mesh("floor", [gltf.primitive(*quad((0, 0, 1), (1, 0, 1), (1, 0, 0), (0, 0, 0)), floor)])
    gltf.mesh("light", [gltf.primitive(*quad((0, 0, 1), (0, 0, 0), (0, 1, 0), (0, 1, 1)), lamp)])
    # The picture is exactly the floor, so its mean is the mean over the floor.
    gltf.camera(field_of_view(1.0, 2.0), 1.0, matrix=look_at((0.5, 2.0, 0.5), (0.5, 0.0, 0.5), up=(0.0, 0.0, -1.0)))
    return gltf


def coincident():
    """Ties: of two coincident triangles, emitting red and green, the first wins at every pixel, on every device."""
    gltf = GltfWriter(coincident.__doc__)
    red = gltf.lambert("red", BLACK, (1.0, 0.0, 0.0))
    green = gltf.lambert("green", BLACK, (0.0, 1.0, 0.0))
    triangle = ([(-1.0, -0.7, 0.1), (1.1, -0.6, -0.2), (0.1, 1.0, 0.3)], [(0, 1, 2)])
    gltf.mesh("pair", [gltf.primitive(*triangle, red), gltf.primitive(*triangle, green)])
    gltf.camera(0.7, 1.0, translation=[0.0, 0.0, 4.0])
    return gltf


def room_with_window(gltf, plaster, floor, right_wall, ground):
    """A room 4 m wide, 2.8 m high and 5 m deep with a window in its left wall, and the ground before it."""
    width, height, depth, wall = 4.0, 2.8, 5.0, 0.3
    window = {"y": (0.9, 2.1), "z": (-3.4, -1.8)}
    x0, x1, y0, y1, z0, z1 = 0.0, width, 0.0, height, -depth, 0.0
    gltf.mesh("floor", [gltf.primitive(*quad((x0, y0, z1), (x1, y0, z1), (x1, y0, z0), (x0, y0, z0)), floor)])
    gltf.mesh("ceiling", [gltf.primitive(*quad((x0, y1, z0), (x1, y1, z0), (x1, y1, z1), (x0, y1, z1)), plaster)])
    gltf.mesh("back wall", [gltf.primitive(*quad((x0, y0, z0), (x1, y0, z0), (x1, y1, z0), (x0, y1, z0)), plaster)])
    gltf.mesh("front wall", [gltf.primitive(*quad((x1, y0, z1), (x0, y0, z1), (x0, y1, z1), (x1, y1, z1)), plaster)])
    gltf.mesh("right wall", [gltf.primitive(*quad((x1, y0, z0), (x1, y0, z1), (x1, y1, z1), (x1, y1, z0)), right_wall)])
    (wy0, wy1), (wz0, wz1) = window["y"], window["z"]
    outer = [(x0, y0, z1), (x0, y0, z0), (x0, y1, z0), (x0, y1, z1)]
    inner = [(x0, wy0, wz1), (x0, wy0, wz0), (x0, wy1, wz0), (x0, wy1, wz1)]
    gltf.mesh("window wall", [gltf.primitive(*ring(outer, inner), plaster)])
    # The reveal: the wall's thickness, seen from inside the opening.
    beyond = [(-wall, y, z) for _, y, z in inner]
    reveal = [quad(inner[i], inner[(i + 1) % 4], beyond[(i + 1) % 4], beyond[i]) for i in range(4)]
    gltf.mesh("reveal", [gltf.primitive(*join(*reveal), plaster)])
    lawn = quad((-20, -0.3, 10), (-wall, -0.3, 10), (-wall, -0.3, -15), (-20, -0.3, -15))
    gltf.mesh("ground", [gltf.primitive(*lawn, ground)])


def window_room():
    """Mostly indirect light: a room that the sky lights only through a window."""
    gltf = GltfWriter(window_room.__doc__)
    gltf.environment((12.0, 14.0, 17.0))
    plaster = gltf.lambert("plaster", (0.75, 0.73, 0.7))
    wood = gltf.lambert("wood", (0.4, 0.25, 0.13))
    blue = gltf.lambert("blue", (0.1, 0.2, 0.5))
    clay = gltf.lambert("clay", (0.6, 0.25, 0.15))
    grass = gltf.lambert("grass", (0.15, 0.25, 0.08))

    room_with_window(gltf, plaster, wood, blue, grass)
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
