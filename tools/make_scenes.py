#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Writes the scenes of scenes/, always the same bytes. Standard library only.

  tools/make_scenes.py             write every scene
  tools/make_scenes.py --check     fail if a committed scene differs from what this script makes
  tools/make_scenes.py --list      names, and what each proves
  tools/make_scenes.py --figure 50000 out/figure.glb    the walking figure, of about so many triangles
"""

import argparse
import pathlib
import sys

from scene_builders import scenes_analytic
from scene_builders import scenes_figure
from scene_builders import scenes_implicit
from scene_builders import scenes_lambert
from scene_builders import scenes_layers
from scene_builders import scenes_materials
from scene_builders import scenes_media
from scene_builders import scenes_motion
from scene_builders import scenes_rooms

SCENES = pathlib.Path(__file__).resolve().parent.parent / "scenes"
MAKERS = {**scenes_lambert.MAKERS, **scenes_materials.MAKERS, **scenes_layers.MAKERS, **scenes_media.MAKERS, **scenes_analytic.MAKERS, **scenes_implicit.MAKERS,
          **scenes_figure.MAKERS, **scenes_motion.MAKERS, **scenes_rooms.MAKERS}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="write nothing; exit 1 if a committed scene differs")
    parser.add_argument("--list", action="store_true", help="print each scene's name and what it proves")
    parser.add_argument("--out", type=pathlib.Path, default=SCENES, metavar="DIR", help="where to (default: scenes)")
    parser.add_argument("--figure", nargs=2, metavar=("TRIANGLES", "FILE"), help="write the walking figure alone")
    arguments = parser.parse_args()
    if arguments.figure:
        gltf, count = scenes_figure.figure(int(arguments.figure[0]), "Speed of sequences: a figure that walks.")
        gltf.write(arguments.figure[1])
        print(f"{arguments.figure[1]}: {count} triangles")
        return 0
    if arguments.list:
        for name, make in MAKERS.items():
            print(f"{name + '.gltf':28s} {make.__doc__}")
        return 0

    wrong = 0
    readme = (SCENES / "README.md").read_text() if arguments.check else ""
    made = {}
    for name, make in MAKERS.items():
        gltf = make()
        for file, data in {f"{name}.gltf": gltf.gltf(), **gltf.files}.items():
            if made.setdefault(file, data) != data:
                raise RuntimeError(f"{file}: two scenes write it differently")
    for file, data in made.items():
        path = arguments.out / file
        if not arguments.check:
            arguments.out.mkdir(parents=True, exist_ok=True)
            path.write_bytes(data)
            continue
        if not path.exists() or path.read_bytes() != data:
            print(f"{path}: not what tools/make_scenes.py makes; run it, or undo the change", file=sys.stderr)
            wrong += 1
        if f"`{file}`" not in readme:
            print(f"scenes/README.md does not say what {file} is for", file=sys.stderr)
            wrong += 1
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
