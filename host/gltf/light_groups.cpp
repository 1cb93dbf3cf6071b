// SPDX-License-Identifier: Apache-2.0
#include "gltf/light_groups.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "shared/records.h"

namespace eikon {
namespace {

constexpr std::size_t kLongestName = 64;

/// Such characters can stand in the name of a channel, whose parts are divided by dots, and in
/// lists, which commas divide.
bool is_plain(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_';
}

}  // namespace

std::uint32_t light_group_of(const JsonView& owner, Scene& scene) {
  const Json* const extras = member(owner.value, "extras");
  if (member(extras, "lightGroup") == nullptr) return 0;
  const JsonView own{.value = *extras, .kind = "extras", .parent = &owner};
  const std::string& name = *as_string(own, "lightGroup");
  if (name.empty() || name.size() > kLongestName || !std::ranges::all_of(name, is_plain))
    own.refuse(fmt::format("'lightGroup' names a layer: up to {} letters, digits, - and _", kLongestName));
  auto& groups = scene.light_groups;
  const auto found = std::ranges::find(groups, name);
  if (found != groups.end()) return static_cast<std::uint32_t>(found - groups.begin());
  if (groups.size() == EK_LIGHT_GROUPS_MOST)
    own.refuse(fmt::format("'lightGroup': there are more than {}; put lights together", EK_LIGHT_GROUPS_MOST - 1));
  groups.push_back(name);
  return static_cast<std::uint32_t>(groups.size() - 1);
}

}  // namespace eikon
