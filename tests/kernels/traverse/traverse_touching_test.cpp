// SPDX-License-Identifier: Apache-2.0
// Rays that leave a surface through the production functions meet the walls that touch it, however
// near they start to them.
#include <gtest/gtest.h>

#include <glm/glm.hpp>
#include <random>

#include "support/accel_fixtures.h"
#include "kernels/traverse/traverse_probe.h"
#include "support/random.h"

namespace eikon {
namespace {

using fixtures::Soup;

// One work-item per ray. starts: weights of the second and third corner and a direction; left: the
// origin and t.
const char* const kLeaveTouching = R"(
#define EK_STACK_SIZE 1
#include "traverse/hit.h"
#include "surface/surface.h"
kernel void leave(constant Frame* frame, global const Triangle* triangles, uint triangle_count, global const float* starts,
                  global const uint* from, global float* left, global uint* met) {
  const uint i = (uint)get_global_id(0);
  const Geometry geometry = {0, 0, {triangles, 0, 0, 0, 0, 0, 0, 0}};
  const OpacityKey key = {(vu)(0u), (vu)(0u)};
  const TriangleLanes t = load_triangle(triangles, (vu)(from[i]));
  global const float* start = starts + 5 * i;
  v3 error;
  const v3 p = triangle_point(t.p0, t.p1, t.p2, (vf)(start[0]), (vf)(start[1]), &error);
  const v3 w = V3((vf)(start[2]), (vf)(start[3]), (vf)(start[4]));
  const v3 origin = offset_ray_origin(p, error, triangle_normal(t.p0, t.p1, t.p2), w);
  RayOne rays[EK_WIDTH];
  ray_store(rays, ray_lanes(frame, origin, w, key), EK_INFINITY);
  const RayOne ray = rays[0];
  Hit hit = no_hit(INFINITY);
  for (uint k = 0; k < triangle_count; ++k) try_triangle(geometry, &ray, k, 0, &hit);
  left[4 * i] = origin.x;
  left[4 * i + 1] = origin.y;
  left[4 * i + 2] = origin.z;
  left[4 * i + 3] = hit.t;
  met[i] = hit.triangle;
}
)";

struct Start {
  std::uint32_t triangle = 0;
  float u = 0, v = 0;
  glm::vec3 w{0};
};

struct Met {
  glm::dvec3 origin{0};
  float t = 0;
  std::uint32_t triangle = 0;
};

std::vector<Met> leave(Device& device, const Soup& soup, const std::vector<Start>& starts) {
  std::vector<Triangle> triangles(soup.size() / 9);
  for (std::size_t i = 0; i < triangles.size(); ++i) std::copy_n(&soup[9 * i], 9, &triangles[i].p0_x);
  std::vector<float> words;
  std::vector<std::uint32_t> from;
  for (const Start& s : starts) {
    words.insert(words.end(), {s.u, s.v, s.w.x, s.w.y, s.w.z});
    from.push_back(s.triangle);
  }
  ProgramOptions options;
  options.defines = feature_defines(false);
  options.defines["EK_WIDTH"] = options.defines["EK_CHUNKED"] = "1";
  Kernel kernel = test::program_of(device, expand_includes(kLeaveTouching, "traverse_touching_test.cl"), options).kernel("leave");
  Arguments arguments;
  arguments.set("frame", device.upload(std::vector<Frame>{frame_of(soup)}));
  arguments.set("triangles", device.upload(triangles));
  arguments.set("triangle_count", static_cast<std::uint32_t>(triangles.size()));
  arguments.set("starts", device.upload(words));
  arguments.set("from", device.upload(from));
  arguments.set("left", device.upload(std::vector<float>(4 * starts.size())));
  arguments.set("met", device.upload(std::vector<std::uint32_t>(starts.size())));
  kernel.bind(arguments);
  device.run(kernel, starts.size(), 1, starts.size());
  const auto left = device.read_all<float>(arguments.buffers().at("left"));
  const auto met = device.read_all<std::uint32_t>(arguments.buffers().at("met"));
  std::vector<Met> out(starts.size());
  for (std::size_t i = 0; i < out.size(); ++i)
    out[i] = {{left[4 * i], left[4 * i + 1], left[4 * i + 2]}, left[4 * i + 3], met[i]};
  return out;
}

struct Plane {
  glm::dvec3 n{0}, p{0};  // n unit, into the box
};
Plane plane_of(const Soup& soup, std::uint32_t triangle, glm::dvec3 inside) {
  const float* c = &soup[9 * triangle];
  const glm::dvec3 p(c[0], c[1], c[2]), q(c[3], c[4], c[5]), r(c[6], c[7], c[8]);
  const glm::dvec3 n = glm::normalize(glm::cross(q - p, r - p));
  return {glm::dot(n, inside - p) < 0 ? -n : n, p};
}

/// Walls around +-1, each reaching `overhang` beyond its neighbours' on all sides.
Soup box(const glm::dmat3& turn, glm::dvec3 center, double overhang) {
  Soup soup;
  const double s = 1 + overhang;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) {
      std::array<glm::vec3, 4> c;
      for (int k = 0; k < 4; ++k) {
        glm::dvec3 p;
        p[axis] = side;
        p[(axis + 1) % 3] = k == 1 || k == 2 ? s : -s;
        p[(axis + 2) % 3] = k >= 2 ? s : -s;
        c[static_cast<std::size_t>(k)] = glm::vec3(turn * p + center);
      }
      for (const auto& corner : {c[0], c[1], c[2], c[0], c[2], c[3]})
        soup.insert(soup.end(), {corner.x, corner.y, corner.z});
    }
  return soup;
}

