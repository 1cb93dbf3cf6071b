// SPDX-License-Identifier: Apache-2.0
// Iridescence: the reflectance of a surface under a film so thin that light reflected on its two
// sides interferes [Belcour and Barla 2017, "A Practical Extension to Microfacet Theory for the
// Modeling of Varying Iridescence"; in the form of KHR_materials_iridescence, "Theory,
// Documentation and Implementations"]. Reflections within the film are summed up to the second
// order. The spectrum of each order becomes a colour in closed form, by Gaussians fitted to the
// colour matching functions of the eye.
#ifndef EK_THIN_FILM_H
#define EK_THIN_FILM_H
#include "bsdf/fresnel.h"
#include "lanes/math.h"

// One of the Gaussians over 1 / lambda whose sums are the colour matching functions [Belcour and
// Barla 2017, supplement].
typedef struct {
  float weight;    // its share of the function's integral
  float middle;    // mean of 1 / lambda, 1 / m
  float variance;  // half of that of 1 / lambda, 1 / m^2
} CieGaussian;

// X is the sum of red and violet, Y is green, and Z is blue.
constant CieGaussian cie_red = {0.846590002f, 1.6810e6f, 4.3278e9f}, cie_violet = {0.153868307f, 2.2399e6f, 4.5282e9f},
                     cie_green = {1.00022189f, 1.7953e6f, 9.3046e9f}, cie_blue = {1.00112249f, 2.2084e6f, 6.6121e9f};

// The mean of exp(2 pi i path / lambda) over a Gaussian, and its absolute value.
typedef struct { vf re, im, size; } CieWave;

// path: metres
EK_FN CieWave cie_wave(vf path, CieGaussian gaussian) {
  // exp(-variance (2 pi path)^2) is written as a power of two; middle * path is in turns.
  const vf phase = 2.0f * EK_PI * path, size = exp2_f((-1.44269504f * gaussian.variance) * (phase * phase));
  vf s, c;
  sincos_2pi(gaussian.middle * path, &s, &c);
  const CieWave w = {size * c, size * s, size};
  return w;
}

// XYZ of cos(2 pi path / lambda), each relative to the integral of its function.
EK_FN vf cie_x(vf path) { return cie_red.weight * cie_wave(path, cie_red).re + cie_violet.weight * cie_wave(path, cie_violet).re; }
EK_FN vf cie_y(vf path) { return cie_green.weight * cie_wave(path, cie_green).re; }
EK_FN vf cie_z(vf path) { return cie_blue.weight * cie_wave(path, cie_blue).re; }

/// Linear sRGB of XYZ [IEC 61966-2-1], divided by that of a flat spectrum, since a reflectance of
/// (1, 1, 1) means a flat spectrum. (The formula of KHR_materials_iridescence omits the division,
/// so that a film of no thickness is pink there.)
EK_FN v3 thin_film_rgb(vf x, vf y, vf z) {
  return V3((3.2404542f * x - 1.5371385f * y - 0.4985314f * z) * 0.829621636f, (-0.9692660f * x + 1.8760108f * y + 0.0415560f * z) * 1.05449694f,
            (0.0556434f * x - 0.2040259f * y + 1.0572252f * z) * 1.09888944f);
}

// Reflectance at normal incidence of a boundary between indices of this ratio.
EK_FN vf thin_film_f0(vf ratio) {
  const vf r = div_f(ratio - 1.0f, ratio + 1.0f);
  return r * r;
}

// The relative index, at most 1e4, of a dielectric with this reflectance at normal incidence in
// air.
EK_FN vf thin_film_base_index(vf f0) {
  const vf r = sqrt_f(min_f(max_f(f0, (vf)(0.0f)), (vf)(0.9996f)));
  return div_f(1.0f + r, 1.0f - r);
}

typedef struct {
  vf index;      // of the film over that of air, >= 1
  vf thickness;  // metres
} ThinFilm;

/// Index of the film, which fades to that of air below a thickness of 0.03 nm.
EK_FN vf thin_film_index(ThinFilm film) {
  const vf t = min_f(max_f(film.thickness * (1.0f / 0.03e-9f), (vf)(0.0f)), (vf)(1.0f));
  return 1.0f + (film.index - 1.0f) * ((t * t) * (3.0f - 2.0f * t));
}

