// SPDX-License-Identifier: Apache-2.0
// Entry point of libFuzzer [https://llvm.org/docs/LibFuzzer.html] for the reader of scenes: each input is a .gltf or .glb file that
// is read, packed and given every tree. An exit code that eikon has for bad files is a right answer; a crash, a sanitizer's report,
// an internal error, a leak, or a run out of time or memory (libFuzzer's -timeout and -rss_limit_mb) is a fault.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/error.h"
#include "support/paths.h"

int read_scene(const std::string& path);  // read_scene.cpp

namespace {

/// A folder for the input, with the pictures that shipped scenes name. It is removed when the process ends.
class InputFolder {
 public:
  InputFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "eikon_fuzz_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr) fail("cannot make a folder " + name);
    path_ = name;
    for (const auto& entry : std::filesystem::directory_iterator(EIKON_SOURCE_DIR "/scenes")) {
      const std::string ending = entry.path().extension().string();
      if (ending == ".png" || ending == ".hdr") std::filesystem::copy(entry.path(), path_);
    }
  }
  ~InputFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  InputFolder(const InputFolder&) = delete;
  InputFolder& operator=(const InputFolder&) = delete;

  [[nodiscard]] std::string write(const std::uint8_t* data, std::size_t size) const {
    const bool binary = std::string(reinterpret_cast<const char*>(data), std::min<std::size_t>(size, 4)) == "glTF";
    const std::string file = path_ / (binary ? "input.glb" : "input.gltf");
    std::ofstream out(file, std::ios::binary);
    out.write(reinterpret_cast<const char*>(data), std::streamsize(size));
    if (!out.flush()) fail("cannot write " + file);
    return file;
  }

  [[noreturn]] static void fail(const std::string& why) {
    std::fprintf(stderr, "scene_fuzzer: %s\n", why.c_str());
    std::_Exit(1);
  }

 private:
  std::filesystem::path path_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const InputFolder folder;
  if (read_scene(folder.write(data, size)) == int(eikon::ExitCode::internal)) std::abort();
  return 0;
}
