// SPDX-License-Identifier: Apache-2.0
#include "view/server/final_render.h"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string_view>

#include "core/error.h"
#include "io/text.h"
#include "view/server/start_process.h"

namespace eikon {
namespace {

constexpr std::size_t kLongestMessage = 4096;  // bytes of stderr that are kept, from its end
constexpr int kMaxNames = 10000;

/// "NAME-1" for the first number such that neither NAME-1.exr nor NAME-1.png exists.
std::string free_name(const std::string& name) {
  for (int number = 1; number < kMaxNames; ++number) {
    const std::string stem = fmt::format("{}-{}", name, number);
    if (!std::filesystem::exists(stem + ".exr") && !std::filesystem::exists(stem + ".png")) return stem;
  }
  throw InputError(fmt::format("{}-N.exr: every number up to {} has such a file; move some away", name, kMaxNames));
}

/// Appends what can be read, up to `most` bytes from the end. False at the end of the file.
bool read_some(int file, std::string& text, std::size_t most) {
  std::array<char, 4096> bytes{};
  const ssize_t count = read(file, bytes.data(), bytes.size());
  if (count <= 0) return false;
  text.append(bytes.data(), std::size_t(count));
  if (text.size() > most) text.erase(0, text.size() - most);
  return true;
}

/// The last line that is not empty.
std::string last_line(std::string text) {
  while (text.ends_with('\n')) text.pop_back();
  return one_line(text.substr(text.rfind('\n') + 1));
}

}  // namespace

FinalRender::~FinalRender() {
  stop();
  if (watcher_.joinable()) watcher_.join();
}

void FinalRender::start(std::vector<std::string> words, const std::string& name) {
  const std::lock_guard starting(starting_);
  if (is_running()) throw UsageError("view: a render is running already; stop it, or wait for it");
  if (watcher_.joinable()) watcher_.join();
  const std::string stem = free_name(name);
  words.insert(words.begin(), {"eikon", "render"});
  words.insert(words.end(), {"--output=" + stem + ".exr", "--png=" + stem + ".png", "--progress=openjd"});
  const StartedProcess started = start_process("/proc/self/exe", words);
  const std::lock_guard lock(mutex_);
  process_ = started.process;
  state_ = "running";
  image_ = stem + ".exr";
  png_ = stem + ".png";
  message_.clear();
  share_ = 0;
  stopped_ = false;
  watcher_ = std::thread([this, started] { watch(started.output, started.messages); });
}

void FinalRender::stop() {
  const std::lock_guard lock(mutex_);
  if (process_ == 0) return;
  stopped_ = true;
  (void)kill(process_, SIGTERM);
}

bool FinalRender::is_running() {
  const std::lock_guard lock(mutex_);
  return process_ != 0;
}

Json FinalRender::status() {
  const std::lock_guard lock(mutex_);
  return {{"state", state_}, {"share", share_}, {"image", image_}, {"png", png_}, {"message", message_}};
}

/// Reads what the process writes until it ends.
void FinalRender::watch(int output, int messages) {
  std::string lines, errors;
  std::array<pollfd, 2> files = {pollfd{output, POLLIN, 0}, pollfd{messages, POLLIN, 0}};
  while (files[0].fd >= 0 || files[1].fd >= 0) {
    if (poll(files.data(), files.size(), -1) < 0) continue;
    if (files[0].revents != 0 && !read_some(output, lines, kLongestMessage)) files[0].fd = -1;
    if (files[1].revents != 0 && !read_some(messages, errors, kLongestMessage)) files[1].fd = -1;
    constexpr std::string_view kProgress = "openjd_progress: ";
    const std::size_t at = lines.rfind(kProgress), end = lines.find('\n', at);
    if (at == std::string::npos || end == std::string::npos) continue;
    const auto percent = number_in<double>(lines.substr(at + kProgress.size(), end - at - kProgress.size()));
    const std::lock_guard lock(mutex_);
    share_ = percent.value_or(0) / 100;
  }
  close(output);
  close(messages);
  int status = 0;
  siginfo_t ended{};
  const auto number = id_t(process_);
  while (waitid(P_PID, number, &ended, WEXITED | WNOWAIT) != 0 && errno == EINTR) {
  }
  // Until it is waited for, under the lock, no other process gets its number, to which stop() would
  // send a signal.
  const std::lock_guard lock(mutex_);
  (void)waitpid(process_, &status, 0);
  process_ = 0;
  const bool done = WIFEXITED(status) && WEXITSTATUS(status) == int(ExitCode::done);
  state_ = done ? "done" : stopped_ ? "stopped" : "failed";
  if (!done) message_ = last_line(errors);
}

}  // namespace eikon
