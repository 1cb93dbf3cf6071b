// SPDX-License-Identifier: Apache-2.0
#include "job/render_options.h"

#include <gtest/gtest.h>

namespace eikon::test {
namespace {

TEST(RenderOptions, want_stage_times_where_somebody_sees_them) {
  RenderOptions options;
  EXPECT_TRUE(options.wants_stage_times()) << "the table at the end";
  options.quiet = true;
  EXPECT_FALSE(options.wants_stage_times());
  for (std::string RenderOptions::*file : {&RenderOptions::stats, &RenderOptions::profile, &RenderOptions::report}) {
    RenderOptions with = options;
    with.*file = "file";
    EXPECT_TRUE(with.wants_stage_times());
  }
}

}  // namespace
}  // namespace eikon::test
