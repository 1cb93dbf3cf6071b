# SPDX-License-Identifier: Apache-2.0
"""The shipped scenes of surfaces that are no meshes. The first line of each docstring says what the scene proves; it is kept in
the file as well.
"""

from . import scene_pictures
from .gltf_writer import GltfWriter
from .scene_shapes import look_at
from .scenes_materials import GOLD, checker_floor, solid


def balls():
    """Spheres by their equation: round at any size, under any transform, in glass, metal, veil and texture."""
    gltf = GltfWriter(balls.__doc__)
    gltf.environment((0.5, 0.6, 0.8))
    checker_floor(gltf, -6.0, 6.0, -8.0, 4.0, 0.5)
    red = gltf.lambert("red", (0.6, 0.05, 0.05))
    gold = gltf.material("gold", GOLD, metallic=1.0, roughness=0.1)
    glass = gltf.material("glass", roughness=0.0, extensions=solid(1.5, (0.5, 0.9, 0.7), 0.5))
    veil = gltf.material("veil", (0.9, 0.9, 0.3), opacity=0.4, alphaMode="BLEND", doubleSided=True)
    tiles = gltf.texture("globe", scene_pictures.checker(), sampler={"magFilter": 9728},
                         transform={"scale": [8.0, 4.0]})
    globe = gltf.material("globe", (0.3, 0.6, 0.9), roughness=0.4, baseColorTexture=tiles)
    lamp = gltf.lambert("lamp", (0.0, 0.0, 0.0), emission=(9.0, 7.0, 5.0))
    gltf.shape("red", "sphere", red, {"radius": 0.5}, translation=[-1.6, 0.5, -0.4])
    gltf.shape("gold egg", "sphere", gold, {"radius": 0.5}, translation=[-0.5, 0.8, -1.0], scale=[0.9, 1.6, 0.9])
    gltf.shape("glass", "sphere", glass, {"radius": 0.5}, translation=[0.5, 0.5, 0.5])
    gltf.shape("globe", "sphere", globe, {"radius": 0.6}, translation=[1.4, 0.6, -0.9],
               rotation=[0.1961, 0.0, 0.0, 0.9806])
    gltf.shape("veil", "sphere", veil, {"radius": 0.35}, translation=[-0.6, 0.35, 0.8])
    gltf.shape("pebble", "sphere", red, {"radius": 0.3}, translation=[1.5, 0.08, 0.9], scale=[1.4, 0.25, 0.8],
               rotation=[0.0, 0.3827, 0.0, 0.9239])
    gltf.shape("lamp", "sphere", lamp, {"radius": 0.4}, translation=[-2.0, 2.6, -1.5])
    gltf.camera(0.6, 1.5, matrix=look_at((0.3, 1.9, 4.8), (0.0, 0.6, -0.3)))
    return gltf


def lamps():
    """Shapes as lights: sphere, ellipsoid, box, plane, cylinder, cone and capsule light a floor, each in its own colour."""
    gltf = GltfWriter(lamps.__doc__)
    checker_floor(gltf, -4.0, 4.0, -4.0, 4.0, 0.5)
    grey = gltf.lambert("grey", (0.6, 0.6, 0.6))

    def glow(name, group, red, green, blue):
        return gltf.lambert(name, (0.1, 0.1, 0.1), emission=(red, green, blue), extras={"lightGroup": group})

    gltf.shape("sphere", "sphere", glow("sphere", "warm", 6.0, 1.0, 0.6), {"radius": 0.22}, translation=[-2.0, 0.5, 0.0])
    gltf.shape("egg", "sphere", glow("egg", "warm", 6.0, 3.0, 0.4), {"radius": 0.3}, translation=[-1.2, 0.45, -0.9],
               scale=[0.5, 1.3, 0.4], rotation=[0.0, 0.0, 0.2588, 0.9659])
    gltf.shape("box", "box", glow("box", "green", 3.0, 4.0, 0.4), {"size": [0.4, 0.25, 0.3]}, translation=[-0.4, 0.4, 0.2],
               rotation=[0.0, 0.2588, 0.0, 0.9659])
    gltf.shape("plane", "plane", glow("plane", "green", 2.0, 5.0, 1.5), {"sizeX": 0.5, "sizeZ": 0.5}, translation=[0.4, 0.8, -0.9],
               rotation=[0.8660, 0.0, 0.0, 0.5])
    gltf.shape("cylinder", "cylinder", glow("cylinder", "cold", 0.4, 3.5, 5.0),
               {"height": 0.6, "radiusTop": 0.12, "radiusBottom": 0.12},
               translation=[1.0, 0.4, 0.3], rotation=[0.0, 0.0, 0.5, 0.8660])
    gltf.shape("cone", "cylinder", glow("cone", "cold", 0.5, 1.2, 7.0), {"height": 0.6, "radiusTop": 0.0, "radiusBottom": 0.25},
               translation=[1.6, 0.31, -0.7])
    gltf.shape("capsule", "capsule", glow("capsule", "warm", 4.0, 0.6, 5.0),
               {"height": 0.4, "radiusTop": 0.08, "radiusBottom": 0.16},
               translation=[2.3, 0.5, 0.1], rotation=[0.2588, 0.0, 0.0, 0.9659])
    for x in (-1.6, -0.8, 0.2, 0.7, 1.4, 2.0):
        gltf.shape("post", "cylinder", grey, {"height": 0.5, "radiusTop": 0.06, "radiusBottom": 0.06},
                   translation=[x, 0.25, 0.75 - 0.2 * abs(x)])
    gltf.camera(0.55, 1.8, matrix=look_at((0.2, 2.2, 4.6), (0.1, 0.25, -0.2)))
    return gltf


MAKERS = {"balls": balls, "lamps": lamps}
