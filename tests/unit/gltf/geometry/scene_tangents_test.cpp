// SPDX-License-Identifier: Apache-2.0
// Tangents made from texture coordinates, against Mikkelsen's own code and a slow reference.
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <random>

#include "gltf/geometry/tangents.h"
#include "support/gltf_builder.h"

namespace {

using eikon::make_tangents;
using eikon::Primitive;

// Each triangle with corners of its own.
void add_corner(Primitive& primitive, const glm::vec3& position, const glm::vec3& normal, const glm::vec2& uv) {
  primitive.indices.push_back(static_cast<std::uint32_t>(primitive.positions_object.size()));
  primitive.positions_object.push_back(position);
  primitive.normals_object.push_back(normal);
  primitive.uv[0].push_back(uv);
}

const glm::vec4& tangent_at(const Primitive& primitive, std::size_t corner) {
  return primitive.tangents_object.at(primitive.indices[corner]);
}

double distance(const glm::vec4& a, const glm::vec4& b) { return static_cast<double>(glm::length(a - b)); }

// A wavy sheet of shared vertices: the texture is mirrored at x = 0 by running along |x|.
Primitive wavy_sheet(std::uint32_t side, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> jitter(-0.3F, 0.3F);
  Primitive primitive;
  for (std::uint32_t j = 0; j < side; ++j) {
    for (std::uint32_t i = 0; i < side; ++i) {
      const float x = static_cast<float>(i) - static_cast<float>(side / 2), y = static_cast<float>(j);
      primitive.positions_object.emplace_back(x + jitter(random), y + jitter(random), jitter(random));
      primitive.normals_object.push_back(glm::normalize(glm::vec3(jitter(random), jitter(random), 1.0F)));
      primitive.uv[0].emplace_back(std::abs(x) + 0.3F * jitter(random), y + 0.3F * jitter(random));
    }
  }
  for (std::uint32_t j = 0; j + 1 < side; ++j) {
    for (std::uint32_t i = 0; i + 1 < side; ++i) {
      const std::uint32_t a = j * side + i;
      for (const std::uint32_t k : {a, a + 1, a + side + 1, a, a + side + 1, a + side}) primitive.indices.push_back(k);
    }
  }
  return primitive;
}

// What the paper says, word by word, for meshes without degenerate triangles whose vertices differ:
// at each corner the mean over the triangles that shared edges lead to, of one orientation.
std::vector<glm::vec4> slow_reference(const Primitive& p) {
  const std::size_t triangle_count = p.indices.size() / 3;
  struct Frame {
    glm::dvec3 s;
    bool keeps;
  };
  std::vector<Frame> frames;
  for (std::size_t f = 0; f < triangle_count; ++f) {
    glm::dvec3 x[3];
    glm::dvec2 t[3];
    for (std::size_t k = 0; k < 3; ++k) {
      x[k] = glm::dvec3(p.positions_object[p.indices[3 * f + k]]);
      t[k] = glm::dvec2(p.uv[0][p.indices[3 * f + k]]) * glm::dvec2(1, -1);
    }
    // dx/ds from the two linear equations of the triangle's edges, by Cramer's rule.
    const glm::dmat2 edges(t[1] - t[0], t[2] - t[0]);
    const double area = glm::determinant(edges);
    frames.push_back({((x[1] - x[0]) * edges[1][1] - (x[2] - x[0]) * edges[0][1]) / area, area > 0});
  }
  std::vector<glm::vec4> result(p.indices.size());
  for (std::size_t c = 0; c < p.indices.size(); ++c) {
    const std::uint32_t vertex = p.indices[c];
    const auto corner_of = [&](std::size_t f) {
      for (std::size_t k = 0; k < 3; ++k) {
        if (p.indices[3 * f + k] == vertex) return static_cast<int>(k);
      }
      return -1;
    };
    const auto shares_an_edge = [&](std::size_t f, std::size_t g) {
      for (std::size_t k = 1; k < 3; ++k) {
        const std::uint32_t other = p.indices[3 * f + (static_cast<std::size_t>(corner_of(f)) + k) % 3];
        for (std::size_t m = 0; m < 3; ++m) {
          if (p.indices[3 * g + m] == other) return true;
        }
      }
      return false;
    };
    std::vector<bool> in(triangle_count, false);
    in[c / 3] = true;
    for (bool grew = true; grew;) {
      grew = false;
      for (std::size_t g = 0; g < triangle_count; ++g) {
        if (in[g] || corner_of(g) < 0 || frames[g].keeps != frames[c / 3].keeps) continue;
        for (std::size_t f = 0; f < triangle_count && !in[g]; ++f) in[g] = in[f] && shares_an_edge(f, g);
        grew = grew || in[g];
      }
    }
    const glm::dvec3 n(p.normals_object[vertex]);
    const auto flattened = [&](const glm::dvec3& v) { return glm::normalize(v - n * glm::dot(n, v)); };
    glm::dvec3 sum(0.0);
    for (std::size_t f = 0; f < triangle_count; ++f) {
      if (!in[f]) continue;
      const auto k = static_cast<std::size_t>(corner_of(f));
      const auto at = [&](std::size_t m) { return glm::dvec3(p.positions_object[p.indices[3 * f + (k + m) % 3]]); };
      sum += flattened(frames[f].s) * std::acos(glm::dot(flattened(at(1) - at(0)), flattened(at(2) - at(0))));
    }
    result[c] = glm::vec4(glm::vec3(glm::normalize(sum)), frames[c / 3].keeps ? 1.0F : -1.0F);
  }
  return result;
}

struct Row {
  glm::vec3 position, normal;
  glm::vec2 uv;
  glm::vec4 tangent;
};

// A mesh with a mirror line, a seam and a triangle whose texture coordinates coincide (the sixth),
// and what Mikkelsen's own code makes of it: Blender 4.2's calc_tangents, where v is 1 - v here.
const std::vector<Row>& blender_rows() {
  static const std::vector<Row> rows{
      {{-1, -1, 0.2109375F},
       {0.122892082F, 0.152053401F, 0.98070246F},
       {0.29296875F, 0.96875F},
       {-0.989962459F, -0.0507189669F, 0.13191618F, -1}},
      {{0, -1, -0.0390625F},
       {0.117559038F, -0.173412263F, 0.97780776F},
       {-0.01953125F, 1.04296875F},
       {-0.981971025F, -0.167071939F, 0.0884297118F, -1}},
      {{0.15625F, -0.296875F, -0.04296875F},
       {-0.158373356F, 0.155231088F, 0.975100636F},
       {-0.046875F, 0.79296875F},
       {-0.985323787F, -0.0885359049F, -0.14593932F, -1}},
      {{-1, -1, 0.2109375F},
       {0.122892082F, 0.152053401F, 0.98070246F},
       {0.29296875F, 0.96875F},
       {-0.989962459F, -0.0507189669F, 0.13191618F, -1}},
      {{0.15625F, -0.296875F, -0.04296875F},
       {-0.158373356F, 0.155231088F, 0.975100636F},
       {-0.046875F, 0.79296875F},
       {-0.985323787F, -0.0885359049F, -0.14593932F, -1}},
      {{-1, 0, -0.0546875F},
       {-0.0449517183F, 0.199270815F, 0.97891295F},
       {0.2109375F, 0.7265625F},
       {-0.998988271F, -0.00768900989F, -0.0443083793F, -1}},
      {{0, -1, -0.0390625F},
       {0.117559038F, -0.173412263F, 0.97780776F},
       {-0.01953125F, 1.04296875F},
       {0.985484421F, -0.101064444F, -0.136405557F, 1}},
      {{1, -1, -0.32421875F},
       {0.229540467F, -0.547123849F, 0.804963827F},
       {0.203125F, 0.9765625F},
       {0.884521306F, -0.227831244F, -0.407080859F, 1}},
      {{1, 0, 0.35546875F},
       {-0.356999844F, 0.183682904F, 0.915866673F},
       {0.25390625F, 0.71875F},
       {0.925259888F, -0.0650691763F, 0.373711377F, 1}},
      {{0, -1, -0.0390625F},
       {0.117559038F, -0.173412263F, 0.97780776F},
       {-0.01953125F, 1.04296875F},
       {0.985484421F, -0.101064444F, -0.136405557F, 1}},
      {{1, 0, 0.35546875F},
       {-0.356999844F, 0.183682904F, 0.915866673F},
       {0.25390625F, 0.71875F},
       {0.925259888F, -0.0650691763F, 0.373711377F, 1}},
      {{0.15625F, -0.296875F, -0.04296875F},
       {-0.158373356F, 0.155231088F, 0.975100636F},
       {-0.046875F, 0.79296875F},
       {0.987121463F, 0.00232008006F, 0.159956396F, 1}},
      {{-1, 0, -0.0546875F},
       {-0.0449517183F, 0.199270815F, 0.97891295F},
       {0.2109375F, 0.7265625F},
       {-0.998988271F, -0.00768900989F, -0.0443083793F, -1}},
      {{0.15625F, -0.296875F, -0.04296875F},
       {-0.158373356F, 0.155231088F, 0.975100636F},
       {-0.046875F, 0.79296875F},
       {-0.985323787F, -0.0885359049F, -0.14593932F, -1}},
      {{0, 1, -0.09375F},
       {0.0571762212F, 0.12437278F, 0.990586817F},
       {-0.05078125F, 0.51171875F},
       {-0.99832958F, -0.00112815958F, 0.0577647723F, -1}},
      {{-1, 0, -0.0546875F}, {-0.0449517183F, 0.199270815F, 0.97891295F}, {0.265625F, 0.55859375F}, {1, 0, 0, -1}},
      {{0, 1, -0.09375F}, {0.0571762212F, 0.12437278F, 0.990586817F}, {0.265625F, 0.55859375F}, {1, 0, 0, -1}},
      {{-1, 1, -0.37890625F}, {-0.261795104F, 0.29765743F, 0.918075919F}, {0.265625F, 0.55859375F}, {1, 0, 0, -1}},
      {{0.15625F, -0.296875F, -0.04296875F},
       {-0.158373356F, 0.155231088F, 0.975100636F},
       {-0.046875F, 0.79296875F},
       {0.987121463F, 0.00232008006F, 0.159956396F, 1}},
      {{1, 0, 0.35546875F},
       {-0.356999844F, 0.183682904F, 0.915866673F},
       {0.25390625F, 0.71875F},
       {0.925259888F, -0.0650691763F, 0.373711377F, 1}},
      {{1, 1, -0.375F},
       {-0.0538848117F, 0.280421644F, 0.958363235F},
       {0.3046875F, 0.4921875F},
       {0.994006038F, -0.0763647035F, 0.0782335177F, 1}},
      {{0.15625F, -0.296875F, -0.04296875F},
       {-0.158373356F, 0.155231088F, 0.975100636F},
       {-0.046875F, 0.79296875F},
       {0.987121463F, 0.00232008006F, 0.159956396F, 1}},
      {{1, 1, -0.375F},
       {-0.0538848117F, 0.280421644F, 0.958363235F},
       {0.3046875F, 0.4921875F},
       {0.994006038F, -0.0763647035F, 0.0782335177F, 1}},
      {{0, 1, -0.09375F},
       {0.0571762212F, 0.12437278F, 0.990586817F},
       {-0.05078125F, 0.51171875F},
       {0.996943831F, -0.0600161366F, -0.0500078537F, 1}},
  };
  return rows;
}

TEST(SceneTangents, agree_with_mikkelsens_own_code_over_mirror_lines_and_seams) {
  Primitive primitive;
  for (const Row& row : blender_rows()) add_corner(primitive, row.position, row.normal, row.uv);
  make_tangents(primitive, {});
  for (std::size_t c = 0; c < blender_rows().size(); ++c) {
    const glm::vec4& want = blender_rows()[c].tangent;
    if (c / 3 != 5) {
      EXPECT_LT(distance(tangent_at(primitive, c), want), 1e-5) << c;  // he computes in single precision
      continue;
    }
    // There his is the x axis; ours is that axis, in the plane of the normal.
    const glm::vec3 n = blender_rows()[c].normal, x(1, 0, 0);
    EXPECT_EQ(glm::vec3(want), x);
    EXPECT_LT(glm::length(glm::vec3(tangent_at(primitive, c)) - glm::normalize(x - n * n.x)), 1e-6F);
  }
}

TEST(SceneTangents, agree_with_a_slow_reference_and_are_unit_and_across_their_normals) {
  for (const std::uint32_t seed : {1U, 2U, 3U}) {
    Primitive primitive = wavy_sheet(7, seed);
    const std::vector<glm::vec4> want = slow_reference(primitive);
    make_tangents(primitive, {});
    ASSERT_EQ(primitive.tangents_object.size(), primitive.positions_object.size());
    int mirrored = 0;
    for (std::size_t c = 0; c < want.size(); ++c) {
      const glm::vec4& tangent = tangent_at(primitive, c);
      EXPECT_LT(distance(tangent, want[c]), 1e-6) << seed << ", corner " << c;
      EXPECT_NEAR(static_cast<double>(glm::length(glm::vec3(tangent))), 1.0, 1e-6);
      EXPECT_LT(std::abs(glm::dot(glm::vec3(tangent), primitive.normals_object[primitive.indices[c]])), 1e-6F);
      mirrored += tangent.w < 0 ? 1 : 0;
    }
    EXPECT_GT(mirrored, 50);
    EXPECT_LT(mirrored, 166);
  }
}

TEST(SceneTangents, do_not_depend_on_the_order_of_triangles_corners_and_vertices) {
  const Primitive sheet = wavy_sheet(9, 4);
  Primitive first = sheet;
  make_tangents(first, {});
  std::mt19937 random(5);
  std::vector<std::uint32_t> triangles(sheet.indices.size() / 3), vertices(sheet.positions_object.size());
  std::iota(triangles.begin(), triangles.end(), 0U);
  std::iota(vertices.begin(), vertices.end(), 0U);
  std::shuffle(triangles.begin(), triangles.end(), random);
  std::shuffle(vertices.begin(), vertices.end(), random);  // new place -> old
  Primitive second;
  std::vector<std::uint32_t> place(vertices.size());
  for (std::uint32_t i = 0; i < vertices.size(); ++i) {
    place[vertices[i]] = i;
    second.positions_object.push_back(sheet.positions_object[vertices[i]]);
    second.normals_object.push_back(sheet.normals_object[vertices[i]]);
    second.uv[0].push_back(sheet.uv[0][vertices[i]]);
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) second.indices.push_back(place[sheet.indices[3 * triangles[t] + (k + t) % 3]]);
  }
  make_tangents(second, {});
  EXPECT_EQ(first.positions_object.size(), second.positions_object.size());
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_LT(distance(tangent_at(second, 3 * t + k), tangent_at(first, 3 * triangles[t] + (k + t) % 3)), 1e-6);
    }
  }
}

