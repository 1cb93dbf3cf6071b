// SPDX-License-Identifier: Apache-2.0
#include "view/server/start_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <thread>

#include "core/error.h"

namespace eikon {
namespace {

/// Holds the settings with which a child is started, and frees them at the end.
struct SpawnSettings {
  posix_spawn_file_actions_t files{};
  posix_spawnattr_t attributes{};

  SpawnSettings() {
    posix_spawn_file_actions_init(&files);
    posix_spawnattr_init(&attributes);
    // This process blocks signals in all threads but one; a child must receive them.
    sigset_t none;
    sigemptyset(&none);
    posix_spawnattr_setsigmask(&attributes, &none);
    sigset_t usual;
    sigemptyset(&usual);
    sigaddset(&usual, SIGPIPE);
    posix_spawnattr_setsigdefault(&attributes, &usual);
    // The child is in a group of its own: Ctrl-C in the terminal ends this process, which then ends
    // the child.
    posix_spawnattr_setpgroup(&attributes, 0);
    posix_spawnattr_setflags(&attributes,
                             short(POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP));
    posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  }
  ~SpawnSettings() {
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;
};

/// Returns 0, or an error number.
int spawn(const std::string& program, const std::vector<std::string>& words, SpawnSettings& settings, pid_t& process) {
  // Sockets of the server are not closed on exec by the library that makes them.
  posix_spawn_file_actions_addclosefrom_np(&settings.files, STDERR_FILENO + 1);
  std::vector<std::string> copy = words;
  std::vector<char*> arguments;
  for (std::string& word : copy) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  return posix_spawnp(&process, program.c_str(), &settings.files, &settings.attributes, arguments.data(), environ);
}

}  // namespace

StartedProcess start_process(const std::string& program, const std::vector<std::string>& words) {
  std::array<int, 2> output{}, messages{};
  if (pipe2(output.data(), O_CLOEXEC) != 0)
    throw InputError(fmt::format("{}: cannot be started: {}", program, std::strerror(errno)));
  if (pipe2(messages.data(), O_CLOEXEC) != 0) {
    for (const int file : output) close(file);
    throw InputError(fmt::format("{}: cannot be started: {}", program, std::strerror(errno)));
  }
  SpawnSettings settings;
  posix_spawn_file_actions_adddup2(&settings.files, output[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&settings.files, messages[1], STDERR_FILENO);
  StartedProcess started{.process = 0, .output = output[0], .messages = messages[0]};
  const int error = spawn(program, words, settings, started.process);
  close(output[1]);
  close(messages[1]);
  if (error == 0) return started;
  close(output[0]);
  close(messages[0]);
  throw InputError(fmt::format("{}: cannot be started: {}", program, std::strerror(error)));
}

bool open_in_browser(const std::string& file) {
  SpawnSettings settings;
  for (const int stream : {STDOUT_FILENO, STDERR_FILENO})
    posix_spawn_file_actions_addopen(&settings.files, stream, "/dev/null", O_WRONLY, 0);
  pid_t process = 0;
  if (spawn("xdg-open", {"xdg-open", file}, settings, process) != 0) return false;
  // Some browsers stay in the foreground; nobody waits for them but this thread.
  std::thread([process] { (void)waitpid(process, nullptr, 0); }).detach();
  return true;
}

}  // namespace eikon
