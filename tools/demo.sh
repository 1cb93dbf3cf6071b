#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# From a fresh clone to a picture: installs what is missing, builds Release, renders the Cornell
# box, says where it is.
# Arguments replace the settings of the render, e.g.  tools/demo.sh --size 1024x1024 --spp 1024
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
build="$root/build-release"
settings=(--exposure 1 --size 512x512 --spp 256)
if [[ $# -gt 0 ]]; then settings=("$@"); fi

"$root/tools/setup.sh"
cmake --log-level=WARNING -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DEIKON_TESTS=OFF \
  -DCMAKE_UNITY_BUILD=ON
cmake --build "$build" --target eikon
mkdir -p "$root/out"
"$build/eikon" render "$root/scenes/cornell.gltf" -o "$root/out/cornell.exr" --png "$root/out/cornell.png" \
  "${settings[@]}"
echo
echo "The picture: $root/out/cornell.png"
echo "The image:   $root/out/cornell.exr"
