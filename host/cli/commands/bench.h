// SPDX-License-Identifier: Apache-2.0
// The commands under `bench`.
#pragma once
#include "cli/commands.h"

namespace eikon {

void add_bench_rays(CommandFlags& bench, Command& chosen);
void add_bench_scene(CommandFlags& bench, Command& chosen);

}  // namespace eikon
