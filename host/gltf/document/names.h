// SPDX-License-Identifier: Apache-2.0
#pragma once
#include "io/json_text.h"

namespace eikon {

/// Makes all names of a document printable (io/text.h): of nodes, meshes, materials and so on, and
/// of the parts of extensions. Names reach messages, tables and headers of images, where an escape
/// sequence could rewrite a terminal.
void make_names_printable(Json& document);

}  // namespace eikon
