// SPDX-License-Identifier: Apache-2.0
// What a job reads, hashed without building the scene.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

namespace eikon {

struct InputsDigest {
  std::uint64_t hash = 0;
  std::uint64_t bytes = 0;
};

/// Of a scene file and every file that it names: buffers, images, the environment; of any other file itself.
/// throws InputError when one of them cannot be read; whether the scene makes sense is not asked
[[nodiscard]] InputsDigest digest_scene_files(const std::filesystem::path& scene);
/// throws InputError
[[nodiscard]] InputsDigest digest_file(const std::filesystem::path& path);

/// 16 hex digits of everything that decides a job's outputs: this version of eikon, what it reads, and its settings.
/// settings  one text, the same whenever the settings are
[[nodiscard]] std::string job_key(const InputsDigest& scene, const InputsDigest& environment,
                                  const std::string& settings);

}  // namespace eikon