TEST(SceneTangents, point_right_in_the_image_with_the_bitangent_up) {
  // A unit square seen from +z that shows its picture upright: v goes down in glTF.
  Primitive square;
  for (const glm::vec2& at :
       {glm::vec2(0, 0), glm::vec2(1, 0), glm::vec2(1, 1), glm::vec2(0, 0), glm::vec2(1, 1), glm::vec2(0, 1)}) {
    add_corner(square, glm::vec3(at, 0), glm::vec3(0, 0, 1), glm::vec2(at.x, 1 - at.y));
  }
  make_tangents(square, {});
  EXPECT_EQ(square.positions_object.size(), 6U);
  for (std::size_t c = 0; c < 6; ++c) EXPECT_LT(distance(tangent_at(square, c), glm::vec4(1, 0, 0, 1)), 1e-6);
}

TEST(SceneTangents, a_mirrored_texture_splits_the_vertices_on_the_line_with_all_that_they_have) {
  Primitive primitive;
  primitive.positions_object = {{-1, 0, 0}, {0, 0, 0}, {1, 0, 0}, {-1, 1, 0}, {0, 1, 0}, {1, 1, 0}};
  primitive.normals_object.assign(6, glm::vec3(0, 0, 1));
  for (const glm::vec3& p : primitive.positions_object) {
    primitive.uv[0].emplace_back(std::abs(p.x), p.y);
    primitive.uv[1].emplace_back(p.x, 7);
    primitive.colors.emplace_back(p.y, 0, 0, 1);
  }
  primitive.indices = {0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4};
  const Primitive before = primitive;
  make_tangents(primitive, {});
  ASSERT_EQ(primitive.positions_object.size(), 8U);  // the two on the line, twice
  for (const auto& size : {primitive.normals_object.size(), primitive.uv[0].size(), primitive.uv[1].size(),
                           primitive.colors.size(), primitive.tangents_object.size()}) {
    EXPECT_EQ(size, 8U);
  }
  for (std::size_t c = 0; c < primitive.indices.size(); ++c) {
    const std::uint32_t now = primitive.indices[c], then = before.indices[c];
    EXPECT_EQ(primitive.positions_object[now], before.positions_object[then]);
    EXPECT_EQ(primitive.uv[0][now], before.uv[0][then]);
    EXPECT_EQ(primitive.uv[1][now], before.uv[1][then]);
    EXPECT_EQ(primitive.colors[now], before.colors[then]);
    EXPECT_LT(distance(tangent_at(primitive, c), c < 6 ? glm::vec4(-1, 0, 0, 1) : glm::vec4(1, 0, 0, -1)), 1e-6) << c;
  }
}

