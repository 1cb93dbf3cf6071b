// SPDX-License-Identifier: Apache-2.0
// The sign of an edge function is exact, even where both rounded products agree.
#include <gtest/gtest.h>

#include <random>

#include "kernels/traverse/traverse_probe.h"

namespace eikon {
namespace {

// The ray along +z from the origin against each triangle by itself, one work-item each.
const char* const kMeetEdges = R"(
#define EK_STACK_SIZE 1
#include "traverse/hit.h"
kernel void edges(constant Frame* frame, global const Triangle* triangles, global uint* hits) {
  const uint index = (uint)get_global_id(0);
  const Geometry geometry = {0, 0, {triangles, 0, 0, 0, 0, 0, 0, 0}};
  const OpacityKey key = {(vu)(0u), (vu)(0u)};
  RayOne rays[EK_WIDTH];
  ray_store(rays, ray_lanes(frame, V3((vf)(0.0f), (vf)(0.0f), (vf)(0.0f)), V3((vf)(0.0f), (vf)(0.0f), (vf)(1.0f)), key), EK_INFINITY);
  const RayOne ray = rays[0];
  Hit hit = no_hit(INFINITY);
  try_triangle(geometry, &ray, index, 0, &hit);
  hits[index] = hit.triangle != EK_NO_HIT;
}
)";

TEST(TraverseEdges, slivers_that_rounding_cannot_tell_from_lines_are_hit_exactly_when_the_ray_is_inside) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> unit(0.5F, 2.0F);
  constexpr std::size_t count = 20'000;
  std::vector<Triangle> triangles(count);
  std::vector<std::uint32_t> expected(count);
  std::size_t undecided = 0, inside = 0;
  for (std::size_t i = 0; i < count; ++i) {
    // Corners on a line through the ray but for rounding.
    const float x = unit(random), y = unit(random), s = unit(random), t = unit(random);
    const float a[2] = {-x, -y}, b[2] = {s * x, s * y}, c[2] = {t * x, t * y};
    triangles[i] = {};
    triangles[i].p0_x = a[0], triangles[i].p0_y = a[1], triangles[i].p0_z = 1;
    triangles[i].p1_x = b[0], triangles[i].p1_y = b[1], triangles[i].p1_z = 1;
    triangles[i].p2_x = c[0], triangles[i].p2_y = c[1], triangles[i].p2_z = 1;
    // Products of two floats are exact in double, and so is the difference of two that are nearly
    // equal.
    const auto edge = [&](const float* p, const float* q) { return double(p[0]) * q[1] - double(p[1]) * q[0]; };
    const auto rounded = [](const float* p, const float* q) { return p[0] * q[1] - p[1] * q[0]; };
    const double ea = edge(c, b), eb = edge(a, c), ec = edge(b, a);
    undecided += rounded(c, b) == 0 && rounded(a, c) == 0 && rounded(b, a) == 0 ? 1 : 0;
    const bool hit = ((ea >= 0 && eb >= 0 && ec >= 0) || (ea <= 0 && eb <= 0 && ec <= 0)) && ea + eb + ec != 0;
    expected[i] = hit ? 1 : 0;
    inside += hit ? 1 : 0;
  }
  ASSERT_GT(undecided, count / 20);  // the test is about these
  ASSERT_GT(inside, count / 20);
  Frame frame{};
  frame.scene_half.x = frame.scene_half.y = frame.scene_half.z = 4;

  for (const auto& opened : test::devices()) {
    Device& device = *opened;
    ProgramOptions options;
    options.defines = feature_defines(false);
    options.defines["EK_WIDTH"] = options.defines["EK_CHUNKED"] = "1";
    Kernel kernel = test::program_of(device, expand_includes(kMeetEdges, "traverse_edges_test.cl"), options).kernel("edges");
    Arguments arguments;
    arguments.set("frame", device.upload(std::vector<Frame>{frame}));
    arguments.set("triangles", device.upload(triangles));
    arguments.set("hits", device.upload(std::vector<std::uint32_t>(count, 2)));
    kernel.bind(arguments);
    device.run(kernel, count, 1, count);
    EXPECT_EQ(device.read_all<std::uint32_t>(arguments.buffers().at("hits")), expected) << device.info().name;
  }
}

}  // namespace
}  // namespace eikon
