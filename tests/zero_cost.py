#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A scene pays only for what it uses: compiles every stage offline with the features that eikon finds in a Lambert-only scene,
and looks for code of the others in the optimiser's output.

  zero_cost.py EIKON [SCENE]      exit code 0: none found; 1: some; 77: no clang here (CLANG names another than clang-14)

Every function of a feature's header gets a call that the optimiser must keep. None may be left for the scene, and no array
that only other features read may be touched; with all features on, each of them must show, or the test would prove nothing."""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
CLANG = os.environ.get("CLANG", "clang-14")
LAYOUTS = re.findall(r"^EK_(?:LAYOUT|CELLS)\((\w+)", (ROOT / "kernels/shared/layouts.def").read_text(), re.M)
ARRAYS = ["triangle_normals", "triangle_tangents", "triangle_colors", "material_extensions", "material_details", "textures", "texels"]
# Headers of single features, by their paths in kernels/.
FEATURES = re.compile(r"bsdf/(?!bsdf\.|diffuse\.|lobe\.|lobe_traits\.).*|lanes/pose_step\..*|"
                      r"lights/(environment_map|moving_light|photon_map|punctual|shape_.*|light_tree)\..*|"
                      r"shapes/(?!classical|implicit).*|stages/(shade/)?(merge|raycast)\..*|"
                      r"surface/(alpha|dispersion|medium|motion|nested_media|shading_normal|texture)\..*")


def features_of(eikon, scene):
    """{feature: whether the scene needs it}, as `eikon info` says."""
    text = subprocess.run([eikon, "info", scene], check=True, capture_output=True, text=True).stdout
    found = re.findall(r"^  (?:lobe|light|shape|option|layer) +(\w+) +(in|out) ", text, re.M)
    return {name: state == "in" for name, state in found}


def mark(kernels):
    """Puts a call into each function of the headers of single features; returns those headers' names."""
    headers = []
    for path in sorted(kernels.rglob("*.h")):
        name = path.relative_to(kernels).as_posix()
        if not FEATURES.fullmatch(name):
            continue
        marker = "ek_marker_" + re.sub(r"\W", "_", name.removesuffix(".h"))
        text = path.read_text()
        marked = re.sub(r"(^EK_FN [^;{}]*\)\s*\{)", rf"\1 {marker}();", text, flags=re.M)
        if marked == text:
            continue
        path.write_text(re.sub(r"(#ifndef \w+\n#define \w+\n)", rf"\1void {marker}(void);\n", marked, count=1))
        headers.append(marker.removeprefix("ek_marker_"))
    return headers


def compiled(kernels, stage, defines, width, chunked, layout):
    """LLVM's text of a stage, optimised."""
    shape = {"EK_WIDTH": width, "EK_CHUNKED": chunked, "EK_CHUNK": 1024, "EK_STACK_SIZE": 64,
             "EK_SMALL_TREE": 0, "EK_MEDIUM_TREE": 1, "EK_LARGE_TREE": 1}
    shape.update({f"EK_LAYOUT_{name}": int(name == layout) for name in [*LAYOUTS, "none"]})
    flags = [f"-D{name}={value}" for name, value in shape.items()]
    flags += [f"-DEK_HAS_{name}={int(on)}" for name, on in defines.items()]
    command = [CLANG, "-x", "cl", "-cl-std=CL1.2", "-Xclang", "-finclude-default-header", "-fno-discard-value-names", "-O2",
               "-DEK_FN_ONCE=EK_FN",  # all in the kernel, where what it touches is seen
               "-w", "-S", "-emit-llvm", "-o", "-", "-I", str(kernels), *flags, str(kernels / "stages" / (stage + ".cl"))]
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


def touched(text, stage):
    """Arrays of ARRAYS that the kernel uses."""
    body = re.search(rf"^define [^\n]*@{stage}\(.*?^\}}", text, re.M | re.S).group(0)
    return [name for name in ARRAYS if len(re.findall(rf"%{name}\b", body)) > 1]  # once in the signature


def main():
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    if shutil.which(CLANG) is None:
        print(f"zero_cost: there is no {CLANG}; install it, or name another with CLANG=")
        return 77
    scene = sys.argv[2] if len(sys.argv) == 3 else str(ROOT / "scenes" / "cornell.gltf")
    lambert = features_of(sys.argv[1], scene)
    if not lambert or lambert["metallic_roughness"] or lambert["uv"]:
        sys.exit(f"zero_cost: {scene} is not a Lambert-only scene: {lambert}")
    everything = {name: name not in ("uniform_scatter", "one_light", "each_light", "raycast") for name in lambert}
    failures = []
    with tempfile.TemporaryDirectory() as folder:
        marked = pathlib.Path(folder) / "kernels"
        shutil.copytree(ROOT / "kernels", marked)
        headers = mark(marked)
        seen, arrays = set(), set()
        for stage in ("generate", "intersect", "miss", "shade", "shadow"):
            for shape in ((16, 1, "bvh16"), (1, 0, "bvh2")):
                text = compiled(marked, stage, lambert, *shape)
                left = sorted(set(re.findall(r"@ek_marker_(\w+)", text)))
                used = touched(text, stage)  # without a marker it is the text of the kernels as they are
                if left or used:
                    failures.append(f"stage {stage}, {shape[0]} lanes: code of {left}, arrays {used}")
            if stage in ("intersect", "shade", "shadow"):
                for features in (everything, {**everything, "raycast": True}):  # which takes the place of other lobes
                    text = compiled(marked, stage, features, 1, 0, "bvh2")
                    seen.update(re.findall(r"@ek_marker_(\w+)", text))
                    arrays.update(touched(text, stage))
    if len(headers) < 20:
        failures.append(f"only {headers} are looked for: the test is blind")
    missing = sorted(set(headers) - seen) + sorted(set(ARRAYS) - arrays)
    if missing:
        failures.append(f"with all features there is no sign of {missing}: the test is blind")
    for failure in failures:
        print("zero_cost:", failure)
    if not failures:
        print(f"zero_cost: {scene} compiles to no code of {', '.join(sorted(headers))}")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
