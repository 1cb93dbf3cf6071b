#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Measures the peak of memory of `eikon info` and of a small render, by the form in which a file has its triangles.

  tools/measure/file_memory.py [--eikon FILE] [--side N]

Each file has the same bumpy sheet of N x N vertices with normals. Needs numpy; gltfpack and draco_encoder (Debian: gltfpack,
draco) make the compressed files, and without them their lines are left out and named.
"""
import argparse
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tools"))
from common.child_process import peak_bytes_from_small_parent  # noqa: E402
from common.flags import add_eikon_flag  # noqa: E402
from scene_builders.glb_file import pack_glb  # noqa: E402

BYTE, SHORT, UNSIGNED, FLOAT = 5120, 5122, 5125, 5126  # types of components in glTF
PLACES = 10  # along each side of the file with instances


class Sheet:
    """Vertices over a square metre, and two triangles for each of its cells."""

    def __init__(self, side):
        y, x = np.mgrid[0:side, 0:side] / (side - 1)
        waves = np.sin(40 * x) * np.cos(30 * y)
        self.positions = np.stack([x, y, 0.05 * waves], axis=-1).reshape(-1, 3).astype("<f4")
        slope_x, slope_y = 2 * np.cos(40 * x) * np.cos(30 * y), -1.5 * np.sin(40 * x) * np.sin(30 * y)
        normals = np.stack([-slope_x, -slope_y, np.ones_like(x)], axis=-1).reshape(-1, 3)
        self.normals = (normals / np.linalg.norm(normals, axis=1, keepdims=True)).astype("<f4")
        a = np.arange(side * side).reshape(side, side)[:-1, :-1].reshape(-1)
        self.indices = np.stack([a, a + 1, a + side, a + 1, a + side + 1, a + side], axis=-1).reshape(-1).astype("<u4")


class Glb:
    """A .glb file of one mesh."""

    def __init__(self):
        self.data = bytearray()
        self.document = {
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "materials": [{"pbrMetallicRoughness": {"metallicFactor": 0}}],
            "meshes": [{"primitives": [{"attributes": {}, "material": 0}]}], "accessors": [], "bufferViews": []}
        self.primitive = self.document["meshes"][0]["primitives"][0]

    def view(self, data, **more):
        """The index of a view of bytes."""
        self.data += b"\0" * (-len(self.data) % 4)
        self.document["bufferViews"].append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data), **more})
        self.data += data
        return len(self.document["bufferViews"]) - 1

    def accessor(self, component, count, kind, **more):
        self.document["accessors"].append({"componentType": component, "count": count, "type": kind, **more})
        return len(self.document["accessors"]) - 1

    def use(self, extension, required=True):
        for key in ["extensionsUsed"] + ["extensionsRequired"] * required:
            self.document.setdefault(key, []).append(extension)

    def add(self, sheet):
        """The sheet in floats."""
        bounds = {"min": sheet.positions.min(axis=0).tolist(), "max": sheet.positions.max(axis=0).tolist()}
        count = len(sheet.positions)
        views = [self.view(array.tobytes()) for array in (sheet.positions, sheet.normals, sheet.indices)]
        self.primitive["attributes"] = {"POSITION": self.accessor(FLOAT, count, "VEC3", bufferView=views[0], **bounds),
                                        "NORMAL": self.accessor(FLOAT, count, "VEC3", bufferView=views[1])}
        self.primitive["indices"] = self.accessor(UNSIGNED, len(sheet.indices), "SCALAR", bufferView=views[2])

    def write(self, path):
        self.document["buffers"] = [{"byteLength": len(self.data)}]
        path.write_bytes(pack_glb(json.dumps(self.document).encode(), self.data))


def make_floats(side, path):
    glb = Glb()
    glb.add(Sheet(side))
    glb.write(path)


def make_lights(side, path):
    glb = Glb()
    glb.add(Sheet(side))
    glb.document["materials"][0]["emissiveFactor"] = [1, 1, 1]
    glb.write(path)


def make_quantised(side, path):
    """Positions of 16 bits and normals of 8, which the node scales (KHR_mesh_quantization)."""
    sheet, glb = Sheet(side), Glb()
    positions = np.zeros((len(sheet.positions), 4), "<i2")
    positions[:, :3] = np.rint(sheet.positions * 32767)
    normals = np.zeros((len(positions), 4), "i1")
    normals[:, :3] = np.rint(sheet.normals * 127)
    bounds = {"min": positions[:, :3].min(axis=0).tolist(), "max": positions[:, :3].max(axis=0).tolist()}
    glb.primitive["attributes"] = {
        "POSITION": glb.accessor(SHORT, len(positions), "VEC3", bufferView=glb.view(positions.tobytes(), byteStride=8), **bounds),
        "NORMAL": glb.accessor(BYTE, len(positions), "VEC3", normalized=True,
                               bufferView=glb.view(normals.tobytes(), byteStride=4))}
    glb.primitive["indices"] = glb.accessor(UNSIGNED, len(sheet.indices), "SCALAR", bufferView=glb.view(sheet.indices.tobytes()))
    glb.document["nodes"][0]["scale"] = [1 / 32767] * 3
    glb.use("KHR_mesh_quantization")
    glb.write(path)


def make_instances(side, path):
    """A sheet with a tenth of the vertices along each side, at a hundred places (EXT_mesh_gpu_instancing)."""
    glb = Glb()
    glb.add(Sheet(side // PLACES + 1))
    y, x = np.mgrid[0:PLACES, 0:PLACES]
    places = np.stack([x, y, 0 * x], axis=-1).reshape(-1, 3).astype("<f4")
    accessor = glb.accessor(FLOAT, len(places), "VEC3", bufferView=glb.view(places.tobytes()))
    glb.document["nodes"][0]["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": accessor}}}
    glb.use("EXT_mesh_gpu_instancing")
    glb.write(path)


def make_meshopt(side, path, *flags):
    floats = path.with_name("floats-for-gltfpack.glb")
    make_floats(side, floats)
    subprocess.run(["gltfpack", "-i", floats, "-o", path, "-c", *flags], check=True, stdout=subprocess.DEVNULL)


def make_draco(side, path):
    """Positions of 14 bits and normals of 10 (KHR_draco_mesh_compression)."""
    sheet, glb = Sheet(side), Glb()
    ply, compressed = path.with_suffix(".ply"), path.with_suffix(".drc")
    vertices, faces = len(sheet.positions), len(sheet.indices) // 3
    properties = "".join("property float %s\n" % name for name in ("x", "y", "z", "nx", "ny", "nz"))
    header = ("ply\nformat binary_little_endian 1.0\nelement vertex %d\n%selement face %d\n"
              "property list uchar int vertex_indices\nend_header\n" % (vertices, properties, faces))
    rows = np.zeros(faces, dtype=[("count", "u1"), ("corners", "<i4", 3)])
    rows["count"], rows["corners"] = 3, sheet.indices.reshape(-1, 3)
    ply.write_bytes(header.encode() + np.hstack([sheet.positions, sheet.normals]).tobytes() + rows.tobytes())
    subprocess.run(["draco_encoder", "-i", ply, "-o", compressed, "-qp", "14", "-qn", "10"], check=True, stdout=subprocess.DEVNULL)
    bounds = {"min": [0, 0, -0.05], "max": [1, 1, 0.05]}
    glb.primitive["attributes"] = {"POSITION": glb.accessor(FLOAT, vertices, "VEC3", **bounds),
                                   "NORMAL": glb.accessor(FLOAT, vertices, "VEC3")}
    glb.primitive["indices"] = glb.accessor(UNSIGNED, 3 * faces, "SCALAR")
    glb.primitive["extensions"] = {"KHR_draco_mesh_compression": {
        "bufferView": glb.view(compressed.read_bytes()), "attributes": {"POSITION": 0, "NORMAL": 1}}}
    glb.use("KHR_draco_mesh_compression")
    glb.write(path)


# In words: what makes the file, and the program that it needs.
FILES = {
    "floats": (make_floats, None),
    "floats, every triangle a light": (make_lights, None),
    "quantised, 16 and 8 bits": (make_quantised, None),
    "meshopt, floats": (lambda side, path: make_meshopt(side, path, "-noq"), "gltfpack"),
    "meshopt, quantised": (make_meshopt, "gltfpack"),
    "Draco": (make_draco, "draco_encoder"),
    f"{PLACES * PLACES} instances of a sheet with {PLACES * PLACES} times fewer": (make_instances, None),
}


def peak_mb(*command):
    """Returns the most memory that a program had at a time, in 10^6 bytes."""
    return 1e-6 * peak_bytes_from_small_parent(*command)  # this process has large arrays


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    add_eikon_flag(parser)
    parser.add_argument("--side", type=int, default=1001, help="vertices along each side [1001, for 2 million triangles]")
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        flags = ["--devices", "cpu", "--size", "64x64", "--spp", "1", "--quiet", "-o", folder / "out.exr"]
        print("| triangles as | file, MB | `info`, MB | a render, MB |\n|---|---|---|---|", flush=True)
        nothing = folder / "nothing.glb"
        make_floats(2, nothing)
        rows = [("two triangles", nothing)]
        for words, (make, needs) in FILES.items():
            if needs is not None and shutil.which(needs) is None:
                print(f"{words}: left out, {needs} is not installed", file=sys.stderr)
                continue
            rows.append((words, make))
        for words, make in rows:
            path = make if isinstance(make, pathlib.Path) else folder / "file.glb"
            if path is not make:
                make(options.side, path)
            peak_mb(options.eikon, "render", path, *flags)  # compiles, which takes memory too
            info, render = peak_mb(options.eikon, "info", path), peak_mb(options.eikon, "render", path, *flags)
            print(f"| {words} | {path.stat().st_size * 1e-6:.1f} | {info:.0f} | {render:.0f} |", flush=True)


if __name__ == "__main__":
    main()
