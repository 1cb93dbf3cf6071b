// SPDX-License-Identifier: Apache-2.0
// Environments in other colours and other shapes than an equirectangular map of Rec. 709.
#include <ImfChannelList.h>
#include <ImfEnvmap.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "image/primaries.h"
#include "scene/environment/cube_map.h"
#include "scene/environment/environment.h"
#include "support/gltf_builder.h"

namespace {

using eikon::Chromaticities;
using eikon::CubeLayout;
using scene_test::contains;
using scene_test::message_of;
using scene_test::TemporaryFolder;

using Texels = std::vector<glm::vec3>;

void write_rgb_exr(const std::filesystem::path& path, int width, int height, Texels texels, Imf::Header header) {
  header.dataWindow() = header.displayWindow() = Imath::Box2i({0, 0}, {width - 1, height - 1});
  Imf::FrameBuffer buffer;
  for (int c = 0; c < 3; ++c) {
    const char* const name = std::array{"R", "G", "B"}[static_cast<std::size_t>(c)];
    header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    buffer.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(&texels[0][c]), sizeof(glm::vec3),
                                   sizeof(glm::vec3) * static_cast<std::size_t>(width)));
  }
  Imf::OutputFile file(path.c_str(), header);
  file.setFrameBuffer(buffer);
  file.writePixels(height);
}

void expect_near(const glm::dvec3& a, const glm::dvec3& b, double tolerance) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(a[c], b[c], tolerance) << c;
}

// Rec. 2020 has Rec. 709's white, so that the matrix is the one of ITU-R BT.2087-0, table 4,
// inverted.
TEST(Primaries, of_rec_2020_become_the_published_values_of_rec_709) {
  const Chromaticities rec2020{{0.708, 0.292}, {0.17, 0.797}, {0.131, 0.046}, {0.3127, 0.329}};
  const glm::dmat3 matrix = eikon::rec709_from(rec2020);
  expect_near(matrix[0], {1.6605, -0.1246, -0.0182}, 1e-4);
  expect_near(matrix[1], {-0.5876, 1.1329, -0.1006}, 1e-4);
  expect_near(matrix[2], {-0.0728, -0.0083, 1.1187}, 1e-4);
}

TEST(Primaries, grey_stays_grey_whatever_the_white) {
  const Chromaticities aces{{0.7347, 0.2653}, {0, 1}, {0.0001, -0.077}, {0.32168, 0.33767}};
  for (const Chromaticities& from : {aces, eikon::kXyz, eikon::kRec709})
    expect_near(eikon::rec709_from(from) * glm::dvec3(1), glm::dvec3(1), 1e-9);
  // ACES' own matrix by Bradford's adaptation [S-2014-004].
  const glm::dmat3 matrix = eikon::rec709_from(aces);
  expect_near(matrix[0], {2.5217, -0.2765, -0.0154}, 2e-3);
  expect_near(matrix[1], {-1.1341, 1.3727, -0.1530}, 2e-3);
  expect_near(matrix[2], {-0.3876, -0.0962, 1.1683}, 2e-3);
}

TEST(Primaries, of_no_colour_space_are_refused) {
  for (const Chromaticities& bad : {Chromaticities{{0.6, 0.3}, {0.6, 0.3}, {0.1, 0.1}, {0.3, 0.3}}, Chromaticities{},
                                    Chromaticities{{0.64, 0.33}, {0.3, 0.6}, {0.15, 0.06}, {0.9, 0.9}},
                                    Chromaticities{{NAN, 0.33}, {0.3, 0.6}, {0.15, 0.06}, {0.3, 0.3}}})
    EXPECT_TRUE(contains(message_of([&] { static_cast<void>(eikon::rec709_from(bad)); }), "primaries"));
}

