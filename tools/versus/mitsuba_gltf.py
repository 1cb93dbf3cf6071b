# SPDX-License-Identifier: Apache-2.0
"""glTF's materials as BSDF and texture plugins of Mitsuba 3, written from the text of the specification and from
numerical integration, so that they share nothing with eikon's kernels. `register(mi)` after mi.set_variant(), an LLVM or
CUDA variant.

The model. Metallic-roughness: GGX with the height-correlated Smith term and Schlick's Fresnel f0 + (f90 - f0) (1 - cos)^5;
under it, where not metal, a diffuse base coupled reciprocally, (1 - E(wo)) (1 - E(wi)) / (pi (1 - E_avg)) [Kelemen and
Szirmay-Kalos 2001], E the albedo of the dielectric's lobe from ggx_albedo.py. Thin-walled transmission mirrors the
reflection lobe to the other side. alpha = roughness^2; below SMOOTH_ALPHA the lobes are delta. Opacity passes straight
through. Shading normals that the viewer sees from behind are bent towards him [Keller et al. 2017, section A.3], light
that reaches a shading hemisphere from near the surface's own horizon fades [Chiang, Li, Burley 2019, equation 3], and
nothing is reflected to the other side of the surface itself. Solid glass is Mitsuba's own dielectric or roughdielectric, and Solid says what it adds.
"""

import functools
import math

import numpy as np

import ggx_albedo

SMOOTH_ALPHA = 2.0 ** -13
LEAST_COSINE = 2.0 ** -7
MATERIALS = []  # gltf_scene.Material of each "gltf" BSDF, by its property "material": properties carry no Python objects


