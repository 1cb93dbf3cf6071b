// SPDX-License-Identifier: Apache-2.0
// Records that host and kernels share. 64-byte records are read whole by rec16 (lanes.h). tests/kernels/probe/layout_test.cpp
// compares sizes and offsets on every device.
#ifndef EK_SHARED_RECORDS_H
#define EK_SHARED_RECORDS_H
#include "shared/abi.h"
EK_BEGIN

#define EK_NO_HIT 0xffffffffu
#define EK_FILM_LIMBS 4           // 32-bit limbs of a film sum: two's complement, unit 2^-64
#define EK_PAD 112                // slots behind arrays that whole vectors may touch, and where hits wait (hit_classes.h)
#define EK_FILM_PIXELS 64         // of one work-item of stage film on CPU devices
#define EK_ARITHMETIC_WORDS 256   // of the arithmetic probe
#define EK_FILTER_BINS 512        // per side of a pixel filter's table (filter.h)
#define EK_FILTER_WORDS (EK_FILTER_BINS + 3)
#define EK_REPORT_COUNT 8         // rejected samples of a unit that are reported one by one

// What a work unit and the camera are; changes without a recompile.
typedef struct {
  // A film point (x, y) in pixels is seen along camera_corner + x * camera_x + y * camera_y from camera_origin; with
  // EK_HAS_orthographic along camera_corner from camera_origin + x * camera_x + y * camera_y. With EK_HAS_panorama camera_x,
  // camera_y and camera_corner are the camera's right, up and back, unit, and w of the first two the reciprocal size in pixels.
  float4 camera_origin;           // world, metres; w: from the camera's plane to this one, along the rays
  float4 camera_x;
  float4 camera_y;
  float4 camera_corner;
  float4 lens_x;                  // of EK_HAS_lens: to the right rim of the lens, metres; w: reciprocal of the distance in focus
  float4 lens_y;                  // to its upper rim
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
  uint roulette_depth;            // the first edge that roulette decides on
  uint light_count;               // entries of the light table
  uint film_stride;               // paths (padded) between two channels of the film slots
  uint pixel_stride;              // pixels (padded) between two limbs of the film sums
  uint environment_width;         // of the environment map, texels; environment_map.h
  uint environment_height;
  float environment_sin;          // of its rotation about +Y
  float environment_cos;
  uint camera_medium;             // of paths that begin (medium.h)
  uint tree_light_count;          // lights that the tree chooses among, the first ones; 0: there is no tree
  float light_scale;              // metres to the unit of the tree's nodes, a power of two
  float roulette;                 // of EK_HAS_fixed_roulette: probability that a path goes on
} Frame;
EK_ASSERT_SIZE(Frame, 224);

#define EK_TRIANGLE_PASSABLE 1u   // opacity below 1 somewhere: a ray may pass (alpha.h)
#define EK_SHAPE_PASSABLE 2u      // the same in a shape's record
#define EK_TRIANGLE_GROUP_SHIFT 2 // then the light group of what it emits, below EK_LIGHT_GROUPS_MOST
#define EK_TRIANGLE_CLASS_SHIFT 8 // then one of EK_CLASS_*, two bits: what shading it takes (hit_classes.h)
#define EK_TRIANGLE_LIGHT_SHIFT 10  // from here on: index into lights, of those that the tree chooses among
#define EK_CLASS_PLAIN 0u         // flat and exactly Lambert, without textures, colours at the corners or layers
#define EK_CLASS_OPAQUE 1u        // any other that lets no light through
#define EK_CLASS_CLEAR 2u         // of the lobe `transmission`
#define EK_CLASS_COUNT 3u
#define EK_LIGHT_GROUPS_MOST 64

// What shading needs of a triangle. Behind the triangles stand the shapes, a record each: p0 and p1 are their box, p2 is NaN,
// of a sphere with p2_x's sign bit set, and n_x has the bits of their index into shapes.
typedef struct {
  float p0_x, p0_y, p0_z;         // world, metres
  float p1_x, p1_y, p1_z;
  float p2_x, p2_y, p2_z;
  uint material;                  // index into materials
  float light_pdf_m2;             // density of light sampling on its area, 1/m^2; of a shape the probability that it is chosen; 0: not a light
  uint node;                      // of the scene; for the id layer
  float n_x, n_y, n_z;            // (p1 - p0) x (p2 - p0), unit, to the front; from doubles, so needles have one too
  uint flags;                     // EK_TRIANGLE_*, and which light it is
} Triangle;
EK_ASSERT_SIZE(Triangle, 64);

