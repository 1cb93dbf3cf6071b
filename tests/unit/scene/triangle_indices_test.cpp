// SPDX-License-Identifier: Apache-2.0
#include "scene/triangle_indices.h"

#include <gtest/gtest.h>

#include <random>

namespace eikon {
namespace {

using List = std::vector<std::uint32_t>;

/// The triangles of corners, one after the other, as [glTF 2.0, section 3.7.2.1] has them.
List expanded(const List& corners, TriangleMode mode) {
  List list;
  for (std::size_t i = 0; i + 2 < corners.size(); i += mode == TriangleMode::list ? 3 : 1) {
    std::array<std::uint32_t, 3> t{corners[i], corners[i + 1], corners[i + 2]};
    if (mode == TriangleMode::fan) t = {corners[i + 1], corners[i + 2], corners[0]};
    if (mode == TriangleMode::strip && i % 2 == 1) std::swap(t[1], t[2]);
    const bool twice = t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
    if (mode == TriangleMode::list || !twice) list.insert(list.end(), t.begin(), t.end());
  }
  return list;
}

TriangleIndices indices_of(const List& corners, TriangleMode mode, std::uint32_t largest) {
  return TriangleIndices({.mode = mode, .count = corners.size(), .largest = largest, .corner = [&](std::size_t i) {
                            return corners[i];
                          }});
}

TEST(TriangleIndices, are_those_of_the_expanded_list_in_each_mode_and_size) {
  std::mt19937 random(7);
  for (const std::uint32_t largest : {2U, 9U, 255U, 256U, 65535U, 65536U, 0xFFFFFFFEU})
    for (const TriangleMode mode : {TriangleMode::list, TriangleMode::strip, TriangleMode::fan})
      for (const std::size_t count : {0U, 1U, 2U, 3U, 4U, 5U, 100U, 1001U}) {
        List corners;
        for (std::size_t i = 0; i < count; ++i) corners.push_back(std::uint32_t(random() % (std::uint64_t{largest} + 1)));
        const List want = expanded(corners, mode);
        const TriangleIndices indices = indices_of(corners, mode, largest);
        EXPECT_EQ(indices.list(), want) << largest << " " << int(mode) << " " << count;
        EXPECT_EQ(indices.size(), want.size());
        for (std::size_t i = 0; i < want.size(); ++i) ASSERT_EQ(indices[i], want[i]) << i;
      }
}

TEST(TriangleIndices, take_no_more_than_the_file_and_copies_nothing) {
  List corners;
  for (std::uint32_t i = 0; i < 1000; ++i) corners.push_back(i % 200);
  const TriangleIndices strip = indices_of(corners, TriangleMode::strip, 199);
  EXPECT_EQ(strip.size(), 3U * 998);
  EXPECT_EQ(strip.bytes(), 1000U);
  EXPECT_EQ(indices_of(corners, TriangleMode::list, 300).bytes(), 2U * 999);
}

TEST(TriangleIndices, a_renumbered_copy_leaves_the_other_as_it_was) {
  const List corners{3, 1, 2, 2, 0, 1};
  const TriangleIndices before = indices_of(corners, TriangleMode::strip, 3);
  TriangleIndices after = before;
  after.renumber({30, 31, 32, 33});
  EXPECT_EQ(before.list(), expanded(corners, TriangleMode::strip));
  EXPECT_EQ(after.list(), expanded({33, 31, 32, 32, 30, 31}, TriangleMode::strip));
  after.push_back(7);
  for (int i = 0; i < 2; ++i) after.push_back(8);
  EXPECT_EQ(after.size(), before.size() + 3);
}

}  // namespace
}  // namespace eikon
