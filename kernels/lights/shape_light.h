// SPDX-License-Identifier: Apache-2.0
// Emissive shapes as lights. A point of the shape is chosen in its own space, where it has a
// standard size; the density is that of the direction towards it, per steradian of that space.
// Lines stay lines, so what is visible from a point is the same in both spaces, and a linear map L
// takes the solid angle d_own of a direction d to d_own = |det L| / |L d|^3 d_world, whether it
// turns, stretches or shears. Each kind that can be sampled has, in shape_sphere.h, shape_flat.h or
// shape_round.h,
//   <name>_choose   a point of the surface, and its part (shapes/shape.h)
//   <name>_density  of the direction towards a point, whether it was chosen or a scattered ray met
//                   it
// and a line in each of the two functions below.
#ifndef EK_LIGHT_SHAPE_H
#define EK_LIGHT_SHAPE_H
#include "lights/light.h"
#include "lights/shape_flat.h"
#include "lights/shape_round.h"
#include "lights/shape_sphere.h"
#include "lights/shape_view.h"
#include "shapes/shape_surface.h"

EK_FN ShapeChoice shape_choose(ShapeView view, vf u, vf v) {
  const vf zero = (vf)(0.0f);
  ShapeChoice choice = {V3(zero, zero, zero), zero};
#define EK_CHOOSE(name)                                            \
  if (EK_HAS_##name) {                                             \
    const vi is_kind = view.shape.kind == (uint)SHAPE_##name;      \
    if (ANY(is_kind)) {                                            \
      const ShapeChoice c = name##_choose(view, u, v);             \
      choice.p = select3(is_kind, c.p, choice.p);                  \
      choice.part = is_kind ? c.part : choice.part;                \
    }                                                              \
  }
  EK_CHOOSE(sphere)
  EK_CHOOSE(box)
  EK_CHOOSE(plane)
  EK_CHOOSE(cylinder)
  EK_CHOOSE(capsule)
#undef EK_CHOOSE
  return choice;
}

EK_FN vf shape_density(ShapeView view, ShapePoint at, vf part) {
  vf density = (vf)(0.0f);
#define EK_DENSITY(name)                                                                \
  if (EK_HAS_##name) {                                                                  \
    const vi is_kind = view.shape.kind == (uint)SHAPE_##name;                           \
    if (ANY(is_kind)) density = is_kind ? name##_density(view, at, part) : density;     \
  }
  EK_DENSITY(sphere)
  EK_DENSITY(box)
  EK_DENSITY(plane)
  EK_DENSITY(cylinder)
  EK_DENSITY(capsule)
#undef EK_DENSITY
  return density;
}

/// The rows of the transform to own space, scaled alike by a power of two, which is exact: they may
/// be as small as 2^-60.
typedef struct {
  v3 x, y, z;
  vf scale;
} ShapeRows;

EK_FN ShapeRows shape_rows(ShapeLanes s) {
  const vf largest = max_f(max_f(max_component(abs3(s.x)), max_component(abs3(s.y))), max_component(abs3(s.z)));
  const vf scale = inverse_power_of_two(largest);
  const ShapeRows rows = {scale3(s.x, scale), scale3(s.y, scale), scale3(s.z, scale), scale};
  return rows;
}
EK_FN vf volume_of(ShapeRows rows) { return abs_f(dot3(rows.x, cross3(rows.y, rows.z))); }

// Steradians of own space per steradian of the world, about the unit direction dir.
EK_FN vf own_sr_per_sr(ShapeLanes s, v3 dir) {
  const ShapeRows rows = shape_rows(s);
  const v3 d = V3(dot3(rows.x, dir), dot3(rows.y, dir), dot3(rows.z, dir));
  const vf length2 = dot3(d, d);
  return div_f(volume_of(rows), length2 * sqrt_f(length2));
}

EK_FN ShapeView shape_view(ShapeLanes s, ShapeWorldLanes world, v3 p) {
  const v3 ones = V3((vf)(1.0f), (vf)(1.0f), (vf)(1.0f));
  const v3 rounding = scale3(abs3(p), (vf)(0x1p-20f));
  const v3 of_p = V3(dot3(abs3(s.x), rounding), dot3(abs3(s.y), rounding), dot3(abs3(s.z), rounding));
  v3 slack = add3(scale3(shape_slack(s, world, ones), (vf)(4.0f)), of_p);
  if (EK_HAS_opacity) {  // with endless slack every point counts as inside
    const v3 endless = V3(EK_INFINITY, EK_INFINITY, EK_INFINITY);
    slack = select3(world.formula == EK_SHAPE_SHOWS_INSIDE, endless, slack);
  }
  const ShapeView view = {s, shape_vector(s, sub3(p, s.center)), slack, world.part_m2};
  return view;
}

// A ray's hit of a shape.
typedef struct {
  vi is_shape;  // mask: the lane has one
  ShapePoint at;
  vf part;
} ShapeLightHit;

