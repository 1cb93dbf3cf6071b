// SPDX-License-Identifier: Apache-2.0
// Emissive shapes: closed forms, and the same light by each way of finding it.
#include "pack/pack.h"
#include "render/ways_to_shade.h"
#include "scene/shape_area.h"

namespace eikon::test {
namespace {

constexpr LightSampling kWays[] = {LightSampling::mis, LightSampling::light, LightSampling::bsdf};

Shape shape_of(ShapeKind kind, std::array<double, 3> size, const glm::dmat4& place = glm::dmat4(1)) {
  Shape shape;
  shape.name = shape_kind(kind).name;
  shape.kind = kind;
  shape.size = size;
  shape.world_from_object = place;
  return shape;
}
Shape& add_shape(Scene& scene, Shape shape, const Material& material) {
  scene.materials.push_back(material);
  shape.material = std::uint32_t(scene.materials.size() - 1);
  return scene.shapes.emplace_back(std::move(shape));
}
glm::dmat4 at(const glm::dvec3& p) { return glm::translate(glm::dmat4(1), p); }
glm::dmat4 askew() {
  return glm::rotate(glm::dmat4(1), 0.7, glm::dvec3(0.3, 1, 0.2)) * glm::scale(glm::dmat4(1), {1.0, 0.4, 0.7}) *
         glm::rotate(glm::dmat4(1), 1.1, glm::dvec3(1, 0.4, 0.1));
}

/// One of each kind, black, so that scenes of one of them or another share a program for each way.
void add_black_shapes(Scene& scene, const glm::dvec3& place) {
  for (const ShapeKindInfo& kind : shape_kinds())
    add_shape(scene, shape_of(kind.kind, {0.3, 0.1, 0.1}, at(place)), lambert(0));
}

/// A white patch about the origin, its front turned by `tilt` from +Y towards +Z, and a camera that
/// sees nothing else: shows E / pi. Black shapes lie behind it.
std::pair<Scene, Settings> patch(double tilt, double side, std::uint64_t spp, LightSampling sampling) {
  std::pair<Scene, Settings> made;
  Primitive floor;
  const float h = float(0.5 * side);
  add_quad(floor, {-h, 0, h}, {2 * h, 0, 0}, {0, 0, -2 * h});
  Node& node = add_mesh(made.first, "patch", std::move(floor), lambert(1));
  node.world_from_object = glm::rotate(glm::dmat4(1), tilt, glm::dvec3(1, 0, 0));
  add_black_shapes(made.first, {0, -0.5, -3});
  Settings& settings = made.second;
  settings = settings_for(8, 8, spp);
  // From beside, where no light is in the way, and near: a picture of much less than the patch.
  const glm::dvec3 normal(0, std::cos(tilt), std::sin(tilt));
  settings.camera = look_at_camera(side * (0.3 * normal + glm::dvec3(0.3, 0, 0)), {0, 0, 0}, {1, 0.1, 0.2}, 0.01);
  settings.light_sampling = sampling;
  settings.max_depth = 2;
  return made;
}

/// comparisons: of the test
void expect_irradiance(const Shape& light, double radiance, double tilt, double expected, int comparisons,
                       std::uint64_t spp = 1024, double rounding = 2e-5, double side = 1e-3) {
  for (const LightSampling way : kWays) {
    if (way == LightSampling::bsdf && expected / (kPi * radiance) < 1e-3) continue;  // too small to be found by chance
    auto [scene, settings] = patch(tilt, side, spp, way);
    add_shape(scene, light, lambert(0, float(radiance)));
    EXPECT_TRUE(agrees(mean_of(film_of(scene, settings)), expected / kPi, comparisons, rounding))
        << "tilt " << tilt << ", way " << int(way) << ", expected E " << expected;
  }
}

TEST(LightShapes, L3_a_disk_and_a_square_light_a_floor_as_their_closed_forms_say) {
  // The lower disc of a cylinder, whose side cannot be seen from below; and a plane's square.
  const Shape drum = shape_of(ShapeKind::cylinder, {0.5, 1, 1}, at({0, 1.25, 0}));
  expect_irradiance(drum, 1, 0, 0.5 * kPi, 6);
  // Unit square at height 1 [its point to finite parallel rectangle form factor, Howell C-11].
  const Shape square =
      shape_of(ShapeKind::plane, {1, 1}, at({0, 1, 0}) * glm::rotate(glm::dmat4(1), kPi, glm::dvec3(1, 0, 0)));
  expect_irradiance(square, 1, 0, 0.752274688, 6);
}

TEST(LightShapes, L4_a_sphere_lights_a_tilted_patch_as_listed) {
  const Shape ball = shape_of(ShapeKind::sphere, {0.5}, at({0, 1, 0}));
  const std::pair<double, double> listed[] = {{0, 0.785398},   {60, 0.392699},  {85, 0.128101},
                                              {90, 0.0905861}, {95, 0.0596493}, {100, 0.0354490}};
  for (const auto& [degrees, expected] : listed)
    expect_irradiance(ball, 1, degrees * kPi / 180, expected, 18, 4096, 1e-4);
}

TEST(LightShapes, L4_a_sphere_under_a_stretched_node_is_the_ellipsoid_that_triangles_make) {
  for (const double tilt : {0.0, 1.0, 1.5}) {
    const glm::dmat4 place = at({0, 1, 0.1}) * askew() * glm::scale(glm::dmat4(1), glm::dvec3(0.8));
    auto [facets, settings] = patch(tilt, 1e-3, 16384, LightSampling::bsdf);
    add_mesh(facets, "ball", sphere({0, 0, 0}, 1, 96, false), lambert(0, 1)).world_from_object = place;
    const MeanAndError expected = mean_of(film_of(facets, settings));
    for (const LightSampling way : kWays) {
      auto [scene, with] = patch(tilt, 1e-3, 8192, way);
      with.seed = 7;
      add_shape(scene, shape_of(ShapeKind::sphere, {1}, place), lambert(0, 1));
      const MeanAndError found = mean_of(film_of(scene, with));
      // The facets' solid angle is short of the sphere's by some 3e-4.
      EXPECT_TRUE(agrees({found.mean, std::hypot(found.sigma, expected.sigma)}, expected.mean, 9, 2e-3))
          << tilt << ", way " << int(way);
    }
  }
}

// Where rays pass half of the near side, the inside of the far one is seen as well.
TEST(LightShapes, a_sphere_with_openings_lights_by_both_of_its_sides) {
  const double alpha = 0.5, opaque = kPi * 0.25;  // of a sphere of radius .5 at distance 1
  for (const bool both : {false, true})
    for (const LightSampling way : kWays) {
      auto [scene, settings] = patch(0, 1e-3, 4096, way);
      Material veil = lambert(0, 1);
      veil.alpha_mode = AlphaMode::blend;
      veil.opacity = float(alpha);
      veil.double_sided = both;
      add_shape(scene, shape_of(ShapeKind::sphere, {0.5}, at({0, 1, 0})), veil);
      const double expected = opaque * (alpha + (both ? (1 - alpha) * alpha : 0));
      EXPECT_TRUE(agrees(mean_of(film_of(scene, settings)), expected / kPi, 6, 1e-4)) << "way " << int(way);
    }
}

TEST(LightShapes, each_kind_with_openings_gives_the_same_light_by_each_way_of_finding_it) {
  const std::pair<ShapeKind, std::array<double, 3>> kinds[] = {
      {ShapeKind::box, {0.5, 0.4, 0.3}}, {ShapeKind::cylinder, {0.4, 0.2, 0.5}}, {ShapeKind::capsule, {0.3, 0.2, 0.4}}};
  for (const auto& [kind, size] : kinds) {
    std::array<MeanAndError, 3> found;
    for (std::size_t way = 0; way < found.size(); ++way) {
      auto [scene, settings] = patch(0.3, 1e-3, 4096, kWays[way]);
      settings.seed = std::uint32_t(way);
      Material veil = lambert(0, 1);
      veil.alpha_mode = AlphaMode::blend;
      veil.opacity = 0.4F;
      veil.double_sided = true;
      add_shape(scene, shape_of(kind, size, at({0.1, 1, 0.2}) * askew()), veil);
      found[way] = mean_of(film_of(scene, settings));
    }
    for (std::size_t way = 0; way < 2; ++way)
      EXPECT_TRUE(agrees({found[way].mean, std::hypot(found[way].sigma, found[2].sigma)}, found[2].mean, 6, 1e-4))
          << shape_kind(kind).name << ", way " << way;
  }
}

TEST(LightShapes, L5_a_tiny_sphere_is_a_point_light) {
  for (const double radius : {1e-2, 1e-4, 1e-6})
    for (const double tilt : {0.0, kPi / 3}) {
      const Shape ball = shape_of(ShapeKind::sphere, {radius}, at({0, 1, 0}));
      expect_irradiance(ball, 1 / (kPi * radius * radius), tilt, std::cos(tilt), 12, 64, 1e-4, 1e-4);
    }
}

TEST(LightShapes, L6_inside_and_on_an_emissive_surface_all_is_finite_and_right) {
  for (const ShapeKindInfo& kind : shape_kinds()) {
    if (kind.kind == ShapeKind::plane) continue;
    for (const glm::dmat4& place : {at({0.1, 0.05, -0.1}), at({0.1, 0.05, -0.1}) * askew()}) {
      Shape hollow = shape_of(kind.kind, {1.5, 1.3, 1.2}, place);
      if (kind.kind == ShapeKind::box) hollow.size = {2, 2.2, 2.4};
      Material wall = lambert(0.5F, 1);
      wall.double_sided = true;
      for (const LightSampling way : kWays) {
        // A patch inside, which sees nothing but the wall: pi L.
        auto [scene, settings] = patch(0.4, 1e-3, 1024, way);
        add_shape(scene, hollow, wall);
        EXPECT_TRUE(agrees(mean_of(film_of(scene, settings)), 1, 30, 2e-5))
            << kind.name << ", inside, way " << int(way);
        // The wall itself, lit by the wall: L + rho L.
        Scene empty;
        add_shape(empty, hollow, wall);
        add_black_shapes(empty, {0, -5, 0});  // outside
        Settings inside = settings_for(16, 16, 512);
        inside.camera = look_at_camera({0.02, 0.01, 0.03}, {1, 0.2, 0.3}, {0, 1, 0}, 2.0);
        inside.max_depth = 2;
        inside.light_sampling = way;
        EXPECT_TRUE(agrees(mean_of(film_of(empty, inside)), 1.5, 30, 2e-5))
            << kind.name << ", on the wall, way " << int(way);
      }
    }
  }
}

TEST(LightShapes, L7_irradiance_goes_on_where_the_way_of_sampling_changes) {
  // Towards the surface of a sphere: E = pi L R^2 / d^2 up to it, then pi L on its inside where
  // both sides emit.
  for (const double height : {-1e-2, -1e-5, 1e-7, 1e-6, 1e-5, 4e-5, 1e-4, 1e-3, 1e-1}) {
    const double side = 1e-3 * std::max(std::abs(height), 1e-6);
    for (const LightSampling way : {LightSampling::mis, LightSampling::bsdf}) {
      auto [scene, settings] = patch(0, side, 1024, way);
      Material both = lambert(0, 1);
      both.double_sided = true;
      add_shape(scene, shape_of(ShapeKind::sphere, {1}, at({0, 1 + height, 0})), both);
      const double expected = height < 0 ? 1 : 1 / ((1 + height) * (1 + height));
      EXPECT_TRUE(agrees(mean_of(film_of(scene, settings)), expected, 18, 1e-3)) << height << ", way " << int(way);
    }
  }
}

/// Irradiance at the origin, facing +Y, by a polygon that is all above it and emits 1 [Lambert
/// 1760]; and its solid angle.
std::pair<double, double> seen_of_triangle(const std::array<glm::dvec3, 3>& corners) {
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const glm::dvec3 a = corners[i], b = corners[(i + 1) % 3], across = glm::cross(a, b);
    const double length = glm::length(across);
    sum += std::atan2(length, glm::dot(a, b)) * across.y / length;
  }
  const glm::dvec3 a = glm::normalize(corners[0]), b = glm::normalize(corners[1]), c = glm::normalize(corners[2]);
  const double solid =
      2 * std::atan2(std::abs(glm::dot(a, glm::cross(b, c))), 1 + glm::dot(a, b) + glm::dot(b, c) + glm::dot(c, a));
  return {0.5 * std::abs(sum), solid};
}

// From a speck to the whole sky, about where others change between ways of sampling a triangle.
TEST(LightShapes, L7_a_triangle_of_any_solid_angle_lights_as_it_should) {
  const struct {
    double side, height, solid;
  } cases[] = {{4.8e-5, 1, 1e-9},    {0.02631, 1, 2.9997e-4}, {0.02635, 1, 3.006e-4}, {1, 0.5, 1.195},
               {1, 0.00352, 6.2197}, {1, 0.0035, 6.2201},     {1, 1e-5, 6.2831}};
  double last = 0;
  for (const auto& each : cases) {
    std::array<glm::dvec3, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) {
      const double phi = 2 * kPi * double(i) / 3 + 0.3;
      corners[i] =
          each.side / std::sqrt(3.0) * glm::dvec3(std::cos(phi), 0, std::sin(phi)) + glm::dvec3(0, each.height, 0);
    }
    const auto [expected, solid] = seen_of_triangle(corners);
    ASSERT_NEAR(solid, each.solid, 0.01 * each.solid) << "the case is what it says";
    for (const LightSampling way : {LightSampling::mis, LightSampling::light, LightSampling::bsdf}) {
      // By chance alone specks are not found; points chosen over all of a triangle that is next to
      // the eye are mostly far away.
      if (way == LightSampling::bsdf ? solid < 0.1 : way == LightSampling::light && solid > 1) continue;
      auto [scene, settings] = patch(0, 1e-4 * each.height, 4096, way);
      Primitive triangle;
      for (std::size_t i = 0; i < 3; ++i) {
        triangle.indices.push_back(std::uint32_t(i));
        triangle.positions_object.emplace_back(corners[i]);
      }
      add_mesh(scene, "triangle", std::move(triangle), lambert(0, 1));
      const MeanAndError found = mean_of(film_of(scene, settings));
      if (way == LightSampling::mis) {
        EXPECT_LT(found.sigma, 5e-4 * expected / kPi) << solid;
      }
      EXPECT_TRUE(agrees(found, expected / kPi, 16, 1e-4)) << solid << ", way " << int(way);
    }
    EXPECT_GT(expected, last);
    last = expected;
  }
}

