// SPDX-License-Identifier: Apache-2.0
// Materials by a file of measurements: EIKON_materials_measured.
#pragma once
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>

#include "io/digest.h"
#include "scene/measured_table.h"
#include "gltf/materials/material_factors.h"

namespace eikon {

inline constexpr std::string_view kMeasuredExtension = "EIKON_materials_measured";

/// Whether `extension` is that one; if so its types are checked. throws InputError naming what is wrong with it
bool check_measured(const Place& extension);

/// Takes away what the table stands for in its place. throws InputError beside another extension that does
void read_measured(const Place& place, Material& material);

/// Reads the tables of materials that are used, each file once.
class MeasuredReader {
 public:
  /// Files are those in `folder`, and are added to `digest`.
  MeasuredReader(std::filesystem::path folder, Digest& digest, Notes& notes)
      : folder_(std::move(folder)), digest_(digest), notes_(notes) {}

  /// The table of a checked material; nothing where it names none, or is unlit. A table that gives back more light than arrives is
  /// named in the notes.
  /// throws InputError with the material: a URI that may not be followed, a file that is missing or no MERL table
  void complete(const Place& material_place, Material& material);

 private:
  std::filesystem::path folder_;
  Digest& digest_;
  Notes& notes_;
  std::map<std::filesystem::path, std::shared_ptr<const MeasuredTable>> of_file_;

  std::shared_ptr<const MeasuredTable> read(const std::filesystem::path& file);
};

}  // namespace eikon
