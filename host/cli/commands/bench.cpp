// SPDX-License-Identifier: Apache-2.0
#include "cli/commands/bench.h"

namespace eikon {

void add_bench(CLI::App& app, Command& chosen) {
  CLI::App* bench = app.add_subcommand("bench", "how fast this machine's devices are");
  bench->require_subcommand(1);
  bench->footer("Example:\n  eikon bench rays scenes/cornell.gltf --versus embree");
  add_bench_rays(*bench, chosen);
  add_bench_scene(*bench, chosen);
}

}  // namespace eikon
