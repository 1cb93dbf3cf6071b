#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Unpacks the offline compilers of GPUs into FOLDER, of which check.py knows the layout. Nothing is
# installed.
#   tools/gpu/fetch_compilers.sh FOLDER      exit code 0: all are there; 3: not ptxas, as PyPI does
#                                            not give it; 1: Debian's are not
# Takes 110 MB of downloads and 420 MB of space; a folder that is complete is left as it is.
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
# shellcheck source=tools/packages.sh
source "$here/../packages.sh"
[[ $# -eq 1 ]] || { echo "fetch_compilers.sh: give one folder" >&2; exit 2; }
mkdir -p "$1"
to="$(cd "$1" && pwd)"

if [[ "$(cat "$to/debian" 2>/dev/null)" != "${gpu_packages[*]}" ]]; then
  rm -rf "$to"/{debian,debs,root} && mkdir -p "$to"/{debs,root,lists/partial,cache/archives/partial}
  # Where the system has no lists of packages, or old ones, the folder gets its own.
  own=(-o "Dir::State::lists=$to/lists" -o "Dir::Cache=$to/cache")
  download() { (cd "$to/debs" && apt-get -qq "$@" download "${gpu_packages[@]}"); }
  download 2>/dev/null || { apt-get -qq "${own[@]}" update && download "${own[@]}"; } ||
    { echo "fetch_compilers.sh: Debian's packages cannot be had: ${gpu_packages[*]}" >&2; exit 1; }
  for package in "$to"/debs/*.deb; do dpkg -x "$package" "$to/root"; done
  rm -rf "$to"/{debs,lists,cache}
  echo "${gpu_packages[*]}" >"$to/debian"
fi

if [[ "$(cat "$to/pypi" 2>/dev/null)" != "${gpu_wheels[*]}" ]]; then
  rm -rf "$to"/{pypi,wheels,nvidia} && mkdir "$to/wheels"
  { python3 -m venv "$to/python" &&
    "$to/python/bin/pip" download --quiet --no-deps --retries 1 --timeout 60 --dest "$to/wheels" "${gpu_wheels[@]}"; } ||
    { echo "fetch_compilers.sh: PyPI does not give ${gpu_wheels[*]}" >&2; exit 3; }
  for wheel in "$to"/wheels/*.whl; do python3 -m zipfile -e "$wheel" "$to"; done
  chmod +x "$to/nvidia/cuda_nvcc/bin/ptxas"
  rm -rf "$to"/{wheels,python}
  echo "${gpu_wheels[*]}" >"$to/pypi"
fi
