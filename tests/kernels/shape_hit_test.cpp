// SPDX-License-Identifier: Apache-2.0
// Rays against shapes: the same hits in every structure to the bit, those of double precision within what floats can know, and
// no way out of a closed solid.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <random>

#include "formula/parse.h"
#include "kernels/traverse_probe.h"
#include "scene/endless.h"

namespace eikon {
namespace {

using Random = std::mt19937;

double uniform(Random& random, double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(random); }

glm::dvec3 direction(Random& random) {
  const double z = uniform(random, -1, 1), phi = uniform(random, 0, 6.283185307), s = std::sqrt(1 - z * z);
  return {s * std::cos(phi), s * std::sin(phi), z};
}

/// A shape of each kind at `center`, turned and stretched by as much as `stretch` says.
Shape shape_of(ShapeKind kind, const glm::dvec3& center, double size, double stretch, Random& random) {
  Shape shape;
  shape.kind = kind;
  std::size_t at = 0;
  for (const ShapeParameter& parameter : shape_kind(kind).parameters)
    for (std::size_t i = 0; i < parameter.count; ++i)
      shape.size[at++] = parameter.usual * size * uniform(random, 0.6, 1.4);
  const glm::dvec3 scale(std::exp2(uniform(random, -stretch, stretch)), std::exp2(uniform(random, -stretch, stretch)),
                         std::exp2(uniform(random, -stretch, stretch)));
  shape.world_from_object = glm::translate(glm::dmat4(1), center);
  if (stretch > 0)
    shape.world_from_object = shape.world_from_object *
                              glm::rotate(glm::dmat4(1), uniform(random, 0, 6), direction(random)) *
                              glm::scale(glm::dmat4(1), scale);
  return shape;
}

/// A cloud of shapes of all kinds, some of which overlap or coincide, and a few triangles among them.
Scene cloud(std::size_t count, double size, std::uint32_t seed, bool opacity = false) {
  Random random(seed);
  Scene scene;
  Material material;
  material.metallic = 0;
  material.specular = 0;
  scene.materials.push_back(material);
  if (opacity) {
    material.alpha_mode = AlphaMode::blend;
    material.opacity = 0.5F;
    scene.materials.push_back(material);
  }
  for (std::size_t i = 0; i < count; ++i) {
    const ShapeKindInfo& kind = shape_kinds()[i % shape_kinds().size()];
    const glm::dvec3 center = size * (i % 16 == 15 ? glm::dvec3(0.0) : direction(random) * uniform(random, 0, 4));
    Shape shape = shape_of(kind.kind, center, size, i % 3 == 0 ? 0 : 1.5, random);
    shape.material = opacity ? std::uint32_t(i % 2) : 0;
    scene.shapes.push_back(shape);
    if (i % 20 == 19) scene.shapes.push_back(shape);  // two in one place: the smaller id wins
  }
  Primitive few;
  for (std::size_t i = 0; i < count / 4; ++i)
    for (std::uint32_t k = 0; k < 3; ++k) {
      few.indices.push_back(std::uint32_t(few.positions_object.size()));
      few.positions_object.push_back(glm::vec3(size * direction(random) * uniform(random, 0, 4)));
    }
  if (!few.indices.empty()) {
    scene.meshes.push_back({"few", {std::move(few)}});
    scene.nodes.emplace_back();
  }
  return scene;
}

/// Rays from everywhere: random ones, along axes, at centres, at silhouettes, from inside and from far away.
std::vector<ProbeRay> rays_at(const Scene& scene, std::size_t count, double size, std::uint32_t seed) {
  Random random(seed);
  std::vector<ProbeRay> rays;
  for (std::size_t i = 0; i < count; ++i) {
    const Shape& shape = scene.shapes[std::size_t(uniform(random, 0, double(scene.shapes.size()) - 0.5))];
    const glm::dmat4& m = shape.world_from_object;
    const glm::dvec3 center(m[3]), side = direction(random);
    const double reach = (i % 7 == 6 ? 1e6 : i % 7 == 5 ? 0.1 : 6) * size;
    glm::dvec3 origin = center + reach * direction(random), target = center;
    switch (i % 5) {
      case 1:
        target = center + size * 0.5 * glm::normalize(glm::cross(center - origin, side));
        break;  // about the silhouette
      case 2:
        target = center + size * side;
        break;
      case 3:
        target = origin, target[int(i / 5 % 3)] += i / 15 % 2 == 0 ? 1 : -1;
        break;  // along an axis
      case 4:
        target = origin + side;
        break;
      default:
        break;
    }
    const glm::dvec3 d = glm::normalize(target - origin);
    rays.push_back(probe_ray(origin, d, uniform(random, 0, 2) * reach));
  }
  return rays;
}

struct Packed {
  Settings settings{};
  Features features;
  PackedScene scene;
  explicit Packed(const Scene& from) : features(from, settings), scene(pack_scene(from, features, settings)) {}
};

::testing::AssertionResult same_hits(const std::vector<ProbeHit>& a, const std::vector<ProbeHit>& b) {
  for (std::size_t i = 0; i < a.size(); ++i)
    if (std::memcmp(&a[i], &b[i], sizeof a[i]) != 0)
      return ::testing::AssertionFailure()
             << "ray " << i << ": t " << a[i].t << " id " << a[i].triangle << " part " << a[i].u << " against "
             << b[i].t << ", " << b[i].triangle << ", " << b[i].u;
  return ::testing::AssertionSuccess();
}

std::vector<TraverseProbe::Options> all_ways() { return TraverseProbe::variants(); }

/// Every accelerator and layout once, the wide ones in each way that rays go through them.
std::vector<TraverseProbe::Options> each_way() {
  std::vector<TraverseProbe::Options> all = all_ways();
  std::erase_if(all, [](const TraverseProbe::Options& o) {
    const bool wide = o.method == "bvh" && (o.layout == "bvh16" || o.layout == "bvh8");
    return wide ? o.portable || o.defines.contains("EK_NO_AVX512") ||
                      (o.width != 1 && o.width != (o.layout == "bvh16" ? 16 : 8))
                : o.width != 1;
  });
  return all;
}

void expect_same_hits_everywhere(const Scene& scene, const std::vector<ProbeRay>& rays,
                                 const std::vector<TraverseProbe::Options>& ways = all_ways()) {
  const Packed packed(scene);
  for (const DeviceInfo& info : select_devices("all")) {
    Device device(info);
    TraverseProbe::Options brute{"none", 1};
    brute.method = "none";
    TraverseProbe reference(device, packed.scene, packed.features, packed.settings, brute);
    const std::vector<ProbeHit> expected = reference.closest(rays);
    const std::vector<bool> blocked = reference.any(rays);
    std::size_t hits = 0;
    for (const ProbeHit& hit : expected)
      hits += hit.triangle != EK_NO_HIT && hit.triangle >= packed.scene.triangle_count();
    EXPECT_GT(hits, rays.size() / 10);
    for (const TraverseProbe::Options& options : ways) {
      TraverseProbe probe(device, packed.scene, packed.features, packed.settings, options);
      EXPECT_TRUE(same_hits(probe.closest(rays), expected)) << info.name << ": " << TraverseProbe::describe(options);
      EXPECT_EQ(probe.any(rays), blocked) << info.name << ": " << TraverseProbe::describe(options);
    }
  }
}

TEST(ShapeHits, every_structure_gives_the_hits_of_brute_force) {
  const Scene scene = cloud(300, 1, 1);
  expect_same_hits_everywhere(scene, rays_at(scene, 4000, 1, 2));
}

// Formulas beside all kinds of shapes and triangles, overlapping, turned, stretched, some in one place twice; one is given up on most rays.
TEST(ShapeHits, formulas_among_shapes_and_triangles_have_the_hits_of_brute_force_in_every_structure) {
  Scene scene = cloud(40, 1, 21);
  for (const char* text : {"x^2+y^2+z^2-1", "(x^2+y^2+z^2+0.3)^2-1.6*(x^2+y^2)",
                           "sin(5*x)*cos(5*y)+sin(5*y)*cos(5*z)+sin(5*z)*cos(5*x)", "x*y-x*y+1e-5"})
    scene.formulas.push_back(formula::parse_formula(text));
  Random random(22);
  for (std::uint32_t i = 0; i < 24; ++i) {
    Shape shape;
    shape.kind = ShapeKind::implicit;
    shape.size = {1.1, 1.1, 1.1};
    shape.formula = i == 23 ? 3 : i % 3;
    const auto stretch = [&] { return 0.5 * std::exp2(uniform(random, -1.5, 1.5)); };
    shape.world_from_object = glm::translate(glm::dmat4(1), direction(random) * uniform(random, 0, 4)) *
                              glm::rotate(glm::dmat4(1), uniform(random, 0, 6), direction(random)) *
                              glm::scale(glm::dmat4(1), glm::dvec3(stretch(), stretch(), stretch()));
    scene.shapes.push_back(shape);
    if (i % 8 == 7) scene.shapes.push_back(shape);
  }
  expect_same_hits_everywhere(scene, rays_at(scene, 1500, 1, 23), each_way());
}

TEST(ShapeHits, planes_without_end_have_the_hits_of_brute_force_in_every_structure) {
  Scene scene = cloud(100, 1, 31);
  Random random(32);
  for (const double other : {kEndlessSize, 2.0}) {
    for (int i = 0; i < 3; ++i) {  // level, twice in one place, and askew
      Shape plane;
      plane.kind = ShapeKind::plane;
      plane.size = {kEndlessSize, other, 0};
      plane.world_from_object = glm::translate(glm::dmat4(1), glm::dvec3(0.25, other > 2 ? -1.5 : 1.0, -0.5));
      if (i == 2)
        plane.world_from_object =
            plane.world_from_object * glm::rotate(glm::dmat4(1), uniform(random, 0, 6), direction(random));
      scene.shapes.push_back(plane);
    }
  }
  expect_same_hits_everywhere(scene, rays_at(scene, 1500, 1, 33), each_way());
  scene.meshes.clear();  // and nothing else
  scene.nodes.clear();
  scene.shapes.erase(scene.shapes.begin(), scene.shapes.end() - 6);
  expect_same_hits_everywhere(scene, rays_at(scene, 500, 1, 34), each_way());
}

TEST(ShapeHits, tiny_and_huge_scenes_too) {
  for (const double size : {1e-6, 1e8}) {
    const Scene scene = cloud(60, size, 3);
    expect_same_hits_everywhere(scene, rays_at(scene, 500, size, 4));
  }
}

TEST(ShapeHits, rays_pass_shapes_in_the_same_places_everywhere) {
  const Scene scene = cloud(150, 1, 5, true);
  expect_same_hits_everywhere(scene, rays_at(scene, 2000, 1, 6));
}

// ---- double precision -------------------------------------------------------------------------------------------------

/// The record's own matrix and a ray in double precision: how far inside the shape (negative) or outside a point is, as a share of
/// the shape's size. Exact for what the record says.
struct Oracle {
  glm::dmat3 l{1.0};
  glm::dvec3 center{0.0};
  ShapeRecord record;
  explicit Oracle(const ShapeRecord& r) : record(r) {
    l = glm::transpose(
        glm::dmat3(glm::dvec3(r.x_x, r.x_y, r.x_z), glm::dvec3(r.y_x, r.y_y, r.y_z), glm::dvec3(r.z_x, r.z_y, r.z_z)));
    center = {r.center_x, r.center_y, r.center_z};
  }
  [[nodiscard]] double height(const glm::dvec3& p) const {
    switch (static_cast<ShapeKind>(record.kind)) {
      case ShapeKind::sphere:
        return glm::length(p) - 1;
      case ShapeKind::box:
        return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) - 1;
      case ShapeKind::plane:     // has no inside
      case ShapeKind::implicit:  // has tests of its own
        return NAN;
      case ShapeKind::cylinder: {
        const double side = std::hypot(p.x, p.z) - (double(record.a) + double(record.b) * p.y);
        return std::max(side, std::abs(p.y) - 1);
      }
      case ShapeKind::capsule: {
        const double a = record.a, b = record.b, c = record.c, round = std::hypot(p.x, p.z);
        const double tilt = (c - b) / (2 * a);
        const double upper = std::hypot(round, p.y - a) - b, lower = std::hypot(round, p.y + a) - c;
        if (std::abs(tilt) >= 1) return std::min(upper, lower);
        const double flat = std::sqrt(1 - tilt * tilt),
                     along = p.y * flat - round * tilt;  // along the side from its middle
        const double low = -a * flat, high = a * flat;
        if (along > high) return upper;
        if (along < low) return lower;
        return round * flat + p.y * tilt - 0.5 * (b + c);
      }
    }
    return NAN;
  }
};

/// Least height of a ray with t > 0, and the first t where it is 0 or less (infinite: none), by convexity: golden section, then
/// bisection.
struct Crossing {
  double least = 0, t = INFINITY;
};
Crossing cross(const Oracle& oracle, const glm::dvec3& o, const glm::dvec3& d) {
  const auto height = [&](double t) { return oracle.height(o + t * d); };
  const auto bisect = [&](double a, double b) {  // height(a) and height(b) differ in sign
    const bool outside = height(a) > 0;
    for (int i = 0; i < 200; ++i) {
      const double middle = 0.5 * (a + b);
      ((height(middle) > 0) == outside ? a : b) = middle;
    }
    return 0.5 * (a + b);
  };
  double lo = 0, hi = 4 * (glm::length(o) + 4) / glm::length(d);
  const double end = hi;
  for (int i = 0; i < 300; ++i) {
    const double a = lo + (hi - lo) / 3, b = hi - (hi - lo) / 3;
    (height(a) < height(b) ? hi : lo) = height(a) < height(b) ? b : a;
  }
  const double nearest = 0.5 * (lo + hi);
  Crossing crossing{height(nearest)};
  if (height(0) <= 0)
    crossing.t = bisect(0, end);
  else if (crossing.least <= 0)
    crossing.t = bisect(0, nearest);
  return crossing;
}

TEST(ShapeHits, they_are_those_of_double_precision) {
  Device device(select_devices("all").front());
  for (const ShapeKindInfo& kind : shape_kinds()) {
    if (kind.kind == ShapeKind::plane) continue;  // has no inside
    for (const double size : {1e-6, 1.0, 1e8}) {
      for (const double stretch : {0.0, 1.5, 5.0}) {
        Random random(7);
        Scene scene;
        scene.materials.emplace_back();
        scene.shapes.push_back(shape_of(kind.kind, size * glm::dvec3(0.3, -0.7, 2), size, stretch, random));
        const Packed packed(scene);
        const Oracle oracle(packed.scene.shapes[0]);
        const std::vector<ProbeRay> rays = rays_at(scene, 3000, size, 8);
        TraverseProbe probe(device, packed.scene, packed.features, packed.settings, {"bvh8", 8});
        const std::vector<ProbeHit> hits = probe.closest(rays);
        std::size_t certain = 0;
        for (std::size_t i = 0; i < rays.size(); ++i) {
          const glm::dvec3 o(rays[i].o[0], rays[i].o[1], rays[i].o[2]), d(rays[i].d[0], rays[i].d[1], rays[i].d[2]);
          const glm::dvec3 from = o - oracle.center;
          const Crossing exact = cross(oracle, oracle.l * from, oracle.l * d);
          // What float products with the matrix can know of heights: some units of the largest sum they make.
          glm::dvec3 sums(0.0);
          for (int row = 0; row < 3; ++row)
            for (int column = 0; column < 3; ++column) sums[row] += std::abs(oracle.l[column][row] * from[column]);
          const double known = 0x1p-20 * (1 + glm::length(sums));
          const bool hit = hits[i].triangle != EK_NO_HIT;
          const double begins = oracle.height(oracle.l * from);
          if (std::abs(exact.least) > known && std::abs(begins) > known) {
            ASSERT_EQ(hit, std::isfinite(exact.t))
                << kind.name << " size " << size << " stretch " << stretch << " ray " << i << " least " << exact.least;
            ++certain;
          }
          if (!hit) continue;
          const double height = oracle.height(oracle.l * (from + double(hits[i].t) * d));
          ASSERT_LE(std::abs(height), known) << kind.name << " size " << size << " stretch " << stretch << " ray " << i;
          if (!std::isfinite(exact.t) || exact.least > -64 * known)
            continue;  // grazes: the place is as uncertain as the root of that
          const double slope = std::abs(oracle.height(oracle.l * (from + 1.0001 * exact.t * d)) -
                                        oracle.height(oracle.l * (from + 0.9999 * exact.t * d)));
          ASSERT_LE(std::abs(double(hits[i].t) - exact.t) * slope, 2e-4 * exact.t * 16 * known + 1e-3 * slope * exact.t)
              << kind.name << " size " << size << " stretch " << stretch << " ray " << i;
        }
        EXPECT_GT(certain, rays.size() / 2);
      }
    }
  }
}

// ---- rays that leave ----------------------------------------------------------------------------------------------------

// One ray per work-item: the point where it met its shape, the normal there, the bound of its error, texture coordinates, and the
// origin of a ray that leaves in the given direction.
const char* const kSource = R"(
#define EK_STACK_SIZE 1
#include "hit.h"
#include "shape_surface.h"
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
  Kernel kernel = device.build(expand_includes(kSource, "shape_hit_test.cl"), options).kernel("leave");
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
  Device device(select_devices("all").front());
  for (const ShapeKindInfo& kind : shape_kinds()) {
    if (kind.kind == ShapeKind::plane) continue;  // has no inside
    for (const double size : {1e-6, 0.015, 1.0, 1e8}) {
      for (const double far : {0.0, 30.0, 1e4}) {
        for (const double stretch : {0.0, 1.5, 4.0}) {
          Random random(9);
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
            dirs[i] = direction(random);
            // Half of them within a thousandth of the surface.
            if (i % 2 == 0)
              dirs[i] = glm::normalize(dirs[i] -
                                       points[i].n * (glm::dot(dirs[i], points[i].n) + uniform(random, -1e-3, 1e-3)));
          }
          points = points_of(device, packed, met.rays, met.hits, dirs);
          for (std::size_t i = 0; i < dirs.size(); ++i) {
            // The surface is on both sides of the point within its error along the normal, and the normal is unit.
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
  Device device(select_devices("all").front());
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

// A little way along the tangent u grows and v stays; along the bitangent v falls, for pictures are read from the top. On shapes of all
// kinds, turned, stretched and mirrored.
TEST(ShapeHits, tangents_point_where_u_grows_and_bitangents_up_the_picture) {
  Device device(select_devices("all").front());
  for (const ShapeKindInfo& kind : shape_kinds())
    for (const double mirrored : {1.0, -1.0}) {
      Random random(11);
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

      // Points next to each, found again from outside along its normal: before and behind it along the tangent, then the bitangent.
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
