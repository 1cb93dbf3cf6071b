// SPDX-License-Identifier: Apache-2.0
// WebP and KTX2: what comes out, and that files which lie are refused in one line.
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <span>

#include "core/error.h"
#include "support/paths.h"
#include "support/picture_builder.h"
#include "support/temporary_folder.h"
#include "unit/image/decoded_picture.h"

namespace eikon {
namespace {

using picture_test::bytes_of;
using picture_test::decoded;
using picture_test::ktx2;
using picture_test::Ktx2Options;
using picture_test::refusal;
using picture_test::Samples;
using picture_test::webp;
using test::contains;
using Pixels = std::vector<std::uint32_t>;

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
  EXPECT_EQ(read_picture_header(bytes_of(webp(2, 2, kFour, true))).scratch_bytes, 16U);
  EXPECT_EQ(read_picture_header(bytes_of(webp(16, 16, plain(256, {1, 2, 3, 255}), false))).scratch_bytes, 0U);
  EXPECT_EQ(read_picture_header(bytes_of(webp(16, 16, plain(256, {1, 2, 3, 9}), false))).scratch_bytes, 512U);
}

TEST(DecodeWebp, an_animation_is_refused_by_name) {
  std::string file = webp(16, 16, plain(256, {1, 2, 3, 9}), false);  // has the extended header, because of its alpha
  ASSERT_EQ(file.substr(12, 4), "VP8X");
  file[20] = static_cast<char>(file[20] | 2);
  EXPECT_TRUE(contains(refusal(file), "animated WebP"));
}

TEST(DecodeWebp, a_file_cut_anywhere_is_an_error) {
  for (const bool lossless : {true, false}) {
    const std::string good = webp(16, 16, plain(256, {200, 100, 50, 77}), lossless);
    for (std::size_t size = 0; size + 1 < good.size(); ++size) refusal(good.substr(0, size));
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
          const PictureHeader header = read_picture_header(bytes_of(changed));
          if (std::uint64_t{header.width} * header.height > 1U << 20U) continue;
          ASSERT_EQ(decode_picture(bytes_of(changed), header).size(), std::size_t{header.width} * header.height);
        } catch (const InputError&) {
        }
      }
    }
  }
}

// One Zstandard frame [RFC 8878] of a block that is not compressed.
Samples zstandard(const Samples& bytes) {
  const auto size = static_cast<std::uint8_t>(bytes.size());
  Samples out{0x28,
              0xB5,
              0x2F,
              0xFD,
              0x20,
              size,
              static_cast<std::uint8_t>(unsigned{size} << 3U | 1U),
              static_cast<std::uint8_t>(size >> 5U),
              0};
  out.insert(out.end(), bytes.begin(), bytes.end());
  return out;
}

TEST(DecodeKtx2, plain_texels_are_read_packed_or_not) {
  const Samples rgb{250, 1, 2, 3, 240, 4};
  for (const bool packed : {false, true}) {
    const auto texels = [&](const Samples& samples) { return packed ? zstandard(samples) : samples; };
    const std::uint32_t scheme = packed ? 2 : 0;
    for (const std::uint32_t format : {37U, 43U})
      EXPECT_EQ(decoded(ktx2(2, 2, texels(kFour), {.format = format, .scheme = scheme, .unpacked = 16})), kFourPixels);
    for (const std::uint32_t format : {23U, 29U})
      EXPECT_EQ(decoded(ktx2(2, 1, texels(rgb), {.format = format, .scheme = scheme, .unpacked = 6})),
                (Pixels{kFourPixels[0], kFourPixels[1]}));
  }
}

TEST(DecodeKtx2, packed_texels_that_lie_about_their_number_are_refused) {
  const Ktx2Options options{.scheme = 2, .unpacked = 16};
  EXPECT_TRUE(contains(refusal(ktx2(2, 2, zstandard({1, 2, 3}), options)), "end early"));
  EXPECT_TRUE(
      contains(refusal(ktx2(2, 2, zstandard(Samples(32, 1)), options)), "Zstandard: Destination buffer is too small"));
  EXPECT_TRUE(contains(refusal(ktx2(2, 2, zstandard(kFour), {.scheme = 2, .unpacked = 15})), "do not hold"));
  EXPECT_TRUE(contains(refusal(ktx2(2, 2, {1, 2, 3}, options)), "Zstandard: "));
  // Memory for the unpacked pixels is bounded by what the header says.
  EXPECT_EQ(read_picture_header(bytes_of(ktx2(2, 2, zstandard(kFour), options))).scratch_bytes, 16U);
}

