// SPDX-License-Identifier: Apache-2.0
#include "device/selection.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <numeric>

#include "core/error.h"

namespace eikon {
namespace {

constexpr std::uint32_t kMostParts = 1024;  // more is a mistake, and would be listed in messages

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return text;
}

bool is_digits(const std::string& text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
}

/// A number from 1 on, or 0 for what is none.
std::uint32_t count_of(const std::string& text) {
  std::uint32_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return is_digits(text) && error == std::errc() && end == text.data() + text.size() ? value : 0;
}

SelectionEntry parse_entry(const std::string& text, const std::string& selection) {
  const auto refuse = [&](const std::string& why) {
    throw UsageError(fmt::format(
        "--devices {}: '{}' {}; takes DEVICE:NxUNITS, such as cpu:2x1 for two sub-devices of one compute unit, "
        "0:2x1+1x4 for three, 0:2x1/2 for the second",
        selection, text, why));
  };
  SelectionEntry entry;
  entry.text = text;
  const std::size_t colon = text.rfind(':');
  entry.device = lower(text.substr(0, colon));
  if (colon == std::string::npos) return entry;
  std::string parts = text.substr(colon + 1);
  if (const std::size_t slash = parts.find('/'); slash != std::string::npos) {
    entry.only = count_of(parts.substr(slash + 1));
    if (entry.only == 0) refuse("has no part's number, from 1, after the '/'");
    parts.resize(slash);
  }
  for (std::size_t begin = 0; begin <= parts.size();) {
    const std::size_t end = std::min(parts.find('+', begin), parts.size());
    const std::string term = parts.substr(begin, end - begin);
    const std::size_t cross = std::min(term.find('x'), term.size());
    const std::uint32_t times = count_of(term.substr(0, cross));
    const std::uint32_t units = cross == term.size() ? 0 : count_of(term.substr(cross + 1));
    if (times == 0 || units == 0) refuse(fmt::format("has the parts '{}'", term));
    if (times > kMostParts - entry.parts.size()) refuse(fmt::format("has more than {} parts", kMostParts));
    entry.parts.insert(entry.parts.end(), times, units);
    begin = end + 1;
  }
  if (entry.only > entry.parts.size()) refuse(fmt::format("has {} parts", entry.parts.size()));
  return entry;
}

bool names(const SelectionEntry& entry, const DeviceInfo& info) {
  const std::string& device = entry.device;
  return is_digits(device) ? std::to_string(info.index) == device
         : device == "all" ? info.unusable.empty()
         : device == "cpu" ? info.cpu
         : device == "gpu" ? info.gpu
                           : !device.empty() && lower(info.name).find(device) != std::string::npos;
}

/// The part of a device that has so many compute units from `first` on.
DeviceInfo part_of(const DeviceInfo& whole, const SelectionEntry& entry, std::uint32_t number, std::uint32_t first) {
  DeviceInfo part = whole;
  const std::uint32_t units = entry.parts[number];
  part.first_unit = whole.first_unit + first;
  part.compute_units = units;
  const char* const noun = whole.cpu ? "core" : "unit";
  part.name += units == 1 ? fmt::format(" [{} {} of {}]", noun, first + 1, whole.compute_units)
                          : fmt::format(" [{}s {} to {} of {}]", noun, first + 1, first + units, whole.compute_units);
  const std::size_t colon = entry.text.rfind(':');
  part.selector =
      fmt::format("{}{}/{}", whole.index, entry.text.substr(colon, entry.text.find('/') - colon), number + 1);
  return part;
}

std::vector<DeviceInfo> divide(const DeviceInfo& whole, const SelectionEntry& entry) {
  const std::uint64_t wanted = std::accumulate(entry.parts.begin(), entry.parts.end(), std::uint64_t{0});
  if (!whole.divisible && wanted > 0)
    throw DeviceError(fmt::format("--devices {}: the driver of device {} ({}) makes no sub-devices; choose it whole",
                                  entry.text, whole.index, whole.name));
  if (wanted > whole.compute_units)
    throw DeviceError(fmt::format("--devices {}: {} compute units are wanted, and device {} ({}) has {}; ask for fewer",
                                  entry.text, wanted, whole.index, whole.name, whole.compute_units));
  std::vector<DeviceInfo> parts;
  std::uint32_t first = 0;
  for (std::uint32_t i = 0; i < entry.parts.size(); ++i) {
    if (entry.only == 0 || entry.only == i + 1) parts.push_back(part_of(whole, entry, i, first));
    first += entry.parts[i];
  }
  return parts;
}

/// Adds a device unless it is there.
void choose(std::vector<DeviceInfo>& chosen, const DeviceInfo& info, const std::string& selection) {
  for (DeviceInfo& other : chosen) {
    if (other.index != info.index) continue;
    const bool apart = other.first_unit + other.compute_units <= info.first_unit ||
                       info.first_unit + info.compute_units <= other.first_unit;
    if (apart) continue;
    if (other.first_unit == info.first_unit && other.compute_units == info.compute_units) {
      other.by_name = other.by_name || info.by_name;
      return;
    }
    throw UsageError(
        fmt::format("--devices {}: '{}' and '{}' overlap; choose one of them", selection, other.name, info.name));
  }
  chosen.push_back(info);
  chosen.back().position = std::uint32_t(chosen.size() - 1);
}

}  // namespace

std::vector<SelectionEntry> parse_selection(const std::string& selection) {
  std::vector<SelectionEntry> entries;
  for (std::size_t begin = 0; begin <= selection.size();) {
    const std::size_t end = std::min(selection.find(',', begin), selection.size());
    entries.push_back(parse_entry(selection.substr(begin, end - begin), selection));
    begin = end + 1;
  }
  return entries;
}

std::vector<DeviceInfo> resolve_selection(const std::string& selection, const std::vector<DeviceInfo>& all) {
  std::string known;
  for (const DeviceInfo& info : all) known += fmt::format("{}{}: {}", known.empty() ? "" : ", ", info.index, info.name);
  std::vector<DeviceInfo> chosen;
  for (const SelectionEntry& entry : parse_selection(selection)) {
    std::size_t matches = 0;
    for (DeviceInfo info : all) {
      if (!names(entry, info)) continue;
      if (!info.unusable.empty())
        throw DeviceError(fmt::format("device {} ({}) cannot be used: {}", info.index, info.name, info.unusable));
      ++matches;
      info.by_name = entry.device != "all" && entry.device != "cpu" && entry.device != "gpu";
      if (entry.parts.empty())
        choose(chosen, info, selection);
      else
        for (const DeviceInfo& part : divide(info, entry)) choose(chosen, part, selection);
    }
    if (matches == 0)
      throw DeviceError(fmt::format("--devices {}: no such device '{}'; there is {}", selection, entry.device, known));
  }
  return chosen;
}

}  // namespace eikon
