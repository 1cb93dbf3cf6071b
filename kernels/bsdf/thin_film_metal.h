// SPDX-License-Identifier: Apache-2.0
// A thin film on a conductor of index eta + i k, by Airy's sum with both polarisations and the
// phase shift of metal [Belcour and Barla 2017, "A Practical Extension to Microfacet Theory for the
// Modeling of Varying Iridescence"]. The reflectance at one wavelength is
//   R = |r12 + r23 E|^2 / |1 + r12 r23 E|^2 = 1 - A (1 + 2 sum Re q^m),
//   q = -r12 r23 E,   A = (1 - R12) (1 - R23) / (1 - R12 R23)
// with r12 of the film's upper side, r23 of the metal seen from the film, R12 and R23 their squared
// absolute values, and E = exp(2 pi i path / lambda). A is small where the metal reflects much, and
// so are the orders beyond the last that is summed.
#ifndef EK_THIN_FILM_METAL_H
#define EK_THIN_FILM_METAL_H
#include "bsdf/thin_film.h"

#define EK_THIN_FILM_METAL_ORDERS 8u

// A, and q without E, of one polarisation in R, G and B.
typedef struct { v3 absorbed, re, im; } ThinFilmEcho;

// The same of one channel.
typedef struct { vf absorbed, re, im; } ThinFilmEchoChannel;

// top, passes  r12 and 1 - R12;  re, im, kept  of r23, and 1 - R23
EK_FN ThinFilmEchoChannel thin_film_echo(vf top, vf passes, vf re, vf im, vf kept) {
  // 1 - R12 R23 without a difference of nearly equal numbers.
  const vf denominator = max_f(passes + (top * top) * kept, (vf)(0x1p-60f));
  ThinFilmEchoChannel e = {div_f(passes * kept, denominator), -top * re, -top * im};
  return e;
}

// The terms of Fresnel's equations that the film's index and the angle determine.
// across, along: polarisation perpendicular and parallel to the plane of incidence
typedef struct {
  vf index2, cosine;  // square of its index; of the light in the air
  vf g;               // index times the cosine within the film
  vf top_across, passes_across, top_along, passes_along;
} ThinFilmTop;

EK_FN ThinFilmTop thin_film_top(vf index, vf cosine) {
  ThinFilmTop t;
  t.index2 = index * index;
  t.cosine = cosine;
  const vf k = (index - 1.0f) * (index + 1.0f), tiny = (vf)(0x1p-30f);
  t.g = sqrt_f(cosine * cosine + k);
  const vf sum = max_f(cosine + t.g, tiny), sum_along = max_f(t.index2 * cosine + t.g, tiny);
  t.top_across = div_f(-div_f(k, sum), sum);
  t.passes_across = div_f(4.0f * (cosine * t.g), sum * sum);
  t.top_along = div_f(t.g - t.index2 * cosine, sum_along);
  t.passes_along = div_f(4.0f * (t.index2 * cosine * t.g), sum_along * sum_along);
  return t;
}

// eta, k  of the metal in one channel; across, along: the two polarisations
EK_FN void thin_film_echoes(ThinFilmTop t, vf eta, vf k, ThinFilmEchoChannel* across, ThinFilmEchoChannel* along) {
  const vf s2 = (1.0f - t.cosine) * (1.0f + t.cosine);
  // a + i b = sqrt((eta + i k)^2 - sin^2), as in fresnel_conductor.
  const vf square = (eta - k) * (eta + k), difference = square - s2, twice = 2.0f * (eta * k);
  const vf sum = sqrt_f(difference * difference + twice * twice);
  const vf half_less = 0.5f * (sum - difference), half_more = 0.5f * (sum + difference);
  const vf smaller2 = sum > 0.0f ? div_f(0.25f * (twice * twice), max_f(0.5f * (sum + abs_f(difference)), (vf)(0x1p-100f))) : (vf)(0.0f);
  const vf a = sqrt_f(difference >= 0.0f ? half_more : smaller2), b = sqrt_f(difference >= 0.0f ? smaller2 : half_less);
  const vf tiny = (vf)(0x1p-100f);
  const vf inverse = div_f(1.0f, max_f((t.g + a) * (t.g + a) + b * b, tiny));
  *across = thin_film_echo(t.top_across, t.passes_across, ((t.g * t.g - b * b) - a * a) * inverse, -2.0f * (t.g * b) * inverse,
                      4.0f * (t.g * a) * inverse);
  // Along: (U - V) / (U + V) with U = n^2 (a + i b) and V = g (eta + i k)^2.
  const vf ur = t.index2 * a, ui = t.index2 * b, vr = t.g * square, vi_ = t.g * twice;
  const vf inverse_along = div_f(1.0f, max_f((ur + vr) * (ur + vr) + (ui + vi_) * (ui + vi_), tiny));
  *along = thin_film_echo(t.top_along, t.passes_along, ((ur * ur + ui * ui) - (vr * vr + vi_ * vi_)) * inverse_along,
                     2.0f * (ui * vr - ur * vi_) * inverse_along, 4.0f * (t.index2 * t.g * (a * (sum + s2))) * inverse_along);
}