// Vertex normals and the first texture coordinates, only when something needs them (EK_HAS_vertex_normal, EK_HAS_uv).
typedef struct {
  float n0_x, n0_y, n0_z;         // world, unit; all zero: this triangle is flat
  float n1_x, n1_y, n1_z;
  float n2_x, n2_y, n2_z;
  float u0, v0, u1, v1, u2, v2;   // TEXCOORD_0
  uint pad0;
} TriangleNormals;
EK_ASSERT_SIZE(TriangleNormals, 64);

// Tangents and the second texture coordinates (EK_HAS_normal_texture, EK_HAS_uv1).
typedef struct {
  float t0_x, t0_y, t0_z;         // world, unit; all zero: none, the normal map is ignored
  float t1_x, t1_y, t1_z;
  float t2_x, t2_y, t2_z;
  float bitangent_sign;           // bitangent = sign * cross(normal, tangent)
  float u0, v0, u1, v1, u2, v2;   // TEXCOORD_1
} TriangleTangents;
EK_ASSERT_SIZE(TriangleTangents, 64);

// Vertex colours (EK_HAS_vertex_color): linear, with opacity; they multiply base colour and opacity.
typedef struct {
  float r0, g0, b0, a0;
  float r1, g1, b1, a1;
  float r2, g2, b2, a2;
  uint pad0, pad1, pad2, pad3;
} TriangleColors;
EK_ASSERT_SIZE(TriangleColors, 64);

// A surface that is no triangle (EK_HAS_shape). In its own space it is of standard size, as its kernels/shape_<name>.h says:
// own = (x, y, z) (world - center), rows of a matrix; world = center + (wx, wy, wz) own, rows of its inverse.
typedef struct {
  float x_x, x_y, x_z, y_x, y_y, y_z, z_x, z_y, z_z;
  float center_x, center_y, center_z;  // world, metres
  float a, b, c;                  // parameters of its kind
  uint kind;                      // bit of EK_SHAPE_KIND
  float wx_x, wx_y, wx_z, wy_x, wy_y, wy_z, wz_x, wz_y, wz_z;
  float middle_x, middle_y, middle_z;  // implicit: of its bounds, in the formula's coordinates
  uint formula;                   // implicit: which
  float part0_m2, part1_m2, part2_m2;  // world areas of its parts, as its file says, where it is sampled as a light by parts
} ShapeRecord;
EK_ASSERT_SIZE(ShapeRecord, 128);

// A place of a mesh that is stored once (EK_HAS_instance): its triangles' records are in the mesh's own space, and instance.h takes
// them to the world, operation by operation as the host does for meshes that are stored for each place.
typedef struct {
  float m_xx, m_xy, m_xz, t_x;    // world x = m_xx x + m_xy y + m_xz z + t_x
  float m_yx, m_yy, m_yz, t_y;
  float m_zx, m_zy, m_zz, t_z;
  float middle_x, middle_y, middle_z;  // of the mesh's box, in its own space
  uint root;                      // of the mesh's tree: what stands for it as a child (traverse_<layout>.h)
  float i_xx, i_xy, i_xz, i_yx, i_yy, i_yz, i_zx, i_zy, i_zz;  // inverse of m
  float extent_x, extent_y, extent_z;  // of the largest box of a triangle of the mesh, world
  float error;                    // world, metres: how far corners may be from where m in real numbers puts them, on any axis
  float facing;                   // -1 where m mirrors: normals turn
  uint node;                      // of the scene; for the id layer
  uint mesh;                      // which of those that are stored once
} InstanceRecord;
EK_ASSERT_SIZE(InstanceRecord, 128);

// MaterialRecord.flags: the lobe (a bit of EK_LOBE) in the low byte, then these.
#define EK_MATERIAL_DOUBLE_SIDED 0x100u  // emits on both sides
#define EK_MATERIAL_UNLIT 0x200u         // shows its base colour to the camera, and lights nothing
#define EK_MATERIAL_MASK 0x400u          // opacity is 1 from alpha_cutoff on, else 0
#define EK_MATERIAL_BLEND 0x800u         // opacity is the probability of a hit
#define EK_MATERIAL_SOLID 0x1000u        // transmits by refraction; else thin-walled
#define EK_NO_TEXTURE 0xffffffffu
#define EK_MEDIA_MOST 4           // solids that a path knows to be in at once (nested_media.h)
#define EK_MEDIA_RANKS 255        // solids that a scene may have where priorities say how they overlap

