// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "kernels/probe.h"
#include "shared/records.h"

namespace eikon::test {
namespace {

enum class Wrapping { repeat, clamp, mirror };

using Color = std::array<double, 4>;

double linear_of(int code) {  // IEC 61966-2-1
  const double x = code / 255.0;
  return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
}
int code_of(double linear) {
  const double x = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
  return int(std::lround(255 * x));
}

/// One image and how it is looked up, said twice: as records for the kernels, and as [OpenGL 4.6,
/// section 8.14] in doubles.
struct Case {
  std::string name;
  TextureRecord record{};
  Wrapping wrap_u = Wrapping::repeat, wrap_v = Wrapping::repeat;
  Words texels;

  [[nodiscard]] bool nearest() const { return (record.flags & EK_TEXTURE_NEAREST) != 0; }

  [[nodiscard]] Color texel(std::int64_t x, std::int64_t y) const {
    const std::uint32_t word = texels[std::size_t(y * record.width + x)];
    Color c{};
    for (int k = 0; k < 4; ++k) {
      const int code = int((word >> (8 * k)) & 255U);
      c[std::size_t(k)] = k < 3 && (record.flags & EK_TEXTURE_SRGB) != 0 ? linear_of(code) : code / 255.0;
    }
    return c;
  }

  static std::int64_t mod(std::int64_t a, std::int64_t n) { return ((a % n) + n) % n; }
  static std::int64_t wrapped(std::int64_t i, std::int64_t size, Wrapping wrap) {
    if (wrap == Wrapping::repeat) return mod(i, size);
    if (wrap == Wrapping::clamp) return std::min(std::max<std::int64_t>(i, 0), size - 1);
    const std::int64_t a = mod(i, 2 * size) - size;
    return size - 1 - (a >= 0 ? a : -(1 + a));
  }

