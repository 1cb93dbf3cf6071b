// SPDX-License-Identifier: Apache-2.0
// Which devices there are, and which of them a selection means.
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <fmt/format.h>

#include "device/cl.h"

namespace eikon {
namespace {

// PoCL caches what it compiles below HOME; where that cannot be written it would compile everything anew each time.
void give_pocl_a_cache() {
  if (std::getenv("POCL_CACHE_DIR") != nullptr || std::getenv("XDG_CACHE_HOME") != nullptr) return;
  const char* home = std::getenv("HOME");
  if (home != nullptr && access(home, W_OK) == 0) return;
  // PoCL loads code from there: it must be ours and closed to others.
  const std::string cache = fmt::format("/tmp/eikon-pocl-{}", getuid());
  mkdir(cache.c_str(), 0700);
  struct stat found {};
  if (lstat(cache.c_str(), &found) == 0 && S_ISDIR(found.st_mode) && found.st_uid == getuid() &&
      (found.st_mode & 077) == 0)
    setenv("POCL_CACHE_DIR", cache.c_str(), 0);
}

std::string device_string(cl_device_id device, cl_device_info what) {
  std::size_t size = 0;
  if (clGetDeviceInfo(device, what, 0, nullptr, &size) != CL_SUCCESS || size == 0) return "";
  std::string text(size, '\0');
  clGetDeviceInfo(device, what, size, text.data(), nullptr);
  return text.substr(0, text.find('\0'));
}

template <class T>
T device_value(cl_device_id device, cl_device_info what) {
  T value{};
  clGetDeviceInfo(device, what, sizeof value, &value, nullptr);
  return value;
}

DeviceInfo describe(cl_device_id device, std::uint32_t index) {
  DeviceInfo info;
  info.index = index;
  info.name = device_string(device, CL_DEVICE_NAME);
  info.vendor = device_string(device, CL_DEVICE_VENDOR);
  info.driver = device_string(device, CL_DRIVER_VERSION);
  info.version = device_string(device, CL_DEVICE_VERSION);
  const auto platform = device_value<cl_platform_id>(device, CL_DEVICE_PLATFORM);
  std::size_t size = 0;
  if (clGetPlatformInfo(platform, CL_PLATFORM_NAME, 0, nullptr, &size) == CL_SUCCESS && size > 0) {
    info.platform.resize(size);
    clGetPlatformInfo(platform, CL_PLATFORM_NAME, size, info.platform.data(), nullptr);
    info.platform.resize(size - 1);
  }
  const auto type = device_value<cl_device_type>(device, CL_DEVICE_TYPE);
  info.cpu = (type & CL_DEVICE_TYPE_CPU) != 0;
  info.gpu = (type & CL_DEVICE_TYPE_GPU) != 0;
  info.compute_units = device_value<cl_uint>(device, CL_DEVICE_MAX_COMPUTE_UNITS);
  info.memory_bytes = device_value<cl_ulong>(device, CL_DEVICE_GLOBAL_MEM_SIZE);
  info.max_allocation_bytes = device_value<cl_ulong>(device, CL_DEVICE_MAX_MEM_ALLOC_SIZE);
  info.native_float_lanes = std::max<cl_uint>(1, device_value<cl_uint>(device, CL_DEVICE_NATIVE_VECTOR_WIDTH_FLOAT));
  const auto fp = device_value<cl_device_fp_config>(device, CL_DEVICE_SINGLE_FP_CONFIG);
  info.correctly_rounded_divide_sqrt = (fp & CL_FP_CORRECTLY_ROUNDED_DIVIDE_SQRT) != 0;
  info.denormals = (fp & CL_FP_DENORM) != 0;
  if (device_value<cl_bool>(device, CL_DEVICE_AVAILABLE) == CL_FALSE)
    info.unusable = "the driver says it is not available";
  else if (device_value<cl_bool>(device, CL_DEVICE_COMPILER_AVAILABLE) == CL_FALSE)
    info.unusable = "it has no compiler";
  else if (device_value<cl_bool>(device, CL_DEVICE_ENDIAN_LITTLE) == CL_FALSE)
    info.unusable = "it is big-endian";
  return info;
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return text;
}

}  // namespace

std::vector<cl_device_id> enumerate_devices() {
  give_pocl_a_cache();
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

std::vector<DeviceInfo> list_devices() {
  std::vector<DeviceInfo> infos;
  for (cl_device_id device : enumerate_devices()) infos.push_back(describe(device, std::uint32_t(infos.size())));
  return infos;
}

std::vector<DeviceInfo> select_devices(const std::string& selection) {
  const std::vector<DeviceInfo> all = list_devices();
  if (all.empty())
    throw DeviceError(
        "no OpenCL device: no platform is installed; try: apt-get install pocl-opencl-icd, then `eikon devices`");
  std::string known;
  for (const DeviceInfo& info : all) known += fmt::format("{}{}: {}", known.empty() ? "" : ", ", info.index, info.name);

  std::vector<DeviceInfo> chosen;
  const auto choose = [&](const DeviceInfo& info) {
    const auto same = [&](const DeviceInfo& other) { return other.index == info.index; };
    if (std::none_of(chosen.begin(), chosen.end(), same)) chosen.push_back(info);
  };
  std::size_t begin = 0;
  while (begin <= selection.size()) {
    const std::size_t end = std::min(selection.find(',', begin), selection.size());
    const std::string entry = lower(selection.substr(begin, end - begin));
    begin = end + 1;
    const bool number = !entry.empty() && entry.find_first_not_of("0123456789") == std::string::npos;
    std::size_t matches = 0;
    for (const DeviceInfo& info : all) {
      const bool match = number           ? std::to_string(info.index) == entry
                         : entry == "all" ? info.unusable.empty()
                         : entry == "cpu" ? info.cpu
                         : entry == "gpu" ? info.gpu
                                          : !entry.empty() && lower(info.name).find(entry) != std::string::npos;
      if (!match) continue;
      if (!info.unusable.empty())
        throw DeviceError(fmt::format("device {} ({}) cannot be used: {}", info.index, info.name, info.unusable));
      choose(info);
      ++matches;
    }
    if (matches == 0)
      throw DeviceError(fmt::format("--devices {}: no such device '{}'; there is {}", selection, entry, known));
  }
  return chosen;
}

}  // namespace eikon
