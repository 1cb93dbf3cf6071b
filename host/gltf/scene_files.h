// SPDX-License-Identifier: Apache-2.0
// The files that a scene names, found without building it.
#pragma once
#include <cstddef>
#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

namespace eikon {

/// The files that the document of a scene in `folder` names, by their URIs; they need not exist.
/// URIs that the loader refuses or needs no file for are left out, and so is everything if the
/// document is broken.
/// document  the bytes of the scene's file
/// is_glb    its name says so
[[nodiscard]] std::map<std::string, std::filesystem::path> named_files(const std::filesystem::path& folder,
                                                                       std::span<const std::byte> document,
                                                                       bool is_glb);

/// The scene's own file and all that it names; the own file alone if it cannot be read, which is
/// for the loader to report. Only the document of a .glb is read.
[[nodiscard]] std::vector<std::filesystem::path> scene_files(const std::filesystem::path& scene);

}  // namespace eikon
