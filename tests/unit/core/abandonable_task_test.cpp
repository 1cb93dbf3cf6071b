// SPDX-License-Identifier: Apache-2.0
// Work that may hang: it is waited for, or left to itself and counted as lost until it ends.
#include "core/abandonable_task.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <stdexcept>
#include <thread>

#include "support/lost_threads.h"

namespace eikon {
namespace {

TEST(AbandonableTask, work_that_ends_is_waited_for) {
  bool done = false;
  AbandonableTask task([&] { done = true; });
  EXPECT_TRUE(task.wait([] { return false; }));
  EXPECT_TRUE(done);
  EXPECT_EQ(lost_threads(), 0);
}

TEST(AbandonableTask, wait_throws_what_the_work_threw) {
  AbandonableTask task([] { throw std::runtime_error("wrong"); });
  EXPECT_THROW((void)task.wait([] { return false; }), std::runtime_error);
}

TEST(AbandonableTask, work_that_hangs_is_lost_until_it_ends) {
  const auto may_end = std::make_shared<std::atomic<bool>>(false);
  AbandonableTask task([may_end] {
    while (!*may_end) std::this_thread::yield();
  });
  EXPECT_FALSE(task.wait([] { return true; }));
  EXPECT_EQ(lost_threads(), 1);
  *may_end = true;
  EXPECT_TRUE(test::wait_for_lost_threads(10));
}

}  // namespace
}  // namespace eikon
