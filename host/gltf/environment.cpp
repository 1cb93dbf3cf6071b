// SPDX-License-Identifier: Apache-2.0
#include "gltf/environment.h"

#include <fmt/format.h>

#include <limits>
#include <numbers>

#include "core/error.h"
#include "io/source_file.h"
#include "scene/environment/environment.h"

namespace eikon {

std::optional<Environment> read_environment(const JsonView& owner, const std::filesystem::path& folder, Digest& digest,
                                            Notes& notes) {
  const Json* found = member(member(owner.value, "extras"), "environment");
  if (found == nullptr) return std::nullopt;
  const JsonView environment{.value = *found, .kind = "extras.environment", .parent = &owner};
  const std::string* const uri = as_string(environment, "uri");
  const bool has_radiance = has_numbers(environment, "radiance", 3);
  Environment result;
  if (uri != nullptr) {
    if (has_radiance) notes.warn(environment.label() + ": 'radiance' ignored, the file of 'uri' counts");
    result.scale = as_number(environment, "scale").value_or(1.0);
    if (!(result.scale >= 0)) environment.refuse(fmt::format("'scale' {:g} is negative", result.scale));
    result.rotation_rad = as_number(environment, "rotate").value_or(0.0) * std::numbers::pi / 180.0;
    std::vector<std::string> warnings;
    try {
      const std::filesystem::path file = resolve_uri(folder, *uri);
      digest.add(read_regular_file(file, kMaxEnvironmentFileBytes).span());
      result.map = load_environment(file, warnings);
    } catch (const InputError& e) {
      environment.refuse(e.what());
    }
    for (std::string& warning : warnings) notes.warn(std::move(warning));
    return result;
  }
  if (!has_radiance) {
    notes.warn(environment.label() + ": ignored, it has neither 'radiance' nor 'uri'");
    return std::nullopt;
  }
  for (int c = 0; c < 3; ++c) {
    const double value = number_at(*member(found, "radiance"), static_cast<std::size_t>(c));
    if (!(value >= 0 && value <= static_cast<double>(std::numeric_limits<float>::max()))) {
      environment.fail(fmt::format("radiance {:g} is negative or beyond single precision", value));
    }
    result.radiance[c] = static_cast<float>(value);
  }
  return result;
}

}  // namespace eikon
