// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "gltf/document/document.h"
#include "gltf/materials/material_measured.h"
#include "gltf/materials/textures.h"
#include "io/json_text.h"
#include "scene/notes.h"
#include "scene/scene.h"

namespace eikon {

/// Reads the materials of a document, and the textures and tables of those that are used.
class MaterialReader {
 public:
  /// Appends all materials of the checked document to `scene.materials`, which keep their numbers.
  /// Factors outside their legal ranges are brought into them and named in `notes`. All arguments
  /// outlive the reader. A material of which something cannot be read, as a value that single
  /// precision cannot hold, is added to `wrong`, which is the document's.
  MaterialReader(const Document& document, WrongParts& wrong, TextureReader& textures, MeasuredReader& measured,
                 Scene& scene, Notes& notes);

  /// The index in `scene.materials` of material `index` of the document, whose textures and table
  /// are read at its first use, and what is left out of it named in the notes. Without an index it
  /// is glTF's default material, which is appended at its first use: white, metallic and rough
  /// [glTF 2.0, section 3.9].
  /// throws InputError as TextureReader::find and MeasuredReader::complete, and if it is wrong
  std::uint32_t use(std::optional<std::size_t> index);

 private:
  [[nodiscard]] JsonView view_of(std::size_t index) const;
  void read(std::size_t index);
  void note_specular_glossiness();
  void find_textures(const JsonView& view, Material& material);

  const Json& document_;
  WrongParts& wrong_;
  TextureReader& textures_;
  MeasuredReader& measured_;
  Scene& scene_;
  Notes& notes_;
  std::vector<bool> used_;
};

}  // namespace eikon
