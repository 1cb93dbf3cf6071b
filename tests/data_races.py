#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""On a device that launches each stage alone, as GPUs do, no two work-items touch a word at the same time, and none touches what
is not its buffer's.

    data_races.py EIKON

Runs of Oclgrind's race check, which between them compile every feature of kernels/shared/features.def, every integrator and every
layout of trees for GPUs. On other devices work-items of a group run one after the other, so no comparison of bits sees a race.
At the end kernels whose work-items share a path must be found out, or the test would prove nothing."""
import array
import base64
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
LAYERS = ("albedo,normal,geometric_normal,depth,position,uv,id,object_id,material_id,cryptomatte_object,cryptomatte_material,"
          "emission,direct,indirect,light_groups,variance,samples")
TEXTURE = {"index": 1}

# Materials that have everything between them, on what textured.gltf shows.
MATERIALS = [
    {"KHR_materials_anisotropy": {"anisotropyStrength": 0.5, "anisotropyTexture": TEXTURE},
     "KHR_materials_sheen": {"sheenColorFactor": [1, 1, 1], "sheenColorTexture": TEXTURE, "sheenRoughnessTexture": TEXTURE,
                             "sheenRoughnessFactor": 0.5},
     "KHR_materials_clearcoat": {"clearcoatFactor": 0.5, "clearcoatTexture": TEXTURE, "clearcoatRoughnessTexture": TEXTURE,
                                 "clearcoatRoughnessFactor": 0.5, "clearcoatNormalTexture": {"index": 3}}},
    {"KHR_materials_iridescence": {"iridescenceFactor": 1, "iridescenceTexture": TEXTURE, "iridescenceThicknessTexture": TEXTURE},
     "KHR_materials_specular": {"specularTexture": TEXTURE, "specularColorTexture": TEXTURE}},
    {"KHR_materials_transmission": {"transmissionFactor": 0.9, "transmissionTexture": TEXTURE},
     "KHR_materials_specular": {"specularFactor": 0.5},
     "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 1, "attenuationColor": [0.5, 0.8, 0.9]},
     "KHR_materials_dispersion": {"dispersion": 1}},
    {"KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 0.5, "diffuseTransmissionTexture": TEXTURE,
                                            "diffuseTransmissionColorTexture": TEXTURE}},
    {"KHR_materials_unlit": {}},
    {"EIKON_materials_conductor": {"metal": "Au"}},
    {"EIKON_materials_phong": {}},
    {"EIKON_materials_measured": {"uri": "measured.binary"}},
    {"KHR_materials_specular": {"specularFactor": 0}},
]
SHAPES = [{"type": "sphere"}, {"type": "box"}, {"type": "plane", "plane": {"sizeX": 1, "sizeZ": 1}}, {"type": "cylinder"},
          {"type": "capsule"}]
LIGHTS = [{"type": kind, "intensity": 5} for kind in ("point", "spot", "directional")]
PERSPECTIVE = {"type": "perspective", "perspective": {"yfov": 0.5, "znear": 0.01}}
CAMERAS = [{**PERSPECTIVE, "extensions": {"EIKON_camera_lens": {"radius": 0.01, "focusDistance": 4}}},
           {**PERSPECTIVE, "extensions": {"EIKON_camera_panorama": {}}},
           {"type": "orthographic", "orthographic": {"xmag": 2, "ymag": 2, "znear": 0.01, "zfar": 100}}]

# (scene, options). The first camera of `everything` is a plain one; `unmeasured` lacks the measured
# material. Oclgrind takes long to clear what it keeps for each byte of the buffers, so memory is
# little and the large table is in one run.
RUNS = [
    ("everything", "--memory 48M --light-paths off --transparent --filter gaussian --roulette 0.8 --energy-compensation on --max-depth 4"),
    ("unmeasured", "--light-paths off --memory 8M --camera 1 --layout bvh4 --integrator direct --light-samples 3"),
    ("unmeasured", "--light-paths off --memory 8M --camera 2 --layout cwbvh --integrator whitted"),
    ("unmeasured", "--light-paths off --memory 12M --camera 3 --integrator raycast"),
    ("lamps", f"--memory 8M --aov {LAYERS}"),
    ("cornell_spheres", "--memory 4M --light-paths 1 --aov direct,light_groups --max-depth 4"),
    ("cornell_spheres", "--memory 4M --light-paths 1 --caustics merge --aov direct,light_groups --max-depth 4"),
    ("places", "--memory 2M --instances two-level --light-sampling light --max-depth 4"),
    ("cornell", "--memory 2M --integrator direct --light-samples 8"),
    ("cornell", "--memory 2M --max-depth 4 --guiding 64"),
    ("moving", "--memory 2M --shutter 0.5 --fps 1 --aov motion --max-depth 4"),
    ("tumbler", "--memory 2M --aov direct,indirect --max-depth 4"),
    ("veach_plates", "--memory 2M --light-paths 1 --max-depth 4"),  # glossy targets
    ("implicit_metaballs", "--memory 2M --max-depth 3"),
    ("window_room", "--memory 2M --light-sampling hemisphere --max-depth 4"),
]


def write_everything(folder):
    scene = json.loads((ROOT / "scenes/textured.gltf").read_text())
    for name in ("tiles_color.png", "tiles_metallic_roughness.png", "tiles_normal.png", "sky.hdr"):
        shutil.copy(ROOT / "scenes" / name, folder)
    with open(folder / "measured.binary", "wb") as table:
        array.array("i", [90, 90, 180]).tofile(table)
        array.array("d", [100.0] * (3 * 90 * 90 * 180)).tofile(table)
    for mesh in scene["meshes"]:
        for primitive in mesh["primitives"]:
            primitive["attributes"]["TEXCOORD_1"] = primitive["attributes"]["TEXCOORD_0"]
            primitive["attributes"]["COLOR_0"] = primitive["attributes"].get("NORMAL", primitive["attributes"]["POSITION"])
    first = len(scene["materials"])
    tiles = scene["materials"][1]
    tiles["pbrMetallicRoughness"]["metallicFactor"] = 0.5
    for number, extensions in enumerate(MATERIALS):
        scene["materials"].append({**tiles, "extensions": extensions, "doubleSided": number % 2 == 0,
                                   "alphaMode": "BLEND" if number == 0 or "KHR_materials_volume" in extensions else "OPAQUE"})
        if "KHR_materials_volume" in extensions:  # a solid with openings, which only a closed mesh or a shape can be
            scene["materials"][-1]["pbrMetallicRoughness"] = {"metallicFactor": 0.5, "baseColorFactor": [1, 1, 1, 0.5]}
            scene["nodes"].append({"translation": [0, 1, 0], "scale": [0.2, 0.2, 0.2], "extensions": {
                "EIKON_shape": {"shape": SHAPES[0], "material": first + number}}})
        mesh = json.loads(json.dumps(scene["meshes"][3 if number % 2 else 1]))
        mesh["primitives"][0]["material"] = first + number
        scene["meshes"].append(mesh)
        scene["nodes"].append({"mesh": len(scene["meshes"]) - 1, "translation": [0.4 * number - 1.6, 0.6, 0.5]})
    scene["materials"][first]["pbrMetallicRoughness"]["baseColorTexture"] = {"index": 1, "texCoord": 1}
    glowing = len(scene["materials"])
    scene["materials"].append({"emissiveFactor": [1, 1, 1], "extras": {"lightGroup": "shapes"}})
    for number, shape in enumerate(SHAPES):
        scene["nodes"].append({"translation": [0.5 * number - 1, 1.4, 0], "scale": [0.2, 0.2, 0.2], "extensions": {
            "EIKON_shape": {"shape": shape, "material": glowing}}})
    scene["extensions"] = {"KHR_lights_punctual": {"lights": LIGHTS}}
    for number in range(len(LIGHTS)):
        scene["nodes"].append({"translation": [0.5, 3, number], "extensions": {"KHR_lights_punctual": {"light": number}}})
    for number, camera in enumerate(CAMERAS):
        scene["cameras"].append(camera)
        scene["nodes"].append({**scene["nodes"][4], "camera": 1 + number})
    scene["scenes"][0]["nodes"] = list(range(len(scene["nodes"])))
    scene.pop("extensionsUsed")
    (folder / "everything.gltf").write_text(json.dumps(scene))
    for material in scene["materials"]:
        material.get("extensions", {}).pop("EIKON_materials_measured", None)
    (folder / "unmeasured.gltf").write_text(json.dumps(scene))


def write_places(folder):
    """The Cornell box, with its first block at several places."""
    scene = json.loads((ROOT / "scenes/cornell.gltf").read_text())
    blocks = [n for n in scene["nodes"] if "block" in n.get("name", "")]
    for number in range(3):
        scene["nodes"].append({**blocks[0], "translation": [0.05 * number, 0.01 * number, 0]})
        scene["scenes"][0]["nodes"].append(len(scene["nodes"]) - 1)
    (folder / "places.gltf").write_text(json.dumps(scene))


def write_moving(folder):
    """The Cornell box with a bulb, in which a block, the lamp, the bulb and the camera move."""
    scene = json.loads((ROOT / "scenes/cornell.gltf").read_text())
    scene["extensions"] = {"KHR_lights_punctual": {"lights": LIGHTS[:1]}}
    scene["scenes"][0]["nodes"].append(len(scene["nodes"]))
    scene["nodes"].append({"name": "bulb", "translation": [0.2, 0.3, 0], "extensions": {"KHR_lights_punctual": {"light": 0}}})
    moving = [i for i, node in enumerate(scene["nodes"]) if node.get("name") in ("short block", "light", "bulb", "camera")]
    begins = [scene["nodes"][i].get("translation", [0, 0, 0]) for i in moving]
    values = [0.0, 1.0] + [x for begin in begins for x in (*begin, begin[0] + 0.05, *begin[1:])]
    uri = "data:application/octet-stream;base64," + base64.b64encode(array.array("f", values).tobytes()).decode()
    buffer, view, accessor = len(scene["buffers"]), len(scene["bufferViews"]), len(scene["accessors"])
    scene["buffers"].append({"uri": uri, "byteLength": 4 * len(values)})
    scene["bufferViews"].append({"buffer": buffer, "byteLength": 4 * len(values)})
    scene["accessors"].append({"bufferView": view, "componentType": 5126, "count": 2, "type": "SCALAR", "min": [0], "max": [1]})
    for number in range(len(moving)):
        scene["accessors"].append({"bufferView": view, "byteOffset": 8 + 24 * number, "componentType": 5126, "count": 2,
                                   "type": "VEC3"})
    scene["animations"] = [{
        "samplers": [{"input": accessor, "output": accessor + 1 + number} for number in range(len(moving))],
        "channels": [{"sampler": number, "target": {"node": node, "path": "translation"}} for number, node in enumerate(moving)]}]
    scene.pop("extensionsUsed", None)
    (folder / "moving.gltf").write_text(json.dumps(scene))


def break_kernels(folder):
    """A copy of the kernels in which all work-items of stage `shadow` serve the same path."""
    shutil.copytree(ROOT / "kernels", folder / "kernels")
    stage = folder / "kernels/stages/shadow.cl"
    text = stage.read_text()
    broken = text.replace("queue_shadow + EK_ENTRY", "queue_shadow")
    assert broken != text, "the test is blind"
    stage.write_text(broken)
    os.environ["EIKON_KERNEL_DIR"] = str(folder / "kernels")


def run(eikon, scene, options, folder):
    """(what Oclgrind reports, by kind; the features of the programs)"""
    environment = {**os.environ, "EIKON_LANES": "1", "EIKON_FAULT": "device:0:gpu", "EIKON_NO_OPTIMISE": "1",
                   "EIKON_WATCHDOG": "3000", "EIKON_DUMP_PROGRAMS": str(folder)}
    made = folder / f"{scene}.gltf"
    done = subprocess.run(["oclgrind", "--data-races", "--max-errors", "100000", eikon, "render",
                           made if made.exists() else ROOT / "scenes" / made.name, "-o", folder / "out.exr", "--size", "4x4", "--spp", "2",
                           "--quiet", *options.split()], env=environment, capture_output=True, text=True, errors="replace")
    if done.returncode != 0:
        sys.exit(f"{scene} {options}: exit code {done.returncode}: {done.stderr[-2000:]}")
    reports = {}
    for line in re.findall(r"^(Invalid .*|.*data race.*) at ", done.stdout + done.stderr, re.M):
        reports[line] = reports.get(line, 0) + 1
    features = set()
    for file in folder.glob("program_*.options"):
        features |= set(re.findall(r"-DEK_HAS_(\w+)=1", file.read_text()))
        file.unlink()
    return reports, features


def main():
    if shutil.which("oclgrind") is None:
        print("Oclgrind is not installed")
        sys.exit(77)
    every = set(re.findall(r"^EK_\w+\((\w+)", (ROOT / "kernels/shared/features.def").read_text(), re.M))
    failed = False
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        write_everything(folder)
        write_places(folder)
        write_moving(folder)
        for scene, options in RUNS:
            reports, features = run(sys.argv[1], scene, options, folder)
            every -= features
            failed |= bool(reports)
            print(f"{scene} {options}: {reports or 'no race'}", flush=True)
        break_kernels(folder)
        blind = not run(sys.argv[1], "cornell", "--memory 2M --max-depth 2", folder)[0]
    if every:
        print("no run has", *sorted(every))
    if blind:
        print("the test is blind: it does not see that work-items share a path")
    return 1 if failed or every or blind else 0


if __name__ == "__main__":
    sys.exit(main())
