// SPDX-License-Identifier: Apache-2.0
// Reads many scenes in child processes. Starting a program with its libraries under sanitizers
// takes several times as long as judging a damaged scene, and so does looking for leaks at its end.
// So the program starts once, and a child reads several scenes.
//   stdin   a line for each child: file for its stdout, file for its stderr, SECONDS that a scene
//           may take, scenes; tabs between them
//   stdout  a line for each when it has ended: how (wait status of wait4(), or -1: killed for want
//           of time), seconds, peak in KB
// Behind what a scene says on stderr the child writes a zero byte, its exit code and seconds, and
// another zero byte. Seconds are of processor time, so that it does not matter what else the
// machine does. A child that waits for something instead of computing is killed when kPatience
// times as many have passed.
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

int read_scene(const std::string& path);  // read_scene.cpp

namespace {

using Clock = std::chrono::steady_clock;
constexpr double kPatience = 20;

double seconds_of(const timeval& time) { return double(time.tv_sec) + 1e-6 * double(time.tv_usec); }

struct Batch {
  std::string out, err;
  double seconds = 0;  // of each scene
  std::vector<std::string> scenes;
};

bool read_batch(std::istream& in, Batch& next) {
  std::string line, seconds;
  if (!std::getline(in, line)) return false;
  std::istringstream fields(line);
  std::getline(fields, next.out, '\t');
  std::getline(fields, next.err, '\t');
  std::getline(fields, seconds, '\t');
  next.seconds = std::strtod(seconds.c_str(), nullptr);
  next.scenes.clear();
  for (std::string scene; std::getline(fields, scene, '\t');) next.scenes.push_back(scene);
  return !next.scenes.empty();
}

void redirect(const std::string& file, int flags, int stream) {
  const int opened = open(file.c_str(), flags, 0600);
  if (opened < 0 || dup2(opened, stream) < 0) std::_Exit(99);
  close(opened);
}

/// Seconds of processor time that this process has taken.
double seconds_taken() {
  rusage usage{};
  if (getrusage(RUSAGE_SELF, &usage) != 0) std::_Exit(99);
  return seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime);
}

[[noreturn]] void run(const Batch& batch, const sigset_t& signals) {
  sigprocmask(SIG_SETMASK, &signals, nullptr);
  redirect("/dev/null", O_RDONLY, STDIN_FILENO);
  redirect(batch.out, O_WRONLY | O_CREAT | O_TRUNC, STDOUT_FILENO);
  redirect(batch.err, O_WRONLY | O_CREAT | O_TRUNC, STDERR_FILENO);
  for (const std::string& scene : batch.scenes) {
    const double begin = seconds_taken();
    rlimit limit{};
    if (getrlimit(RLIMIT_CPU, &limit) != 0) std::_Exit(99);
    limit.rlim_cur = rlim_t(std::ceil(begin + batch.seconds));
    if (setrlimit(RLIMIT_CPU, &limit) != 0) std::_Exit(99);
    const int code = read_scene(scene);
    std::fprintf(stderr, "%c%d %.4f%c", 0, code, seconds_taken() - begin, 0);
  }
  std::exit(0);
}

/// Waits for SIGCHLD, which is blocked, until then. returns whether it came
bool child_ended(Clock::time_point until) {
  sigset_t ended;
  sigemptyset(&ended);
  sigaddset(&ended, SIGCHLD);
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::nanoseconds>(until - Clock::now()).count();
    const timespec most = {left > 0 ? left / 1000000000 : 0, left > 0 ? left % 1000000000 : 0};
    if (sigtimedwait(&ended, nullptr, &most) == SIGCHLD) return true;
    if (errno == EAGAIN) return false;
  }
}

}  // namespace

int main() {
  sigset_t ended, before;
  sigemptyset(&ended);
  sigaddset(&ended, SIGCHLD);
  sigprocmask(SIG_BLOCK, &ended, &before);
  for (Batch next; read_batch(std::cin, next);) {
    const auto patience = std::chrono::duration<double>(kPatience * next.seconds * double(next.scenes.size()));
    const auto until = Clock::now() + std::chrono::duration_cast<Clock::duration>(patience);
    const pid_t child = fork();
    if (child < 0) return 1;
    if (child == 0) run(next, before);
    const bool in_time = child_ended(until);
    if (!in_time) kill(child, SIGKILL);
    int status = 0;
    rusage usage{};
    if (wait4(child, &status, 0, &usage) != child) return 1;
    if (!in_time) child_ended(Clock::now());  // of the one that was killed
    const bool killed = !in_time || (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU);
    const double seconds = seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime);
    std::printf("%d %.4f %ld\n", killed ? -1 : status, seconds, usage.ru_maxrss);
    std::fflush(stdout);
  }
  return 0;
}
