// SPDX-License-Identifier: Apache-2.0
// Materials as a scene has them, packed by the renderer and evaluated by the kernels, against [glTF
// 2.0, section 3.9] and its extensions in doubles.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "kernels/probe.h"
#include "kernels/statistics.h"
#include "pack/pack.h"

namespace eikon::test {
namespace {

double linear_of(std::uint32_t code) {
  const double x = code / 255.0;
  return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
}

/// A scene of one triangle with colours and coordinates, all materials, and one-texel images.
struct Shelf {
  Scene scene;

  Shelf() {
    Primitive p;
    p.positions_object = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    p.normals_object.assign(3, {0, 0, 1});
    p.tangents_object.assign(3, {1, 0, 0, 1});
    p.uv[0] = {{0, 0}, {1, 0}, {0, 1}};
    p.uv[1] = p.uv[0];
    p.colors = {{1, 0.5F, 0.25F, 1}, {0.2F, 1, 0.5F, 0.5F}, {0, 0.3F, 1, 0}};
    p.indices = {0, 1, 2};
    scene.meshes.push_back({"triangle", {p}});
    Primitive plain = p;  // a mesh without colours beside it
    plain.colors.clear();
    scene.meshes[0].primitives.push_back(plain);
    scene.nodes.emplace_back();
  }

  Texture image(std::uint32_t word, bool srgb = false) {
    TextureImage image;
    image.width = image.height = 1;
    image.rgba8 = {word};
    scene.images.push_back(image);
    Texture texture;
    texture.image = std::uint32_t(scene.images.size() - 1);
    texture.srgb = srgb;
    return texture;
  }

  std::uint32_t add(const Material& material) {
    scene.materials.push_back(material);
    // Features come from the materials that some primitive shows.
    Primitive shown = scene.meshes[0].primitives[1];
    shown.material = std::uint32_t(scene.materials.size() - 1);
    scene.meshes[0].primitives.push_back(shown);
    return shown.material;
  }

  /// The packed scene behind `probe`, with attributes, textures and extensions.
  [[nodiscard]] Probe probe(const PackedScene& packed) const {
    Words texels;
    for (const auto part : packed.texels) texels.insert(texels.end(), part.begin(), part.end());
    const auto or_one = [](auto values) {
      if (values.empty()) values.resize(1);
      return values;
    };
    Probe probe("material");
    probe.buffer("triangles", packed.triangles)
        .buffer("triangle_normals", packed.normals)
        .buffer("triangle_tangents", or_one(packed.tangents))
        .buffer("triangle_colors", packed.colors)
        .buffer("materials", packed.materials)
        .buffer("material_extensions", packed.material_extensions)
        .buffer("material_details", std::vector<MaterialDetail>(packed.materials.size()))
        .buffer("textures", or_one(packed.textures))
        .buffer("texels", or_one(texels));
    if (packed.tangents.empty()) probe.define("EK_HAS_uv1", "0").define("EK_HAS_normal_texture", "0").define("EK_HAS_tangent", "0");
    return probe;
  }

