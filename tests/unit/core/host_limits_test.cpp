// SPDX-License-Identifier: Apache-2.0
// Limits of processors and memory, from invented files.
#include "core/host_limits.h"

#include <gtest/gtest.h>

#include <map>

namespace eikon {
namespace {

using Files = std::map<std::string, std::string>;

HostLimits limits(const Files& files, const HostFacts& facts = {16, 16, std::uint64_t{64} << 30}) {
  return limits_of(facts, [&](const std::string& path) -> std::optional<std::string> {
    const auto found = files.find(path);
    if (found == files.end()) return std::nullopt;
    return found->second;
  });
}

const std::string kMountV2 = "24 30 0:26 / /sys/fs/cgroup rw,nosuid shared:4 - cgroup2 cgroup2 rw,nsdelegate\n";
const std::string kMountsV1 =
    "31 23 0:28 / /sys/fs/cgroup rw - tmpfs tmpfs rw\n"
    "32 31 0:29 / /sys/fs/cgroup/cpu,cpuacct rw,relatime shared:9 master:2 - cgroup cgroup rw,cpu,cpuacct\n"
    "35 31 0:32 / /sys/fs/cgroup/memory rw,relatime - cgroup cgroup rw,memory\n"
    "34 31 0:31 / /sys/fs/cgroup/cpuset rw,relatime - cgroup cgroup rw,cpuset\n";

TEST(HostLimits, without_files_the_machine_is_the_limit) {
  const HostLimits found = limits({});
  EXPECT_EQ(found.threads, 16U);
  EXPECT_EQ(found.memory_bytes, std::uint64_t{64} << 30);
  EXPECT_EQ(found.threads_why, "16 processors");
}

TEST(HostLimits, the_affinity_mask_limits_the_threads) {
  const HostLimits found = limits({}, {16, 3, 0});
  EXPECT_EQ(found.threads, 3U);
  EXPECT_EQ(found.threads_why, "affinity mask of 3 of 16 processors");
  EXPECT_EQ(limits({}, {16, 0, 0}).threads, 1U);
}

TEST(HostLimits, of_groups_of_version_2_the_least_limit_above_holds) {
  const Files files = {{"/proc/self/cgroup", "0::/user.slice/job 7\n"},
                       {"/proc/self/mountinfo", kMountV2},
                       {"/sys/fs/cgroup/user.slice/job 7/cpu.max", "max 100000\n"},
                       {"/sys/fs/cgroup/user.slice/cpu.max", "250000 100000\n"},
                       {"/sys/fs/cgroup/user.slice/job 7/memory.max", "2147483648\n"},
                       {"/sys/fs/cgroup/user.slice/memory.max", "8589934592\n"}};
  const HostLimits found = limits(files);
  EXPECT_EQ(found.threads, 3U);  // 2.5, rounded up
  EXPECT_EQ(found.threads_why, "quota of 2.5 processors in /sys/fs/cgroup/user.slice/cpu.max");
  EXPECT_EQ(found.memory_bytes, std::uint64_t{2} << 30);
  EXPECT_EQ(found.memory_why, "/sys/fs/cgroup/user.slice/job 7/memory.max");
}

TEST(HostLimits, quota_and_memory_of_a_group_of_version_1_are_limits) {
  const Files files = {{"/proc/self/cgroup", "9:cpuset:/\n4:memory:/job\n2:cpu,cpuacct:/job\n0::/\n"},
                       {"/proc/self/mountinfo", kMountsV1 + kMountV2},
                       {"/sys/fs/cgroup/cpu,cpuacct/job/cpu.cfs_quota_us", "50000\n"},
                       {"/sys/fs/cgroup/cpu,cpuacct/job/cpu.cfs_period_us", "100000\n"},
                       {"/sys/fs/cgroup/cpu,cpuacct/cpu.cfs_quota_us", "-1\n"},
                       {"/sys/fs/cgroup/cpu,cpuacct/cpu.cfs_period_us", "100000\n"},
                       {"/sys/fs/cgroup/memory/job/memory.limit_in_bytes", "536870912\n"},
                       {"/sys/fs/cgroup/memory/memory.limit_in_bytes", "9223372036854771712\n"}};
  const HostLimits found = limits(files);
  EXPECT_EQ(found.threads, 1U);
  EXPECT_EQ(found.memory_bytes, std::uint64_t{512} << 20);
}

TEST(HostLimits, a_container_s_mount_shows_its_own_group_at_the_top) {
  const CgroupDirectories found =
      cgroup_directories("4:memory:/docker/abc\n",
                         "35 31 0:32 /docker/abc /sys/fs/cgroup/memory ro - cgroup cgroup rw,memory\n", "memory");
  EXPECT_EQ(found.v1, (std::vector<std::string>{"/sys/fs/cgroup/memory"}));
  const CgroupDirectories inner =
      cgroup_directories("4:memory:/docker/abc/x\n",
                         "35 31 0:32 /docker/abc /sys/fs/cgroup/memory ro - cgroup cgroup rw,memory\n", "memory");
  EXPECT_EQ(inner.v1, (std::vector<std::string>{"/sys/fs/cgroup/memory/x", "/sys/fs/cgroup/memory"}));
  const CgroupDirectories other =
      cgroup_directories("4:memory:/docker/abcd\n",
                         "35 31 0:32 /docker/abc /sys/fs/cgroup/memory ro - cgroup cgroup rw,memory\n", "memory");
  EXPECT_EQ(other.v1, (std::vector<std::string>{"/sys/fs/cgroup/memory"})) << "another group's, not seen here";
}

TEST(HostLimits, spaces_and_backslashes_in_mount_points_are_read) {
  const CgroupDirectories found =
      cgroup_directories("0::/a\n", "35 31 0:32 / /odd\\040place\\134x rw - cgroup2 none rw\n", "cpu");
  EXPECT_EQ(found.v2, (std::vector<std::string>{"/odd place\\x/a", "/odd place\\x"}));
}

TEST(HostLimits, a_quota_is_time_over_its_period_and_anything_else_is_none) {
  EXPECT_EQ(parse_cpu_max("150000 100000\n"), 1.5);
  EXPECT_EQ(parse_cfs("800000\n", "100000\n"), 8.0);
  for (const char* const none : {"max 100000\n", "", "\n", "100000", "x 100000", "0 100000", "-1 100000", "100000 0",
                                 "100000 100000 7", "99999999999999999999 100000", "1.5 2"})
    EXPECT_FALSE(parse_cpu_max(none)) << none;
}

TEST(HostLimits, a_limit_of_memory_is_a_number_of_bytes_and_anything_else_is_none) {
  EXPECT_EQ(parse_memory_limit("4096\n"), 4096U);
  for (const char* const none :
       {"max\n", "", "\n", "-1\n", "0\n", "9223372036854771712\n", "1k", "1 2", "99999999999999999999999\n"})
    EXPECT_FALSE(parse_memory_limit(none)) << none;
}

TEST(HostLimits, files_without_sense_limit_nothing) {
  const Files files = {{"/proc/self/cgroup", "nonsense\n0:\n::\n:cpu:/x\n"},
                       {"/proc/self/mountinfo", "- - -\n1 2 3\n35 31 0:32 / /m rw - cgroup\n\n"},
                       {"/m/cpu.max", "1 1\n"}};
  EXPECT_EQ(limits(files).threads, 16U);
}

TEST(HostLimits, this_process_has_limits_and_says_why) {
  const HostLimits here = host_limits();
  EXPECT_GE(here.threads, 1U);
  EXPECT_GT(here.memory_bytes, std::uint64_t{1} << 26);
  EXPECT_FALSE(here.threads_why.empty());
  EXPECT_FALSE(here.memory_why.empty());
}

}  // namespace
}  // namespace eikon