TEST(SceneTangents, corners_weigh_by_their_angle) {
  // Two triangles around the origin over the edge to (1, 0), with 90 and 30 degrees there. The
  // texture of the second is sheared, so that its s direction is turned by -40 degrees.
  const double pi = std::acos(-1.0), turn = -40 * pi / 180;
  Primitive primitive;
  const glm::vec3 z(0, 0, 1), o(0, 0, 0), x(1, 0, 0), y(0, 1, 0);
  const glm::vec3 low(static_cast<float>(std::cos(-pi / 6)), static_cast<float>(std::sin(-pi / 6)), 0);
  // Both textures give the point x the coordinates s = t = 1, so dx/ds + dx/dt = x.
  const auto sheared = [&](const glm::vec3& p) {
    const glm::dvec2 s(std::cos(turn), std::sin(turn)), t = glm::dvec2(1, 0) - s;
    const glm::dvec2 st = glm::inverse(glm::dmat2(s, t)) * glm::dvec2(p);
    return glm::vec2(static_cast<float>(st.x), static_cast<float>(-st.y));
  };
  const auto plain = [&](const glm::vec3& p) { return glm::vec2(p.x, -(p.x + p.y)); };
  for (const glm::vec3& p : {o, x, y}) add_corner(primitive, p, z, plain(p));
  for (const glm::vec3& p : {o, low, x}) add_corner(primitive, p, z, p == x ? plain(p) : sheared(p));
  const std::vector<glm::vec4> own = [&] {
    Primitive alone;
    for (std::size_t c = 3; c < 6; ++c) add_corner(alone, primitive.positions_object[c], z, primitive.uv[0][c]);
    make_tangents(alone, {});
    return alone.tangents_object;
  }();
  EXPECT_LT(distance(own[0], glm::vec4(std::cos(turn), std::sin(turn), 0, 1)), 1e-5);
  make_tangents(primitive, {});
  // dx/ds of `plain`: (u, -v) = (x, x + y), so s moves by (1, -1).
  const glm::dvec2 sum = glm::normalize(glm::dvec2(1, -1)) * (pi / 2) + glm::dvec2(own[0].x, own[0].y) * (pi / 6);
  EXPECT_LT(distance(tangent_at(primitive, 0), glm::vec4(glm::vec2(glm::normalize(sum)), 0, 1)), 1e-6);
  EXPECT_EQ(tangent_at(primitive, 0), tangent_at(primitive, 3));
}

