#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Installs what eikon needs and this machine lacks, on Debian 12; elsewhere names the packages and
# stops.
#   tools/setup.sh          what building and running needs
#   tools/setup.sh tests    that, and what the tests need
# Asks nothing; touches the package manager only when something is missing.
set -euo pipefail
here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
# shellcheck source=tools/packages.sh
source "$here/packages.sh"

needed=("${build_packages[@]}")
case "${1-}" in
  '') ;;
  tests) needed+=("${test_packages[@]}") ;;
  *) echo "setup.sh: unknown argument '$1'; give nothing, or: tests" >&2; exit 2 ;;
esac

system=unknown
if [[ -r /etc/os-release ]]; then
  # shellcheck source=/dev/null
  system="$(source /etc/os-release; echo "${ID-}-${VERSION_ID-}")"
fi
if [[ "$system" != debian-12 ]]; then
  {
    echo "setup.sh: this system ($system) is not Debian 12, so nothing was installed."
    echo "Install the counterparts of these Debian packages, then build with CMake as README.md says:"
    printf '  %s\n' "${needed[@]}"
  } >&2
  exit 1
fi

is_installed() {
  [[ "$(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null)" == installed ]]
}
missing=()
for package in "${needed[@]}"; do
  is_installed "$package" || missing+=("$package")
done
if [[ ${#missing[@]} -eq 0 ]]; then
  exit 0
fi

as_root=()
if [[ $EUID -ne 0 ]]; then
  if ! command -v sudo >/dev/null; then
    echo "setup.sh: not root and no sudo; as root, run: apt-get install --no-install-recommends ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo)
fi
echo "setup.sh: installing ${missing[*]}"
apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq)
"${apt[@]}" update
"${apt[@]}" install -y --no-install-recommends "${missing[@]}" </dev/null