// Gauss-Legendre nodes over the squared cosine, for 2 times the integral of f(cosine) cosine. Films
// that still have colours show at most two fringes between the horizon and the normal.
#define EK_THIN_FILM_NODES 5u
constant float thin_film_cosines[EK_THIN_FILM_NODES] = {0.216587343f, 0.480380417f, 0.707106781f, 0.877060235f, 0.976263245f};
constant float thin_film_weights[EK_THIN_FILM_NODES] = {0.118463443f, 0.239314335f, 0.284444444f, 0.239314335f, 0.118463443f};

/// Upper bound over wavelengths of the reflectance at normal incidence of a base under the film.
/// f0  reflectance of the base at normal incidence without the film
EK_FN vf thin_film_most_f0(ThinFilm film, vf f0) {
  const vf index = thin_film_index(film);
  const vf a = sqrt_f(thin_film_f0(index)), b = sqrt_f(thin_film_f0(div_f(thin_film_base_index(f0), index)));
  const vf r = div_f(a + b, 1.0f + a * b);
  return r * r;
}

/// Reflectance, R, G and B, [0, 1]; never more than Schlick's law with thin_film_most_f0 as f0, on
/// which the share of a diffuse base below relies.
/// cosine  of the light with the normal, in air, [0, 1]
/// f0      of the base without the film, R, G and B
EK_FN_ONCE v3 thin_film_reflectance(ThinFilm film, v3 f0, vf cosine) {
  const vf index = thin_film_index(film);
  // Within the film; index >= 1, so there is no total reflection.
  const vf cos2 = 1.0f - div_f((1.0f - cosine) * (1.0f + cosine), index * index);
  const vf cos_film = sqrt_f(max_f(cos2, (vf)(0.0f)));
  const vf weight = schlick_weight(cosine);
  // The exact equation, since Schlick's would let a film of the index of air reflect at grazing
  // angles.
  const vf top = fresnel_dielectric(cosine, index);
  const vf passes = 1.0f - top;
  const vf path = 2.0f * (index * film.thickness) * cos_film;
  // Reflectance of each channel's base as seen from the film.
  const v3 base = V3(thin_film_base_index(f0.x), thin_film_base_index(f0.y), thin_film_base_index(f0.z));
  const vf weight_film = schlick_weight(cos_film);
  const v3 f0_film = V3(thin_film_f0(div_f(base.x, index)), thin_film_f0(div_f(base.y, index)), thin_film_f0(div_f(base.z, index)));
  const v3 bottom = schlick(f0_film, (vf)(1.0f), weight_film);
  // Reflection within the film at its upper side shifts the phase by half a turn, and so does the
  // base where its index is lower than the film's: two half turns cancel.
  const vf one = (vf)(1.0f), none = (vf)(0.0f);
  const v3 sign = V3(base.x < index ? one : -one, base.y < index ? one : -one, base.z < index ? one : -one);
  const v3 both = V3(min_f(top * bottom.x, (vf)(0.9999f)), min_f(top * bottom.y, (vf)(0.9999f)),
                     min_f(top * bottom.z, (vf)(0.9999f)));
  const v3 again = V3(div_f(passes * passes * bottom.x, 1.0f - both.x), div_f(passes * passes * bottom.y, 1.0f - both.y),
                      div_f(passes * passes * bottom.z, 1.0f - both.z));
  v3 sum = V3(top + again.x, top + again.y, top + again.z);
  const v3 step = V3(sqrt_f(both.x), sqrt_f(both.y), sqrt_f(both.z));
  v3 order = V3(again.x - passes, again.y - passes, again.z - passes);
  for (int m = 1; m <= 2; ++m) {
    order = mul3(order, mul3(step, sign));
    const vf far = (float)m * path;
    sum = add3(sum, scale3(mul3(order, thin_film_rgb(cie_x(far), cie_y(far), cie_z(far))), (vf)(2.0f)));
  }
  const v3 most = V3(thin_film_most_f0(film, f0.x), thin_film_most_f0(film, f0.y), thin_film_most_f0(film, f0.z));
  const v3 bound = schlick(most, (vf)(1.0f), weight);
  return V3(min_f(max_f(sum.x, none), bound.x), min_f(max_f(sum.y, none), bound.y), min_f(max_f(sum.z, none), bound.z));
}

#endif
