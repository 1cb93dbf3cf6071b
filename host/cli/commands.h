// SPDX-License-Identifier: Apache-2.0
// The subcommands. Each adds itself to the parser; the one that the user names stores what is to run in `chosen`.
#pragma once
#include <CLI/CLI.hpp>
#include <functional>

#include "core/error.h"

namespace eikon {

using Command = std::function<ExitCode()>;

void add_render(CLI::App& app, Command& chosen);
void add_batch(CLI::App& app, Command& chosen);
void add_merge(CLI::App& app, Command& chosen);
void add_info(CLI::App& app, Command& chosen);
void add_devices(CLI::App& app, Command& chosen);
void add_compare(CLI::App& app, Command& chosen);
void add_selftest(CLI::App& app, Command& chosen);
void add_meter(CLI::App& app, Command& chosen);
void add_measure(CLI::App& app, Command& chosen);
void add_bench(CLI::App& app, Command& chosen);

}  // namespace eikon
