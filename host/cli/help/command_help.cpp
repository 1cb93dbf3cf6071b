// SPDX-License-Identifier: Apache-2.0
#include "cli/help/command_help.h"

namespace eikon {

std::vector<const CommandHelp*> with_all_below(const CommandHelp& command) {
  std::vector<const CommandHelp*> all = {&command};
  for (const CommandHelp& below : command.commands)
    for (const CommandHelp* each : with_all_below(below)) all.push_back(each);
  return all;
}

std::string last_word(const CommandHelp& command) { return command.name.substr(command.name.rfind(' ') + 1); }

}  // namespace eikon