/// Of rays that start within the box, most of them close to an edge, how many leave it or meet a
/// wall from behind. Those count that start `margin` units of 2^-24 of the coordinates from all
/// walls, and run along none of them within 2^-10.
std::pair<std::size_t, std::size_t> wrong_and_tried(Device& device, const Soup& soup, glm::dvec3 center,
                                                    double overhang, double margin) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> unit(0.0F, 1.0F);
  std::vector<Start> starts;
  std::vector<Plane> planes;
  const auto count = static_cast<std::uint32_t>(soup.size() / 9);
  for (std::uint32_t i = 0; i < count; ++i) planes.push_back(plane_of(soup, i, center));
  for (int i = 0; i < 300'000; ++i) {
    Start start;
    start.triangle = static_cast<std::uint32_t>(random()) % count;
    // Distance to an edge of the room: from 2^-25 up.
    const float s = i % 8 == 0 ? unit(random) : std::exp2(-25 + 12 * unit(random));
    const float at = unit(random), rim = static_cast<float>(overhang / (2 * (1 + overhang)));
    const float one = (1 - 2 * rim) * s + rim, other = (1 - 2 * rim) * at + rim;
    // The first triangle of a quad is where the second of its coordinates is the smaller one;
    // corners as in box().
    const bool first = start.triangle % 2 == 0;
    const float x = first ? 1 - one : one, y = other;
    if (first) {
      if (y > x) continue;
      start.u = x - y, start.v = y;
    } else {
      if (y < x) continue;
      start.u = x, start.v = y - x;
    }
    const float z = 2 * unit(random) - 1, phi = 6.2831853F * unit(random), r = std::sqrt(1 - z * z);
    start.w = {r * std::cos(phi), r * std::sin(phi), z};
    const Plane& own = planes[start.triangle];
    if (glm::dot(own.n, glm::dvec3(start.w)) < 0) start.w = -start.w;
    starts.push_back(start);
  }
  const std::vector<Met> met = leave(device, soup, starts);
  std::size_t wrong = 0, tried = 0;
  for (std::size_t i = 0; i < starts.size(); ++i) {
    bool within = true;
    for (const Plane& plane : planes)
      within = within &&
               glm::dot(plane.n, met[i].origin - plane.p) >
                   margin * 0x1p-24 * glm::dot(glm::abs(plane.n), glm::abs(met[i].origin)) &&
               std::abs(glm::dot(plane.n, glm::dvec3(starts[i].w))) > 0x1p-10;
    if (!within) continue;
    ++tried;
    wrong += met[i].triangle == EK_NO_HIT || glm::dot(planes[met[i].triangle].n, glm::dvec3(starts[i].w)) > 0 ? 1 : 0;
  }
  return {wrong, tried};
}

