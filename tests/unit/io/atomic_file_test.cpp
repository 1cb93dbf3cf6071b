// SPDX-License-Identifier: Apache-2.0
#include "io/atomic_file.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include "core/error.h"
#include "support/temporary_folder.h"

namespace eikon::test {
namespace {

/// The id of a process that has ended.
pid_t dead_process() {
  const pid_t child = fork();
  if (child == 0) _exit(0);
  int status = 0;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  return child;
}

TEST(AtomicFile, removes_what_a_dead_writer_left_and_leaves_the_files_of_others) {
  const TemporaryFolder folder;
  std::string name;  // of a temporary file: .a.exr.eikon-PROCESSES-ID-NUMBER.tmp
  {
    const AtomicFile file(folder / "a.exr");
    name = std::filesystem::directory_iterator(folder.path())->path().filename().string();
  }
  ASSERT_EQ(folder.file_count(), 0U);
  const std::string id = "-" + std::to_string(getpid()) + "-";
  const std::size_t at = name.rfind(id), begin = name.rfind('-', at - 1) + 1;
  ASSERT_NE(at, std::string::npos) << name;
  ASSERT_EQ(at - begin, 16U) << name;
  const std::string dead_id = "-" + std::to_string(dead_process()) + "-";
  const auto named = [&](const std::string& processes, const std::string& process) {
    return name.substr(0, begin) + processes + process + "0.tmp";
  };
  const std::string own = name.substr(begin, 16), foreign(16, own == std::string(16, '0') ? '1' : '0');
  folder.write(named(own, dead_id), "dead");
  folder.write(named(own, "-" + std::to_string(getppid()) + "-"), "alive");
  folder.write(named(foreign, dead_id), "cannot be seen from here");
  folder.write(".a.exr.eikon" + dead_id + "0.tmp", "says nothing of its machine");
  { const AtomicFile file(folder / "a.exr"); }
  EXPECT_FALSE(std::filesystem::exists(folder / named(own, dead_id)));
  EXPECT_TRUE(std::filesystem::exists(folder / named(own, "-" + std::to_string(getppid()) + "-")));
  EXPECT_TRUE(std::filesystem::exists(folder / named(foreign, dead_id)));
  EXPECT_EQ(folder.file_count(), 3U);
}

TEST(AtomicFile, refuses_a_name_that_is_too_long_before_anything_is_written) {
  const TemporaryFolder folder;
  EXPECT_NO_THROW(AtomicFile(folder / std::string(255, 'x')));
  EXPECT_THROW(AtomicFile(folder / std::string(256, 'x')), InputError);
  EXPECT_EQ(folder.file_count(), 0U);
}

}  // namespace
}  // namespace eikon::test
