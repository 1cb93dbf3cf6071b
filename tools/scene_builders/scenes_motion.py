# SPDX-License-Identifier: Apache-2.0
"""The shipped scenes that move. The first line of each docstring says what the scene proves; it is kept in the file as well.
"""

import math

from .gltf_writer import GltfWriter
from .scene_shapes import box, join, look_at, quad, sphere

DIGITS = 7  # of what sines and roots give, so that every libm gives the same file


def rounded(vector):
    return tuple(round(c, DIGITS) for c in vector)


def turn(axis, degrees):
    """The quaternion (x, y, z, w) of a turn about axis 0, 1 or 2."""
    half = math.radians(degrees) / 2
    vector = [0.0, 0.0, 0.0]
    vector[axis] = math.sin(half)
    return rounded((*vector, math.cos(half)))


def unit(v):
    length = math.sqrt(sum(c * c for c in v))
    return tuple(c / length for c in v)


def stage(gltf, size, light_height):
    """A floor, a sky that fills shadows, and a square light above, which faces down."""
    gltf.environment((0.25, 0.3, 0.4))
    floor = gltf.lambert("floor", (0.55, 0.5, 0.45))
    gltf.mesh("floor", [gltf.primitive(*quad((-size, 0, size), (size, 0, size), (size, 0, -size), (-size, 0, -size)), floor)])
    lamp = gltf.lambert("lamp", (0.0, 0.0, 0.0), (14.0, 13.0, 11.0))
    h, s = light_height, 0.6
    corners = ((-s, h, -s + 0.8), (s, h, -s + 0.8), (s, h, s + 0.8), (-s, h, s + 0.8))
    gltf.mesh("lamp", [gltf.primitive(*quad(*corners), lamp)])


def arm_surface(rings, around, height):
    """A limb along +Y that narrows: points, normals, triangles, and the share of each point's way along it."""
    points, normals, along = [], [], []
    for i in range(rings):
        y = height * i / (rings - 1)
        radius, slope = 0.2 - 0.11 * y / height, 0.11 / height
        for k in range(around):
            angle = 2 * math.pi * k / around
            c, s = math.cos(angle), math.sin(angle)
            points.append(rounded((radius * c, y, radius * s)))
            normals.append(rounded(unit((c, slope, s))))
            along.append(y)
    triangles = []
    for i in range(rings - 1):
        for k in range(around):
            a, b = i * around + k, i * around + (k + 1) % around
            triangles += [(a, a + around, b), (b, a + around, b + around)]
    tip = len(points)
    points.append((0.0, height + 0.05, 0.0))
    normals.append((0.0, 1.0, 0.0))
    along.append(height)
    last = (rings - 1) * around
    triangles += [(last + k, tip, last + (k + 1) % around) for k in range(around)]
    return points, normals, triangles, along


def bending_arm():
    """Skin: an arm of three joints bends at the elbow and waves, smooth where two joints share a point."""
    gltf = GltfWriter(bending_arm.__doc__)
    stage(gltf, 3.0, 3.2)
    starts = (0.0, 0.7, 1.3)
    points, normals, triangles, along = arm_surface(29, 20, 1.8)
    joints, weights = [], []
    for y in along:
        share = [0, 0, 0, 0]
        upper = sum(1 for start in starts[1:] if y > start + 0.15)
        blend = next((round(255 * (y - start + 0.15) / 0.3) for start in starts[1:] if abs(y - start) <= 0.15), 0)
        share[upper], share[upper + 1] = 255 - blend, blend
        joints.append((0, 1, 2, 0))
        weights.append(share)
    skin_color = gltf.material("skin", (0.8, 0.35, 0.2), roughness=0.5)
    primitive = gltf.primitive(points, triangles, skin_color, normals)
    primitive["attributes"].update(gltf.joint_weights(joints, weights))
    shoulder = gltf.joint("shoulder")
    elbow = gltf.joint("elbow", shoulder, translation=[0.0, starts[1], 0.0])
    wrist = gltf.joint("wrist", elbow, translation=[0.0, starts[2] - starts[1], 0.0])
    binds = [[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -start, 0.0, 1.0] for start in starts]
    gltf.mesh("arm", [primitive], skin=gltf.skin("arm", [shoulder, elbow, wrist], binds))
    gltf.channel("wave", {"node": shoulder, "path": "rotation"}, [0.0, 1.0, 2.0], [turn(2, 0), turn(2, 35), turn(2, 0)])
    gltf.channel("wave", {"node": elbow, "path": "rotation"}, [0.0, 0.5, 1.0, 1.5, 2.0],
                 [turn(2, a) for a in (0, -60, -110, -60, 0)])
    still = (0.0, 0.0, 0.0, 0.0)
    spline = [part for angle in (0, 40, -40, 40, 0) for part in (still, turn(2, angle), still)]
    gltf.channel("wave", {"node": wrist, "path": "rotation"}, [0.0, 0.5, 1.0, 1.5, 2.0], spline, "CUBICSPLINE")
    gltf.camera(0.6, 1.5, matrix=[round(c, DIGITS) for c in look_at((1.2, 1.6, 4.6), (0.0, 0.95, 0.0))])
    return gltf


