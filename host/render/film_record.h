// SPDX-License-Identifier: Apache-2.0
// The record of a film: a text in checkpoints, parts and merged files that states the scene,
// settings and samples of the sums beside it. Sums that belong together can be added; others are
// refused with a reason.
#pragma once
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "film/film.h"
#include "film/sample_set.h"
#include "pack/settings.h"
#include "render/film_store.h"
#include "scene/scene.h"

namespace eikon {

struct PilotReport;

/// Raised whenever the bits of some image change, because sums from before and after must not be
/// added. A test holds the bits of a few images, and fails when they change and this does not.
inline constexpr int kImageVersion = 19;

/// A setting that decides the bits of the image.
/// name: as in "its NAME is VALUE", on one line, without a colon
struct ImageSetting {
  std::string name, value;
  bool operator==(const ImageSetting&) const = default;
};

/// Lists every setting that decides the bits of an image's samples, with numbers in full. The crop
/// and the range of samples do not, and neither does the way in which the work was done.
[[nodiscard]] std::vector<ImageSetting> image_settings(const Scene& scene, const Settings& settings,
                                                       const FilmLayout& layout);

/// Returns the first difference, e.g. "its seed (--seed) is 1, not 0", or nothing. A setting that
/// follows from the flag of another one is named only if it differs alone.
[[nodiscard]] std::optional<std::string> difference(const std::vector<ImageSetting>& expected,
                                                    const std::vector<ImageSetting>& found);

/// Holds what the text states of the sums beside it.
struct FilmRecord {
  std::vector<ImageSetting> settings;
  // Arithmetic classes of the devices that rendered the samples.
  std::set<std::string> arithmetic;
  /// Light paths of each sample index, where a trial decided on them. Samples of different counts
  /// must not be added up: each count shares light between camera paths and light paths in its own
  /// way.
  std::set<std::uint64_t> light_path_counts;
  /// The tables that pilots guided samples by: their digests, or "off". Samples of several are
  /// added up without a bias, but the image then has other bits than one that a single pilot
  /// guides.
  std::set<std::string> guiding;
  std::set<std::string> layers;                  // of --aov, for the picture of a merged file
  std::map<std::string, std::string> manifests;  // of its mattes, by layer (film/mattes.h)
  SampleSet sample_set;                          // the samples that are in the sums
  bool operator==(const FilmRecord&) const = default;
};

/// Notes what the pilot decided with the sums that a render begins with. notes: for the user
/// throws InputError when these have another number of light paths, which must not be added up
void agree_on_pilot(FilmState& begin, const Settings& settings, const PilotReport& pilot,
                    std::vector<std::string>& notes);

/// A line for the user if samples are guided in several ways; else empty.
[[nodiscard]] std::string note_of_guiding(const std::set<std::string>& guiding);

[[nodiscard]] std::string to_text(const FilmRecord& record);
/// layout: of the film that the text belongs to
/// throws InputError that states the fault in the text, without the file's name
[[nodiscard]] FilmRecord parse_film_record(std::string_view text, const FilmLayout& layout);

}  // namespace eikon
