// SPDX-License-Identifier: Apache-2.0
// WebP and KTX2: what comes out, and that files which lie are refused in one line.
#include <gtest/gtest.h>

#include <cstdlib>
#include <span>

#include "core/error.h"
#include "image/decode_picture.h"
#include "support/ktx_named.h"
#include "support/paths.h"
#include "support/picture_builder.h"

namespace eikon {
namespace {

using picture_test::ktx2;
using picture_test::Ktx2Options;
using picture_test::KtxNamed;
using picture_test::Samples;
using picture_test::webp;
using Pixels = std::vector<std::uint32_t>;

std::span<const std::byte> bytes_in(const std::string& file) { return std::as_bytes(std::span(file)); }

Pixels decoded(const std::string& file) { return decode_picture(bytes_in(file), read_picture_header(bytes_in(file))); }

std::string refused(const std::string& file) {
  try {
    decoded(file);
  } catch (const InputError& e) {
    const std::string what = e.what();
    EXPECT_EQ(what.find('\n'), std::string::npos) << what;
    return what;
  }
  ADD_FAILURE() << "accepted";
  return {};
}

bool says(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

/// A red, a green, a blue and a half transparent pixel, as four samples each.
const Samples kFour{250, 1, 2, 255, 3, 240, 4, 255, 5, 6, 230, 255, 7, 8, 9, 128};
const Pixels kFourPixels{0xFF0201FAU, 0xFF04F003U, 0xFFE60605U, 0x80090807U};

/// `count` pixels of one colour.
Samples plain(std::size_t count, std::initializer_list<std::uint8_t> rgba) {
  Samples samples;
  for (std::size_t i = 0; i < count; ++i) samples.insert(samples.end(), rgba);
  return samples;
}

TEST(DecodeWebp, lossless_pixels_come_out_as_they_went_in) {
  EXPECT_EQ(decoded(webp(2, 2, kFour, true)), kFourPixels);
  EXPECT_EQ(decoded(webp(4, 1, kFour, true)), kFourPixels);
}

TEST(DecodeWebp, lossy_pixels_come_out_nearly_so_with_their_alpha) {
  for (const std::uint8_t alpha : {std::uint8_t{255}, std::uint8_t{77}}) {
    const std::string file = webp(16, 16, plain(256, {200, 100, 50, alpha}), false);
    for (const std::uint32_t pixel : decoded(file)) {
      ASSERT_NEAR(pixel & 0xFFU, 200, 4);
      ASSERT_NEAR(pixel >> 8U & 0xFFU, 100, 4);
      ASSERT_NEAR(pixel >> 16U & 0xFFU, 50, 4);
      ASSERT_EQ(pixel >> 24U, alpha);
    }
  }
}

TEST(DecodeWebp, memory_of_the_decoder_is_known_before) {
  EXPECT_EQ(read_picture_header(bytes_in(webp(2, 2, kFour, true))).scratch_bytes, 16U);
  EXPECT_EQ(read_picture_header(bytes_in(webp(16, 16, plain(256, {1, 2, 3, 255}), false))).scratch_bytes, 0U);
  EXPECT_EQ(read_picture_header(bytes_in(webp(16, 16, plain(256, {1, 2, 3, 9}), false))).scratch_bytes, 512U);
}

TEST(DecodeWebp, an_animation_is_refused_by_name) {
  std::string file = webp(16, 16, plain(256, {1, 2, 3, 9}), false);  // has the extended header, because of its alpha
  ASSERT_EQ(file.substr(12, 4), "VP8X");
  file[20] = static_cast<char>(file[20] | 2);
  EXPECT_TRUE(says(refused(file), "animated WebP"));
}

TEST(DecodeWebp, a_file_cut_anywhere_is_an_error) {
  for (const bool lossless : {true, false}) {
    const std::string good = webp(16, 16, plain(256, {200, 100, 50, 77}), lossless);
    for (std::size_t size = 0; size + 1 < good.size(); ++size) refused(good.substr(0, size));
  }
}

TEST(DecodeWebp, changed_bytes_give_a_picture_or_an_error) {
  for (const bool lossless : {true, false}) {
    const std::string good = webp(5, 7, plain(35, {200, 100, 50, 77}), lossless);
    for (std::size_t at = 0; at < good.size(); ++at) {
      for (const int value : {0x00, 0x01, 0x7F, 0x80, 0xFF}) {
        std::string changed = good;
        changed[at] = static_cast<char>(value);
        try {
          const PictureHeader header = read_picture_header(bytes_in(changed));
          if (std::uint64_t{header.width} * header.height > 1U << 20U) continue;
          ASSERT_EQ(decode_picture(bytes_in(changed), header).size(), std::size_t{header.width} * header.height);
        } catch (const InputError&) {
        }
      }
    }
  }
}

TEST(DecodeKtx2, plain_texels_need_no_library) {
  const KtxNamed none("/nowhere/libktx.so");
  for (const std::uint32_t format : {37U, 43U}) EXPECT_EQ(decoded(ktx2(2, 2, kFour, {.format = format})), kFourPixels);
  const Samples rgb{250, 1, 2, 3, 240, 4};
  for (const std::uint32_t format : {23U, 29U})
    EXPECT_EQ(decoded(ktx2(2, 1, rgb, {.format = format})), (Pixels{kFourPixels[0], kFourPixels[1]}));
}

TEST(DecodeKtx2, the_largest_level_of_basis_universal_comes_by_libktx) {
  const KtxNamed stand_in(EIKON_KTX_STAND_IN);
  ASSERT_EQ(ktx_library_problem(), "");
  const Pixels pixels = decoded(ktx2(4, 2, {1}, {.format = 0, .levels = 3}));
  ASSERT_EQ(pixels.size(), 8U);
  for (std::uint32_t i = 0; i < 8; ++i) EXPECT_EQ(pixels[i], i | 2 * i << 8U | (255 - i) << 24U);
  EXPECT_TRUE(says(refused(ktx2(4, 2, {}, {.format = 0})), "libktx: stand-in: no data"));
  EXPECT_TRUE(says(refused(ktx2(4, 2, {1}, {.scheme = 2})), "fewer pixels"));
}

TEST(DecodeKtx2, without_libktx_the_reason_is_said) {
  const std::string file = ktx2(4, 4, {1}, {.format = 0, .scheme = 1});
  EXPECT_TRUE(read_picture_header(bytes_in(file)).needs_library);
  for (const char* library : {"/nowhere/libktx.so", "libm.so.6"}) {
    const KtxNamed named(library);
    EXPECT_TRUE(says(ktx_library_problem(), library));
    EXPECT_TRUE(says(refused(file), "libktx"));
  }
  const KtxNamed other("libm.so.6");
  EXPECT_TRUE(says(ktx_library_problem(), "it has no ktxTexture2_CreateFromMemory"));
}

TEST(DecodeKtx2, what_is_no_picture_is_refused) {
  for (const Ktx2Options& options : {Ktx2Options{.depth = 2}, Ktx2Options{.layers = 2}, Ktx2Options{.faces = 6}})
    EXPECT_TRUE(says(refused(ktx2(2, 2, kFour, options)), "several"));
  EXPECT_TRUE(says(refused(ktx2(2, 2, kFour, {.format = 145})), "VkFormat 145"));
  EXPECT_TRUE(says(refused(ktx2(2, 2, kFour, {.scheme = 3})), "supercompression 3"));
  EXPECT_TRUE(says(refused(ktx2(0, 2, kFour)), "dimensions"));
  EXPECT_TRUE(says(refused(ktx2(2, 0, kFour)), "dimensions"));
  EXPECT_TRUE(says(refused(ktx2(3, 2, kFour)), "do not hold"));
  EXPECT_TRUE(says(refused(ktx2(0xFFFFFFFFU, 0xFFFFFFFFU, kFour)), "do not hold"));
  EXPECT_TRUE(says(refused(ktx2(0xFFFFFFFFU, 0xFFFFFFFFU, kFour, {.format = 0})), "more than"));
  const std::string good = ktx2(2, 2, kFour);
  for (std::size_t size = 0; size < good.size(); ++size) refused(good.substr(0, size));
}

// 8 x 8 pixels in four quarters: red, blue, green, and light grey of alpha 128. Written by Basis Universal's encoder.
// Of codec ETC1S.
constexpr const char* kEtc1s =
    "ab4b5458203230bb0d0a1a0a0000000001000000080000000800000000000000000000000100000001000000010000006800"
    "00003c000000a400000024000000c8000000000000009a000000000000006201000000000000040000000000000000000000"
    "000000003c0000000000000002003800a301020003030000080800000000000000003f000000000000000000ffffffff4000"
    "3f0f0000000000000000ffffffff1f0000004b545877726974657200426173697320556e6976657273616c20322e31300000"
    "06000300350000000d000000300000000000000000000000000000000200000002000000020000001840140001000040d00a"
    "9a0ec10a200a8000000000647b9208600600000000200c8361d00f80290000000000104887b8b69c934305acaaaaaafaffff"
    "ff575555550500c144000000000000f2df2748013001400000000002b990005103060000004113a2d1130c00260000000000"
    "001040000b09e653";
// Of codec UASTC, with Zstandard.
constexpr const char* kUastc =
    "ab4b5458203230bb0d0a1a0a0000000001000000080000000800000000000000000000000100000001000000020000006800"
    "00002c000000940000002400000000000000000000000000000000000000b800000000000000330000000000000040000000"
    "000000002c0000000000000002002800a601020003030000100000000000000000007f030000000000000000ffffffff1f00"
    "00004b545877726974657200426173697320556e6976657273616c20322e3130000028b52ffd2040550100f0171b05e37fc6"
    "2300170409fa3f1e08030c19e85f328c001e1e1e1074ce010400801850ccccc209c005";

std::string from_hex(const char* digits) {
  std::string out;
  for (; *digits != '\0'; digits += 2) out += static_cast<char>(std::stoi(std::string(digits, 2), nullptr, 16));
  return out;
}

TEST(DecodeKtx2, both_codecs_of_basis_universal_give_their_picture) {
  const char* const library = std::getenv("EIKON_KTX");
  if (library == nullptr || *library == '\0') GTEST_SKIP() << "EIKON_KTX does not name libktx";
  constexpr int kQuarters[2][2][4] = {{{216, 40, 24, 255}, {32, 72, 208, 255}},
                                      {{96, 200, 64, 255}, {240, 240, 240, 128}}};
  for (const char* file : {kEtc1s, kUastc}) {
    const Pixels pixels = decoded(from_hex(file));
    ASSERT_EQ(pixels.size(), 64U);
    for (std::uint32_t i = 0; i < 64; ++i)
      for (std::uint32_t c = 0; c < 4; ++c)
        ASSERT_NEAR(pixels[i] >> (8 * c) & 0xFFU, kQuarters[i / 32][i % 8 / 4][c], 12) << i << ' ' << c;
  }
}

}  // namespace
}  // namespace eikon
