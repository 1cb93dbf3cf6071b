// SPDX-License-Identifier: Apache-2.0
#include "scene/environment/environment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "image/decode_hdr.h"
#include "io/source_file.h"
#include "io/text.h"
#include "scene/environment/cube_map.h"

namespace eikon {
namespace {

std::uint64_t map_budget_bytes() {
  const std::uint64_t memory = usable_memory_bytes();
  return memory == 0 ? std::uint64_t{1} << 32U : memory / 4;
}

bool starts_with(std::span<const std::byte> bytes, std::string_view magic) {
  return std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()).starts_with(magic);
}

HdrImage read_map(const std::filesystem::path& path) {
  {
    const Bytes file = read_regular_file(path, kMaxEnvironmentFileBytes);
    if (starts_with(file.span(), "#?")) return decode_hdr(file.span(), map_budget_bytes());
    if (!starts_with(file.span(), "\x76\x2f\x31\x01"))
      throw InputError("is neither OpenEXR nor Radiance HDR; convert it to one of them");
  }
  // OpenEXR reads the file in pieces, so all of it at once is no longer needed.
  return read_exr_rgb(path, map_budget_bytes());
}

void to_rec709(const std::string& user, HdrImage& image, std::vector<std::string>& warnings) {
  if (!image.primaries || is_rec709(*image.primaries)) return;
  const glm::dmat3 matrix = rec709_from(*image.primaries);
  for (glm::vec3& texel : image.rgb) texel = glm::vec3(matrix * glm::dvec3(texel));
  const Chromaticities& from = *image.primaries;
  warnings.push_back(fmt::format("{}: converted to Rec. 709 from primaries ({:g}, {:g}) ({:g}, {:g}) ({:g}, {:g})",
                                 user, from.red.x, from.red.y, from.green.x, from.green.y, from.blue.x, from.blue.y));
}

void unfold_cube(const std::string& user, HdrImage& image, std::vector<std::string>& warnings) {
  const auto layout = cube_layout(image.width, image.height, image.rgb, image.is_cube);
  if (!layout) return;
  const std::uint32_t side = face_side(*layout, image.width);
  const std::uint64_t needed = std::uint64_t{8} * side * side * sizeof(glm::vec3);
  if (needed > map_budget_bytes())
    throw InputError(
        fmt::format("is a cube map that needs {} MB as an equirectangular one; at most {} MB are for it, "
                    "scale it down",
                    needed >> 20U, map_budget_bytes() >> 20U));
  image.rgb = equirectangular(*layout, image.width, image.rgb);
  image.width = 4 * side;
  image.height = 2 * side;
  warnings.push_back(fmt::format("{}: is a cube map ({}), seen as an equirectangular one of {} x {} pixels", user,
                                 name_of(*layout), image.width, image.height));
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
    HdrImage image = read_map(path);
    to_rec709(user, image, warnings);
    unfold_cube(user, image, warnings);
    map->width = image.width;
    map->height = image.height;
    map->radiance = std::move(image.rgb);
  } catch (const InputError& e) {
    throw InputError(user + ": " + e.what());
  } catch (const std::bad_alloc&) {
    throw InputError(user + ": needs more memory than there is; scale it down");
  }
  make_legal(user, *map, warnings);
  return map;
}

}  // namespace eikon
