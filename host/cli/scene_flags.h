// SPDX-License-Identifier: Apache-2.0
// The flags that say what is rendered and from where; most commands share them.
#pragma once
#include <string>

#include "cli/command_flags.h"
#include "job/scene_options.h"

namespace eikon {

// These add flags to a command; `options` must live as long as the parser.
/// Adds the scene file, and how strictly it is read.
void add_scene_flags(CommandFlags& flags, SceneOptions& options);
/// Adds the camera, the picture and its layers.
void add_image_flags(CommandFlags& flags, SceneOptions& options);
/// Adds the environment, and how paths find light. spp_about: the text of --spp in --help
void add_light_flags(CommandFlags& flags, SceneOptions& options, const std::string& spp_about);
/// Adds all of these.
void add_all_scene_flags(CommandFlags& flags, SceneOptions& options);

}  // namespace eikon
