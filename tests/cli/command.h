// SPDX-License-Identifier: Apache-2.0
// Runs the binary as a user would: by a shell, in a folder of its own.
#pragma once
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/messages.h"
#include "support/paths.h"
#include "support/temporary_folder.h"

namespace eikon::test {

inline constexpr int kUsage = 2, kInput = 3, kDevice = 4;  // exit codes

struct Outcome {
  int code = -1;  // exit code, or 1000 + the signal that ended it
  std::string out, err;
};

inline nlohmann::json read_json(const std::filesystem::path& path) { return nlohmann::json::parse(read_bytes(path)); }

inline std::string scene(const std::string& name) { return std::string(EIKON_SOURCE_DIR) + "/scenes/" + name; }

class Workplace {
 public:
  [[nodiscard]] std::filesystem::path operator/(const std::string& name) const { return folder_ / name; }

  /// Runs `eikon arguments`; `before` is shell text in front of it: variables, `ulimit ...;`,
  /// oclgrind.
  Outcome eikon(const std::string& arguments, const std::string& before = "") const {
    return wait(start(arguments, before));
  }
  Outcome shell(const std::string& line) const { return wait(start_shell(line)); }

  /// Starts it; the process is eikon itself.
  pid_t start(const std::string& arguments, const std::string& before = "") const {
    const bool commands = before.find(';') != std::string::npos;
    return start_shell((commands ? before + " exec " : "exec env " + before + " ") + binary() + " " + arguments);
  }
  pid_t start_shell(const std::string& line) const {
    const std::string in_folder = "cd '" + folder_.path().string() + "' && " + line;
    const pid_t child = fork();
    if (child == 0) {
      redirect(STDIN_FILENO, "/dev/null", O_RDONLY);
      redirect(STDOUT_FILENO, logs_ / "out", O_WRONLY | O_CREAT | O_TRUNC);
      redirect(STDERR_FILENO, logs_ / "err", O_WRONLY | O_CREAT | O_TRUNC);
      execl("/bin/sh", "sh", "-c", in_folder.c_str(), nullptr);
      _exit(127);
    }
    return child;
  }

  Outcome wait(pid_t child) const {
    int status = 0;
    EXPECT_EQ(waitpid(child, &status, 0), child);
    const int code = WIFSIGNALED(status) ? 1000 + WTERMSIG(status) : WEXITSTATUS(status);
    return {code, read_bytes(logs_ / "out"), read_bytes(logs_ / "err")};
  }

  /// Runs `eikon arguments`, which must succeed.
  /// returns  the most bytes that it had in memory at a time
  std::int64_t peak_bytes(const std::string& arguments) const {
    const pid_t child = start(arguments);
    int status = 0;
    rusage usage{};
    EXPECT_EQ(wait4(child, &status, 0, &usage), child);
    EXPECT_EQ(status, 0) << arguments;
    return std::int64_t{usage.ru_maxrss} * 1024;
  }

  /// Names of what lies in the folder, sorted.
  [[nodiscard]] std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
      names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }
  std::filesystem::path write(const std::string& name, const std::string& bytes) const {
    return folder_.write(name, bytes);
  }
  static std::string binary() { return std::string("'") + EIKON_BINARY + "'"; }

 private:
  static void redirect(int descriptor, const std::filesystem::path& path, int flags) {
    const int file = open(path.c_str(), flags, 0600);
    if (file < 0 || dup2(file, descriptor) < 0) _exit(126);
    close(file);
  }

  TemporaryFolder folder_, logs_;
};

/// One line on stderr that begins "eikon: ", nothing on stdout, that exit code.
inline ::testing::AssertionResult refused(const Outcome& outcome, int code) {
  const auto lines = std::count(outcome.err.begin(), outcome.err.end(), '\n');
  if (outcome.code == code && lines == 1 && outcome.err.rfind("eikon: ", 0) == 0 && outcome.out.empty() &&
      outcome.err.size() > 20)
    return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "exit code " << outcome.code << ", stdout '" << outcome.out << "', stderr '"
                                       << outcome.err << "'";
}

inline ::testing::AssertionResult succeeded(const Outcome& outcome) {
  if (outcome.code == 0) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "exit code " << outcome.code << ", stderr '" << outcome.err << "'";
}

/// A render of the Cornell box to out.exr.
inline std::string cornell(const std::string& flags = "--size 16x12 --spp 4 --quiet") {
  return "render " + scene("cornell.gltf") + " -o out.exr " + flags;
}

}  // namespace eikon::test
