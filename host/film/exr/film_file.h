// SPDX-License-Identifier: Apache-2.0
// Writes a film as an OpenEXR file: the picture and, on request, the exact sums from which the film
// is restored to the bit.
#pragma once
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "film/film.h"
#include "image/image.h"

namespace eikon {

/// A value exceeds the range of half floats; nothing was written.
struct HalfOverflow : InputError {
  using InputError::InputError;
};

struct ExrOptions {
  // R, G, B and layers as half; an error when a value would become infinite.
  bool half = false;
  std::vector<std::string> layers = {};  // of --aov (film/layers.h)
  const Image* denoised = nullptr;  // its R, G, B are written as denoised.R/G/B; null: none
  bool exact_sums = false;          // adds a lossless part with the film's integer sums
  std::map<std::string, std::string> manifests = {};  // of the matte layers (film/mattes.h)
  // For the sums: scene, settings and samples (render/film_record.h)
  std::string record = {};
  // A larger file in a tenth of the time, for one that is soon replaced.
  bool quick = false;
};

/// Writes a film. Part 0, "image", has the crop as its data window, and R, G, B, A (if the film has
/// it; R, G, B are multiplied by it) and the layers as channels. film/layers.h defines the layers:
/// floats, or UINT for integers and sample counts; mattes (exr/mattes.h) are always in full
/// precision. exact_sums adds a part "sums" of UINT channels, from which read_film() restores the
/// film to the bit, and a part "mattes" with the counts of mattes. The same input gives the same
/// bytes.
/// throws InputError when the file cannot be written (disk full, no such folder, a value too large
/// for half), and leaves nothing behind; InternalError for a layer whose channels the film does not
/// have
void write_exr(const std::filesystem::path& path, const Film& film, const Metadata& metadata,
               const ExrOptions& options);

/// The picture that part 0 of the file has, as floats: words are converted, and nothing is rounded
/// to half. throws InternalError as write_exr()
[[nodiscard]] Image image_part(const Film& film, const ExrOptions& options);

/// Reads the "sums" part of a file, a few rows at a time. add_to() verifies its checksum.
class SumsReader {
 public:
  /// throws InputError when the file is not an EXR, is truncated or damaged, has no such part (it
  /// is a plain picture), or has the format of a newer version
  explicit SumsReader(const std::filesystem::path& path);
  ~SumsReader();
  SumsReader(const SumsReader&) = delete;
  SumsReader& operator=(const SumsReader&) = delete;

  [[nodiscard]] const FilmLayout& layout() const;
  [[nodiscard]] const std::string& record() const;  // ExrOptions::record
  /// Adds all sums and counts to a film of the same size, replicates and channels, whose crop
  /// contains the file's. throws InputError when the file is damaged, or a sum leaves the film's
  /// range; the film is then unusable
  void add_to(Film& film);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Reads a whole film. throws as SumsReader
Film read_film(const std::filesystem::path& path);

/// Makes a picture of the means of R, G, B, A (if the film has it) and further channels of the
/// film.
/// throws InternalError when the film lacks one of them
[[nodiscard]] Image to_image(const Film& film, std::span<const std::string_view> further = {});

}  // namespace eikon
