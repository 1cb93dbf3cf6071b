// SPDX-License-Identifier: Apache-2.0
#include "gltf/materials/scratch_share.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

namespace eikon {
namespace {

/// Lets eight threads work several times with `bytes` of 100 each. Returns the most of them at work
/// at one time.
int most_at_work(std::uint64_t bytes) {
  ScratchShare share(100);
  std::atomic<int> at_work{0}, most{0};
  std::vector<std::jthread> threads;
  for (int i = 0; i < 8; ++i)
    threads.emplace_back([&] {
      for (int k = 0; k < 10; ++k)
        share.with(bytes, [&] {
          const int now = ++at_work;
          for (int known = most; known < now && !most.compare_exchange_weak(known, now);) continue;
          std::this_thread::sleep_for(std::chrono::milliseconds(1));
          --at_work;
        });
    });
  threads.clear();
  return most;
}

TEST(ScratchShare, decoders_wait_while_others_leave_too_little) {
  EXPECT_LE(most_at_work(33), 3);
  EXPECT_EQ(most_at_work(51), 1);
}

TEST(ScratchShare, a_decoder_that_needs_more_than_there_is_works_alone) { EXPECT_EQ(most_at_work(1000), 1); }

TEST(ScratchShare, what_fails_gives_its_part_back) {
  ScratchShare share(100);
  EXPECT_THROW(share.with(100, [] { throw std::runtime_error("damaged"); }), std::runtime_error);
  bool worked = false;
  share.with(100, [&] { worked = true; });
  EXPECT_TRUE(worked);
}

}  // namespace
}  // namespace eikon
