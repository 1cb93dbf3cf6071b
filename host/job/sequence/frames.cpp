// SPDX-License-Identifier: Apache-2.0
#include "job/sequence/frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <utility>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/text.h"
#include "job/render_options.h"

namespace eikon {
namespace {

constexpr std::size_t kMaxDigits = 2;  // of the width

/// Calls `place` with each place of a number, by its begin, its end and its width, from the left.
template <class Place>
void for_each_place(const std::string& name, const Place& place) {
  for (std::size_t begin = name.find('%'); begin != std::string::npos; begin = name.find('%', begin + 1)) {
    std::size_t end = begin + 1;
    while (end < name.size() && end - begin - 1 < kMaxDigits && std::isdigit(static_cast<unsigned char>(name[end])))
      ++end;
    if (end >= name.size() || name[end] != 'd') continue;
    place(begin, end + 1, number_in<std::size_t>(name.substr(begin + 1, end - begin - 1)).value_or(0));
  }
}

/// The flags and names of the files that a render writes, or keeps; empty names are of files that
/// it has not.
std::array<std::pair<const char*, std::string*>, 7> names_of(RenderOptions& options) {
  return {{{"-o", &options.output},
           {"--png", &options.png.file},
           {"--stats", &options.stats},
           {"--profile", &options.profile},
           {"--report", &options.report},
           {"--checkpoint", &options.checkpoint.file},
           {"--pilot", &options.pilot}}};
}

}  // namespace

bool has_number(const std::string& name) {
  bool found = false;
  for_each_place(name, [&](std::size_t, std::size_t, std::size_t) { found = true; });
  return found;
}

std::string numbered(const std::string& name, std::uint64_t frame) {
  std::string result;
  std::size_t done = 0;
  for_each_place(name, [&](std::size_t begin, std::size_t end, std::size_t width) {
    result += name.substr(done, begin - done) + fmt::format("{:0{}}", frame, width);
    done = end;
  });
  return result + name.substr(done);
}

void require_frames_for_force(const RenderOptions& options) {
  if (options.force && !options.frames)
    throw UsageError("--force: goes with --frames; without it every render is made anew");
}

void number_outputs(RenderOptions& options) {
  if (!options.scene.animation.frame) return;
  for (const auto& [flag, name] : names_of(options)) *name = numbered(*name, *options.scene.animation.frame);
}

void require_numbers(const RenderOptions& options) {
  RenderOptions copy = options;
  for (const auto& [flag, name] : names_of(copy)) {
    if (name->empty() || has_number(*name)) continue;
    if (*name == kStandardOutput)
      throw UsageError(fmt::format("--frames writes a file for each frame: {} takes a name such as walk_%04d.exr, not "
                                   "standard output",
                                   flag));
    const std::size_t dot = name->size() - std::filesystem::path(*name).extension().string().size();
    throw UsageError(
        fmt::format("--frames: {} {} has no place for a number, and each frame has a file of its own; "
                    "write {} {}.%04d{}",
                    flag, *name, flag, name->substr(0, dot), name->substr(dot)));
  }
}

}  // namespace eikon
