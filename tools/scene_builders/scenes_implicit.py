# SPDX-License-Identifier: Apache-2.0
"""Scenes of surfaces by formula (EIKON_implicit_surface): where f(x, y, z) = 0 within bounds, f > 0 outside."""

from .gltf_writer import GltfWriter
from .scene_shapes import look_at
from .scenes_materials import checker_floor, lamp, solid


def stage(gltf):
    """A floor, a lamp and a sky for one thing of about 2 m at (0, 1, 0)."""
    gltf.environment((0.35, 0.45, 0.6))
    checker_floor(gltf, -6, 6, -6, 6, 0.5)
    lamp(gltf, (14.0, 13.0, 11.0), -1.5, 0.5, 0.5, 2.5, 5.0)
    gltf.camera(0.5, 1.5, matrix=look_at((1.6, 2.6, 5.4), (0.0, 0.95, 0.0)))


def implicit_torus():
    """A torus of radii 1 and 0.45 by its quartic, of polished brass, tilted by its node."""
    gltf = GltfWriter(implicit_torus.__doc__)
    stage(gltf)
    brass = gltf.material("brass", (0.91, 0.78, 0.42), metallic=1.0, roughness=0.2)
    gltf.implicit_surface("torus", "(x^2 + y^2 + z^2 + 1 - 0.45^2)^2 - 4*(x^2 + y^2)", (-1.5, -1.5, -0.5, 1.5, 1.5, 0.5), brass,
                          matrix=[0.7, 0.0, -0.2, 0.0, 0.0, 0.728, 0.0, 0.0, 0.2, 0.0, 0.7, 0.0, 0.0, 1.06, 0.0, 1.0])
    return gltf


def implicit_heart():
    """Taubin's heart, a sextic with a cusp and a flat dent, of red lacquer."""
    gltf = GltfWriter(implicit_heart.__doc__)
    stage(gltf)
    lacquer = gltf.material("lacquer", (0.6, 0.03, 0.04), roughness=0.15)
    gltf.implicit_surface("heart", "(x^2 + y^2 + 9/4*z^2 - 1)^3 - x^2*y^3 - 9/80*z^2*y^3",
                          (-1.25, -1.1, -0.8, 1.25, 1.35, 0.8), lacquer,
                          translation=[0.0, 1.0, 0.0], scale=[0.9, 0.9, 0.9])
    return gltf


def implicit_gyroid():
    """A sheet along a gyroid within a ball, of glass that absorbs: many roots on every ray, and media inside and outside of them."""
    gltf = GltfWriter(implicit_gyroid.__doc__)
    stage(gltf)
    glass = gltf.material("glass", roughness=0.0, extensions=solid(1.5, (0.3, 0.8, 0.75), 0.3))
    wave = "sin(6*x)*cos(6*y) + sin(6*y)*cos(6*z) + sin(6*z)*cos(6*x)"
    gltf.implicit_surface("gyroid", f"max(x^2 + y^2 + z^2 - 1, (abs({wave}) - 0.5)/10)",
                          (-1.05, -1.05, -1.05, 1.05, 1.05, 1.05), glass,
                          translation=[0.0, 1.02, 0.0])
    return gltf


def implicit_metaballs():
    """Five balls that melt into each other, a sum of poles, of clear glass; beside them the same in matt white."""
    gltf = GltfWriter(implicit_metaballs.__doc__)
    stage(gltf)
    glass = gltf.material("glass", roughness=0.0, extensions=solid(1.5, (0.9, 0.6, 0.35), 0.5))
    white = gltf.material("white", (0.8, 0.8, 0.8), roughness=0.6)
    balls = ((0.0, 0.0, 0.0, 0.14), (0.5, 0.25, 0.1, 0.08), (-0.45, 0.3, -0.15, 0.08), (0.1, 0.6, 0.05, 0.07), (0.05, -0.45, 0.35, 0.06))
    poles = " - ".join(f"{s}/((x - {x})^2 + (y - {y})^2 + (z - {z})^2)" for x, y, z, s in balls)
    f, bounds = f"1 - {poles}".replace("- -", "+ "), (-1.2, -1.1, -1.0, 1.2, 1.3, 1.1)
    gltf.implicit_surface("glass balls", f, bounds, glass, translation=[0.75, 0.95, 0.3])
    gltf.implicit_surface("white balls", f, bounds, white, translation=[-0.95, 0.95, -0.5], rotation=[0.0, 0.6, 0.0, 0.8])
    return gltf


MAKERS = {
    "implicit_torus": implicit_torus,
    "implicit_heart": implicit_heart,
    "implicit_gyroid": implicit_gyroid,
    "implicit_metaballs": implicit_metaballs,
}
