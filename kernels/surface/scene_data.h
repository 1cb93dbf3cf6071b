// SPDX-License-Identifier: Apache-2.0
// The arrays of a scene that describe its surfaces, as one argument. An array that the scene does
// not need is a dummy.
#ifndef EK_SCENE_DATA_H
#define EK_SCENE_DATA_H
#include "lanes/math.h"
#include "lanes/record_lanes.h"

/// Mask of the records that are shapes: their third corner is NaN (shared/records.def).
EK_FN vi is_shape_record(TriangleLanes record) { return record.p2.x != record.p2.x; }

/// Mask of the records of planes without end, as is_endless_box of host/scene/endless.h.
EK_FN vi is_endless_record(TriangleLanes record) {
  const vf farthest = max_f(max_component(abs3(record.p0)), max_component(abs3(record.p1)));
  return is_shape_record(record) & (farthest > 0x1p41f);
}

typedef struct {
  global const Triangle* triangles;
  global const TriangleNormals* triangle_normals;
  global const TriangleTangents* triangle_tangents;
  global const TriangleColors* triangle_colors;
  global const MaterialRecord* materials;
  global const MaterialExtension* material_extensions;
  global const MaterialDetail* material_details;
  global const TextureRecord* textures;
  global const uint* texels;  // EK_TEXEL_TABLE words, then RGBA8; and measured tables
  // Null where the feature is absent.
  global const ShapeRecord* shapes;         // shape
  global Diagnostics* diagnostics;          // implicit
  global const InstanceRecord* instances;   // instance
#if EK_HAS_moving_surface
  global const uint* motion;  // motion.h
  global const uint* motion_nodes;   // of the tree of triangles that move (traverse/motion_tree.h)
  global const uint* motion_leaves;
  global const Triangle* pose_triangles;
  global const TriangleNormals* pose_normals;
  global const TriangleTangents* pose_tangents;
#endif
#if !EK_CHUNKED
  uint absent_classes;  // bit k: no hit is of shading class k (hit_queues.h); a constant in each kernel
#endif
#if EK_HAS_motion
  global const float* motion_cameras;  // film/motion_vector.h
  global const uint* next_corners;
#endif
#if EK_HAS_culling
  uint culled;  // the traced rays pass the backs of triangles and shapes with one of these flags
#endif
} SceneData;

#if !EK_CHUNKED
/// True in a kernel that shades hits of class k alone.
EK_FN int shades_only(SceneData scene, uint k) { return scene.absent_classes == (((1u << SHADING_CLASS_COUNT) - 1u) & ~(1u << k)); }
#endif

// 1 where rays of this kind may pass backs: those that light paths cast to the camera ask for any
// hit.
#define EK_CULLS(any_hit) (EK_HAS_culling & (!(any_hit) | EK_HAS_light_paths))
#if EK_HAS_culling
#define EK_CULLED(scene) ((scene).culled)
#else
#define EK_CULLED(scene) 0u
#endif

// The same as arguments of a kernel; they are bound by these names.
#if EK_HAS_moving_surface
#define EK_MOTION_ARGUMENTS                                                                            \
  , global const uint *motion, global const uint *motion_nodes, global const uint *motion_leaves, \
      global const Triangle *pose_triangles
#define EK_MOTION_DATA \
  , .motion = motion, .motion_nodes = motion_nodes, .motion_leaves = motion_leaves, .pose_triangles = pose_triangles
#define EK_POSE_ARGUMENTS , global const TriangleNormals *pose_normals, global const TriangleTangents *pose_tangents
#define EK_POSE_DATA , .pose_normals = pose_normals, .pose_tangents = pose_tangents
#else
#define EK_MOTION_ARGUMENTS
#define EK_MOTION_DATA
#define EK_POSE_ARGUMENTS
#define EK_POSE_DATA
#endif
#if EK_HAS_instance
#define EK_INSTANCE_ARGUMENTS , global const InstanceRecord *instances EK_MOTION_ARGUMENTS
#define EK_INSTANCE_DATA , .instances = instances EK_MOTION_DATA
#else
#define EK_INSTANCE_ARGUMENTS EK_MOTION_ARGUMENTS
#define EK_INSTANCE_DATA EK_MOTION_DATA
#endif
#if EK_HAS_implicit
#define EK_SHAPE_ARGUMENTS , global const ShapeRecord *shapes, global Diagnostics *diagnostics EK_INSTANCE_ARGUMENTS
#define EK_SHAPE_DATA , .shapes = shapes, .diagnostics = diagnostics EK_INSTANCE_DATA
#elif EK_HAS_shape
#define EK_SHAPE_ARGUMENTS , global const ShapeRecord *shapes EK_INSTANCE_ARGUMENTS
#define EK_SHAPE_DATA , .shapes = shapes EK_INSTANCE_DATA
#else
#define EK_SHAPE_ARGUMENTS EK_INSTANCE_ARGUMENTS
#define EK_SHAPE_DATA EK_INSTANCE_DATA
#endif
#if EK_HAS_motion
#define EK_NEXT_ARGUMENTS , global const float *motion_cameras, global const uint *next_corners
#define EK_NEXT_DATA , .motion_cameras = motion_cameras, .next_corners = next_corners
#else
#define EK_NEXT_ARGUMENTS
#define EK_NEXT_DATA
#endif
#define EK_SCENE_ARGUMENTS                                                                                                \
  global const Triangle *triangles, global const TriangleNormals *triangle_normals,                                      \
      global const TriangleTangents *triangle_tangents, global const TriangleColors *triangle_colors,                    \
      global const MaterialRecord *materials, global const MaterialExtension *material_extensions,                       \
      global const MaterialDetail *material_details, global const TextureRecord *textures, global const uint *texels EK_SHAPE_ARGUMENTS EK_POSE_ARGUMENTS EK_NEXT_ARGUMENTS
#define EK_SCENE_DATA                         \
  {.triangles = triangles,                     \
   .triangle_normals = triangle_normals,       \
   .triangle_tangents = triangle_tangents,     \
   .triangle_colors = triangle_colors,         \
   .materials = materials,                     \
   .material_extensions = material_extensions, \
   .material_details = material_details,       \
   .textures = textures,                       \
   .texels = texels EK_SHAPE_DATA EK_POSE_DATA EK_NEXT_DATA}

#endif