def blob_surface(around, rows, radius_of):
    """Points of a surface around the origin, and its normals: radius_of(unit direction) metres away."""
    def point(u, v):
        polar, angle = math.pi * v, 2 * math.pi * u
        d = (math.sin(polar) * math.cos(angle), math.cos(polar), math.sin(polar) * math.sin(angle))
        r = radius_of(d)
        return tuple(r * c for c in d)

    points, normals = [], []
    for j in range(rows + 1):
        for i in range(around + 1):
            u, v, e = i / around, min(max(j / rows, 1e-3), 1 - 1e-3), 1e-4
            across = tuple(a - b for a, b in zip(point(u + e, v), point(u - e, v)))
            down = tuple(a - b for a, b in zip(point(u, v + e), point(u, v - e)))
            n = (across[1] * down[2] - across[2] * down[1], across[2] * down[0] - across[0] * down[2],
                 across[0] * down[1] - across[1] * down[0])
            points.append(rounded(point(u, j / rows)))
            normals.append(tuple(round(c, 5) for c in unit(n)))
    return points, normals


def morphing_blob():
    """Morph targets: a ball swells to a star and flattens to a cushion, positions and normals, by the weights of its node."""
    gltf = GltfWriter(morphing_blob.__doc__)
    stage(gltf, 3.0, 3.0)
    around, rows = 28, 16
    ball = blob_surface(around, rows, lambda d: 0.6)
    star = blob_surface(around, rows, lambda d: 0.6 + 0.25 * math.cos(5 * math.atan2(d[2], d[0])) * (1 - d[1] * d[1]))
    cushion = blob_surface(around, rows, lambda d: 0.75 / math.sqrt(1 + 3 * d[1] * d[1]))
    triangles = []
    for j in range(rows):
        for i in range(around):
            a, b = j * (around + 1) + i, (j + 1) * (around + 1) + i
            triangles += [] if j == 0 else [(a, a + 1, b)]
            triangles += [] if j == rows - 1 else [(a + 1, b + 1, b)]
    paint = gltf.material("paint", (0.15, 0.45, 0.75), roughness=0.3)
    primitive = gltf.primitive(ball[0], triangles, paint, ball[1])

    def differences(shape):
        return [[rounded(b - a for a, b in zip(p, q)) for p, q in zip(ball[k], shape[k])] for k in (0, 1)]

    primitive["targets"] = [gltf.morph_target(*differences(star)), gltf.morph_target(*differences(cushion))]
    gltf.mesh("blob", [primitive], translation=[0.0, 0.9, 0.0], weights=[0.0, 0.0])
    mesh = gltf.root["meshes"][-1]
    mesh["extras"] = {"targetNames": ["star", "cushion"]}
    gltf.channel("breathe", {"node": gltf.node_index("blob"), "path": "weights"}, [0.0, 0.75, 1.5, 2.25, 3.0],
                 [0.0, 0.0, 1.0, 0.0, 0.5, 0.5, 0.0, 1.0, 0.0, 0.0])
    gltf.camera(0.6, 1.5, matrix=[round(c, DIGITS) for c in look_at((1.5, 2.2, 3.6), (0.0, 0.8, 0.0))])
    return gltf


def wheel(gltf, material, hub):
    """A wheel of radius 0.5 about the Z axis: a tyre, six spokes and a hub."""
    around, section = 48, 10
    points, normals, triangles = [], [], []
    for i in range(around):
        a = 2 * math.pi * i / around
        for k in range(section):
            b = 2 * math.pi * k / section
            r = 0.42 + 0.08 * math.cos(b)
            points.append(rounded((r * math.cos(a), r * math.sin(a), 0.08 * math.sin(b))))
            normals.append(rounded((math.cos(b) * math.cos(a), math.cos(b) * math.sin(a), math.sin(b))))
            c, d = i * section + k, i * section + (k + 1) % section
            e, f = (c + section) % (around * section), (d + section) % (around * section)
            triangles += [(c, e, d), (d, e, f)]
    spokes = []
    for i in range(6):
        c, s = math.cos(math.pi * i / 3), math.sin(math.pi * i / 3)
        corners, faces = box((0.06, -0.025, -0.02), (0.38, 0.025, 0.02))
        spokes.append(([rounded((c * x - s * y, s * x + c * y, z)) for x, y, z in corners], faces))
    spokes.append(box((-0.07, -0.07, -0.05), (0.07, 0.07, 0.05)))
    return gltf.mesh_alone("wheel", [gltf.primitive(points, triangles, material, normals), gltf.primitive(*join(*spokes), hub)])


