// SPDX-License-Identifier: Apache-2.0
// The interface to OpenCL. No cl_* handle is visible outside host/device.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/error.h"
#include "device/profiler.h"

namespace eikon {

class Fault;

struct DeviceInfo {
  std::uint32_t index = 0;  // position in list_devices(), what --devices takes
  std::string name, vendor, driver, platform, version;
  bool cpu = false, gpu = false;
  std::uint32_t compute_units = 0;
  std::uint64_t memory_bytes = 0, max_allocation_bytes = 0;
  std::uint32_t native_float_lanes = 1;
  bool correctly_rounded_divide_sqrt = false, denormals = false;
  // Kernels of one lane divide by kernels/lanes/division.h instead of the driver's operations.
  bool own_division = false;
  // Kernels can read the processor's cycle counter; other drivers end the process that tries.
  bool cycle_counter = false;
  // Why it cannot be used (not available, no compiler, ...); empty: it can.
  std::string unusable;

  /// The compute units of the whole device that are used: compute_units from first_unit on.
  std::uint32_t first_unit = 0, whole_units = 0;
  bool divisible = false;  // the driver makes sub-devices of some compute units
  bool part = false;       // the user asked for this part of a device
  [[nodiscard]] bool whole() const { return compute_units == whole_units; }
  /// The limits that reduce compute units and memory; empty: the device has no more.
  std::string units_limit, memory_limit;

  /// Identify the hardware under any driver; empty when the driver does not state them.
  std::string pci, uuid;
  std::uint32_t vendor_id = 0;

  std::string selector;          // the text for --devices that chooses this device only
  std::uint32_t position = 0;    // among the selected devices
  // Selected by name or index, not by kind; a render without it has failed.
  bool by_name = false;
  std::shared_ptr<Fault> fault;  // see fault.h; null except in tests
  // The times of its commands are wanted (profiler.h). A driver may take longer for a command whose
  // times it notes.
  bool timed = true;
};

/// Returns true if kernels of one lane divide by eikon's own code on a device, as on GPUs that
/// promise no correct rounding, and on Intel's, whose code for it is several times as long. asked:
/// own, driver, or nothing. throws UsageError
[[nodiscard]] bool divides_itself(const DeviceInfo& info, const std::string& asked);

/// Returns all devices of all platforms, in the order of the platforms; the list may be empty. CPU
/// devices have no more compute units and memory than the process may use (core/host_limits.h), and
/// no more units than `threads` unless that is 0.
std::vector<DeviceInfo> list_devices(unsigned threads = 0);

/// Returns the devices that `selection` names (selection.h).
/// notes: unless null, gets a line for everything that a user may not expect
/// throws UsageError for a malformed selection; DeviceError, with a list of the devices, when there
/// is no platform or device, or when an entry names nothing
std::vector<DeviceInfo> select_devices(const std::string& selection, unsigned threads = 0,
                                       std::vector<std::string>* notes = nullptr);

/// A device's compiler does not take the kernels. Another attempt would end alike.
struct CompileError : DeviceError {
  using DeviceError::DeviceError;
};

class Device;

/// Device memory. Copies share it, and the last one frees it.
class Buffer {
 public:
  Buffer() = default;
  [[nodiscard]] std::size_t size_bytes() const;
  [[nodiscard]] explicit operator bool() const { return impl_ != nullptr; }
  struct Impl;

 private:
  friend class Device;
  friend class Kernel;
  std::shared_ptr<Impl> impl_;
};

/// The buffers and scalars from which kernels of one device take their arguments by name.
class Arguments {
 public:
  void set(const std::string& name, Buffer buffer) { buffers_[name] = std::move(buffer); }
  void set(const std::string& name, std::uint32_t value) { scalars_[name] = value; }
  [[nodiscard]] const std::map<std::string, Buffer>& buffers() const { return buffers_; }
  [[nodiscard]] const std::map<std::string, std::uint32_t>& scalars() const { return scalars_; }

 private:
  std::map<std::string, Buffer> buffers_;
  std::map<std::string, std::uint32_t> scalars_;
};

struct ProgramOptions {
  std::map<std::string, std::string> defines;
  bool optimise = true;          // false adds -cl-opt-disable (Oclgrind needs it)
  std::string extra_flags = "";  // tests imitate a driver with loose arithmetic by them
};

/// A transfer that is under way; see Device::read_later().
class Ticket {
 public:
  struct Impl;
  [[nodiscard]] explicit operator bool() const { return impl_ != nullptr; }

