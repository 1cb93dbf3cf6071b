#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""eikon's metals and tables against Mitsuba's own plugins, direction by direction and without noise. Exit code 0: all agree.

  tools/versus/check_materials.py [--eikon build-release/eikon]

Rough metal: `eikon measure` writes a MERL table of EIKON_materials_conductor, of which random cells are compared with
`roughconductor` at the directions that MERL's angles say; so these angles and the channels' scales are checked with it. Mitsuba
shadows each direction by itself, eikon by the height that both share [Heitz 2014, eq. 99]: the known ratio is taken out.
Lambert's table is checked against `diffuse`. Smooth metal: what a mirror ball shows of a white sky is its reflectance at the
angle that the layers say, compared with `conductor`."""

import argparse
import json
import math
import pathlib
import sys
import tempfile

import modules

modules.need(["numpy", "mitsuba", "OpenEXR"], "eikon-versus", "mitsuba OpenEXR numpy")

import numpy as np  # noqa: E402
import OpenEXR  # noqa: E402

import mitsuba_render  # noqa: E402

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1]))
from common.child_process import run_or_exit  # noqa: E402
from common.flags import add_eikon_flag  # noqa: E402

# eta and k at 650, 550 and 450 nm, as eikon's README names them and host/scene/ has them.
METALS = {"Au": ((0.16779, 0.350409, 1.508458), (3.137816, 2.714063, 1.87885)),
          "Cu": ((0.216561, 0.958162, 1.165808), (3.637741, 2.577065, 2.393857)),
          "own": ((1.5, 3.0, 0.4), (0.0, 4.0, 2.0))}
H, D, P = 90, 90, 180
SCALES = np.array([1.0, 1.15, 1.66]) / 1500


def scene_of(material):
    """A ball of the material under a white sky, seen from 3 m."""
    return {"asset": {"version": "2.0"}, "scene": 0,
            "scenes": [{"nodes": [0, 1], "extras": {"environment": {"radiance": [1, 1, 1]}}}],
            "cameras": [{"type": "perspective", "perspective": {"yfov": 0.4, "znear": 0.1, "aspectRatio": 1.0}}],
            "nodes": [{"extensions": {"EIKON_shape": {"material": 0, "shape": {"type": "sphere", "sphere": {"radius": 0.5}}}}},
                      {"camera": 0, "translation": [0, 0, 3]}],
            "materials": [{"name": "m", **material}]}


def metal(name, roughness):
    eta, k = METALS[name]
    said = {"eta": list(eta), "k": list(k)} if name == "own" else {"metal": name}
    return {"pbrMetallicRoughness": {"roughnessFactor": roughness}, "extensions": {"EIKON_materials_conductor": said}}


def measured(options, material, folder):
    """f of each cell, (H, D, P, 3)."""
    scene, table = folder / "m.gltf", folder / "m.binary"
    scene.write_text(json.dumps(scene_of(material)))
    run_or_exit(options.eikon, "measure", scene, "--material", "m", "-o", table)
    data = table.read_bytes()
    if tuple(np.frombuffer(data, "<i4", 3)) != (H, D, P):
        sys.exit("the table has other dimensions than MERL's")
    values = np.frombuffer(data, "<f8", offset=12).reshape(3, H, D, P)
    return np.moveaxis(values, 0, -1) * SCALES


def some_cells(count, least_cosine):
    """Random cells, and the two directions in the middle of each, both well above the surface."""
    random = np.random.default_rng(1)
    i, j, k = (random.integers(0, n, count) for n in (H, D, P))
    theta_h, theta_d, phi_d = ((i + 0.5) / H) ** 2 * math.pi / 2, (j + 0.5) / D * math.pi / 2, (k + 0.5) / P * math.pi
    h = np.stack([np.sin(theta_h), 0 * theta_h, np.cos(theta_h)], -1)
    d = np.stack([np.sin(theta_d) * np.cos(phi_d), np.sin(theta_d) * np.sin(phi_d), np.cos(theta_d)], -1)
    wi = np.stack([h[:, 2] * d[:, 0] + h[:, 0] * d[:, 2], d[:, 1], h[:, 2] * d[:, 2] - h[:, 0] * d[:, 0]], -1)
    wo = 2 * np.sum(h * wi, -1, keepdims=True) * h - wi
    above = (wi[:, 2] > least_cosine) & (wo[:, 2] > least_cosine)
    return (i[above], j[above], k[above]), wo[above], wi[above]


def smith(cosine, alpha):
    """Lambda of GGX."""
    return (np.sqrt(1 + alpha * alpha * (1 - cosine * cosine) / (cosine * cosine)) - 1) / 2


class Mitsuba:
    def __init__(self):
        mitsuba_render.find_llvm()
        import drjit
        import mitsuba
        self.dr, self.mi = drjit, mitsuba
        self.mi.set_variant("llvm_ad_rgb")

    def bsdf(self, kind, name, **more):
        eta, k = METALS[name]
        values = {"eta": {"type": "rgb", "value": list(eta)}, "k": {"type": "rgb", "value": list(k)}}
        return self.mi.load_dict({"type": kind, **values, **more})

    def interaction(self, wi):
        si = self.dr.zeros(self.mi.SurfaceInteraction3f, len(wi))
        si.wi = self.mi.Vector3f(*(np.ascontiguousarray(wi[:, c], np.float32) for c in range(3)))
        si.n = self.mi.Normal3f(0, 0, 1)
        si.sh_frame = self.mi.Frame3f(self.mi.Normal3f(0, 0, 1))
        return si

    def f(self, bsdf, wo, wi):
        light = self.mi.Vector3f(*(np.ascontiguousarray(wi[:, c], np.float32) for c in range(3)))
        return np.array(bsdf.eval(self.mi.BSDFContext(), self.interaction(wo), light)).T / wi[:, 2:]

    def mirror(self, bsdf, cosine):
        """Returns what a mirror reflects at these angles, (n, 3)."""
        wo = np.stack([np.sqrt(1 - cosine * cosine), 0 * cosine, cosine], -1)
        _, weight = bsdf.sample(self.mi.BSDFContext(), self.interaction(wo), self.mi.Float(0.5), self.mi.Point2f(0.5, 0.5))
        return np.array(weight).T


def ball(options, name, folder):
    """Cosines of the angles that a ball of smooth metal is seen at, one sample in each pixel, and what it shows there."""
    scene, picture = folder / "ball.gltf", folder / "ball.exr"
    scene.write_text(json.dumps(scene_of(metal(name, 0.0))))
    run_or_exit(options.eikon, "render", scene, "-o", picture, "--size", "128x128", "--spp", "1", "--aov", "normal,position,id",
                "--quiet")
    with OpenEXR.File(str(picture), separate_channels=True) as file:
        planes = {key: np.array(channel.pixels, np.float64) for part in file.parts for key, channel in part.channels.items()}
    hit = planes["id"] > 0
    to_eye = np.array([0, 0, 3]) - np.stack([planes[f"position.{c}"][hit] for c in "XYZ"], -1)
    normal = np.stack([planes[f"normal.{c}"][hit] for c in "XYZ"], -1)
    cosine = np.sum(to_eye * normal, -1) / np.linalg.norm(to_eye, axis=-1)
    return np.clip(cosine, 0, 1), np.stack([planes[c][hit] for c in "RGB"], -1)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_eikon_flag(parser)
    options = parser.parse_args()
    mitsuba = Mitsuba()
    failures = 0

    def report(what, found, expected, bound):
        nonlocal failures
        worst = float(np.max(np.abs(found - expected) / (np.abs(expected) + 1e-6)))
        failures += not worst <= bound
        print(f"{'ok  ' if worst <= bound else 'FAIL'} {what}: {len(found)} directions, off by {worst:.2g} at most "
              f"(bound {bound:g})")

    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        cells, wo, wi = some_cells(60000, 0.05)
        # Both sides are floats: a direction is known to 6e-8, and a lobe of width alpha changes by
        # 4 / alpha of itself per radian.
        for metal_name in METALS:
            for roughness in (0.2, 0.5, 1.0):
                alpha = roughness * roughness
                table = measured(options, metal(metal_name, roughness), folder)[cells]
                bsdf = mitsuba.bsdf("roughconductor", metal_name, distribution="ggx", alpha=alpha)
                a, b = smith(wo[:, 2:], alpha), smith(wi[:, 2:], alpha)
                expected = mitsuba.f(bsdf, wo, wi) * (1 + a) * (1 + b) / (1 + a + b)
                report(f"table of {metal_name}, roughness {roughness}", table, expected, 5e-4)
        lambert = {"pbrMetallicRoughness": {"metallicFactor": 0.0, "baseColorFactor": [0.8, 0.5, 0.2, 1]},
                   "extensions": {"KHR_materials_specular": {"specularFactor": 0.0}}}
        bsdf = mitsuba.mi.load_dict({"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.8, 0.5, 0.2]}})
        report("table of Lambert", measured(options, lambert, folder)[cells], mitsuba.f(bsdf, wo, wi), 1e-6)
        for metal_name in METALS:
            cosine, shown = ball(options, metal_name, folder)
            inner = cosine > 0.02  # beyond, the layers' cosine is that of rounded points
            report(f"mirror ball of {metal_name}", shown[inner], mitsuba.mirror(mitsuba.bsdf("conductor", metal_name), cosine[inner]), 1e-4)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
