// SPDX-License-Identifier: Apache-2.0
// The flags that several commands share: what is rendered and from where, and how the work is done,
// which never changes the image. Those that add flags to a command refer to options, which must
// live as long as the parser.
#pragma once
#include <string>
#include <vector>

#include "cli/command_flags.h"
#include "job/render_options.h"

namespace eikon {

/// Adds the scene file, and how strictly it is read.
void add_scene_flags(CommandFlags& flags, SceneOptions& options);
/// Adds the camera, the picture and its layers. size_default: the text of --size in --help
void add_image_flags(CommandFlags& flags, SceneOptions& options, const std::string& size_default);
/// Adds the environment, and how paths find light. spp_about: the text of --spp in --help
void add_light_flags(CommandFlags& flags, SceneOptions& options, const std::string& spp_about);
/// Adds all of these.
void add_all_scene_flags(CommandFlags& flags, SceneOptions& options);

/// With this name, `bench rays --accel` measures every accelerator.
inline const char* const kEveryAccelerator = "all";

/// The largest number of a frame.
inline constexpr std::uint64_t kMaxFrame = 9'999'999;

/// Adds --instances.
void add_instance_flag(CommandFlags& flags, Execution& execution);
/// Adds --devices, --threads, --memory, --accel, --instances and --layout.
/// probe  --layout also takes kProbeLayouts
/// every  --accel also takes kEveryAccelerator
void add_execution_flags(CommandFlags& flags, Execution& execution, bool probe = false, bool every = false);

/// Lists the environment variables that eikon reads, for the end of --help.
[[nodiscard]] std::string environment_help();

void add_shutter_flags(CommandFlags& flags, AnimationOptions& options);
void add_render_flags(CommandFlags& flags, RenderOptions& options);
/// Adds --png, --exposure, --ev100 and --tonemap.
void add_png_flags(CommandFlags& flags, PngOptions& png);

/// Reads the words that follow `eikon render` on a command line. throws UsageError
[[nodiscard]] RenderOptions parse_render(std::vector<std::string> words);

}  // namespace eikon
