// SPDX-License-Identifier: Apache-2.0
// Private to host/device: OpenCL handles, and the implementation of the classes in device.h.
#pragma once
#include <CL/cl.h>

#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/device_vector.h"
#include "core/error.h"
#include "device/device.h"
#include "device/store/program_store.h"

namespace eikon {

/// Returns e.g. "CL_OUT_OF_RESOURCES (-5)", for messages.
[[nodiscard]] std::string cl_error_name(cl_int code);
/// throws DeviceError "`what` failed on `device`: name of the code" unless the code is CL_SUCCESS
void cl_check(cl_int code, const std::string& what, const std::string& device);

/// Returns every device of every platform, in the order of list_devices().
std::vector<cl_device_id> enumerate_devices();

template <class Handle, cl_int (*Release)(Handle)>
struct ClRelease {
  using pointer = Handle;
  void operator()(Handle handle) const { Release(handle); }
};
template <class Handle, cl_int (*Release)(Handle)>
using ClOwned = std::unique_ptr<std::remove_pointer_t<Handle>, ClRelease<Handle, Release>>;
using ClDevice = ClOwned<cl_device_id, clReleaseDevice>;  // releasing a whole device does nothing
using ClContext = ClOwned<cl_context, clReleaseContext>;
using ClQueue = ClOwned<cl_command_queue, clReleaseCommandQueue>;
using ClProgram = ClOwned<cl_program, clReleaseProgram>;
using ClKernel = ClOwned<cl_kernel, clReleaseKernel>;
using ClMem = ClOwned<cl_mem, clReleaseMemObject>;
using ClEvent = ClOwned<cl_event, clReleaseEvent>;

/// Finds the device, or creates the sub-device, that `info` describes. throws DeviceError
ClDevice open_device(const DeviceInfo& info);

struct FreeHost {
  void operator()(void* memory) const { free_device_memory(memory); }
};

struct Buffer::Impl {
  // Backing memory on CPU devices, see Device::allocate; released after `mem`.
  std::unique_ptr<void, FreeHost> host;
  ClMem mem;
  std::size_t bytes = 0;
};

struct Ticket::Impl {
  ClEvent event;
  void* data = nullptr;  // destination
  std::size_t bytes = 0;
  std::uint64_t number = 0;  // of the device's commands, in the order of enqueuing
};

struct Program::Impl {
  ClProgram program;
  cl_device_id id = nullptr;  // of the device that it is built for
  std::string device;         // name of it
  // The place to keep the binary in; none: it is there already, or not wanted.
  std::optional<StoredProgram> stored;
  std::set<std::string> not_run;  // kernels that the driver has yet to compile; empty before the first has run

  /// Keeps the binary once each kernel has run.
  void has_run(const std::string& kernel);
};

std::shared_ptr<Program::Impl> build_program(cl_context context, cl_device_id device, const DeviceInfo& info,
                                             const std::string& text, const ProgramOptions& options);

struct Kernel::Impl {
  std::shared_ptr<Program::Impl> program;
  ClKernel kernel;
  std::string name;
  std::vector<std::string> argument_names;
  std::vector<bool> argument_is_buffer;
  std::vector<Buffer> bound;  // keeps the memory alive
  bool launched = false;
};

}  // namespace eikon