def spinning_wheel():
    """Nodes, a camera and materials: a wheel rolls without slipping, the camera follows, and a lamp changes its colour."""
    gltf = GltfWriter(spinning_wheel.__doc__)
    stage(gltf, 4.0, 3.0)
    rubber = gltf.material("rubber", (0.03, 0.03, 0.035), roughness=0.6)
    brass = gltf.material("brass", (0.9, 0.7, 0.35), metallic=1.0, roughness=0.3)
    gltf.place_mesh("wheel", wheel(gltf, rubber, brass), translation=[-1.5, 0.5, 0.0])
    glow = gltf.lambert("glow", (0.0, 0.0, 0.0), (6.0, 1.0, 0.5))
    gltf.mesh("sign", [gltf.primitive(*box((-0.3, 0.0, -0.05), (0.3, 0.9, 0.05)), glow)], translation=[0.0, 0.0, -1.2])
    node = gltf.node_index("wheel")
    length = round(math.pi, DIGITS)  # of a whole turn at radius 0.5
    times = [0.0, 0.5, 1.0, 1.5, 2.0]
    gltf.channel("roll", {"node": node, "path": "translation"}, [0.0, 2.0], [(-1.5, 0.5, 0.0), (-1.5 + length, 0.5, 0.0)])
    gltf.channel("roll", {"node": node, "path": "rotation"}, times, [turn(2, -90 * i) for i in range(5)])
    gltf.channel("blink", f"/materials/{glow}/emissiveFactor", [0.0, 1.0, 2.0],
                 [(1.0, 1.0 / 6, 0.5 / 6), (0.1, 0.5, 1.0), (1.0, 1.0 / 6, 0.5 / 6)], "STEP")
    eye = (0.0, 1.1, 3.6)
    gltf.camera(0.75, 1.5, translation=list(eye), rotation=list(turn(0, -10)))
    camera = gltf.node_index("camera")
    gltf.channel("follow", {"node": camera, "path": "translation"}, [0.0, 2.0], [(-0.7, 1.1, 3.6), (0.7, 1.1, 3.6)])
    return gltf


def camera_path():
    """A camera alone moves: it flies once around still things, by CUBICSPLINE, turns by slerp, and zooms in and out."""
    gltf = GltfWriter(camera_path.__doc__)
    stage(gltf, 3.0, 3.2)
    clay = gltf.material("clay", (0.7, 0.3, 0.2), roughness=0.7)
    steel = gltf.material("steel", (0.75, 0.75, 0.78), metallic=1.0, roughness=0.25)
    enamel = gltf.material("enamel", (0.1, 0.3, 0.6), roughness=0.4)
    gltf.mesh("pillar", [gltf.primitive(*box((-0.25, 0.0, -0.25), (0.25, 1.2, 0.25)), clay)], rotation=list(turn(1, 30)))
    points, triangles = sphere(0.4, 3)
    points = [rounded(p) for p in points]
    ball = gltf.primitive(points, triangles, steel, [tuple(round(c / 0.4, 5) for c in p) for p in points])
    gltf.mesh("ball", [ball], translation=[0.9, 0.4, 0.3])
    gltf.mesh("block", [gltf.primitive(*box((-0.35, 0.0, -0.3), (0.35, 0.5, 0.3)), enamel)], translation=[-0.9, 0.0, 0.2])
    radius, height, middle, keys, length_s = 4.0, 1.6, 0.6, 8, 4.0
    down, speed = math.degrees(math.atan((height - middle) / radius)), 2 * math.pi / length_s
    x, w = math.sin(math.radians(-down) / 2), math.cos(math.radians(-down) / 2)
    times, places, turns = [], [], []
    for i in range(keys + 1):
        angle = 2 * math.pi * i / keys
        s, c = math.sin(angle), math.cos(angle)
        along = rounded((radius * speed * c, 0.0, -radius * speed * s))
        places += [along, rounded((radius * s, height, radius * c)), along]
        # Turned down first, and then around the upright axis.
        half_s, half_c = math.sin(angle / 2), math.cos(angle / 2)
        turns.append(rounded((half_c * x, half_s * w, -half_s * x, half_c * w)))
        times.append(length_s * i / keys)
    gltf.camera(0.6, 1.5, translation=list(places[1]), rotation=list(turns[0]))
    camera = gltf.node_index("camera")
    gltf.channel("fly", {"node": camera, "path": "translation"}, times, places, "CUBICSPLINE")
    gltf.channel("fly", {"node": camera, "path": "rotation"}, times, turns)
    gltf.channel("fly", "/cameras/0/perspective/yfov", [0.0, 2.0, 4.0], [0.6, 0.35, 0.6])
    return gltf


MAKERS = {make.__name__: make for make in (bending_arm, camera_path, morphing_blob, spinning_wheel)}