TEST(EnvironmentKinds, stated_primaries_are_converted_and_said) {
  const TemporaryFolder folder;
  Imf::Header header;
  Imf::addChromaticities(header, {{0.708F, 0.292F}, {0.17F, 0.797F}, {0.131F, 0.046F}, {0.3127F, 0.329F}});
  write_rgb_exr(folder / "wide.exr", 2, 1, {{1, 1, 1}, {0.5F, 0.75F, 0.25F}}, header);
  std::vector<std::string> warnings;
  const auto map = eikon::load_environment(folder / "wide.exr", warnings);
  expect_near(map->radiance[0], glm::dvec3(1), 1e-5);
  expect_near(map->radiance[1], {0.3714, 0.7853, 0.1951}, 2e-4);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(contains(warnings[0], "wide.exr': converted to Rec. 709 from primaries (0.708, 0.292)"));
  // Rec. 709 itself is left alone.
  warnings.clear();
  Imf::Header usual;
  Imf::addChromaticities(usual, Imf::Chromaticities());
  write_rgb_exr(folder / "usual.exr", 2, 1, {{1, 0, 0}, {0, 1, 0}}, usual);
  EXPECT_EQ(eikon::load_environment(folder / "usual.exr", warnings)->radiance, (Texels{{1, 0, 0}, {0, 1, 0}}));
  EXPECT_TRUE(warnings.empty());
}

TEST(EnvironmentKinds, the_first_part_with_colours_is_the_map) {
  const TemporaryFolder folder;
  std::vector<Imf::Header> headers(3, Imf::Header(2, 1));
  const std::array<std::vector<const char*>, 3> channels{{{"Z"}, {"R", "G", "B"}, {"R", "G", "B"}}};
  for (std::size_t part = 0; part < 3; ++part) {
    headers[part].setName(fmt::format("part {}", part));
    headers[part].setType(Imf::SCANLINEIMAGE);
    for (const char* name : channels[part]) headers[part].channels().insert(name, Imf::Channel(Imf::FLOAT));
  }
  {
    Imf::MultiPartOutputFile file((folder / "parts.exr").c_str(), headers.data(), 3);
    for (std::size_t part = 0; part < 3; ++part) {
      std::vector<float> values(6, static_cast<float>(part));
      Imf::FrameBuffer buffer;
      for (std::size_t c = 0; c < channels[part].size(); ++c)
        buffer.insert(channels[part][c], Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(&values[2 * c]), sizeof(float),
                                                    2 * sizeof(float)));
      Imf::OutputPart output(file, static_cast<int>(part));
      output.setFrameBuffer(buffer);
      output.writePixels(1);
    }
  }
  std::vector<std::string> warnings;
  EXPECT_EQ(eikon::load_environment(folder / "parts.exr", warnings)->radiance, (Texels{glm::vec3(1), glm::vec3(1)}));
}

// A colour for each direction, so that a face in a wrong place or turned shows.
glm::vec3 colour_towards(const glm::dvec3& direction) { return glm::vec3(glm::normalize(direction) + 2.0); }

/// Direction of the middle of pixel (x, y) of a face, in an order and orientation written down here
/// once more: the three vectors of a face are its middle, its right and its bottom.
glm::dvec3 towards(const std::array<glm::dvec3, 3>& face, std::uint32_t x, std::uint32_t y, std::uint32_t side) {
  return face[0] + face[1] * (2 * (x + 0.5) / side - 1) + face[2] * (2 * (y + 0.5) / side - 1);
}

constexpr glm::dvec3 kX{1, 0, 0}, kY{0, 1, 0}, kZ{0, 0, 1};
using FaceAxes = std::array<glm::dvec3, 3>;
const FaceAxes kRight{kX, kZ, -kY}, kLeft{-kX, -kZ, -kY}, kUp{kY, kX, -kZ}, kDown{-kY, kX, kZ}, kAhead{-kZ, kX, -kY},
    kBehind{kZ, -kX, -kY};

struct Placed {
  FaceAxes face;
  std::uint32_t column, row;
};

Texels picture_of(const std::vector<Placed>& faces, std::uint32_t columns, std::uint32_t rows, std::uint32_t side) {
  Texels texels(std::size_t{columns} * rows * side * side, glm::vec3(0));
  for (const Placed& placed : faces)
    for (std::uint32_t y = 0; y < side; ++y)
      for (std::uint32_t x = 0; x < side; ++x)
        texels[std::size_t{placed.row * side + y} * columns * side + placed.column * side + x] =
            colour_towards(towards(placed.face, x, y, side));
  return texels;
}

