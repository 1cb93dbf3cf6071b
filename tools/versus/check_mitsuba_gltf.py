#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Is the reference itself right? Tries the BSDF of mitsuba_gltf.py by itself: its sampling against its density
(chi-square, Sidak over all cases), the albedo of GGX against its closed form 1 - ln 2, and a white base under
a colourless layer of which nothing is lost (albedo 1). Exit code 0: all pass.

  tools/versus/check_mitsuba_gltf.py
"""

import contextlib
import io
import math
import sys

import modules

modules.need(["numpy", "mitsuba"], "eikon-versus", "mitsuba OpenEXR numpy")

import numpy as np  # noqa: E402

import gltf_scene  # noqa: E402
import mitsuba_gltf  # noqa: E402
import mitsuba_render  # noqa: E402


def main():
    mitsuba_render.find_llvm()
    import drjit as dr
    import mitsuba as mi
    mi.set_variant("llvm_ad_rgb")
    from mitsuba.chi2 import ChiSquareTest, SphericalDomain
    mitsuba_gltf.register(mi)

    def bsdf(**members):
        mitsuba_gltf.MATERIALS.append(gltf_scene.Material(**members))
        return {"type": "gltf", "material": len(mitsuba_gltf.MATERIALS) - 1}

    failures = 0

    def report(what, ok, figure):
        nonlocal failures
        failures += not ok
        print(f"{'ok  ' if ok else 'FAIL'} {what}: {figure}")

    cases = [(roughness, kind, angle) for roughness in (0.25, 0.5, 1.0) for kind in ("metal", "plastic", "thin")
             for angle in (0, 45, 80)]
    for roughness, kind, angle in cases:
        description = bsdf(roughness=roughness, metallic=1.0 if kind == "metal" else 0.0, base_color=(0.8, 0.5, 0.2),
                           transmission=0.7 if kind == "thin" else 0.0)

        instance = mi.load_dict(description)
        wi = mi.ScalarVector3f(math.sin(math.radians(angle)), 0, math.cos(math.radians(angle)))

        def interaction(count, wi=wi):
            si = dr.zeros(mi.SurfaceInteraction3f, count)
            si.wi = wi
            si.n = mi.Normal3f(0, 0, 1)
            si.sh_frame = mi.Frame3f(mi.Normal3f(0, 0, 1))
            return si

        def draw(points, instance=instance, interaction=interaction):
            si = interaction(dr.width(points))
            bs, weight = instance.sample(mi.BSDFContext(), si, points.x, mi.Point2f(points.y, points.z))
            return bs.wo, dr.select(bs.pdf > 0, 1.0, 0.0)

        def density(wo, instance=instance, interaction=interaction):
            return instance.pdf(mi.BSDFContext(), interaction(dr.width(wo)), wo)

        test = ChiSquareTest(domain=SphericalDomain(), sample_func=draw, pdf_func=density, sample_dim=3,
                             sample_count=400000, res=201, ires=8)
        with contextlib.redirect_stdout(io.StringIO()):
            ok = test.run(0.01, len(cases))
        report(f"chi-square of {kind}, roughness {roughness}, {angle} degrees", ok, f"p = {float(np.ravel(test.p_value)[0]):.3g}")

    def albedo(description, cos, count=1 << 20):
        instance = mi.load_dict(description)
        si = dr.zeros(mi.SurfaceInteraction3f, count)
        si.wi = mi.Vector3f(math.sqrt(1 - cos * cos), 0, cos)
        si.n = mi.Normal3f(0, 0, 1)
        si.sh_frame = mi.Frame3f(mi.Normal3f(0, 0, 1))
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(0, count)
        _, weight = instance.sample(mi.BSDFContext(), si, sampler.next_1d(), sampler.next_2d())
        values = np.array(weight)[0]
        return values.mean(), values.std() / math.sqrt(count)

    mean, sigma = albedo(bsdf(metallic=1.0, roughness=1.0), 1.0)
    report("albedo of white metal of alpha 1, 1 - ln 2", abs(mean - (1 - math.log(2))) < 4 * sigma + 1e-5, f"{mean:.5f}")
    for roughness in (0.0, 0.3, 0.6, 1.0):
        for cos in (1.0, 0.5, 0.1):
            mean, sigma = albedo(bsdf(metallic=0.0, roughness=roughness), cos)
            # The base gets all that the layer does not reflect, also what GGX itself loses.
            report(f"albedo of white plastic, roughness {roughness}, cosine {cos}", abs(mean - 1) < 4 * sigma + 2e-3,
                   f"{mean:.5f} +- {sigma:.5f}")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
