// SPDX-License-Identifier: Apache-2.0
// Programs and kernels. Drivers cache what they compile; of PoCL, which takes long to find it,
// eikon keeps binaries (store/program_store.h).
#include <fmt/format.h>

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "device/cl.h"
#include "device/kernel_conditions.h"
#include "device/kernel_sources.h"
#include "io/text.h"

namespace eikon {
namespace {

std::string first_error(const std::string& log) {
  std::istringstream lines(log);
  std::string line, first;
  while (std::getline(lines, line)) {
    if (line.find("error") != std::string::npos) return line;
    if (first.empty()) first = line;
  }
  return first.empty() ? "the compiler says nothing" : first;
}

/// Writes what a driver's compiler is given to the folder that EIKON_DUMP_PROGRAMS names, so that
/// other compilers can be given the same.
void dump_program(const std::string& text, const std::string& flags) {
  const char* const folder = std::getenv("EIKON_DUMP_PROGRAMS");
  if (folder == nullptr || *folder == '\0') return;
  static std::atomic<unsigned> count = 0;  // devices build at the same time
  const std::string name = fmt::format("program_{}", count++);
  for (const auto& [kind, content] : {std::pair{".cl", &text}, std::pair{".options", &flags}}) {
    const std::filesystem::path file = std::filesystem::path(folder) / (name + kind);
    if (!(std::ofstream(file, std::ios::binary) << *content << '\n').flush())
      throw InputError(fmt::format("EIKON_DUMP_PROGRAMS: cannot write '{}'; name a folder that is there", file.string()));
  }
}

/// Sets the program to that of a text. Returns the code of the compiler.
cl_int compile(Program::Impl& impl, cl_context context, cl_device_id device, const std::string& text,
               const std::string& flags) {
  const char* source = text.c_str();
  const std::size_t length = text.size();
  cl_int code = CL_SUCCESS;
  impl.program.reset(clCreateProgramWithSource(context, 1, &source, &length, &code));
  cl_check(code, "creating a program", impl.device);
  return clBuildProgram(impl.program.get(), 1, &device, flags.c_str(), nullptr, nullptr);
}

std::vector<std::string> kernel_names(cl_program program) {
  std::size_t size = 0;
  clGetProgramInfo(program, CL_PROGRAM_KERNEL_NAMES, 0, nullptr, &size);
  std::string names(size, '\0');
  clGetProgramInfo(program, CL_PROGRAM_KERNEL_NAMES, size, names.data(), nullptr);
  return split(names.substr(0, names.find('\0')), ';');
}

/// Returns whether the driver knows the names of a built program's arguments, by which they are
/// bound.
bool names_arguments(cl_program program) {
  const ClKernel kernel(clCreateKernel(program, kernel_names(program).front().c_str(), nullptr));
  std::size_t size = 0;
  return kernel && clGetKernelArgInfo(kernel.get(), 0, CL_KERNEL_ARG_NAME, 0, nullptr, &size) == CL_SUCCESS;
}

/// Sets the program to that of a driver's binary, if there is one and the driver takes it. Returns
/// whether it is set.
bool open_binary(Program::Impl& impl, cl_context context, cl_device_id device, const StoredProgram& stored,
                 const std::string& flags) {
  const std::optional<std::string> binary = stored.find();
  if (!binary) return false;
  const auto* data = reinterpret_cast<const unsigned char*>(binary->data());
  const std::size_t size = binary->size();
  ClProgram program(clCreateProgramWithBinary(context, 1, &device, &size, &data, nullptr, nullptr));
  if (!program || clBuildProgram(program.get(), 1, &device, flags.c_str(), nullptr, nullptr) != CL_SUCCESS ||
      !names_arguments(program.get()) || !can_run(*binary))
    return false;
  impl.program = std::move(program);
  return true;
}

}  // namespace

void Program::Impl::has_run(const std::string& kernel) {
  if (!stored) return;
  if (not_run.empty()) {
    const std::vector<std::string> kernels = kernel_names(program.get());
    not_run.insert(kernels.begin(), kernels.end());
  }
  not_run.erase(kernel);
  if (!not_run.empty()) return;
  if (const std::string binary = program_binary(program.get()); !binary.empty()) stored->keep(binary);
  stored.reset();
}

std::shared_ptr<Program::Impl> build_program(cl_context context, cl_device_id device, const DeviceInfo& info,
                                             const std::string& text, const ProgramOptions& options) {
  // The text switches FP_CONTRACT off; no flag may loosen the arithmetic. -w, because PoCL's
  // compiler writes how many warnings it has to the standard error stream: hundreds, of vectors
  // that are wider than the registers of the processor.
  std::string flags = "-cl-std=CL1.2 -cl-kernel-arg-info -w";
  std::map<std::string, std::string> defines = options.defines;
  defines["EK_CPU"] = info.cpu ? "1" : "0";
  const auto width = defines.find("EK_WIDTH");
  const bool one_lane = width != defines.end() && width->second == "1";
  if (info.own_division && one_lane)
    defines["EK_OWN_DIVISION"] = "1";  // lanes/division.h
  else if (info.correctly_rounded_divide_sqrt)
    flags += " -cl-fp32-correctly-rounded-divide-sqrt";
  if (!options.optimise) flags += " -cl-opt-disable -DEK_OUT_OF_LINE -DEK_PORTABLE";
  if (!options.extra_flags.empty()) flags += " " + options.extra_flags;
  std::string not_zero;  // for an error, which names what is in a program and not the hundred features that are out
  for (const auto& [name, value] : defines) {
    const std::string define = fmt::format(" -D{}={}", name, value);
    flags += define;
    if (value != "0") not_zero += define;
  }

  dump_program(text, flags);

  auto impl = std::make_shared<Program::Impl>();
  impl->id = device;
  impl->device = info.name;
  // Code that is not optimised is for Oclgrind, which names files and lines of the text, as errors
  // do.
  const std::string compact = options.optimise ? bare_text(without_excluded(text, defines)) : text;
  if (options.optimise) impl->stored = stored_program(info, device, flags, compact);
  if (impl->stored && open_binary(*impl, context, device, *impl->stored, flags)) {
    impl->stored.reset();
    return impl;
  }
  cl_int code = compile(*impl, context, device, compact, flags);
  if (code != CL_SUCCESS && options.optimise) {
    impl->stored.reset();
    code = compile(*impl, context, device, text, flags);
  }
  if (code != CL_SUCCESS) {
    if (const auto why = is_pocl(info) ? why_pocl_cannot_compile() : std::nullopt) throw CompileError(*why);
    std::size_t size = 0;
    clGetProgramBuildInfo(impl->program.get(), device, CL_PROGRAM_BUILD_LOG, 0, nullptr, &size);
    std::string log(size, '\0');
    clGetProgramBuildInfo(impl->program.get(), device, CL_PROGRAM_BUILD_LOG, size, log.data(), nullptr);
    throw CompileError(fmt::format(
        "the kernels do not compile on device '{}': {}; defines that are not 0:{}; try another device (--devices)",
        info.name, first_error(log), not_zero));
  }
  return impl;
}

Kernel Program::kernel(const std::string& name) const {
  Kernel kernel;
  kernel.impl_ = std::make_shared<Kernel::Impl>();
  Kernel::Impl& k = *kernel.impl_;
  k.program = impl_;
  k.name = name;
  cl_int code = CL_SUCCESS;
  k.kernel.reset(clCreateKernel(impl_->program.get(), name.c_str(), &code));
  if (code != CL_SUCCESS) throw InternalError(fmt::format("no kernel '{}': {}", name, cl_error_name(code)));
  cl_uint count = 0;
  clGetKernelInfo(k.kernel.get(), CL_KERNEL_NUM_ARGS, sizeof count, &count, nullptr);
  for (cl_uint i = 0; i < count; ++i) {
    std::size_t size = 0;
    cl_check(clGetKernelArgInfo(k.kernel.get(), i, CL_KERNEL_ARG_NAME, 0, nullptr, &size),
             "asking for the arguments of kernel '" + name + "'", impl_->device);
    std::string argument(size, '\0');
    clGetKernelArgInfo(k.kernel.get(), i, CL_KERNEL_ARG_NAME, size, argument.data(), nullptr);
    k.argument_names.push_back(argument.substr(0, argument.find('\0')));
    cl_kernel_arg_address_qualifier space = CL_KERNEL_ARG_ADDRESS_PRIVATE;
    clGetKernelArgInfo(k.kernel.get(), i, CL_KERNEL_ARG_ADDRESS_QUALIFIER, sizeof space, &space, nullptr);
    k.argument_is_buffer.push_back(space != CL_KERNEL_ARG_ADDRESS_PRIVATE);
  }
  return kernel;
}

const std::string& Kernel::name() const { return impl_->name; }

std::size_t Kernel::most_work_items() const {
  // Oclgrind wants the device to be named, which OpenCL asks for only where a program has several.
  std::size_t count = 1;
  cl_check(clGetKernelWorkGroupInfo(impl_->kernel.get(), impl_->program->id, CL_KERNEL_WORK_GROUP_SIZE, sizeof count,
                                    &count, nullptr),
           "asking for the work-group size of kernel '" + impl_->name + "'", impl_->program->device);
  return count;
}

void Kernel::bind(const Arguments& arguments) {
  Impl& k = *impl_;
  k.bound.clear();
  for (cl_uint i = 0; i < k.argument_names.size(); ++i) {
    const std::string& name = k.argument_names[i];
    cl_int code = CL_SUCCESS;
    if (k.argument_is_buffer[i]) {
      const auto found = arguments.buffers().find(name);
      if (found == arguments.buffers().end() || !found->second)
        throw InternalError(fmt::format("kernel '{}' wants a buffer '{}' that nobody provides", k.name, name));
      const cl_mem mem = found->second.impl_->mem.get();
      code = clSetKernelArg(k.kernel.get(), i, sizeof mem, static_cast<const void*>(&mem));
      k.bound.push_back(found->second);
    } else {
      const auto found = arguments.scalars().find(name);
      if (found == arguments.scalars().end())
        throw InternalError(fmt::format("kernel '{}' wants a value '{}' that nobody provides", k.name, name));
      code = clSetKernelArg(k.kernel.get(), i, sizeof found->second, &found->second);
    }
    cl_check(code, fmt::format("setting argument '{}' of kernel '{}'", name, k.name), k.program->device);
  }
}

void Kernel::set(const std::string& argument, std::uint32_t value) {
  Impl& k = *impl_;
  for (cl_uint i = 0; i < k.argument_names.size(); ++i)
    if (k.argument_names[i] == argument && !k.argument_is_buffer[i])
      cl_check(clSetKernelArg(k.kernel.get(), i, sizeof value, &value), "setting argument '" + argument + "'",
               k.program->device);
}

}  // namespace eikon
