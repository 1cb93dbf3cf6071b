# SPDX-License-Identifier: Apache-2.0
"""A figure that walks: a skin of thirteen joints, coarse for scenes/ and dense for measurements. Standard library only."""

import math

from .gltf_writer import GltfWriter
from .scene_shapes import look_at
from .scenes_motion import DIGITS, rounded, stage, turn

# Each part of the body is an upright tube at rest: its place, heights of its ends, half widths in x
# and z, and the joints along it with the height at which each begins to hold, from the first end
# on.
PARTS = (
    ("torso", 0.0, 0.9, 1.46, 0.17, 0.105, (("hips", 0.9), ("chest", 1.12))),
    ("head", 0.0, 1.44, 1.8, 0.085, 0.1, (("chest", 1.44), ("head", 1.53))),
    ("left arm", 0.235, 1.42, 0.74, 0.052, 0.052, (("left shoulder", 1.42), ("left elbow", 1.08))),
    ("right arm", -0.235, 1.42, 0.74, 0.052, 0.052, (("right shoulder", 1.42), ("right elbow", 1.08))),
    ("left leg", 0.095, 0.95, 0.0, 0.078, 0.085, (("left hip", 0.95), ("left knee", 0.48), ("left ankle", 0.09))),
    ("right leg", -0.095, 0.95, 0.0, 0.078, 0.085, (("right hip", 0.95), ("right knee", 0.48), ("right ankle", 0.09))),
)
# name: (parent, place at rest)
JOINTS = {
    "hips": (None, (0.0, 0.95, 0.0)),
    "chest": ("hips", (0.0, 1.12, 0.0)),
    "head": ("chest", (0.0, 1.53, 0.0)),
    **{f"{side} {joint}": (parent if parent in ("chest", "hips") else f"{side} {parent}", (sign * x, y, 0.0))
       for side, sign in (("left", 1.0), ("right", -1.0))
       for joint, parent, x, y in (("shoulder", "chest", 0.2, 1.4), ("elbow", "shoulder", 0.235, 1.08),
                                   ("hip", "hips", 0.095, 0.92), ("knee", "hip", 0.095, 0.48),
                                   ("ankle", "knee", 0.095, 0.09))},
}
BLEND_M = 0.06  # above and below a joint within which it takes over
WALK_S, SPEED = 2.0, 1.3


def tube(part, rings, around):
    """Points, normals, triangles, joints and weights of a part, closed by half ellipsoids at both ends."""
    _, x, begin, end, half_x, half_z, held = part
    names = list(JOINTS)
    points, normals, joints, weights = [], [], [], []
    for i in range(rings + 1):
        share = i / rings
        y = begin + (end - begin) * share
        # A superellipse along the tube: nearly straight sides, round ends.
        s = 2 * share - 1
        width = max(1 - abs(s) ** 6, 0.0) ** 0.5
        slope = (-3 * abs(s) ** 5 * math.copysign(1, s) / max(width, 1e-3)) * 2 / (end - begin)
        holder = max(k for k, (_, from_y) in enumerate(held) if (y - from_y) * (end - begin) >= 0 or k == 0)
        other, blend = holder, 0
        for k in range(1, len(held)):
            past = (y - held[k][1]) * (1 if end > begin else -1)
            if abs(past) < BLEND_M:
                holder, other, blend = k - 1, k, round(255 * (past + BLEND_M) / (2 * BLEND_M))
        for k in range(around):
            angle = 2 * math.pi * k / around
            c, z = math.cos(angle), math.sin(angle)
            points.append(rounded((x + half_x * width * c, y, half_z * width * z)))
            n = (c / half_x, -slope * width, z / half_z)
            length = math.sqrt(sum(v * v for v in n))
            normals.append(tuple(round(v / length, 5) for v in n))
            joints.append((names.index(held[holder][0]), names.index(held[other][0]), 0, 0))
            weights.append((255 - blend, blend, 0, 0) if other != holder else (255, 0, 0, 0))
    triangles = []
    for i in range(rings):
        for k in range(around):
            a, b = i * around + k, i * around + (k + 1) % around
            quad = [(a, a + around, b), (b, a + around, b + around)]
            triangles += [t if end > begin else t[::-1] for t in quad]
    return points, normals, triangles, joints, weights


def body(triangles):
    """The parts of the figure in one, with about so many triangles."""
    rings = max(6, round(math.sqrt(triangles / len(PARTS) / 2 * 1.5)))
    around = max(5, round(triangles / len(PARTS) / 2 / rings))
    whole = ([], [], [], [], [])
    for part in PARTS:
        points, normals, faces, joints, weights = tube(part, rings, around)
        base = len(whole[0])
        for total, own in zip(whole, (points, normals, [tuple(base + v for v in t) for t in faces], joints, weights)):
            total.extend(own)
    return whole


def walk(gltf, nodes):
    """Two steps a second; the hips go on and the camera goes along and around."""
    count = 16
    times = [round(WALK_S * i / count, 6) for i in range(count + 1)]
    phases = [2 * math.pi * t / 1.0 for t in times]

    def swing(joint, degrees):
        gltf.channel("walk", {"node": nodes[joint], "path": "rotation"}, times, [turn(0, d) for d in degrees])

    for side, shift in (("left", 0.0), ("right", math.pi)):
        swing(f"{side} hip", [-28 * math.sin(p + shift) for p in phases])
        swing(f"{side} knee", [28 - 26 * math.cos(p + shift - 0.9) for p in phases])
        swing(f"{side} ankle", [8 * math.sin(p + shift) for p in phases])
        swing(f"{side} shoulder", [24 * math.sin(p + shift) for p in phases])
        swing(f"{side} elbow", [-25 - 15 * math.sin(p + shift) for p in phases])
    gltf.channel("walk", {"node": nodes["chest"], "path": "rotation"}, times,
                 [turn(1, 7 * math.sin(p)) for p in phases])
    hips = [(0.0, 0.95 + 0.02 * math.cos(2 * p), -1.3 + SPEED * t) for p, t in zip(phases, times)]
    gltf.channel("walk", {"node": nodes["hips"], "path": "translation"}, times, [rounded(h) for h in hips])


def figure(triangles, description):
    """The scene with a figure of about so many triangles."""
    gltf = GltfWriter(description)
    stage(gltf, 4.0, 3.2)
    points, normals, faces, joints, weights = body(triangles)
    cloth = gltf.material("cloth", (0.25, 0.4, 0.7), roughness=0.6)
    primitive = gltf.primitive(points, faces, cloth, normals)
    primitive["attributes"].update(gltf.joint_weights(joints, weights))
    nodes = {}
    for name, (parent, place) in JOINTS.items():
        above = JOINTS[parent][1] if parent else (0.0, 0.0, 0.0)
        nodes[name] = gltf.joint(name, nodes.get(parent), translation=list(rounded(p - a for p, a in zip(place, above))))
    binds = [[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, *(-c for c in place), 1.0]
             for _, place in JOINTS.values()]
    gltf.mesh("figure", [primitive], skin=gltf.skin("figure", list(nodes.values()), binds))
    walk(gltf, nodes)
    gltf.camera(0.6, 4 / 3, matrix=[round(c, DIGITS) for c in look_at((3.0, 1.5, 4.0), (0.0, 0.85, 0.0))])
    return gltf, len(faces)


def walking_figure():
    """A skin of 13 joints walks; joints of limbs are shared by two parts each, and the whole of it goes on."""
    return figure(1800, walking_figure.__doc__)[0]


MAKERS = {"walking_figure": walking_figure}
