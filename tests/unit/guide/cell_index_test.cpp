// SPDX-License-Identifier: Apache-2.0
#include "guide/cell_index.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

namespace eikon::test {
namespace {

TEST(CellIndex, numbers_cells_as_a_map_does) {
  std::mt19937_64 random(1);
  CellIndex index;
  CellValues<std::uint64_t> values;
  for (int round = 0; round < 3; ++round) {
    std::map<CellId, std::uint32_t> expected;
    for (int i = 0; i < 20000; ++i) {
      // Neighbours, which differ in few bits, and the id 0 among them.
      const CellId id = (random() % 40) | (random() % 40) << 16 | (random() % 3) << 56;
      const auto [at, is_new] = expected.emplace(id, std::uint32_t(expected.size()));
      EXPECT_EQ(index.find(id), is_new ? CellIndex::kNone : at->second);
      EXPECT_EQ(index.add(id), at->second);
      if (is_new) values.add() = id;
    }
    ASSERT_EQ(index.ids().size(), expected.size());
    ASSERT_EQ(values.size(), expected.size());
    for (const auto& [id, number] : expected) {
      EXPECT_EQ(index.find(id), number);
      EXPECT_EQ(index.ids()[number], id);
      EXPECT_EQ(values[number], id);
    }
    index.clear();
    values.clear();
    EXPECT_EQ(index.find(expected.begin()->first), CellIndex::kNone);
  }
}

TEST(CellValues, stay_where_they_are) {
  CellValues<int> values;
  values.add() = 7;
  const int* const first = &values[0];
  for (int i = 0; i < 10000; ++i) values.add() = i;
  EXPECT_EQ(first, &values[0]);
  EXPECT_EQ(values[0], 7);
}

}  // namespace
}  // namespace eikon::test