TEST(SceneTangents, degenerate_triangles_take_the_frame_of_their_neighbours) {
  Primitive primitive;
  const glm::vec3 z(0, 0, 1);
  primitive.positions_object = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};
  primitive.normals_object.assign(4, z);
  primitive.uv[0] = {{0, 1}, {0, 0}, {1, 1}, {0.5F, 0.5F}};  // s along y; vertex 3 lies on the edge 1-2 of the texture
  primitive.indices = {0, 1, 2, 2, 1, 3, 0, 0, 2};
  make_tangents(primitive, {});
  EXPECT_EQ(primitive.positions_object.size(), 4U);
  for (std::size_t c = 0; c < 9; ++c) {
    if (c == 5) continue;  // the corner that no good triangle shares
    EXPECT_LT(distance(tangent_at(primitive, c), glm::vec4(0, 1, 0, tangent_at(primitive, 0).w)), 1e-6) << c;
  }
}

TEST(SceneTangents, without_any_direction_in_the_texture_there_is_still_one_across_the_normal) {
  Primitive primitive;
  const std::array<glm::vec3, 3> normals{glm::vec3(1, 0, 0), glm::vec3(0, 1, 0),
                                         glm::normalize(glm::vec3(1, 1e-3F, -1e-3F))};
  for (std::size_t k = 0; k < 3; ++k) {
    add_corner(primitive, glm::vec3(0, k == 1, k == 2), normals[k], glm::vec2(0.5F, 0.5F));
  }
  make_tangents(primitive, {});
  for (std::size_t k = 0; k < 3; ++k) {
    const glm::vec3 tangent(tangent_at(primitive, k));
    EXPECT_NEAR(static_cast<double>(glm::length(tangent)), 1.0, 1e-6);
    EXPECT_LT(std::abs(glm::dot(tangent, normals[k])), 1e-6F);
    EXPECT_EQ(tangent_at(primitive, k).w, 1.0F);
  }
}

