// SPDX-License-Identifier: Apache-2.0
// The arrays of a scene that say what a surface looks like, as one argument. What a scene does not need is there as a dummy.
#ifndef EK_SCENE_DATA_H
#define EK_SCENE_DATA_H
#include "lanes.h"

typedef struct {
  global const Triangle* triangles;
  global const TriangleNormals* triangle_normals;
  global const TriangleTangents* triangle_tangents;
  global const TriangleColors* triangle_colors;
  global const MaterialRecord* materials;
  global const MaterialExtension* material_extensions;
  global const TextureRecord* textures;
  global const uint* texels;  // EK_TEXEL_TABLE words, then RGBA8
} SceneData;

// The same as arguments of a kernel; they are bound by these names.
#define EK_SCENE_ARGUMENTS                                                                                                \
  global const Triangle *triangles, global const TriangleNormals *triangle_normals,                                      \
      global const TriangleTangents *triangle_tangents, global const TriangleColors *triangle_colors,                    \
      global const MaterialRecord *materials, global const MaterialExtension *material_extensions,                       \
      global const TextureRecord *textures, global const uint *texels
#define EK_SCENE_DATA \
  {triangles, triangle_normals, triangle_tangents, triangle_colors, materials, material_extensions, textures, texels}

#endif
