// SPDX-License-Identifier: Apache-2.0
#include "wavefront/unit_shrink.h"

#include <gtest/gtest.h>

namespace eikon {
namespace {

/// A device on which whatever `fails` says of a unit's size goes wrong; returns how often that was,
/// and what share of units had full size.
struct Course {
  int failures = 0, full = 0, units = 0;
};

template <class Fails>
Course drive(UnitShrink& shrink, int units, const Fails& fails) {
  Course course;
  double now_s = 0;
  bool open = false;
  while (course.units < units) {
    if (!open) shrink.opened(now_s, now_s + 0.1), now_s += 0.1, open = true;
    now_s += 0.5;
    ++course.units;
    if (fails(course.units, shrink.times())) {
      shrink.failed();
      ++course.failures, open = false;
      continue;
    }
    shrink.finished();
    course.full += shrink.times() == 0 ? 1 : 0;
    if (shrink.wants_larger_units(now_s)) shrink.enlarge(), open = false;
  }
  return course;
}

TEST(UnitShrink, after_single_faults_units_have_their_full_size_again) {
  UnitShrink shrink;
  const Course course = drive(shrink, 1000, [](int unit, unsigned) { return unit % 30 == 0; });
  EXPECT_EQ(course.failures, 33);
  EXPECT_GT(course.full, 650);  // of 30 units each time, 8 of a quarter's size
  EXPECT_LE(shrink.times(), 1U);
}

TEST(UnitShrink, single_faults_do_not_add_up_where_larger_units_are_not_worth_it_yet) {
  UnitShrink shrink;
  for (int fault = 0; fault < 20; ++fault) {
    shrink.opened(0, 1e9);  // it takes too long to open it again
    for (int unit = 0; unit < 20; ++unit) shrink.finished();
    shrink.failed();
    EXPECT_EQ(shrink.times(), 1U);
  }
}

TEST(UnitShrink, what_is_too_large_is_tried_ever_more_rarely) {
  for (const unsigned fits : {1U, 2U, 3U}) {
    UnitShrink shrink;
    const Course course = drive(shrink, 10000, [&](int, unsigned times) { return times < fits; });
    EXPECT_EQ(course.full, 0);
    EXPECT_LE(course.failures, 3 + 11);  // 8 + 16 + 32 + ... units lie between them
  }
}

TEST(UnitShrink, what_cannot_be_opened_is_tried_ever_more_rarely) {
  UnitShrink shrink;
  int failures = 0;
  double now_s = 0;
  for (int unit = 0; unit < 10000; now_s += 1) {
    if (shrink.times() == 0) {
      shrink.failed();
      ++failures;
      continue;
    }
    shrink.opened(now_s, now_s);
    while (!shrink.wants_larger_units(now_s) && unit < 10000) shrink.finished(), ++unit;
    if (unit < 10000) shrink.enlarge();
  }
  EXPECT_LE(failures, 11);  // 8 + 16 + 32 + ... units lie between them
  EXPECT_GE(failures, 10);
}

TEST(UnitShrink, opening_it_again_takes_a_small_part_of_the_time) {
  UnitShrink shrink;
  shrink.opened(0, 1);
  shrink.failed();
  shrink.opened(2, 3);  // a second, for units of a millisecond
  for (int i = 0; i < 1000; ++i) shrink.finished();
  EXPECT_FALSE(shrink.wants_larger_units(4));
  EXPECT_TRUE(shrink.wants_larger_units(23));
}

}  // namespace
}  // namespace eikon
