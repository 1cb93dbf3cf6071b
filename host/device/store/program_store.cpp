// SPDX-License-Identifier: Apache-2.0
#include "device/store/program_store.h"

#include <CL/cl_ext.h>
#include <dlfcn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <exception>
#include <fmt/format.h>
#include <span>
#include <system_error>
#include <vector>

#include "device/store/pocl_binary.h"
#include "io/atomic_file.h"
#include "io/source_file.h"
#include "io/xxhash64.h"

namespace eikon {
namespace {

constexpr const char* kOneVariant = "POCL_WORK_GROUP_SPECIALIZATION";
// PoCL allocates so much for a binary, whatever its size, and does not look whether it got it.
constexpr std::size_t kMaxBytes = std::size_t{256} << 20;
constexpr std::uintmax_t kMaxBytesOfAll = std::uintmax_t{512} << 20;  // some 2,000 programs
constexpr std::uintmax_t kMinFreeBytes = std::uintmax_t{1} << 20;     // that one program may take while it is compiled

std::uint64_t hash_of_text(std::string_view text, std::uint64_t seed) {
  return xxhash64(std::as_bytes(std::span(text)), seed);
}

std::string checksum_of(std::string_view head, std::string_view binary) {
  const std::uint64_t sum = hash_of_text(binary, hash_of_text(head, 0));
  return {reinterpret_cast<const char*>(&sum), sizeof sum};
}

std::string variable(const char* name) {
  const char* const value = std::getenv(name);
  return value == nullptr ? "" : value;
}

/// The folder in which PoCL puts what it compiles, even if it is to keep none of it, by its own
/// rule. None: the one for temporary files.
std::optional<std::filesystem::path> pocl_folder() {
  if (const std::string folder = variable("POCL_CACHE_DIR"); !folder.empty()) return folder;
  if (const std::string caches = variable("XDG_CACHE_HOME"); !caches.empty())
    return std::filesystem::path(caches) / "pocl/kcache";
  if (const std::string home = variable("HOME"); !home.empty())
    return std::filesystem::path(home) / ".cache/pocl/kcache";
  return {};
}

/// The folder in which PoCL keeps what it compiles. None: it keeps nothing, or only in the folder
/// for temporary files.
std::optional<std::filesystem::path> pocl_cache_folder() {
  if (const std::string wanted = variable("POCL_KERNEL_CACHE"); !wanted.empty() && wanted[0] != '1') return {};
  return pocl_folder();
}

/// As folder_of_running_pocl(), but even if PoCL keeps nothing.
const std::optional<std::filesystem::path>& folder_where_pocl_compiles() {
  static const std::optional<std::filesystem::path> folder = pocl_folder();
  return folder;
}

/// Size and date of the driver's library: a package can be built again under the version of the one
/// before.
std::string library_of(cl_platform_id platform) {
  const void* const function = clGetExtensionFunctionAddressForPlatform(platform, "clIcdGetPlatformIDsKHR");
  Dl_info library{};
  struct stat status {};
  if (function == nullptr || dladdr(function, &library) == 0 || stat(library.dli_fname, &status) != 0) return "";
  return fmt::format("{} bytes of {}", status.st_size, status.st_mtime);
}

/// The variables that PoCL reads, in alphabetical order. Some change what it compiles; the others
/// do no harm here.
std::string pocl_variables() {
  std::vector<std::string> set;
  for (char** entry = environ; entry != nullptr && *entry != nullptr; ++entry)
    if (std::string_view(*entry).starts_with("POCL_") && !std::string_view(*entry).starts_with("POCL_CACHE_DIR="))
      set.emplace_back(*entry);
  std::ranges::sort(set);
  return fmt::format("{}", fmt::join(set, "\n"));
}

}  // namespace

StoredProgram::StoredProgram(const std::filesystem::path& folder, const std::string& driver, const std::string& flags,
                             std::string_view text)
    : head_(fmt::format("eikon program 2\n{}\n{}\n{} bytes {:016x} {:016x}\n", driver, flags, text.size(),
                        hash_of_text(text, 1), hash_of_text(text, 2))) {
  file_ = folder / fmt::format("{:016x}", hash_of_text(head_, 0));
}

std::optional<std::string> StoredProgram::find() const try {
  const Bytes bytes = read_regular_file(file_, kMaxBytes);
  const std::string_view all(reinterpret_cast<const char*>(bytes.data.get()), bytes.size);
  if (all.size() <= head_.size() + sizeof(std::uint64_t) || !all.starts_with(head_)) return {};
  const std::string_view sum = all.substr(all.size() - sizeof(std::uint64_t));
  const std::string_view binary = all.substr(head_.size(), all.size() - head_.size() - sum.size());
  if (sum != checksum_of(head_, binary)) return {};
  std::error_code ignored;
  std::filesystem::last_write_time(file_, std::filesystem::file_time_type::clock::now(), ignored);
  return std::string(binary);
} catch (const std::exception&) {
  return {};
}

void StoredProgram::keep(std::string_view binary) const try {
  // The driver runs what the file holds, so the folder is closed to others, as those of PoCL are.
  mkdir(file_.parent_path().c_str(), 0700);
  const std::string sum = checksum_of(head_, binary);
  AtomicFile file(file_);
  for (const std::string_view part : {std::string_view(head_), binary, std::string_view(sum)})
    file.write(part.data(), part.size());
  file.commit();
  forget_oldest(file_.parent_path(), kMaxBytesOfAll);
} catch (const std::exception&) {
  // The program is compiled again the next time.
}

void forget_oldest(const std::filesystem::path& folder, std::uintmax_t most) {
  struct File {
    std::filesystem::file_time_type used;
    std::uintmax_t bytes;
    std::filesystem::path path;
  };
  std::vector<File> files;
  std::uintmax_t bytes = 0;
  std::error_code error;  // of files that another process removes meanwhile, too
  for (std::filesystem::directory_iterator entry(folder, error), end; entry != end; entry.increment(error)) {
    if (!entry->is_regular_file(error)) continue;
    File file{entry->last_write_time(error), 0, entry->path()};
    if (!error) file.bytes = entry->file_size(error);
    if (error) continue;
    bytes += file.bytes;
    files.push_back(std::move(file));
  }
  if (bytes <= most) return;
  std::ranges::sort(files, {}, &File::used);
  for (const File& file : files) {
    if (bytes <= most / 4 * 3) return;
    if (std::filesystem::remove(file.path, error)) bytes -= file.bytes;
  }
}

bool is_pocl(const DeviceInfo& info) { return info.platform == "Portable Computing Language"; }

std::optional<StoredProgram> stored_program(const DeviceInfo& info, cl_device_id device, const std::string& flags,
                                            std::string_view text) {
  if (!is_pocl(info) || variable(kOneVariant) != "0") return {};
  const auto folder = pocl_cache_folder();
  cl_platform_id platform = nullptr;
  clGetDeviceInfo(device, CL_DEVICE_PLATFORM, sizeof platform, &platform, nullptr);
  const std::string library = library_of(platform);
  char version[1024] = "";
  const cl_int code = clGetPlatformInfo(platform, CL_PLATFORM_VERSION, sizeof version, version, nullptr);
  if (!folder || library.empty() || code != CL_SUCCESS) return {};
  const std::string driver =
      fmt::format("{}\n{}\n{}\n{}\n{}\n{}", version, library, info.name, info.version, info.driver, pocl_variables());
  return StoredProgram(*folder / "eikon", driver, flags, text);
}

const std::optional<std::filesystem::path>& folder_of_running_pocl() {
  static const std::optional<std::filesystem::path> folder = pocl_cache_folder();
  return folder;
}

std::optional<std::string> why_pocl_cannot_compile() {
  const std::optional<std::filesystem::path>& folder = folder_where_pocl_compiles();
  if (!folder) return {};
  std::error_code error;
  std::filesystem::path made = std::filesystem::absolute(*folder, error);
  while (!std::filesystem::exists(made, error) && made.has_relative_path()) made = made.parent_path();
  int code = 0;
  if (!std::filesystem::is_directory(made, error))
    code = ENOTDIR;
  else if (access(made.c_str(), W_OK) != 0)
    code = errno;
  else if (std::filesystem::space(made, error).available < kMinFreeBytes && !error)
    code = ENOSPC;
  if (code == 0) return {};
  return fmt::format(
      "PoCL cannot keep compiled kernels in \"{}\": {}; {}set POCL_CACHE_DIR to a folder that you may write to",
      folder->string(), std::generic_category().message(code), code == ENOSPC ? "free some of it, or " : "");
}

void prepare_pocl() {
  setenv(kOneVariant, "0", 0);
  folder_of_running_pocl();
  folder_where_pocl_compiles();
}

std::string program_binary(cl_program program) {
  void* const room = mmap(nullptr, 2 * kMaxBytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (room == MAP_FAILED) return "";
  munmap(room, 2 * kMaxBytes);
  std::size_t size = 0;
  if (clGetProgramInfo(program, CL_PROGRAM_BINARY_SIZES, sizeof size, &size, nullptr) != CL_SUCCESS) return "";
  std::string binary(size, '\0');
  char* data = binary.data();
  if (clGetProgramInfo(program, CL_PROGRAM_BINARIES, sizeof data, &data, nullptr) != CL_SUCCESS) return "";
  return without_bitcode(binary).value_or(binary);
}

bool can_run(std::string_view binary) {
  const auto& folder = folder_of_running_pocl();
  return folder && is_unpacked(binary, *folder);
}

}  // namespace eikon
