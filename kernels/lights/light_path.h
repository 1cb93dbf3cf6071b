// SPDX-License-Identifier: Apache-2.0
// Light paths: where they start, and how likely. Light that passes glass or leaves a mirror before
// it first meets a rough surface is found by paths from the camera only if they hit the lamp by
// chance, and never if that has no extent. So light paths start from lamps towards glass and
// mirrors, go on, and are joined to the camera where they meet rough surfaces
// (stages/light/shade.h).
//
// They are aimed at the targets (lights/light_aim.h): balls that hold all surfaces of delta
// scattering, called specular targets, and those that come close to it, called glossy targets. The
// latter differ in that paths from the camera find light at them by light sampling, too. Unless a
// trial has learned where starts bring most, a direction is chosen uniformly within the cones of
// all targets, so its density is the number of cones that it lies in over the sum of their solid
// angles; parallel light, and light of an environment map from a direction that is chosen as light
// sampling does, starts from the balls' discs likewise. A light path ends if the first surface that
// it meets is no target, and paths from the camera keep all light that reaches them from a lamp by
// way of such a surface: that may lie within a target's cone or outside of all, and only a look at
// every target would tell.
#ifndef EK_LIGHT_PATH_H
#define EK_LIGHT_PATH_H
#include "lights/emission.h"

#if EK_HAS_light_paths
#include "lights/light_aim.h"
#include "lights/light_ratio_word.h"
#if EK_HAS_shape & EK_HAS_shape_light
#include "lights/shape_light.h"
#endif

/// Density with which light paths start from a point of a lamp, per m^2.
/// light  index; pdf_of_point: 1 for triangles, of shapes shape_pdf_m2
EK_FN vf start_pdf_m2(LightData lights, vu light, vf pdf_of_point) {
  return gather_f(lights.light_paths.emission_pdf, light) * pdf_of_point;
}

/// Density of a light path that leaves an emissive surface: per m^2 of it, per sr, and over the
/// cosine there. The throughput of a light path is the radiance over this.
/// start_m2  start_pdf_m2; dir: away from the surface, unit
EK_FN vf emission_density(constant Frame* frame, LightData lights, vf start_m2, v3 p, v3 n_geom, v3 dir) {
  const vf cosine = abs_f(dot3(n_geom, dir));
  return cosine > 0.0f ? div_f(start_m2 * target_pdf_sr(frame, lights, p, dir), cosine) : (vf)(0.0f);
}

// Camera paths and light paths share light by the density of a start in the mean: as if all points
// of the light saw the targets as its middle does (emission_aim), and as many targets overlapped
// everywhere. For the density itself camera paths would have to look at all targets; any number
// that both ways agree on will do.
EK_FN vf mean_target_pdf_sr(LightData lights, vu light) {
  return gather_f(lights.light_paths.emission_aim, light + 1u);
}
EK_FN float mean_parallel_pdf_m2(LightData lights) { return lights.light_paths.emission_aim[0]; }

/// As emission_density, in the mean. light: index
EK_FN vf mean_emission_density(LightData lights, vu light, vf start_m2, v3 n_geom, v3 dir) {
  const vf cosine = abs_f(dot3(n_geom, dir));
  return cosine > 0.0f ? div_f(start_m2 * mean_target_pdf_sr(lights, light), cosine) : (vf)(0.0f);
}

#if EK_HAS_environment_map
/// The same of light from an environment map: per m^2 across it, and per sr. pdf: of light sampling
/// for its direction, per sr
EK_FN vf mean_environment_density(constant Frame* frame, LightData lights, vf pdf) {
  return pdf * (frame->environment_emission * mean_parallel_pdf_m2(lights));
}
#endif

// At glossy targets paths from the camera find light in two ways: as light paths do, by sampling
// the lobe, and by sampling the light. The latter is worth its density times the lobe's solid
// angle. That stands for the lobe's true value, which one of both ways would not know; what they
// agree on leaves the picture without a bias.

/// The density of light paths by way of a glossy target over that of all camera paths, which sample
/// the lobe or the light.
/// density  over that of camera paths that sample the lobe
/// pdf_sr   of light sampling from there, for which start_pdf_m2 stands in
/// sr       of the lobe; 0 after delta scattering
EK_FN vf density_beside_sampling(vf density, vf pdf_sr, vf sr) { return div_f(density, 1.0f + pdf_sr * sr); }

/// The same of a light without extent, which camera paths find by sampling the light alone.
/// pdf_m2  of light paths, per m^2 across them at the glossy target, if all started from this light
EK_FN vf density_beside_sampling_of_point(vf pdf_m2, vf sr) { return div_f(pdf_m2, sr); }

/// PathState.path of a light path: the replicate of its sample, and the name of its start
/// (shared/light_target.h).
EK_FN vu light_path_tag(vu replicate, vu start) { return replicate | start << 8; }
EK_FN vu light_path_replicate(vu tag) { return tag & 0xffu; }
EK_FN vu light_path_start(vu tag) { return tag >> 8; }

/// The start of a light path.
typedef struct {
  v3 origin, dir;   // world; dir: unit
  v3 throughput;    // radiance over density; 0: no light goes there
  // PathState.light_ratio of the start, with a mark (light_ratio_word.h): of a surface
  // mean_emission_density, 1 / (m^2 sr); of an environment map mean_environment_density,
  // 1 / (m^2 sr); of point and spot lights -mean_target_pdf_sr, 1 / sr; of directional lights
  // -mean_parallel_pdf_m2, 1 / m^2.
  vf density;
  vu triangle;      // that it leaves, or EK_NO_HIT
  vu group;         // light group of the light
  vu start;         // its name (shared/light_target.h)
} EmittedPath;

