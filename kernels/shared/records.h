// SPDX-License-Identifier: Apache-2.0
// The records that host and kernels share (records.def), and the constants that belong to them.
#ifndef EK_SHARED_RECORDS_H
#define EK_SHARED_RECORDS_H
#include "shared/abi.h"
EK_BEGIN

#define EK_NO_HIT 0xffffffffu
#define EK_FILM_LIMBS 4           // 32-bit limbs of a film sum: two's complement, unit 2^-64
#define EK_PAD 112  // slots behind arrays that whole vectors may touch, and where hits
                                  // wait (stages/hit_walk.h)
#define EK_WORK_GROUP 64          // work-items of a work-group on GPU devices
#define EK_FILM_PIXELS 64         // pixels of one work-item of stage `film` on CPU devices
#define EK_ARITHMETIC_WORDS 256   // of the arithmetic probe
#define EK_FILTER_BINS 512        // of a pixel filter's table, per side (film/filter.h)
#define EK_FILTER_WORDS (EK_FILTER_BINS + 3)
#define EK_MOTION_CAMERA_WORDS 16  // of a camera of layer `motion` (film/motion_vector.h)
#define EK_CAMERA_POSE_WORDS 24   // of a pose of a moving camera (film/camera.h)
#define EK_MOTION_HEAD_WORDS 16   // in front of the tree of triangles that move (traverse/motion_tree.h)
#define EK_REPORT_COUNT 8         // rejected samples of a unit that are reported one by one

// Triangle.flags
#define EK_TRIANGLE_ALPHA_TESTED 1u  // the traversal decides whether rays pass it (surface/alpha.h)
#define EK_TRIANGLE_SINGLE_SIDED 2u  // camera rays pass its back (EK_HAS_culling)
#define EK_TRIANGLE_GROUP_SHIFT 2    // six bits: light group of its emission
#define EK_TRIANGLE_CLASS_SHIFT 8    // two bits: SHADING_*, the shading that it takes
// The rest: index of its light. Set for lights of the light tree, and with light paths for all that
// emit; else 0.
#define EK_TRIANGLE_LIGHT_SHIFT 10
// Exactly Lambert and the same all over: no textures, colours, shading normals or layers.
#define SHADING_FLAT_LAMBERT 0u
#define SHADING_OPAQUE 1u         // any other surface that transmits no light
#define SHADING_TRANSMISSIVE 2u   // of the lobe `transmission`
#define SHADING_CLASS_COUNT 3u
#define EK_LIGHT_GROUPS_MOST 64

// MaterialRecord.flags, above the byte of the lobe
#define EK_MATERIAL_DOUBLE_SIDED 0x100u  // emits on both sides
#define EK_MATERIAL_UNLIT 0x200u         // shows its base colour to the camera, and lights nothing
#define EK_MATERIAL_MASK 0x400u          // opacity is 1 from alpha_cutoff on, else 0
#define EK_MATERIAL_BLEND 0x800u         // opacity is the probability of a hit
#define EK_MATERIAL_SOLID 0x1000u        // transmits by refraction; else it is thin-walled
#define EK_NO_TEXTURE 0xffffffffu
#define EK_MEDIA_MOST 4           // solids that a path can be inside of at once (nested_media.h)
#define EK_MEDIA_RANKS 255  // solids that a scene may have where priorities say how they overlap

// TextureRecord.flags
#define EK_TEXTURE_SRGB 1u        // R, G, B are sRGB-encoded
#define EK_TEXTURE_NEAREST 2u     // else bilinear
#define EK_TEXTURE_UV1 4u         // TEXCOORD_1, else TEXCOORD_0
#define EK_TEXTURE_CLAMP_U 8u     // neither clamp nor mirror: repeat
#define EK_TEXTURE_MIRROR_U 16u
#define EK_TEXTURE_CLAMP_V 32u
#define EK_TEXTURE_MIRROR_V 64u
#define EK_TEXEL_TABLE 256u  // first words of texels: linear value of each sRGB code, as floats

// Light.flags
#define EK_LIGHT_DOUBLE_SIDED 1u
// Its inside emits and is seen through its openings, so light sampling chooses among all of it.
#define EK_SHAPE_SHOWS_INSIDE 1u
#define EK_LIGHT_QUAD 2u  // the parallelogram with sides p1 - p0 and p2 - p0: `triangle` and the
                                  // one after it
#define EK_LIGHT_GROUP_SHIFT 8    // the rest: its light group

// LightNode
#define LIGHT_TREE_RIGHT_IS_LIGHT 0x80000000u
#define LIGHT_TREE_LEAST 0x1p-10f  // each side of a node is chosen with at least this probability

#define EK_IMPLICIT_STEPS 4096    // most pieces of a ray that are tried in an implicit surface
#define EK_PATH_STAGES 5          // number of EK_PATH_STAGE in stages.def
#define EK_TALLY_DEPTHS 16  // depths that are counted apart; the last one counts all deeper ones

#define EK_RECORD(T) typedef struct {
#define EK_RECORD_END(T, bytes) } T; EK_ASSERT_SIZE(T, bytes);
#define EK_FLOAT(name) float name;
#define EK_UINT(name) uint name;
#define EK_FLOAT3(name, x, y, z) float x, y, z;
#define EK_JOIN(a, b) a##b
#define EK_NAME_AT(line) EK_JOIN(unused_, line)
#define EK_UNUSED(words) uint EK_NAME_AT(__LINE__)[words];
#define EK_MEMBER(type, name) type name;
#define EK_ARRAY(type, name, count) type name[count];
#include "shared/records.def"
#undef EK_NAME_AT
#undef EK_JOIN

EK_END
#endif
