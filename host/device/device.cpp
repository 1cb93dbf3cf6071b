// SPDX-License-Identifier: Apache-2.0
#include "device/device.h"

#include <algorithm>
#include <deque>
#include <fmt/format.h>

#include "device/cl.h"
#include "device/fault.h"

namespace eikon {

std::string cl_error_name(cl_int code) {
  static const std::map<cl_int, const char*> names = {
      {-1, "CL_DEVICE_NOT_FOUND"},
      {-2, "CL_DEVICE_NOT_AVAILABLE"},
      {-3, "CL_COMPILER_NOT_AVAILABLE"},
      {-4, "CL_MEM_OBJECT_ALLOCATION_FAILURE"},
      {-5, "CL_OUT_OF_RESOURCES"},
      {-6, "CL_OUT_OF_HOST_MEMORY"},
      {-11, "CL_BUILD_PROGRAM_FAILURE"},
      {-14, "CL_EXEC_STATUS_ERROR_FOR_EVENTS_IN_WAIT_LIST"},
      {-36, "CL_INVALID_COMMAND_QUEUE"},
      {-38, "CL_INVALID_MEM_OBJECT"},
      {-45, "CL_INVALID_PROGRAM_EXECUTABLE"},
      {-46, "CL_INVALID_KERNEL_NAME"},
      {-48, "CL_INVALID_KERNEL"},
      {-51, "CL_INVALID_ARG_SIZE"},
      {-52, "CL_INVALID_KERNEL_ARGS"},
      {-54, "CL_INVALID_WORK_GROUP_SIZE"},
      {-61, "CL_INVALID_BUFFER_SIZE"},
      {-1001, "CL_PLATFORM_NOT_FOUND_KHR"},
      {-9999, "a kernel used memory that is not its own, by NVIDIA's driver"},
  };
  const auto found = names.find(code);
  return fmt::format("{} ({})", found == names.end() ? "OpenCL error" : found->second, code);
}

void cl_check(cl_int code, const std::string& what, const std::string& device) {
  if (code == CL_SUCCESS) return;
  throw DeviceError(fmt::format("{} failed on device '{}': {}; try another device (--devices) or a smaller image", what,
                                device, cl_error_name(code)));
}

std::size_t Buffer::size_bytes() const { return impl_ ? impl_->bytes : 0; }

struct Device::Impl {
  DeviceInfo info;
  ClDevice handle;
  cl_device_id id = nullptr;  // of handle
  ClContext context;
  ClQueue queue;
  ClQueue beside;  // for transfers beside the work; null: they go through `queue`
  Profiler profiler;
  double clock_offset_s = 0;  // host_seconds() = device timestamp [s] + offset

  struct Pending {
    std::string name;
    ClEvent event;
    std::uint64_t items = 0, bytes = 0;
    std::uint64_t number = 0;                           // of the commands of both queues, in the order of enqueuing
    std::shared_ptr<Program::Impl> first_of = nullptr;  // whose kernel `name` runs for the first time
  };
  // Commands that the profiler has yet to get, of `queue` and of `beside`. Those of a queue end in
  // order.
  std::deque<Pending> pending, pending_beside;
  std::uint64_t enqueued = 0;  // commands of both queues

  // Programs by flags and text, in the order of their last use. Each holds megabytes of the
  // driver's.
  static constexpr std::size_t kPrograms = 16;
  std::deque<std::pair<std::string, std::shared_ptr<Program::Impl>>> programs;

  void check(cl_int code, const std::string& what) const { cl_check(code, what, info.name); }

  /// throws DeviceError when a fault is planned for this call
  void may_fail(Fault::Call call, const std::string& what) const {
    if (info.fault) check(info.fault->at(call), what);
  }

  [[nodiscard]] static double timestamp_s(cl_event event, cl_profiling_info what) {
    cl_ulong nanoseconds = 0;
    clGetEventProfilingInfo(event, what, sizeof nanoseconds, &nanoseconds, nullptr);
    return double(nanoseconds) * 1e-9;
  }

  /// Gives a finished command to the profiler. Returns its seconds; 0 where times are not wanted.
  double count(const Pending& done, bool on_other_queue) {
    if (!info.timed) return profiler.count(done.name, done.items, done.bytes), 0;
    const double begin = timestamp_s(done.event.get(), CL_PROFILING_COMMAND_START);
    const double end = timestamp_s(done.event.get(), CL_PROFILING_COMMAND_END);
    if (on_other_queue)
      profiler.record_beside(done.name, begin + clock_offset_s, end + clock_offset_s, done.bytes);
    else
      profiler.record(done.name, begin + clock_offset_s, end + clock_offset_s, done.items, done.bytes);
    return end - begin;
  }

