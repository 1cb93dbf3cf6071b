# SPDX-License-Identifier: Apache-2.0
"""Furnished rooms whose light takes long ways. The first line of each docstring says what the scene proves; it is
kept in the file as well.
"""

import math

from .gltf_writer import GltfWriter
from .scenes_materials import place, smooth_sphere, solid
from .scene_shapes import box, inside_out, join, look_at, quad, ring, sphere

WIDTH, HEIGHT, DEPTH = 4.6, 2.7, 5.2  # of the rooms, metres; from (0, 0, -DEPTH) to (WIDTH, HEIGHT, 0)
WINDOW = (0.8, 2.2, -4.2, -2.2)  # as `shell` takes it


def finishes(gltf):
    """The materials of both rooms by name."""
    materials = {name: gltf.lambert(name, color) for name, color in {
        "plaster": (0.76, 0.74, 0.7), "cloth": (0.35, 0.4, 0.3), "wool": (0.55, 0.3, 0.18), "paper": (0.7, 0.66, 0.55),
        "red": (0.5, 0.09, 0.07), "blue": (0.08, 0.16, 0.4), "ochre": (0.6, 0.38, 0.1), "soil": (0.2, 0.3, 0.1)}.items()}
    materials["oak"] = gltf.material("oak", (0.42, 0.27, 0.14), 0.0, 0.45)
    materials["glaze"] = gltf.material("glaze", (0.1, 0.35, 0.4), 0.0, 0.25)
    return materials


def shell(gltf, materials, window=None):
    """Floor, ceiling and walls. window: (low y, high y, low z, high z) of a hole in the left wall."""
    x, y, z = WIDTH, HEIGHT, -DEPTH
    gltf.mesh("floor", [gltf.primitive(*quad((0, 0, 0), (x, 0, 0), (x, 0, z), (0, 0, z)), materials["oak"])])
    walls = [quad((0, y, z), (x, y, z), (x, y, 0), (0, y, 0)), quad((0, 0, z), (x, 0, z), (x, y, z), (0, y, z)),
             quad((x, 0, 0), (0, 0, 0), (0, y, 0), (x, y, 0)), quad((x, 0, z), (x, 0, 0), (x, y, 0), (x, y, z))]
    left = [(0, 0, 0), (0, 0, z), (0, y, z), (0, y, 0)]
    if window is None:
        walls.append(quad(*left))
    else:
        y0, y1, z0, z1 = window
        inner = [(0, y0, z1), (0, y0, z0), (0, y1, z0), (0, y1, z1)]
        beyond = [(-0.25, b, c) for _, b, c in inner]
        walls.append(ring(left, inner))
        walls += [quad(inner[i], inner[(i + 1) % 4], beyond[(i + 1) % 4], beyond[i]) for i in range(4)]
    gltf.mesh("walls", [gltf.primitive(*join(*walls), materials["plaster"])])


def table(gltf, materials, x, z):
    """A low table with a bowl, a ball and two books on it, its middle at (x, z)."""
    parts = [box((x - 0.55, 0.40, z - 0.35), (x + 0.55, 0.44, z + 0.35))]
    parts += [box((x + i - 0.03, 0.0, z + j - 0.03), (x + i + 0.03, 0.40, z + j + 0.03)) for i in (-0.5, 0.5) for j in (-0.3, 0.3)]
    gltf.mesh("table", [gltf.primitive(*join(*parts), materials["oak"])])
    gltf.mesh("vase", [gltf.primitive(*sphere(0.12, 2, (x - 0.28, 0.56, z - 0.1)), materials["glaze"])])
    gltf.mesh("ball", [gltf.primitive(*sphere(0.07, 2, (x + 0.05, 0.51, z + 0.16)), materials["red"])])
    gltf.mesh("books on the table", [
        gltf.primitive(*box((x + 0.15, 0.44, z - 0.2), (x + 0.42, 0.48, z - 0.01)), materials["blue"]),
        gltf.primitive(*box((x + 0.18, 0.48, z - 0.18), (x + 0.4, 0.51, z - 0.03)), materials["ochre"])])