TEST(SceneTangents, without_normals_they_lie_in_their_triangles) {
  Primitive sheet = wavy_sheet(6, 8);
  sheet.normals_object.clear();
  const eikon::TriangleIndices before = sheet.indices;
  const std::vector<glm::vec3> positions = sheet.positions_object;
  make_tangents(sheet, {});
  EXPECT_TRUE(sheet.normals_object.empty());
  for (std::size_t c = 0; c < sheet.indices.size(); ++c) {
    const auto corner = [&](std::size_t k) { return sheet.positions_object[sheet.indices[c / 3 * 3 + k]]; };
    const glm::vec3 normal = glm::normalize(glm::cross(corner(1) - corner(0), corner(2) - corner(0)));
    EXPECT_LT(std::abs(glm::dot(normal, glm::vec3(tangent_at(sheet, c)))), 1e-6F);
    EXPECT_EQ(sheet.positions_object[sheet.indices[c]], positions[before[c]]);
    EXPECT_EQ(tangent_at(sheet, c), tangent_at(sheet, c / 3 * 3));  // one frame per triangle
  }
}

TEST(SceneTangents, a_vertex_with_countless_triangles_takes_neither_the_stack_nor_the_square_of_the_time) {
  constexpr std::uint32_t kCount = 100000;
  for (const bool connected : {true, false}) {
    Primitive fan;
    fan.positions_object.emplace_back(0, 0, 0);
    fan.uv[0].emplace_back(0, 0);
    for (std::uint32_t i = 0; i < 2 * kCount; ++i) {
      const double angle = 3e-5 * i;
      fan.positions_object.emplace_back(std::cos(angle), std::sin(angle), 0);
      fan.uv[0].emplace_back(std::cos(angle), std::sin(angle));
    }
    for (std::uint32_t i = 0; i < kCount; ++i) {
      const std::uint32_t first = connected ? i : 2 * i;
      for (const std::uint32_t k : {0U, 1 + first, 2 + first}) fan.indices.push_back(k);
    }
    fan.normals_object.assign(fan.positions_object.size(), glm::vec3(0, 0, 1));
    make_tangents(fan, {});
    EXPECT_LT(distance(tangent_at(fan, 0), glm::vec4(1, 0, 0, -1)), 0.05);
  }
  // An edge with countless triangles on the same side.
  Primitive book;
  book.positions_object = {{0, 0, 0}, {0, 1, 0}};
  book.uv[0] = {{0, 0}, {0, 1}};
  for (std::uint32_t i = 0; i < kCount; ++i) {
    book.positions_object.emplace_back(1, 0, i);
    book.uv[0].emplace_back(1, 0);
    for (const std::uint32_t k : {0U, 1U, 2 + i}) book.indices.push_back(k);
  }
  make_tangents(book, {});
  EXPECT_EQ(book.tangents_object.size(), book.positions_object.size());
}

}  // namespace
