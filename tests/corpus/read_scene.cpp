// SPDX-License-Identifier: Apache-2.0
// What `eikon info SCENE` and `eikon render SCENE` do with a file before they ask for a device:
// read, pack, build every tree.
#include <cstdio>
#include <exception>
#include <new>

#include "accel/accel.h"
#include "core/error.h"
#include "io/text.h"
#include "pack/geometry/instanced_meshes.h"
#include "pack/lights/arriving_light.h"
#include "pack/pack.h"
#include "scene/scene.h"

namespace {

void read_and_pack(const std::string& path) {
  using namespace eikon;
  Scene scene = load_scene(path, {.variant = {}, .animation = {.animation = {}, .time_s = 0.3}});  // between keys
  Settings settings;
  settings.width = 640, settings.height = 480;
  settings.crop = {0, 0, settings.width, settings.height};
  if (scene.cameras.empty()) {
    settings.camera = frame_camera(scene, 4.0 / 3);
  } else {
    settings.camera = scene.cameras.front();
  }
  if (scene.environment) settings.environment = *scene.environment;
  static_cast<void>(arriving_light(scene, settings));
  const Features features = features_of(scene, settings, Execution{}, nullptr);
  PackedScene packed = pack_and_release(scene, features, settings);
  for (const std::string& layout : tree_layouts()) {
    if (features.has(Feature::instance) && !has_two_levels(layout)) continue;
    add_accel(packed, "bvh", layout, 0);
    packed.accels.clear();
  }
}

int refuse(eikon::ExitCode code, const std::string& message) {
  std::fprintf(stderr, "eikon: %s\n", eikon::one_line(message).c_str());
  return int(code);
}

}  // namespace

/// Reads a scene. returns the exit code that eikon would end with, after its line on stderr
int read_scene(const std::string& path) {
  try {
    read_and_pack(path);
    return 0;
  } catch (const eikon::Error& error) {
    return refuse(error.code(), error.what());
  } catch (const std::bad_alloc&) {
    return refuse(eikon::ExitCode::internal, "out of memory");
  } catch (const std::exception& error) {
    return refuse(eikon::ExitCode::internal, error.what());
  }
}
