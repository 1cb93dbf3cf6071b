// SPDX-License-Identifier: Apache-2.0
// A process with a lost thread ends at once and with its code, whoever's main() it has.
#include "core/lost_threads.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

namespace eikon {
namespace {

/// Ends as Python does: by exit(), which comes to the destructors of a driver that was loaded
/// before.
[[noreturn]] void exit_with_a_driver(bool is_lost) {
  (void)std::atexit([] { std::fputs("destructors\n", stderr); });
  std::fputs("begin\n", stderr);
  thread_is_lost();
  leave_process_at_exit();
  if (!is_lost) lost_thread_ended();
  std::exit(7);
}

TEST(LostThreads, exit_skips_destructors_of_drivers_while_a_thread_is_lost) {
  EXPECT_EXIT(exit_with_a_driver(true), testing::ExitedWithCode(7), "^begin\n$");
  EXPECT_EXIT(exit_with_a_driver(false), testing::ExitedWithCode(7), "^begin\ndestructors\n$");
}

}  // namespace
}  // namespace eikon
