// SPDX-License-Identifier: Apache-2.0
// The commands. Each adds itself to the parser; the one that the user names sets `chosen`.
#pragma once
#include "cli/command_flags.h"

namespace eikon {

void add_render(CommandFlags& root, Command& chosen);
void add_batch(CommandFlags& root, Command& chosen);
void add_merge(CommandFlags& root, Command& chosen);
void add_info(CommandFlags& root, Command& chosen);
void add_devices(CommandFlags& root, Command& chosen);
void add_compare(CommandFlags& root, Command& chosen);
void add_selftest(CommandFlags& root, Command& chosen);
void add_meter(CommandFlags& root, Command& chosen);
void add_measure(CommandFlags& root, Command& chosen);
void add_report(CommandFlags& root, Command& chosen);
void add_view(CommandFlags& root, Command& chosen);
void add_bench(CommandFlags& root, Command& chosen);
void add_man(CommandFlags& root, Command& chosen);
void add_completion(CommandFlags& root, Command& chosen);
void add_bench_rays(CommandFlags& bench, Command& chosen);  // below `bench`, as the next
void add_bench_scene(CommandFlags& bench, Command& chosen);

/// Adds every command.
void add_commands(CommandFlags& root, Command& chosen);
/// The text behind the list of commands in `eikon --help`: an example, exit codes, and environment
/// variables.
[[nodiscard]] std::string root_footer();
/// The text of --help of all commands.
[[nodiscard]] CommandHelp describe_commands();

}  // namespace eikon
