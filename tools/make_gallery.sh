#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
# Renders the pictures of README.md into scenes/gallery/:  tools/make_gallery.sh [--eikon FILE]
set -euo pipefail
root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
eikon="$root/build-release/eikon"
case "$#:${1-}" in
  0:) ;;
  2:--eikon) eikon="$2" ;;
  *) echo "usage: tools/make_gallery.sh [--eikon FILE]" >&2; exit 2 ;;
esac
image="$(mktemp --suffix=.exr)"
trap 'rm -f "$image"' EXIT
mkdir -p "$root/scenes/gallery"

# picture SCENE FLAG...
picture() {
  "$eikon" render "$root/scenes/$1.gltf" -o "$image" --png "$root/scenes/gallery/$1.png" --size 240x160 --quiet "${@:2}"
}
picture cornell_spheres --spp 1024 --exposure 1
picture prism --spp 512
picture lacquer --spp 256
picture tumbler --spp 512
picture implicit_gyroid --spp 256
picture textured --spp 256