TEST(TraverseTouching, a_ray_from_the_corner_of_a_box_meets_the_floor_beside_it) {
  Device& device = *test::devices().front();
  ProbeRay ray;
  ray.o = {0.326411486F, -0.999995589F, 0.999999464F};
  ray.d = {-0.649F, -0.633F, -0.422F};
  for (const std::string& layout : every_layout()) {
    TraverseProbe probe(device, box(glm::dmat3(1), glm::dvec3(0), 0), {layout});
    EXPECT_NEAR(probe.closest({ray})[0].t, (ray.o[1] + 1) / 0.633, 1e-8) << layout;
    EXPECT_TRUE(probe.any({ray})[0]) << layout;
  }
}

TEST(TraverseTouching, no_ray_leaves_a_box_or_meets_a_wall_from_behind) {
  Device& device = *test::devices().front();
  for (const double overhang : {0.0, 0.5})
    for (const glm::dvec3& center : {glm::dvec3(0), glm::dvec3(1), glm::dvec3(1, -1, 7), glm::dvec3(-300, 20, 4000)}) {
      const auto [wrong, tried] = wrong_and_tried(device, box(glm::dmat3(1), center, overhang), center, overhang, 0.0);
      EXPECT_GT(tried, 20'000U);
      EXPECT_EQ(wrong, 0U) << "of " << tried << ", center " << center.z << ", overhang " << overhang;
    }
}

TEST(TraverseTouching, no_ray_leaves_a_turned_box) {
  Device& device = *test::devices().front();
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 8; ++i) {
    const glm::dvec3 x = test::random_direction(random);
    const glm::dvec3 z = glm::normalize(glm::cross(x, test::random_direction(random)));
    const glm::dvec3 center = i < 4 ? glm::dvec3(0) : glm::dvec3(normal(random), 3 * normal(random), normal(random));
    const double overhang = i % 2 == 0 ? 0 : 0.5;
    const auto [wrong, tried] =
        wrong_and_tried(device, box({x, glm::cross(z, x), z}, center, overhang), center, overhang, 5.0);
    EXPECT_GT(tried, 20'000U);
    EXPECT_EQ(wrong, 0U) << "of " << tried << ", box " << i;
  }
}

TEST(TraverseTouching, G1_rays_from_a_bumpy_sphere_do_not_meet_their_triangle_nor_leave_inwards) {
  Device& device = *test::devices().front();
  std::mt19937 random(5);
  std::uniform_real_distribution<float> unit(0.0F, 1.0F);
  std::vector<float> radii(9 * 16);
  for (float& r : radii) r = 1 + 5 * unit(random);
  const Soup sphere = fixtures::sphere(8, [&](int i, int j) { return radii[static_cast<std::size_t>(16 * i + j)]; });
  Soup soup;  // without the triangles of no area at its poles
  for (std::size_t i = 0; i < sphere.size(); i += 9)
    if (!std::equal(&sphere[i], &sphere[i + 3], &sphere[i + 3]) &&
        !std::equal(&sphere[i], &sphere[i + 3], &sphere[i + 6]) &&
        !std::equal(&sphere[i + 3], &sphere[i + 6], &sphere[i + 6]))
      soup.insert(soup.end(), &sphere[i], &sphere[i] + 9);
  const auto count = static_cast<std::uint32_t>(soup.size() / 9);
  std::vector<Start> starts;
  std::vector<bool> inwards;
  for (int i = 0; i < 200'000; ++i) {
    Start start;
    start.triangle = static_cast<std::uint32_t>(i) % count;
    start.u = unit(random), start.v = unit(random);
    if (start.u + start.v > 1) start.u = 1 - start.u, start.v = 1 - start.v;
    const float z = 2 * unit(random) - 1, phi = 6.2831853F * unit(random), r = std::sqrt(1 - z * z);
    start.w = {r * std::cos(phi), r * std::sin(phi), z};
    starts.push_back(start);
    // The sphere is a star around its centre.
    inwards.push_back(glm::dot(plane_of(soup, start.triangle, glm::dvec3(0)).n, glm::dvec3(start.w)) > 0);
  }
  const std::vector<Met> met = leave(device, soup, starts);
  std::size_t own = 0, escaped = 0;
  for (std::size_t i = 0; i < met.size(); ++i) {
    own += met[i].triangle == starts[i].triangle ? 1 : 0;
    escaped += inwards[i] && met[i].triangle == EK_NO_HIT ? 1 : 0;
  }
  EXPECT_EQ(own, 0U);
  EXPECT_EQ(escaped, 0U);
}

}  // namespace
}  // namespace eikon
