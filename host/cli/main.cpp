// SPDX-License-Identifier: Apache-2.0
// Exit codes leave the process here; core/error.h lists them.
#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <new>

#include "cli/commands.h"
#include "job/log.h"
#include "core/lost_threads.h"
#include "io/standard_streams.h"
#include "io/text.h"

namespace {

int report(eikon::ExitCode code, const std::string& message) {
  // Names of files may hold anything.
  eikon::print_to_stderr("eikon: {}\n", eikon::printable(eikon::one_line(message)));
  return int(code);
}

int run(int argc, char** argv) {
  eikon::Command chosen;
  const auto code = eikon::parse_command_line(argc, argv, eikon::root_footer(),
                                              [&](eikon::CommandFlags root) { eikon::add_commands(root, chosen); });
  return code ? *code : int(chosen());
}

/// True if standard output is a pipe or socket whose other end is closed.
bool nobody_reads() {
  pollfd output{.fd = STDOUT_FILENO, .events = POLLOUT, .revents = 0};
  return poll(&output, 1, 0) > 0 && (output.revents & POLLERR) != 0;
}

/// Turns success into an error when results did not reach standard output.
int with_results(int code) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
  const int failed =
      report(eikon::ExitCode::input,
             fmt::format("cannot write to standard output: {}",
                         nobody_reads() ? "nobody reads it any more (broken pipe)" : "is there space where it goes?"));
  return code == 0 ? failed : code;
}

}  // namespace

int main(int argc, char** argv) {
  eikon::open_standard_streams();
  std::signal(SIGXFSZ, SIG_IGN);  // a write beyond the file size limit (ulimit -f) is an error like any other
  try {
    return eikon::leave_process(with_results(run(argc, argv)));
  } catch (const eikon::Error& error) {
    return eikon::leave_process(report(error.code(), error.what()));
  } catch (const std::bad_alloc&) {
    return eikon::leave_process(report(eikon::ExitCode::internal, "out of memory; try a smaller image or scene"));
  } catch (const std::exception& error) {
    if (std::ferror(stdout) != 0) return eikon::leave_process(with_results(0));  // fmt::print() throws then
    return eikon::leave_process(report(eikon::ExitCode::internal, fmt::format("internal error: {}", error.what())));
  }
}
