// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "kernels/probe.h"
#include "kernels/statistics.h"
#include "shared/records.h"
#include "support/random.h"

namespace eikon::test {
namespace {

using Vec = glm::dvec3;

Vec unit(const Vec& a) { return glm::normalize(a); }
double angle(const Vec& a, const Vec& b) { return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)); }
double degrees(double radians) { return radians * 180 / std::numbers::pi; }

Vec rounded(const Vec& a) { return {double(float(a[0])), double(float(a[1])), double(float(a[2]))}; }

TriangleNormals corner_normals(const Vec& a, const Vec& b, const Vec& c) {
  TriangleNormals r{};
  r.n0_x = float(a[0]), r.n0_y = float(a[1]), r.n0_z = float(a[2]);
  r.n1_x = float(b[0]), r.n1_y = float(b[1]), r.n1_z = float(b[2]);
  r.n2_x = float(c[0]), r.n2_y = float(c[1]), r.n2_z = float(c[2]);
  return r;
}
TriangleTangents corner_tangents(const Vec& a, const Vec& b, const Vec& c, float sign) {
  TriangleTangents r{};
  r.t0_x = float(a[0]), r.t0_y = float(a[1]), r.t0_z = float(a[2]);
  r.t1_x = float(b[0]), r.t1_y = float(b[1]), r.t1_z = float(b[2]);
  r.t2_x = float(c[0]), r.t2_y = float(c[1]), r.t2_z = float(c[2]);
  r.bitangent_sign = sign;
  return r;
}

/// Triangles, and normal maps of one texel each.
struct Bumps {
  std::vector<TriangleNormals> normals;
  std::vector<TriangleTangents> tangents;
  std::vector<TextureRecord> textures;
  Words texels = Words(EK_TEXEL_TABLE);

  std::uint32_t map(int r, int g, int b, float scale = 1) {
    TextureRecord record{};
    record.first_texel = std::uint32_t(texels.size());
    record.width = record.height = 1;
    record.scale = scale;
    texels.push_back(std::uint32_t(r) | std::uint32_t(g) << 8 | std::uint32_t(b) << 16 | 0xff000000U);
    textures.push_back(record);
    return std::uint32_t(textures.size() - 1);
  }
  void triangle(const TriangleNormals& n, const TriangleTangents& t) {
    normals.push_back(n);
    tangents.push_back(t);
  }
};

struct Looks {
  std::vector<Words> in = std::vector<Words>(7);
  void add(std::uint32_t triangle, double u, double v, const Vec& n_geom, std::uint32_t map = EK_NO_TEXTURE) {
    in[0].push_back(triangle);
    in[1].push_back(as_word(float(u)));
    in[2].push_back(as_word(float(v)));
    append(in, 3, n_geom);
    in[6].push_back(map);
  }
  [[nodiscard]] std::size_t size() const { return in[0].size(); }
};

/// Outputs: 0 shading_normal, 3 mapped_normal.
std::vector<Words> look(const Bumps& bumps, const Looks& looks) {
  const std::vector<TextureRecord> none(1);
  return Probe("shading_normal")
      .buffer("triangles", std::vector<Triangle>(1))
      .buffer("triangle_normals", bumps.normals)
      .buffer("triangle_tangents", bumps.tangents)
      .buffer("triangle_colors", std::vector<TriangleColors>(bumps.normals.size()))
      .buffer("materials", std::vector<MaterialRecord>(1))
      .buffer("material_extensions", std::vector<MaterialExtension>(1))
      .buffer("material_details", std::vector<MaterialDetail>(1))
      .buffer("textures", bumps.textures.empty() ? none : bumps.textures)
      .buffer("texels", bumps.texels)
      .run("probe_shading_normal", looks.in, 6);
}

const Vec kUp = {0, 0, 1}, kZero = {0, 0, 0};

TEST(ShadingNormal, vertex_normals_are_interpolated) {
  std::mt19937 random(1);
  Bumps bumps;
  Looks looks;
  for (std::uint32_t t = 0; t < 500; ++t) {
    const Vec n = rounded(random_direction(random));
    const auto leaning = [&] { return rounded(unit(n + rounded(random_direction(random)) * 0.5)); };
    bumps.triangle(corner_normals(leaning(), leaning(), leaning()), {});
    const double u = uniform(random), v = (1 - u) * uniform(random);
    looks.add(t, u, v, n);
  }
  const auto out = look(bumps, looks);
  for (std::size_t i = 0; i < looks.size(); ++i) {
    const TriangleNormals& r = bumps.normals[i];
    const double u = as_float(looks.in[1][i]), v = as_float(looks.in[2][i]);
    const Vec sum =
        Vec{r.n0_x, r.n0_y, r.n0_z} * (1 - u - v) + Vec{r.n1_x, r.n1_y, r.n1_z} * u + Vec{r.n2_x, r.n2_y, r.n2_z} * v;
    ASSERT_LT(angle(vector_at(out, 0, i), sum), 5e-7) << i;
    ASSERT_NEAR(glm::length(vector_at(out, 0, i)), 1, 3e-7) << i;
    ASSERT_EQ(vector_at(out, 3, i), vector_at(out, 0, i)) << "no map, yet the normal changes";
  }
}

