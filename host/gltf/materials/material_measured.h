// SPDX-License-Identifier: Apache-2.0
// Materials by a file of measurements: EIKON_materials_measured.
#pragma once
#include <filesystem>
#include <map>
#include <memory>
#include <string>

#include "io/xxhash64.h"
#include "scene/measured_table.h"
#include "io/json_text.h"
#include "scene/notes.h"
#include "scene/scene.h"

namespace eikon {

inline constexpr const char* kMeasuredExtension = "EIKON_materials_measured";

/// Reads the tables of materials that are used, each file once.
class MeasuredReader {
 public:
  /// Reads files in `folder` only, and adds them to `digest`.
  MeasuredReader(std::filesystem::path folder, Digest& digest, Notes& notes)
      : folder_(std::move(folder)), digest_(digest), notes_(notes) {}

  /// Gives a checked material its table; does nothing if it names none or is unlit. A table that
  /// reflects more light than arrives is named in the notes.
  /// throws InputError with the material: a URI that may not be followed, a file that is missing or
  ///        no MERL table
  void complete(const JsonView& view, Material& material);

 private:
  std::filesystem::path folder_;
  Digest& digest_;
  Notes& notes_;
  std::map<std::filesystem::path, std::shared_ptr<const MeasuredTable>> of_file_;

  std::shared_ptr<const MeasuredTable> read(const std::filesystem::path& file);
};

}  // namespace eikon