TEST(LightShapes, L9_a_furnace_of_each_shape_is_constant) {
  for (const ShapeKindInfo& kind : shape_kinds()) {
    if (kind.kind == ShapeKind::plane) continue;
    Scene scene;
    Material wall = lambert(0.5F, 0.5F);
    wall.double_sided = true;
    add_shape(scene, shape_of(kind.kind, {1.6, 1.2, 1.0}, askew()), wall);
    Settings settings = settings_for(16, 16, 256);
    settings.camera = look_at_camera({0.02, 0.01, 0.03}, {1, 0.2, 0.3}, {0, 1, 0}, 2.0);
    EXPECT_TRUE(agrees(mean_of(film_of(scene, settings)), 1, 4)) << kind.name;
  }
}

TEST(LightShapes, each_shape_gives_the_same_light_by_each_way_of_finding_it) {
  const std::array<double, 3> sizes[] = {{0.3}, {0.5, 0.3, 0.4}, {0.6, 0.5}, {0.6, 0.1, 0.25}, {0.5, 0.1, 0.22}};
  std::size_t number = 0;
  for (const ShapeKindInfo& kind : shape_kinds()) {
    const std::array<double, 3> size = sizes[number++];
    for (const glm::dmat4& place : {at({0.1, 0.6, -0.1}), at({0.1, 0.6, -0.1}) * askew()}) {
      MeanAndError found[3];
      for (std::size_t way = 0; way < 3; ++way) {
        Scene scene;
        Primitive floor;
        add_quad(floor, {-1, 0, 1}, {2, 0, 0}, {0, 0, -2});
        add_mesh(scene, "floor", std::move(floor), lambert(0.8F));
        Material glow = lambert(0.3F, 5);
        glow.double_sided = kind.kind == ShapeKind::plane;
        add_shape(scene, shape_of(kind.kind, size, place), glow);
        add_shape(scene, shape_of(ShapeKind::sphere, {0.2}, at({-0.6, 0.25, 0.4})), lambert(0.5F, 0.7F));
        add_black_shapes(scene, {0, -3, 0});  // under the floor
        Settings settings = settings_for(24, 24, 512);
        settings.seed = std::uint32_t(way);
        settings.camera = look_at_camera({0.5, 1.2, 2.2}, {0, 0.2, 0}, {0, 1, 0}, 0.7);
        settings.light_sampling = kWays[way];
        found[way] = mean_of(film_of(scene, settings));
      }
      EXPECT_TRUE(agree(found[0], found[2], 20)) << kind.name << ": mis and cosine";
      EXPECT_TRUE(agree(found[1], found[2], 20)) << kind.name << ": light and cosine";
      EXPECT_LT(found[0].sigma, found[2].sigma) << kind.name << ": light sampling is there to help";
    }
  }
}

