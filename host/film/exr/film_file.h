// SPDX-License-Identifier: Apache-2.0
// A film as an OpenEXR file: the picture and, where asked, the exact sums from which the film is restored to the bit.
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

/// A value that half floats cannot hold; nothing was written.
struct HalfOverflow : InputError {
  using InputError::InputError;
};

struct ExrOptions {
  bool half = false;                // R, G, B and layers as half; refused when a value would become infinite
  std::vector<std::string> layers;  // of --aov (render/layers.h)
  const Image* denoised = nullptr;  // also its R, G, B, as denoised.R/G/B
  bool exact_sums = false;          // second, lossless part with the film's integer sums
  std::map<std::string, std::string> manifests = {};  // of the mattes among the layers (render/mattes.h)
  std::string record = {};  // of that part: a text that says what the sums are of; see render/film_record.h
  bool quick = false;       // for a file that will soon be replaced: larger, and written in a tenth of the time
};

/// Writes the film: part 0 "image" with R, G, B, A if the film has it (R, G, B are multiplied by it), and layers over the crop as data window; with exact_sums a part "sums" of UINT
/// channels, from which read_film restores the film to the bit. Layers are made as render/layers.h says: means over the samples, means
/// over those that hit something (+inf where none did), integers (UINT), the variance of the mean (NaN: unknown), the number of
/// samples (UINT); mattes as cryptomatte.h says, in full precision. With exact_sums their counts are a part "mattes". The same input gives the same bytes.
/// throws InputError when the file cannot be written (disk full, no such folder, a value too large for half), and leaves
/// nothing behind; InternalError for a layer whose channels the film does not have.
void write_exr(const std::filesystem::path& path, const Film& film, const Metadata& metadata,
               const ExrOptions& options);

/// The "sums" part of a file, a few rows in memory at a time. What it says is under a checksum, which add_to verifies.
class SumsReader {
 public:
  /// throws InputError when the file is not an EXR, is truncated or damaged, has no such part (it is a plain picture), or one
  /// in the format of a newer version.
  explicit SumsReader(const std::filesystem::path& path);
  ~SumsReader();
  SumsReader(const SumsReader&) = delete;
  SumsReader& operator=(const SumsReader&) = delete;

  [[nodiscard]] const FilmLayout& layout() const;
  [[nodiscard]] const std::string& record() const;  // ExrOptions::record
  /// Adds all sums and counts to a film of the same size, replicates and channels, within whose crop this one lies.
  /// throws InputError when the file is damaged, and when a sum leaves the film's range; the film is then unusable.
  void add_to(Film& film);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// All of a sums part. throws as SumsReader
Film read_film(const std::filesystem::path& path);

/// The means of R, G, B, of A where the film has it, and of further channels of the film.
/// throws InternalError when the film lacks one of them
[[nodiscard]] Image to_image(const Film& film, std::span<const std::string_view> further = {});

}  // namespace eikon
