# SPDX-License-Identifier: Apache-2.0
# The module that Python loads, made of the same libraries as the program. Its package lies in the build folder, ready for
# PYTHONPATH; pyproject.toml installs the component `python` into a wheel.
find_package(Python 3.9 REQUIRED COMPONENTS Interpreter Development.Module ${SKBUILD_SABI_COMPONENT})
if(NOT nanobind_DIR)
  execute_process(COMMAND ${Python_EXECUTABLE} -m nanobind --cmake_dir OUTPUT_VARIABLE folder OUTPUT_STRIP_TRAILING_WHITESPACE)
  set(nanobind_DIR ${folder} CACHE PATH "where nanobind's package for CMake is" FORCE)
endif()
find_package(nanobind CONFIG REQUIRED)
file(GLOB PYTHON_SOURCES CONFIGURE_DEPENDS host/python/*.cpp)
# By the stable interface, where Python has it (from 3.12 on), one module serves later versions, too.
nanobind_add_module(_eikon STABLE_ABI NB_STATIC NOMINSIZE ${PYTHON_SOURCES})
target_link_libraries(_eikon PRIVATE eikon_commands)
target_include_directories(_eikon SYSTEM PRIVATE ${NB_DIR}/include)  # no warnings about them
target_compile_options(_eikon PRIVATE -O1)
set_target_properties(_eikon PROPERTIES UNITY_BUILD OFF LIBRARY_OUTPUT_DIRECTORY ${CMAKE_BINARY_DIR}/python-package/eikon)
target_link_options(_eikon PRIVATE -Wl,--exclude-libs,ALL)  # no symbol of our libraries meets that of another module
file(GLOB package_files CONFIGURE_DEPENDS host/python/eikon/*)
set(copied ${CMAKE_BINARY_DIR}/python-package.stamp)
add_custom_command(OUTPUT ${copied} DEPENDS ${package_files}
  COMMAND ${CMAKE_COMMAND} -E copy ${package_files} ${CMAKE_BINARY_DIR}/python-package/eikon
  COMMAND ${CMAKE_COMMAND} -E touch ${copied} VERBATIM)
add_custom_target(python_package ALL DEPENDS _eikon ${copied})
install(TARGETS _eikon LIBRARY DESTINATION eikon COMPONENT python EXCLUDE_FROM_ALL)
