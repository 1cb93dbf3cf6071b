// SPDX-License-Identifier: Apache-2.0
#include "io/atomic_file.h"

#include <fcntl.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <array>
#include <csignal>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <span>
#include <system_error>

#include <fmt/format.h>

#include "core/error.h"
#include "io/standard_streams.h"
#include "io/text.h"
#include "io/xxhash64.h"

namespace eikon {
namespace {

/// A write beyond the file size limit (ulimit -f) raises SIGXFSZ, which would end the process and
/// leave the temporary file. While this lives, the calling thread alone does not see it, and
/// write() returns EFBIG.
class FileSizeSignalBlocked {
 public:
  FileSizeSignalBlocked() {
    sigemptyset(&signals_);
    sigaddset(&signals_, SIGXFSZ);
    pthread_sigmask(SIG_BLOCK, &signals_, &before_);
  }
  ~FileSizeSignalBlocked() {
    if (sigismember(&before_, SIGXFSZ) == 0) {
      const timespec now{};
      sigtimedwait(&signals_, nullptr, &now);
      pthread_sigmask(SIG_SETMASK, &before_, nullptr);
    }
  }
  FileSizeSignalBlocked(const FileSizeSignalBlocked&) = delete;
  FileSizeSignalBlocked& operator=(const FileSizeSignalBlocked&) = delete;

 private:
  sigset_t signals_{}, before_{};
};

std::string advice(int error) {
  switch (error) {
    case ENOENT:
    case ENOTDIR:
      return "create the folder first";
    case EACCES:
    case EPERM:
    case EROFS:
      return "choose a folder that you may write to";
    case ENOSPC:
    case EDQUOT:
      return "free some space or choose another disk";
    case EFBIG:
      return "raise the file size limit (ulimit -f)";
    default:
      return "choose another path";
  }
}

[[noreturn]] void fail_with(const std::filesystem::path& path, int error) {
  throw InputError(
      fmt::format("cannot write \"{}\": {}: {}", path.string(), std::generic_category().message(error), advice(error)));
}

/// Names the process ids that this process sees: those of one boot of a machine, in one PID
/// namespace. Empty if the kernel does not tell.
const std::string& name_of_process_ids() {
  static const std::string name = [] {
    std::string text;
    std::getline(std::ifstream("/proc/sys/kernel/random/boot_id"), text);
    struct stat ids {};
    if (text.empty() || stat("/proc/self/ns/pid", &ids) != 0) return std::string();
    text += fmt::format(" {}", ids.st_ino);
    return fmt::format("{:016x}", xxhash64(std::as_bytes(std::span(text)), 0));
  }();
  return name;
}

/// The beginning of a file's temporary names, before the process and a number. File names are 255
/// bytes at most. Processes of other machines and containers may write the same file, and have
/// other names.
std::string temporary_prefix(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  return fmt::format(".{}.eikon-{}-", name.substr(0, std::min<std::size_t>(name.size(), 200)), name_of_process_ids());
}

/// Removes temporary files of this file whose process has ended, as far as it may. Processes that
/// it cannot see may live, so their files stay.
void remove_left_behind(const std::filesystem::path& real) {
  if (name_of_process_ids().empty()) return;
  const std::string prefix = temporary_prefix(real);
  std::error_code error;
  const auto folder = real.has_parent_path() ? real.parent_path() : std::filesystem::path(".");
  for (std::filesystem::directory_iterator file(folder, error), end; !error && file != end; file.increment(error)) {
    const std::string name = file->path().filename().string();
    if (!name.starts_with(prefix) || !name.ends_with(".tmp")) continue;
    const std::string process = name.substr(prefix.size(), name.find('-', prefix.size()) - prefix.size());
    const pid_t id = number_in<pid_t>(process).value_or(0);
    if (id <= 0) continue;
    std::error_code ignored;
    if (kill(id, 0) != 0 && errno == ESRCH) std::filesystem::remove(file->path(), ignored);
  }
}

/// Calls see(file) for a path and for all that the links lead to which it names. Returns the last;
/// nothing if there are too many.
template <class See>
std::optional<std::filesystem::path> follow_links(const std::filesystem::path& path, const See& see) {
  constexpr int kMaxLinks = 40;  // as Linux follows
  std::filesystem::path file = path;
  std::error_code error;
  for (int i = 0; i < kMaxLinks; ++i) {
    see(file);
    if (!std::filesystem::is_symlink(file, error)) return file;
    const std::filesystem::path to = std::filesystem::read_symlink(file, error);
    if (error) return file;
    file = file.parent_path() / to;  // which is `to` if that is absolute
  }
  return std::nullopt;
}

/// True if a path leads to an open stream of a process, as /dev/stdout does. It may be a file that
/// others append to, or a pipe.
bool is_stream(const std::filesystem::path& path) {
  bool found = false;
  (void)follow_links(path, [&](const std::filesystem::path& file) {
    std::error_code error;
    const std::filesystem::path folder = std::filesystem::weakly_canonical(file.parent_path(), error);
    found = found || (!error && folder.filename() == "fd" && folder.native().starts_with("/proc/"));
  });
  return found;
}

/// Standard output as it was when a file was first named "-"; what is printed goes to stderr from
/// then on.
int standard_output() {
  static const int kept = [] {
    std::fflush(stdout);
    const int descriptor = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    if (descriptor >= 0) dup2(STDERR_FILENO, STDOUT_FILENO);
    return descriptor;
  }();
  return kept;
}

}  // namespace

std::optional<std::filesystem::path> behind_links(const std::filesystem::path& path) {
  return follow_links(path, [](const std::filesystem::path&) {});
}

AtomicFile::AtomicFile(const std::filesystem::path& path) {
  const std::optional<std::filesystem::path> file = behind_links(path);
  if (!file) fail_with(path, ELOOP);
  path_ = *file;
  if (path == kStandardOutput) {
    if (standard_output_was_closed())
      throw InputError("cannot write to standard output: it is closed; name a file, or start eikon with it open");
    descriptor_ = standard_output() < 0 ? -1 : memfd_create("eikon", MFD_CLOEXEC);
    if (descriptor_ < 0) fail_with(path_, errno);
    return;
  }
  if (is_stream(path))
    throw InputError(
        fmt::format("cannot write \"{}\": it is an open stream, and files are written whole: choose a file, or - for "
                    "standard output",
                    path.string()));
  std::error_code why;
  const auto status = std::filesystem::status(path_, why);
  // The temporary file has a short name, so a name that is too long would be found only when that
  // is renamed.
  if (why == std::errc::filename_too_long) fail_with(path_, ENAMETOOLONG);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
    throw InputError(
        fmt::format("cannot write \"{}\": it exists and is not a regular file: choose another path", path.string()));
  if (!path_.has_filename()) throw InputError(fmt::format("cannot write \"{}\": that is no file name", path.string()));

  remove_left_behind(path_);
  // The id makes the name unique among processes, the counter within this one; O_EXCL guards the
  // rest.
  static std::atomic<unsigned> counter{0};
  for (int attempt = 0; attempt < 100; ++attempt) {
    temporary_ = path_;
    temporary_.replace_filename(fmt::format("{}{}-{}.tmp", temporary_prefix(path_), getpid(), counter++));
    descriptor_ = open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor_ >= 0) return;
    if (errno != EEXIST) break;
  }
  fail_with(path_, errno);
}

