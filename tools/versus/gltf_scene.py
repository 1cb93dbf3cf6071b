# SPDX-License-Identifier: Apache-2.0
"""Reads what eikon renders of a glTF file, for handing the same scene to another renderer. Needs numpy.

Covers triangles, transforms, Lambert materials, emission, the constant environment and perspective cameras; whatever
else would change the picture is refused by name, because a comparison of two different scenes proves nothing.
"""

import base64
import dataclasses
import json
import math
import pathlib
import struct
import urllib.parse

import numpy as np

COMPONENTS = {5121: "<u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
WIDTHS = {"SCALAR": 1, "VEC3": 3}
UNDERSTOOD = {"KHR_materials_specular", "KHR_materials_emissive_strength"}


@dataclasses.dataclass
class Part:
    """A primitive of a node, in world space. positions, normals: (n, 3) float64, or None; triangles: (m, 3) uint32."""
    name: str
    positions: np.ndarray
    normals: np.ndarray | None
    triangles: np.ndarray
    color: tuple
    emission: tuple
    double_sided: bool


@dataclasses.dataclass
class Camera:
    """world_from_camera: 4x4, looks along -Z with +Y up; yfov in radians; aspect = width / height."""
    world_from_camera: np.ndarray
    yfov: float
    aspect: float


@dataclasses.dataclass
class Scene:
    parts: list
    camera: Camera | None
    environment: tuple | None


class _File:
    def __init__(self, path):
        data = path.read_bytes()
        self.folder, self.binary = path.parent, None
        if data[:4] == b"glTF":
            offset = 12
            while offset < len(data):
                length, kind = struct.unpack_from("<II", data, offset)
                chunk = data[offset + 8:offset + 8 + length]
                if kind == 0x4E4F534A:
                    self.root = json.loads(chunk)
                elif kind == 0x004E4942:
                    self.binary = chunk
                offset += 8 + length
        else:
            self.root = json.loads(data)
        self.buffers = {}

    def _buffer(self, index):
        if index not in self.buffers:
            uri = self.root["buffers"][index].get("uri")
            if uri is None:
                self.buffers[index] = self.binary
            elif uri.startswith("data:"):
                self.buffers[index] = base64.b64decode(uri.split(",", 1)[1])
            else:
                self.buffers[index] = (self.folder / urllib.parse.unquote(uri)).read_bytes()
        return self.buffers[index]

    def accessor(self, index):
        entry = self.root["accessors"][index]
        if "sparse" in entry or "bufferView" not in entry:
            raise ValueError(f"accessor {index}: sparse and empty accessors are not read here")
        view = self.root["bufferViews"][entry["bufferView"]]
        kind, width = np.dtype(COMPONENTS[entry["componentType"]]), WIDTHS[entry["type"]]
        stride = view.get("byteStride", kind.itemsize * width)
        offset = view.get("byteOffset", 0) + entry.get("byteOffset", 0)
        return np.ndarray((entry["count"], width), kind, self._buffer(view["buffer"]), offset, (stride, kind.itemsize))


def _local(node):
    """parent_from_node of a node, 4x4."""
    if "matrix" in node:
        return np.array(node["matrix"], np.float64).reshape(4, 4).T
    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    n = math.sqrt(x * x + y * y + z * z + w * w)
    x, y, z, w = x / n, y / n, z / n, w / n
    matrix = np.eye(4)
    matrix[:3, :3] = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]) * np.array(node.get("scale", (1, 1, 1)), np.float64)
    matrix[:3, 3] = node.get("translation", (0, 0, 0))
    return matrix


def _material(root, index):
    """(color, emission, double_sided); raises ValueError when it is not plain Lambert."""
    entry = root["materials"][index] if index is not None else {}
    name = f"material {entry.get('name', index)!r}"
    surface = entry.get("pbrMetallicRoughness", {})
    extensions = entry.get("extensions", {})
    for unknown in sorted(set(extensions) - UNDERSTOOD):
        raise ValueError(f"{name}: {unknown} has no counterpart here")
    if any("Texture" in key for key in [*entry, *surface]):
        raise ValueError(f"{name}: textures have no counterpart here")
    if surface.get("metallicFactor", 1.0) != 0.0:
        raise ValueError(f"{name}: metallic, only Lambert has a counterpart here")
    if extensions.get("KHR_materials_specular", {}).get("specularFactor", 1.0) != 0.0:
        raise ValueError(f"{name}: reflects specularly; set KHR_materials_specular.specularFactor to 0")
    strength = extensions.get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0)
    return (tuple(surface.get("baseColorFactor", (1, 1, 1, 1))[:3]),
            tuple(strength * e for e in entry.get("emissiveFactor", (0, 0, 0))), entry.get("doubleSided", False))


def load(path):
    """The default scene of a .gltf or .glb file. Raises ValueError naming what cannot be carried over."""
    file = _File(pathlib.Path(path))
    root = file.root
    chosen = root["scenes"][root.get("scene", 0)]
    environment = chosen.get("extras", {}).get("environment")
    scene = Scene([], None, None if environment is None else tuple(environment["radiance"]))
    stack = [(index, np.eye(4)) for index in reversed(chosen["nodes"])]
    while stack:
        index, parent = stack.pop()
        node = root["nodes"][index]
        world = parent @ _local(node)
        stack += [(child, world) for child in reversed(node.get("children", []))]
        if "camera" in node and scene.camera is None:
            lens = root["cameras"][node["camera"]]["perspective"]
            scene.camera = Camera(world, lens["yfov"], lens.get("aspectRatio", 1.0))
        if "mesh" not in node:
            continue
        for number, primitive in enumerate(root["meshes"][node["mesh"]]["primitives"]):
            name = f"{node.get('name', index)}.{number}"
            if primitive.get("mode", 4) != 4:
                raise ValueError(f"node {name}: only triangle lists are read here")
            positions = file.accessor(primitive["attributes"]["POSITION"]).astype(np.float64)
            positions = positions @ world[:3, :3].T + world[:3, 3]
            normals = None
            if "NORMAL" in primitive["attributes"]:
                normals = file.accessor(primitive["attributes"]["NORMAL"]) @ np.linalg.inv(world[:3, :3])
                normals /= np.linalg.norm(normals, axis=1, keepdims=True)
            if "indices" in primitive:
                triangles = file.accessor(primitive["indices"]).astype(np.uint32).reshape(-1, 3)
            else:
                triangles = np.arange(len(positions), dtype=np.uint32).reshape(-1, 3)
            if np.linalg.det(world[:3, :3]) < 0:
                triangles = triangles[:, ::-1]  # a mirrored node keeps its front on the same side of the object
            scene.parts.append(Part(name, positions, normals, triangles, *_material(root, primitive.get("material"))))
    return scene