def register(mi):
    """Adds the plugins "gltf", "gltf_solid" and "gltf_emission" to the current variant."""
    import drjit as dr  # not above: it looks for LLVM when it is imported
    Flags = mi.BSDFFlags
    size = ggx_albedo.STEPS + 1

    class AlbedoTable:
        """A and B of ggx_albedo, linear between its entries."""

        def __init__(self):
            directional, mean = ggx_albedo.tables()
            self.directional = mi.Texture2f(mi.TensorXf(directional.astype("float32")), wrap_mode=dr.WrapMode.Clamp)
            self.mean = mi.Texture1f(mi.TensorXf(mean.astype("float32")), wrap_mode=dr.WrapMode.Clamp)

        def at(self, cos, alpha):
            return self.directional.eval(mi.Point2f((dr.sqrt(cos) * ggx_albedo.STEPS + 0.5) / size,
                                                    (dr.sqrt(alpha) * ggx_albedo.STEPS + 0.5) / size))

        def average(self, alpha):
            return self.mean.eval(mi.Point1f((dr.sqrt(alpha) * ggx_albedo.STEPS + 0.5) / size))

    albedo_table = functools.cache(AlbedoTable)  # takes seconds to make, and not every scene needs it

    class Picture:
        """A gltf_scene.Texture on the device: four linear channels, interpolated between texel centres."""

        def __init__(self, texture, srgb):
            stream = mi.MemoryStream()
            stream.write(texture.encoded)
            stream.seek(0)
            bitmap = mi.Bitmap(stream)
            # As it is: "converted" to the encoding it has.
            bitmap = bitmap.convert(mi.Bitmap.PixelFormat.RGBA, mi.Struct.Type.UInt8, bitmap.srgb_gamma())
            texels = mi.TensorXf(np.array(bitmap, np.float32) / 255)
            self.height, self.width = texels.shape[:2]
            data = texels.array
            if srgb:
                index = dr.arange(mi.UInt32, dr.width(data))
                linear = dr.select(data <= 0.04045, data / 12.92, ((data + 0.055) / 1.055) ** 2.4)
                data = dr.select(index % 4 == 3, data, linear)
            self.data, self.texture = data, texture

        def _wrap(self, i, count, mode):
            if mode == "clamp":
                return dr.clip(i, 0, count - 1)
            period = count if mode == "repeat" else 2 * count
            i = i - period * dr.floor(i / period)
            return i if mode == "repeat" else dr.minimum(i, 2 * count - 1 - i)

        def _texel(self, x, y, active):
            x = self._wrap(x, self.width, self.texture.wrap[0])
            y = self._wrap(y, self.height, self.texture.wrap[1])
            index = mi.UInt32(y) * self.width + mi.UInt32(x)
            return dr.gather(mi.Vector4f, self.data, index, active)

        def at(self, uv, active):
            (a, b, c), (d, e, f) = self.texture.image_from_uv
            u, v = a * uv.x + b * uv.y + c, d * uv.x + e * uv.y + f
            x, y = u * self.width, v * self.height
            if self.texture.nearest:
                return self._texel(dr.floor(x), dr.floor(y), active)
            x, y = x - 0.5, y - 0.5
            x0, y0 = dr.floor(x), dr.floor(y)
            fx, fy = x - x0, y - y0
            top = dr.lerp(self._texel(x0, y0, active), self._texel(x0 + 1, y0, active), fx)
            return dr.lerp(top, dr.lerp(self._texel(x0, y0 + 1, active), self._texel(x0 + 1, y0 + 1, active), fx), fy)

    def picture(texture, srgb):
        return None if texture is None else Picture(texture, srgb)

    def lum(c):
        return (c.x + c.y + c.z) / 3

    def schlick(f0, f90, cos):
        return f0 + (f90 - f0) * dr.clip(1 - cos, 0, 1) ** 5

    def smith(z, alpha):
        return (dr.sqrt(1 + alpha * alpha * (1 - z * z) / dr.maximum(z * z, 1e-12)) - 1) / 2

    def distribution(h_z, alpha):
        c = h_z * h_z
        return alpha * alpha / (dr.pi * dr.square(dr.square(alpha) * c + 1 - c))

    def usable_normal(n, n_geom, viewer, glossy):
        """The shading normal n bent until the viewer is above it and, if glossy, its mirror direction above n_geom."""
        cos_geom, cos = dr.dot(viewer, n_geom), dr.dot(viewer, n)
        least = dr.minimum(cos_geom, LEAST_COSINE)
        n = dr.select(cos < least, dr.normalize(n + (least - cos) * viewer), n)
        if glossy:
            mirrored = 2 * dr.dot(viewer, n) * n - viewer
            above = dr.dot(mirrored, n_geom)
            lifted = dr.normalize(mirrored + (least - above) * n_geom)
            n = dr.select(above < least, dr.normalize(viewer + lifted), n)
        return n

    def terminator(wi, n_geom, n):
        g = dr.minimum(dr.dot(wi, n_geom) / (dr.dot(wi, n) * dr.dot(n_geom, n)), 1)
        return ((g - g * g) + 1) * g

    class Surface:
        """The material at a hit, after textures; directions are world, everything on the viewer's side."""

    class Gltf(mi.BSDF):
        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            m = self.m = MATERIALS[props["material"]]
            self.albedos = albedo_table()
            self.color = picture(m.base_color_texture, True)
            self.roughness = picture(m.metallic_roughness_texture, False)
            self.normal = picture(m.normal_texture, False)
            self.tangents = mi.load_dict({"type": "mesh_attribute", "name": "vertex_tangent"}) if self.normal else None
            self.signs = mi.load_dict({"type": "mesh_attribute", "name": "vertex_sign"}) if self.normal else None
            self.thin = m.transmission > 0 and not m.solid
            both = Flags.FrontSide | Flags.BackSide
            self.glossy = m.metallic > 0 or m.specular > 0 or m.transmission > 0
            smooth = m.roughness ** 2 < SMOOTH_ALPHA
            kinds = [Flags.DeltaReflection if smooth else Flags.GlossyReflection]
            if m.metallic < 1 or self.roughness:
                kinds.append(Flags.DiffuseReflection)
            if self.thin:
                kinds.append(Flags.DeltaTransmission if smooth else Flags.GlossyTransmission)
            if m.alpha_mode != "OPAQUE":
                kinds.append(Flags.Null)
            self.m_components = [kind | both for kind in kinds]
            self.m_flags = both
            for kind in self.m_components:
                self.m_flags = self.m_flags | kind

        def surface(self, si, active):
            m, s = self.m, Surface()
            texel = self.color.at(si.uv, active) if self.color else mi.Vector4f(1)
            s.color = mi.Color3f(*m.base_color) * mi.Color3f(texel.x, texel.y, texel.z)
            opacity = m.opacity * texel.w
            s.opacity = mi.Float(1) if m.alpha_mode == "OPAQUE" else (
                dr.select(opacity >= m.alpha_cutoff, 1.0, 0.0) if m.alpha_mode == "MASK" else opacity)
            rm = self.roughness.at(si.uv, active) if self.roughness else mi.Vector4f(1)
            metallic, roughness = m.metallic * rm.z, m.roughness * rm.y
            s.alpha = mi.Float(roughness * roughness)
            s.smooth = s.alpha < SMOOTH_ALPHA
            s.metallic = metallic
            reflectance = ((m.ior - 1) / (m.ior + 1)) ** 2 if m.ior > 0 else 1.0
            s.f0_base = mi.Color3f(*(min(reflectance * c, 1.0) * m.specular for c in m.specular_color))
            s.f90_base = m.specular
            s.f0 = dr.lerp(s.f0_base, s.color, metallic)
            s.f90 = dr.lerp(mi.Float(m.specular), mi.Float(1), metallic)

            viewer = si.to_world(si.wi)
            n = dr.select(dr.dot(si.sh_frame.n, si.n) > 0, si.sh_frame.n, si.n)
            if self.normal:
                texel = self.normal.at(si.uv, active)
                t = self.tangents.eval(si, active)
                t = mi.Vector3f(t.x, t.y, t.z)
                sign = self.signs.eval_1(si, active)
                scale = m.normal_texture.scale
                x, y, z = (2 * texel.x - 1) * scale, (2 * texel.y - 1) * scale, 2 * texel.z - 1
                t = dr.normalize(t - n * dr.dot(n, t))
                mapped = dr.normalize(t * x + dr.cross(n, t) * sign * y + n * z)
                n = dr.select(dr.dot(mapped, si.n) > 0, mapped, n)
            flip = dr.select(dr.dot(viewer, si.n) < 0, -1.0, 1.0)
            s.n_geom, s.viewer = si.n * flip, viewer
            s.frame = mi.Frame3f(usable_normal(n * flip, s.n_geom, viewer, self.glossy))
            s.wo = s.frame.to_local(viewer)

            dielectric = mi.Float(0)
            for channel in (s.f0_base.x, s.f0_base.y, s.f0_base.z):
                dielectric = dr.maximum(dielectric, channel)
            s.max_f0 = dielectric
            ab = self.albedos.at(dr.maximum(s.wo.z, 0), s.alpha)
            mean_ab = self.albedos.average(s.alpha)
            s.coupled_o = 1 - (s.max_f0 * ab[0] + s.f90_base * ab[1])
            s.coupled_mean = 1 - (s.max_f0 * mean_ab[0] + s.f90_base * mean_ab[1])
            transmission = m.transmission if self.thin else 0.0
            s.diffuse = s.color * (1 - metallic) * (1 - transmission)
            s.through = s.color * (1 - metallic) * transmission
            # Selection by estimated albedo.
            reflected = lum(s.f0) * ab[0] + s.f90 * ab[1] + 1e-4
            through = lum(s.through) * (1 - lum(s.f0_base)) if self.thin else mi.Float(0)
            diffuse = lum(s.diffuse) * s.coupled_o
            total = reflected + through + diffuse
            s.p_reflect, s.p_through = reflected / total, through / total
            s.p_diffuse = 1 - s.p_reflect - s.p_through
            return s

        def parts(self, s, wi_world, active):
            """(value with cosine, pdf) of the parts that are not delta; wi_world to the light."""
            wi = s.frame.to_local(wi_world)
            side = dr.dot(wi_world, s.n_geom)
            active &= s.wo.z > 0
            reflected = active & (wi.z > 0) & (side > 0)
            crossed = active & (wi.z < 0) & (side < 0)
            cos_i = dr.abs(wi.z)
            mirrored = mi.Vector3f(wi.x, wi.y, cos_i)
            h = dr.normalize(s.wo + mirrored)
            cos_d = dr.dot(s.wo, h)
            alpha = dr.maximum(s.alpha, SMOOTH_ALPHA)
            d = distribution(h.z, alpha)
            lambda_o, lambda_i = smith(s.wo.z, alpha), smith(cos_i, alpha)
            lobe = d / ((1 + lambda_o + lambda_i) * 4 * s.wo.z)
            lobe_pdf = d / ((1 + lambda_o) * 4 * s.wo.z)
            rough = ~s.smooth
            ab = self.albedos.at(cos_i, s.alpha)
            coupled_i = 1 - (s.max_f0 * ab[0] + s.f90_base * ab[1])
            fade = terminator(wi_world, s.n_geom, s.frame.n)
            value = s.diffuse * s.coupled_o * coupled_i / (s.coupled_mean * dr.pi) * cos_i * fade
            value += dr.select(rough, schlick(s.f0, s.f90, cos_d) * lobe * dr.lerp(1, fade, s.alpha), 0)
            pdf = s.p_diffuse * cos_i / dr.pi + dr.select(rough, s.p_reflect * lobe_pdf, 0)
            value, pdf = dr.select(reflected, value, 0), dr.select(reflected, pdf, 0)
            if self.thin:
                crossed &= rough
                value += dr.select(crossed, s.through * (1 - schlick(s.f0_base, s.f90_base, cos_d)) * lobe, 0)
                pdf += dr.select(crossed, s.p_through * lobe_pdf, 0)
            return value * s.opacity, pdf * s.opacity

        def sample(self, ctx, si, sample1, sample2, active=True):
            s = self.surface(si, active)
            bs = dr.zeros(mi.BSDFSample3f)
            pass_on = sample1 >= s.opacity
            choice = sample1 / dr.maximum(s.opacity, 1e-9)
            diffuse = ~pass_on & (choice >= s.p_reflect + s.p_through)
            through = ~pass_on & ~diffuse & (choice >= s.p_reflect)

            alpha = dr.maximum(s.alpha, SMOOTH_ALPHA)
            stretched = dr.normalize(mi.Vector3f(alpha * s.wo.x, alpha * s.wo.y, s.wo.z))
            z = (1 - sample2.x) * (1 + stretched.z) - stretched.z
            r, phi = dr.sqrt(dr.clip(1 - z * z, 0, 1)), 2 * dr.pi * sample2.y
            h = mi.Vector3f(r * dr.cos(phi), r * dr.sin(phi), z) + stretched
            h = dr.normalize(mi.Vector3f(alpha * h.x, alpha * h.y, dr.maximum(h.z, 1e-9)))
            h = dr.select(s.smooth, mi.Vector3f(0, 0, 1), h)
            wi = 2 * dr.dot(s.wo, h) * h - s.wo
            upper = wi.z > 0
            wi.z = dr.select(through, -wi.z, wi.z)
            wi = dr.select(diffuse, mi.warp.square_to_cosine_hemisphere(sample2), wi)
            wi_world = s.frame.to_world(wi)

            value, pdf = self.parts(s, wi_world, active)
            f = schlick(s.f0, s.f90, s.wo.z)
            f_base = schlick(s.f0_base, s.f90_base, s.wo.z)
            delta = ~pass_on & ~diffuse & s.smooth
            side = dr.dot(wi_world, s.n_geom)
            right_side = dr.select(through, side < 0, side > 0)
            delta_p = dr.select(through, s.p_through, s.p_reflect) * s.opacity
            delta_weight = s.opacity / delta_p * dr.select(
                through, s.through * (1 - f_base), f)
            ok = active & (s.wo.z > 0) & (diffuse | upper) & right_side
            weight = dr.select(delta, delta_weight, value / pdf)
            bs.pdf = dr.select(delta, delta_p, pdf)
            ok &= bs.pdf > 0
            weight, bs.pdf = dr.select(ok, weight, 0), dr.select(ok, bs.pdf, 0)
            bs.pdf = dr.select(pass_on, 1 - s.opacity, bs.pdf)
            bs.wo = dr.select(pass_on, -si.wi, si.to_local(wi_world))
            bs.eta = 1.0
            bs.sampled_type = dr.select(
                pass_on, mi.UInt32(+Flags.Null), dr.select(diffuse, mi.UInt32(+Flags.DiffuseReflection), dr.select(
                    delta, dr.select(through, mi.UInt32(+Flags.DeltaTransmission), mi.UInt32(+Flags.DeltaReflection)),
                    dr.select(through, mi.UInt32(+Flags.GlossyTransmission), mi.UInt32(+Flags.GlossyReflection)))))
            bs.sampled_component = 0
            return bs, dr.select(pass_on & active, mi.Color3f(1), weight)

        def eval(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[0]

        def pdf(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[1]

        def eval_pdf(self, ctx, si, wo, active=True):
            active = mi.Bool(active)
            return self.parts(self.surface(si, active), si.to_world(wo), active)

        def to_string(self):
            return f"Gltf[{self.m.name}]"

    class Solid(mi.BSDF):
        """Mitsuba's dielectric with two things added. Beer's law on segments that end at the surface from within; and for
        reflections of rough glass the height-correlated Smith term in place of the separable one (which stands for
        transmission in both)."""

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            m = MATERIALS[props["material"]]
            self.nested = props["nested"]
            self.alpha = m.roughness ** 2
            self.rough = self.alpha >= SMOOTH_ALPHA
            self.sigma = [-math.log(max(c, 1e-30)) / m.attenuation_distance for c in m.attenuation_color]
            self.m_components = [self.nested.flags(i) for i in range(self.nested.component_count())]
            self.m_flags = self.nested.flags()

        def factor(self, si, wo):
            factor = dr.select(si.wi.z < 0, dr.exp(-mi.Color3f(*self.sigma) * si.t), 1)
            if self.rough:
                a, b = smith(si.wi.z, self.alpha), smith(wo.z, self.alpha)
                factor *= dr.select(si.wi.z * wo.z > 0, (1 + a) * (1 + b) / (1 + a + b), 1)
            return factor

        def sample(self, ctx, si, sample1, sample2, active=True):
            bs, weight = self.nested.sample(ctx, si, sample1, sample2, active)
            return bs, weight * self.factor(si, bs.wo)

        def eval(self, ctx, si, wo, active=True):
            return self.nested.eval(ctx, si, wo, active) * self.factor(si, wo)

        def pdf(self, ctx, si, wo, active=True):
            return self.nested.pdf(ctx, si, wo, active)

        def eval_pdf(self, ctx, si, wo, active=True):
            value, pdf = self.nested.eval_pdf(ctx, si, wo, active)
            return value * self.factor(si, wo), pdf

    class Emission(mi.Texture):
        """Radiance of a textured light; sampled evenly over its area."""

        def __init__(self, props):
            mi.Texture.__init__(self, props)
            self.m = MATERIALS[props["material"]]
            self.picture = picture(self.m.emissive_texture, True)

        def eval(self, si, active=True):
            texel = self.picture.at(si.uv, active)
            return mi.Color3f(*self.m.emission) * mi.Color3f(texel.x, texel.y, texel.z)

        def eval_3(self, si, active=True):
            return self.eval(si, active)

        def is_spatially_varying(self):
            return False

    mi.register_bsdf("gltf", Gltf)
    mi.register_bsdf("gltf_solid", Solid)
    mi.register_texture("gltf_emission", Emission)
