// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include "core/error.h"
#include "film/exr/film_file.h"

namespace eikon {

Image to_image(const Film& film, std::span<const std::string_view> further) {
  const Crop& crop = film.layout().crop;
  Image image{
      .width = crop.width(), .height = crop.height(), .channels = {"R", "G", "B"}, .planes = {}, .metadata = {}};
  if (film.channel_index("A")) image.channels.emplace_back("A");
  image.channels.insert(image.channels.end(), further.begin(), further.end());
  for (const std::string& channel : image.channels) {
    const auto found = film.channel_index(channel);
    if (!found) throw InternalError(fmt::format("the film has no channel {}", channel));
    std::vector<float>& plane = image.planes.emplace_back();
    plane.reserve(crop.pixel_count());
    for (std::uint32_t y = crop.y0; y < crop.y1; ++y)
      for (std::uint32_t x = crop.x0; x < crop.x1; ++x) plane.push_back(static_cast<float>(film.mean(x, y, *found)));
  }
  return image;
}

}  // namespace eikon
