// SPDX-License-Identifier: Apache-2.0
// Steps of stage `shade` for path guiding: find the table of a shading point, say how likely a path
// goes on by what the pilot expects of it, and write the log of a pilot.
#ifndef EK_SHADE_GUIDE_H
#define EK_SHADE_GUIDE_H
#include "guide/path_log.h"
#include "stages/shade/scatter.h"

#if EK_USES_GUIDE
// Least survival probability: a table may be wrong, and the weight of a path grows by the inverse.
#define EK_ROULETTE_LEAST 0.05f
// More metallic surfaces reflect by direction, so the tables do not say what the rest of a path
// brings. The limit is a choice: from there on metal is the larger part.
#define EK_DIFFUSE_METALLIC 0.5f

/// Finds the guide's table that applies to each lane's point, and what the pilot expects of the
/// path, and sets both in `point`.
EK_FN void guide_point(const ShadeContext* c, const PathHit* hit, ShadingPoint* point) {
  constant Frame* frame = c->stage.frame;
  point->is_diffuse = has_trait(point->material.lobes, EK_TRAIT_LAMBERT);
  point->is_guided = point->is_diffuse;
  if (has_lobe_with(EK_TRAIT_GUIDED)) {
    const vi is = has_trait(point->material.lobes, EK_TRAIT_GUIDED);
    point->is_diffuse = point->is_diffuse | (is & (point->material.metallic < EK_DIFFUSE_METALLIC));
    point->is_guided = point->is_diffuse | (is & (point->material.ggx_alpha >= EK_GUIDED_ALPHA));
  }
  point->cell_key = cell_key(frame, point->p, point->n_shade);
  const vi wanted = point->live & (frame->guided_roulette_depth != 0u ? point->is_guided : (vi)(0));
  const GuideCell guide = {c->lights.guide.cells, cell_find(frame, c->lights.guide.slots, point->cell_key, wanted)};
  point->material.guide = guide;
  point->expected = hit->path.expected;
}

/// Survival probability by what the pilot expects of the rest of the path over what it expects of
/// all of it [Vorba and Krivanek 2016, "Adjoint-driven Russian Roulette and Splitting in Light
/// Transport Simulation"]. Paths that bring at least a third of it go on. Lanes that the tables say
/// nothing about keep `otherwise`.
EK_FN vf guided_survival(const ShadeContext* c, ShadingPoint* point, vf otherwise) {
  const GuideCell guide = point->material.guide;
  const vi has = guide_has(guide) & point->is_diffuse;
  if (!ANY(has)) return otherwise;
  const vf indirect = guide_indirect(guide), direct = guide_direct(guide);
  const vf leaving = luminance(abs3(mul3(point->beta, point->material.base_color)));
  point->expected = (has & !(point->expected > 0.0f)) ? leaving * (indirect + direct) : point->expected;
  const vf share = div_f(leaving * indirect, point->expected);
  vf survival = min_f(max_f(EK_ROULETTE_GAIN * share, (vf)(EK_ROULETTE_LEAST)), roulette_most(c->depth));
  survival = c->depth < c->stage.frame->guided_roulette_depth ? (vf)(1.0f) : survival;
  return (has & (point->expected > 0.0f) & is_finite(share)) ? survival : otherwise;
}
#endif

#if EK_HAS_path_log
/// PathState.pdf of a scattering if directions were not guided.
EK_FN vf plain_pdf(const ShadingPoint* point, const ScatteredPath* next) {
  MaterialLanes plain = point->material;
  plain.guide.cell = (vu)(EK_NO_CELL);
  return has_no_density(next->pdf) ? next->pdf : bsdf_evaluate(plain, point->wo, next->wi).pdf;
}

/// Begins the log of a vertex, to which add_emission and stage `shadow` add what they find.
EK_FN void log_vertex_begin(const ShadeContext* c, const PathHit* hit) {
  log_set_f(c->stage.log, c->depth, LOG_sampled, hit->live, hit->path.path, (vf)(0.0f));
  log_set_f(c->stage.log, c->depth, LOG_emitted, hit->live, hit->path.path, (vf)(0.0f));
}

EK_FN void log_vertex_end(const ShadeContext* c, const PathHit* hit, const ShadingPoint* point,
                          const ScatteredPath* next) {
  const PathLog log = c->stage.log;
  const vu path = hit->path.path;
  const vu info = (guide_bin(next->wi) & (uint)LOG_BIN_MASK) | (uint)LOG_HIT |
                  ((point->live & point->is_guided) ? (vu)(LOG_GUIDED) : (vu)(0u)) |
                  (next->survives ? (vu)(LOG_CONTINUES) : (vu)(0u));
  log_set(log, c->depth, LOG_info, hit->live, path, info);
  log_set(log, c->depth, LOG_xy, hit->live, path, point->cell_key.xy);
  log_set(log, c->depth, LOG_zn, hit->live, path, point->cell_key.zn);
  log_set_f(log, c->depth, LOG_distance, hit->live, path, hit->t);
  log_set_f(log, c->depth, LOG_weight, hit->live, path, log_share(hit->path.beta, next->beta));
  log_set_f(log, c->depth, LOG_albedo, hit->live, path, luminance(point->material.base_color) * point->transmitted);
}
#endif

#endif
