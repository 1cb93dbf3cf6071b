// SPDX-License-Identifier: Apache-2.0
#include "io/text.h"
#include "support/messages.h"

#include <gtest/gtest.h>

namespace eikon {
namespace {

using test::contains;

TEST(Text, whatever_could_rewrite_a_terminal_is_escaped) {
  EXPECT_EQ(printable("lamp \xC3\xA4 \xE2\x82\xAC \xF0\x9F\x92\xA1"), "lamp \xC3\xA4 \xE2\x82\xAC \xF0\x9F\x92\xA1");
  EXPECT_EQ(printable("a\x1b[2Jb\nc\rd\x7F"), "a\\x1b[2Jb\\x0ac\\x0dd\\x7f");
  EXPECT_EQ(printable(std::string("a\0b", 3)), "a\\x00b");
  EXPECT_EQ(printable("\xC2\x9B"
                      "2J"),
            "\\xc2\\x9b2J")
      << "the C1 code of ESC [";
  EXPECT_EQ(printable("\xE2\x80\xAE"
                      "gpj.exe"),
            "\\xe2\\x80\\xaegpj.exe")
      << "right-to-left override";
  EXPECT_EQ(printable("\xE2\x81\xA6"), "\\xe2\\x81\\xa6") << "isolate";
}

TEST(Text, bytes_that_are_not_utf_8_are_escaped_one_by_one) {
  EXPECT_EQ(printable("\x80"
                      "a\xFF"),
            "\\x80a\\xff");
  EXPECT_EQ(printable("\xC3"), "\\xc3") << "cut off";
  EXPECT_EQ(printable("\xC0\x9B"), "\\xc0\\x9b") << "an overlong ESC";
  EXPECT_EQ(printable("\xE0\x82\x9B"), "\\xe0\\x82\\x9b") << "an overlong C1 code";
  EXPECT_EQ(printable("\xED\xA0\x80"), "\\xed\\xa0\\x80") << "a surrogate";
  EXPECT_EQ(printable("\xF5\x80\x80\x80"), "\\xf5\\x80\\x80\\x80") << "beyond the last code point";
}

TEST(Text, names_of_any_bytes_become_utf_8_and_come_back) {
  const std::string plain = "a \xC3\xA4 \\xff \xE2\x82\xAC";
  EXPECT_EQ(name_to_utf8(plain), plain);
  EXPECT_EQ(name_to_utf8("a\xFF\xC3.exr"), std::string("a\0ff\0c3.exr", 11));
  std::string all = "\xC3\xA4";
  for (int byte = 0; byte < 256; ++byte) (all += static_cast<char>(byte)) += "ff";
  EXPECT_EQ(name_from_utf8(name_to_utf8(all)), all);
  for (const std::string& other : {std::string("\0", 1), std::string("\0f", 2), std::string("\0fg", 3)})
    EXPECT_EQ(name_from_utf8(other), other) << "no byte's two digits";
}

TEST(Text, long_names_lose_their_middle) {
  EXPECT_EQ(in_quotes("it's"), "'it\\x27s'");
  const std::string path = "/home/" + std::string(300, 'x') + "/scene.gltf";
  const std::string shown = in_quotes(path);
  EXPECT_LE(shown.size(), 105U);
  EXPECT_TRUE(shown.starts_with("'/home/xx"));
  EXPECT_TRUE(shown.ends_with("xx/scene.gltf'"));
  EXPECT_TRUE(contains(shown, "..."));
  std::string euros;
  for (int i = 0; i < 200; ++i) euros += "\xE2\x82\xAC";
  const std::string cut = in_quotes(euros);
  EXPECT_EQ(printable(cut), cut) << "no sequence is cut";
}

TEST(Text, a_mistyped_name_is_like_the_one_with_fewest_edits) {
  const std::vector<std::string> names = {"--samples", "--spp", "--fps", "--output", "--threads", "--light-samples"};
  EXPECT_EQ(most_like("--ssp", names), "--spp");
  EXPECT_EQ(most_like("--thredas", names), "--threads");
  EXPECT_EQ(most_like("--out", names), "--output") << "its beginning";
  EXPECT_EQ(most_like("--s", names), "--spp") << "the shortest that begins so";
  EXPECT_EQ(most_like("--light-sample", names), "--light-samples");
  EXPECT_EQ(most_like("--width", names), std::nullopt);
  EXPECT_EQ(most_like("-x", names), std::nullopt);
  EXPECT_EQ(most_like("", {}), std::nullopt);
}

}  // namespace
}  // namespace eikon
