// SPDX-License-Identifier: Apache-2.0
// The result of a pilot on disk (--pilot): what it learned and what was decided, for other renders
// of the same image.
//
// A text and tables. The text has a line for each setting of the image that the pilot depends on,
// as the record of a film has them (film_record.h), and a line for each figure; an empty line ends
// it. The tables follow as 32-bit words with the lowest byte first: the aim of light paths
// (guide/light_aim.h), if there is one, and the slots and cells of guiding (guide/guide_table.h).
// Then comes the xxHash64 of everything before it.
#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "render/film_record.h"
#include "render/pilot/pilot.h"

namespace eikon {

/// The settings that decide the pilot of an image: all but those that choose samples.
[[nodiscard]] std::vector<ImageSetting> pilot_settings_of(const Scene& scene, Settings settings,
                                                          const FilmLayout& layout);

[[nodiscard]] std::string to_bytes(const Pilot& pilot, const std::vector<ImageSetting>& settings);
/// settings: of the image that is to be rendered
/// throws InputError that states the fault, or what differs, without the file's name
[[nodiscard]] Pilot parse_pilot(std::string_view bytes, const std::vector<ImageSetting>& settings);

/// throws InputError
void write_pilot(const std::filesystem::path& file, const Pilot& pilot, const std::vector<ImageSetting>& settings);
/// throws InputError, also when the file is damaged or of another image, and names what differs
[[nodiscard]] Pilot read_pilot(const std::filesystem::path& file, const std::vector<ImageSetting>& settings);

}  // namespace eikon