// A material's factors; textures (indices into textures, or EK_NO_TEXTURE) multiply them.
typedef struct {
  float base_color_r, base_color_g, base_color_b;
  float emission_r, emission_g, emission_b;  // radiance, W / (sr m^2)
  uint flags;
  float metallic, roughness;
  float ior;                      // 0: reflects everything [KHR_materials_ior]
  float opacity, alpha_cutoff;
  uint base_color_texture;        // RGB, A: opacity
  uint metallic_roughness_texture;  // G: roughness, B: metallic
  uint normal_texture;
  uint emissive_texture;
} MaterialRecord;
EK_ASSERT_SIZE(MaterialRecord, 64);

// What few materials have (EK_HAS_material_extension): KHR_materials_specular, _transmission, _volume, EIKON_materials_measured.
typedef struct {
  float specular;
  float specular_color_r, specular_color_g, specular_color_b;
  float transmission;
  float absorption_r, absorption_g, absorption_b;  // log2 of the transmittance of a metre, <= 0
  uint transmission_texture;      // R
  uint specular_texture;          // A
  uint specular_color_texture;    // RGB
  uint medium_rank;               // of EK_HAS_nested_media: rank of this solid, 1 to 255; 0: it is none
  uint medium_of_rank;            // and, of record i, the material that has rank i + 1
  uint measured_table;            // word of texels where it begins (measured.h)
  uint pad0, pad1;
} MaterialExtension;
EK_ASSERT_SIZE(MaterialExtension, 64);

// What few materials have (EK_HAS_material_detail): KHR_materials_clearcoat, _sheen, _anisotropy, _dispersion,
// _diffuse_transmission, _iridescence, EIKON_materials_conductor, _phong.
typedef struct {
  float clearcoat, clearcoat_roughness;
  float sheen_r, sheen_g, sheen_b, sheen_roughness;
  uint clearcoat_texture;         // R
  uint clearcoat_roughness_texture;  // G
  uint clearcoat_normal_texture;
  uint sheen_color_texture;       // RGB
  uint sheen_roughness_texture;   // A
  float anisotropy;               // strength, [0, 1]
  float anisotropy_cos, anisotropy_sin;  // of its rotation from the tangent towards the bitangent
  uint anisotropy_texture;        // R, G: direction, B: strength
  float phong_shininess;
  float eta_r, eta_g, eta_b;      // of a conductor: its index of refraction, eta + i k
  float k_r, k_g, k_b;
  float spread;                   // by how much the index of B is larger than that of G, and of R smaller
  float diffuse_transmission;
  float diffuse_transmission_r, diffuse_transmission_g, diffuse_transmission_b;
  uint diffuse_transmission_texture;  // A
  uint diffuse_transmission_color_texture;  // RGB
  float phong_r, phong_g, phong_b;  // highlight
  float iridescence;              // share of the surface under a thin film
  float film_index;               // of refraction, >= 1
  float film_least, film_most;    // thickness, nm, for 0 and 1 of its texture
  uint iridescence_texture;       // R
  uint film_texture;              // G
  uint pad0, pad1, pad2, pad3, pad4, pad5, pad6, pad7, pad8, pad9;
} MaterialDetail;
EK_ASSERT_SIZE(MaterialDetail, 192);
#define EK_DETAIL_PARTS 3u        // of 64 bytes

// TextureRecord.flags
#define EK_TEXTURE_SRGB 1u        // R, G, B are sRGB-encoded
#define EK_TEXTURE_NEAREST 2u     // else bilinear
#define EK_TEXTURE_UV1 4u         // TEXCOORD_1, else TEXCOORD_0
#define EK_TEXTURE_CLAMP_U 8u     // neither clamp nor mirror: repeat
#define EK_TEXTURE_MIRROR_U 16u
#define EK_TEXTURE_CLAMP_V 32u
#define EK_TEXTURE_MIRROR_V 64u
#define EK_TEXEL_TABLE 256u       // first words of texels: linear value of each sRGB code, as floats

// One use of an image: where its texels lie, and how they are looked up.
typedef struct {
  uint first_texel;               // word of texels: RGBA, 8 bits each, R lowest; row-major from the top
  uint width, height;
  uint flags;
  float u_u, u_v, u_1;            // image's u = u_u * u + u_v * v + u_1, in [0, 1] over the image
  float v_u, v_v, v_1;            // from the top
  float scale;                    // normal maps: of x and y
  uint pad0, pad1, pad2, pad3, pad4;
} TextureRecord;
EK_ASSERT_SIZE(TextureRecord, 64);

