// SPDX-License-Identifier: Apache-2.0
// Stage `miss`.   From: paths of this depth whose ray left the scene.
// Adds the environment, weighted against light sampling; in a transparent picture to no ray that
// comes from the camera itself. These paths end here: stage shade leaves out all that hit nothing.
#ifndef EK_STAGE_MISS_H
#define EK_STAGE_MISS_H
#include "film/motion_vector.h"
#include "lights/light_path.h"
#include "stages/wavefront.h"
#include "surface/medium.h"

/// Radiance of the environment along a path's ray, and its density in light sampling [1/sr].
EK_FN MapValue escaped_radiance(StageContext stage, LightData lights, uint slot) {
  if (EK_HAS_environment_map)
    return environment_map_value(stage.frame, lights.environment_texels, state_v3(stage.state, FIELD_dir, slot));
  MapValue sky = {splat3(stage.frame->environment), (vf)(0.0f)};
  if (EK_HAS_environment & EK_HAS_next_event & EK_HAS_bsdf_emission)
    sky.pdf = state_vf(stage.state, FIELD_pdf_environment, slot);
  return sky;
}

#if EK_HAS_light_paths & EK_HAS_environment_map
/// Share of the environment's light that camera paths bring, as emission_share of
/// shade/light_ratio.h.
/// pdf_sr  of light sampling for the path's direction
EK_FN vf environment_share(StageContext stage, LightData lights, const PathState* path, vi escaped, vf pdf_sr) {
  const vi shared = escaped & is_shared_scattering(path->pdf, path->light_ratio);
  if (!(stage.frame->environment_emission > 0.0f) || !ANY(shared)) return (vf)(1.0f);
  const vf emitted = mean_environment_density(stage.frame, lights, pdf_sr);
  const vf density = density_beside_sampling(emitted, pdf_sr, marked_lobe_sr(path->light_ratio));
  return shared ? camera_share(path->light_ratio, density) : (vf)(1.0f);
}
#endif

EK_FN_ONCE void stage_miss(StageContext stage, SceneData scene, LightData lights, uint count, uint depth) {
  if (EK_HAS_coverage && depth == 1) return;
  PathWalk walk = path_walk(count);
  while (path_walk_next(&walk, stage.queue, EK_WIDTH)) {
    const vi escaped =
        (LANE_INDEX < (vu)(walk.lanes)) & (state_vu(stage.state, FIELD_hit_triangle, walk.slot) == EK_NO_HIT);
    if (!ANY(escaped)) continue;
    const PathState path = path_load(stage.state, walk.slot);
#if EK_HAS_motion
    const SeenMotion seen = {
        escaped, path.path, EK_HAS_pixel_filter ? path.beta.x : (vf)(1.0f), path.dir, path.dir, 0.0f};
    if (depth == 1) film_motion(stage.frame, scene, stage.film, &seen);
#endif
    const MapValue sky = escaped_radiance(stage, lights, walk.slot);
    vf weight = (vf)(1.0f);
    if (EK_HAS_next_event) {
      const vf scattered = EK_HAS_bsdf_emission ? power_heuristic(path.pdf, sky.pdf * EK_LIGHT_MEAN) : (vf)(0.0f);
      weight = has_no_density(path.pdf) ? weight : scattered;
    }
#if EK_HAS_light_paths & EK_HAS_environment_map
    const vf share = environment_share(stage, lights, &path, escaped, sky.pdf);
#else
    const vf share = (vf)(1.0f);
#endif
    weight = weight * share;
    v3 beta = path.beta;
    if (EK_HAS_nested_media) {
      // Solids are closed, so the path has left them all, even those whose surface it stepped over.
      beta = scale3(beta, media_radiance_outside(scene, path.medium));
    } else if (EK_HAS_absorption) {
      // A path may leave an open solid without meeting its surface; the matter then goes on for
      // ever.
      beta = mul3(beta, transmittance(medium_absorption(scene, path.medium), EK_INFINITY));
    }
    const Contribution light = {.live = escaped,
                                .path = path.path,
                                .uncounted = EK_USES_NULL_INTERFACES ? path.null_interface_count : (vu)(0u),
                                .group = (vu)(EK_ENVIRONMENT_GROUP),
                                .radiance = scale3(mul3(beta, sky.radiance), weight)};
    film_add_light(stage.film, depth - 1, light);
#if EK_HAS_path_log
    // The constant environment is sampled as scattered rays are, so the two densities without
    // guiding differ by the probability that the environment is chosen.
    const vf sampled = EK_HAS_environment_map ? sky.pdf : path.plain_pdf * stage.frame->environment.w;
    vf plain = (vf)(1.0f);
    if (EK_HAS_next_event & EK_HAS_bsdf_emission) plain = power_heuristic(path.plain_pdf, sampled * EK_LIGHT_MEAN);
    plain = (has_no_density(path.pdf) ? (vf)(1.0f) : plain) * share * log_share(path.beta, beta);
    log_set_f(stage.log, depth, LOG_emitted, escaped, path.path, luminance(sky.radiance) * plain);
    log_set_f(stage.log, depth, LOG_sampled, escaped, path.path, (vf)(0.0f));
    log_set(stage.log, depth, LOG_info, escaped, path.path, (vu)(LOG_MISS));
#endif
  }
}

#endif
