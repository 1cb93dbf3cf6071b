// SPDX-License-Identifier: Apache-2.0
#include "core/time_share.h"

#include <gtest/gtest.h>

namespace eikon::test {
namespace {

void work_for(double seconds) {
  for (const double begin_s = host_seconds(); host_seconds() - begin_s < seconds;) {
  }
}

TEST(TimeShare, work_is_due_at_first_and_then_rests_for_its_share) {
  TimeShare share(0.01);
  EXPECT_TRUE(share.is_due());
  const double begin_s = host_seconds();
  share.run([] { work_for(0.002); });
  while (!share.is_due()) work_for(1e-4);
  // It took 2 ms or more, and rests for a hundred times that.
  EXPECT_GE(host_seconds() - begin_s, 0.2);
}

TEST(TimeShare, work_that_takes_nothing_rests_for_the_least_time) {
  TimeShare share(0.5, 1e6);
  share.run([] {});
  EXPECT_FALSE(share.is_due());
}

TEST(TimeShare, a_rest_may_begin_before_the_work_was_ever_done) {
  TimeShare share(0.5);
  share.rest(1e6);
  EXPECT_FALSE(share.is_due());
  share.run([] {});
  share.rest(0);
  EXPECT_TRUE(share.is_due());
}

}  // namespace
}  // namespace eikon::test