  /// Records the commands of one queue up to `last`, as far as they have ended. Returns their
  /// seconds.
  double resolve(std::deque<Pending>& from, std::uint64_t last) {
    double busy_s = 0;
    for (; !from.empty() && from.front().number <= last; from.pop_front()) {
      const Pending& front = from.front();
      cl_int status = CL_QUEUED;
      clGetEventInfo(front.event.get(), CL_EVENT_COMMAND_EXECUTION_STATUS, sizeof status, &status, nullptr);
      if (status < 0) check(status, "command '" + front.name + "'");
      if (status != CL_COMPLETE) break;
      busy_s += count(front, &from == &pending_beside);
      if (front.first_of) front.first_of->has_run(front.name);
    }
    return busy_s;
  }
  /// Records all commands that have ended and were enqueued no later than that of the number
  /// `last`. It is called where the host has waited for the device anyway.
  void resolve(std::uint64_t last) {
    const double busy_s = resolve(pending, last) + resolve(pending_beside, last);
    if (info.fault) info.fault->slow_down(busy_s);
  }

  /// Creates buffer.mem, in memory of the host unless `host` is null. throws DeviceError
  void create(Buffer::Impl& buffer, cl_mem_flags flags, void* host) const {
    if (host != nullptr) flags |= CL_MEM_USE_HOST_PTR;
    cl_int code = info.fault ? info.fault->at(Fault::Call::allocate) : CL_SUCCESS;
    if (code == CL_SUCCESS) buffer.mem.reset(clCreateBuffer(context.get(), flags, buffer.bytes, host, &code));
    if (code != CL_SUCCESS)
      throw DeviceError(
          fmt::format("device '{}' cannot allocate {} bytes ({} in one piece, {} in all): {}; try a smaller scene",
                      info.name, buffer.bytes, info.max_allocation_bytes, info.memory_bytes, cl_error_name(code)));
  }

  void track(const char* name, cl_event event, std::uint64_t items, std::uint64_t bytes) {
    pending.push_back({name, ClEvent(event), items, bytes, ++enqueued});
  }

