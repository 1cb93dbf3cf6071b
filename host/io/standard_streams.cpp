// SPDX-License-Identifier: Apache-2.0
#include "io/standard_streams.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>

namespace eikon {
namespace {

bool output_was_closed = false;

}  // namespace

void open_standard_streams() {
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream) {
    if (fcntl(stream, F_GETFD) >= 0 || errno != EBADF) continue;
    if (stream == STDOUT_FILENO) output_was_closed = true;
    (void)!open("/dev/null", O_RDWR);  // takes the lowest free number
  }
}

bool standard_output_was_closed() { return output_was_closed; }

}  // namespace eikon