/// Density with which shape_light_sample chooses the point where a ray met a shape, per sr from the
/// ray's origin; the choice of the shape is included.
/// corners      record that was met
/// hit          the point in own space (shape_surface)
/// origin, dir  of the ray; dir unit
EK_FN_ONCE vf shape_light_pdf_sr(SceneData scene, TriangleLanes corners, ShapeLightHit hit, v3 origin, v3 dir) {
  const vu index = hit.is_shape ? AS_U(corners.n.x) : (vu)(0u);
  const ShapeLanes s = load_shape(scene.shapes, index);
  const ShapeView view = shape_view(s, load_shape_world(scene.shapes, index), origin);
  const vf pdf = shape_density(view, hit.at, hit.part) * own_sr_per_sr(s, dir);
  return corners.light_pdf_m2 > 0.0f ? pdf * corners.light_pdf_m2 : (vf)(0.0f);
}

#if EK_HAS_light_paths
/// A shape as seen from a point from where all of its surface is chosen by its area: the middle of
/// a solid, and for a plane a point off it.
EK_FN ShapeView shape_view_of_all(ShapeLanes s, ShapeWorldLanes world) {
  const vf zero = (vf)(0.0f), off = s.kind == (uint)SHAPE_plane ? (vf)(1.0f) : zero;
  const ShapeView view = {s, V3(zero, off, zero), V3(zero, zero, zero), world.part_m2};
  return view;
}

/// Density per m^2 with which shape_choose finds a point with the view of all.
/// The transform takes an area of own space with the unit normal n to one |L^T n| / |det L| times
/// as large.
EK_FN vf shape_pdf_m2(ShapeView view, ShapePoint at, vf part) {
  const v3 d = sub3(at.p, view.from);
  const vf out2 = dot3(at.out, at.out), distance2 = dot3(d, d);
  const vf own = div_f(shape_density(view, at, part) * abs_f(dot3(at.out, d)), distance2 * sqrt_f(distance2 * out2));
  const ShapeRows rows = shape_rows(view.shape);
  const v3 n = add3(add3(scale3(rows.x, at.out.x), scale3(rows.y, at.out.y)), scale3(rows.z, at.out.z));
  return div_f(div_f(own * volume_of(rows) * sqrt_f(div_f(out2, dot3(n, n))), rows.scale), rows.scale);
}
#endif

/// Puts a sample's point on its shape, with its error and normal, and in b1 and b2 the texture
/// coordinates.
EK_FN LightSample shape_sample_at(LightSample sample, ShapePoint point, Surface surface) {
  const vi is_shape = sample.is_shape;
  sample.p = select3(is_shape, surface.p, sample.p);
  sample.p_error = select3(is_shape, surface.p_error, sample.p_error);
  sample.n = select3(is_shape, surface.n_geom, sample.n);
  sample.b1 = is_shape ? point.u : sample.b1;
  sample.b2 = is_shape ? point.v : sample.b2;
  return sample;
}

/// The shape of a sample; some valid one where its light is none.
typedef struct {
  ShapeLanes own;
  ShapeWorldLanes world;
  v3 slack;  // shape_slack of its surface
} SampledShape;

EK_FN SampledShape sampled_shape(SceneData scene, LightSample sample) {
  const vu index = load_word_u(Triangle, scene.triangles, sample.is_shape ? sample.triangle : (vu)(0u), n_x);
  const vu shape = sample.is_shape ? index : (vu)(0u);
  SampledShape found;
  found.own = load_shape(scene.shapes, shape);
  found.world = load_shape_world(scene.shapes, shape);
  found.slack = shape_slack(found.own, found.world, V3((vf)(1.0f), (vf)(1.0f), (vf)(1.0f)));
  return found;
}

/// Completes a sample whose light is a shape: the point on it as seen from p, its error, its
/// normal, the density per sr, and in b1 and b2 the texture coordinates.
EK_FN_ONCE LightSample shape_light_sample(SceneData scene, LightSample sample, v3 p) {
  const vi is_shape = sample.is_shape;
  if (!ANY(is_shape)) return sample;
  const SampledShape shape = sampled_shape(scene, sample);
  const ShapeView view = shape_view(shape.own, shape.world, p);
  const ShapeChoice choice = shape_choose(view, sample.u, sample.v);
  const ShapePoint point = shape_point(shape.own, choice.p, choice.part, shape.slack);
  const Surface surface = shape_world_surface(shape.own, shape.world, point);
  const vf pdf = shape_density(view, point, choice.part) * own_sr_per_sr(shape.own, normalize3(sub3(surface.p, p)));
  sample.pdf = is_shape ? sample.pdf * pdf : sample.pdf;
#if EK_HAS_light_paths
  const vf pdf_m2 = shape_pdf_m2(shape_view_of_all(shape.own, shape.world), point, choice.part);
  sample.pdf_of_point = is_shape ? pdf_m2 : (vf)(1.0f);
#endif
  return shape_sample_at(sample, point, surface);
}

#if EK_HAS_light_paths
/// Completes a sample from which a light path starts, if its light is a shape: a point of all of
/// its surface, and pdf_of_point.
EK_FN_ONCE LightSample shape_light_start(SceneData scene, LightSample sample) {
  if (!ANY(sample.is_shape)) return sample;
  const SampledShape shape = sampled_shape(scene, sample);
  const ShapeView view = shape_view_of_all(shape.own, shape.world);
  const ShapeChoice choice = shape_choose(view, sample.u, sample.v);
  const ShapePoint point = shape_point(shape.own, choice.p, choice.part, shape.slack);
  sample.pdf_of_point = sample.is_shape ? shape_pdf_m2(view, point, choice.part) : (vf)(1.0f);
  return shape_sample_at(sample, point, shape_world_surface(shape.own, shape.world, point));
}
#endif

#endif
