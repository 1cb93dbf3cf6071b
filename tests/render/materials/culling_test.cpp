// SPDX-License-Identifier: Apache-2.0
// --cull camera: camera rays pass the backs of single-sided surfaces as if these were not there,
// and no other ray does.
#include "formula/parse.h"
#include "pack/geometry/instanced_meshes.h"
#include "render/materials/glass_builder.h"
#include "render/ways_to_shade.h"

namespace eikon::test {
namespace {

Settings with(Culling culling, Settings settings) {
  settings.culling = culling;
  return settings;
}

/// The film with backs culled.
Film culled_film(const Scene& scene, const Settings& settings, const Execution& execution = {}) {
  return film_of(scene, with(Culling::camera, settings), execution);
}

/// A floor of albedo 0.8, and under a sky of 1 a black lid of 2 m x 2 m, 1 m above it, whose back
/// is on top. The camera above looks at the floor's middle, through the lid.
std::pair<Scene, Settings> floor_under_lid() {
  Scene scene;
  Primitive floor, lid;
  add_quad(floor, {-40, 0, 40}, {80, 0, 0}, {0, 0, -80});
  add_quad(lid, {-1, 1, -1}, {2, 0, 0}, {0, 0, 2});
  add_mesh(scene, "floor", std::move(floor), lambert(0.8F));
  add_mesh(scene, "lid", std::move(lid), lambert(0));
  Settings settings = settings_under_sky(8, 512);
  settings.camera = look_at_camera({0, 3, 0}, {0, 0, 0}, {0, 0, -1}, 0.01);
  return {std::move(scene), settings};
}

TEST(Culling, a_quad_from_behind_is_not_seen_but_casts_its_shadow) {
  auto [scene, settings] = floor_under_lid();
  // The share of the sky's light that a square of 2 m keeps from the point 1 m below its middle.
  const double kept_out = 4 / kPi * std::sqrt(0.5) * std::atan(std::sqrt(0.5));
  EXPECT_TRUE(agrees(mean_of(culled_film(scene, settings)), 0.8 * (1 - kept_out), 1));
  EXPECT_EQ(mean_of(film_of(scene, settings)).mean, 0) << "--cull none shows the lid";
  scene.materials[1].double_sided = true;
  EXPECT_EQ(mean_of(culled_film(scene, settings)).mean, 0) << "a double-sided lid is seen";
}

TEST(Culling, is_the_same_for_every_integrator_and_strategy) {
  const auto [scene, settings] = floor_under_lid();
  Scene open = scene;
  open.meshes[1].primitives[0].indices = {};
  std::vector<Settings> all(5, settings);
  all[1].max_depth = 2;
  all[2].integrator = Integrator::whitted;
  all[3].integrator = Integrator::raycast, all[3].max_depth = 2;
  all[4].light_sampling = LightSampling::hemisphere;
  for (const std::size_t i : {2U, 3U}) all[i].light_sampling = LightSampling::light;
  for (const Settings& each : all) {
    const double shaded = mean_of(culled_film(scene, each)).mean, lit = mean_of(culled_film(open, each)).mean;
    EXPECT_GT(shaded, 0.3 * lit) << name_of(each.integrator) << ", " << name_of(each.light_sampling);
    EXPECT_LT(shaded, 0.6 * lit) << name_of(each.integrator) << ", " << name_of(each.light_sampling);
  }
}

TEST(Culling, a_closed_room_shows_its_inside_and_keeps_out_the_sky) {
  const Scene scene = furnace(0.5F, 0.5F);
  Settings settings = settings_for(8, 8, 512);
  settings.environment.radiance = glm::vec3(100);
  settings.camera = look_at_camera({0, 0, 9}, {0, 0, 0}, {0, 1, 0}, 0.1);
  EXPECT_TRUE(agrees(mean_of(culled_film(scene, settings)), 1, 1));
  EXPECT_TRUE(agrees(mean_of(film_of(scene, settings)), 50, 1)) << "--cull none shows the wall from outside";
}

/// The room with a quad before the camera, whose back it sees, as the last node.
std::pair<Scene, Settings> room_behind_back(const Material& material) {
  auto [scene, settings] = room(24, 16, 16);
  Primitive quad;
  add_quad(quad, {2, -2, 2}, {-4, 0, 0}, {0, 4, 0});
  add_mesh(scene, "back", std::move(quad), material);
  settings.aovs = {"albedo", "normal",      "geometric_normal",  "depth", "position", "uv",
                   "id",     "material_id", "cryptomatte_object"};
  settings.transparent = true;
  settings.max_depth = 1;  // no shadows
  return {std::move(scene), settings};
}

TEST(Culling, layers_and_alpha_show_what_lies_behind_to_the_bit) {
  Material veil = lambert(0.5F, 2.0F);
  veil.alpha_mode = AlphaMode::blend;
  veil.opacity = 0.5F;
  Material bright = lambert(0.5F);
  bright.unlit = true;
  for (const Material& material : {lambert(0.5F, 2.0F), veil, bright}) {
    const auto [scene, settings] = room_behind_back(material);
    Scene open = scene;
    open.meshes.back().primitives[0].indices = {};  // its corners stay: with the same bounds hits have the same bits
    const Film film = culled_film(scene, settings);
    EXPECT_TRUE(same_film(film, culled_film(open, settings)));
    EXPECT_FALSE(same_film(film, film_of(scene, settings))) << "the comparison sees nothing";
  }
}

TEST(Culling, changes_no_bit_where_no_back_is_seen) {
  const auto [scene, settings] = room(24, 16, 16);
  EXPECT_TRUE(same_film(film_of(scene, settings), culled_film(scene, settings)));
}

/// What the camera sees of a quad that shows 1 and whose front is towards +Z before `place`, from
/// `side` times `towards`.
double seen(const glm::dmat4& place, glm::dvec3 towards, double side, InstanceMode mode, std::size_t count) {
  Scene scene;
  Primitive quad;
  add_quad(quad, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
  Material white = lambert(1);
  white.unlit = true;
  Node& node = add_mesh(scene, "quad", std::move(quad), white);
  node.world_from_object = place;
  node.mirrored = glm::determinant(glm::dmat3(place)) < 0;
  for (std::size_t i = 1; i < count; ++i) {
    Node next = scene.nodes.front();
    next.world_from_object[3] += glm::dvec4(0, double(100 * i), 0, 0);
    scene.nodes.push_back(next);
  }
  Settings settings = settings_for(4, 4, 4);
  settings.camera = look_at_camera(side * 5.0 * towards, {0, 0, 0}, {0, 1, 0}, 0.1);
  Execution execution;
  execution.instances = mode;
  InstanceChoice choice;
  (void)features_of(scene, with(Culling::camera, settings), execution, &choice);
  EXPECT_EQ(choice.two_level, mode == InstanceMode::two_level);
  return mean_of(culled_film(scene, settings, execution)).mean;
}

TEST(Culling, a_mirrored_node_keeps_its_front) {
  for (const InstanceMode mode : {InstanceMode::flat, InstanceMode::two_level})
    for (const auto& scale : {glm::dvec3(1, 1, 1), glm::dvec3(-1, 1, 1), glm::dvec3(1, -2, 1), glm::dvec3(1, 1, -1)}) {
      const glm::dmat4 place = glm::scale(glm::dmat4(1), scale);
      const glm::dvec3 towards(0.1 * scale.z, 0.2 * scale.z, scale.z);
      EXPECT_EQ(seen(place, towards, 1, mode, 9), 1) << scale.x << "," << scale.y << "," << scale.z;
      EXPECT_EQ(seen(place, towards, -1, mode, 9), 0) << scale.x << "," << scale.y << "," << scale.z;
    }
}

TEST(Culling, of_two_quads_back_to_back_each_side_shows_its_own) {
  Scene scene;
  Primitive front, back;
  add_quad(front, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
  back = front;
  std::vector<std::uint32_t> turned = back.indices.list();
  for (std::size_t i = 0; i < turned.size(); i += 3) std::swap(turned[i], turned[i + 1]);
  back.indices = turned;
  add_mesh(scene, "front", std::move(front), lambert(glm::vec3(0), {1, 0, 0}));
  add_mesh(scene, "back", std::move(back), lambert(glm::vec3(0), {0, 1, 0}));
  Settings settings = settings_for(8, 8, 4);
  for (const double side : {1.0, -1.0}) {
    settings.camera = look_at_camera({1, 2, side * 5}, {0, 0, 0}, {0, 1, 0}, 0.1);
    const Film film = culled_film(scene, settings);
    EXPECT_EQ(mean_of(film, 0).mean, side > 0 ? 1 : 0);
    EXPECT_EQ(mean_of(film, 1).mean, side > 0 ? 0 : 1);
  }
}

TEST(Culling, a_camera_inside_of_glass_sees_the_glass_around_it) {
  Scene scene;
  Primitive quad;
  add_quad(quad, {-1, -1, -5}, {2, 0, 0}, {0, 2, 0});
  add_mesh(scene, "quad", std::move(quad), lambert(0.5F, 1));
  add_mesh(scene, "ball", sphere({0, 0, 0}, 1, 12, false, true), glass(1.5F, 0, true));
  const Settings settings = settings_under_sky(16, 16);
  EXPECT_TRUE(same_film(film_of(scene, settings), culled_film(scene, settings)));
}

Shape& add_shape(Scene& scene, ShapeKind kind, const std::array<double, kShapeParameters>& size,
                 const Material& material) {
  scene.materials.push_back(material);
  Shape shape;
  shape.name = "shape";
  shape.kind = kind;
  shape.size = size;
  shape.material = std::uint32_t(scene.materials.size() - 1);
  return scene.shapes.emplace_back(shape);
}

Shape& add_formula(Scene& scene, const std::string& f, double half, const Material& material) {
  scene.formulas.push_back(formula::parse_formula(f));
  Shape& shape = add_shape(scene, ShapeKind::implicit, {half, half, half}, material);
  shape.formula = std::uint32_t(scene.formulas.size() - 1);
  return shape;
}

TEST(Culling, shapes_are_not_seen_from_inside_and_planes_not_from_below) {
  const auto see = [](ShapeKind kind, const glm::dvec3& eye, Culling culling) {
    Scene scene;
    if (kind == ShapeKind::implicit)
      add_formula(scene, "x^2+y^2+z^2-1", 2, lambert(0));
    else
      add_shape(scene, kind, {1, 1, 1}, lambert(0));
    Settings settings = settings_under_sky(8, 4);
    settings.camera = look_at_camera(eye, {0, 0.05, 0}, {0, 0, 1}, 0.2);
    settings.max_depth = 1;
    return mean_of(film_of(scene, with(culling, settings))).mean;
  };
  for (const ShapeKind kind : {ShapeKind::sphere, ShapeKind::box, ShapeKind::plane, ShapeKind::cylinder,
                               ShapeKind::capsule, ShapeKind::implicit}) {
    const glm::dvec3 inside(0, kind == ShapeKind::plane ? -3 : 0.1, 0), outside(0.1, 6, 0);
    EXPECT_EQ(see(kind, inside, Culling::camera), 1) << int(kind);
    EXPECT_EQ(see(kind, inside, Culling::none), 0) << int(kind);
    EXPECT_EQ(see(kind, outside, Culling::camera), see(kind, outside, Culling::none)) << int(kind);
    EXPECT_LT(see(kind, outside, Culling::camera), 0.5) << int(kind);
  }
}

TEST(Culling, behind_the_back_of_a_surface_by_formula_its_next_front_is_seen) {
  Scene scene;
  add_formula(scene, "min(x^2+y^2+z^2-1, (x-4)^2+y^2+z^2-1)", 6, lambert(0, 3));
  Settings settings = settings_for(8, 8, 4);
  settings.camera = look_at_camera({0.1, 0.1, 0.1}, {4, 0, 0}, {0, 1, 0}, 0.2);
  settings.max_depth = 1;
  EXPECT_EQ(mean_of(film_of(scene, settings)).mean, 0);
  EXPECT_EQ(mean_of(culled_film(scene, settings)).mean, 3);
}

/// The room from outside, through walls whose backs are seen, with shapes that the camera is in or
/// behind.
std::pair<Scene, Settings> room_from_outside() {
  auto [scene, settings] = room(40, 28, 8);
  settings.camera = look_at_camera({-2.5, 1.6, 2.2}, {0, 0, 0}, {0, 1, 0}, 0.8);
  settings.aovs = {"albedo", "normal", "depth", "id"};
  Shape& ball = add_shape(scene, ShapeKind::sphere, {0.4, 0, 0}, lambert({0.2F, 0.7F, 0.3F}));
  ball.world_from_object = glm::translate(glm::dmat4(1), {-2.4, 1.5, 2.1});
  add_shape(scene, ShapeKind::plane, {0.5, 1, 0.4}, lambert(0.4F)).world_from_object =
      glm::rotate(glm::translate(glm::dmat4(1), {-0.5, 0.2, 0.6}), 2.0, glm::dvec3(1, 0.2, 0));
  add_formula(scene, "x^2+y^2+z^2-1", 1.1, lambert({0.6F, 0.6F, 0.1F})).world_from_object =
      glm::scale(glm::translate(glm::dmat4(1), {0.3, 0.3, -0.2}), glm::dvec3(0.3));
  return {std::move(scene), settings};
}

TEST(Culling, has_the_same_bits_by_every_way_to_shade) {
  const auto [scene, settings] = room_from_outside();
  const Film expected = culled_film(scene, settings);
  EXPECT_FALSE(same_film(expected, film_of(scene, settings))) << "the comparison sees nothing";
  for (const Execution& way : ways_to_shade())
    EXPECT_TRUE(same_film(expected, culled_film(scene, settings, way))) << describe(way);
}

}  // namespace
}  // namespace eikon::test
