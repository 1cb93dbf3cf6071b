// SPDX-License-Identifier: Apache-2.0
// Host and device must agree on every field of every shared record.
#include <gtest/gtest.h>

#include <cstddef>

#include "device/device.h"
#include "device/kernel_sources.h"
#include "shared/records.h"

namespace eikon {
namespace {

// Every field of every record; the sizes below add up, so none can be forgotten.
// clang-format off: it breaks the lists anew when one field is added.
#define FRAME_FIELDS(F)                                                                                           \
  F(Frame, camera_origin)                                                                                         \
  F(Frame, camera_x)                                                                                              \
  F(Frame, camera_y)                                                                                              \
  F(Frame, camera_corner)                                                                                         \
  F(Frame, lens_x)                                                                                                \
  F(Frame, lens_y)                                                                                                \
  F(Frame, environment) F(Frame, scene_center) F(Frame, scene_half) F(Frame, path_count) F(Frame, pixel_count)    \
      F(Frame, sample_count) F(Frame, sample_begin) F(Frame, sample_high) F(Frame, seed) F(Frame, replicate_bits) \
          F(Frame, max_depth) F(Frame, roulette_depth) F(Frame, light_count) F(Frame, film_stride)                \
              F(Frame, pixel_stride) F(Frame, environment_width) F(Frame, environment_height)                     \
                  F(Frame, environment_sin) F(Frame, environment_cos) F(Frame, camera_medium)                     \
                      F(Frame, tree_light_count) F(Frame, light_scale) F(Frame, roulette)
#define TRIANGLE_FIELDS(F)                                                                                        \
  F(Triangle, p0_x)                                                                                               \
  F(Triangle, p0_y)                                                                                               \
  F(Triangle, p0_z)                                                                                               \
  F(Triangle, p1_x)                                                                                               \
  F(Triangle, p1_y) F(Triangle, p1_z) F(Triangle, p2_x) F(Triangle, p2_y) F(Triangle, p2_z) F(Triangle, material) \
      F(Triangle, light_pdf_m2) F(Triangle, node) F(Triangle, n_x) F(Triangle, n_y) F(Triangle, n_z)              \
          F(Triangle, flags)
#define NORMALS_FIELDS(F)  \
  F(TriangleNormals, n0_x) \
  F(TriangleNormals, n0_y) \
  F(TriangleNormals, n0_z) \
  F(TriangleNormals, n1_x) \
  F(TriangleNormals, n1_y) \
  F(TriangleNormals, n1_z) \
  F(TriangleNormals, n2_x) \
  F(TriangleNormals, n2_y) \
  F(TriangleNormals, n2_z) \
  F(TriangleNormals, u0)   \
  F(TriangleNormals, v0)   \
  F(TriangleNormals, u1)   \
  F(TriangleNormals, v1)   \
  F(TriangleNormals, u2)   \
  F(TriangleNormals, v2)   \
  F(TriangleNormals, pad0)
#define TANGENTS_FIELDS(F)            \
  F(TriangleTangents, t0_x)           \
  F(TriangleTangents, t0_y)           \
  F(TriangleTangents, t0_z)           \
  F(TriangleTangents, t1_x)           \
  F(TriangleTangents, t1_y)           \
  F(TriangleTangents, t1_z)           \
  F(TriangleTangents, t2_x)           \
  F(TriangleTangents, t2_y)           \
  F(TriangleTangents, t2_z)           \
  F(TriangleTangents, bitangent_sign) \
  F(TriangleTangents, u0)             \
  F(TriangleTangents, v0)             \
  F(TriangleTangents, u1)             \
  F(TriangleTangents, v1)             \
  F(TriangleTangents, u2)             \
  F(TriangleTangents, v2)
#define COLORS_FIELDS(F)  \
  F(TriangleColors, r0)   \
  F(TriangleColors, g0)   \
  F(TriangleColors, b0)   \
  F(TriangleColors, a0)   \
  F(TriangleColors, r1)   \
  F(TriangleColors, g1)   \
  F(TriangleColors, b1)   \
  F(TriangleColors, a1)   \
  F(TriangleColors, r2)   \
  F(TriangleColors, g2)   \
  F(TriangleColors, b2)   \
  F(TriangleColors, a2)   \
  F(TriangleColors, pad0) \
  F(TriangleColors, pad1) \
  F(TriangleColors, pad2) \
  F(TriangleColors, pad3)
#define MATERIAL_FIELDS(F)                      \
  F(MaterialRecord, base_color_r)               \
  F(MaterialRecord, base_color_g)               \
  F(MaterialRecord, base_color_b)               \
  F(MaterialRecord, emission_r)                 \
  F(MaterialRecord, emission_g)                 \
  F(MaterialRecord, emission_b)                 \
  F(MaterialRecord, flags)                      \
  F(MaterialRecord, metallic)                   \
  F(MaterialRecord, roughness)                  \
  F(MaterialRecord, ior)                        \
  F(MaterialRecord, opacity)                    \
  F(MaterialRecord, alpha_cutoff)               \
  F(MaterialRecord, base_color_texture)         \
  F(MaterialRecord, metallic_roughness_texture) \
  F(MaterialRecord, normal_texture)             \
  F(MaterialRecord, emissive_texture)
#define EXTENSION_FIELDS(F)                    \
  F(MaterialExtension, specular)               \
  F(MaterialExtension, specular_color_r)       \
  F(MaterialExtension, specular_color_g)       \
  F(MaterialExtension, specular_color_b)       \
  F(MaterialExtension, transmission)           \
  F(MaterialExtension, absorption_r)           \
  F(MaterialExtension, absorption_g)           \
  F(MaterialExtension, absorption_b)           \
  F(MaterialExtension, transmission_texture)   \
  F(MaterialExtension, specular_texture)       \
  F(MaterialExtension, specular_color_texture) \
  F(MaterialExtension, medium_rank)            \
  F(MaterialExtension, medium_of_rank)         \
  F(MaterialExtension, measured_table)         \
  F(MaterialExtension, pad0)                   \
  F(MaterialExtension, pad1)
#define DETAIL_FIELDS(F)                                \
  F(MaterialDetail, iridescence)                        \
  F(MaterialDetail, film_index)                         \
  F(MaterialDetail, film_least)                         \
  F(MaterialDetail, film_most)                          \
  F(MaterialDetail, iridescence_texture)                \
  F(MaterialDetail, film_texture)                       \
  F(MaterialDetail, pad0)                               \
  F(MaterialDetail, pad1)                               \
  F(MaterialDetail, pad2)                               \
  F(MaterialDetail, pad3)                               \
  F(MaterialDetail, pad4)                               \
  F(MaterialDetail, pad5)                               \
  F(MaterialDetail, pad6)                               \
  F(MaterialDetail, pad7)                               \
  F(MaterialDetail, pad8)                               \
  F(MaterialDetail, pad9)                               \
  F(MaterialDetail, clearcoat)                          \
  F(MaterialDetail, clearcoat_roughness)                \
  F(MaterialDetail, sheen_r)                            \
  F(MaterialDetail, sheen_g)                            \
  F(MaterialDetail, sheen_b)                            \
  F(MaterialDetail, sheen_roughness)                    \
  F(MaterialDetail, clearcoat_texture)                  \
  F(MaterialDetail, clearcoat_roughness_texture)        \
  F(MaterialDetail, clearcoat_normal_texture)           \
  F(MaterialDetail, sheen_color_texture)                \
  F(MaterialDetail, sheen_roughness_texture)            \
  F(MaterialDetail, anisotropy)                         \
  F(MaterialDetail, anisotropy_cos)                     \
  F(MaterialDetail, anisotropy_sin)                     \
  F(MaterialDetail, anisotropy_texture)                 \
  F(MaterialDetail, phong_shininess)                    \
  F(MaterialDetail, eta_r)                              \
  F(MaterialDetail, eta_g)                              \
  F(MaterialDetail, eta_b)                              \
  F(MaterialDetail, k_r)                                \
  F(MaterialDetail, k_g)                                \
  F(MaterialDetail, k_b)                                \
  F(MaterialDetail, spread)                             \
  F(MaterialDetail, diffuse_transmission)               \
  F(MaterialDetail, diffuse_transmission_r)             \
  F(MaterialDetail, diffuse_transmission_g)             \
  F(MaterialDetail, diffuse_transmission_b)             \
  F(MaterialDetail, diffuse_transmission_texture)       \
  F(MaterialDetail, diffuse_transmission_color_texture) \
  F(MaterialDetail, phong_r)                            \
  F(MaterialDetail, phong_g)                            \
  F(MaterialDetail, phong_b)
#define TEXTURE_FIELDS(F)       \
  F(TextureRecord, first_texel) \
  F(TextureRecord, width)       \
  F(TextureRecord, height)      \
  F(TextureRecord, flags)       \
  F(TextureRecord, u_u)         \
  F(TextureRecord, u_v)         \
  F(TextureRecord, u_1)         \
  F(TextureRecord, v_u)         \
  F(TextureRecord, v_v)         \
  F(TextureRecord, v_1)         \
  F(TextureRecord, scale)       \
  F(TextureRecord, pad0)        \
  F(TextureRecord, pad1)        \
  F(TextureRecord, pad2)        \
  F(TextureRecord, pad3)        \
  F(TextureRecord, pad4)
#define LIGHT_FIELDS(F)                                                                                                \
  F(Light, p0_x)                                                                                                       \
  F(Light, p0_y)                                                                                                       \
  F(Light, p0_z)                                                                                                       \
  F(Light, p1_x)                                                                                                       \
  F(Light, p1_y) F(Light, p1_z) F(Light, p2_x) F(Light, p2_y) F(Light, p2_z) F(Light, emission_r) F(Light, emission_g) \
      F(Light, emission_b) F(Light, pdf_m2) F(Light, flags) F(Light, kind) F(Light, triangle)
#define SHAPE_FIELDS(F)    \
  F(ShapeRecord, x_x)      \
  F(ShapeRecord, x_y)      \
  F(ShapeRecord, x_z)      \
  F(ShapeRecord, y_x)      \
  F(ShapeRecord, y_y)      \
  F(ShapeRecord, y_z)      \
  F(ShapeRecord, z_x)      \
  F(ShapeRecord, z_y)      \
  F(ShapeRecord, z_z)      \
  F(ShapeRecord, center_x) \
  F(ShapeRecord, center_y) \
  F(ShapeRecord, center_z) \
  F(ShapeRecord, a)        \
  F(ShapeRecord, b)        \
  F(ShapeRecord, c)        \
  F(ShapeRecord, kind)     \
  F(ShapeRecord, wx_x)     \
  F(ShapeRecord, wx_y)     \
  F(ShapeRecord, wx_z)     \
  F(ShapeRecord, wy_x)     \
  F(ShapeRecord, wy_y)     \
  F(ShapeRecord, wy_z)     \
  F(ShapeRecord, wz_x)     \
  F(ShapeRecord, wz_y)     \
  F(ShapeRecord, wz_z)     \
  F(ShapeRecord, middle_x) \
  F(ShapeRecord, middle_y) \
  F(ShapeRecord, middle_z) \
  F(ShapeRecord, formula)  \
  F(ShapeRecord, part0_m2) \
  F(ShapeRecord, part1_m2) \
  F(ShapeRecord, part2_m2)
#define INSTANCE_FIELDS(F)    \
  F(InstanceRecord, m_xx)     \
  F(InstanceRecord, m_xy)     \
  F(InstanceRecord, m_xz)     \
  F(InstanceRecord, t_x)      \
  F(InstanceRecord, m_yx)     \
  F(InstanceRecord, m_yy)     \
  F(InstanceRecord, m_yz)     \
  F(InstanceRecord, t_y)      \
  F(InstanceRecord, m_zx)     \
  F(InstanceRecord, m_zy)     \
  F(InstanceRecord, m_zz)     \
  F(InstanceRecord, t_z)      \
  F(InstanceRecord, middle_x) \
  F(InstanceRecord, middle_y) \
  F(InstanceRecord, middle_z) \
  F(InstanceRecord, root)     \
  F(InstanceRecord, i_xx)     \
  F(InstanceRecord, i_xy)     \
  F(InstanceRecord, i_xz)     \
  F(InstanceRecord, i_yx)     \
  F(InstanceRecord, i_yy)     \
  F(InstanceRecord, i_yz)     \
  F(InstanceRecord, i_zx)     \
  F(InstanceRecord, i_zy)     \
  F(InstanceRecord, i_zz)     \
  F(InstanceRecord, extent_x) \
  F(InstanceRecord, extent_y) \
  F(InstanceRecord, extent_z) \
  F(InstanceRecord, error)    \
  F(InstanceRecord, facing)   \
  F(InstanceRecord, node)     \
  F(InstanceRecord, mesh)
#define BUCKET_FIELDS(F) F(LightBucket, threshold) F(LightBucket, alias)
#define NODE_FIELDS(F)                                                                                        \
  F(LightNode, left_x)                                                                                        \
  F(LightNode, left_y)                                                                                        \
  F(LightNode, left_z)                                                                                        \
  F(LightNode, left_spread2)                                                                                  \
  F(LightNode, left_flow_x) F(LightNode, left_flow_y) F(LightNode, left_flow_z) F(LightNode, left_share)      \
      F(LightNode, right_x) F(LightNode, right_y) F(LightNode, right_z) F(LightNode, right_spread2)           \
          F(LightNode, right_flow_x) F(LightNode, right_flow_y) F(LightNode, right_flow_z) F(LightNode, link)
#define DIAGNOSTICS_FIELDS(F) \
  F(Diagnostics, nonfinite)   \
  F(Diagnostics, saturated)   \
  F(Diagnostics, reported) F(Diagnostics, report) F(Diagnostics, given_up) F(Diagnostics, given_up_surfaces)
#define RECORDS(R)                                                                                         \
  R(Frame, FRAME_FIELDS)                                                                                   \
  R(Triangle, TRIANGLE_FIELDS)                                                                             \
  R(TriangleNormals, NORMALS_FIELDS)                                                                       \
  R(MaterialRecord, MATERIAL_FIELDS)                                                                       \
  R(TriangleTangents, TANGENTS_FIELDS)                                                                     \
  R(TriangleColors, COLORS_FIELDS) R(MaterialExtension, EXTENSION_FIELDS) R(MaterialDetail, DETAIL_FIELDS)                                   \
      R(TextureRecord, TEXTURE_FIELDS) R(Light, LIGHT_FIELDS) R(LightBucket, BUCKET_FIELDS) R(LightNode, NODE_FIELDS) \
          R(Diagnostics, DIAGNOSTICS_FIELDS) R(ShapeRecord, SHAPE_FIELDS) R(InstanceRecord, INSTANCE_FIELDS)
// clang-format on

#define FIELD_SIZE(record, field) +sizeof(record::field)
#define CHECK_COMPLETE(record, fields) \
  static_assert(sizeof(record) == 0 fields(FIELD_SIZE), "layout_test.cpp lacks a field of " #record);
RECORDS(CHECK_COMPLETE)

struct Place {
  const char* name;
  std::uint32_t offset;
};
#define PLACE(record, field) {#record "." #field, std::uint32_t(offsetof(record, field))},
#define PLACES(record, fields) {"sizeof " #record, std::uint32_t(sizeof(record))}, fields(PLACE)
const Place kHost[] = {RECORDS(PLACES)};

#define OFFSET_TEXT(record, field) "  *out++ = (uint)((private char*)&x." #field " - (private char*)&x);\n"
#define RECORD_TEXT(record, fields) "  { " #record " x; *out++ = (uint)sizeof(x);\n" fields(OFFSET_TEXT) "  }\n"

TEST(Layout, every_field_of_every_shared_record_lies_where_the_host_has_it) {
  const std::string text = expand_includes(
      "#include \"shared/records.h\"\nkernel void layout(global uint* out) {\n" RECORDS(RECORD_TEXT) "}\n",
      "layout.cl");
  for (const DeviceInfo& info : list_devices()) {
    if (!info.unusable.empty()) continue;
    Device device(info);
    const Buffer out = device.allocate(std::size(kHost) * 4);
    device.fill_zero(out);
    Arguments arguments;
    arguments.set("out", out);
    Kernel kernel = device.build(text, {.defines = {}, .optimise = false}).kernel("layout");
    kernel.bind(arguments);
    device.run(kernel, 1, 1, 1);
    const auto found = device.read_all<std::uint32_t>(out);
    for (std::size_t i = 0; i < std::size(kHost); ++i)
      EXPECT_EQ(found[i], kHost[i].offset) << kHost[i].name << " on " << info.name;
  }
}

}  // namespace
}  // namespace eikon
