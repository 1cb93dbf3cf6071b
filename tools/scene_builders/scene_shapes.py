# SPDX-License-Identifier: Apache-2.0
"""Geometry of the shipped scenes. Points are tuples in metres; faces are counter-clockwise seen from the side that is
their front. Standard library only.
"""

import math


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
