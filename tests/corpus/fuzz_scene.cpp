// SPDX-License-Identifier: Apache-2.0
// Entry point of libFuzzer [https://llvm.org/docs/LibFuzzer.html] for the reader of scenes: each
// input is a .gltf or .glb file that is read, packed and given every tree. An exit code that eikon
// has for bad files is a right answer; a crash, a sanitizer's report, an internal error, a leak, or
// a run out of time or memory (libFuzzer's -timeout and -rss_limit_mb) is a fault.
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "core/error.h"
#include "support/paths.h"
#include "support/temporary_folder.h"

int read_scene(const std::string& path);  // read_scene.cpp

namespace {

/// A folder for the input, with the pictures that shipped scenes name.
const eikon::test::TemporaryFolder& input_folder() {
  static const eikon::test::TemporaryFolder folder;
  static const bool filled = [] {
    for (const auto& entry : std::filesystem::directory_iterator(EIKON_SOURCE_DIR "/scenes")) {
      const std::string ending = entry.path().extension().string();
      if (ending == ".png" || ending == ".hdr") std::filesystem::copy(entry.path(), folder.path());
    }
    return true;
  }();
  static_cast<void>(filled);
  return folder;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bytes(reinterpret_cast<const char*>(data), size);
  const std::filesystem::path file =
      input_folder().write(bytes.starts_with("glTF") ? "input.glb" : "input.gltf", bytes);
  if (read_scene(file) == int(eikon::ExitCode::internal)) std::abort();
  return 0;
}
