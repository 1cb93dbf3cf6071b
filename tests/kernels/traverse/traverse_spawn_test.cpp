// SPDX-License-Identifier: Apache-2.0
// Rays that leave a surface through the production functions do not meet it again.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "kernels/traverse/traverse_probe.h"

namespace eikon {
namespace {

constexpr std::uint32_t kTriangles = 1000, kRaysEach = 1000;

// One work-item per triangle. draws: barycentrics, a direction, a target and unused, per ray.
const char* const kLeaveAndReturn = R"(
#include "traverse/hit.h"
#include "surface/surface.h"
#define EK_STACK_SIZE 1
kernel void leave(constant Frame* frame, global const Triangle* triangles, global const float* draws, global uint* self_hits,
                  uint rays_each) {
  const uint index = (uint)get_global_id(0);
  const Geometry geometry = {0, 0, {triangles, 0, 0, 0, 0, 0, 0, 0}};
  const OpacityKey key = {(vu)(0u), (vu)(0u)};
  const TriangleLanes triangle = load_triangle(triangles, (vu)(index));
  const v3 n = triangle_normal(triangle.p0, triangle.p1, triangle.p2);
  uint count[2] = {0, 0};
  for (uint i = 0; i < rays_each; ++i) {
    global const float* draw = draws + 8 * ((index * 7919u + i * 104729u) % 100003u);
    v3 error;
    const v3 p = triangle_point(triangle.p0, triangle.p1, triangle.p2, (vf)(draw[0]), (vf)(draw[1]), &error);
    const v3 w = V3((vf)(draw[2]), (vf)(draw[3]), (vf)(draw[4]));
    for (uint kind = 0; kind < 2; ++kind) {
      // Kind 1 leaves towards a point, as shadow rays do: the direction is the difference of two
      // points.
      const v3 target = add3(p, scale3(w, (vf)(draw[5])));
      const v3 towards = kind == 0 ? w : sub3(target, p);
      const v3 origin = offset_ray_origin(p, error, n, towards);
      const v3 dir = kind == 0 ? w : sub3(target, origin);
      // A target within rounding error of the surface may lie on its other side as seen from the
      // moved origin.
      const int leaves = (dot3(towards, n) < 0.0f) == (dot3(dir, n) < 0.0f);
      RayOne rays[EK_WIDTH];
      ray_store(rays, ray_lanes(frame, origin, dir, key), EK_INFINITY);
      const RayOne ray = rays[0];
      Hit hit = no_hit(INFINITY);
      try_triangle(geometry, &ray, index, 0, &hit);
      count[kind] += leaves & (hit.triangle != EK_NO_HIT);
    }
  }
  self_hits[2 * index] = count[0];
  self_hits[2 * index + 1] = count[1];
}
)";

/// Triangles with coordinates from 10^-decades to 10^decades: the more, the more of them are
/// needles.
void expect_no_self_hits(float decades) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit(0.0F, 1.0F), exponent(-decades, decades);
  const auto coordinate = [&] { return (unit(random) < 0.5F ? -1.0F : 1.0F) * std::pow(10.0F, exponent(random)); };
  std::vector<Triangle> triangles(kTriangles);
  for (Triangle& t : triangles) {
    for (float* x = &t.p0_x; x <= &t.p2_z; ++x) *x = coordinate();
  }
  std::vector<float> draws;
  for (int i = 0; i < 100'003; ++i) {
    float u = unit(random), v = unit(random);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    draws.insert(draws.end(), {u, v});
    const float z = 2 * unit(random) - 1, phi = 6.2831853F * unit(random), s = std::sqrt(1 - z * z);
    draws.insert(draws.end(), {s * std::cos(phi), s * std::sin(phi), z, std::pow(10.0F, exponent(random)), 0, 0});
  }
  Frame frame{};
  frame.scene_half.x = frame.scene_half.y = frame.scene_half.z = 1e8F;

  for (const auto& opened : test::devices()) {
    Device& device = *opened;
    ProgramOptions options;
    options.defines = feature_defines(false);
    options.defines["EK_WIDTH"] = options.defines["EK_CHUNKED"] = "1";
    Kernel kernel = test::program_of(device, expand_includes(kLeaveAndReturn, "traverse_spawn_test.cl"), options).kernel("leave");
    Arguments arguments;
    arguments.set("frame", device.upload(std::vector<Frame>{frame}));
    arguments.set("triangles", device.upload(triangles));
    arguments.set("draws", device.upload(draws));
    arguments.set("self_hits", device.upload(std::vector<std::uint32_t>(2 * kTriangles, 1)));
    arguments.set("rays_each", kRaysEach);
    kernel.bind(arguments);
    device.run(kernel, kTriangles, 1, kTriangles);
    std::uint32_t total[2] = {0, 0};
    const auto counts = device.read_all<std::uint32_t>(arguments.buffers().at("self_hits"));
    for (std::size_t i = 0; i < counts.size(); ++i) total[i % 2] += counts[i];
    EXPECT_EQ(total[0], 0U) << device.info().name << ": rays, decades " << decades;
    EXPECT_EQ(total[1], 0U) << device.info().name << ": segments to a point, decades " << decades;
  }
}

TEST(TraverseSpawn, G3_rays_that_leave_a_triangle_of_any_size_do_not_hit_it) { expect_no_self_hits(8); }

TEST(TraverseSpawn, rays_that_leave_a_triangle_of_any_shape_do_not_hit_it) {
  for (const float decades : {0.1F, 0.5F, 1.0F, 2.0F, 4.0F}) expect_no_self_hits(decades);
}

}  // namespace
}  // namespace eikon
