// SPDX-License-Identifier: Apache-2.0
// The extensions of glTF that eikon reads: one table, which decides what a file may require and
// what is named as left out.
#pragma once
#include <string>

#include "io/json_text.h"
#include "scene/notes.h"

namespace eikon {

/// The objects of a document that extensions extend, as bits.
enum class ExtensionOwner : unsigned {
  none = 0,  // the extension changes a rule of the whole file
  document = 1,
  scene = 2,
  node = 4,
  camera = 8,
  mesh = 16,
  primitive = 32,
  material = 64,
  texture_info = 128,
  buffer_view = 256,
  texture = 512
};

/// "visible": false hides a node and all below it.
inline constexpr const char* kVisibilityExtension = "KHR_node_visibility";

/// The object of extension `name` in `owner`, or null if it has none.
[[nodiscard]] const Json* extension_of(const Json& owner, const char* name);

/// throws InputError for an extension in extensionsRequired that eikon does not read, with what to
///        do about the file
void check_required_extensions(const Json& document);

/// Notes each extension of `owner`, an object of the given kind, that eikon does not read there, as
/// left out of `user`.
void note_unsupported_extensions(const Json& owner, ExtensionOwner kind, const std::string& user, Notes& notes);

}  // namespace eikon
