// SPDX-License-Identifier: Apache-2.0
// Lists the devices of this machine and chooses those that a selection names.
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fmt/format.h>
#include <mutex>
#include <iterator>
#include <map>
#include <optional>
#include <span>
#include <tuple>

#include "core/host_limits.h"
#include "device/cl.h"
#include "device/fault.h"
#include "device/probes.h"
#include "device/store/program_store.h"
#include "device/selection.h"

namespace eikon {
namespace {

constexpr const char* kNoPlatform =
    "no platform is installed; try: apt-get install pocl-opencl-icd, or, for a GPU, name its driver's library in a "
    "file /etc/OpenCL/vendors/NAME.icd, then `eikon devices`";

// PoCL caches what it compiles below HOME. When that cannot be written, it would compile everything
// in every run.
void give_pocl_a_cache() {
  if (std::getenv("POCL_CACHE_DIR") != nullptr || std::getenv("XDG_CACHE_HOME") != nullptr) return;
  const char* home = std::getenv("HOME");
  if (home != nullptr && access(home, W_OK) == 0) return;
  // PoCL loads code from the cache, so the folder must be ours and closed to others.
  const std::string cache = fmt::format("/tmp/eikon-pocl-{}", getuid());
  mkdir(cache.c_str(), 0700);
  struct stat found {};
  if (lstat(cache.c_str(), &found) == 0 && S_ISDIR(found.st_mode) && found.st_uid == getuid() &&
      (found.st_mode & 077) == 0)
    setenv("POCL_CACHE_DIR", cache.c_str(), 0);
}

/// ask: clGetDeviceInfo or clGetPlatformInfo
template <class Ask, class Handle>
std::string text_of(Ask ask, Handle of, cl_uint what) {
  std::size_t size = 0;
  if (ask(of, what, 0, nullptr, &size) != CL_SUCCESS || size == 0) return "";
  std::string text(size, '\0');
  ask(of, what, size, text.data(), nullptr);
  return text.substr(0, text.find('\0'));
}

std::string device_string(cl_device_id device, cl_device_info what) { return text_of(clGetDeviceInfo, device, what); }

template <class T>
T device_value(cl_device_id device, cl_device_info what) {
  T value{};
  clGetDeviceInfo(device, what, sizeof value, &value, nullptr);
  return value;
}

bool divides_by_counts(cl_device_id device) {
  cl_device_partition_property properties[16] = {};
  std::size_t bytes = 0;
  if (clGetDeviceInfo(device, CL_DEVICE_PARTITION_PROPERTIES, sizeof properties, properties, &bytes) != CL_SUCCESS)
    return false;
  const std::span<const cl_device_partition_property> known(
      properties, std::min(bytes / sizeof properties[0], std::size(properties)));
  return std::ranges::find(known, cl_device_partition_property(CL_DEVICE_PARTITION_BY_COUNTS)) != known.end();
}

// cl_khr_pci_bus_info: domain, bus, device, function.
constexpr cl_device_info kPciBusInfo = 0x410F;
constexpr cl_device_info kUuid = 0x106A;        // cl_khr_device_uuid: 16 bytes
constexpr cl_device_info kNvidiaBus = 0x4008, kNvidiaSlot = 0x4009,
                         kNvidiaDomain = 0x400A;  // cl_nv_device_attribute_query

/// Returns e.g. "0000:65:00.0", or "" when the driver does not state it.
std::string pci_address(cl_device_id device, const std::string& extensions) {
  if (extensions.find("cl_khr_pci_bus_info") != std::string::npos) {
    cl_uint where[4] = {};
    if (clGetDeviceInfo(device, kPciBusInfo, sizeof where, where, nullptr) == CL_SUCCESS)
      return fmt::format("{:04x}:{:02x}:{:02x}.{:x}", where[0], where[1], where[2], where[3]);
  }
  cl_uint bus = 0, slot = 0;
  if (extensions.find("cl_nv_device_attribute_query") == std::string::npos ||
      clGetDeviceInfo(device, kNvidiaBus, sizeof bus, &bus, nullptr) != CL_SUCCESS ||
      clGetDeviceInfo(device, kNvidiaSlot, sizeof slot, &slot, nullptr) != CL_SUCCESS)
    return "";
  return fmt::format("{:04x}:{:02x}:{:02x}.{:x}", device_value<cl_uint>(device, kNvidiaDomain), bus, slot >> 3,
                     slot & 7U);
}

std::string uuid_of(cl_device_id device, const std::string& extensions) {
  unsigned char bytes[16] = {};
  if (extensions.find("cl_khr_device_uuid") == std::string::npos ||
      clGetDeviceInfo(device, kUuid, sizeof bytes, bytes, nullptr) != CL_SUCCESS)
    return "";
  std::string text;
  for (const unsigned char byte : bytes) text += fmt::format("{:02x}", byte);
  return text;
}

DeviceInfo describe(cl_device_id device, std::uint32_t index) {
  DeviceInfo info;
  info.index = index;
  info.name = device_string(device, CL_DEVICE_NAME);
  info.vendor = device_string(device, CL_DEVICE_VENDOR);
  info.driver = device_string(device, CL_DRIVER_VERSION);
  info.version = device_string(device, CL_DEVICE_VERSION);
  const auto platform = device_value<cl_platform_id>(device, CL_DEVICE_PLATFORM);
  info.platform = text_of(clGetPlatformInfo, platform, CL_PLATFORM_NAME);
  const auto type = device_value<cl_device_type>(device, CL_DEVICE_TYPE);
  info.cpu = (type & CL_DEVICE_TYPE_CPU) != 0;
  info.gpu = (type & CL_DEVICE_TYPE_GPU) != 0;
  info.whole_units = info.compute_units = device_value<cl_uint>(device, CL_DEVICE_MAX_COMPUTE_UNITS);
  info.divisible = divides_by_counts(device);
  info.selector = std::to_string(index);
  const std::string extensions = device_string(device, CL_DEVICE_EXTENSIONS);
  info.pci = pci_address(device, extensions);
  info.uuid = uuid_of(device, extensions);
  info.vendor_id = device_value<cl_uint>(device, CL_DEVICE_VENDOR_ID);
  for (const char* const native : {"Portable Computing Language", "Intel", "Oclgrind"})
    info.cycle_counter = info.cycle_counter || (info.cpu && info.platform.find(native) != std::string::npos);
  info.memory_bytes = device_value<cl_ulong>(device, CL_DEVICE_GLOBAL_MEM_SIZE);
  info.max_allocation_bytes = device_value<cl_ulong>(device, CL_DEVICE_MAX_MEM_ALLOC_SIZE);
  info.native_float_lanes = std::max<cl_uint>(1, device_value<cl_uint>(device, CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT));
  const auto fp = device_value<cl_device_fp_config>(device, CL_DEVICE_SINGLE_FP_CONFIG);
  info.correctly_rounded_divide_sqrt = (fp & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) != 0;
  info.denormals = (fp & CL_FP_DENORM) != 0;
  const char* const division = std::getenv("EIKON_DIVISION");
  info.own_division = divides_itself(info, division != nullptr ? division : "");
  if (device_value<cl_bool>(device, CL_DEVICE_AVAILABLE) == CL_FALSE)
    info.unusable = "the driver says it is not available";
  else if (device_value<cl_bool>(device, CL_DEVICE_COMPILER_AVAILABLE) == CL_FALSE)
    info.unusable = "it has no compiler";
  else if (device_value<cl_bool>(device, CL_DEVICE_ENDIAN_LITTLE) == CL_FALSE)
    info.unusable = "it is big-endian";
  return info;
}

/// Gives the chosen devices the faults of EIKON_FAULT. throws UsageError
void plan_faults(std::vector<DeviceInfo>& chosen) {
  const char* const text = std::getenv("EIKON_FAULT");
  if (text == nullptr || *text == '\0') return;
  std::map<std::uint32_t, std::vector<FaultPlan>> plans;
  for (const FaultPlan& plan : parse_faults(text)) plans[plan.device].push_back(plan);
  for (DeviceInfo& info : chosen) {
    if (plans.count(info.position) == 0) continue;
    info.fault = std::make_shared<Fault>(plans[info.position]);
    if (info.fault->acts_as_gpu()) info.cpu = false, info.gpu = true;
  }
}

}  // namespace

bool divides_itself(const DeviceInfo& info, const std::string& asked) {
  constexpr cl_uint intel = 0x8086;  // PCI vendor
  if (asked.empty()) return info.gpu && (!info.correctly_rounded_divide_sqrt || info.vendor_id == intel);
  if (asked != "own" && asked != "driver")
    throw UsageError(fmt::format("EIKON_DIVISION={}: takes own or driver", asked));
  return asked == "own";
}

std::vector<cl_device_id> enumerate_devices() {
  // The loader initialises itself in the first call, and crashes when two threads make it at once.
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  give_pocl_a_cache();
  prepare_pocl();
  cl_uint platform_count = 0;
  if (clGetPlatformIDs(0, nullptr, &platform_count) != CL_SUCCESS || platform_count == 0) return {};
  std::vector<cl_platform_id> platforms(platform_count);
  clGetPlatformIDs(platform_count, platforms.data(), nullptr);
  std::vector<cl_device_id> all;
  for (cl_platform_id platform : platforms) {
    cl_uint count = 0;
    if (clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, 0, nullptr, &count) != CL_SUCCESS) continue;
    std::vector<cl_device_id> devices(count);
    if (clGetDeviceIDs(platform, CL_DEVICE_TYPE_ALL, count, devices.data(), nullptr) != CL_SUCCESS) continue;
    all.insert(all.end(), devices.begin(), devices.end());
  }
  return all;
}