// exp(2 pi i m path / lambda) averaged over one of the Gaussians of thin_film.h, stepped from one
// order m to the next: d^(m m) exp(2 pi i m middle path), where the Gaussian's width damps the
// first order to d.
typedef struct { vf re, im, step_re, step_im, shrink; } ThinFilmWave;

EK_FN ThinFilmWave thin_film_wave(vf path, CieGaussian gaussian) {
  const CieWave first = cie_wave(path, gaussian);
  const ThinFilmWave w = {(vf)(1.0f), (vf)(0.0f), first.re, first.im, first.size * first.size};
  return w;
}

EK_FN ThinFilmWave thin_film_wave_next(ThinFilmWave w) {
  const ThinFilmWave next = {w.re * w.step_re - w.im * w.step_im, w.re * w.step_im + w.im * w.step_re, w.step_re * w.shrink,
                         w.step_im * w.shrink, w.shrink};
  return next;
}

// 2 A Re q^m of one polarisation; power: q^(m - 1) before the call, q^m after it.
EK_FN v3 thin_film_echo_order(ThinFilmEcho e, v3* power_re, v3* power_im, v3 wave_re, v3 wave_im) {
  const v3 re = sub3(mul3(*power_re, e.re), mul3(*power_im, e.im)), im = add3(mul3(*power_re, e.im), mul3(*power_im, e.re));
  *power_re = re;
  *power_im = im;
  return mul3(scale3(e.absorbed, (vf)(2.0f)), sub3(mul3(re, wave_re), mul3(im, wave_im)));
}

EK_FN ThinFilmEcho thin_film_echo3(ThinFilmEchoChannel r, ThinFilmEchoChannel g, ThinFilmEchoChannel b) {
  const ThinFilmEcho e = {V3(r.absorbed, g.absorbed, b.absorbed), V3(r.re, g.re, b.re), V3(r.im, g.im, b.im)};
  return e;
}

/// Reflectance, R, G and B, [0, 1].
/// cosine  of the light with the normal, in air, [0, 1]
/// eta, k  of the conductor, R, G and B, <= 2^14
EK_FN_ONCE v3 thin_film_conductor_reflectance(ThinFilm film, v3 eta, v3 k, vf cosine) {
  const ThinFilmTop top = thin_film_top(thin_film_index(film), cosine);
  ThinFilmEchoChannel across[3], along[3];
  thin_film_echoes(top, eta.x, k.x, &across[0], &along[0]);
  thin_film_echoes(top, eta.y, k.y, &across[1], &along[1]);
  thin_film_echoes(top, eta.z, k.z, &across[2], &along[2]);
  const ThinFilmEcho s = thin_film_echo3(across[0], across[1], across[2]), p = thin_film_echo3(along[0], along[1], along[2]);
  const vf one = (vf)(1.0f), none = (vf)(0.0f), path = 2.0f * (film.thickness * top.g);
  v3 s_re = V3(one, one, one), s_im = V3(none, none, none), p_re = s_re, p_im = s_im;
  v3 absorbed = add3(s.absorbed, p.absorbed);
  ThinFilmWave red = thin_film_wave(path, cie_red), violet = thin_film_wave(path, cie_violet), green = thin_film_wave(path, cie_green),
           blue = thin_film_wave(path, cie_blue);
  for (uint m = 1; m <= EK_THIN_FILM_METAL_ORDERS; ++m) {
    red = thin_film_wave_next(red);
    violet = thin_film_wave_next(violet);
    green = thin_film_wave_next(green);
    blue = thin_film_wave_next(blue);
    const v3 re = thin_film_rgb(cie_red.weight * red.re + cie_violet.weight * violet.re, cie_green.weight * green.re, cie_blue.weight * blue.re),
             im = thin_film_rgb(cie_red.weight * red.im + cie_violet.weight * violet.im, cie_green.weight * green.im, cie_blue.weight * blue.im);
    absorbed = add3(absorbed, add3(thin_film_echo_order(s, &s_re, &s_im, re, im), thin_film_echo_order(p, &p_re, &p_im, re, im)));
  }
  const v3 r = V3(one - 0.5f * absorbed.x, one - 0.5f * absorbed.y, one - 0.5f * absorbed.z);
  return V3(min_f(max_f(r.x, none), one), min_f(max_f(r.y, none), one), min_f(max_f(r.z, none), one));
}

#endif
