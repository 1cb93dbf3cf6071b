#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Tries a wheel where nothing is but what a release of Debian installs at least, its Python and an
# OpenCL driver: it is installed, its libraries are found, and its examples run.
#   tools/wheel/try.sh WHEEL RELEASE     e.g. tools/wheel/try.sh out/wheels/eikon-*.whl trixie
# Needs root and mmdebstrap (Debian's package of that name). EIKON_TRY_ROOT names a folder for the
# release that is kept.
set -euo pipefail
if [[ $# -ne 2 || ! -f "$1" ]]; then
  echo "try.sh: give a wheel and a release of Debian" >&2
  exit 2
fi
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
wheel="$(realpath "$1")"
bare="${EIKON_TRY_ROOT-}"
if [[ -z "$bare" ]]; then
  bare="$(mktemp -d)"
  trap 'rm -rf "$bare"' EXIT
fi
if [[ ! -x "$bare/usr/bin/python3" ]]; then
  mmdebstrap --variant=minbase --include=python3-minimal,python3-venv,pocl-opencl-icd,ca-certificates "$2" "$bare"
fi
rm -rf "$bare/try"
mkdir "$bare/try"
cp "$wheel" "$bare/try"
for part in scenes host/python/README.md tests/python/examples_test.py; do
  mkdir -p "$bare/try/$(dirname "$part")"
  cp -r "$root/$part" "$bare/try/$part"
done
if [[ -r /etc/ssl/certs/ca-certificates.crt ]]; then cp /etc/ssl/certs/ca-certificates.crt "$bare/try"; fi
cat >"$bare/try/run.sh" <<'INSIDE'
set -eu
cd /try
python3 -m venv tools
tools/bin/python -m pip install --quiet "$1"
# A library that is not found, or that is neither of the wheel nor of those that every Linux has.
ldd tools/lib/python3*/site-packages/eikon/*.so tools/lib/python3*/site-packages/eikon.libs/* |
  awk '/not found/ || ($2 == "=>" && $3 !~ /eikon\.libs/ && $1 !~ /^lib(c|m|dl|rt|pthread|gcc_s|stdc\+\+|z)\.so|^ld-linux/)' >foreign
if [ -s foreign ]; then echo "try.sh: libraries of the system:" >&2; cat foreign >&2; exit 1; fi
tools/bin/python -c 'import eikon; print(eikon.__file__, [d.name for d in eikon.devices()])'
PYTHONPATH= tools/bin/python tests/python/examples_test.py
INSIDE
# PoCL reads what processors and memory there are from /proc and /sys. The mounts end with the
# command.
export SSL_CERT_FILE=/try/ca-certificates.crt PIP_CERT=/try/ca-certificates.crt REQUESTS_CA_BUNDLE=/try/ca-certificates.crt PIP_FIND_LINKS=
# shellcheck disable=SC2016
unshare --mount sh -c 'mount -t proc proc "$1/proc" && mount --rbind /sys "$1/sys" && exec chroot "$1" sh /try/run.sh "$2"' \
  sh "$bare" "$(basename "$wheel")"
echo "try.sh: $(basename "$wheel") works on $2"
