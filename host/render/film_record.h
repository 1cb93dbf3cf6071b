// SPDX-License-Identifier: Apache-2.0
// What a film's sums are of: the text that checkpoints, parts and merged files carry beside them, so that what belongs together
// can be added, and what does not is refused with a reason. Pure.
#pragma once
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "film/film.h"
#include "film/sample_ledger.h"
#include "pack/settings.h"
#include "scene/scene.h"

namespace eikon {

/// Raised whenever the bits of some image change: sums of before and after must not be added. A test keeps the bits of a few
/// images, and fails when they change and this does not.
inline constexpr int kImageVersion = 7;

/// Something that decides the image's bits. name: as in "its NAME is VALUE", on one line, without a colon
struct ImageSetting {
  std::string name, value;
  bool operator==(const ImageSetting&) const = default;
};

/// All that decides the bits of an image's samples, numbers in full. What of them a film holds (crop, range of samples) is none of
/// it, nor is how the work was done.
[[nodiscard]] std::vector<ImageSetting> image_settings(const Scene& scene, const Settings& settings,
                                                       const FilmLayout& layout);

/// Nothing when the two are the same, else the first that differs: "its seed (--seed) is 1, not 0".
[[nodiscard]] std::optional<std::string> difference(const std::vector<ImageSetting>& expected,
                                                    const std::vector<ImageSetting>& found);

struct FilmRecord {
  std::vector<ImageSetting> settings;
  std::set<std::string> arithmetic;              // classes of the devices that the samples are from
  std::set<std::string> layers;                  // of --aov, for the picture of a merged file
  std::map<std::string, std::string> manifests;  // of its mattes, by layer (mattes.h)
  SampleLedger done;
  bool operator==(const FilmRecord&) const = default;
};

[[nodiscard]] std::string to_text(const FilmRecord& record);
/// layout: of the film that the text belongs to. throws InputError: what in the text is wrong, without the file's name
[[nodiscard]] FilmRecord parse_film_record(std::string_view text, const FilmLayout& layout);

}  // namespace eikon
