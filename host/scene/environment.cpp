// SPDX-License-Identifier: Apache-2.0
#include "scene/environment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "image/decode_hdr.h"
#include "image/image.h"
#include "io/source_file.h"
#include "io/text.h"

namespace eikon {
namespace {

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

// A texel that is not finite would reach every pixel, and a negative one could not be sampled.
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
    const Bytes file = read_regular_file(path, kMaxEnvironmentFileBytes);
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

}  // namespace eikon
