#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs what is missing, builds Release with the tests, runs all of them. Extra arguments go to
# ctest, e.g.
#   tools/test.sh -L unit        only the tests of one label, such as unit, kernels, render or cli
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
build="$root/build-tests"

"$root/tools/setup.sh" tests
# What reads scenes, under sanitizers: the corpus of damaged scenes runs against it. Clang builds it
# without optimisation in a third of the time that GCC takes, and the corpus takes no longer than
# with -Og.
sanitized="$build/reader"
cmake --log-level=WARNING -S "$root" -B "$sanitized" -G Ninja -DCMAKE_BUILD_TYPE=Release "-DCMAKE_CXX_FLAGS_RELEASE=-O0" \
  -DCMAKE_CXX_COMPILER=clang++-14 -DCMAKE_UNITY_BUILD=ON -DEIKON_TESTS=ON -DEIKON_SANITIZE=address,undefined
cmake --build "$sanitized" --target corpus_reader
# nanobind, which no package of Debian 12 has, binds the module for Python. Without it the tests of
# the package are left out.
python="$build/python"
nanobind="$python/bin/python -m nanobind --cmake_dir"
$nanobind >/dev/null 2>&1 ||
  { python3 -m venv "$python" && "$python/bin/pip" install --quiet --no-deps --retries 1 --timeout 60 nanobind==3.1.0; } ||
  echo "test.sh: nanobind cannot be installed from PyPI; the tests of the package for Python are left out" >&2
binding=(-DEIKON_PYTHON=OFF)
if folder="$($nanobind 2>/dev/null)"; then binding=(-DEIKON_PYTHON=ON "-Dnanobind_DIR=$folder" -DPython_EXECUTABLE=/usr/bin/python3); fi

cmake --log-level=WARNING -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DEIKON_TESTS=ON \
  -DCMAKE_UNITY_BUILD=ON "-DEIKON_SANITIZED_READER=$sanitized/tests/corpus_reader" "${binding[@]}"
cmake --build "$build"

# Open Image Denoise, which no package of Debian 12 has. Without it one test is left out, and says
# so.
library="lib/python3*/site-packages/pyoidn/oidn/lib/libOpenImageDenoise.so.2"
if [[ -z "${EIKON_OIDN-}" ]]; then
  # shellcheck disable=SC2086
  compgen -G "$python"/$library >/dev/null ||
    { python3 -m venv "$python" && "$python/bin/pip" install --quiet --no-deps --retries 1 --timeout 60 pyoidn==2.5.1.0; } ||
    echo "test.sh: pyoidn cannot be installed from PyPI; the test of --denoise is left out" >&2
  # shellcheck disable=SC2086
  EIKON_OIDN="$(compgen -G "$python"/$library || true)"
  export EIKON_OIDN
fi
# The encoder of Basis Universal and the decoder that belongs to it, in no package of Debian 12.
# Without them one test is left out.
if [[ -z "${EIKON_BASISU-}" ]]; then
  "$python/bin/python" -c 'import alktx2' 2>/dev/null ||
    { python3 -m venv "$python" && "$python/bin/pip" install --quiet --no-deps --retries 1 --timeout 60 alktx2==0.1.7; } ||
    echo "test.sh: alktx2 cannot be installed from PyPI; the test against Basis Universal is left out" >&2
  if "$python/bin/python" -c 'import alktx2' 2>/dev/null; then EIKON_BASISU="$python/bin/python"; fi
  export EIKON_BASISU="${EIKON_BASISU-}"
fi
# The reference implementation of Open Job Description, which no package of Debian 12 has either.
if [[ -z "${EIKON_OPENJD-}" ]]; then
  EIKON_OPENJD="$python/bin/openjd"
  [[ -x "$EIKON_OPENJD" ]] ||
    { python3 -m venv "$python" && "$python/bin/pip" install --quiet --retries 1 --timeout 60 openjd-cli==0.8.0; } ||
    echo "test.sh: openjd-cli cannot be installed from PyPI; the test of templates is left out" >&2
  export EIKON_OPENJD
fi
rm -rf "$build/tests/suites"
ctest --test-dir "$build" --output-on-failure --no-tests=error -j "$(nproc)" --output-junit "$build/tests.xml" "$@"
if [[ -n "${CI-}" ]]; then "$root/tests/skipped.py" "$build/tests.xml" "$build"/tests/suites/*.xml; fi
