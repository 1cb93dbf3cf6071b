// SPDX-License-Identifier: Apache-2.0
// Light paths: where they start, and how likely. Light that passes glass or leaves a mirror before it first meets a
// rough surface is found by paths from the camera only if they hit the lamp by chance, and never if that has no extent.
// So light paths start from lamps towards glass and mirrors, go on, and are joined to the camera where they meet rough
// surfaces (stages/light/shade.h).
//
// They are aimed at the targets: balls that hold all surfaces which reflect or refract exactly. A direction is chosen
// uniformly within the cones of all targets, so its density is the number of cones that it lies in over the sum of
// their solid angles; parallel light, and light of an environment map from a direction that is chosen as light sampling
// does, starts from the balls' discs likewise. No light path starts elsewhere, and paths from the camera that find such
// light take the density 0 for it.
#ifndef EK_LIGHT_PATH_H
#define EK_LIGHT_PATH_H
#include "lights/emission.h"

// With photons (EK_HAS_merging) a camera path's word light_ratio says by negative values what the path has met.
#define EK_SEEN_EXACTLY (-1.0f)  // exact reflection and refraction alone: it gathers photons (stages/shade/merge.h)
#define EK_MERGED (-2.0f)  // a surface where it gathered: what it finds behind that comes by photons, if light paths bring it

#if EK_HAS_light_paths
/// Mask of the camera paths that share light with light paths.
EK_FN vi is_shared_ratio(vf ratio) { return EK_HAS_merging ? (ratio > 0.0f) | (ratio == EK_MERGED) : ratio > 0.0f; }

/// The share of such a path in light that light paths start from with that density.
EK_FN vf camera_share(vf ratio, vf density) {
  const vf share = 1.0f / (1.0f + ratio * density);
  if (!EK_HAS_merging) return share;
  return ratio == EK_MERGED ? (density > 0.0f ? (vf)(0.0f) : (vf)(1.0f)) : share;
}

/// Solid angle of a target over 2 pi, in [0, 2]; all around where `from` lies within the ball.
/// target  centre, and radius; world, metres
EK_FN vf target_cone(float4 target, v3 from) {
  const v3 way = sub3(splat3(target), from);
  const vf sin2 = (target.w * target.w) / dot3(way, way);
  const vf outside = sin2 / (1.0f + sqrt(max_f(1.0f - sin2, (vf)(0.0f))));  // 1 - cosine, also of small angles
  return sin2 < 1.0f ? outside : (vf)(2.0f);
}

/// Sum of target_cone over all targets.
EK_FN vf all_target_cones(constant Frame* frame, LightData lights, v3 from) {
  vf sum = (vf)(0.0f);
  for (uint i = 0; i < frame->light_target_count; ++i) sum = sum + target_cone(lights.light_targets[i], from);
  return sum;
}

/// The squared distance of a ball's centre from the line through `from` along dir.
EK_FN vf distance2_from_line(float4 target, v3 from, v3 dir) {
  const v3 way = sub3(splat3(target), from);
  const v3 across = sub3(way, scale3(dir, dot3(way, dir)));
  return dot3(across, across);
}

/// Number of targets that a ray meets. dir: unit
EK_FN vf targets_met(constant Frame* frame, LightData lights, v3 from, v3 dir) {
  vf met = (vf)(0.0f);
  for (uint i = 0; i < frame->light_target_count; ++i) {
    const float4 target = lights.light_targets[i];
    const v3 way = sub3(splat3(target), from);
    const vi ahead = (dot3(way, dir) > 0.0f) & (distance2_from_line(target, from, dir) <= target.w * target.w);
    met = met + ((ahead | (target_cone(target, from) == 2.0f)) ? (vf)(1.0f) : (vf)(0.0f));
  }
  return met;
}

/// Density of the directions of light paths from a point, per sr.
EK_FN vf target_pdf_sr(constant Frame* frame, LightData lights, v3 from, v3 dir) {
  const vf met = targets_met(frame, lights, from, dir);
  return met > 0.0f ? met * (EK_INV_2PI / all_target_cones(frame, lights, from)) : (vf)(0.0f);
}