  void enqueue_write(cl_bool blocking, const Buffer& buffer, const void* data, std::size_t bytes, std::size_t offset) {
    may_fail(Fault::Call::transfer, "a transfer to the device");
    cl_event event = nullptr;
    check(clEnqueueWriteBuffer(queue.get(), buffer.impl_->mem.get(), blocking, offset, bytes, data, 0, nullptr, &event),
          "a transfer to the device");
    track("upload", event, 0, bytes);
  }
  Ticket enqueue_read(bool on_other_queue, const Buffer& buffer, void* data, std::size_t bytes, std::size_t offset) {
    may_fail(Fault::Call::transfer, "a transfer from the device");
    // The last command of the work was enqueued after all others of its queue, so they have ended
    // when it has.
    const cl_event before = on_other_queue && !pending.empty() ? pending.back().event.get() : nullptr;
    if (before != nullptr) check(clFlush(queue.get()), "submitting work");
    const cl_command_queue on = on_other_queue ? beside.get() : queue.get();
    cl_event event = nullptr;
    check(clEnqueueReadBuffer(on, buffer.impl_->mem.get(), CL_FALSE, offset, bytes, data, before != nullptr ? 1 : 0,
                              before != nullptr ? &before : nullptr, &event),
          "a transfer from the device");
    Ticket ticket = track_read(event, data, bytes, on_other_queue);
    if (on_other_queue) check(clFlush(on), "submitting work");
    return ticket;
  }
  Ticket track_read(cl_event event, void* data, std::size_t bytes, bool on_other_queue) {
    (on_other_queue ? pending_beside : pending).push_back({"read back", ClEvent(event), 0, bytes, ++enqueued});
    Ticket ticket;
    ticket.impl_ = std::make_shared<Ticket::Impl>();
    ticket.impl_->number = enqueued;
    clRetainEvent(event);
    ticket.impl_->event.reset(event);
    ticket.impl_->data = data;
    ticket.impl_->bytes = bytes;
    return ticket;
  }
};

Device::Device(const DeviceInfo& info) : impl_(std::make_unique<Impl>()) {
  impl_->info = info;
  impl_->may_fail(Fault::Call::open, "opening it");
  impl_->handle = open_device(info);
  impl_->id = impl_->handle.get();
  cl_int code = CL_SUCCESS;
  impl_->context.reset(clCreateContext(nullptr, 1, &impl_->id, nullptr, nullptr, &code));
  impl_->check(code, "creating a context");
  const cl_command_queue_properties properties = info.timed ? CL_QUEUE_PROFILING_ENABLE : 0;
  impl_->queue.reset(clCreateCommandQueue(impl_->context.get(), impl_->id, properties, &code));
  impl_->check(code, "creating a queue");
  if (!info.cpu) {
    impl_->beside.reset(clCreateCommandQueue(impl_->context.get(), impl_->id, properties, &code));
    impl_->check(code, "creating a queue");
  }

  // One small transfer relates the device's clock to the host's.
  const std::uint32_t word = 0;
  ClMem probe(clCreateBuffer(impl_->context.get(), CL_MEM_READ_WRITE, sizeof word, nullptr, &code));
  impl_->check(code, "allocating memory");
  cl_event event = nullptr;
  impl_->check(
      clEnqueueWriteBuffer(impl_->queue.get(), probe.get(), CL_TRUE, 0, sizeof word, &word, 0, nullptr, &event),
      "a transfer");
  const ClEvent owned(event);
  if (info.timed) impl_->clock_offset_s = host_seconds() - Impl::timestamp_s(event, CL_PROFILING_COMMAND_END);
}

Device::~Device() {
  if (impl_ && impl_->queue) drain();
}
Device::Device(Device&&) noexcept = default;
Device& Device::operator=(Device&&) noexcept = default;

const DeviceInfo& Device::info() const { return impl_->info; }
Profiler& Device::profiler() { return impl_->profiler; }

Program Device::build(const std::string& text, const ProgramOptions& options) {
  impl_->may_fail(Fault::Call::transfer, "compiling");
  const double begin = host_seconds();
  std::string key = fmt::format("{}\n{}\n", options.optimise, options.extra_flags);
  for (const auto& [name, value] : options.defines) key += fmt::format("{}={}\n", name, value);
  key += text;
  auto& kept = impl_->programs;
  const auto found = std::find_if(kept.begin(), kept.end(), [&](const auto& known) { return known.first == key; });
  Program program;
  if (found != kept.end()) {
    program.impl_ = found->second;
    kept.erase(found);
  } else {
    program.impl_ = build_program(impl_->context.get(), impl_->id, impl_->info, text, options);
    if (kept.size() == Impl::kPrograms) kept.pop_front();
  }
  kept.emplace_back(std::move(key), program.impl_);
  impl_->profiler.compile_s += host_seconds() - begin;
  return program;
}

Buffer Device::allocate(std::size_t bytes) {
  // The driver would put such a buffer in small pages.
  constexpr std::size_t large = std::size_t{4} << 20;
  Buffer buffer;
  buffer.impl_ = std::make_shared<Buffer::Impl>();
  buffer.impl_->bytes = std::max<std::size_t>(bytes, 4);
  if (impl_->info.cpu && bytes >= large) buffer.impl_->host.reset(allocate_device_memory(bytes));
  impl_->create(*buffer.impl_, CL_MEM_READ_WRITE, buffer.impl_->host.get());
  return buffer;
}

Buffer Device::share(const void* data, std::size_t bytes) {
  const bool aligned = reinterpret_cast<std::uintptr_t>(data) % kDeviceAlignment == 0;
  if (!impl_->info.cpu || !aligned || bytes < 4) return upload(data, bytes);
  Buffer buffer;
  buffer.impl_ = std::make_shared<Buffer::Impl>();
  buffer.impl_->bytes = bytes;
  // The call of OpenCL takes no pointer to const.
  impl_->create(*buffer.impl_, CL_MEM_READ_ONLY, const_cast<void*>(data));
  return buffer;
}

Buffer Device::upload(const void* data, std::size_t bytes) {
  Buffer buffer = allocate(bytes);
  if (bytes > 0) write(buffer, data, bytes);
  return buffer;
}

void Device::write(const Buffer& buffer, const void* data, std::size_t bytes, std::size_t offset) {
  impl_->enqueue_write(CL_TRUE, buffer, data, bytes, offset);
  impl_->resolve(impl_->enqueued);
}

void Device::write_later(const Buffer& buffer, const void* data, std::size_t bytes, std::size_t offset) {
  impl_->enqueue_write(CL_FALSE, buffer, data, bytes, offset);
}

void Device::fill_zero(const Buffer& buffer) {
  const std::uint32_t zero = 0;
  cl_event event = nullptr;
  impl_->check(clEnqueueFillBuffer(impl_->queue.get(), buffer.impl_->mem.get(), &zero, sizeof zero, 0,
                                   buffer.size_bytes() / 4 * 4, 0, nullptr, &event),
               "clearing a buffer");
  impl_->track("clear", event, 0, buffer.size_bytes());
}

void Device::read(const Buffer& buffer, void* data, std::size_t bytes, std::size_t offset) {
  const Ticket ticket = read_later(buffer, data, bytes, offset);
  try {
    wait(ticket);
  } catch (...) {
    drain();  // the read may be under way, and its destination ends with the caller
    throw;
  }
}

Ticket Device::read_later(const Buffer& buffer, void* data, std::size_t bytes, std::size_t offset) {
  return impl_->enqueue_read(false, buffer, data, bytes, offset);
}

Ticket Device::read_beside(const Buffer& buffer, void* data, std::size_t bytes, std::size_t offset) {
  return impl_->enqueue_read(impl_->beside != nullptr, buffer, data, bytes, offset);
}

std::shared_ptr<const void> Device::map(const Buffer& buffer, std::size_t bytes) {
  impl_->may_fail(Fault::Call::transfer, "a transfer from the device");
  const cl_command_queue queue = impl_->queue.get();
  const std::shared_ptr<Buffer::Impl> mapped = buffer.impl_;
  cl_event event = nullptr;
  cl_int code = CL_SUCCESS;
  void* const data =
      clEnqueueMapBuffer(queue, mapped->mem.get(), CL_FALSE, CL_MAP_READ, 0, bytes, 0, nullptr, &event, &code);
  impl_->check(code, "a transfer from the device");
  const Ticket ticket = impl_->track_read(event, data, bytes, false);
  std::shared_ptr<const void> view(
      data, [queue, mapped](void* at) { clEnqueueUnmapMemObject(queue, mapped->mem.get(), at, 0, nullptr, nullptr); });
  wait(ticket);
  return view;
}

std::shared_ptr<std::uint32_t[]> Device::transfer_memory(std::size_t words) {
  if (impl_->info.cpu) return std::make_shared<std::uint32_t[]>(words);
  const auto buffer = std::make_shared<Buffer::Impl>();
  buffer->bytes = 4 * std::max<std::size_t>(words, 1);
  impl_->create(*buffer, CL_MEM_READ_WRITE | CL_MEM_ALLOC_HOST_PTR, nullptr);
  const cl_command_queue queue = impl_->beside.get();  // it is seldom at work
  cl_int code = CL_SUCCESS;
  void* const data = clEnqueueMapBuffer(queue, buffer->mem.get(), CL_TRUE, CL_MAP_READ | CL_MAP_WRITE, 0, buffer->bytes,
                                        0, nullptr, nullptr, &code);
  impl_->check(code, "allocating memory for transfers");
  return {static_cast<std::uint32_t*>(data), [queue, buffer](std::uint32_t* at) {
            clEnqueueUnmapMemObject(queue, buffer->mem.get(), at, 0, nullptr, nullptr);
          }};
}

void Device::wait(const Ticket& ticket) {
  impl_->may_fail(Fault::Call::wait, "waiting for the device");
  const cl_event event = ticket.impl_->event.get();
  impl_->check(clWaitForEvents(1, &event), "waiting for the device");
  impl_->resolve(ticket.impl_->number);
  if (impl_->info.fault) impl_->info.fault->spoil(ticket.impl_->data, ticket.impl_->bytes);
}

void Device::begin_unit(std::uint64_t paths) {
  if (impl_->info.fault) impl_->info.fault->begin_unit(paths);
}

void Device::run(const Kernel& kernel, std::size_t groups, std::size_t local, std::uint64_t items) {
  if (groups == 0) return;
  Kernel::Impl& k = *kernel.impl_;
  impl_->may_fail(Fault::Call::launch, "launching kernel '" + k.name + "'");
  const std::size_t global = groups * local;
  if (!k.launched && local > kernel.most_work_items())
    throw DeviceError(fmt::format(
        "kernel '{}' is to run with {} work-items in a work-group on device '{}', which takes {}; try another device "
        "(--devices)",
        k.name, local, impl_->info.name, kernel.most_work_items()));
  const double begin = k.launched ? 0 : host_seconds();
  cl_event event = nullptr;
  impl_->check(
      clEnqueueNDRangeKernel(impl_->queue.get(), k.kernel.get(), 1, nullptr, &global, &local, 0, nullptr, &event),
      "launching kernel '" + k.name + "'");
  impl_->track(k.name.c_str(), event, items, 0);
  if (k.launched) return;
  impl_->profiler.compile_s += host_seconds() - begin;
  impl_->pending.back().first_of = k.program;
  k.launched = true;
}

void Device::flush() { impl_->check(clFlush(impl_->queue.get()), "submitting work"); }

void Device::drain() noexcept {
  if (impl_->info.fault) (void)impl_->info.fault->at(Fault::Call::wait);
  clFinish(impl_->queue.get());
  if (impl_->beside) clFinish(impl_->beside.get());
}

void Device::finish() {
  impl_->may_fail(Fault::Call::finish, "waiting for the device");
  impl_->check(clFinish(impl_->queue.get()), "waiting for the device");
  if (impl_->beside) impl_->check(clFinish(impl_->beside.get()), "waiting for the device");
  impl_->resolve(impl_->enqueued);
}

}  // namespace eikon
