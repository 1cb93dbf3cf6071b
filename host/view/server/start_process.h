// SPDX-License-Identifier: Apache-2.0
#pragma once
#include <sys/types.h>

#include <string>
#include <vector>

namespace eikon {

struct StartedProcess {
  pid_t process = 0;
  int output = -1, messages = -1;  // where its stdout and stderr can be read; the caller closes them
};

/// Starts a program without a shell; its stdin is empty, and no file of this process stays open in
/// it.
/// words  its name and arguments
/// throws InputError if it cannot be started
[[nodiscard]] StartedProcess start_process(const std::string& program, const std::vector<std::string>& words);

/// Opens a page in the browser of the desktop, and does not wait for it. False if there is no
/// program for that.
/// file  path of the page; every user of the machine can read this text
[[nodiscard]] bool open_in_browser(const std::string& file);

}  // namespace eikon
