// SPDX-License-Identifier: Apache-2.0
// EXT_mesh_gpu_instancing: a mesh at many places, from accessors.
#pragma once
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "gltf/document/accessor_table.h"
#include "io/json_text.h"

namespace eikon {

/// Checks the shape of the extension in a node that may have it. throws InputError
void check_instancing(const JsonView& node, std::size_t accessor_count);

/// True if a node of the checked document has the extension.
[[nodiscard]] bool has_instances(const JsonView& node);
/// The transforms, relative to a node of the checked document, at which its mesh stands; nothing if
/// the node does not have the extension. throws InputError: types or counts that do not fit, values
/// that are not finite, a rotation of length 0
[[nodiscard]] std::optional<std::vector<glm::dmat4>> read_instances(const JsonView& node,
                                                                    const AccessorTable& accessors);

}  // namespace eikon
