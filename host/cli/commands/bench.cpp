// SPDX-License-Identifier: Apache-2.0
#include "cli/commands.h"

namespace eikon {

void add_bench(CommandFlags& root, Command& chosen) {
  CommandFlags bench = root.command("bench", "measure how fast this machine's devices are",
                                    "Example:\n  eikon bench rays scenes/cornell.gltf --versus embree");
  bench.require_command();
  add_bench_rays(bench, chosen);
  add_bench_scene(bench, chosen);
}

}  // namespace eikon