TEST(DecodeKtx2, what_is_no_picture_is_refused) {
  for (const Ktx2Options& options : {Ktx2Options{.depth = 2}, Ktx2Options{.layers = 2}, Ktx2Options{.faces = 6}})
    EXPECT_TRUE(contains(refusal(ktx2(2, 2, kFour, options)), "several"));
  EXPECT_TRUE(contains(refusal(ktx2(2, 2, kFour, {.format = 145})), "VkFormat 145"));
  EXPECT_TRUE(contains(refusal(ktx2(2, 2, kFour, {.scheme = 3})), "supercompression 3"));
  EXPECT_TRUE(contains(refusal(ktx2(2, 2, kFour, {.format = 0})), "colour model 0 and supercompression 0"));
  EXPECT_TRUE(contains(refusal(ktx2(0, 2, kFour)), "dimensions"));
  EXPECT_TRUE(contains(refusal(ktx2(2, 0, kFour)), "dimensions"));
  EXPECT_TRUE(contains(refusal(ktx2(3, 2, kFour)), "do not hold"));
  EXPECT_TRUE(contains(refusal(ktx2(0xFFFFFFFFU, 0xFFFFFFFFU, kFour)), "do not hold"));
  EXPECT_TRUE(contains(refusal(ktx2(65537, 1, Samples(4 * 65537))), "more than"));
  const std::string good = ktx2(2, 2, kFour);
  for (std::size_t size = 0; size < good.size(); ++size) refusal(good.substr(0, size));
}

TEST(DecodeKtx2, both_codecs_of_basis_universal_give_their_picture) {
  constexpr int kQuarters[2][2][4] = {{{216, 40, 24, 255}, {32, 72, 208, 255}},
                                      {{96, 200, 64, 255}, {240, 240, 240, 128}}};
  for (const std::string& file : {picture_test::etc1s_quarters(), picture_test::uastc_quarters()}) {
    const Pixels pixels = decoded(file);
    ASSERT_EQ(pixels.size(), 64U);
    for (std::uint32_t i = 0; i < 64; ++i)
      for (std::uint32_t c = 0; c < 4; ++c)
        ASSERT_NEAR(pixels[i] >> (8 * c) & 0xFFU, kQuarters[i / 32][i % 8 / 4][c], 12) << i << ' ' << c;
  }
}

TEST(DecodeKtx2, damaged_basis_universal_is_refused_in_one_line_or_read) {
  for (const std::string& good : {picture_test::etc1s_quarters(), picture_test::uastc_quarters()}) {
    for (std::size_t size = 0; size < good.size(); ++size) refusal(good.substr(0, size));
    int refusals = 0;
    // The pixels stay 8 x 8, so that no change makes a large picture.
    for (std::size_t at = 28; at < good.size(); ++at)
      for (const int change : {1, 16, 128, 255}) {
        std::string bad = good;
        bad[at] = static_cast<char>(bad[at] ^ change);
        try {
          EXPECT_EQ(decoded(bad).size(), 64U);
        } catch (const InputError& e) {
          EXPECT_FALSE(contains(e.what(), "\n"));
          ++refusals;
        }
      }
    EXPECT_GT(refusals, 50);
  }
}

// Files by the encoder of Basis Universal, each beside its texels by the decoder that belongs to
// it.
TEST(DecodeKtx2, texels_of_basis_universal_are_those_of_its_own_decoder) {
  const char* const python = std::getenv("EIKON_BASISU");
  if (python == nullptr || *python == '\0') GTEST_SKIP() << "EIKON_BASISU does not name a Python that has alktx2";
  const test::TemporaryFolder folder;
  const std::string script = std::string(EIKON_SOURCE_DIR) + "/tests/support/basis_pictures.py";
  ASSERT_EQ(std::system(("'" + std::string(python) + "' '" + script + "' '" + folder.path().string() + "'").c_str()),
            0);
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    if (entry.path().extension() != ".ktx2") continue;
    const Pixels pixels = decoded(test::read_bytes(entry.path()));
    const std::string truth = test::read_bytes(std::filesystem::path(entry.path()).replace_extension(".rgba"));
    ASSERT_EQ(4 * pixels.size(), truth.size()) << entry.path();
    EXPECT_EQ(std::memcmp(pixels.data(), truth.data(), truth.size()), 0) << entry.path();
    ++count;
  }
  EXPECT_EQ(count, 192);
}

}  // namespace
}  // namespace eikon
