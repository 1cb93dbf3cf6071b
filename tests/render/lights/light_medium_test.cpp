// SPDX-License-Identifier: Apache-2.0
// M16, lights in a medium: what they give inside a solid that absorbs, and what of it comes out.
#include "render/scene_builder.h"

namespace eikon::test {
namespace {

/// A solid of which a metre lets `per_metre` through.
Material amber(float per_metre, float ior = 1, float roughness = 0) {
  Material m;
  m.metallic = 0;
  m.roughness = roughness;
  m.ior = ior;
  m.transmission = 1;
  m.solid = true;
  m.attenuation_color = glm::vec3(per_metre);
  m.attenuation_distance = 1;
  return m;
}

Shape& add_ball(Scene& scene, const glm::dvec3& center, double radius, const Material& material) {
  scene.materials.push_back(material);
  Shape shape;
  shape.name = "ball";
  shape.kind = ShapeKind::sphere;
  shape.size[0] = radius;
  shape.world_from_object = glm::translate(glm::dmat4(1), center);
  shape.material = std::uint32_t(scene.materials.size() - 1);
  return scene.shapes.emplace_back(shape);
}

void add_floor(Scene& scene, float albedo) {
  Primitive floor;
  add_quad(floor, {-1, 0, 1}, {2, 0, 0}, {0, 0, -2});
  add_mesh(scene, "floor", std::move(floor), lambert(albedo));
}

/// Parallel rays straight down to the origin, from a height.
Settings from_above(double height, std::uint64_t spp) {
  Settings settings = settings_for(4, 4, spp);
  settings.camera = look_at_camera({0.0002, height, 0.0003}, {0.0002, 0, 0.0003}, {0, 0, -1}, 1);
  settings.camera.projection = Projection::orthographic;
  settings.camera.ymag_m = 1e-4;
  settings.max_depth = 8;
  return settings;
}

enum class Around { mesh, shape };

void add_amber(Scene& scene, Around around, double radius, const Material& material) {
  if (around == Around::shape)
    add_ball(scene, {0, 0, 0}, radius, material);
  else
    add_mesh(scene, "amber", sphere({0, 0, 0}, float(radius), 64, false), material);
}

// A floor and a lamp in one solid, seen from inside and from outside: E = I cos / d^2 less what the
// way from the lamp absorbs, and the picture less what the way to the eye absorbs.
TEST(LightMedium, M16_a_bulb_in_a_solid_lights_what_is_in_it_through_the_medium) {
  for (const Around around : {Around::mesh, Around::shape})
    for (const bool eye_inside : {true, false}) {
      Scene scene;
      add_amber(scene, around, 4, amber(0.5F));
      add_floor(scene, 0.5F);
      PunctualLight bulb;
      bulb.position = {1, 2, 0};
      bulb.intensity = glm::vec3(7);
      scene.lights.push_back(bulb);
      const double d = std::sqrt(5.0), seen_through = eye_inside ? 3 : 4;
      const double expected = 0.5 / kPi * 7 * (2 / d) / (d * d) * std::pow(0.5, d) * std::pow(0.5, seen_through);
      // Seen from outside through a facet, which is up to 4 (pi / 64)^2 / 2 nearer than the sphere.
      // The beam is .0003 wide.
      const double tolerance = 5e-4 + (eye_inside || around == Around::shape ? 0 : 5e-3);
      const Film film = film_of(scene, from_above(eye_inside ? 3 : 9, 64));
      EXPECT_NEAR(mean_of(film).mean, expected, tolerance * expected) << "inside " << eye_inside;
    }
}

// Nothing outside is lit by a lamp that is a point in smooth clear glass, nor anything inside by
// one outside: paths meet no points. That is how it is with points (info says so), and must not be
// a leak of light without the medium.
TEST(LightMedium, M16_a_bulb_lights_nothing_across_a_boundary) {
  for (const bool bulb_inside : {true, false}) {
    Scene scene;
    add_ball(scene, {0, 2, 0}, 1, amber(0.5F, 1.5F));
    // Nothing but glass stands on the bulb's side: what it lights there would be seen across the
    // boundary.
    Primitive inner;
    add_quad(inner, {-0.2F, 2, 0.2F}, {0.4F, 0, 0}, {0, 0, -0.4F});
    if (bulb_inside)
      add_floor(scene, 0.5F);
    else
      add_mesh(scene, "inner", std::move(inner), lambert(0.5F));
    PunctualLight bulb;
    bulb.position = bulb_inside ? glm::dvec3(0, 1.5, 0) : glm::dvec3(0, 6, 0);
    bulb.intensity = glm::vec3(7);
    scene.lights.push_back(bulb);
    // The eye is outside where the bulb is inside, beside the glass, and else inside, above the
    // quad there.
    Settings settings = from_above(2.4, 64);
    if (bulb_inside) settings.camera = look_at_camera({3, 1, 0}, {0.6, 0, 0}, {0, 1, 0}, 0.05);
    EXPECT_EQ(mean_of(film_of(scene, settings)).mean, 0) << bulb_inside;
  }
}

// A glowing ball in rough absorbing glass above a floor: light leaves by scattered rays and by the
// boundary's own sampling of the lamp, from inside and outside alike. Each way of sampling takes
// the media from another end of the path.
TEST(LightMedium, M16_each_way_of_sampling_a_lamp_in_rough_glass_agrees) {
  const auto picture = [](LightSampling way, bool eye_inside, float per_metre) {
    Scene scene;
    add_ball(scene, {0, 1.5, 0}, 1, amber(per_metre, 1.3F, 0.5F));
    add_ball(scene, {0.1, 1.6, 0}, 0.5, lambert(0.5F, 2));
    add_floor(scene, 0.5F);
    Settings settings = settings_for(8, 8, 3072);
    settings.camera = eye_inside ? look_at_camera({0.7, 1.5, 0.3}, {0, 0.9, 0.2}, {0, 1, 0}, 0.6)
                                 : look_at_camera({2, 1.5, 3}, {0, 0.9, 0}, {0, 1, 0}, 0.6);
    settings.light_sampling = way;
    settings.max_depth = 6;
    return mean_of(film_of(scene, settings));
  };
  for (const bool eye_inside : {false, true}) {
    const MeanAndError both = picture(LightSampling::mis, eye_inside, 0.3F);
    EXPECT_TRUE(agree(picture(LightSampling::light, eye_inside, 0.3F), both, 4)) << eye_inside;
    EXPECT_TRUE(agree(picture(LightSampling::bsdf, eye_inside, 0.3F), both, 4)) << eye_inside;
    EXPECT_GT(picture(LightSampling::mis, eye_inside, 1).mean, 1.1 * both.mean) << "the medium counts";
  }
}

}  // namespace
}  // namespace eikon::test
