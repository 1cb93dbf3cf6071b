// SPDX-License-Identifier: Apache-2.0
// Frames of a sequence, and the names of their files.
#pragma once
#include <cstdint>
#include <string>

namespace eikon {

struct RenderOptions;

/// Frames `first`, `first` + `step`, ... up to `last`, which is one of them if the steps meet it.
struct FrameRange {
  std::uint64_t first = 0, last = 0, step = 1;

  [[nodiscard]] std::uint64_t count() const { return (last - first) / step + 1; }
};

/// True if a name has a place for the number of a frame: "%d", or "%04d" for four digits with zeros
/// in front.
[[nodiscard]] bool has_number(const std::string& name);

/// The name with the number of a frame in its places. A '%' that begins no such place stays.
[[nodiscard]] std::string numbered(const std::string& name, std::uint64_t frame);

/// throws UsageError where --force has nothing that it could mean
void require_frames_for_force(const RenderOptions& options);
/// Puts the number of the frame, if --frame gives one, into the names of the files that a render
/// writes.
void number_outputs(RenderOptions& options);

/// throws UsageError if --frames asks for a file that every frame would write anew
void require_numbers(const RenderOptions& options);

}  // namespace eikon
