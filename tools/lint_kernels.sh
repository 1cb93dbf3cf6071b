#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Compiles every stage offline: no device is needed, warnings are errors. The kernel `paths`
# includes the code of every stage of a path, so it alone is compiled with every layout and with
# each feature alone; the others with all features and with none. At last no division and no root
# may be left that the driver has to round (kernels/lanes/division.h), with each feature alone and
# all.
set -euo pipefail
cd "$(dirname "$0")/.."
clang=${CLANG:-clang-14}
mapfile -t features < <(sed -nE 's/^EK_(LOBE|LIGHT|SHAPE_KIND|OPTION|AOV)\(([a-z0-9_]+).*/\2/p' kernels/shared/features.def)
mapfile -t layouts < <(sed -nE 's/^EK_(LAYOUT|CELLS)\(([a-z0-9]+).*/\2/p' kernels/shared/layouts.def)
mapfile -t stages < <(sed -nE 's/^EK_(PATH_)?STAGE\(([a-z0-9_]+)\).*/\2/p' kernels/shared/stages.def)
mapfile -t -O "${#stages[@]}" stages < <(sed -nE 's/^EK_CLASS_STAGE\(([a-z0-9_]+)\).*/by_class\/\1/p' kernels/shared/stages.def)

# lint STAGE WIDTH CHUNKED LAYOUT FEATURE|all|none SMALL [option of the compiler ...]
lint() {
  local defines=()
  for feature in "${features[@]}"; do
    if [[ $5 == all || $5 == "$feature" ]]; then defines+=("-DEK_HAS_$feature=1"); else defines+=("-DEK_HAS_$feature=0"); fi
  done
  for layout in "${layouts[@]}" none; do
    if [[ $4 == "$layout" ]]; then defines+=("-DEK_LAYOUT_$layout=1"); else defines+=("-DEK_LAYOUT_$layout=0"); fi
  done
  local more=("${@:7}")
  if [[ ${#more[@]} == 0 ]]; then more=(-fsyntax-only); fi
  "$clang" -x cl -cl-std=CL1.2 -Xclang -finclude-default-header "${more[@]}" -Wall -Wextra -Wundef -Werror \
    -Wno-unused-parameter -Wno-bitwise-instead-of-logical -I kernels "-DEK_WIDTH=$2" "-DEK_CHUNKED=$3" "-DEK_CPU=$3" -DEK_CHUNK=1024 \
    -DEK_STACK_SIZE=64 "-DEK_SMALL_TREE=$6" "-DEK_MEDIUM_TREE=$((1 - $6))" "-DEK_LARGE_TREE=$((1 - $6))" \
    "${defines[@]}" "kernels/stages/$1.cl"
}

count=0
run() {
  lint "$@"
  count=$((count + 1))
}
for which in all none; do
  for shape in "16 1 bvh8" "1 1 none" "1 0 bvh2"; do
    read -r width chunked layout <<<"$shape"
    for stage in "${stages[@]}"; do run "$stage" "$width" "$chunked" "$layout" "$which" 0; done
  done
  for shape in "16 1 bvh16" "16 1 bvh8" "8 1 bvh8" "1 1 none" "1 0 bvh2" "1 0 bvh4" "1 0 cwbvh" "1 0 grid" "1 0 octree" \
    "16 1 kdtree" "1 0 bsp"; do
    read -r width chunked layout <<<"$shape"
    for small in 0 1; do run paths "$width" "$chunked" "$layout" "$which" "$small"; done
  done
done
for feature in "${features[@]}"; do
  run paths 16 1 bvh8 "$feature" 0
  run paths 1 0 bvh2 "$feature" 0
done
code="$(mktemp)"
trap 'rm -f "$code"' EXIT
# no_division STAGE LAYOUT FEATURE|all|none
no_division() {
  lint "$1" 1 1 "$2" "$3" 0 --target=spir64 -DEK_OWN_DIVISION -Xclang -disable-llvm-passes -O1 -S -emit-llvm -o "$code"
  if grep -nE ' fdiv |call.*@_Z[0-9]*sqrt' "$code"; then
    echo "lint_kernels: stage $1 with $3 divides or takes a root by the driver's operation; call div_f and sqrt_f" >&2
    exit 1
  fi
  count=$((count + 1))
}
# Clang makes no code of features that are out, nor of the ways that are for scenes without a
# feature.
for layout in none bvh2 bvh4 cwbvh grid octree kdtree bsp; do no_division paths "$layout" all; done
for feature in none "${features[@]}"; do no_division paths bvh2 "$feature"; done
for stage in light_paths film; do no_division "$stage" bvh2 all; done
# The compilers of some GPUs refuse builtins for pointers to global memory, which Clang takes, so a
# GPU gets none but these.
for stage in "${stages[@]}"; do
  lint "$stage" 1 0 bvh2 all 0 --target=spir64 -E -o "$code"
  if grep -oE '__builtin_[a-z0-9_]+' "$code" | grep -vxE '__builtin_(astype|ctz|inff|offsetof)'; then
    echo "lint_kernels: stage $stage has these builtins on GPUs; leave them to EK_CPU (kernels/lanes/lanes.h)" >&2
    exit 1
  fi
  count=$((count + 1))
done
echo "lint_kernels: $count compilations, no warning"
