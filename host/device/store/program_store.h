// SPDX-License-Identifier: Apache-2.0
// Private to host/device: binaries of compiled programs on the disk. PoCL finds what it has
// compiled by a hash of the preprocessed text, and preprocessing takes it four fifths of the time
// in which it opens a program. From a binary it opens the same program without the text.
#pragma once
#include <CL/cl.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "device/device.h"

namespace eikon {

/// The file of one program's binary. It states in full what decides the binary, but for the text,
/// of which it has the length and 128 bits of hashes; and it ends with a checksum. Processes and
/// threads may read and write it at once.
class StoredProgram {
 public:
  /// folder  need not exist; the folder that holds it must
  /// driver  everything but flags and text that decides the binary
  StoredProgram(const std::filesystem::path& folder, const std::string& driver, const std::string& flags,
                std::string_view text);

  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  /// Returns the binary, and notes the time in the file's date. None: there is no such file, it
  /// cannot be read, is damaged, or states another driver, flags or text.
  [[nodiscard]] std::optional<std::string> find() const;
  /// Replaces the file, and removes others if the folder has become large. Where it cannot be
  /// written there is none, or the one before, and no error.
  void keep(std::string_view binary) const;

 private:
  std::filesystem::path file_;
  std::string head_;
};

/// Removes the files of a folder that have not been used for the longest time, if all together have
/// more than `most` bytes, until they have three quarters of that. What cannot be removed stays.
void forget_oldest(const std::filesystem::path& folder, std::uintmax_t most);

[[nodiscard]] bool is_pocl(const DeviceInfo& info);

/// Returns the place of a program in PoCL's cache folder. None: the driver is another one, which
/// has a cache of its own, or PoCL is to keep nothing (POCL_KERNEL_CACHE=0), or to compile more
/// than one variant of each kernel (prepare_pocl()).
std::optional<StoredProgram> stored_program(const DeviceInfo& info, cl_device_id device, const std::string& flags,
                                            std::string_view text);

/// Lets PoCL compile each kernel once, for any size of work-groups, unless the environment says
/// otherwise. That variant is in PoCL's binaries in any case, so it would be compiled beside those
/// for the sizes in use, and it is as fast: work-groups of CPU devices are single work-items. Call
/// it before PoCL is asked for its devices.
void prepare_pocl();

/// Returns the folder in which PoCL keeps what it compiles: it asks the environment once, when it
/// starts, as prepare_pocl() does. None: it keeps nothing.
const std::optional<std::filesystem::path>& folder_of_running_pocl();

/// Says why PoCL cannot write to its folder, without which it finds no device or compiles nothing.
/// None: it can.
std::optional<std::string> why_pocl_cannot_compile();

/// Returns the driver's binary of a built program without what its kernels do not need to run, or
/// "" if the driver gives none. All of the program's kernels must have been run, because PoCL
/// compiles those that were not.
std::string program_binary(cl_program program);

/// Returns whether the kernels of a binary that PoCL has opened can be run.
bool can_run(std::string_view binary);

}  // namespace eikon
