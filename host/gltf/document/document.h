// SPDX-License-Identifier: Apache-2.0
// The boundary to tinygltf.
//
// Who checks what. tinygltf 2.7 reads JSON into structs; it does not check ranges, follows URIs anywhere, hands
// unchecked bytes to image decoders and recurses as deep as the file nests. So it gets neither the file nor its
// buffers, but a document that source_file, json_text, document_check and accessor_table have been through, reduced to
// what the loader reads from it: scenes, nodes, meshes and cameras. Bytes are read through `Accessor` only.
#pragma once
#include "io/json_text.h"

// The same in every file that sees its classes: no images, no files.
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#include <tiny_gltf.h>

namespace eikon {

/// throws InputError with tinygltf's words
tinygltf::Model parse_structure(const Json& checked_document);

}  // namespace eikon
