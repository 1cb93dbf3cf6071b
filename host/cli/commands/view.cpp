// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>

#include "cli/commands.h"
#include "cli/flags.h"
#include "job/log.h"
#include "job/stop_signals.h"
#include "view/server/redirect_file.h"
#include "view/server/start_process.h"
#include "view/server/view_server.h"

namespace eikon {
namespace {

constexpr ImageSize kUsualSize = {640, 480};

struct ViewOptions {
  RenderOptions render;
  std::uint32_t port = 0;
  bool open = false;
};

/// The words that `eikon render` knows, too. A view is not guided and does not try how many light
/// paths pay, unless that is asked for: a pilot would come before each picture.
std::vector<std::string> render_words(const std::vector<std::string>& words) {
  std::vector<std::string> kept;
  for (const std::string& word : words) {
    const std::string name = word.substr(0, word.find('='));
    if (name != "--port" && name != "--open" && name != "--crop" && name != "--samples") kept.push_back(word);
  }
  if (!has_flag(kept, "--guiding")) kept.emplace_back("--guiding=off");
  if (!has_flag(kept, "--light-paths")) kept.emplace_back("--light-paths=usual");
  return kept;
}

ViewLook first_look(const SceneOptions& scene) {
  const ImageSize size = scene.size.value_or(kUsualSize);
  const std::string text = fmt::format("{}x{}", size.width, size.height);
  if (std::max(size.width, size.height) > kMaxViewSide)
    throw UsageError(
        fmt::format("--size {}: a view has at most {} pixels a side; render the command that its page shows, "
                    "with another --size",
                    text, kMaxViewSide));
  return {.flags = {{"--size", text}}};
}

ExitCode view_command(const ViewOptions& options, const std::vector<std::string>& words) {
  const std::string& scene = options.render.scene.scene;
  if (!std::filesystem::exists(scene)) throw InputError(fmt::format("{}: no such file", scene));
  receive_signals();
  const std::atomic<bool>& stop = catch_stop_signals();
  ViewSession session(render_words(words), parse_render, first_look(options.render.scene));
  ViewServer server(session, int(options.port));
  fmt::print("{}\n", server.address());
  std::fflush(stdout);
  std::optional<RedirectFile> redirect;
  if (options.open && !open_in_browser(redirect.emplace(server.address()).path().string()))
    print_to_stderr("eikon: --open: xdg-open cannot be started; open the address yourself\n");
  server.serve(stop);
  return ExitCode::done;
}

}  // namespace

void add_view(CommandFlags& root, Command& chosen) {
  auto options = std::make_shared<ViewOptions>();
  CommandFlags flags = root.command(
      "view", "show a scene in a browser, and render it anew as the camera moves",
      fmt::format(
          "Prints an address that only this machine can open; from elsewhere, come through ssh -L PORT:localhost:PORT. "
          "The\npicture refines while one looks, and the scene is loaded again when a file of it changes. Ctrl-C ends "
          "it. A picture\nhas no pilot unless --guiding or --light-paths ask for one.\n\n"
          "Example:\n  eikon view scenes/cornell.gltf --open\n\n{}",
          environment_help()));
  add_scene_flags(flags, options->render.scene);
  add_image_flags(flags, options->render.scene, fmt::format("{}x{}", kUsualSize.width, kUsualSize.height));
  add_light_flags(flags, options->render.scene,
                  fmt::format("samples per pixel of the whole picture [{}]", kUsualViewSpp));
  add_shutter_flags(flags, options->render.scene.animation);
  flags.hide({"--crop", "--samples", "--aov", "--transparent"});
  add_execution_flags(flags, options->render.execution);
  flags.group("Server");
  flags.number({"--port", "N", "port of the loopback address [any that is free]"}, options->port, 1, 65535);
  flags.toggle("--open", "open the page in the browser of the desktop", options->open);
  flags.run(chosen, [options](const std::vector<std::string>& words) { return view_command(*options, words); });
}

}  // namespace eikon