def sofa(gltf, materials, x, z):
    """A sofa against the right wall, its far left corner at (x, z), with two cushions."""
    parts = [box((x, 0.0, z), (x + 0.9, 0.38, z + 1.9)), box((x + 0.65, 0.38, z), (x + 0.9, 0.85, z + 1.9)),
             box((x, 0.38, z), (x + 0.65, 0.58, z + 0.2)), box((x, 0.38, z + 1.7), (x + 0.65, 0.58, z + 1.9))]
    gltf.mesh("sofa", [gltf.primitive(*join(*parts), materials["cloth"])])
    cushions = [box((x + 0.45, 0.38, z + 0.3 + i), (x + 0.63, 0.74, z + 0.75 + i)) for i in (0.0, 0.8)]
    gltf.mesh("cushions", [gltf.primitive(*join(*cushions), materials["wool"])])


def rug(gltf, materials, x, z):
    """A rug, its middle at (x, z)."""
    gltf.mesh("rug", [gltf.primitive(*box((x - 1.1, 0.0, z - 0.8), (x + 1.1, 0.015, z + 0.8)), materials["wool"])])


def shelf(gltf, materials, x0, x1, z, backed):
    """A shelf with four rows of books that stands with its front at z, 0.3 m deep. backed: closed behind."""
    top = 1.9
    parts = [box((x0, 0.0, z - 0.3), (x0 + 0.03, top, z)), box((x1 - 0.03, 0.0, z - 0.3), (x1, top, z))]
    boards = [0.06 + 0.45 * row for row in range(5)]
    parts += [box((x0 + 0.03, y, z - 0.3), (x1 - 0.03, y + 0.03, z)) for y in boards]
    if backed:
        parts.append(box((x0 + 0.03, 0.0, z - 0.3), (x1 - 0.03, top, z - 0.29)))
    gltf.mesh("shelf", [gltf.primitive(*join(*parts), materials["oak"])])
    books = {name: [] for name in ("red", "blue", "ochre", "paper")}
    names = list(books)
    for row, y in enumerate(boards[:-1]):
        x, number = x0 + 0.05, 0
        while x < x1 - 0.3 - 0.2 * (row % 2):
            # Sizes that look like chance, and are the same everywhere.
            turn = (7 * number + 5 * row) % 11
            width, height, depth = 0.03 + 0.004 * turn, 0.26 + 0.012 * ((3 * turn) % 11), 0.18 + 0.008 * (turn % 5)
            books[names[(number + row + turn // 4) % 4]].append(
                box((x, y + 0.03, z - 0.285), (x + width, y + 0.03 + height, z - 0.285 + depth)))
            x, number = x + width + 0.003, number + 1
    gltf.mesh("books", [gltf.primitive(*join(*shapes), materials[name]) for name, shapes in books.items()])


def shelf_lamp_room():
    """Light by way of a wall: the lamp of a furnished room hides behind a shelf, and no ray from the room meets it."""
    gltf = GltfWriter(shelf_lamp_room.__doc__)
    materials = finishes(gltf)
    shell(gltf, materials)
    lamp = gltf.lambert("lamp", (0.0, 0.0, 0.0), (90.0, 72.0, 50.0))
    back = -DEPTH + 0.35  # of the shelf, with a gap behind it
    shelf(gltf, materials, 1.1, 3.3, back + 0.3, backed=True)
    # A strip on the back of the shelf, 1.6 m wide and 6 cm high, that faces the wall.
    gltf.mesh("lamp", [gltf.primitive(*quad((3.0, 1.5, back - 0.01), (1.4, 1.5, back - 0.01), (1.4, 1.56, back - 0.01),
                                            (3.0, 1.56, back - 0.01)), lamp)])
    table(gltf, materials, 2.1, -2.5)
    rug(gltf, materials, 2.1, -2.5)
    sofa(gltf, materials, WIDTH - 0.95, -3.5)
    frames = [box((0.0, 1.2, -1.7 - i), (0.03, 1.8, -1.2 - i)) for i in (0.0, 0.8)]
    gltf.mesh("pictures", [gltf.primitive(*join(*frames), materials["ochre"])])
    gltf.camera(0.85, 1.5, matrix=look_at((1.0, 1.45, -0.2), (2.5, 0.95, -4.2)))
    return gltf


def ground_and_furniture(gltf, materials):
    """The ground before the window, and what stands in a room that has one."""
    lawn = quad((-20, -0.3, 10), (-0.25, -0.3, 10), (-0.25, -0.3, -15), (-20, -0.3, -15))
    gltf.mesh("ground", [gltf.primitive(*lawn, materials["soil"])])
    shelf(gltf, materials, 1.2, 3.0, -DEPTH + 0.31, backed=False)
    table(gltf, materials, 2.0, -2.7)
    rug(gltf, materials, 2.0, -2.7)
    sofa(gltf, materials, WIDTH - 0.95, -3.7)


def blind_room():
    """Light through slits: the sky reaches a furnished room between the slats of a blind."""
    gltf = GltfWriter(blind_room.__doc__)
    materials = finishes(gltf)
    gltf.environment((20.0, 23.0, 28.0))
    y0, y1, z0, z1 = WINDOW
    shell(gltf, materials, WINDOW)
    slat = gltf.lambert("slat", (0.65, 0.63, 0.58))
    # Slats of 8 cm every 7 cm, tilted by 55 degrees with the room's side up, half way through the
    # wall.
    reach, rise, thick = round(0.04 * math.cos(math.radians(55)), 6), round(0.04 * math.sin(math.radians(55)), 6), 0.004
    slats = []
    for i in range(20):
        y = y0 + 0.035 + 0.07 * i
        low = [(-0.12 - reach, y - rise, z1), (-0.12 + reach, y + rise, z1), (-0.12 + reach, y + rise, z0), (-0.12 - reach, y - rise, z0)]
        high = [(a, b + thick, c) for a, b, c in low]
        slats.append(join(quad(*high), inside_out(quad(*low)),
                          *[quad(low[k], low[(k + 1) % 4], high[(k + 1) % 4], high[k]) for k in range(4)]))
    gltf.mesh("blind", [gltf.primitive(*join(*slats), slat)])
    ground_and_furniture(gltf, materials)
    gltf.camera(0.85, 1.5, matrix=look_at((3.7, 1.5, -0.2), (1.55, 0.95, -3.9)))
    return gltf


def glazed_room():
    """The sun through a pane: only light paths find it, and what it lights up lights a furnished room."""
    gltf = GltfWriter(glazed_room.__doc__)
    materials = finishes(gltf)
    gltf.environment((0.9, 1.2, 1.7))
    y0, y1, z0, z1 = WINDOW
    shell(gltf, materials, WINDOW)
    gltf.punctual_light("sun", "directional", (1.0, 0.9, 0.75), 60.0,
                        matrix=look_at((-0.75, 0.6, 0.2), (0.0, 0.0, 0.0)))
    glass = gltf.material("glass", roughness=0.0, extensions=solid(1.5))
    # Half way through the wall, and a little larger than the hole.
    gltf.mesh("pane", [gltf.primitive(*box((-0.13, y0 - 0.01, z0 - 0.01), (-0.12, y1 + 0.01, z1 + 0.01)), glass)])
    ground_and_furniture(gltf, materials)
    ball = smooth_sphere(gltf, 3, glass)
    place(gltf, "glass ball", ball, glass, (1.2, 0.2, -3.5), 0.2)
    gltf.camera(0.85, 1.5, matrix=look_at((3.7, 1.5, -0.2), (1.55, 0.95, -3.9)))
    return gltf


MAKERS = {
    "shelf_lamp_room": shelf_lamp_room,
    "blind_room": blind_room,
    "glazed_room": glazed_room,
}