/// Density of a light path that leaves an emissive triangle: per m^2 of the triangle, per sr, and over the cosine there.
/// It is the radiance of a light path's throughput 1.
/// light  index of the triangle's light; dir: away from it, unit
EK_FN vf emission_density(constant Frame* frame, LightData lights, vu light, v3 p, v3 n_geom, v3 dir) {
  const vf density = gather_f(lights.emission_pdf, light) * target_pdf_sr(frame, lights, p, dir);
  const vf cosine = abs_f(dot3(n_geom, dir));
  return cosine > 0.0f ? density / cosine : (vf)(0.0f);
}

/// Sum of the squared radii of all targets.
EK_FN float all_target_radii2(constant Frame* frame, LightData lights) {
  float sum = 0.0f;
  for (uint i = 0; i < frame->light_target_count; ++i) sum += lights.light_targets[i].w * lights.light_targets[i].w;
  return sum;
}

/// Density of light paths of one direction on a plane across it, per m^2.
/// p  on the light path, before or behind the targets; dir: unit, along it
EK_FN vf parallel_pdf_m2(constant Frame* frame, LightData lights, v3 p, v3 dir) {
  vf met = (vf)(0.0f);
  for (uint i = 0; i < frame->light_target_count; ++i) {
    const float4 target = lights.light_targets[i];
    met = met + ((distance2_from_line(target, p, dir) <= target.w * target.w) ? (vf)(1.0f) : (vf)(0.0f));
  }
  return met * (EK_INV_PI / all_target_radii2(frame, lights));
}

#if EK_HAS_environment_map
/// Density of a light path from the environment: per m^2 across it, and per sr. It is the radiance of a throughput of 1.
/// pdf  of light sampling for its direction, per sr; p, dir: as of parallel_pdf_m2
EK_FN vf environment_emission_density(constant Frame* frame, LightData lights, vf pdf, v3 p, v3 dir) {
  return pdf * frame->environment_emission * parallel_pdf_m2(frame, lights, p, dir);
}
#endif

/// The start of a light path.
typedef struct {
  v3 origin, dir;   // world; dir: unit
  v3 throughput;    // radiance over density; 0: no light goes there
  vf density;       // of emission, or -1 where no path from the camera can find the light
  vu triangle;      // that it leaves, or EK_NO_HIT
  vu group;         // light group of the light
} EmittedPath;

/// A direction from a point towards a target.
/// numbers  random, [0, 1)^3: x chooses the target, y and z the direction
EK_FN v3 direction_to_targets(constant Frame* frame, LightData lights, v3 from, v3 numbers) {
  const vf chosen = numbers.x * all_target_cones(frame, lights, from);
  vf before = (vf)(0.0f), cone = (vf)(0.0f);
  v3 centre = from;
  for (uint i = 0; i < frame->light_target_count; ++i) {
    const float4 target = lights.light_targets[i];
    const vf own = target_cone(target, from);
    const vi takes = before <= chosen;  // the last one that does is the chosen one
    cone = takes ? own : cone;
    centre = select3(takes, splat3(target), centre);
    before = before + own;
  }
  v3 axis = sub3(centre, from);
  const vf length2 = dot3(axis, axis);
  axis = select3(length2 > 0.0f, scale3(axis, (vf)(1.0f) / sqrt(length2)), V3((vf)(0.0f), (vf)(0.0f), (vf)(1.0f)));
  return to_world(basis_around(axis), warp_cone(numbers.y, numbers.z, cone));
}

/// A point of the targets' discs across dir.
/// numbers  as direction_to_targets takes them
EK_FN v3 point_of_discs(constant Frame* frame, LightData lights, v3 dir, v3 numbers) {
  const vf chosen = numbers.x * all_target_radii2(frame, lights);
  vf radius = (vf)(0.0f);
  v3 centre = dir;
  float before = 0.0f;
  for (uint i = 0; i < frame->light_target_count; ++i) {
    const float4 target = lights.light_targets[i];
    const vi takes = before <= chosen;
    radius = takes ? (vf)(target.w) : radius;
    centre = select3(takes, splat3(target), centre);
    before += target.w * target.w;
  }
  const DiskPoint at = warp_disk(numbers.y, numbers.z);
  const Basis basis = basis_around(dir);
  return add3(centre, scale3(add3(scale3(basis.x, at.x), scale3(basis.y, at.y)), radius));
}