TEST(ShadingNormal, M20_what_says_nothing_leaves_the_triangles_own_normal) {
  const double nan = as_float(0x7fc00000U);
  Bumps bumps;
  bumps.triangle(corner_normals(kZero, kZero, kZero), {});
  bumps.triangle(corner_normals({1, 0, 0}, {-1, 0, 0}, {-1, 0, 0}), {});  // cancel at u + v = 1/2
  bumps.triangle(corner_normals({nan, nan, nan}, kUp, kUp), {});          // what a zero normal makes after normalising
  Looks looks;
  const Vec n = rounded(unit({0.1, -0.3, 0.9}));
  for (std::uint32_t t = 0; t < 3; ++t) looks.add(t, 0.25, 0.25, n);
  const auto out = look(bumps, looks);
  for (std::size_t i = 0; i < looks.size(); ++i) EXPECT_EQ(vector_at(out, 0, i), n) << i;
}

TEST(ShadingNormal, normals_that_dip_below_the_triangle_come_back_without_an_edge) {
  // Along the triangle the normal turns from 60 degrees on one side, through the surface, to the
  // other.
  Bumps bumps;
  bumps.triangle(corner_normals({0, 0, 1}, rounded({std::sin(2.4), 0, std::cos(2.4)}), {0, 0, 1}), {});
  Looks looks;
  constexpr int steps = 4096;
  for (int i = 0; i <= steps; ++i) looks.add(0, double(i) / steps, 0, kUp);
  const auto out = look(bumps, looks);
  bool dipped = false;
  for (std::size_t i = 0; i <= steps; ++i) {
    const Vec n = vector_at(out, 0, i);
    ASSERT_GE(n[2], 0) << i;
    ASSERT_NEAR(glm::length(n), 1, 3e-7);
    if (i == 0) continue;
    ASSERT_LT(angle(n, vector_at(out, 0, i - 1)), 4 * 2.4 / steps * 2) << "an edge at step " << i;
    dipped = dipped || n[2] > vector_at(out, 0, i - 1)[2];
  }
  EXPECT_TRUE(dipped) << "the case does not test what it says";
}

TEST(ShadingNormal, normal_maps_turn_along_tangent_and_bitangent_and_the_frame_is_orthonormal) {
  std::mt19937 random(2);
  Bumps bumps;
  Looks looks;
  // Texels that show the axes: x, y and z of the frame, as nearly as codes can.
  const std::uint32_t maps[] = {bumps.map(255, 128, 128), bumps.map(128, 255, 128), bumps.map(200, 90, 230, 0.7F)};
  const double codes[3][3] = {{255, 128, 128}, {128, 255, 128}, {200, 90, 230}};
  const double scales[3] = {1, 1, double(0.7F)};
  for (std::uint32_t t = 0; t < 500; ++t) {
    const Vec n = rounded(random_direction(random));
    Vec along = rounded(random_direction(random));
    while (std::abs(glm::dot(along, n)) > 0.9) along = rounded(random_direction(random));
    bumps.triangle(corner_normals(n, n, n), corner_tangents(along, along, along, t % 2 == 0 ? 1.0F : -1.0F));
    for (const std::uint32_t map : maps) looks.add(t, 0.3, 0.4, n, map);
  }
  const auto out = look(bumps, looks);
  for (std::size_t i = 0; i < looks.size(); ++i) {
    const std::size_t t = looks.in[0][i], m = i % 3;
    const Vec n = unit(vector_at(looks.in, 3, i));
    const TriangleTangents& r = bumps.tangents[t];
    const Vec along = {r.t0_x, r.t0_y, r.t0_z};
    const Vec tangent = unit(along - n * glm::dot(along, n)),
              bitangent = glm::cross(n, tangent) * double(r.bitangent_sign);
    const double x = (codes[m][0] / 127.5 - 1) * scales[m], y = (codes[m][1] / 127.5 - 1) * scales[m],
                 z = codes[m][2] / 127.5 - 1;
    const Vec found = vector_at(out, 3, i);
    ASSERT_LT(angle(found, tangent * x + bitangent * y + n * z), 1e-6) << i;
    ASSERT_NEAR(glm::length(found), 1, 5e-7) << i;
  }
}