  [[nodiscard]] PackedScene pack() const {
    const Settings settings;
    return pack_in_world(scene, Features(scene, settings), settings);
  }
};

struct Hits {
  std::vector<Words> in = std::vector<Words>(5);
  void add(std::uint32_t material, std::uint32_t triangle, double u, double v, bool front = true) {
    in[0].push_back(material);
    in[1].push_back(triangle);
    in[2].push_back(as_word(float(u)));
    in[3].push_back(as_word(float(v)));
    in[4].push_back(front ? 1 : 0);
  }
};

// Outputs of probe_material.
enum Output {
  kBaseColor = 0,
  kEmission = 3,
  kMetallic = 6,
  kAlpha = 7,
  kF0Dielectric = 8,
  kSpecular = 11,
  kF0 = 12,
  kF90 = 15,
  kTransmission = 16,
  kSolid = 17,
  kEta = 18,
  kLobes = 19,
  kDoubleSided = 20,
  kUnlit = 21,
  kOpacity = 22,
  kOutputs = 23
};

std::vector<Words> evaluate(const Shelf& shelf, const Hits& hits) {
  const PackedScene packed = shelf.pack();
  return shelf.probe(packed).run("probe_material", hits.in, kOutputs);
}

/// A material with extensions, so that their records exist, and otherwise neutral.
Material glass() {
  Material m;
  m.metallic = 0;
  m.transmission = 1;
  return m;
}

std::uint32_t pixel(std::mt19937& random) { return std::uint32_t(random()); }

TEST(Material, factors_textures_and_vertex_colours_multiply_as_glTF_says) {
  std::mt19937 random(1);
  Shelf shelf;
  struct Words7 {
    std::uint32_t base, rough, emissive, transmission, specular, specular_color;
  };
  std::vector<Words7> texels;
  for (int i = 0; i < 200; ++i) {
    Material m;
    m.base_color = {uniform(random), uniform(random), uniform(random)};
    m.metallic = float(uniform(random));
    m.roughness = float(uniform(random));
    m.ior = float(1 + uniform(random));
    m.specular = float(uniform(random));
    m.specular_color = {3 * uniform(random), uniform(random), uniform(random)};
    m.transmission = float(uniform(random));
    m.emission = {10 * uniform(random), uniform(random), uniform(random)};
    Words7 t{pixel(random), pixel(random), pixel(random), pixel(random), pixel(random), pixel(random)};
    // Some materials have none of a kind: the factor alone counts.
    if (i % 2 == 0)
      m.base_color_texture = shelf.image(t.base, true);
    else
      t.base = ~0U;
    if (i % 3 != 0)
      m.metallic_roughness_texture = shelf.image(t.rough);
    else
      t.rough = ~0U;
    if (i % 5 != 0)
      m.emissive_texture = shelf.image(t.emissive, true);
    else
      t.emissive = ~0U;
    if (i % 7 != 0)
      m.transmission_texture = shelf.image(t.transmission);
    else
      t.transmission = ~0U;
    if (i % 11 != 0)
      m.specular_texture = shelf.image(t.specular);
    else
      t.specular = ~0U;
    if (i % 13 != 0)
      m.specular_color_texture = shelf.image(t.specular_color, true);
    else
      t.specular_color = ~0U;
    shelf.add(m);
    texels.push_back(t);
  }
  Hits hits;
  for (std::uint32_t i = 0; i < 200; ++i) hits.add(i, i % 2, 0.25, 0.5);  // triangle 0 has colours, 1 has none
  const auto out = evaluate(shelf, hits);
  const auto code = [](std::uint32_t word, unsigned channel) { return (word >> (8 * channel)) & 255U; };
  const std::array<double, 3> colour{0.25 * 1 + 0.25 * double(0.2F), 0.25 * 0.5 + 0.25 * 1 + 0.5 * double(0.3F),
                                     0.25 * 0.25 + 0.25 * 0.5 + 0.5 * 1};
  for (std::uint32_t i = 0; i < 200; ++i) {
    const Material& m = shelf.scene.materials[i];
    const Words7& t = texels[i];
    const double metallic = double(m.metallic) * code(t.rough, 2) / 255;
    const double roughness = double(m.roughness) * code(t.rough, 1) / 255;
    const double specular = double(m.specular) * code(t.specular, 3) / 255;
    const double ratio = (double(m.ior) - 1) / (double(m.ior) + 1);
    ASSERT_NEAR(as_float(out[kMetallic][i]), metallic, 1e-6) << i;
    ASSERT_NEAR(as_float(out[kAlpha][i]), roughness * roughness, 1e-6) << i;
    ASSERT_NEAR(as_float(out[kSpecular][i]), specular, 1e-6) << i;
    ASSERT_NEAR(as_float(out[kF90][i]), specular + (1 - specular) * metallic, 1e-6) << i;
    ASSERT_NEAR(as_float(out[kTransmission][i]), double(m.transmission) * code(t.transmission, 0) / 255, 1e-6) << i;
    for (unsigned k = 0; k < 3; ++k) {
      const auto c = int(k);
      const double base = double(m.base_color[c]) * linear_of(code(t.base, k)) * (i % 2 == 0 ? colour[k] : 1.0);
      const double f0 =
          std::min(ratio * ratio * double(m.specular_color[c]) * linear_of(code(t.specular_color, k)), 1.0) * specular;
      ASSERT_NEAR(as_float(out[kBaseColor + k][i]), base, 1e-6) << i;
      ASSERT_NEAR(as_float(out[kEmission + k][i]), double(m.emission[c]) * linear_of(code(t.emissive, k)), 1e-5) << i;
      ASSERT_NEAR(as_float(out[kF0Dielectric + k][i]), f0, 1e-6) << i;
      ASSERT_NEAR(as_float(out[kF0 + k][i]), f0 + (base - f0) * metallic, 1e-6) << i;
    }
  }
}

TEST(Material, a_colour_that_is_the_same_at_all_corners_is_kept_exactly) {
  std::mt19937 random(2);
  Shelf shelf;
  for (glm::vec4& c : shelf.scene.meshes[0].primitives[0].colors) c = {0.3F, 1, 0.7F, 0.5F};
  Material m = glass();
  m.alpha_mode = AlphaMode::mask;
  m.alpha_cutoff = 0.5F;  // and the opacity is exactly that
  const std::uint32_t index = shelf.add(m);
  Hits hits;
  for (int i = 0; i < 5000; ++i) {
    const double u = uniform(random);
    hits.add(index, 0, u, (1 - u) * uniform(random));
  }
  const auto out = evaluate(shelf, hits);
  for (std::size_t i = 0; i < 5000; ++i) {
    ASSERT_EQ(as_float(out[kBaseColor][i]), 0.3F) << i;
    ASSERT_EQ(as_float(out[kBaseColor + 1][i]), 1.0F) << i;
    ASSERT_EQ(as_float(out[kOpacity][i]), 1.0F) << i;
  }
}

TEST(Material, M22_a_mask_keeps_what_is_at_the_cutoff_or_above_and_opaque_ignores_alpha) {
  Shelf shelf;
  struct Row {
    AlphaMode mode;
    float opacity, cutoff;
    std::uint32_t alpha;  // of the texture
    double expected;
  };
  const std::vector<Row> rows = {{AlphaMode::opaque, 0.25F, 0.5F, 128, 1},
                                 {AlphaMode::mask, 0.5F, 0.5F, 255, 1},
                                 {AlphaMode::mask, 0.49999997F, 0.5F, 255, 0},
                                 {AlphaMode::mask, 1, float(128 / 255.0), 128, 1},
                                 {AlphaMode::mask, 1, 0.5F, 127, 0},
                                 {AlphaMode::mask, 1, 0.5F, 128, 1},
                                 {AlphaMode::mask, 0, 0, 255, 1},
                                 {AlphaMode::mask, 1, 1.5F, 255, 0},
                                 {AlphaMode::blend, 0.5F, 0.9F, 51, 0.5 * 0.2},
                                 {AlphaMode::blend, 1, 0.5F, 0, 0},
                                 {AlphaMode::blend, 1, 0.5F, 255, 1}};
  Hits hits;
  for (const Row& row : rows) {
    Material m = glass();
    m.alpha_mode = row.mode;
    m.opacity = row.opacity;
    m.alpha_cutoff = row.cutoff;
    m.base_color_texture = shelf.image(row.alpha << 24 | 0x00ffffffU, true);
    hits.add(shelf.add(m), 1, 0.25, 0.25);
  }
  Material half = glass();
  half.alpha_mode = AlphaMode::blend;
  hits.add(shelf.add(half), 0, 0.5, 0.25);  // vertex colours have opacity too
  const auto out = evaluate(shelf, hits);
  for (std::size_t i = 0; i < rows.size(); ++i)
    EXPECT_NEAR(as_float(out[kOpacity][i]), rows[i].expected, 1e-7) << "row " << i;
  EXPECT_NEAR(as_float(out[kOpacity][rows.size()]), 0.25 * 1 + 0.5 * 0.5, 1e-7);
}

TEST(Material, M13_indices_of_refraction_and_what_side_was_hit) {
  Shelf shelf;
  Hits hits;
  const std::vector<float> iors = {0, 1, 1.000001F, 1.33F, 1.5F, 2.42F, 1e9F};
  for (const float ior : iors) {
    Material m = glass();
    m.ior = ior;
    m.solid = true;
    const std::uint32_t index = shelf.add(m);
    hits.add(index, 1, 0.2, 0.2, true);
    hits.add(index, 1, 0.2, 0.2, false);
  }
  const auto out = evaluate(shelf, hits);
  for (std::size_t i = 0; i < iors.size(); ++i) {
    const double ior = iors[i], f0 = std::pow((ior - 1) / (ior + 1), 2);
    for (const std::size_t side : {2 * i, 2 * i + 1}) {
      EXPECT_NEAR(as_float(out[kF0Dielectric][side]), f0, 1e-7 + 1e-6 * f0) << ior;
      EXPECT_EQ(out[kSolid][side], 1U);
    }
    EXPECT_EQ(as_float(out[kEta][2 * i]), iors[i]);
    EXPECT_EQ(as_float(out[kEta][2 * i + 1]), 1.0F / iors[i]);
  }
}

TEST(Material, what_a_material_is_arrives_as_flags) {
  Shelf shelf;
  Material diffuse;
  diffuse.metallic = diffuse.specular = 0;
  Material metal;
  Material unlit = metal;
  unlit.unlit = true;
  unlit.double_sided = true;
  Hits hits;
  for (const Material& m : {diffuse, metal, glass(), unlit}) hits.add(shelf.add(m), 1, 0.2, 0.2);
  const auto out = evaluate(shelf, hits);
  EXPECT_EQ(out[kLobes], (Words{1, 2, 4, 1}));
  EXPECT_EQ(out[kUnlit], (Words{0, 0, 0, 1}));
  EXPECT_EQ(out[kDoubleSided], (Words{0, 0, 0, 1}));
}

TEST(Material, coordinates_of_a_hit_find_the_texel_there) {
  Shelf shelf;
  Texture texture = shelf.image(0);
  shelf.scene.images[0].width = 2, shelf.scene.images[0].height = 2;
  shelf.scene.images[0].rgba8 = {0xff0000ffU, 0xff00ff00U, 0xffff0000U, 0xffffffffU};  // red, green / blue, white
  texture.filter = TextureFilter::nearest;
  Material m = glass();
  m.base_color_texture = texture;
  m.base_color_texture->uv_set = 1;
  const std::uint32_t index = shelf.add(m);
  m.base_color_texture->uv_set = 0;
  const std::uint32_t first = shelf.add(m);
  // TEXCOORD_1 is turned by a quarter against TEXCOORD_0: (u, v) -> (v, u).
  for (Primitive& p : shelf.scene.meshes[0].primitives) p.uv[1] = {{0, 0}, {0, 1}, {1, 0}};
  Hits hits;
  for (const std::uint32_t material : {first, index}) {
    hits.add(material, 1, 0.1, 0.1);
    hits.add(material, 1, 0.8, 0.1);
    hits.add(material, 1, 0.1, 0.8);
  }
  const auto out = evaluate(shelf, hits);
  const float expected[6][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 0}, {0, 0, 1}, {0, 1, 0}};
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(as_float(out[kBaseColor + k][i]), expected[i][k]) << i;
}

// ---- media --------------------------------------------------------------------------------------

struct Segments {
  std::vector<Words> in = std::vector<Words>(5);
  void add(std::uint32_t medium, double distance, bool front = true, bool transmitted = false,
           std::uint32_t material = 0) {
    in[0].push_back(medium);
    in[1].push_back(as_word(float(distance)));
    in[2].push_back(front ? 1 : 0);
    in[3].push_back(transmitted ? 1 : 0);
    in[4].push_back(material);
  }
};

Material tinted(glm::vec3 color, float distance) {
  Material m = glass();
  m.solid = true;
  m.attenuation_color = color;
  m.attenuation_distance = distance;
  return m;
}

TEST(Medium, M15_light_falls_off_by_Beers_law_and_never_by_NaN) {
  const double inf = std::numeric_limits<double>::infinity();
  Shelf shelf;
  const std::uint32_t half = shelf.add(tinted({0.5F, 0.25F, 1}, 1)), endless = shelf.add(tinted({0.5F, 0, 1}, 0)),
                      infinite = shelf.add(tinted({0.5F, 0, 1}, float(inf))),
                      black = shelf.add(tinted({0, 0.5F, 1}, 3)), thin = shelf.add(tinted({0.9F, 0.01F, 0.5F}, 1e-6F));
  struct Row {
    std::uint32_t material;
    double distance;
    std::array<double, 3> expected;
  };
  const std::vector<Row> rows = {{half, 2, {0.25, 0.0625, 1}},
                                 {half, 0, {1, 1, 1}},
                                 {half, inf, {0, 0, 1}},
                                 {endless, 1e30, {1, 1, 1}},
                                 {endless, inf, {1, 1, 1}},
                                 {infinite, 1e30, {1, 1, 1}},
                                 {infinite, inf, {1, 1, 1}},
                                 {black, 1e-20, {0, 1, 1}},
                                 {black, 1, {0, std::pow(0.5, 1 / 3.0), 1}},
                                 {black, 0, {1, 1, 1}},
                                 {black, inf, {0, 0, 1}},
                                 {thin, 1e-6, {0.9, 0.01, 0.5}},
                                 {thin, 5e-7, {std::sqrt(0.9), 0.1, std::sqrt(0.5)}}};
  Segments segments;
  for (const Row& row : rows) segments.add(row.material + 1, row.distance);
  segments.add(0, 5);  // in no medium
  const PackedScene packed = shelf.pack();
  const auto out = shelf.probe(packed).run("probe_medium", segments.in, 4);
  for (std::size_t i = 0; i < rows.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(as_float(out[k][i]), rows[i].expected[k], 1e-6 * rows[i].expected[k])
          << "row " << i << " channel " << k;
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(as_float(out[k][rows.size()]), 1.0F);
}

TEST(Medium, rays_enter_and_leave_solids_and_ignore_thin_walls) {
  Shelf shelf;
  const std::uint32_t solid = shelf.add(tinted({0.5F, 0.5F, 0.5F}, 1)), wall = shelf.add(glass());
  Segments segments;
  segments.add(0, 1, true, true, solid);            // in
  segments.add(solid + 1, 1, false, true, solid);   // out
  segments.add(0, 1, true, false, solid);           // reflected outside
  segments.add(solid + 1, 1, false, false, solid);  // reflected inside
  segments.add(solid + 1, 1, true, true, wall);     // through a window within
  const PackedScene packed = shelf.pack();
  const auto out = shelf.probe(packed).run("probe_medium", segments.in, 4);
  EXPECT_EQ(out[3], (Words{solid + 1, 0, 0, solid + 1, solid + 1}));
}

}  // namespace
}  // namespace eikon::test
