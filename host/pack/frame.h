// SPDX-License-Identifier: Apache-2.0
// The record of a unit that says what the camera sees.
#pragma once
#include "pack/pack.h"

namespace eikon {

/// Fills in camera, environment and bounds. The fields that differ from unit to unit are left 0.
[[nodiscard]] Frame pack_frame(const PackedScene& packed, const Settings& settings);

/// EK_CAMERA_POSE_WORDS for each of Settings::camera_poses, as kernels/film/camera.h reads them;
/// behind them, for the layer `motion`, the camera's EK_MOTION_CAMERA_WORDS in this frame and in
/// the next one (kernels/film/motion_vector.h).
[[nodiscard]] std::vector<float> camera_pose_words(const PackedScene& packed, const Settings& settings);

/// The frame of a unit with these samples of each of its pixels.
[[nodiscard]] Frame unit_frame(Frame frame, std::uint64_t sample_begin, std::uint64_t sample_end,
                               std::uint32_t pixel_count);
/// Sets what the kernels need to know of the table that guides paths.
void set_guide(Frame& frame, const GuideTable& guide);

}  // namespace eikon
