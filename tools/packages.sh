# SPDX-License-Identifier: Apache-2.0
# shellcheck shell=bash disable=SC2034 The one list of Debian packages (names of Debian 12). Sourced
# by setup.sh; nothing else names a package.

# To configure, build and run eikon. libtinygltf-dev does not pull in the JSON header that it
# includes, so nlohmann-json3-dev is named too. pocl-opencl-icd is an OpenCL device for any CPU;
# drivers of other devices are found through /etc/OpenCL/vendors and are not ours to install.
build_packages=(
  ca-certificates git
  g++ cmake ninja-build pkg-config
  ocl-icd-opencl-dev opencl-headers pocl-opencl-icd
  libopenexr-dev libpng-dev libjpeg-dev libwebp-dev libzstd-dev libdeflate-dev libglm-dev libtinygltf-dev nlohmann-json3-dev
  libcli11-dev libtbb-dev libfmt-dev
  libdraco-dev libmeshoptimizer-dev libxxhash-dev
  libcpp-httplib-dev
  libembree-dev
)

# For the tests: GoogleTest; Oclgrind, a second OpenCL implementation to compare bits with; clang to
# check the kernels without a device and, with the runtime of its sanitizers, to build the reader of
# scenes; Python for the scene generators, numpy as the reference of the image metrics; locales for
# one whose numbers have a decimal comma; venv for what test.sh takes from PyPI; dev for the module
# that Python loads; Slurm and its munge for the cluster of two nodes that the tests of the farm
# start; zsh and fish, whose completion is tried; mandoc for the manual pages; dpkg-dev for the
# package; Chromium and what drives it, for the page of the view.
test_packages=(
  libgtest-dev
  oclgrind clang-14 libclang-rt-14-dev
  python3 python3-numpy python3-venv python3-dev
  locales
  slurm-wlm munge
  zsh fish mandoc dpkg-dev
  chromium chromium-driver python3-selenium
)

# Compilers of GPUs, which tools/gpu/fetch_compilers.sh unpacks into a folder and does not install:
# an OpenCL driver more would change which devices a render finds. Clang for AMD's code and NVIDIA's
# PTX; ocloc for Intel's.
gpu_packages=(
  clang-19 libclang-cpp19 libllvm19 libclang-common-19-dev libclc-19 libclc-19-dev
  intel-opencl-icd libigc1 libigdfcl1 libigdgmm12 libopencl-clang14 libllvmspirvlib14
)
gpu_wheels=(nvidia-cuda-nvcc-cu12==12.9.86)  # of PyPI: ptxas