/// The point of a line through the scene, along dir, that lies before the whole scene.
EK_FN v3 before_scene(constant Frame* frame, v3 p, v3 dir) {
  // Twice the scene's diagonal is far enough for any target in it.
  const v3 half_extent = splat3(frame->scene_half);
  return sub3(p, scale3(dir, 4.0f * sqrt_f(dot3(half_extent, half_extent))));
}

/// Makes the start that of parallel light, or of light from an environment map, in the lanes of
/// such light.
/// returns the density over which the light is divided
EK_FN vf emit_distant(constant Frame* frame, LightData lights, LightSample light, vu index, v3 random,
                      EmittedPath* path) {
  const v3 dir = neg3(light.wi);
  vu start;
  const v3 p = point_of_discs(frame, lights, dir, random, &start);
  const vf of_place = parallel_pdf_m2(frame, lights, p, dir);
  vf density = gather_f(lights.light_paths.emission_pdf, index) * of_place,
     in_the_mean = -(vf)(mean_parallel_pdf_m2(lights));
#if EK_HAS_environment_map
  const vi is_map = !light.is_delta;
  density = is_map ? light.pdf * frame->environment_emission * of_place : density;
  in_the_mean = is_map ? mean_environment_density(frame, lights, light.pdf) : in_the_mean;
#endif
  path->dir = select3(light.is_distant, dir, path->dir);
  path->origin = select3(light.is_distant, before_scene(frame, p, dir), path->origin);
  path->density = light.is_distant ? marked(in_the_mean, (vu)(EK_PARALLEL_MARK)) : path->density;
  path->start = light.is_distant ? start : path->start;
  return density;
}

/// Makes the start that of a lamp's surface in the lanes of such light. path->dir is set.
/// returns the density over which the light is divided
EK_FN vf emit_from_surface(constant Frame* frame, LightData lights, LightSample light, vu index, EmittedPath* path) {
  const vi is_area = !(light.is_distant | light.is_punctual);
  const vf start_m2 = start_pdf_m2(lights, index, light.pdf_of_point);
  const vf density = emission_density(frame, lights, start_m2, light.p, light.n, path->dir);
  const vf in_the_mean = mean_emission_density(lights, index, start_m2, light.n, path->dir);
  const v3 origin = offset_ray_origin(light.p, light.p_error, light.n, path->dir);
  path->origin = select3(is_area, origin, path->origin);
  path->density = is_area ? marked(in_the_mean, mark_of(path->density)) : path->density;
  path->triangle = is_area ? light.triangle : path->triangle;
  return ((dot3(light.n, path->dir) > 0.0f) | light.double_sided) ? density : (vf)(0.0f);
}

/// Starts a light path.
/// choice   of the light, by the table of emission
/// random   as direction_to_targets takes it
/// words    for the direction from an environment map
EK_FN EmittedPath emit_light_path(constant Frame* frame, SceneData scene, LightData lights, AliasSample choice,
                                  v3 random, LightWords words) {
  const PickedLight picked = {choice, (vf)(1.0f)};
  const v3 up = V3((vf)(0.0f), (vf)(0.0f), (vf)(1.0f));
  const LightViewer viewer = {.basis = basis_around(up),
                              .both_sides = (vi)(0),
#if EK_USES_GUIDE
                              .guide = {lights.guide.cells, (vu)(EK_NO_CELL)}
#endif
  };
  LightSample light = light_sample(frame, lights, picked, viewer, words);
  light.pdf_of_point = (vf)(1.0f);
#if EK_HAS_shape & EK_HAS_shape_light
  light = shape_light_start(scene, light);
#endif
  light.radiance = light_emission(scene, light);
  const vf selection = gather_f(lights.light_paths.emission_pdf, choice.index);
  EmittedPath path;
  path.group = light.group;
  path.triangle = (vu)(EK_NO_HIT);
  path.start = (vu)(0u);
  path.dir = EK_USES_NEAR_LIGHT ? direction_to_targets(frame, lights, light.p, random, &path.start) : up;
  path.origin = light.p;
  path.throughput = light.radiance;
  vf density = selection;  // of this path, over which the light is divided
  const vf aim = mean_target_pdf_sr(lights, choice.index);
  const vu mark = aim_mark(aim);
  path.density = marked(-aim, mark);
  if (EK_USES_NEAR_LIGHT) density = selection * target_pdf_sr(frame, lights, light.p, path.dir);
  if (EK_HAS_area) {
    const vi is_area = !(light.is_distant | light.is_punctual);
    const vf of_area = emit_from_surface(frame, lights, light, choice.index, &path);
    density = is_area ? of_area : density;
    if (EK_HAS_clearcoat)
      path.throughput = scale3(path.throughput, is_area ? light_coat(scene, light, neg3(path.dir)) : (vf)(1.0f));
  }
  if (EK_HAS_spot) {
    const vf falloff = spot_falloff(-dot3(light.wi, path.dir), light.cone_cos, light.cone_scale);
    path.throughput = select3(light.is_punctual, scale3(path.throughput, falloff), path.throughput);
  }
  if (EK_HAS_directional | EK_HAS_environment_map) {
    const vf of_distant = emit_distant(frame, lights, light, choice.index, random, &path);
    density = light.is_distant ? of_distant : density;
  }
  path.throughput = scale3(path.throughput, density > 0.0f ? div_f((vf)(1.0f), density) : (vf)(0.0f));
  return path;
}
#endif

#endif