  [[nodiscard]] Color at(double u, double v) const {
    const auto place = [this](double x, std::uint32_t size) {
      return std::min(std::max(x * size, -4e18), 4e18) - (nearest() ? 0.0 : 0.5);
    };
    const double x = place(u, record.width), y = place(v, record.height);
    const auto x0 = std::int64_t(std::floor(x)), y0 = std::int64_t(std::floor(y));
    const auto look = [&](std::int64_t i, std::int64_t j) {
      return texel(wrapped(i, record.width, wrap_u), wrapped(j, record.height, wrap_v));
    };
    if (nearest()) return look(x0, y0);
    Color c{};
    const double s = x - double(x0), t = y - double(y0);
    const Color a = look(x0, y0), b = look(x0 + 1, y0), d = look(x0, y0 + 1), e = look(x0 + 1, y0 + 1);
    for (std::size_t k = 0; k < 4; ++k) c[k] = (1 - t) * ((1 - s) * a[k] + s * b[k]) + t * ((1 - s) * d[k] + s * e[k]);
    return c;
  }
};

std::uint32_t wrap_flags(Wrapping u, Wrapping v) {
  return (u == Wrapping::clamp    ? EK_TEXTURE_CLAMP_U
          : u == Wrapping::mirror ? EK_TEXTURE_MIRROR_U
                                  : 0U) |
         (v == Wrapping::clamp    ? EK_TEXTURE_CLAMP_V
          : v == Wrapping::mirror ? EK_TEXTURE_MIRROR_V
                                  : 0U);
}

Case make_case(std::uint32_t width, std::uint32_t height, Wrapping u, Wrapping v, std::uint32_t flags,
               std::mt19937& random) {
  static const char* const names[] = {"repeat", "clamp", "mirror"};
  Case c;
  c.name = std::to_string(width) + "x" + std::to_string(height) + " " + names[int(u)] + " " + names[int(v)] +
           " flags " + std::to_string(flags);
  c.record.width = width;
  c.record.height = height;
  c.record.flags = flags | wrap_flags(u, v);
  c.record.u_u = c.record.v_v = 1;
  c.wrap_u = u;
  c.wrap_v = v;
  for (std::uint32_t i = 0; i < width * height; ++i) c.texels.push_back(std::uint32_t(random()));
  return c;
}

/// The cases' images in one array, after the table of sRGB codes, and their records.
struct Packed {
  std::vector<TextureRecord> records;
  Words texels;
  explicit Packed(const std::vector<Case>& cases) {
    for (int code = 0; code < int(EK_TEXEL_TABLE); ++code) texels.push_back(as_word(float(linear_of(code))));
    for (const Case& c : cases) {
      records.push_back(c.record);
      records.back().first_texel = std::uint32_t(texels.size());
      texels.insert(texels.end(), c.texels.begin(), c.texels.end());
    }
  }
  [[nodiscard]] std::vector<Words> run(const std::vector<Words>& in) const {
    return Probe("texture").buffer("textures", records).buffer("texels", texels).run("probe_texture", in, 4);
  }
};

struct Lookups {
  std::vector<Words> in = std::vector<Words>(5);
  void add(std::size_t texture, float u, float v, float u1 = 0, float v1 = 0) {
    in[0].push_back(std::uint32_t(texture));
    in[1].push_back(as_word(u));
    in[2].push_back(as_word(v));
    in[3].push_back(as_word(u1));
    in[4].push_back(as_word(v1));
  }
  [[nodiscard]] std::size_t size() const { return in[0].size(); }
};

// What single precision may shift a place by, in texels: the fraction of a negative coordinate, its
// product with the size, and half a texel taken off are rounded; the coordinate itself is given.
double place_error(std::uint32_t size) { return 3.0 * size * 0x1p-24; }

// Whether `found` is the reference's value within single precision's error of the place: bilinear
// values are off in proportion, nearest ones only where the place is at a border.
bool matches(const Case& c, double u, double v, const Color& found) {
  const double du = place_error(c.record.width) / c.record.width, dv = place_error(c.record.height) / c.record.height;
  const double slack = c.nearest() ? 1e-6 : 1e-6 + place_error(c.record.width) + place_error(c.record.height);
  const double steps[][2] = {{0, 0}, {-du, 0}, {du, 0}, {0, -dv}, {0, dv}, {-du, -dv}, {-du, dv}, {du, -dv}, {du, dv}};
  for (const auto& step : steps) {
    const Color expected = c.at(u + step[0], v + step[1]);
    bool same = true;
    for (std::size_t k = 0; k < 4; ++k) same = same && std::abs(found[k] - expected[k]) <= slack;
    if (same) return true;
    if (!c.nearest()) return false;
  }
  return false;
}

std::vector<Case> every_case(std::mt19937& random) {
  const std::array<std::uint32_t, 2> sizes[] = {{1, 1}, {1, 7}, {5, 1}, {2, 2}, {3, 5}, {16, 8}, {257, 31}, {1024, 3}};
  const Wrapping wraps[] = {Wrapping::repeat, Wrapping::clamp, Wrapping::mirror};
  std::vector<Case> cases;
  for (const auto& size : sizes)
    for (const Wrapping u : wraps)
      for (const Wrapping v : wraps)
        for (const std::uint32_t flags :
             {0U, EK_TEXTURE_NEAREST, EK_TEXTURE_SRGB, EK_TEXTURE_SRGB | EK_TEXTURE_NEAREST})
          cases.push_back(make_case(size[0], size[1], u, v, flags, random));
  return cases;
}

void expect_reference(const std::vector<Case>& cases, const Lookups& lookups) {
  const auto out = Packed(cases).run(lookups.in);
  std::size_t wrong = 0;
  for (std::size_t i = 0; i < lookups.size(); ++i) {
    const Case& c = cases[lookups.in[0][i]];
    const float u = as_float(lookups.in[1][i]), v = as_float(lookups.in[2][i]);
    const Color found{as_float(out[0][i]), as_float(out[1][i]), as_float(out[2][i]), as_float(out[3][i])};
    if (matches(c, double(u), double(v), found) || ++wrong > 3) continue;
    const Color expected = c.at(double(u), double(v));
    ADD_FAILURE() << c.name << " at " << u << ", " << v << ": " << found[0] << " " << found[1] << " " << found[2] << " "
                  << found[3] << ", not " << expected[0] << " " << expected[1] << " " << expected[2] << " "
                  << expected[3];
  }
  EXPECT_EQ(wrong, 0U) << "of " << lookups.size();
}

TEST(Texture, every_filter_and_wrap_is_as_OpenGL_defines_it_at_random_places) {
  std::mt19937 random(1);
  const std::vector<Case> cases = every_case(random);
  Lookups lookups;
  std::uniform_real_distribution<float> near(-3, 4), far(-5000, 5000);
  for (std::size_t t = 0; t < cases.size(); ++t) {
    for (int i = 0; i < 96; ++i) lookups.add(t, near(random), near(random));
    for (int i = 0; i < 32; ++i) lookups.add(t, far(random), far(random));
  }
  expect_reference(cases, lookups);
}

TEST(Texture, borders_and_middles_of_texels_and_whole_turns_are_as_OpenGL_defines_them) {
  std::mt19937 random(2);
  const std::vector<Case> cases = every_case(random);
  Lookups lookups;
  for (std::size_t t = 0; t < cases.size(); ++t) {
    const auto width = float(cases[t].record.width);
    for (const float turn : {-2.0F, -1.0F, 0.0F, 1.0F, 2.0F, 3.0F})
      for (const float k : {0.0F, 0.5F, 1.0F, 1.5F, width - 0.5F})
        for (const float nudge : {-1e-7F, 0.0F, 1e-7F}) lookups.add(t, turn + k / width + nudge, turn + nudge);
  }
  expect_reference(cases, lookups);
}

TEST(Texture, nearest_lookups_of_a_power_of_two_are_exact_on_borders) {
  std::mt19937 random(3);
  std::vector<Case> cases;
  for (const Wrapping wrap : {Wrapping::repeat, Wrapping::clamp, Wrapping::mirror})
    cases.push_back(make_case(8, 1, wrap, wrap, EK_TEXTURE_NEAREST, random));
  Lookups lookups;
  for (std::size_t t = 0; t < cases.size(); ++t)
    for (int k = -40; k <= 40; ++k) lookups.add(t, float(k) / 8, 0.5F);
  const auto out = Packed(cases).run(lookups.in);
  for (std::size_t i = 0; i < lookups.size(); ++i) {
    const Case& c = cases[lookups.in[0][i]];
    ASSERT_NEAR(as_float(out[0][i]), c.at(as_float(lookups.in[1][i]), 0.5)[0], 1e-7)
        << c.name << " at " << as_float(lookups.in[1][i]);
  }
}

TEST(Texture, M25_far_coordinates_keep_the_precision_that_they_have) {
  // A fraction of 1/16 is exact up to 2^20, and with a width of 4096 its texel is whole; the
  // product of the two is not.
  std::mt19937 random(4);
  std::vector<Case> cases;
  for (const Wrapping wrap : {Wrapping::repeat, Wrapping::mirror})
    for (const std::uint32_t flags : {0U, EK_TEXTURE_NEAREST})
      cases.push_back(make_case(4096, 1, wrap, wrap, flags, random));
  Lookups lookups;
  for (std::size_t t = 0; t < cases.size(); ++t)
    for (const double turns : {0.0, 1000.0, 65537.0, 524287.0, -65537.0, -524288.0})
      for (int k = 0; k < 16; ++k) lookups.add(t, float(turns + k / 16.0 + 1 / 32.0), 0);
  const auto out = Packed(cases).run(lookups.in);
  for (std::size_t i = 0; i < lookups.size(); ++i) {
    const Case& c = cases[lookups.in[0][i]];
    const double u = as_float(lookups.in[1][i]);
    for (std::size_t k = 0; k < 4; ++k)
      ASSERT_NEAR(as_float(out[k][i]), c.at(u, 0)[k], 1e-6) << c.name << " at " << u << ", channel " << k;
  }
}

TEST(Texture, M25_wild_coordinates_give_a_texel_of_the_image_and_nothing_else) {
  std::mt19937 random(5);
  std::vector<Case> cases = every_case(random);
  Lookups lookups;
  const float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> wild = {1e8F,        -1e8F,    3e38F,   -3e38F,   inf,    -inf,       nan,
                                   -0.0F,       0.0F,     1e-45F,  -1e-45F,  1e-30F, -1e-30F,    0x1p24F,
                                   16777215.0F, -0x1p24F, 0x1p31F, -0x1p31F, -1e-9F, 8388607.5F, -8388607.5F};
  for (std::size_t t = 0; t < cases.size(); ++t)
    for (const float u : wild)
      for (const float v : {0.3F, u}) lookups.add(t, u, v);
  const auto out = Packed(cases).run(lookups.in);
  for (std::size_t i = 0; i < lookups.size(); ++i) {
    const Case& c = cases[lookups.in[0][i]];
    const double u = as_float(lookups.in[1][i]), v = as_float(lookups.in[2][i]);
    Color found{};
    for (std::size_t k = 0; k < 4; ++k) {
      found[k] = as_float(out[k][i]);
      ASSERT_TRUE(found[k] >= 0 && found[k] <= 1) << c.name << " at " << u << ", " << v;
    }
    if (!std::isfinite(u) || std::abs(u) > 1e18) continue;  // at either end or in the middle, but finite
    ASSERT_TRUE(matches(c, u, v, found)) << c.name << " at " << u << ", " << v;
  }
}

TEST(Texture, coordinates_beyond_the_ends_of_a_clamped_image_show_its_ends) {
  std::mt19937 random(6);
  const std::vector<Case> cases = {make_case(4, 1, Wrapping::clamp, Wrapping::clamp, 0, random)};
  const float inf = std::numeric_limits<float>::infinity();
  Lookups lookups;
  for (const float u : {1e8F, 3e38F, inf, 2.0F, -1e8F, -3e38F, -inf, -2.0F}) lookups.add(0, u, 0.5F);
  const auto out = Packed(cases).run(lookups.in);
  for (std::size_t i = 0; i < lookups.size(); ++i)
    EXPECT_EQ(as_float(out[0][i]), float(cases[0].texel(i < 4 ? 3 : 0, 0)[0])) << i;
}

TEST(Texture, M25_all_sRGB_codes_decode_exactly_and_return) {
  std::mt19937 random(7);
  Case c = make_case(256, 1, Wrapping::repeat, Wrapping::repeat, EK_TEXTURE_SRGB, random);
  Case plain = make_case(256, 1, Wrapping::repeat, Wrapping::repeat, 0, random);
  for (std::uint32_t code = 0; code < 256; ++code)
    c.texels[code] = plain.texels[code] = code * 0x10101U | (255U - code) << 24;  // and another alpha, which is linear
  Lookups lookups;
  for (int code = 0; code < 256; ++code) lookups.add(0, (float(code) + 0.5F) / 256, 0.5F);
  for (int code = 0; code < 256; ++code) lookups.add(1, (float(code) + 0.5F) / 256, 0.5F);
  const auto out = Packed({c, plain}).run(lookups.in);
  for (std::size_t code = 0; code < 256; ++code) {
    for (std::size_t k = 0; k < 3; ++k) {
      const float found = as_float(out[k][code]);
      EXPECT_EQ(found, float(linear_of(int(code)))) << code;
      EXPECT_EQ(code_of(double(found)), int(code));
      EXPECT_EQ(as_float(out[k][256 + code]), float(code) / 255.0F) << code;
    }
    EXPECT_EQ(as_float(out[3][code]), float(255 - code) / 255.0F) << code;
  }
}

TEST(Texture, channels_are_in_the_order_of_the_records_R_in_the_low_byte) {
  std::mt19937 random(8);
  Case c = make_case(1, 1, Wrapping::repeat, Wrapping::repeat, 0, random);
  c.texels = {0x33U | 0x66U << 8 | 0x99U << 16 | 0xffU << 24};
  Lookups lookups;
  lookups.add(0, 0.2F, 0.9F);
  const auto out = Packed({c}).run(lookups.in);
  EXPECT_EQ(as_float(out[0][0]), 0.2F);
  EXPECT_EQ(as_float(out[1][0]), 0.4F);
  EXPECT_EQ(as_float(out[2][0]), 0.6F);
  EXPECT_EQ(as_float(out[3][0]), 1.0F);
}

TEST(Texture, M25_coordinates_are_transformed_and_come_from_the_set_that_the_texture_says) {
  std::mt19937 random(9);
  Case c = make_case(5, 6, Wrapping::repeat, Wrapping::mirror, 0, random);
  c.record.u_u = 0.5F, c.record.u_v = -2, c.record.u_1 = 0.25F;
  c.record.v_u = 3, c.record.v_v = 1.5F, c.record.v_1 = -0.125F;
  Case second = c;
  second.record.flags |= EK_TEXTURE_UV1;
  Case flat = c;  // scale 0: one colour everywhere
  flat.record.u_u = flat.record.u_v = flat.record.v_u = flat.record.v_v = 0;
  const std::vector<Case> cases{c, second, flat};
  Lookups lookups;
  std::uniform_real_distribution<float> any(-2, 2);
  for (int i = 0; i < 300; ++i) lookups.add(std::size_t(i) % 3, any(random), any(random), any(random), any(random));
  const auto out = Packed(cases).run(lookups.in);
  for (std::size_t i = 0; i < lookups.size(); ++i) {
    const Case& used = cases[lookups.in[0][i]];
    const bool other = lookups.in[0][i] == 1;
    const double mesh_u = as_float(lookups.in[other ? 3 : 1][i]), mesh_v = as_float(lookups.in[other ? 4 : 2][i]);
    const double u = used.record.u_u * mesh_u + used.record.u_v * mesh_v + used.record.u_1;
    const double v = used.record.v_u * mesh_u + used.record.v_v * mesh_v + used.record.v_1;
    for (std::size_t k = 0; k < 4; ++k) ASSERT_NEAR(as_float(out[k][i]), used.at(u, v)[k], 2e-5) << i;
  }
}

}  // namespace
}  // namespace eikon::test