void expect_all_directions(const Texels& map, std::uint32_t side) {
  const std::uint32_t width = 4 * side, height = 2 * side;
  ASSERT_EQ(map.size(), std::size_t{width} * height);
  for (std::uint32_t y = 0; y < height; ++y)
    for (std::uint32_t x = 0; x < width; ++x) {
      const double polar = std::numbers::pi * (y + 0.5) / height,
                   turn = 2 * std::numbers::pi * ((x + 0.5) / width - 0.5);
      const glm::dvec3 d(std::sin(turn) * std::sin(polar), std::cos(polar), -std::cos(turn) * std::sin(polar));
      ASSERT_LT(glm::distance(map[std::size_t{y} * width + x], colour_towards(d)), 0.05F) << x << ' ' << y;
    }
}

TEST(CubeMaps, crosses_and_strips_show_each_direction_where_it_is) {
  constexpr std::uint32_t kSide = 32;
  const FaceAxes behind_turned{kZ, kX, kY};
  const struct {
    CubeLayout layout;
    std::uint32_t columns, rows;
    std::vector<Placed> faces;
  } cases[] = {
      {CubeLayout::horizontal_cross,
       4,
       3,
       {{kUp, 1, 0}, {kLeft, 0, 1}, {kAhead, 1, 1}, {kRight, 2, 1}, {kBehind, 3, 1}, {kDown, 1, 2}}},
      {CubeLayout::vertical_cross,
       3,
       4,
       {{kUp, 1, 0}, {kLeft, 0, 1}, {kAhead, 1, 1}, {kRight, 2, 1}, {kDown, 1, 2}, {behind_turned, 1, 3}}},
      {CubeLayout::row,
       6,
       1,
       {{kRight, 0, 0}, {kLeft, 1, 0}, {kUp, 2, 0}, {kDown, 3, 0}, {kAhead, 4, 0}, {kBehind, 5, 0}}},
      {CubeLayout::column,
       1,
       6,
       {{kRight, 0, 0}, {kLeft, 0, 1}, {kUp, 0, 2}, {kDown, 0, 3}, {kAhead, 0, 4}, {kBehind, 0, 5}}},
  };
  for (const auto& c : cases) {
    const Texels texels = picture_of(c.faces, c.columns, c.rows, kSide);
    const auto layout = eikon::cube_layout(c.columns * kSide, c.rows * kSide, texels, false);
    ASSERT_EQ(layout, c.layout) << eikon::name_of(c.layout);
    expect_all_directions(eikon::equirectangular(*layout, c.columns * kSide, texels), kSide);
  }
}

// OpenEXR's own library says where a direction lies. Its +Z is where eikon has -Z, in both kinds of
// maps.
TEST(CubeMaps, of_openexr_are_as_its_library_has_them) {
  constexpr int kSide = 32;
  const Imath::Box2i window({0, 0}, {kSide - 1, 6 * kSide - 1});
  Texels texels(6 * kSide * kSide);
  for (int face = 0; face < 6; ++face)
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        const auto which = static_cast<Imf::CubeMapFace>(face);
        const Imath::V2f inside(static_cast<float>(x), static_cast<float>(y));
        const Imath::V3f d = Imf::CubeMap::direction(which, window, inside);
        const Imath::V2f at = Imf::CubeMap::pixelPosition(which, window, inside);
        const auto index =
            static_cast<std::size_t>(std::lround(at.y)) * kSide + static_cast<std::size_t>(std::lround(at.x));
        texels[index] = colour_towards({-d.x, d.y, -d.z});
      }
  const TemporaryFolder folder;
  Imf::Header header;
  Imf::addEnvmap(header, Imf::ENVMAP_CUBE);
  write_rgb_exr(folder / "cube.exr", kSide, 6 * kSide, texels, header);
  std::vector<std::string> warnings;
  const auto map = eikon::load_environment(folder / "cube.exr", warnings);
  EXPECT_EQ(map->width, 128U);
  EXPECT_EQ(map->height, 64U);
  expect_all_directions(map->radiance, kSide);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_TRUE(contains(warnings[0], "cube.exr': is a cube map (column in OpenEXR's order)"));
}

TEST(CubeMaps, a_picture_that_fills_its_corners_is_no_cross) {
  Texels texels(4 * 3 * 4, glm::vec3(1));
  EXPECT_EQ(eikon::cube_layout(8, 6, texels, false), CubeLayout::horizontal_cross);
  texels[0] = glm::vec3(2);
  EXPECT_FALSE(eikon::cube_layout(8, 6, texels, false));
  EXPECT_FALSE(eikon::cube_layout(8, 4, texels, false));
}

}  // namespace
