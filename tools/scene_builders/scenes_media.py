# SPDX-License-Identifier: Apache-2.0
"""The shipped scenes of solids inside each other. The first line of each docstring says what the scene proves; it is kept in the
file as well.
"""

from .gltf_writer import GltfWriter
from .scene_shapes import look_at
from .scenes_materials import checker_floor, lamp, solid


def tumbler():
    """Solids by priority: a tumbler that air and water hollow out of a block of glass, ice, a bubble, a straw; drops that join."""
    gltf = GltfWriter(tumbler.__doc__)
    gltf.environment((0.55, 0.65, 0.8))
    checker_floor(gltf, -6.0, 6.0, -8.0, 4.0, 0.25)
    lamp(gltf, (14.0, 12.0, 10.0), -1.8, -0.4, -1.0, 0.4, 3.5)

    def medium(name, priority, ior, *absorption):
        return gltf.material(name, roughness=0.0, extensions=solid(ior, *absorption), extras={"mediumPriority": priority})

    glass = medium("glass", 1, 1.5, (0.75, 0.95, 0.9), 0.5)
    water = medium("water", 2, 1.333, (0.5, 0.8, 0.95), 1.0)
    air = medium("air", 3, 1.0)
    ice = medium("ice", 4, 1.31)
    frost = medium("bubble in the ice", 5, 1.0)
    syrup = medium("syrup", 2, 1.4, (0.95, 0.35, 0.08), 0.3)

    def cylinder(name, material, x, bottom, top, radius):
        gltf.shape(name, "cylinder", material, {"height": round(top - bottom, 9), "radiusTop": radius, "radiusBottom": radius},
                   translation=[x, round(0.5 * (top + bottom), 9), 0.0])

    # Water reaches into the air above it and air out of the glass: each ends where something higher
    # begins.
    cylinder("block of glass", glass, -0.55, 0.001, 1.2, 0.5)
    cylinder("water", water, -0.55, 0.1, 0.9, 0.44)
    cylinder("air", air, -0.55, 0.78, 1.3, 0.44)
    turned = [0.1227878, 0.3535534, 0.1227878, 0.9190597]
    gltf.shape("ice", "box", ice, {"size": [0.3, 0.3, 0.3]}, translation=[-0.68, 0.74, 0.1], rotation=turned)
    gltf.shape("bubble in the ice", "sphere", frost, {"radius": 0.07}, translation=[-0.68, 0.73, 0.1])
    gltf.shape("ice", "box", ice, {"size": [0.26, 0.26, 0.26]}, translation=[-0.4, 0.75, -0.1])
    for x, y, z, radius in ((-0.75, 0.3, 0.15, 0.05), (-0.4, 0.42, 0.2, 0.035), (-0.55, 0.22, -0.1, 0.07)):
        gltf.shape("bubble", "sphere", air, {"radius": radius}, translation=[x, y, z])
    straw = gltf.lambert("straw", (0.8, 0.06, 0.05))
    gltf.shape("straw", "cylinder", straw, {"height": 1.5, "radiusTop": 0.03, "radiusBottom": 0.03},
               translation=[-0.4, 0.85, 0.0], rotation=[0.0, 0.0, -0.1305262, 0.9914449])

    # Two drops are one; the ball of glass, lower, ends where they are; the hollow in it does not.
    gltf.shape("drop", "sphere", syrup, {"radius": 0.32}, translation=[0.55, 0.33, 0.35])
    gltf.shape("drop", "sphere", syrup, {"radius": 0.26}, translation=[0.85, 0.4, 0.45])
    gltf.shape("ball", "sphere", glass, {"radius": 0.45}, translation=[1.0, 0.46, -0.1])
    gltf.shape("hollow", "sphere", air, {"radius": 0.25}, translation=[1.1, 0.52, -0.15])
    gltf.camera(0.42, 1.5, matrix=look_at((0.5, 1.7, 4.6), (0.2, 0.55, 0.0)))
    return gltf


MAKERS = {"tumbler": tumbler}
