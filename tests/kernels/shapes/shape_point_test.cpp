// SPDX-License-Identifier: Apache-2.0
// Where rays met shapes: no ray that leaves meets its shape again, none gets out of a closed solid,
// and textures lie as documented.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "kernels/shapes/shape_cloud.h"
#include "kernels/shapes/shape_oracle.h"

namespace eikon {
namespace {

// One ray per work-item: the point where it met its shape, the normal there, the bound of its
// error, texture coordinates, and the origin of a ray that leaves in the given direction.
const char* const kSource = R"(
#define EK_STACK_SIZE 1
#include "traverse/hit.h"
#include "shapes/shape_surface.h"
kernel void leave(global const Triangle* triangles, global const ShapeRecord* shapes, global const float* rays,
                  global const float* hits, global const float* dirs, global float* points, uint stride) {
  const uint i = (uint)get_global_id(0);
  const SceneData scene = {.triangles = triangles, .shapes = shapes};
  const TriangleLanes corners = load_triangle(triangles, as_uint(hits[3 * stride + i]));
  const v3 origin = V3(rays[i], rays[stride + i], rays[2 * stride + i]);
  const v3 dir = V3(rays[3 * stride + i], rays[4 * stride + i], rays[5 * stride + i]);
  Surface surface = surface_at(corners, hits[stride + i], hits[2 * stride + i], scale3(dir, hits[i]));
  const ShapePoint at = shape_surface(scene, corners, hits[stride + i], origin, dir, hits[i], &surface);
  const v3 w = V3(dirs[3 * i], dirs[3 * i + 1], dirs[3 * i + 2]);
  const v3 from = offset_ray_origin(surface.p, surface.p_error, surface.n_geom, w);
  const HitAttributes none = {from, 0, 0, 0, 0, from, 0, 0, 0, 0, 0};
  const HitAttributes said = shape_attributes(scene, corners, at, surface.n_geom, none);
  global float* out = points + 18 * i;
  out[0] = surface.p.x; out[1] = surface.p.y; out[2] = surface.p.z;
  out[3] = surface.n_geom.x; out[4] = surface.n_geom.y; out[5] = surface.n_geom.z;
  out[6] = surface.p_error.x; out[7] = surface.p_error.y; out[8] = surface.p_error.z;
  out[9] = from.x; out[10] = from.y; out[11] = from.z;
  out[12] = said.uv0_u; out[13] = said.uv0_v;
  out[14] = said.tangent.x; out[15] = said.tangent.y; out[16] = said.tangent.z; out[17] = said.bitangent_sign;
}
)";

struct Point {
  glm::dvec3 p, n, error, origin;
  double u, v;
  glm::dvec3 tangent;
  double bitangent_sign;
};

std::vector<Point> points_of(Device& device, const Packed& packed, const std::vector<ProbeRay>& rays,
                             const std::vector<ProbeHit>& hits, const std::vector<glm::dvec3>& dirs) {
  ProgramOptions options;
  options.defines = packed.features.defines();
  for (const auto& [name, value] : std::map<std::string, std::string>{
           {"EK_WIDTH", "1"}, {"EK_CHUNKED", "1"}, {"EK_HAS_uv", "1"}, {"EK_HAS_tangent", "1"}})
    options.defines[name] = value;
  Accel none;
  none.layout = "none";
  options.defines.merge(none.defines());
  Kernel kernel = test::program_of(device, expand_includes(kSource, "shape_hit_test.cl"), options).kernel("leave");
  const std::size_t stride = rays.size();
  std::vector<float> ray_words(6 * stride), hit_words(4 * stride), dir_words;
  for (std::size_t i = 0; i < stride; ++i) {
    for (std::size_t k = 0; k < 3; ++k)
      ray_words[k * stride + i] = rays[i].o[k], ray_words[(3 + k) * stride + i] = rays[i].d[k];
    hit_words[i] = hits[i].t, hit_words[stride + i] = hits[i].u, hit_words[2 * stride + i] = hits[i].v;
    hit_words[3 * stride + i] = std::bit_cast<float>(hits[i].triangle);
    for (int k = 0; k < 3; ++k) dir_words.push_back(float(dirs[i][k]));
  }
  Arguments arguments;
  arguments.set("triangles",
                device.upload(std::vector<Triangle>(packed.scene.triangles.begin(), packed.scene.triangles.end())));
  arguments.set("shapes",
                device.upload(std::vector<ShapeRecord>(packed.scene.shapes.begin(), packed.scene.shapes.end())));
  arguments.set("rays", device.upload(ray_words));
  arguments.set("hits", device.upload(hit_words));
  arguments.set("dirs", device.upload(dir_words));
  arguments.set("points", device.upload(std::vector<float>(18 * stride)));
  arguments.set("stride", std::uint32_t(stride));
  kernel.bind(arguments);
  device.run(kernel, stride, 1, stride);
  const std::vector<float> words = device.read_all<float>(arguments.buffers().at("points"));
  std::vector<Point> points(stride);
  for (std::size_t i = 0; i < stride; ++i) {
    const auto vector = [&](std::size_t at) {
      const float* w = &words[18 * i + at];
      return glm::dvec3(w[0], w[1], w[2]);
    };
    points[i] = {vector(0),
                 vector(3),
                 vector(6),
                 vector(9),
                 double(words[18 * i + 12]),
                 double(words[18 * i + 13]),
                 vector(14),
                 double(words[18 * i + 17])};
  }
  return points;
}

/// Rays that meet one shape, from outside and inside.
struct Met {
  std::vector<ProbeRay> rays;
  std::vector<ProbeHit> hits;
};
Met rays_that_meet(TraverseProbe& probe, const Scene& scene, std::size_t count, double size, std::uint32_t seed) {
  const std::vector<ProbeRay> rays = rays_at(scene, count, size, seed);
  const std::vector<ProbeHit> hits = probe.closest(rays);
  Met met;
  for (std::size_t i = 0; i < rays.size(); ++i)
    if (hits[i].triangle != EK_NO_HIT) met.rays.push_back(rays[i]), met.hits.push_back(hits[i]);
  EXPECT_GT(met.rays.size(), count / 4);
  return met;
}

TEST(ShapeHits, G4_rays_that_leave_a_convex_shape_do_not_hit_it_and_none_gets_out_of_it) {
  Device& device = *test::devices().front();
  for (const ShapeKindInfo& kind : shape_kinds()) {
    if (kind.kind == ShapeKind::plane) continue;  // has no inside
    for (const double size : {1e-6, 0.015, 1.0, 1e8}) {
      for (const double far : {0.0, 30.0, 1e4}) {
        for (const double stretch : {0.0, 1.5, 4.0}) {
          test::Random random(9);
          Scene scene;
          scene.materials.emplace_back();
          scene.shapes.push_back(shape_of(kind.kind, size * far * glm::dvec3(0.5, 0.083, -0.4), size, stretch, random));
          const Packed packed(scene);
          TraverseProbe probe(device, packed.scene, packed.features, packed.settings, {"bvh8", 8});
          const Met met = rays_that_meet(probe, scene, 4000, size, 10);
          std::vector<glm::dvec3> dirs(met.rays.size());
          std::vector<Point> points = points_of(device, packed, met.rays, met.hits, dirs);
          const Oracle oracle(packed.scene.shapes[0]);
          std::vector<ProbeRay> leaving(met.rays.size());
          for (std::size_t i = 0; i < dirs.size(); ++i) {
            dirs[i] = test::random_direction(random);
            // Half of them within a thousandth of the surface.
            if (i % 2 == 0)
              dirs[i] = glm::normalize(
                  dirs[i] - points[i].n * (glm::dot(dirs[i], points[i].n) + test::uniform(random, -1e-3, 1e-3)));
          }
          points = points_of(device, packed, met.rays, met.hits, dirs);
          for (std::size_t i = 0; i < dirs.size(); ++i) {
            // The surface is on both sides of the point within its error along the normal, and the
            // normal is unit.
            const Point& at = points[i];
            const glm::dvec3 own = oracle.l * (at.p - oracle.center), out = oracle.l * at.n;
            const double error = 1.01 * glm::dot(glm::abs(at.n), at.error);
            ASSERT_GE(oracle.height(own + error * out), 0)
                << kind.name << " size " << size << " far " << far << " stretch " << stretch;
            ASSERT_LE(oracle.height(own - error * out), 0)
                << kind.name << " size " << size << " far " << far << " stretch " << stretch;
            ASSERT_NEAR(glm::length(at.n), 1, 1e-6);
            for (std::size_t k = 0; k < 3; ++k) {
              leaving[i].o[k] = float(at.origin[int(k)]);
              leaving[i].d[k] = float(dirs[i][int(k)]);
            }
          }
          const std::vector<ProbeHit> again = probe.closest(leaving);
          std::size_t outwards = 0, inwards = 0, self_hits = 0, leaks = 0;
          for (std::size_t i = 0; i < again.size(); ++i) {
            const glm::dvec3 d(leaving[i].d[0], leaving[i].d[1], leaving[i].d[2]);
            const bool out = glm::dot(d, points[i].n) >= 0;
            ++(out ? outwards : inwards);
            if (out && again[i].triangle != EK_NO_HIT) ++self_hits;
            if (!out && again[i].triangle == EK_NO_HIT) ++leaks;
          }
          EXPECT_GT(std::min(outwards, inwards), again.size() / 4);
          EXPECT_EQ(self_hits, 0U) << kind.name << " size " << size << " far " << far << " stretch " << stretch
                                   << " of " << outwards;
          EXPECT_EQ(leaks, 0U) << kind.name << " size " << size << " far " << far << " stretch " << stretch << " of "
                               << inwards;
        }
      }
    }
  }
}

TEST(ShapeHits, textures_are_looked_up_as_on_a_globe) {
  Device& device = *test::devices().front();
  Scene scene;
  scene.materials.emplace_back();
  Shape shape;
  shape.kind = ShapeKind::sphere;
  shape.size[0] = 2;
  scene.shapes.push_back(shape);
  const Packed packed(scene);
  TraverseProbe probe(device, packed.scene, packed.features, packed.settings, {"bvh8", 8});
  const struct {
    glm::dvec3 from;
    double u, v;
  } cases[] = {{{0, 0, 5}, 0.5, 0.5},  {{5, 0, 0}, 0.75, 0.5},  {{-5, 0, 0}, 0.25, 0.5},
               {{0, 5, 1e-3}, 0.5, 0}, {{0, -5, 1e-3}, 0.5, 1}, {{3, 3, 3}, 0.625, 0.304087}};
  for (const auto& each : cases) {
    ProbeRay ray;
    for (std::size_t k = 0; k < 3; ++k) ray.o[k] = float(each.from[int(k)]), ray.d[k] = float(-each.from[int(k)]);
    const std::vector<ProbeHit> hits = probe.closest({ray});
    ASSERT_NE(hits[0].triangle, EK_NO_HIT);
    const Point at = points_of(device, packed, {ray}, hits, {glm::dvec3(0, 0, 1)}).front();
    EXPECT_NEAR(at.u, each.u, 1e-4);
    EXPECT_NEAR(at.v, each.v, 2e-4);
  }
}

// A little way along the tangent u grows and v stays; along the bitangent v falls, for pictures are
// read from the top. On shapes of all kinds, turned, stretched and mirrored.
TEST(ShapeHits, tangents_point_where_u_grows_and_bitangents_up_the_picture) {
  Device& device = *test::devices().front();
  for (const ShapeKindInfo& kind : shape_kinds())
    for (const double mirrored : {1.0, -1.0}) {
      test::Random random(11);
      Scene scene;
      scene.materials.emplace_back();
      Shape shape = shape_of(kind.kind, {0.3, -0.7, 2}, 1, 0.7, random);
      shape.world_from_object = shape.world_from_object * glm::scale(glm::dmat4(1), {1, 1, mirrored});
      scene.shapes.push_back(shape);
      const Packed packed(scene);
      TraverseProbe probe(device, packed.scene, packed.features, packed.settings, {"bvh8", 8});
      const Met met = rays_that_meet(probe, scene, 2000, 1, 12);
      const std::vector<glm::dvec3> unused(met.rays.size());
      const std::vector<Point> points = points_of(device, packed, met.rays, met.hits, unused);

      // Points next to each, found again from outside along its normal: before and behind it along
      // the tangent, then the bitangent.
      constexpr double kStep = 4e-3;
      std::vector<ProbeRay> near;
      for (const Point& at : points) {
        const glm::dvec3 bitangent = at.bitangent_sign * glm::cross(at.n, at.tangent);
        for (const glm::dvec3& along : {at.tangent, bitangent})
          for (const double sign : {-1.0, 1.0})
            near.push_back(probe_ray(at.p + sign * kStep * along + 0.02 * at.n, -at.n, 10));
      }
      const std::vector<ProbeHit> hits = probe.closest(near);
      std::vector<ProbeRay> met_near;
      std::vector<ProbeHit> hits_near;
      std::vector<std::size_t> whose;
      for (std::size_t i = 0; i < points.size(); ++i) {
        bool same = true;  // all four on the part where the point is
        for (std::size_t k = 0; k < 4; ++k)
          same = same && hits[4 * i + k].triangle != EK_NO_HIT && hits[4 * i + k].u == met.hits[i].u;
        if (!same) continue;
        whose.push_back(i);
        for (std::size_t k = 0; k < 4; ++k) met_near.push_back(near[4 * i + k]), hits_near.push_back(hits[4 * i + k]);
      }
      const std::vector<Point> beside =
          points_of(device, packed, met_near, hits_near, std::vector<glm::dvec3>(met_near.size()));
      std::size_t judged = 0;
      for (std::size_t i = 0; i < whose.size(); ++i) {
        const Point& at = points[whose[i]];
        ASSERT_NEAR(glm::length(at.tangent), 1, 1e-6) << kind.name;
        ASSERT_NEAR(glm::dot(at.tangent, at.n), 0, 1e-5) << kind.name;
        const Point* const four = &beside[4 * i];
        const double u = four[1].u - four[0].u, v = four[1].v - four[0].v;
        if (std::abs(u) > 0.05) continue;  // across the seam, or about a pole
        ASSERT_GT(u, 1e-4) << kind.name << " mirrored " << mirrored << " at " << at.u << ", " << at.v;
        // The square of the step over the radius of the curve; and the floats that u and v are.
        ASSERT_LE(std::abs(v), 0.05 * u + 4e-6)
            << kind.name << " mirrored " << mirrored << " at " << at.u << ", " << at.v;
        ASSERT_LT(four[3].v - four[2].v, -1e-4)
            << kind.name << " mirrored " << mirrored << " at " << at.u << ", " << at.v;
        ++judged;
      }
      EXPECT_GT(judged, points.size() / 2) << kind.name;
    }
}

}  // namespace
}  // namespace eikon
