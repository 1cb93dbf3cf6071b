# SPDX-License-Identifier: Apache-2.0
"""The shipped scenes of surfaces that are no meshes. The first line of each docstring says what the scene proves; it is kept in
the file as well.
"""

import scene_pictures
from gltf_writer import GltfWriter
from scene_shapes import look_at
from scenes_materials import GOLD, checker_floor, solid


def balls():
    """Spheres by their equation: round at any size, under any transform, in glass, metal, veil and texture."""
    gltf = GltfWriter(balls.__doc__)
    gltf.environment((0.5, 0.6, 0.8))
    checker_floor(gltf, -6.0, 6.0, -8.0, 4.0, 0.5)
    red = gltf.material("red", (0.6, 0.05, 0.05))
    gold = gltf.surface("gold", GOLD, metallic=1.0, roughness=0.1)
    glass = gltf.surface("glass", roughness=0.0, extensions=solid(1.5, (0.5, 0.9, 0.7), 0.5))
    veil = gltf.surface("veil", (0.9, 0.9, 0.3), opacity=0.4, alphaMode="BLEND")
    tiles = gltf.texture("globe", scene_pictures.checker(), sampler={"magFilter": 9728},
                         transform={"scale": [8.0, 4.0]})
    globe = gltf.surface("globe", (0.3, 0.6, 0.9), roughness=0.4, baseColorTexture=tiles)
    lamp = gltf.material("lamp", (0.0, 0.0, 0.0), emission=(9.0, 7.0, 5.0))
    gltf.analytic("red", "sphere", red, {"radius": 0.5}, translation=[-1.6, 0.5, -0.4])
    gltf.analytic("gold egg", "sphere", gold, {"radius": 0.5}, translation=[-0.5, 0.8, -1.0], scale=[0.9, 1.6, 0.9])
    gltf.analytic("glass", "sphere", glass, {"radius": 0.5}, translation=[0.5, 0.5, 0.5])
    gltf.analytic("globe", "sphere", globe, {"radius": 0.6}, translation=[1.4, 0.6, -0.9],
                  rotation=[0.1961, 0.0, 0.0, 0.9806])
    gltf.analytic("veil", "sphere", veil, {"radius": 0.35}, translation=[-0.6, 0.35, 0.8])
    gltf.analytic("pebble", "sphere", red, {"radius": 0.3}, translation=[1.5, 0.08, 0.9], scale=[1.4, 0.25, 0.8],
                  rotation=[0.0, 0.3827, 0.0, 0.9239])
    gltf.analytic("lamp", "sphere", lamp, {"radius": 0.4}, translation=[-2.0, 2.6, -1.5])
    gltf.camera(0.6, 1.5, matrix=look_at((0.3, 1.9, 4.8), (0.0, 0.6, -0.3)))
    return gltf


MAKERS = {"balls": balls}
