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
#define FRAME_FIELDS(F)                                                                                              \
  F(Frame, camera_origin)                                                                                            \
  F(Frame, camera_x) F(Frame, camera_y) F(Frame, camera_corner) F(Frame, environment) F(Frame, scene_center)         \
      F(Frame, scene_half) F(Frame, path_count) F(Frame, pixel_count) F(Frame, sample_count) F(Frame, sample_begin)  \
          F(Frame, sample_high) F(Frame, seed) F(Frame, replicate_bits) F(Frame, max_depth) F(Frame, roulette_depth) \
              F(Frame, light_count) F(Frame, film_stride) F(Frame, pixel_stride) F(Frame, pad0) F(Frame, pad1)       \
                  F(Frame, pad2) F(Frame, pad3)
#define TRIANGLE_FIELDS(F)                                                                                    \
  F(Triangle, p0_x)                                                                                           \
  F(Triangle, p0_y) F(Triangle, p0_z) F(Triangle, p1_x) F(Triangle, p1_y) F(Triangle, p1_z) F(Triangle, p2_x) \
      F(Triangle, p2_y) F(Triangle, p2_z) F(Triangle, material) F(Triangle, light_pdf_m2) F(Triangle, node)   \
          F(Triangle, n_x) F(Triangle, n_y) F(Triangle, n_z) F(Triangle, pad0)
#define NORMALS_FIELDS(F)                                                                                     \
  F(TriangleNormals, n0_x)                                                                                    \
  F(TriangleNormals, n0_y) F(TriangleNormals, n0_z) F(TriangleNormals, n1_x) F(TriangleNormals, n1_y)         \
      F(TriangleNormals, n1_z) F(TriangleNormals, n2_x) F(TriangleNormals, n2_y) F(TriangleNormals, n2_z)     \
          F(TriangleNormals, pad0) F(TriangleNormals, pad1) F(TriangleNormals, pad2) F(TriangleNormals, pad3) \
              F(TriangleNormals, pad4) F(TriangleNormals, pad5) F(TriangleNormals, pad6)
#define MATERIAL_FIELDS(F)                                                                                            \
  F(MaterialRecord, albedo_r)                                                                                         \
  F(MaterialRecord, albedo_g) F(MaterialRecord, albedo_b) F(MaterialRecord, emission_r) F(MaterialRecord, emission_g) \
      F(MaterialRecord, emission_b) F(MaterialRecord, lobes) F(MaterialRecord, double_sided) F(MaterialRecord, pad0)  \
          F(MaterialRecord, pad1) F(MaterialRecord, pad2) F(MaterialRecord, pad3) F(MaterialRecord, pad4)             \
              F(MaterialRecord, pad5) F(MaterialRecord, pad6) F(MaterialRecord, pad7)
#define LIGHT_FIELDS(F)                                                                                    \
  F(Light, p0_x)                                                                                           \
  F(Light, p0_y) F(Light, p0_z) F(Light, p1_x) F(Light, p1_y) F(Light, p1_z) F(Light, p2_x) F(Light, p2_y) \
      F(Light, p2_z) F(Light, emission_r) F(Light, emission_g) F(Light, emission_b) F(Light, pdf_m2)       \
          F(Light, double_sided) F(Light, kind) F(Light, triangle)
#define BUCKET_FIELDS(F) \
  F(LightBucket, threshold) F(LightBucket, alias) F(LightBucket, scale_own) F(LightBucket, scale_alias)
#define DIAGNOSTICS_FIELDS(F) \
  F(Diagnostics, nonfinite) F(Diagnostics, saturated) F(Diagnostics, reported) F(Diagnostics, report)
#define RECORDS(R)                                                                                   \
  R(Frame, FRAME_FIELDS)                                                                             \
  R(Triangle, TRIANGLE_FIELDS) R(TriangleNormals, NORMALS_FIELDS) R(MaterialRecord, MATERIAL_FIELDS) \
      R(Light, LIGHT_FIELDS) R(LightBucket, BUCKET_FIELDS) R(Diagnostics, DIAGNOSTICS_FIELDS)

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