TEST(LightShapes, areas_are_those_of_geometry_under_any_transform) {
  const glm::dmat4 stretch = glm::scale(glm::dmat4(1), {2.0, 3.0, 0.5});
  const auto area = [](const Shape& shape) {
    const auto parts = part_areas_m2(shape.kind, own_shape(shape));
    return parts[0] + parts[1] + parts[2];
  };
  EXPECT_NEAR(area(shape_of(ShapeKind::sphere, {0.5})), kPi, 1e-12);
  // Semi-axes 1, 2, 3 [by the elliptic integrals of Legendre]; flattened: two discs.
  EXPECT_NEAR(area(shape_of(ShapeKind::sphere, {1}, glm::scale(glm::dmat4(1), {1.0, 2.0, 3.0}))), 48.8821463, 1e-5);
  EXPECT_NEAR(area(shape_of(ShapeKind::sphere, {1}, glm::scale(glm::dmat4(1), {1.0, 1e-6, 1.0}))), 2 * kPi, 1e-4);
  // Long ones of semi-axes 1, 1 and c: 2 pi (1 + c / e asin e) with e^2 = 1 - 1 / c^2, whichever
  // axis is the long one.
  for (const double c : {1.5, 50.0})
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 scales(1);
      scales[axis] = c;
      const double e = std::sqrt(1 - 1 / (c * c)), expected = 2 * kPi * (1 + c / e * std::asin(e));
      EXPECT_NEAR(area(shape_of(ShapeKind::sphere, {1}, glm::scale(glm::dmat4(1), scales))), expected, 1e-5 * expected);
    }
  EXPECT_NEAR(area(shape_of(ShapeKind::box, {1, 2, 3}, stretch)), 2 * (2 * 6 + 6 * 1.5 + 2 * 1.5), 1e-9);
  EXPECT_NEAR(area(shape_of(ShapeKind::plane, {1, 2}, stretch)), 2 * 1, 1e-12);
  EXPECT_NEAR(area(shape_of(ShapeKind::cylinder, {3, 1, 1})), 2 * kPi * 3 + 2 * kPi, 1e-9);
  EXPECT_NEAR(area(shape_of(ShapeKind::cylinder, {4, 0, 3})), kPi * 3 * 5 + kPi * 9, 1e-9);  // a cone
  // An elliptic cylinder of semi-axes 2 and 1/2: its perimeter is 8.57842178 [Ramanujan's second
  // formula, 8.578...].
  EXPECT_NEAR(area(shape_of(ShapeKind::cylinder, {1, 1, 1}, stretch)), 3 * 8.5784217 + 2 * kPi, 1e-5);
  EXPECT_NEAR(area(shape_of(ShapeKind::capsule, {3, 0.5, 0.5})), 2 * kPi * 0.5 * 3 + kPi, 1e-6);
  EXPECT_NEAR(area(shape_of(ShapeKind::capsule, {0, 0.5, 0.2})), kPi, 1e-6);  // the larger sphere alone
  // Spheres of 1 and 2 whose centres are 4 apart: sin = 1/4; the frustum between the circles where
  // the cone touches them.
  const double sine = 0.25, cosine = std::sqrt(1 - sine * sine);
  EXPECT_NEAR(area(shape_of(ShapeKind::capsule, {4, 1, 2})),
              kPi * 3 * cosine * 4 * cosine + 2 * kPi * (1 - sine) + 8 * kPi * (1 + sine), 1e-5);
}

