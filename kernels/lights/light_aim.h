// SPDX-License-Identifier: Apache-2.0
// Light paths are aimed at targets (lights/light_path.h).
//
// A start has coordinates in the unit square of the target that it is aimed at: those from which
// warp_cone makes its direction within the target's cone, or warp_disk its place on the target's
// disc. What a trial has learned about starts (shared/light_target.h) moves the coordinates as
// guide_warp does, and makes some targets more likely than others. The density of a start is a sum
// over all targets, of which several may lie in the same direction.
#ifndef EK_LIGHT_AIM_H
#define EK_LIGHT_AIM_H
#include "lights/light.h"
#include "shared/light_target.h"

#if EK_HAS_light_paths
EK_FN uint aim_flags(LightData lights) { return lights.light_paths.light_aim[AIM_flags]; }
EK_FN uint aim_is_learned(LightData lights) { return aim_flags(lights) & EK_AIM_LEARNED; }

/// The table of a target. kind: EK_AIM_CONE or EK_AIM_DISC; target: index
EK_FN GuideCell target_table(LightData lights, vu target, uint kind) {
  const GuideCell table = {lights.light_paths.light_aim,
                           aim_is_learned(lights) ? EK_AIM_CELL(target, kind) : (vu)(EK_NO_CELL)};
  return table;
}

/// Weight of a target among all, apart from its solid angle or its disc; 1 if nothing was learned.
EK_FN float target_weight(LightData lights, uint target, uint kind) {
  global const float* words = (global const float*)lights.light_paths.light_aim;
  return aim_is_learned(lights) ? words[EK_AIM_CELL(target, kind) * EK_GUIDE_CELL_WORDS + AIM_weight] : 1.0f;
}

/// Density of a start over that of an even one. x, y: the point of the unit disc to which warp_disk
/// maps the start's coordinates
EK_FN vf target_density(LightData lights, uint target, uint kind, vf x, vf y) {
  const float weight = target_weight(lights, target, kind);
  if (!aim_is_learned(lights)) return (vf)(weight);
  return weight * guide_density(target_table(lights, (vu)(target), kind), V3(x, y, (vf)(0.0f)));
}

/// Solid angle of a target over 2 pi, in [0, 2]; all around where `from` lies within the ball.
/// target  centre, and radius; world, metres
EK_FN vf target_cone(float4 target, v3 from) {
  const v3 way = sub3(splat3(target), from);
  const vf sin2 = div_f(target.w * target.w, dot3(way, way));
  const vf outside = div_f(sin2, 1.0f + sqrt_f(max_f(1.0f - sin2, (vf)(0.0f))));  // 1 - cosine, also of small angles
  return sin2 < 1.0f ? outside : (vf)(2.0f);
}

/// Local axes of a target's cone, or +z where a point is its centre.
EK_FN Basis target_basis(v3 centre, v3 from) {
  const v3 axis = sub3(centre, from);
  const vf length2 = dot3(axis, axis);
  return basis_around(
      select3(length2 > 0.0f, scale3(axis, div_f((vf)(1.0f), sqrt_f(length2))), V3((vf)(0.0f), (vf)(0.0f), (vf)(1.0f))));
}

/// Sum of target_cone over all targets, by their weights.
EK_FN vf all_target_cones(constant Frame* frame, LightData lights, v3 from) {
  vf sum = (vf)(0.0f);
  for (uint i = 0; i < frame->light_target_count; ++i)
    sum = sum + target_cone(lights.light_paths.light_targets[i], from) * target_weight(lights, i, EK_AIM_CONE);
  return sum;
}

/// The squared distance of a ball's centre from the line through `from` along dir.
EK_FN vf distance2_from_line(float4 target, v3 from, v3 dir) {
  const v3 way = sub3(splat3(target), from);
  const v3 across = sub3(way, scale3(dir, dot3(way, dir)));
  return dot3(across, across);
}

/// As target_density, of a direction within the target's cone.
EK_FN vf cone_density(LightData lights, uint i, v3 from, v3 dir, vf cone) {
  if (!aim_is_learned(lights)) return (vf)(target_weight(lights, i, EK_AIM_CONE));
  // The inverse of warp_cone.
  const v3 within = to_local(target_basis(splat3(lights.light_paths.light_targets[i]), from), dir);
  const vf stretch = sqrt_f(max_f(cone * (1.0f + within.z), (vf)(0x1p-60f)));
  return target_density(lights, i, EK_AIM_CONE, div_f(within.x, stretch), div_f(within.y, stretch));
}

/// Sum, over the targets that a ray meets, of the density of its start over that of an even one
/// (cone_density): their number, if nothing was learned. dir: unit
EK_FN vf density_of_targets_met(constant Frame* frame, LightData lights, v3 from, v3 dir) {
  vf met = (vf)(0.0f);
  for (uint i = 0; i < frame->light_target_count; ++i) {
    const float4 target = lights.light_paths.light_targets[i];
    const v3 way = sub3(splat3(target), from);
    const vf cone = target_cone(target, from);
    const vi ahead = (dot3(way, dir) > 0.0f) & (distance2_from_line(target, from, dir) <= target.w * target.w);
    const vi meets = ahead | (cone == 2.0f);
    if (ANY(meets)) met = met + (meets ? cone_density(lights, i, from, dir, cone) : (vf)(0.0f));
  }
  return met;
}

