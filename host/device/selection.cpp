// SPDX-License-Identifier: Apache-2.0
#include "device/selection.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <numeric>

#include "core/error.h"
#include "io/text.h"

namespace eikon {
namespace {

constexpr std::uint32_t kMaxParts = 1024;  // more are a mistake, and messages would list them all

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return text;
}

bool is_digits(const std::string& text) {
  return !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
}

/// Returns a number from 1 on, or 0 when the text is none.
std::uint32_t count_of(const std::string& text) { return number_in<std::uint32_t>(text).value_or(0); }

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
  for (const std::string& term : split(parts, '+')) {
    const std::size_t cross = std::min(term.find('x'), term.size());
    const std::uint32_t times = count_of(term.substr(0, cross));
    const std::uint32_t units = cross == term.size() ? 0 : count_of(term.substr(cross + 1));
    if (times == 0 || units == 0) refuse(fmt::format("has the parts '{}'", term));
    if (times > kMaxParts - entry.parts.size()) refuse(fmt::format("has more than {} parts", kMaxParts));
    entry.parts.insert(entry.parts.end(), times, units);
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

/// Returns the part of a device with so many compute units from `first` on.
DeviceInfo part_of(const DeviceInfo& whole, const SelectionEntry& entry, std::uint32_t number, std::uint32_t first) {
  DeviceInfo part = whole;
  const std::uint32_t units = entry.parts[number];
  part.first_unit = whole.first_unit + first;
  part.compute_units = units;
  part.part = true;
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

/// Adds a device unless it is in the list.
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

void add_note(std::vector<std::string>& notes, const std::string& note) {
  if (std::find(notes.begin(), notes.end(), note) == notes.end()) notes.push_back(note);
}

/// Returns the devices that show the hardware of other devices, by index, with a note for each.
std::map<std::uint32_t, std::string> duplicates(const std::vector<DeviceInfo>& all,
                                                const std::function<bool(const DeviceInfo&)>& trusted) {
  std::map<std::uint32_t, std::string> left_out;
  std::vector<DeviceInfo> kept;
  for (const DeviceInfo& info : all) {
    if (!info.unusable.empty()) continue;
    const auto same =
        std::find_if(kept.begin(), kept.end(), [&](const DeviceInfo& other) { return same_hardware(info, other); });
    if (same == kept.end()) {
      kept.push_back(info);
      continue;
    }
    const auto exact = [](const DeviceInfo& device) {
      return (device.correctly_rounded_divide_sqrt || (device.gpu && device.own_division)) && device.denormals;
    };
    const bool was_right = trusted(*same), is_right = trusted(info);
    const bool better = was_right == is_right ? !exact(*same) && exact(info) : is_right;
    const DeviceInfo &taken = better ? info : *same, &left = better ? *same : info;
    const char* const why = was_right != is_right          ? ", which reads memory rightly"
                            : exact(taken) && !exact(left) ? ", which promises exact arithmetic"
                                                           : "";
    left_out[left.index] = fmt::format(
        "device {} ({}, {}) is the hardware of device {} ({}){}, and is left out; it can be chosen by index",
        left.index, left.name, left.platform, taken.index, taken.platform, why);
    if (better) *same = info;
  }
  return left_out;
}

}  // namespace

std::vector<SelectionEntry> parse_selection(const std::string& selection) {
  std::vector<SelectionEntry> entries;
  for (const std::string& text : split(selection, ',')) entries.push_back(parse_entry(text, selection));
  return entries;
}

bool same_hardware(const DeviceInfo& a, const DeviceInfo& b) {
  if (a.index == b.index) return true;
  if (a.cpu || b.cpu) return a.cpu && b.cpu;
  if (!a.pci.empty() && !b.pci.empty()) return a.pci == b.pci;
  if (!a.uuid.empty() && !b.uuid.empty()) return a.uuid == b.uuid;
  // Two cards of one kind have the same name on their platform.
  const std::string of_a = lower(a.name), of_b = lower(b.name);
  return a.platform != b.platform && a.vendor_id == b.vendor_id && !of_a.empty() && !of_b.empty() &&
         (of_a.find(of_b) != std::string::npos || of_b.find(of_a) != std::string::npos);
}

Selection resolve_selection(const std::string& selection, const std::vector<DeviceInfo>& all,
                            const std::function<bool(const DeviceInfo&)>& trusted) {
  std::string known;
  for (const DeviceInfo& info : all) known += fmt::format("{}{}: {}", known.empty() ? "" : ", ", info.index, info.name);
  Selection result;
  const std::map<std::uint32_t, std::string> left_out = duplicates(all, trusted);
  for (const SelectionEntry& entry : parse_selection(selection)) {
    const bool by_name = entry.device != "all" && entry.device != "cpu" && entry.device != "gpu";
    std::size_t matches = 0;
    for (DeviceInfo info : all) {
      if (!names(entry, info)) continue;
      ++matches;
      if (!by_name && left_out.count(info.index) != 0) {
        add_note(result.notes, left_out.at(info.index));
        continue;
      }
      if (!info.unusable.empty())
        throw DeviceError(fmt::format("device {} ({}) cannot be used: {}", info.index, info.name, info.unusable));
      info.by_name = by_name;
      const std::vector<DeviceInfo> parts = entry.parts.empty() ? std::vector{info} : divide(info, entry);
      for (const DeviceInfo& part : parts) choose(result.devices, part, selection);
    }
    if (matches == 0)
      throw DeviceError(fmt::format("--devices {}: no such device '{}'; there is {}", selection, entry.device, known));
  }
  for (const DeviceInfo& a : result.devices)
    for (const DeviceInfo& b : result.devices)
      if (a.index < b.index && same_hardware(a, b))
        add_note(result.notes,
                 fmt::format("devices {} ({}, {}) and {} ({}, {}) are one piece of hardware, and will share it",
                             a.index, a.name, a.platform, b.index, b.name, b.platform));
  return result;
}

std::vector<std::string> leave_cores_to_feeders(std::vector<DeviceInfo>& chosen, unsigned host_threads) {
  const auto fed = unsigned(std::ranges::count_if(chosen, [](const DeviceInfo& info) { return !info.cpu; }));
  const unsigned most = host_threads > fed ? host_threads - fed : 1;
  std::vector<std::string> notes;
  for (DeviceInfo& info : chosen) {
    if (fed == 0 || !info.cpu || info.part || !info.divisible || info.compute_units <= most) continue;
    notes.push_back(fmt::format("device {} ({}) works with {} of {} cores: the rest is for the thread{} that feed{} {}",
                                info.selector, info.name, most, info.compute_units, fed > 1 ? "s" : "",
                                fed > 1 ? "" : "s", fed > 1 ? "the other devices" : "the other device"));
    info.compute_units = most;
    info.units_limit = "the threads that feed other devices";
  }
  return notes;
}

void hold_to_limits(DeviceInfo& info, const HostLimits& host, unsigned threads) {
  if (!info.cpu) return;
  const bool asked = threads != 0 && threads < host.threads;
  const unsigned most = asked ? threads : host.threads;
  if (info.compute_units > most) {
    info.compute_units = most;
    info.units_limit = asked ? fmt::format("--threads {}", threads) : host.threads_why;
  }
  if (host.memory_bytes == 0 || info.memory_bytes <= host.memory_bytes) return;
  info.memory_bytes = host.memory_bytes;
  info.max_allocation_bytes = std::min(info.max_allocation_bytes, info.memory_bytes);
  info.memory_limit = host.memory_why;
}

}  // namespace eikon
