// SPDX-License-Identifier: Apache-2.0
// The scripts of tools/ that need no device: what they promise about the files beside them.
#include <gtest/gtest.h>

#include <cstdlib>
#include <string>

#include "support/paths.h"

namespace {

TEST(Tools, shipped_scenes_are_what_make_scenes_writes_and_the_readme_names_each) {
  const std::string command = "/usr/bin/python3 -B '" EIKON_SOURCE_DIR "/tools/make_scenes.py' --check";
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
}

// Needs clang 14; another one is named by the environment variable CLANG.
TEST(Tools, every_stage_compiles_offline_without_a_warning_for_each_feature_alone) {
  const std::string command = "'" EIKON_SOURCE_DIR "/tools/lint_kernels.sh'";
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
}

}  // namespace
