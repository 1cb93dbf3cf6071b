// SPDX-License-Identifier: Apache-2.0
// What a batch did, from its table, its ledger and its pictures.
#pragma once
#include <chrono>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "cli/command.h"
#include "image/image.h"

namespace eikon::test {

inline constexpr const char* kSmall = "--size 12x8 --spp 2";

/// A scene of the project beside the jobs, with its buffers.
inline void copy_scene(const Workplace& here, const std::string& name, const std::string& as = "") {
  const std::filesystem::path to = here / (as.empty() ? name : as);
  std::filesystem::copy_file(scene(name), to, std::filesystem::copy_options::overwrite_existing);
}

/// What became of each line, from the table: "done", "skipped", ...
using States = std::map<int, std::string>;
inline States states(const Outcome& outcome) {
  States found;
  std::istringstream lines(outcome.out);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    int number = 0;
    std::string state;
    if (words >> number >> state && state != "jobs" && state != "frames") found[number] = state;
  }
  return found;
}

inline std::vector<nlohmann::json> entries(const std::filesystem::path& ledger) {
  std::vector<nlohmann::json> found;
  std::istringstream lines(read_bytes(ledger));
  for (std::string line; std::getline(lines, line);)
    if (const nlohmann::json entry = nlohmann::json::parse(line, nullptr, false); entry.is_object())
      found.push_back(entry);
  return found;
}

/// The states that the ledger tells of each line, in order.
inline std::map<int, std::vector<std::string>> told(const std::filesystem::path& ledger) {
  std::map<int, std::vector<std::string>> found;
  for (const nlohmann::json& entry : entries(ledger)) found[entry.at("line")].push_back(entry.at("state"));
  return found;
}

inline bool same_picture(const std::filesystem::path& a, const std::filesystem::path& b) {
  const Image one = read_exr(a), other = read_exr(b);
  return one.width == other.width && one.height == other.height && one.planes == other.planes;
}

/// Once the file has that many lines.
inline void wait_for_lines(const std::filesystem::path& file, std::ptrdiff_t count) {
  for (int i = 0; i < 6000; ++i) {
    if (std::filesystem::exists(file)) {
      const std::string text = read_bytes(file);
      if (std::count(text.begin(), text.end(), '\n') >= count) return;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  FAIL() << file << " has not " << count << " lines after a minute";
}

}  // namespace eikon::test
