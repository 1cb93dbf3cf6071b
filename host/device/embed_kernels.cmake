# SPDX-License-Identifier: Apache-2.0
# Writes OUTPUT: a C++ table (path below ROOT, text) of every kernel source, for host/device/kernel_sources.cpp.
file(GLOB_RECURSE files RELATIVE ${ROOT} ${ROOT}/*.h ${ROOT}/*.def ${ROOT}/*.cl)
list(SORT files)
set(table "#include \"device/kernel_sources.h\"\nnamespace eikon {\nconst std::map<std::string, std::string>& embedded_kernels() {\n  static const std::map<std::string, std::string> table = {\n")
foreach(file ${files})
  file(READ ${ROOT}/${file} text)
  string(APPEND table "{\"${file}\", R\"EIKON(${text})EIKON\"},\n")
endforeach()
string(APPEND table "  };\n  return table;\n}\n}\n")
file(WRITE ${OUTPUT} "${table}")
