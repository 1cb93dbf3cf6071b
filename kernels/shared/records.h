// SPDX-License-Identifier: Apache-2.0
// Records that host and kernels share. 64-byte records are read whole by rec16 (lanes.h). tests/kernels/layout_test.cpp
// compares sizes and offsets on every device.
#ifndef EK_SHARED_RECORDS_H
#define EK_SHARED_RECORDS_H
#include "shared/abi.h"
EK_BEGIN

#define EK_NO_HIT 0xffffffffu
#define EK_FILM_LIMBS 4           // 32-bit limbs of a film sum: two's complement, unit 2^-64
#define EK_PAD 16                 // slots behind arrays that whole vectors may touch
#define EK_FILM_PIXELS 64         // of one work-item of stage film on CPU devices
#define EK_ARITHMETIC_WORDS 256   // of the arithmetic probe
#define EK_REPORT_COUNT 8         // rejected samples of a unit that are reported one by one

// What a work unit and the camera are; changes without a recompile.
typedef struct {
  float4 camera_origin;           // world, metres; w unused
  float4 camera_x;                // direction of a film point (x, y) in pixels: camera_corner + x * camera_x + y * camera_y
  float4 camera_y;
  float4 camera_corner;
  float4 environment;             // radiance of the constant environment, W / (sr m^2); w: probability of sampling it
  float4 scene_center;            // of the scene's bounds, world
  float4 scene_half;              // half their extent
  uint path_count;                // paths of this unit: pixel_count * sample_count, path = sample * pixel_count + pixel
  uint pixel_count;
  uint sample_count;
  uint sample_begin;              // low word of the first sample's index; a unit never crosses a multiple of 2^32
  uint sample_high;               // high word
  uint seed;
  uint replicate_bits;            // log2 of the number of replicates
  uint max_depth;                 // 0: no limit
  uint roulette_depth;            // roulette from this depth on
  uint light_count;               // entries of the light table
  uint film_stride;               // paths (padded) between two channels of the film slots
  uint pixel_stride;              // pixels (padded) between two limbs of the film sums
  uint pad0, pad1, pad2, pad3;
} Frame;
EK_ASSERT_SIZE(Frame, 176);

// What shading needs of a triangle.
typedef struct {
  float p0_x, p0_y, p0_z;         // world, metres
  float p1_x, p1_y, p1_z;
  float p2_x, p2_y, p2_z;
  uint material;                  // index into materials
  float light_pdf_m2;             // density of light sampling on its area, 1/m^2; 0: not a light
  uint node;                      // of the scene; for the id layer
  float n_x, n_y, n_z;            // (p1 - p0) x (p2 - p0), unit, to the front; from doubles, so needles have one too
  uint pad0;
} Triangle;
EK_ASSERT_SIZE(Triangle, 64);

// Vertex normals, only when some mesh has its own (EK_HAS_vertex_normal).
typedef struct {
  float n0_x, n0_y, n0_z;         // world, unit
  float n1_x, n1_y, n1_z;
  float n2_x, n2_y, n2_z;
  uint pad0, pad1, pad2, pad3, pad4, pad5, pad6;
} TriangleNormals;
EK_ASSERT_SIZE(TriangleNormals, 64);

typedef struct {
  float albedo_r, albedo_g, albedo_b;
  float emission_r, emission_g, emission_b;  // radiance, W / (sr m^2)
  uint lobes;                     // bit set of EK_LOBE
  uint double_sided;              // 1: emits on both sides
  uint pad0, pad1, pad2, pad3, pad4, pad5, pad6, pad7;
} MaterialRecord;
EK_ASSERT_SIZE(MaterialRecord, 64);

// An emissive triangle, or the environment (kind 1, nothing else set).
typedef struct {
  float p0_x, p0_y, p0_z;         // world, metres
  float p1_x, p1_y, p1_z;
  float p2_x, p2_y, p2_z;
  float emission_r, emission_g, emission_b;
  float pdf_m2;                   // density of light sampling on its area, selection included
  uint double_sided;
  uint kind;                      // bit of EK_LIGHT
  uint triangle;                  // index into triangles
} Light;
EK_ASSERT_SIZE(Light, 64);

// One bucket of the alias table over lights [Walker 1974; Vose 1991].
typedef struct {
  uint threshold;                 // of 2^32: below, the bucket's own light; else `alias`
  uint alias;
  float scale_own;                // 1 / P(own | bucket), for reusing the random number
  float scale_alias;
} LightBucket;
EK_ASSERT_SIZE(LightBucket, 16);

// Raised by kernels, read once per unit.
typedef struct {
  uint nonfinite;                 // samples whose radiance was NaN or infinite
  uint saturated;                 // samples beyond the film's range
  uint reported;                  // entries of `report` that were claimed
  uint report[2 * EK_REPORT_COUNT];  // pixel of the unit, sample of the unit
} Diagnostics;
EK_ASSERT_SIZE(Diagnostics, 76);

EK_END
#endif
