// SPDX-License-Identifier: Apache-2.0
// Step of stage `shade`: loads a vector of paths and finds the points of the surfaces that they
// hit.
#ifndef EK_SHADE_HIT_H
#define EK_SHADE_HIT_H
#include "stages/hit_walk.h"
#include "stages/shade/context.h"
#include "surface/instance_surface.h"
#include "surface/motion.h"

/// slot, lanes  of the paths (HitWalk)
EK_FN PathHit hit_load(const ShadeContext* c, uint slot, uint lanes) {
  global const uint* state = c->stage.state;
  PathHit hit;
  hit.path = path_load(state, slot);
  hit.live = (LANE_INDEX < (vu)(lanes)) & (hit.path.hit_triangle != EK_NO_HIT);
  hit.triangle = hit.live ? hit.path.hit_triangle : (vu)(0u);
  hit.t = state_vf(state, FIELD_hit_t, slot);
  hit.u = state_vf(state, FIELD_hit_u, slot);
  hit.v = state_vf(state, FIELD_hit_v, slot);
  const v3 dir = hit.path.dir;

#if EK_HAS_moving_surface
  const PoseSpan span = pose_span(c->scene, hit.triangle, hit.path.time);
  const vu resting = resting_triangle(span, hit.triangle);
#else
  const vu resting = hit.triangle;
#endif
  hit.corners = load_triangle(c->scene.triangles, resting);
#if EK_HAS_instance
  const HitInstance instance = hit_instance(c->scene, hit.live ? state_vu(state, FIELD_hit_instance, slot) : (vu)(0u));
  hit.corners = instance_triangle(instance, hit.corners);
#endif
#if EK_HAS_moving_surface
  if (ANY(span.moves)) hit.corners = moved_triangle(c->scene, span, hit.corners);
#endif
  hit.surface = surface_at(hit.corners, hit.u, hit.v, scale3(dir, hit.t));
#if EK_HAS_shape
  hit.on_shape = shape_surface(c->scene, hit.corners, hit.u, hit.path.origin, dir, hit.t, &hit.surface);
#endif
  hit.front = dot3(hit.surface.n_geom, dir) < 0.0f;
  hit.is_flat_lambert = shading_class_of(hit.corners.flags) == SHADING_FLAT_LAMBERT;
#if !EK_CHUNKED
  if (c->scene.absent_classes != 0u) hit.is_flat_lambert = shades_only(c->scene, SHADING_FLAT_LAMBERT);
#endif
  hit.needs_attributes = (1 - EK_HAS_flat_lambert_hits) | EK_HAS_texcoord | (ANY(hit.live & !hit.is_flat_lambert) != 0);

  hit.attributes = no_attributes();
  // Of the attributes only normals and tangents move.
  const vu fixed = EK_HAS_uv | EK_HAS_uv1 | EK_HAS_tangent | EK_HAS_vertex_color ? hit.triangle : resting;
  if (hit.needs_attributes) hit.attributes = hit_attributes(c->scene, fixed, hit.u, hit.v);
#if EK_HAS_moving_surface
  if (hit.needs_attributes & (ANY(span.moves) != 0)) hit.attributes = moved_attributes(c->scene, span, hit.u, hit.v, hit.attributes);
#endif
#if EK_HAS_instance
  hit.attributes = instance_attributes(c->scene, instance, hit.triangle, hit.u, hit.v, hit.attributes);
#endif
#if EK_HAS_shape
  hit.attributes = shape_attributes(c->scene, hit.corners, hit.on_shape, hit.surface.n_geom, hit.attributes);
#endif
#if !EK_CHUNKED
  // Attributes may still be wanted for a layer of the film, but they are none that turn a normal.
  if (shades_only(c->scene, SHADING_FLAT_LAMBERT)) hit.needs_attributes = 0;
#endif
  return hit;
}

#endif
