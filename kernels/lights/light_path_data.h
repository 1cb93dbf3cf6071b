// SPDX-License-Identifier: Apache-2.0
// The arrays that light paths start from, and the same as arguments of a kernel.
#ifndef EK_LIGHT_PATH_DATA_H
#define EK_LIGHT_PATH_DATA_H
#include "lights/alias_table.h"

typedef struct {
  global const AliasEntry* emission_alias_table;  // of lights, by which light paths start
  global const float* emission_pdf;    // of each light: probability of that, of triangles per m^2
  // In the mean over the targets, the density of a light path per m^2 across parallel light; then
  // of each light, per sr of its direction from the light's middle, a power of two.
  global const float* emission_aim;
  global const float4* light_targets;  // light_path.h
  global const uint* light_aim;        // light_aim.h
} LightPathData;

#define EK_LIGHT_PATH_ARGUMENTS                                                                                        \
  , global const AliasEntry *emission_alias_table, global const float *emission_pdf, global const float *emission_aim, \
      global const float4 *light_targets, global const uint *light_aim
#define EK_LIGHT_PATH_DATA \
  , { emission_alias_table, emission_pdf, emission_aim, light_targets, light_aim }

#endif