TEST(LightShapes, a_scene_without_emissive_shapes_has_none_of_this_in_its_programs) {
  auto [scene, settings] = room(8, 8, 1);
  add_shape(scene, shape_of(ShapeKind::sphere, {0.2}), lambert(0.5F));
  EXPECT_FALSE(Features(scene, settings).has(Feature::shape_light));
  EXPECT_TRUE(Features(scene, settings).has(Feature::shape));
  add_shape(scene, shape_of(ShapeKind::sphere, {0.2}), lambert(0.5F, 1));
  EXPECT_TRUE(Features(scene, settings).has(Feature::shape_light));
}

TEST(LightShapes, every_way_to_shade_and_every_scale_give_the_same_film) {
  auto made = room(24, 16, 8);
  const std::array<double, 3> sizes[] = {{0.15}, {0.2, 0.3, 0.1}, {0.3, 0.2}, {0.3, 0.05, 0.1}, {0.2, 0.05, 0.1}};
  std::size_t number = 0;
  for (const ShapeKindInfo& kind : shape_kinds()) {
    add_shape(made.first, shape_of(kind.kind, sizes[number], at({-0.7 + 0.35 * double(number), 0.3, 0.3}) * askew()),
              lambert(0.2F, 2));
    ++number;
  }
  const std::vector<Execution> ways = ways_to_shade();
  const Film first = film_of(made.first, made.second, ways.front());
  for (std::size_t i = 1; i < ways.size(); ++i)
    EXPECT_TRUE(same_film(first, film_of(made.first, made.second, ways[i]))) << describe(ways[i]);
  for (const double factor : {0x1p-12, 0x1p17}) {
    const auto scaled = times(made, factor);
    EXPECT_TRUE(same_film(first, film_of(scaled.first, scaled.second, ways.front()))) << factor;
  }
}

}  // namespace
}  // namespace eikon::test
