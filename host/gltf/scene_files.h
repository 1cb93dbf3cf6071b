// SPDX-License-Identifier: Apache-2.0
// Which files a scene names, found without building it.
#pragma once
#include <cstddef>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace eikon {

/// What the document of a scene in `folder` names, wherever it stands, whether it is there or not: URI -> file. What the loader
/// refuses, or has no need of a file for, is left out, and so is all of a document that is broken.
/// document  the bytes of the scene's file
/// is_glb    its name says so
[[nodiscard]] std::map<std::string, std::filesystem::path> named_files(const std::filesystem::path& folder,
                                                                       std::span<const std::byte> document,
                                                                       bool is_glb);

/// The scene's own file and all that it names; just the former when it cannot be read, which is for the loader to say. Of a .glb only the
/// document is read.
[[nodiscard]] std::vector<std::filesystem::path> scene_files(const std::filesystem::path& scene);

}  // namespace eikon
