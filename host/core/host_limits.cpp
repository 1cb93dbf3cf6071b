// SPDX-License-Identifier: Apache-2.0
#include "core/host_limits.h"

#include <sched.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <fstream>
#include <sstream>

namespace eikon {

namespace {

std::vector<std::string> words_of(const std::string& text, char separator = ' ') {
  std::vector<std::string> words;
  std::istringstream stream(text);
  for (std::string word; std::getline(stream, word, separator);)
    if (!word.empty()) words.push_back(word);
  return words;
}

bool has(const std::vector<std::string>& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

/// Returns the number in a file of one line.
template <class Number>
std::optional<Number> number_of(const std::string& text) {
  const std::size_t end = text.find_last_not_of(" \t\n") + 1;
  Number value{};
  const auto [last, error] = std::from_chars(text.data(), text.data() + end, value);
  if (end == 0 || error != std::errc() || last != text.data() + end) return std::nullopt;
  return value;
}

/// Decodes \040 and the like, which stand for spaces in mount points.
std::string unescape(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool octal = text[i] == '\\' && i + 3 < text.size() && text.find_first_not_of("01234567", i + 1) >= i + 4;
    if (octal) {
      out += char((text[i + 1] - '0') * 64 + (text[i + 2] - '0') * 8 + (text[i + 3] - '0'));
      i += 3;
    } else {
      out += text[i];
    }
  }
  return out;
}

/// Returns the directories of group `path` and of the groups above it, in a mount of group `root`.
std::vector<std::string> upwards(const std::string& mount, const std::string& root, std::string path) {
  const std::string prefix = root == "/" ? "" : root;
  const bool below =
      path.compare(0, prefix.size(), prefix) == 0 && (path.size() == prefix.size() || path[prefix.size()] == '/');
  // The mount does not show a group of another namespace, so only its top can be read.
  path = below ? path.substr(prefix.size()) : "";
  std::vector<std::string> directories;
  while (!path.empty() && path != "/") {
    directories.push_back(mount + path);
    path.resize(path.rfind('/') == std::string::npos ? 0 : path.rfind('/'));
  }
  directories.push_back(mount);
  return directories;
}

std::optional<std::string> read_file(const std::string& path) {
  std::ifstream in(path);
  std::stringstream text;
  if (!in || !(text << in.rdbuf())) return std::nullopt;
  return text.str();
}

unsigned count_affinity_mask(unsigned processors) {
  // The call fails while the kernel's mask is longer than this one.
  for (int size = 1024; size <= 1 << 20; size *= 2) {
    cpu_set_t* const set = CPU_ALLOC(size);
    if (set == nullptr) break;
    const std::size_t bytes = CPU_ALLOC_SIZE(size);
    const int failed = sched_getaffinity(0, bytes, set);
    const int count = failed == 0 ? CPU_COUNT_S(bytes, set) : 0;
    CPU_FREE(set);
    if (failed == 0) return unsigned(std::max(count, 1));
  }
  return processors;
}

void apply_cpu(HostLimits& limits, double granted, const std::string& file) {
  // The quota is rounded up: with 1.5 processors, two threads can use all of it and one cannot.
  const auto threads = unsigned(std::clamp(std::ceil(granted), 1.0, 65536.0));
  if (threads >= limits.threads) return;
  limits.threads = threads;
  limits.threads_why = fmt::format("quota of {:.3g} processors in {}", granted, file);
}

void apply_memory(HostLimits& limits, std::uint64_t bytes, const std::string& file) {
  if (limits.memory_bytes != 0 && bytes >= limits.memory_bytes) return;
  limits.memory_bytes = bytes;
  limits.memory_why = file;
}

}  // namespace

std::optional<double> parse_cpu_max(const std::string& text) {
  const std::vector<std::string> words = words_of(text);
  return words.size() == 2 ? parse_cfs(words[0], words[1]) : std::nullopt;
}

std::optional<double> parse_cfs(const std::string& quota, const std::string& period) {
  const auto granted = number_of<std::int64_t>(quota), of = number_of<std::int64_t>(period);
  if (!granted || !of || *granted <= 0 || *of <= 0) return std::nullopt;
  return double(*granted) / double(*of);
}

std::optional<std::uint64_t> parse_memory_limit(const std::string& text) {
  const auto bytes = number_of<std::uint64_t>(text);
  if (!bytes || *bytes == 0 || *bytes >= std::uint64_t{1} << 62) return std::nullopt;
  return bytes;
}

CgroupDirectories cgroup_directories(const std::string& cgroup, const std::string& mountinfo,
                                     const std::string& controller) {
  std::string path_v1, path_v2;
  for (const std::string& line : words_of(cgroup, '\n')) {  // "4:cpu,cpuacct:/path", "0::/path"
    const std::size_t first = line.find(':');
    const std::size_t second = first == std::string::npos ? first : line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string names = line.substr(first + 1, second - first - 1);
    if (names.empty()) path_v2 = line.substr(second + 1);
    if (has(words_of(names, ','), controller)) path_v1 = line.substr(second + 1);
  }
  CgroupDirectories found;
  for (const std::string& line : words_of(mountinfo, '\n')) {
    // "32 31 0:29 /root /mount/point rw,relatime shared:1 - cgroup cgroup rw,cpu"
    const std::vector<std::string> words = words_of(line);
    const auto dash = std::find(words.begin(), words.end(), "-");
    if (words.size() < 8 || words.end() - dash < 4) continue;
    const std::string &type = dash[1], root = unescape(words[3]), mount = unescape(words[4]);
    if (type == "cgroup2" && !path_v2.empty()) found.v2 = upwards(mount, root, path_v2);
    if (type == "cgroup" && !path_v1.empty() && has(words_of(dash[3], ','), controller))
      found.v1 = upwards(mount, root, path_v1);
  }
  return found;
}

HostLimits limits_of(const HostFacts& facts, const FileReader& read) {
  HostLimits limits;
  limits.threads = std::max(1U, std::min(facts.processors, facts.in_affinity_mask));
  limits.threads_why = facts.in_affinity_mask < facts.processors
                           ? fmt::format("affinity mask of {} of {} processors", limits.threads, facts.processors)
                           : fmt::format("{} processors", limits.threads);
  limits.memory_bytes = facts.memory_bytes;
  limits.memory_why = "of the machine";
  const std::string cgroup = read("/proc/self/cgroup").value_or("");
  const std::string mountinfo = read("/proc/self/mountinfo").value_or("");
  const CgroupDirectories cpu = cgroup_directories(cgroup, mountinfo, "cpu");
  const CgroupDirectories memory = cgroup_directories(cgroup, mountinfo, "memory");
  const auto text = [&](const std::string& file) { return read(file).value_or(""); };
  for (const std::string& directory : cpu.v2)
    if (const auto granted = parse_cpu_max(text(directory + "/cpu.max")))
      apply_cpu(limits, *granted, directory + "/cpu.max");
  for (const std::string& directory : cpu.v1)
    if (const auto granted = parse_cfs(text(directory + "/cpu.cfs_quota_us"), text(directory + "/cpu.cfs_period_us")))
      apply_cpu(limits, *granted, directory + "/cpu.cfs_quota_us");
  for (const std::string& directory : memory.v2)
    if (const auto bytes = parse_memory_limit(text(directory + "/memory.max")))
      apply_memory(limits, *bytes, directory + "/memory.max");
  for (const std::string& directory : memory.v1)
    if (const auto bytes = parse_memory_limit(text(directory + "/memory.limit_in_bytes")))
      apply_memory(limits, *bytes, directory + "/memory.limit_in_bytes");
  return limits;
}

HostLimits host_limits() {
  HostFacts facts;
  facts.processors = unsigned(std::max(sysconf(_SC_NPROCESSORS_ONLN), 1L));
  facts.in_affinity_mask = count_affinity_mask(facts.processors);
  const long pages = sysconf(_SC_PHYS_PAGES), page_bytes = sysconf(_SC_PAGESIZE);
  if (pages > 0 && page_bytes > 0) facts.memory_bytes = std::uint64_t(pages) * std::uint64_t(page_bytes);
  return limits_of(facts, read_file);
}

std::uint64_t usable_memory_bytes() {
  static const std::uint64_t bytes = host_limits().memory_bytes;
  return bytes;
}

std::shared_ptr<const void> limit_threads(unsigned threads) {
  const unsigned allowed = host_limits().threads;
  const unsigned most = threads == 0 ? allowed : std::min(threads, allowed);
  return std::make_shared<tbb::global_control>(tbb::global_control::max_allowed_parallelism, most);
}

}  // namespace eikon
