// SPDX-License-Identifier: Apache-2.0
#include "scene/notes.h"

#include <fmt/format.h>

#include <utility>

#include "scene/scene.h"

namespace eikon {

void Notes::unsupported(const std::string& feature, const std::string& user) {
  const auto [entry, is_new] = feature_index_.try_emplace(feature, features_.size());
  if (is_new) features_.push_back({.name = feature, .first_user = user, .users = {}});
  features_[entry->second].users.insert(user);
}

void Notes::warn(const std::string& warning) {
  if (said_.insert(warning).second) warnings_.push_back(warning);
}

void Notes::mended(const std::string& warning) {
  strict_errors_.push_back(warning);
  warn(warning);
}

void Notes::finish(Scene& scene) {
  for (Feature& feature : features_) {
    std::string user = std::move(feature.first_user);
    if (feature.users.size() > 1) user += fmt::format(" and {} more", feature.users.size() - 1);
    scene.unsupported.push_back({.feature = std::move(feature.name), .user = std::move(user)});
  }
  for (std::string& warning : strict_errors_) scene.out_of_range.push_back(std::move(warning));
  for (std::string& warning : warnings_) scene.warnings.push_back(std::move(warning));
}

}  // namespace eikon
