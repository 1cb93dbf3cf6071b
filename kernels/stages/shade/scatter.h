// SPDX-License-Identifier: Apache-2.0
// Steps of stage `shade`: samples the BSDF for the direction in which a path goes on, and Russian
// roulette.
#ifndef EK_SHADE_SCATTER_H
#define EK_SHADE_SCATTER_H
#include "stages/shade/shading_frame.h"

// Survival over throughput: paths that carry more than a third go on. kernels/EXPERIMENTS.md has
// what this, the depth and the probability below gain over roulette in proportion to throughput.
#define EK_ROULETTE_GAIN 3.0f
// From this depth on every path may end, because those between white mirrors would not otherwise.
#define EK_ROULETTE_ALWAYS_DEPTH 8u
#define EK_ROULETTE_MOST 0.95f  // largest probability of survival from that depth on

/// The largest probability of survival at a depth.
EK_FN vf roulette_most(uint depth) { return (vf)(depth < EK_ROULETTE_ALWAYS_DEPTH ? 1.0f : EK_ROULETTE_MOST); }

/// The continuation of a path after a scattering.
typedef struct {
  vi survives;  // mask; nothing else is of use where it is not set
  v3 dir;       // world, unit
  v3 wi;        // the same, local
  v3 beta;
  vf pdf;       // as PathState's
  vu medium;
#if EK_HAS_light_paths
  vf light_ratio;  // as PathState's; scatter() leaves it unset
#endif
} ScatteredPath;

/// True if some material scatters in several ways, so that a random number has to choose one.
EK_FN int needs_choice(void) { return EK_LAYERED | EK_HAS_energy_compensation | has_lobe_with(EK_TRAIT_CHOICE); }

/// Samples the BSDF; null interfaces are passed straight on. beta: is the sample's weight
EK_FN ScatteredPath scatter_direction(const ShadeContext* c, const PathHit* hit, const ShadingPoint* point) {
  const vi is_null = point->interface.is_null;
  vf u, v, choice = (vf)(0.0f), unused;
  sample_2d(point->key, point->index, bounce_dimension(c->depth, DIM_SCATTER), &u, &v);
  if (needs_choice()) sample_2d(point->key, point->index, bounce_dimension(c->depth, DIM_CHOICE), &choice, &unused);
  BsdfSample sample = bsdf_sample(point->material, point->wo, u, v, choice);
  ScatteredPath next;
  next.dir = to_world(point->basis, sample.wi);
  if (EK_USES_NULL_INTERFACES) {
    vf radiance = (vf)(1.0f);
#if EK_HAS_open_solid
    radiance = point->interface.is_opening ? radiance_transmitted(point->material) : radiance;
#endif
    sample = pass_null_interface(is_null, radiance, sample);
    next.dir = select3(is_null, hit->path.dir, next.dir);
  }
  next.wi = sample.wi;
  next.medium = is_transmitted(point, sample.wi, next.dir) ? point->interface.transmitted_medium : point->interface.medium;
  next.pdf = sample.delta ? (vf)(EK_NO_DENSITY) : sample.pdf;
  next.beta = sample.weight;
  next.survives = point->live & (sample.pdf > 0.0f) &
                  (is_null | is_on_geometric_side(point, sample.wi, dot3(next.dir, point->n_geom)));
  return next;
}

/// The continuation of a path from the camera.
EK_FN ScatteredPath scatter(const ShadeContext* c, const PathHit* hit, const ShadingPoint* point) {
  ScatteredPath next = scatter_direction(c, hit, point);
  next.beta = mul3(point->beta, next.beta);
  next.survives = next.survives & (max_component(abs3(next.beta)) > 0.0f);
  if (!(EK_HAS_bsdf_emission | EK_HAS_next_event)) next.survives = (vi)(0);
  if (EK_HAS_whitted) next.survives = next.survives & has_no_density(next.pdf);
  if (EK_HAS_raycast) next.survives = next.survives & point->interface.is_null;
  return next;
}

/// Survival probability that falls with the throughput of a path.
EK_FN vf throughput_survival(const ShadeContext* c, const PathHit* hit, const ShadingPoint* point,
                             const ScatteredPath* next) {
  vf rr_throughput = max_component(abs3(next->beta));
  // Throughput is compared as it would be outside of all solids: a third of the paths that enter
  // glass would end there for nothing.
  if (has_lobe_with(EK_TRAIT_TRANSMITS)) {
    const vi transmitted = is_transmitted(point, next->wi, next->dir);
    rr_throughput = rr_throughput * (EK_HAS_nested_media
                                         ? media_radiance_outside(c->scene, next->medium)
                                         : radiance_returned_outside(point->material, hit->front, transmitted));
  }
  // Ending paths that carry more adds more error than it saves rays (kernels/EXPERIMENTS.md).
  vf survival = min_f(EK_ROULETTE_GAIN * rr_throughput, roulette_most(c->depth));
  if (EK_HAS_fixed_roulette) survival = (vf)(c->stage.frame->roulette);
  if (EK_USES_NULL_INTERFACES) survival = point->interface.skips_depth ? (vf)(1.0f) : survival;
  return survival;
}

/// Russian roulette: ends paths that do not survive, and scales up the others.
EK_FN void roulette(const ShadeContext* c, const ShadingPoint* point, vf survival, ScatteredPath* next) {
  vf unused, number;
  sample_2d(point->key, point->index, bounce_dimension(c->depth, DIM_CHOICE), &unused, &number);
  next->survives = next->survives & (number < survival);
  next->beta = scale3(next->beta, div_f((vf)(1.0f), survival));
}

#endif
