// SPDX-License-Identifier: Apache-2.0
#include "scene/environment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/error.h"
#include "image/decode_hdr.h"
#include "image/image.h"
#include "io/source_file.h"

namespace eikon {
namespace {

constexpr std::uint64_t kMaxFileBytes = std::uint64_t{1} << 34U;

std::uint64_t map_budget_bytes() {
  const std::uint64_t memory = physical_memory_bytes();
  return memory == 0 ? std::uint64_t{1} << 32U : memory / 4;
}

bool starts_with(std::span<const std::byte> bytes, std::string_view magic) {
  return std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()).starts_with(magic);
}

void take_exr(const std::filesystem::path& path, EnvironmentMap& map) {
  const Image image = read_exr_within(path, map_budget_bytes());
  const auto* y = image.plane("Y");
  const auto *r = image.plane("R"), *g = image.plane("G"), *b = image.plane("B");
  if (r == nullptr || g == nullptr || b == nullptr) {
    if (y == nullptr) throw InputError("has neither channels R, G, B nor Y; save it as RGB");
    r = g = b = y;
  }
  map.width = image.width;
  map.height = image.height;
  map.radiance.resize(r->size());
  for (std::size_t i = 0; i < map.radiance.size(); ++i) map.radiance[i] = {(*r)[i], (*g)[i], (*b)[i]};
}

constexpr float kBrightest = 1e30F;  // of one texel; sums and products of more would overflow

// One texel that is not finite would reach every pixel, and a negative one has no probability to be chosen by.
void make_legal(const std::string& user, EnvironmentMap& map, std::vector<std::string>& warnings) {
  std::uint64_t not_finite = 0, negative = 0;
  bool black = true;
  for (glm::vec3& texel : map.radiance) {
    const bool sane =
        std::abs(texel.x) <= kBrightest && std::abs(texel.y) <= kBrightest && std::abs(texel.z) <= kBrightest;
    if (!sane) {
      ++not_finite;
      texel = glm::vec3(0.0F);
    } else if (texel.x < 0 || texel.y < 0 || texel.z < 0) {
      ++negative;
      texel = glm::max(texel, glm::vec3(0.0F));
    }
    black = black && texel.x == 0 && texel.y == 0 && texel.z == 0;
  }
  if (not_finite != 0)
    warnings.push_back(fmt::format("{}: {} of {} texels are not finite or beyond {:g} and count as black", user,
                                   not_finite, map.radiance.size(), kBrightest));
  if (negative != 0)
    warnings.push_back(fmt::format("{}: {} of {} texels have negative colours, which count as 0", user, negative,
                                   map.radiance.size()));
  if (black) warnings.push_back(user + ": is black altogether and gives no light");
  if (map.width != std::uint64_t{2} * map.height)
    warnings.push_back(fmt::format("{}: has {} x {} pixels; an equirectangular map is twice as wide as high", user,
                                   map.width, map.height));
}

}  // namespace

std::shared_ptr<const EnvironmentMap> load_environment(const std::filesystem::path& path,
                                                       std::vector<std::string>& warnings) {
  const std::string user = "environment " + in_quotes(path.string());
  auto map = std::make_shared<EnvironmentMap>();
  map->name = path.filename().string();
  try {
    const Bytes file = read_regular_file(path, kMaxFileBytes);
    if (starts_with(file.span(), "\x76\x2f\x31\x01")) {
      take_exr(path, *map);
    } else if (starts_with(file.span(), "#?")) {
      HdrImage image = decode_hdr(file.span(), map_budget_bytes());
      map->width = image.width;
      map->height = image.height;
      map->radiance = std::move(image.rgb);
    } else {
      throw InputError("is neither OpenEXR nor Radiance HDR; convert it to one of them");
    }
  } catch (const InputError& e) {
    throw InputError(user + ": " + e.what());
  } catch (const std::bad_alloc&) {
    throw InputError(user + ": needs more memory than there is; scale it down");
  }
  make_legal(user, *map, warnings);
  return map;
}

std::optional<Environment> read_environment(const Place& owner, const std::filesystem::path& folder, Digest& digest,
                                            Notes& notes) {
  const Json* extras = member(owner.value, "extras");
  const Json* found = extras == nullptr ? nullptr : member(*extras, "environment");
  if (found == nullptr) return std::nullopt;
  const Place environment{.value = *found, .kind = "extras.environment", .parent = &owner};
  check_string(environment, "uri");
  const bool has_radiance = has_numbers(environment, "radiance", 3);
  const Json* uri = member(*found, "uri");
  Environment result;
  if (uri != nullptr) {
    if (has_radiance) notes.warn(environment.label() + ": 'radiance' ignored, the file of 'uri' counts");
    result.scale = as_number(environment, "scale").value_or(1.0);
    if (!(result.scale >= 0)) environment.refuse(fmt::format("'scale' {:g} is negative", result.scale));
    result.rotation_rad = as_number(environment, "rotate").value_or(0.0) * std::numbers::pi / 180.0;
    std::vector<std::string> warnings;
    try {
      const std::filesystem::path file = resolve_uri(folder, uri->get_ref<const std::string&>());
      digest.add(read_regular_file(file, kMaxFileBytes).span());
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
    const double value = (*found)["radiance"][static_cast<std::size_t>(c)].get<double>();
    if (!(value >= 0 && value <= static_cast<double>(std::numeric_limits<float>::max()))) {
      environment.fail(fmt::format("radiance {:g} is negative or beyond single precision", value));
    }
    result.radiance[c] = static_cast<float>(value);
  }
  return result;
}

}  // namespace eikon
