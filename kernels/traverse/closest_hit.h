// SPDX-License-Identifier: Apache-2.0
// The hit of a ray and the rule that chooses it, written once and included by hit.h for
//   EK_ONE_RAY 1  one ray: Hit, no_hit(), is_closer(), keep_given_up()
//   EK_ONE_RAY 0  EK_WIDTH rays: HitLanes, and the same functions with the ending _lanes
#if EK_ONE_RAY
#define HIT_TYPE Hit
#define HIT(name) name
#define HitF float
#define HitI int
#define HitU uint
#else
#define HIT_TYPE HitLanes
#define HIT(name) name##_lanes
#define HitF vf
#define HitI vi
#define HitU vu
#endif

// The closest hit so far. t, in lengths of the direction, is the ray's end while nothing was hit.
// triangle   EK_NO_HIT: nothing was hit
// instance   0: the triangle is stored in the world; INSTANCE_SHAPE: it is a shape; else 1 + the
//            instance, in whose mesh's space the record is. It is read only with EK_HAS_instance.
// gave_up    the first t at which the search for an implicit surface was given up, or infinity; and
//            that surface's number. It is read only with EK_HAS_implicit.
// tests, steps  counted in a program with EK_COUNT 1 (`bench rays`): tests of triangles, and steps
// through the structure
typedef struct {
  HitF t, u, v;  // u, v: weights of corners b and c
  HitU triangle, instance;
  HitF gave_up;
  HitU gave_up_surface;
#if EK_COUNT
  uint tests, steps;
#endif
} HIT_TYPE;

EK_FN HIT_TYPE HIT(no_hit)(HitF t_max) {
  HIT_TYPE hit;
  hit.t = t_max;
  hit.u = hit.v = (HitF)(0.0f);
  hit.triangle = hit.instance = (HitU)(EK_NO_HIT);
  hit.gave_up = (HitF)(INFINITY);
  hit.gave_up_surface = (HitU)(EK_NO_HIT);
#if EK_COUNT
  hit.tests = hit.steps = 0u;
#endif
  return hit;
}

// THE rule of the closest hit, which stands nowhere else: the smallest t wins; among equals the
// smallest instance, and within one the smallest triangle. So the order of traversal does not show.
EK_FN HitI HIT(is_closer)(const HIT_TYPE* hit, HitF t, HitU triangle, HitU instance) {
  HitI before = triangle < hit->triangle;
  if (EK_HAS_instance) before = (instance < hit->instance) | ((instance == hit->instance) & before);
  return (t < hit->t) | ((t == hit->t) & before);
}

// Keeps the nearest t at which a search was given up; among equals the surface of the smallest
// number.
EK_FN void HIT(keep_given_up)(HitF t, HitU surface, HitF* nearest, HitU* its_surface) {
  const HitI nearer = (t < *nearest) | ((t == *nearest) & (surface < *its_surface));
  *nearest = nearer ? t : *nearest;
  *its_surface = nearer ? surface : *its_surface;
}

#undef HIT_TYPE
#undef HIT
#undef HitF
#undef HitI
#undef HitU
#undef EK_ONE_RAY
