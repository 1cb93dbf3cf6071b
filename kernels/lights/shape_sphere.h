// SPDX-License-Identifier: Apache-2.0
// Sampling of spheres: from outside directions uniform in the cone that the sphere fills, from
// inside points uniform over its area, which at the surface is the cosine about its normal, and at
// the centre every direction alike.
#ifndef EK_LIGHT_SHAPE_SPHERE_H
#define EK_LIGHT_SHAPE_SPHERE_H
#include "lanes/basis.h"
#include "lights/shape_view.h"

EK_FN vi sphere_holds(ShapeView view) {
  return dot3(view.from, view.from) < 1.0f + 2.0f * max_component(view.slack);
}

// 1 - cos of half the cone's angle. sin^2 / (1 + cos) has no difference of nearly equal numbers,
// however far away the sphere is.
EK_FN vf sphere_cone(v3 from) {
  const vf sin2 = div_f(1.0f, dot3(from, from));
  return div_f(sin2, 1.0f + sqrt_f(1.0f - sin2));
}

// The concentric map to the disc gives the map to the cone, with 1 - cos as r^2. A line at the
// angle theta to the axis passes the centre at the distance h = D sin theta, and meets the sphere
// at the angle asin h - theta from the axis, seen from the centre.
// source  [Pharr, Jakob, Humphreys 2023, section 6.2.4], without its difference of squares
EK_FN ShapeChoice sphere_choose(ShapeView view, vf u, vf v) {
  const vf zero = (vf)(0.0f), one = (vf)(1.0f);
  const vi inside = sphere_holds(view);
  const vf distance = sqrt_f(dot3(view.from, view.from));
  const DiskPoint disk = warp_disk(u, v);
  const vf versine = (disk.r * disk.r) * sphere_cone(view.from);
  const vf h = min_f(distance * sqrt_f(versine * (2.0f - versine)), one), rest = sqrt_f((1.0f - h) * (1.0f + h));
  const vf cos_theta = 1.0f - versine, sin_theta = div_f(h, distance);
  const vf sin_middle = h * cos_theta - rest * sin_theta, cos_middle = rest * cos_theta + h * sin_theta;
  const vf across = disk.r > 0.0f ? div_f(sin_middle, disk.r) : zero;
  const Basis basis = basis_around(scale3(view.from, div_f(one, distance)));
  const v3 seen = to_world(basis, V3(across * disk.x, across * disk.y, cos_middle));
  const ShapeChoice choice = {select3(inside, warp_uniform_sphere(u, v), seen), zero};
  return choice;
}

EK_FN vf sphere_density(ShapeView view, ShapePoint at, vf part) {
  const vf within = density_sr_from_area(view, at.p, at.out, (vf)(EK_INV_4PI));
  return sphere_holds(view) ? within : div_f(EK_INV_2PI, sphere_cone(view.from));
}

#endif