TEST(ShadingNormal, M20_a_flat_map_tilts_by_less_than_0_4_degrees_and_maps_that_say_nothing_not_at_all) {
  Bumps bumps;
  const std::uint32_t flat = bumps.map(128, 128, 255), black = bumps.map(0, 0, 0), unscaled = bumps.map(255, 0, 200, 0),
                      steep = bumps.map(255, 0, 200);
  const Vec n = rounded(unit({0.3, 0.2, 0.9})), along = rounded(unit({0.9, 0.1, -0.2}));
  bumps.triangle(corner_normals(n, n, n), corner_tangents(along, along, along, 1));
  bumps.triangle(corner_normals(n, n, n), {});                           // no tangents
  bumps.triangle(corner_normals(n, n, n), corner_tangents(n, n, n, 1));  // along the normal
  bumps.triangle(corner_normals(n, n, n),
                 corner_tangents(along, along * -1.0, along * -1.0, 1));  // cancel at u + v = 1/2
  Looks looks;
  for (const std::uint32_t map : {flat, black, unscaled, steep}) looks.add(0, 0.25, 0.25, n, map);
  for (std::uint32_t t = 1; t < 4; ++t) looks.add(t, 0.25, 0.25, n, steep);
  const auto out = look(bumps, looks);
  EXPECT_LT(degrees(angle(vector_at(out, 3, 0), n)), 0.4);
  EXPECT_EQ(vector_at(out, 3, 1), vector_at(out, 0, 1)) << "texel (0, 0, 0)";
  EXPECT_LT(angle(vector_at(out, 3, 2), n), 5e-7) << "scale 0";
  EXPECT_GT(degrees(angle(vector_at(out, 3, 3), n)), 30) << "the steep map must tilt, or nothing here is tested";
  for (std::size_t i = 4; i < 7; ++i)
    EXPECT_EQ(vector_at(out, 3, i), vector_at(out, 0, i)) << "tangents of triangle " << i - 3;
}

TEST(ShadingNormal, mapped_normals_stay_on_the_front_without_an_edge) {
  Bumps bumps;
  // The vertex normals lean over and the map tilts further the same way, through the surface.
  const Vec n = rounded(unit({0.8, 0, 0.6}));
  bumps.triangle(corner_normals(n, n, n), corner_tangents({0, 1, 0}, {0, 1, 0}, {0, 1, 0}, 1));
  Looks looks;
  for (int g = 0; g < 256; ++g) looks.add(0, 0.2, 0.2, kUp, bumps.map(128, g, 160));
  const auto out = look(bumps, looks);
  for (std::size_t i = 0; i < looks.size(); ++i) {
    ASSERT_GE(vector_at(out, 3, i)[2], 0) << i;
    if (i > 0) {
      ASSERT_LT(angle(vector_at(out, 3, i), vector_at(out, 3, i - 1)), 0.04) << i;
    }
  }
}

// ---- usable_normal ------------------------------------------------------------------------------

struct Views {
  std::vector<Words> in = std::vector<Words>(10);
  void add(const Vec& n_shade, const Vec& n_geom, const Vec& wo, bool glossy) {
    append(in, 0, n_shade);
    append(in, 3, n_geom);
    append(in, 6, wo);
    in[9].push_back(glossy ? 1 : 0);
  }
  [[nodiscard]] std::size_t size() const { return in[0].size(); }
  [[nodiscard]] std::vector<Words> run() const { return Probe("shading_normal").run("probe_usable_normal", in, 3); }
};

/// A direction at cosine `c` with n, turned by phi around it.
Vec tilted(const Vec& n, double c, double phi) {
  const Vec side = unit(glm::cross(n, std::abs(n[0]) < 0.5 ? Vec{1, 0, 0} : Vec{0, 1, 0})), other = glm::cross(n, side);
  const double s = std::sqrt(std::max(0.0, 1 - c * c));
  return rounded(n * c + side * (s * std::cos(phi)) + other * (s * std::sin(phi)));
}

TEST(ShadingNormal, flat_shading_is_never_changed_by_a_bit) {
  std::mt19937 random(3);
  Views views;
  for (int i = 0; i < 20000; ++i) {
    const Vec n = rounded(random_direction(random));
    const double c = i % 2 == 0 ? uniform(random) : std::pow(10.0, -10 * uniform(random));
    views.add(n, n, tilted(n, c, 7 * uniform(random)), i % 4 < 2);
  }
  const auto out = views.run();
  for (std::size_t i = 0; i < views.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) ASSERT_EQ(out[k][i], views.in[k][i]) << i;
}

