// SPDX-License-Identifier: Apache-2.0
// Nanoseconds that a sample takes longer with a feature than without it, as kernels/FEATURES.md has them, where its rows are
// described: another scene and machine, so they tell which features are dear, and no more. A test holds them to that page.
"use strict";

/** feature -> [row of that page, ns per sample] */
const FEATURE_COSTS = {
  vertex_normal: ["normals of the mesh", 6],
  vertex_color: ["vertex colours", 8],
  base_color_texture: ["base colour texture", 9],
  normal_texture: ["normal map", 4],
  emissive_texture: ["emissive texture, no light of its own", 139],
  metallic_roughness: ["plastic (GGX over diffuse)", 10],
  metallic_roughness_texture: ["metallic-roughness texture", 20],
  clearcoat: ["clearcoat", 19],
  clearcoat_normal: ["clearcoat of its own normal", 11],
  sheen: ["sheen", 18],
  anisotropy: ["anisotropy", 35],
  conductor: ["conductor", 18],
  measured: ["measured", 170],
  iridescence: ["iridescence of plastic", 84],
  transmission: ["transmission, solid and rough", 77],
  diffuse_transmission: ["diffuse transmission", 64],
  phong: ["Blinn's highlights", 16],
  dispersion: ["dispersion", -3],
  energy_compensation: ["energy compensation of metal", 18],
  absorption: ["absorption", -10],
  nested_media: ["absorption by priority", -1],
  opacity: ["opacity, MASK of a texture", 84],
  unlit: ["unlit", -70],
  point: ["point light", 10],
  spot: ["spot light", 12],
  directional: ["directional light", 2],
  environment_map: ["environment map", 18],
};