AtomicFile::~AtomicFile() {
  if (descriptor_ < 0) return;
  close(descriptor_);
  if (!temporary_.empty()) unlink(temporary_.c_str());
}

void AtomicFile::fail() const { fail_with(path_, error_); }

void AtomicFile::write(const void* data, std::size_t size_bytes) {
  if (error_ != 0) fail();
  const FileSizeSignalBlocked blocked;
  const char* bytes = static_cast<const char*>(data);
  while (size_bytes > 0) {
    const ssize_t written = pwrite(descriptor_, bytes, size_bytes, static_cast<off_t>(position_));
    if (written < 0) {
      if (errno == EINTR) continue;
      error_ = errno;
      fail();
    }
    bytes += written;
    size_bytes -= static_cast<std::size_t>(written);
    position_ += static_cast<std::uint64_t>(written);
  }
}

void AtomicFile::copy_to_standard_output() {
  std::array<char, 1 << 16> buffer{};
  for (off_t at = 0; error_ == 0;) {
    const ssize_t size = pread(descriptor_, buffer.data(), buffer.size(), at);
    if (size == 0) break;
    const ssize_t written = size < 0 ? size : ::write(standard_output(), buffer.data(), std::size_t(size));
    if (written >= 0) at += written;
    else if (errno != EINTR) error_ = errno;
  }
}

void AtomicFile::commit() {
  if (temporary_.empty()) {
    copy_to_standard_output();
    if (error_ != 0) fail();
    return;
  }
  // EINVAL and ENOTSUP mean a file system without fsync; the rename still keeps half-written files
  // out of sight.
  if (error_ == 0 && fsync(descriptor_) != 0 && errno != EINVAL && errno != ENOTSUP) error_ = errno;
  if (error_ == 0 && rename(temporary_.c_str(), path_.c_str()) != 0) error_ = errno;
  if (error_ != 0) fail();
  close(descriptor_);
  descriptor_ = -1;
  // The new name is safe against a power cut once the folder is on the disk; not every file system
  // allows it.
  const auto folder = path_.has_parent_path() ? path_.parent_path() : std::filesystem::path(".");
  const int folder_descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder_descriptor >= 0) {
    static_cast<void>(fsync(folder_descriptor));
    close(folder_descriptor);
  }
}

void write_text(const std::filesystem::path& path, const std::string& text) {
  AtomicFile file(path);
  file.write(text.data(), text.size());
  file.commit();
}

}  // namespace eikon