/// The point of a line through the scene, along dir, that lies before the whole scene.
EK_FN v3 before_scene(constant Frame* frame, v3 p, v3 dir) {
  // Twice the scene's diagonal is far enough for any target in it.
  const v3 half_extent = splat3(frame->scene_half);
  return sub3(p, scale3(dir, 4.0f * sqrt(dot3(half_extent, half_extent))));
}

/// Starts a light path.
/// choice   of the light, by the table of emission
/// numbers  as direction_to_targets takes them
/// words    for the direction from an environment map
EK_FN EmittedPath emit_light_path(constant Frame* frame, SceneData scene, LightData lights, AliasSample choice,
                                  v3 numbers, LightWords words) {
  const PickedLight picked = {choice, (vf)(1.0f)};
  const v3 up = V3((vf)(0.0f), (vf)(0.0f), (vf)(1.0f));
  const LightViewer viewer = {.basis = basis_around(up),
                              .both_sides = (vi)(0),
#if EK_HAS_GUIDE
                              .guide = {lights.guide.cells, (vu)(EK_NO_CELL)}
#endif
  };
  LightSample light = light_sample(frame, lights, picked, viewer, words);
  light.radiance = light_emission(scene, light);
  const vf selection = gather_f(lights.emission_pdf, choice.index);
  EmittedPath path;
  path.group = light.group;
  path.triangle = (vu)(EK_NO_HIT);
  path.density = (vf)(-1.0f);
  path.dir = EK_HAS_near_light ? direction_to_targets(frame, lights, light.p, numbers) : up;
  path.origin = light.p;
  path.throughput = light.radiance;
  vf density = selection;  // of this path, over which the light is divided
  if (EK_HAS_near_light) density = selection * target_pdf_sr(frame, lights, light.p, path.dir);
  if (EK_HAS_area) {
    const vi is_area = !(light.is_distant | light.is_punctual | light.is_shape);
    const vf cosine = dot3(light.n, path.dir);
    const vf of_area = emission_density(frame, lights, choice.index, light.p, light.n, path.dir);
    const v3 origin = offset_ray_origin(light.p, light.p_error, light.n, path.dir);
    path.origin = select3(is_area, origin, path.origin);
    path.density = is_area ? of_area : path.density;
    path.triangle = is_area ? light.triangle : path.triangle;
    density = is_area ? (((cosine > 0.0f) | light.double_sided) ? of_area : (vf)(0.0f)) : density;
    if (EK_HAS_clearcoat)
      path.throughput = scale3(path.throughput, is_area ? light_coat(scene, light, neg3(path.dir)) : (vf)(1.0f));
  }
  if (EK_HAS_spot) {
    const vf falloff = spot_falloff(-dot3(light.wi, path.dir), light.cone_cos, light.cone_scale);
    path.throughput = select3(light.is_punctual, scale3(path.throughput, falloff), path.throughput);
  }
  if (EK_HAS_directional | EK_HAS_environment_map) {
    const v3 dir = neg3(light.wi);
    const v3 p = point_of_discs(frame, lights, dir, numbers);
    path.dir = select3(light.is_distant, dir, path.dir);
    path.origin = select3(light.is_distant, before_scene(frame, p, dir), path.origin);
    density = light.is_distant ? selection * parallel_pdf_m2(frame, lights, p, dir) : density;
#if EK_HAS_environment_map
    const vi is_map = light.is_distant & !light.is_delta;
    const vf of_map = environment_emission_density(frame, lights, light.pdf, p, dir);
    path.density = is_map ? of_map : path.density;
    density = is_map ? of_map : density;
#endif
  }
  path.throughput = scale3(path.throughput, density > 0.0f ? (vf)(1.0f) / density : (vf)(0.0f));
  return path;
}
#endif

#endif
