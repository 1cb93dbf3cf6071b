// SPDX-License-Identifier: Apache-2.0
// The words of a photon, which host and kernels both read: light that arrives at a surface along a
// light path.
#ifndef EK_SHARED_PHOTON_H
#define EK_SHARED_PHOTON_H

// PHOTON_info: EK_PHOTON_INFO, with the number of edges from the light to the surface.
// PHOTON_dir_*: back along the light path. PHOTON_normal: pack_normal of the surface's own
// (lights/light_tree.h). PHOTON_r, g, b: power of the light path, W, over the cosine of its
// direction with the surface's own normal, because bsdf_evaluate multiplies by a cosine.
// Frame.photon_weight makes of it W / m^2 across the path (stages/shade/merge.h). PHOTON_order:
// orders the light paths of a replicate.
enum {
  PHOTON_x, PHOTON_y, PHOTON_z, PHOTON_info, PHOTON_dir_x, PHOTON_dir_y, PHOTON_dir_z, PHOTON_normal, PHOTON_r, PHOTON_g, PHOTON_b,
  PHOTON_order, PHOTON_WORDS
};
#define EK_PHOTON_EDGES_MOST 0xffffu
#define EK_PHOTON_INFO(replicate, group, edges) ((replicate) | (group) << 8 | (edges) << 16)
#define EK_PHOTON_REPLICATE(info) ((info)&0xffu)
#define EK_PHOTON_GROUP(info) ((info) >> 8 & 0xffu)
#define EK_PHOTON_EDGES(info) ((info) >> 16)

// Frame.of_light_paths
#define EK_OF_CAMERA_PATHS 0u
#define EK_OF_LIGHT_PATHS 1u  // they bring splats
#define EK_OF_PHOTONS 2u      // they bring photons

#endif
