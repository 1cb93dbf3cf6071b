#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Measures eikon on a machine's GPUs and leaves all that was found in one archive, with a page of
# tables.
#   tools/bench_gpu.sh                     builds eikon, then takes a quarter of an hour on a fast
#                                          GPU
#   tools/bench_gpu.sh --eikon FILE        takes a program that is there
#   tools/bench_gpu.sh --help              devices, steps, sizes
# tools/gpu/README.md says what the tables mean.
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
for argument in "$@"; do
  case "$argument" in --eikon | --eikon=* | -h | --help) exec python3 "$root/tools/gpu/bench_gpu.py" "$@" ;; esac
done
build="$root/build-release"
"$root/tools/setup.sh"
cmake --log-level=WARNING -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DEIKON_TESTS=OFF \
  -DCMAKE_UNITY_BUILD=ON
cmake --build "$build" --target eikon
exec python3 "$root/tools/gpu/bench_gpu.py" --eikon "$build/eikon" "$@"
