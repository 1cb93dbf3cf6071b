// SPDX-License-Identifier: Apache-2.0
// Hashes of what a job reads, without building the scene.
#pragma once
#include <filesystem>
#include <string>

#include "io/xxhash64.h"

namespace eikon {

/// The digest of a scene file and every file that it names: buffers, images, the environment.
/// throws InputError if one of them cannot be read; does not check that the scene is valid
[[nodiscard]] Digest digest_scene_files(const std::filesystem::path& scene);
/// throws InputError
[[nodiscard]] Digest digest_file(const std::filesystem::path& path);

/// The digest of the map that --env names, if it names one. throws InputError
[[nodiscard]] Digest digest_environment(const std::string& map);

/// 16 hex digits, the hash of everything that decides a job's outputs: this version of eikon, the
/// files that it reads, and its settings.
/// settings  a text that is the same whenever the settings are
[[nodiscard]] std::string job_key(const Digest& scene, const Digest& environment, const std::string& settings);

}  // namespace eikon