 private:
  friend class Device;
  std::shared_ptr<Impl> impl_;
};

/// A kernel with its arguments bound by name. Belongs to one thread.
class Kernel {
 public:
  Kernel() = default;
  /// Takes every argument from `arguments` by the name it has in the kernel's signature.
  /// throws InternalError naming kernel and argument when there is none of that name.
  void bind(const Arguments& arguments);
  /// Sets one scalar argument for the launches that follow, if the kernel has one of that name.
  void set(const std::string& argument, std::uint32_t value);
  [[nodiscard]] const std::string& name() const;
  /// The most work-items that the device can have in a work-group of this kernel. throws
  /// DeviceError
  [[nodiscard]] std::size_t most_work_items() const;
  struct Impl;

 private:
  friend class Device;
  friend class Program;
  std::shared_ptr<Impl> impl_;
};

class Program {
 public:
  /// Kernels of one program that are to run with different arguments must be made separately.
  /// throws InternalError when there is no kernel of that name
  Kernel kernel(const std::string& name) const;
  struct Impl;

 private:
  friend class Device;
  std::shared_ptr<Impl> impl_;
};

/// An open device: one context, one in-order queue and one profiler. A device with memory of its
/// own has a second queue for transfers beside its work. One thread at a time may use it.
class Device {
 public:
  /// throws DeviceError
  explicit Device(const DeviceInfo& info);
  ~Device();
  Device(Device&&) noexcept;
  Device& operator=(Device&&) noexcept;

  [[nodiscard]] const DeviceInfo& info() const;
  [[nodiscard]] Profiler& profiler();

  /// Compiles one text (kernel_text()) with the options of our dialect. The last few programs are
  /// kept, so building one of them again costs nothing.
  /// throws CompileError with the compiler's first error, the device and the defines; DeviceError
  Program build(const std::string& text, const ProgramOptions& options);

  /// Allocates uninitialised memory. throws DeviceError with the size and the memory of the device
  Buffer allocate(std::size_t bytes);
  Buffer upload(const void* data, std::size_t bytes);
  template <class T, class Allocator>
  Buffer upload(const std::vector<T, Allocator>& values) {
    return upload(values.data(), values.size() * sizeof(T));
  }

  /// Makes a buffer that kernels only read. The data must live, unchanged, as long as the buffer
  /// and the commands that use it. CPU devices read the elements of a DeviceVector in place; other
  /// devices, and data of other alignment, get a copy.
  Buffer share(const void* data, std::size_t bytes);

  /// Blocks until everything before it is done and `data` may be reused.
  void write(const Buffer& buffer, const void* data, std::size_t bytes, std::size_t offset = 0);
  /// Enqueues a write; `data` must live, untouched, until a command that was enqueued later is
  /// done.
  void write_later(const Buffer& buffer, const void* data, std::size_t bytes, std::size_t offset = 0);
  void fill_zero(const Buffer& buffer);
  /// Blocks until everything before it is done.
  void read(const Buffer& buffer, void* data, std::size_t bytes, std::size_t offset = 0);
  /// Enqueues a read; `data` must live, untouched, until wait().
  Ticket read_later(const Buffer& buffer, void* data, std::size_t bytes, std::size_t offset = 0);
  /// Like read_later(), but on a device with memory of its own the commands enqueued later do not
  /// wait for it; they must not write to `buffer` before wait().
  Ticket read_beside(const Buffer& buffer, void* data, std::size_t bytes, std::size_t offset = 0);
  /// Returns the first `bytes` of a buffer for the host to read, in place where the device shares
  /// its memory. Blocks until everything before it is done. Commands that write to the buffer may
  /// be enqueued once all copies of the pointer are gone.
  [[nodiscard]] std::shared_ptr<const void> map(const Buffer& buffer, std::size_t bytes);
  /// Blocks until the transfer is done. The profile then has every command of its queue up to it,
  /// and those of the other queue that were enqueued before it and have ended, but none that was
  /// enqueued after it.
  void wait(const Ticket& ticket);
  /// Memory of the host for transfers. A device with memory of its own reads and writes it while
  /// the host goes on; from other memory a driver may copy at once, for which it waits for all that
  /// was enqueued before. It must not outlive the device. throws DeviceError
  [[nodiscard]] std::shared_ptr<std::uint32_t[]> transfer_memory(std::size_t words);
  template <class T>
  std::vector<T> read_all(const Buffer& buffer) {
    std::vector<T> out(buffer.size_bytes() / sizeof(T));
    read(buffer, out.data(), out.size() * sizeof(T));
    return out;
  }

  /// Tells planned faults (fault.h) that the next launch begins a work unit of so many paths.
  void begin_unit(std::uint64_t paths);
  /// Launches `groups` work-groups of `local` work-items (offset zero, fixed local size). `items`
  /// is for the profile.
  /// throws DeviceError
  void run(const Kernel& kernel, std::size_t groups, std::size_t local, std::uint64_t items = 0);
  void flush();
  /// Blocks until everything is done. throws DeviceError
  void finish();
  /// The same without an error: for destructors, before memory that commands use is freed.
  void drain() noexcept;

  struct Impl;

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace eikon