std::vector<DeviceInfo> list_devices(unsigned threads) {
  const HostLimits host = host_limits();
  std::vector<DeviceInfo> infos;
  for (cl_device_id device : enumerate_devices()) {
    infos.push_back(describe(device, std::uint32_t(infos.size())));
    hold_to_limits(infos.back(), host, threads);
  }
  return infos;
}

std::vector<DeviceInfo> select_devices(const std::string& selection, unsigned threads,
                                       std::vector<std::string>* notes) {
  const std::vector<DeviceInfo> all = list_devices(threads);
  if (all.empty()) throw DeviceError("no OpenCL device: " + why_pocl_cannot_compile().value_or(kNoPlatform));
  Selection chosen = resolve_selection(selection, all, passes_canary);
  plan_faults(chosen.devices);
  std::ranges::move(leave_cores_to_feeders(chosen.devices, host_limits().threads), std::back_inserter(chosen.notes));
  if (notes != nullptr) *notes = std::move(chosen.notes);
  return std::move(chosen.devices);
}

namespace {

cl_device_id make_part(cl_device_id whole, const DeviceInfo& info) {
  std::vector<cl_device_partition_property> counts = {CL_DEVICE_PARTITION_BY_COUNTS};
  if (info.first_unit > 0) counts.push_back(info.first_unit);
  counts.insert(counts.end(),
                {cl_device_partition_property(info.compute_units), CL_DEVICE_PARTITION_BY_COUNTS_LIST_END, 0});
  cl_device_id parts[2] = {nullptr, nullptr};
  cl_uint made = 0;
  cl_check(clCreateSubDevices(whole, counts.data(), info.first_unit > 0 ? 2 : 1, parts, &made), "making a sub-device",
           info.name);
  const ClDevice before(info.first_unit > 0 ? parts[0] : nullptr);
  return parts[info.first_unit > 0 ? 1 : 0];
}

/// Sub-devices are made once and never released. A thread of PoCL releases a command, and asks the
/// queue's device for that, after clFinish() has returned; nothing in PoCL keeps the device until
/// then.
cl_device_id part_of_device(cl_device_id whole, const DeviceInfo& info) {
  static std::mutex one_at_a_time;
  static std::map<std::tuple<cl_device_id, std::uint32_t, std::uint32_t>, cl_device_id> parts;
  const std::lock_guard lock(one_at_a_time);
  cl_device_id& part = parts[{whole, info.first_unit, info.compute_units}];
  if (part == nullptr) part = make_part(whole, info);
  return part;
}

}  // namespace

ClDevice open_device(const DeviceInfo& info) {
  const std::vector<cl_device_id> devices = enumerate_devices();
  // The loader of OpenCL finds platforms and devices once for the whole process, so what has this
  // index is still the same.
  if (info.index >= devices.size())
    throw DeviceError(fmt::format("device {} '{}' has disappeared: drivers list {} devices now; see `eikon devices`",
                                  info.index, info.name, devices.size()));
  const cl_device_id whole = devices[info.index];
  if (info.whole() || !info.divisible) return ClDevice(whole);
  const cl_device_id part = part_of_device(whole, info);
  clRetainDevice(part);
  return ClDevice(part);
}

}  // namespace eikon
