// SPDX-License-Identifier: Apache-2.0
// OpenCL, and the only place that knows it: no cl_* handle is visible outside host/device.
#pragma once
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

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
  bool cycle_counter = false;  // kernels can read the processor's; other drivers end the process that tries
  std::string unusable;        // why it cannot be used (not available, no compiler, ...); empty: it can

  /// Of the whole device's compute units, these are used: compute_units from first_unit on.
  std::uint32_t first_unit = 0, whole_units = 0;
  bool divisible = false;  // the driver makes sub-devices of some compute units
  bool part = false;       // it was asked for as this part of a device
  [[nodiscard]] bool whole() const { return compute_units == whole_units; }
  /// Why there are not more of them, or not more memory; empty: it is the device that has no more.
  std::string units_limit, memory_limit;

  /// What tells the hardware, whatever the driver; empty where the driver does not say.
  std::string pci, uuid;
  std::uint32_t vendor_id = 0;

  std::string selector;          // what --devices takes to choose this one and no other
  std::uint32_t position = 0;    // among those selected
  bool by_name = false;          // selected by name or index, not by its kind: to go without it is a failure
  std::shared_ptr<Fault> fault;  // see fault.h; nothing but in tests
};

/// All devices of all platforms, in the platforms' order. Empty when there is no platform; never throws for that.
/// CPU devices have no more compute units than the process may use (core/host_limits.h), nor than `threads` unless that is 0,
/// and no more memory than it may use.
std::vector<DeviceInfo> list_devices(unsigned threads = 0);

/// The devices that `selection` names, see selection.h. notes: where not null, gets a line for each thing that a user may not expect
/// throws UsageError for what does not parse; DeviceError when there is no platform or device, or when an entry names nothing,
/// with what there is.
std::vector<DeviceInfo> select_devices(const std::string& selection, unsigned threads = 0,
                                       std::vector<std::string>* notes = nullptr);

class Device;

/// Device memory; copies share it, and the last one frees it.
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

/// Names -> buffers and scalars that kernels of one device take their arguments from.
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
  std::string extra_flags = "";  // of the compiler; only tests give any, to stand in for a driver with loose arithmetic
};

/// A transfer under way; see Device::read_later.
class Ticket {
 public:
  struct Impl;

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
  /// Sets one scalar argument for the launches that follow; ignored when the kernel has none of that name.
  void set(const std::string& argument, std::uint32_t value);
  [[nodiscard]] const std::string& name() const;
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

/// An opened device: one context, one in-order queue and, where it has memory of its own, another one for what it reads back beside
/// its work; one profiler. One thread at a time.
class Device {
 public:
  /// throws DeviceError
  explicit Device(const DeviceInfo& info);
  ~Device();
  Device(Device&&) noexcept;
  Device& operator=(Device&&) noexcept;

  [[nodiscard]] const DeviceInfo& info() const;
  [[nodiscard]] Profiler& profiler();

  /// Compiles one text (kernel_text) with our dialect's options. throws DeviceError with the compiler's first error,
  /// the device and the defines. The last few programs are kept: asking for the same again costs nothing.
  Program build(const std::string& text, const ProgramOptions& options);

  /// Uninitialised memory. throws DeviceError saying how much was asked for and what the device has.
  Buffer allocate(std::size_t bytes);
  Buffer upload(const void* data, std::size_t bytes);
  template <class T, class Allocator>
  Buffer upload(const std::vector<T, Allocator>& values) {
    return upload(values.data(), values.size() * sizeof(T));
  }

  /// A buffer that kernels only read, with what is at `data`: that must live, unchanged, as long as the buffer and what runs on
  /// it. CPU devices read a DeviceVector's elements where they are; what other devices have, or has other alignment, is a copy.
  Buffer share(const void* data, std::size_t bytes);

  /// Blocks until everything before it is done, and `data` may be reused.
  void write(const Buffer& buffer, const void* data, std::size_t bytes, std::size_t offset = 0);
  /// Enqueues; `data` must live, untouched, until something that was enqueued later is done.
  void write_later(const Buffer& buffer, const void* data, std::size_t bytes, std::size_t offset = 0);
  void fill_zero(const Buffer& buffer);
  /// Blocks until everything before it is done.
  void read(const Buffer& buffer, void* data, std::size_t bytes, std::size_t offset = 0);
  /// Enqueues; `data` must live, untouched, until wait().
  Ticket read_later(const Buffer& buffer, void* data, std::size_t bytes, std::size_t offset = 0);
  /// The same; where the device has memory of its own, what is enqueued later does not wait for it, and must not write to `buffer`
  /// before wait().
  Ticket read_beside(const Buffer& buffer, void* data, std::size_t bytes, std::size_t offset = 0);
  /// The profile then holds everything up to it, and nothing that was enqueued later.
  void wait(const Ticket& ticket);
  template <class T>
  std::vector<T> read_all(const Buffer& buffer) {
    std::vector<T> out(buffer.size_bytes() / sizeof(T));
    read(buffer, out.data(), out.size() * sizeof(T));
    return out;
  }

  /// The next launch begins a work unit of so many paths; only planned faults (fault.h) count them.
  void begin_unit(std::uint64_t paths);
  /// Launches `groups` work-groups of `local` work-items (offset zero, fixed local size). `items` is for the profile.
  /// throws DeviceError
  void run(const Kernel& kernel, std::size_t groups, std::size_t local, std::uint64_t items = 0);
  void flush();
  /// Blocks until everything is done. throws DeviceError
  void finish();
  /// The same without a word: for destructors, before memory that commands use is freed.
  void drain() noexcept;

  struct Impl;

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace eikon
