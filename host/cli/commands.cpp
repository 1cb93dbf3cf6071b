// SPDX-License-Identifier: Apache-2.0
#include "cli/commands.h"

#include "cli/flags.h"

namespace eikon {

void add_commands(CommandFlags& root, Command& chosen) {
  for (const auto add : {add_render, add_batch, add_merge, add_info, add_devices, add_compare, add_selftest, add_meter,
                         add_measure, add_report})
    add(root, chosen);
  if constexpr (EIKON_VIEW != 0) add_view(root, chosen);
  for (const auto add : {add_bench, add_completion, add_man}) add(root, chosen);
}

std::string root_footer() {
  return "Example:\n  eikon render scenes/cornell.gltf -o cornell.exr --png cornell.png --spp 256\n\n"
         "Exit codes: 0 done, 1 done but not as asked, 2 usage, 3 input, 4 device, 5 internal, 130 interrupted, 143 "
         "terminated; --frames ends with the code of all frames if they all fail with the same one.\n\n" +
         environment_help();
}

CommandHelp describe_commands() {
  Command none;
  return describe_command_line(root_footer(), [&](CommandFlags root) { add_commands(root, none); });
}

}  // namespace eikon
