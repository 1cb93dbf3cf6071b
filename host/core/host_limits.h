// SPDX-License-Identifier: Apache-2.0
// How much of the machine this process may use: what batch systems and containers grant is often less than what is there.
#pragma once
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace eikon {

struct HostLimits {
  unsigned threads = 1;
  std::string threads_why;  // "2 processors", "affinity mask", "quota of 1.5 processors in /sys/fs/cgroup/cpu.max"
  std::uint64_t memory_bytes = 0;  // 0: not known
  std::string memory_why;          // "the machine has so much", or the file that says so
};

/// The limits of this process, as they are now. Files that are missing or make no sense limit nothing.
[[nodiscard]] HostLimits host_limits();

/// A file's text, or nothing where there is none.
using FileReader = std::function<std::optional<std::string>(const std::string& path)>;

/// What the machine has, apart from control groups.
struct HostFacts {
  unsigned processors = 1, in_affinity_mask = 1;
  std::uint64_t memory_bytes = 0;  // 0: not known
};
/// The limits by `facts` and by the control groups (v1 and v2) that the files of /proc and /sys show.
[[nodiscard]] HostLimits limits_of(const HostFacts& facts, const FileReader& read);

/// Processors that "cpu.max" of a v2 group grants ("150000 100000": 1.5); nothing for "max" or what makes no sense.
[[nodiscard]] std::optional<double> parse_cpu_max(const std::string& text);
/// The same for v1's cpu.cfs_quota_us (-1: no limit) and cpu.cfs_period_us.
[[nodiscard]] std::optional<double> parse_cfs(const std::string& quota, const std::string& period);
/// Bytes that memory.max (v2) or memory.limit_in_bytes (v1, which says "no limit" with the largest multiple of a page) grants.
[[nodiscard]] std::optional<std::uint64_t> parse_memory_limit(const std::string& text);

/// Directories of this process's control group for a controller ("cpu", "memory") and of all groups above it, innermost first,
/// of a v1 hierarchy or else of v2. Each may have limits; the least holds.
/// cgroup, mountinfo  texts of /proc/self/cgroup and /proc/self/mountinfo
struct CgroupDirectories {
  std::vector<std::string> v1, v2;
};
[[nodiscard]] CgroupDirectories cgroup_directories(const std::string& cgroup, const std::string& mountinfo,
                                                   const std::string& controller);

}  // namespace eikon
