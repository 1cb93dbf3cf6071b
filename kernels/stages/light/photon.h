// SPDX-License-Identifier: Apache-2.0
// Step of stage `light_shade` where light paths bring photons: leaves one at each surface that
// scatters light otherwise than as delta. It waits for stage `splat` in the place of the shadow ray
// that would carry a splat.
#ifndef EK_LIGHT_PHOTON_H
#define EK_LIGHT_PHOTON_H
#include "film/splat.h"
#include "stages/shade/merge.h"

#if EK_HAS_merging
/// Leaves a photon for each lane that needs one. slot: as of direct_light_cast. returns the mask of
/// those lanes, as bits
EK_FN uint photon_leave(const ShadeContext* c, const PathHit* hit, const ShadingPoint* point, uint slot) {
  const v3 to_light = neg3(hit->path.dir);
  const vf cosine = abs_f(dot3(point->n_geom, to_light));
  vi leaves = point->live & (cosine > 0.0f) & (max_component(abs3(point->beta)) > 0.0f) & !is_purely_delta(&point->material);
  if (EK_USES_NULL_INTERFACES) leaves = leaves & !point->interface.is_null;
  const vu edges = (vu)(c->depth) - point->interface.null_interface_count;
  const vu most = (vu)(EK_PHOTON_EDGES_MOST);
  const vu group = EK_HAS_light_group ? hit->path.source_group : (vu)(0u);
  const vu info = EK_PHOTON_INFO(light_path_replicate(hit->path.path), group, edges < most ? edges : most);
  vf met = cosine;  // the share of light from there that meets an area of the surface
  // Light paths end on a surface of alphaMode BLEND as often as its opacity says, and so do the
  // paths from the camera that gather there. So that it counts once, the photon has the light that
  // there would be without it.
  if (EK_HAS_opacity) {
    const MaterialRecordLanes record = load_material(c->scene.materials, hit->corners.material);
    met = met * material_opacity(c->scene, record, hit->attributes);
    leaves = leaves & (met > 0.0f);
  }
  const ShadowRay photon = {.destination = point->index,
                            .origin = point->p,
                            .dir = to_light,
                            .radiance = scale3(point->beta, div_f((vf)(1.0f), met)),
                            .photon_normal = pack_normal(point->n_geom, (vi)(0)),
                            .record_info = info};
  shadow_store(c->stage.state, slot, packing(leaves), photon);
  return mask_bits(leaves);
}

/// Lists the photons of stage `light_shade`. count: of them
EK_FN void photons_add(StageContext stage, RecordList list, uint count) {
  PathWalk walk = path_walk(count);
  while (path_walk_next(&walk, stage.queue, EK_WIDTH)) {
    const ShadowRay ray = shadow_load(stage.state, walk.slot);
    vu photon[PHOTON_WORDS];
    photon[PHOTON_x] = AS_U(ray.origin.x);
    photon[PHOTON_y] = AS_U(ray.origin.y);
    photon[PHOTON_z] = AS_U(ray.origin.z);
    photon[PHOTON_info] = ray.record_info;
    photon[PHOTON_dir_x] = AS_U(ray.dir.x);
    photon[PHOTON_dir_y] = AS_U(ray.dir.y);
    photon[PHOTON_dir_z] = AS_U(ray.dir.z);
    photon[PHOTON_normal] = ray.photon_normal;
    photon[PHOTON_r] = AS_U(ray.radiance.x);
    photon[PHOTON_g] = AS_U(ray.radiance.y);
    photon[PHOTON_b] = AS_U(ray.radiance.z);
    photon[PHOTON_order] = ray.destination;
    record_add(list, LANE_INDEX < (vu)(walk.lanes), photon, PHOTON_WORDS);
  }
}
#endif

#endif
