// SPDX-License-Identifier: Apache-2.0
// Checkpoints as files: what is in them, when there is a new one, and what a render that nothing
// disturbed would have left.
#pragma once
#include <sys/stat.h>
#include <sys/wait.h>

#include <chrono>
#include <thread>

#include "cli/command.h"
#include "film/exr/film_file.h"
#include "image/image.h"
#include "instruments/analytic_scenes.h"
#include "render/film_record.h"

namespace eikon::test {

struct Checkpoint {
  Film film;
  FilmRecord record;
};

/// Reads every number of it, and so its checksum.
inline Checkpoint read_checkpoint(const std::filesystem::path& path) {
  SumsReader reader(path);
  Checkpoint checkpoint{Film(reader.layout()), parse_film_record(reader.record(), reader.layout())};
  reader.add_to(checkpoint.film);
  return checkpoint;
}

/// Whether the process has begun to receive it on a thread of its own; before that the signal would
/// end it.
inline bool listens_to(pid_t process, int signal) {
  const std::string status = read_bytes("/proc/" + std::to_string(process) + "/status");
  const std::size_t at = status.find("SigBlk:");
  return at != std::string::npos && (std::stoull(status.substr(at + 7), nullptr, 16) >> (signal - 1) & 1) != 0;
}

/// Changes with every new file of that name.
inline ino_t identity(const std::filesystem::path& path) {
  struct stat status {};
  return stat(path.c_str(), &status) == 0 ? status.st_ino : 0;
}

inline bool has_ended(pid_t process) {
  siginfo_t info{};
  return waitid(P_PID, id_t(process), &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid != 0;
}

/// Waits for `count` new files of that name, or the end of the process. Returns whether it still
/// runs.
inline bool wait_for_files(pid_t process, const std::filesystem::path& path, int count) {
  ino_t last = identity(path);
  for (int i = 0; i < 120000 && count > 0; ++i) {
    if (has_ended(process)) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    if (const ino_t now = identity(path); now != last && now != 0) {
      last = now;
      --count;
    }
  }
  EXPECT_EQ(count, 0) << "no checkpoint is written";
  return !has_ended(process);
}

/// Never ends by itself; what it has done is finished by a render of few samples more.
inline constexpr const char* kEndless = "--size 64x64 --spp 100000000 --quiet ";

inline std::string just_beyond(const Checkpoint& checkpoint) {
  std::uint64_t end = 0;
  for (const WorkUnit& part : checkpoint.record.sample_set.parts()) end = std::max(end, part.sample_end);
  return "--size 64x64 --quiet --spp " + std::to_string(end + 3) + " ";
}

inline void expect_undisturbed(const Workplace& here, const std::string& flags) {
  ASSERT_TRUE(
      succeeded(here.eikon("render " + scene("cornell.gltf") + " -o whole.exr --checkpoint whole.ckpt.exr " + flags)));
  const Checkpoint expected = read_checkpoint(here / "whole.ckpt.exr"), found = read_checkpoint(here / "c.exr");
  EXPECT_TRUE(same_bits(expected.film, found.film));
  EXPECT_TRUE(expected.record == found.record);
  EXPECT_EQ(read_exr(here / "whole.exr").planes, read_exr(here / "out.exr").planes);
}

}  // namespace eikon::test
