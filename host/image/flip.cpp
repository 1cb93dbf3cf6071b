// SPDX-License-Identifier: Apache-2.0
// HDR-FLIP by the Python package flip-evaluator, in a child process without a shell. The images go
// to the child's standard input as raw floats, so neither side depends on what the other can read
// of OpenEXR.
#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <span>

#include <fmt/format.h>

#include "image/image.h"

namespace eikon {
namespace {

constexpr int kPatienceMs = 600'000;
constexpr const char* kProgram = R"(
import sys, numpy, flip_evaluator
width, height = int(sys.argv[1]), int(sys.argv[2])
both = numpy.frombuffer(sys.stdin.buffer.read(), dtype=numpy.float32).reshape(2, height, width, 3)
mean = flip_evaluator.evaluate(both[0].copy(), both[1].copy(), "HDR", applyMagma=False)[1]
print("FLIP", repr(float(mean)))
)";

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

bool write_rgb(std::FILE* file, const Image& image) {
  const std::array<const std::vector<float>*, 3> planes{image.plane("R"), image.plane("G"), image.plane("B")};
  std::vector<float> row(std::size_t{3} * image.width);
  for (std::size_t y = 0; y < image.height; ++y) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      const float value = (*planes[i % 3])[y * image.width + i / 3];
      row[i] = std::isfinite(value) && value > 0 ? value : 0.0f;
    }
    if (std::fwrite(row.data(), sizeof(float), row.size(), file) != row.size()) return false;
  }
  return true;
}

/// What the child prints until it closes its output; nothing when it takes too long.
std::optional<std::string> read_all(int descriptor) {
  std::string text;
  pollfd ready{.fd = descriptor, .events = POLLIN, .revents = 0};
  while (poll(&ready, 1, kPatienceMs) > 0) {
    std::array<char, 4096> buffer{};
    const ssize_t size = read(descriptor, buffer.data(), buffer.size());
    if (size <= 0) return text;
    text.append(buffer.data(), static_cast<std::size_t>(size));
  }
  return std::nullopt;
}

/// Runs `python -c kProgram arguments...` with the file as its input. Nothing when it cannot be
/// started or fails.
std::optional<std::string> run_python(std::FILE* input, std::span<const std::string> arguments) {
  const char* chosen = std::getenv("EIKON_PYTHON");
  std::string python = chosen != nullptr && *chosen != '\0' ? chosen : "python3", option = "-c", program = kProgram;
  std::vector<std::string> words(arguments.begin(), arguments.end());
  std::vector<char*> argv{python.data(), option.data(), program.data()};
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);

  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return std::nullopt;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, fileno(input), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t child = 0;
  const int failed = posix_spawnp(&child, python.c_str(), &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(ends[1]);
  std::optional<std::string> text;
  if (failed == 0) {
    text = read_all(ends[0]);
    if (!text) kill(child, SIGKILL);
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) text.reset();
  }
  close(ends[0]);
  return text;
}

}  // namespace

std::optional<double> flip(const Image& test, const Image& reference) {
  static_cast<void>(compare_images(test, reference));  // refuses what cannot be compared
  const File input(std::tmpfile(), std::fclose);
  if (!input || !write_rgb(input.get(), reference) || !write_rgb(input.get(), test) || std::fflush(input.get()) != 0)
    return std::nullopt;
  std::rewind(input.get());
  const std::array<std::string, 2> size{std::to_string(test.width), std::to_string(test.height)};
  const auto text = run_python(input.get(), size);
  const auto at = text ? text->rfind("FLIP ") : std::string::npos;
  if (at == std::string::npos) return std::nullopt;
  double mean = 0;
  if (std::sscanf(text->c_str() + at, "FLIP %lf", &mean) != 1 || !std::isfinite(mean)) return std::nullopt;
  return mean;
}

}  // namespace eikon