/// Density of the directions of light paths from a point, per sr.
EK_FN vf target_pdf_sr(constant Frame* frame, LightData lights, v3 from, v3 dir) {
  const vf met = density_of_targets_met(frame, lights, from, dir);
  return met > 0.0f ? met * div_f(EK_INV_2PI, all_target_cones(frame, lights, from)) : (vf)(0.0f);
}

/// Sum of the squared radii of all targets, by their weights.
EK_FN float all_target_radii2(constant Frame* frame, LightData lights) {
  float sum = 0.0f;
  for (uint i = 0; i < frame->light_target_count; ++i) {
    const float radius = lights.light_paths.light_targets[i].w;
    sum += radius * radius * target_weight(lights, i, EK_AIM_DISC);
  }
  return sum;
}

/// As target_density, of a line along dir through the target's disc.
EK_FN vf disc_density(LightData lights, uint i, v3 p, v3 dir) {
  if (!aim_is_learned(lights)) return (vf)(target_weight(lights, i, EK_AIM_DISC));
  const float4 target = lights.light_paths.light_targets[i];
  const v3 across = to_local(basis_around(dir), sub3(p, splat3(target)));
  return target_density(lights, i, EK_AIM_DISC, div_f(across.x, target.w), div_f(across.y, target.w));
}

/// Density of light paths of one direction on a plane across it, per m^2.
/// p  on the light path, before or behind the targets; dir: unit, along it
EK_FN vf parallel_pdf_m2(constant Frame* frame, LightData lights, v3 p, v3 dir) {
  vf met = (vf)(0.0f);
  for (uint i = 0; i < frame->light_target_count; ++i) {
    const float4 target = lights.light_paths.light_targets[i];
    const vi meets = distance2_from_line(target, p, dir) <= target.w * target.w;
    if (ANY(meets)) met = met + (meets ? disc_density(lights, i, p, dir) : (vf)(0.0f));
  }
  return met * div_f(EK_INV_PI, all_target_radii2(frame, lights));
}

/// Moves the coordinates of a start as its target's table has it. returns the name of the start
/// (shared/light_target.h)
EK_FN vu aim_warp(LightData lights, vu target, uint kind, v3* random) {
  guide_warp(target_table(lights, target, kind), &random->y, &random->z);
  const vu row = AS_U(TO_I(random->y * (float)EK_GUIDE_ROWS)), column = AS_U(TO_I(random->z * (float)EK_GUIDE_ROWS));
  return EK_AIM_START(target, kind, row * EK_GUIDE_ROWS + column);
}

/// A direction from a point towards a target.
/// random  numbers in [0, 1)^3: x chooses the target, y and z the direction
/// start   gets the name of the start
EK_FN v3 direction_to_targets(constant Frame* frame, LightData lights, v3 from, v3 random, vu* start) {
  const vf chosen = random.x * all_target_cones(frame, lights, from);
  vf before = (vf)(0.0f), cone = (vf)(0.0f);
  vu target = (vu)(0u);
  v3 centre = from;
  for (uint i = 0; i < frame->light_target_count; ++i) {
    const float4 ball = lights.light_paths.light_targets[i];
    const vf own = target_cone(ball, from);
    const vi takes = before <= chosen;  // the last one that does is the chosen one
    cone = takes ? own : cone;
    target = takes ? (vu)(i) : target;
    centre = select3(takes, splat3(ball), centre);
    before = before + own * target_weight(lights, i, EK_AIM_CONE);
  }
  *start = aim_warp(lights, target, EK_AIM_CONE, &random);
  return to_world(target_basis(centre, from), warp_cone(random.y, random.z, cone));
}

/// A point of the targets' discs across dir.
/// random, start  as of direction_to_targets
EK_FN v3 point_of_discs(constant Frame* frame, LightData lights, v3 dir, v3 random, vu* start) {
  const vf chosen = random.x * all_target_radii2(frame, lights);
  vf radius = (vf)(0.0f);
  vu target = (vu)(0u);
  v3 centre = dir;
  float before = 0.0f;
  for (uint i = 0; i < frame->light_target_count; ++i) {
    const float4 ball = lights.light_paths.light_targets[i];
    const vi takes = before <= chosen;
    radius = takes ? (vf)(ball.w) : radius;
    target = takes ? (vu)(i) : target;
    centre = select3(takes, splat3(ball), centre);
    before += ball.w * ball.w * target_weight(lights, i, EK_AIM_DISC);
  }
  *start = aim_warp(lights, target, EK_AIM_DISC, &random);
  const DiskPoint at = warp_disk(random.y, random.z);
  const Basis basis = basis_around(dir);
  return add3(centre, scale3(add3(scale3(basis.x, at.x), scale3(basis.y, at.y)), radius));
}
#endif

#endif