TEST(ShadingNormal, M19_the_viewer_and_for_reflectors_the_mirror_direction_are_on_the_front) {
  std::mt19937 random(4);
  Views views;
  for (int i = 0; i < 40000; ++i) {
    const Vec n = rounded(random_direction(random));
    const double c = i % 3 == 0 ? std::pow(10.0, -9 * uniform(random)) : uniform(random);
    const Vec wo = tilted(n, c, 7 * uniform(random));
    const Vec n_shade =
        i % 5 == 0 ? tilted(n, 1e-8, 7 * uniform(random)) : tilted(n, uniform(random), 7 * uniform(random));
    views.add(i % 7 == 0 ? rounded(wo * -1.0) : n_shade, n, wo, i % 2 == 0);
  }
  const auto out = views.run();
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Vec n = vector_at(out, 0, i), n_geom = vector_at(views.in, 3, i), wo = vector_at(views.in, 6, i);
    ASSERT_NEAR(glm::length(n), 1, 1e-6) << i;  // finite, too
    const double cos_geom = glm::dot(wo, n_geom);
    if (cos_geom < 1e-6) continue;  // along the surface nothing scatters
    ASSERT_GE(glm::dot(wo, n), -2e-7) << i;
    const Vec mirrored = n * (2 * glm::dot(wo, n)) - wo;
    if (views.in[9][i] != 0) {
      ASSERT_GT(glm::dot(mirrored, n_geom), -4e-7) << i;
    }
  }
}

TEST(ShadingNormal, usable_normals_are_continuous_in_the_shading_normal_and_the_view) {
  std::mt19937 random(5);
  Views views;
  constexpr int steps = 512, tracks = 64;
  for (int track = 0; track < tracks; ++track) {
    const Vec n = rounded(random_direction(random));
    const double phi = 7 * uniform(random), turn = 7 * uniform(random), c = 0.05 + 0.9 * uniform(random);
    for (int i = 0; i < steps; ++i) {
      const double x = (i + 0.5) / steps * std::numbers::pi / 2;
      // Even tracks turn the shading normal from n_geom to the horizon, odd ones the view.
      const Vec wo = tilted(n, track % 2 == 0 ? c : std::max(0.02, std::cos(x)), turn);
      views.add(tilted(n, track % 2 == 0 ? std::cos(x) : c, phi), n, wo, track % 4 < 2);
    }
  }
  const auto out = views.run();
  // One step turns by 0.18 degrees; bending near the horizon magnifies that some times.
  for (std::size_t i = 0; i < views.size(); ++i)
    if (i % steps != 0) {
      ASSERT_LT(degrees(angle(vector_at(out, 0, i), vector_at(out, 0, i - 1))), 4)
          << "track " << i / steps << " step " << i % steps;
    }
}

// ---- terminator ---------------------------------------------------------------------------------

TEST(ShadingNormal, G22_the_terminator_fades_from_one_to_nothing_at_the_surfaces_own_horizon) {
  std::vector<Words> in(3);
  std::vector<double> expected;
  std::mt19937 random(6);
  const auto add = [&](float cos_geom, float cos_shade, float cos_between) {
    for (const auto& [k, x] : {std::pair(0, cos_geom), std::pair(1, cos_shade), std::pair(2, cos_between)})
      in[std::size_t(k)].push_back(as_word(x));
    const double ratio = double(cos_geom) / (double(cos_shade) * double(cos_between));
    const double g = std::isnan(ratio) ? 1 : std::min(std::max(ratio, 0.0), 1.0);
    expected.push_back(-g * g * g + g * g + g);
  };
  for (int i = 0; i < 10000; ++i)
    add(float(uniform(random)), float(uniform(random)) + 1e-6F, float(uniform(random)) + 1e-6F);
  for (const float c : {1.0F, 0.5F, 1e-3F, 1e-8F, 1e-30F}) add(c, c, 1);  // one normal: 1
  const std::size_t equal = in[0].size();
  for (const float c : {0.0F, -0.1F, -1.0F}) add(c, 0.5F, 0.7F);
  add(0.5F, 0.5F, 0), add(0.5F, 1e-45F, 1e-30F);
  const auto out = Probe("shading_normal").run("probe_terminator", in, 1)[0];
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double found = as_float(out[i]);
    ASSERT_TRUE(found >= 0 && found <= 1.0000001) << i << ": " << found;
    ASSERT_NEAR(found, expected[i], 1e-6) << i;
  }
  for (std::size_t i = equal - 5; i < equal; ++i) EXPECT_EQ(as_float(out[i]), 1.0F);
}

}  // namespace
}  // namespace eikon::test
