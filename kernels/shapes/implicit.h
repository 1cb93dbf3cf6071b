// SPDX-License-Identifier: Apache-2.0
// Kind `implicit`: f = 0 within bounds. The shape's own space is that of the formula about the
// middle of its bounds; a, b, c: half of their extent. f is above 0 outside. Opacity does not
// count: a ray meets the surface or not.
#ifndef EK_SHAPE_IMPLICIT_H
#define EK_SHAPE_IMPLICIT_H
#include "shapes/implicit_root.h"
#include "shapes/span.h"
#include "lanes/simd.h"

// Runs what follows for each formula with the lanes that have it; one lane has one.
#if EK_WIDTH == 1
#define EK_FOR_EACH_FORMULA(k, formula) for (uint k = (formula), more_ = 1; more_ != 0; more_ = 0)
#else
#define EK_FOR_EACH_FORMULA(k, formula) for (uint k = 0; k < EK_FORMULA_COUNT; ++k)
#endif

EK_FN ImplicitRay implicit_own_ray(ShapeLanes s, ShapeWorldLanes world, v3 o, v3 d) {
  const v3 extent = V3(s.a, s.b, s.c);
  return implicit_ray(add3(o, world.middle), d, sub3(world.middle, extent), add3(world.middle, extent));
}

// A search for where the ray o + z d, in the shape's own space, first meets f = 0 with z > 0, in
// lanes that have an implicit shape.
typedef struct {
  vu shape;
  vi lanes;
  vi culls;  // of these lanes, those that pass backs, where f grows along the ray
  v3 o, d;
  vf until;  // how far to search, in z
} ImplicitSearch;

/// The root of each searching lane, and `root` in the others. Its part is the root in lengths of
/// the clipped ray, from which the point is found again without the error of z. gave_up: set to the
/// z at which a search was given up
EK_FN ShapeRoot implicit_shape_root(SceneData scene, ShapeLanes s, const ImplicitSearch* search, ShapeRoot root, vf* gave_up) {
  const ShapeWorldLanes world = load_shape_world(scene.shapes, search->shape);
  const ImplicitRay ray = implicit_own_ray(s, world, search->o, search->d);
  EK_FOR_EACH_FORMULA(k, world.formula) {
    const vi mine = search->lanes & (world.formula == (vu)(k));
    if (!ANY(mine)) continue;
    const ImplicitRoot found = implicit_root(k, ray, mine, search->culls, div_f(search->until, ray.per_length) - ray.begin);
    const vf z = (ray.begin + found.s) * ray.per_length;
    root.hit = mine ? (found.hit & (z > 0.0f)) : root.hit;
    root.z = mine ? z : root.z;
    root.part = mine ? found.s : root.part;
    root.front = root.front | mine;  // else the search has passed it
    *gave_up = (mine & found.given_up) ? z : *gave_up;
  }
  return root;
}

/// The point of root `part` of the ray origin + t dir, as ShapePoint has it.
// The ray is the one that was searched: shape_hit divides directions by their longest component.
EK_FN ShapePoint implicit_shape_point(ShapeLanes s, ShapeWorldLanes world, vi live, v3 origin, v3 dir, vf part, ShapePoint point) {
  const vf longest = max_component(abs3(dir));
  const v3 o = shape_vector(s, sub3(origin, s.center));
  const ImplicitRay ray = implicit_own_ray(s, world, o, shape_vector(s, V3(div_f(dir.x, longest), div_f(dir.y, longest), div_f(dir.z, longest))));
  // To the world and back: two products of matrices, as in shape_surface, and the rounding of a
  // point in the world.
  const v3 extent = V3(s.a, s.b, s.c), center = abs3(s.center);
  const v3 size = V3(dot3(abs3(world.x), extent), dot3(abs3(world.y), extent), dot3(abs3(world.z), extent));
  const v3 moved = add3(scale3(size, (vf)(0x1p-20f)), scale3(center, (vf)(0x1p-23f)));
  const vf noise = max_f(max_f(dot3(abs3(s.x), moved), dot3(abs3(s.y), moved)), dot3(abs3(s.z), moved)) + ray.reach * 0x1p-23f;
  EK_FOR_EACH_FORMULA(k, world.formula) {
    const vi mine = live & (world.formula == (vu)(k));
    if (!ANY(mine)) continue;
    const ImplicitPoint at = implicit_point(k, ray, mine, part, noise);
    point.p = select3(mine, sub3(at.p, world.middle), point.p);
    point.out = select3(mine, at.n, point.out);
    point.clearance = mine ? at.error : point.clearance;
  }
  return point;
}

#endif
