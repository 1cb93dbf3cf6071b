// SPDX-License-Identifier: Apache-2.0
// Exit codes leave the process here; core/error.h lists them.
#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <exception>
#include <new>

#include "cli/commands.h"
#include "cli/flags.h"
#include "job/log.h"
#include "core/lost_threads.h"
#include "io/text.h"

namespace {

int report(eikon::ExitCode code, const std::string& message) {
  eikon::print_to_stderr("eikon: {}\n", eikon::printable(eikon::one_line(message)));  // names of files may hold anything
  return int(code);
}

int run(int argc, char** argv) {
  const std::string footer =
      "Example:\n  eikon render scenes/cornell.gltf -o cornell.exr --png cornell.png --spp 256\n\n"
      "Exit codes: 0 done, 1 done but not as asked, 2 usage, 3 input, 4 device, 5 internal, 130 interrupted, 143 "
      "terminated.\n\n" +
      eikon::environment_help();
  eikon::Command chosen;
  const auto code = eikon::parse_command_line(argc, argv, footer, [&](eikon::CommandFlags root) {
    for (const auto add : {eikon::add_render, eikon::add_batch, eikon::add_merge, eikon::add_info, eikon::add_devices,
                           eikon::add_compare, eikon::add_selftest, eikon::add_meter, eikon::add_measure,
                           eikon::add_report, eikon::add_bench})
      add(root, chosen);
  });
  return code ? *code : int(chosen());
}

/// Opens those standard streams that are closed: the next file that the process opens would get
/// their number, and then its messages.
void open_standard_streams() {
  for (int stream = STDIN_FILENO; stream <= STDERR_FILENO; ++stream)
    if (fcntl(stream, F_GETFD) < 0 && errno == EBADF) (void)!open("/dev/null", O_RDWR);  // takes the lowest free number
}

/// Turns success into an error when results did not reach standard output.
int with_results(int code) {
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
  const int failed = report(eikon::ExitCode::input, "cannot write to standard output: is there space where it goes?");
  return code == 0 ? failed : code;
}

}  // namespace

int main(int argc, char** argv) {
  open_standard_streams();
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
