// SPDX-License-Identifier: Apache-2.0
// Finds how much of the machine this process may use. Batch systems and containers often grant less
// than the machine has.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace eikon {

struct HostLimits {
  unsigned threads = 1;
  // "2 processors", "affinity mask", "quota of 1.5 processors in /sys/fs/cgroup/cpu.max".
  std::string threads_why;
  std::uint64_t memory_bytes = 0;  // 0: not known
  std::string memory_why;          // "the machine has so much", or the file that sets the limit
};

/// Returns the present limits of this process. Files that are missing or malformed limit nothing.
[[nodiscard]] HostLimits host_limits();

/// Memory of host_limits() when this was first asked; 0 if the system does not say. It is cheap,
/// for whoever asks once per file.
[[nodiscard]] std::uint64_t usable_memory_bytes();

/// Returns the text of a file, or nothing when there is no such file.
using FileReader = std::function<std::optional<std::string>(const std::string& path)>;

/// Resources of the machine, before control groups limit them.
struct HostFacts {
  unsigned processors = 1, in_affinity_mask = 1;
  std::uint64_t memory_bytes = 0;  // 0: not known
};
/// Returns the limits by `facts` and by the control groups (v1 and v2) in /proc and /sys.
[[nodiscard]] HostLimits limits_of(const HostFacts& facts, const FileReader& read);

/// Returns the processors that a v2 group grants in cpu.max ("150000 100000" is 1.5), or nothing
/// for "max" and malformed text.
[[nodiscard]] std::optional<double> parse_cpu_max(const std::string& text);
/// The same for v1, from cpu.cfs_quota_us (-1: no limit) and cpu.cfs_period_us.
[[nodiscard]] std::optional<double> parse_cfs(const std::string& quota, const std::string& period);
/// Returns the bytes that memory.max (v2) or memory.limit_in_bytes (v1) grants. In v1 the largest
/// multiple of a page means "no limit".
[[nodiscard]] std::optional<std::uint64_t> parse_memory_limit(const std::string& text);

/// Returns the directories of this process's control group for a controller ("cpu", "memory") and
/// of all groups above it, innermost first, from a v1 hierarchy or else from v2. Each may have
/// limits, and the least one holds.
/// cgroup, mountinfo  texts of /proc/self/cgroup and /proc/self/mountinfo
struct CgroupDirectories {
  std::vector<std::string> v1, v2;
};
[[nodiscard]] CgroupDirectories cgroup_directories(const std::string& cgroup, const std::string& mountinfo,
                                                   const std::string& controller);

/// While the result lives, host-side work of the whole process uses at most so many threads at
/// once; the least of several such limits holds. 0 stands for what the machine, the affinity mask
/// and the quota of the control group allow.
[[nodiscard]] std::shared_ptr<const void> limit_threads(unsigned threads);

}  // namespace eikon