#define EK_LIGHT_DOUBLE_SIDED 1u
#define EK_LIGHT_GROUP_SHIFT 8    // from here on: its light group
#define EK_LIGHT_QUAD 2u          // the parallelogram with sides p1 - p0 and p2 - p0: `triangle` and the one after it

// An emissive triangle or two, or another kind of light. Of a shape `triangle` is the record among the triangles, and places are unset. Of a point or spot light p0 is its place and p2 holds (cosine of the outer
// cone, 1 / its distance from that of the inner one, range^2 or infinity); of a spot and a directional light p1 is the
// direction back to the light, unit; emission is the intensity, W / sr, or of a directional light the irradiance, W / m^2.
// The environment, constant or a map, sets nothing but kind and pdf_m2.
typedef struct {
  float p0_x, p0_y, p0_z;         // world, metres
  float p1_x, p1_y, p1_z;
  float p2_x, p2_y, p2_z;
  float emission_r, emission_g, emission_b;
  float pdf_m2;                   // of a triangle density of light sampling on its area, selection included; else probability of selection;
                                  // of lights in the tree selection is that of the tree as a whole
  uint flags;                     // EK_LIGHT_DOUBLE_SIDED, EK_LIGHT_QUAD, group
  uint kind;                      // bit of EK_LIGHT
  uint triangle;                  // index into triangles
} Light;
EK_ASSERT_SIZE(Light, 64);

// One bucket of an alias table [Walker 1974; Vose 1991] over lights, or over the texels of the environment's map.
typedef struct {
  uint threshold;                 // of 2^32: below, the bucket's own entry; else `alias`
  uint alias;
} LightBucket;
EK_ASSERT_SIZE(LightBucket, 8);

// Two sides of a node of the tree of lights (light_tree.h): moments of the lights there, in the tree's unit. Nodes stand in order of
// depth: the left side is the next one, the right side as many on as there are lights on the left; lights stand in the same order.
typedef struct {
  float left_x, left_y, left_z;   // middle of the emitted energy, world
  float left_spread2;             // mean square of the distance from it, > 0
  float left_flow_x, left_flow_y, left_flow_z;  // mean of the normals
  float left_share;               // of the node's energy
  float right_x, right_y, right_z;
  float right_spread2;
  float right_flow_x, right_flow_y, right_flow_z;
  uint link;                      // how many lights are on the left, and LIGHT_TREE_RIGHT_IS_LIGHT
} LightNode;
EK_ASSERT_SIZE(LightNode, 64);
#define LIGHT_TREE_RIGHT_IS_LIGHT 0x80000000u
#define LIGHT_TREE_LEAST 0x1p-10f  // each side of a node is chosen with this probability at least

#define EK_IMPLICIT_STEPS 4096    // pieces of a ray that are tried in an implicit surface at most

// Raised by kernels, read once per unit.
typedef struct {
  uint nonfinite;                 // samples whose radiance was NaN or infinite
  uint saturated;                 // samples beyond the film's range
  uint reported;                  // entries of `report` that were claimed
  uint report[2 * EK_REPORT_COUNT];  // pixel of the unit, sample of the unit
  uint given_up;                  // rays whose search for an implicit surface took too many steps
  uint given_up_surfaces;         // of which shapes: bit i of number i; bit 31 of that and all behind it
} Diagnostics;
EK_ASSERT_SIZE(Diagnostics, 84);

#define EK_PATH_STAGES 5          // EK_PATH_STAGE of stages.def
#define EK_TALLY_DEPTHS 16        // depths that are counted apart; what is deeper is counted with the last

// What one work-item of kernel `paths` did. Ticks are of the processor's cycle counter, low and high word; 0 where there is none.
typedef struct {
  uint scattered;                 // rays traced beyond the camera's
  uint shadow;                    // shadow rays
  uint begin[2];
  uint end[2];
  uint ticks[2 * EK_PATH_STAGES]; // spent in each stage, in the order of stages.def
  // At depth i + 1: paths, shadow rays, chunks that had any paths, and vectors of EK_WIDTH lanes that they took.
  uint depth_paths[EK_TALLY_DEPTHS];
  uint depth_shadow[EK_TALLY_DEPTHS];
  uint depth_chunks[EK_TALLY_DEPTHS];
  uint depth_vectors[EK_TALLY_DEPTHS];
} WorkerTally;
EK_ASSERT_SIZE(WorkerTally, 320);

EK_END
#endif
