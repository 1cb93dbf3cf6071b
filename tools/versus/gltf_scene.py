# SPDX-License-Identifier: Apache-2.0
"""Reads what eikon renders of a glTF file, for handing the same scene to another renderer. Needs numpy.

Covers triangles, transforms, metallic-roughness materials with textures, transmission, volumes, opacity, emission,
environments, punctual lights and perspective cameras; whatever else would change the picture is refused by name, because
a comparison of two different scenes proves nothing.
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
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}
UNDERSTOOD = {"KHR_materials_specular", "KHR_materials_emissive_strength", "KHR_materials_ior",
              "KHR_materials_transmission", "KHR_materials_volume"}


@dataclasses.dataclass(frozen=True)
class Texture:
    """One use of a picture. encoded: the PNG or JPEG file's bytes; image_from_uv: 2x3, from the mesh's (u, v, 1) to the
    picture's, v down from the top; wrap: per axis "repeat", "clamp" or "mirror"."""
    name: str
    encoded: bytes
    image_from_uv: tuple
    wrap: tuple
    nearest: bool
    scale: float  # of a normal map


@dataclasses.dataclass
class Material:
    """A glTF material with its defaults filled in; factors multiply their textures."""
    name: str = "default"
    base_color: tuple = (1.0, 1.0, 1.0)
    opacity: float = 1.0
    metallic: float = 1.0
    roughness: float = 1.0
    ior: float = 1.5
    specular: float = 1.0
    specular_color: tuple = (1.0, 1.0, 1.0)
    transmission: float = 0.0
    solid: bool = False
    attenuation_color: tuple = (1.0, 1.0, 1.0)
    attenuation_distance: float = math.inf
    emission: tuple = (0.0, 0.0, 0.0)
    alpha_mode: str = "OPAQUE"
    alpha_cutoff: float = 0.5
    double_sided: bool = False
    base_color_texture: Texture | None = None
    metallic_roughness_texture: Texture | None = None
    normal_texture: Texture | None = None
    emissive_texture: Texture | None = None

    @property
    def emits(self):
        return max(self.emission) > 0


@dataclasses.dataclass
class Part:
    """A primitive of a node, in world space. positions, normals: (n, 3) float64, or None; uv: (n, 2) or None; tangents:
    (n, 4), the last is the bitangent's sign, or None; triangles: (m, 3) uint32."""
    name: str
    positions: np.ndarray
    normals: np.ndarray | None
    uv: np.ndarray | None
    tangents: np.ndarray | None
    triangles: np.ndarray
    material: Material
    material_index: int | None  # in the file


@dataclasses.dataclass
class Camera:
    """world_from_camera: 4x4, looks along -Z with +Y up; yfov in radians; aspect = width / height."""
    world_from_camera: np.ndarray
    yfov: float
    aspect: float


@dataclasses.dataclass
class Environment:
    """radiance, the same from everywhere, or `path` of an equirectangular picture: its middle is -Z, +Y is up, u grows
    towards +X; turned about +Y."""
    radiance: tuple | None
    path: pathlib.Path | None = None
    scale: float = 1.0
    rotate_deg: float = 0.0


@dataclasses.dataclass
class PunctualLight:
    """KHR_lights_punctual. intensity: colour times W / sr, or W / m^2 of a directional light; direction: the light's way."""
    kind: str
    intensity: tuple
    position: np.ndarray
    direction: np.ndarray


@dataclasses.dataclass
class Scene:
    parts: list
    camera: Camera | None
    environment: Environment | None
    lights: list


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

    def image(self, index):
        """(name, bytes as encoded) of a picture."""
        entry = self.root["images"][index]
        if "bufferView" in entry:
            view = self.root["bufferViews"][entry["bufferView"]]
            start = view.get("byteOffset", 0)
            data = bytes(self._buffer(view["buffer"])[start:start + view["byteLength"]])
        elif entry["uri"].startswith("data:"):
            data = base64.b64decode(entry["uri"].split(",", 1)[1])
        else:
            data = (self.folder / urllib.parse.unquote(entry["uri"])).read_bytes()
        return entry.get("name", f"image {index}"), data

    def accessor(self, index):
        entry = self.root["accessors"][index]
        if "sparse" in entry or "bufferView" not in entry:
            raise ValueError(f"accessor {index}: sparse and empty accessors are not read here")
        if entry.get("normalized"):
            raise ValueError(f"accessor {index}: normalized integers are not read here")
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


def _texture(file, reference, user):
    """The Texture of a textureInfo, or None."""
    if reference is None:
        return None
    transform = reference.get("extensions", {}).get("KHR_texture_transform", {})
    if transform.get("texCoord", reference.get("texCoord", 0)) != 0:
        raise ValueError(f"{user}: a second set of texture coordinates is not read here")
    entry = file.root["textures"][reference["index"]]
    if "source" not in entry:
        raise ValueError(f"{user}: a texture without a PNG or JPEG source")
    sampler = file.root["samplers"][entry["sampler"]] if "sampler" in entry else {}
    wraps = {10497: "repeat", 33071: "clamp", 33648: "mirror"}
    # The extension turns counter-clockwise as seen with v down: u' = c u + s v, v' = -s u + c v,
    # after the scale.
    c, s = math.cos(transform.get("rotation", 0.0)), math.sin(transform.get("rotation", 0.0))
    (x, y), (sx, sy) = transform.get("offset", (0.0, 0.0)), transform.get("scale", (1.0, 1.0))
    return Texture(*file.image(entry["source"]), ((c * sx, s * sy, x), (-s * sx, c * sy, y)),
                   (wraps[sampler.get("wrapS", 10497)], wraps[sampler.get("wrapT", 10497)]),
                   sampler.get("magFilter") == 9728, reference.get("scale", 1.0))


def _material(file, index):
    """The Material with that index; raises ValueError when it has what is not read here."""
    if index is None:
        return Material()
    entry = file.root["materials"][index]
    user = f"material {entry.get('name', index)!r}"
    surface, extensions = entry.get("pbrMetallicRoughness", {}), entry.get("extensions", {})
    for unknown in sorted(set(extensions) - UNDERSTOOD):
        raise ValueError(f"{user}: {unknown} has no counterpart here")
    for name, extension in extensions.items():
        for key in extension:
            if key.endswith("Texture") and key != "thicknessTexture":
                raise ValueError(f"{user}: {name}.{key} has no counterpart here")
    color = surface.get("baseColorFactor", (1, 1, 1, 1))
    specular = extensions.get("KHR_materials_specular", {})
    volume = extensions.get("KHR_materials_volume", {})
    strength = extensions.get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0)
    return Material(
        name=entry.get("name", str(index)), base_color=tuple(color[:3]), opacity=color[3],
        metallic=surface.get("metallicFactor", 1.0), roughness=surface.get("roughnessFactor", 1.0),
        ior=extensions.get("KHR_materials_ior", {}).get("ior", 1.5),
        specular=specular.get("specularFactor", 1.0), specular_color=tuple(specular.get("specularColorFactor", (1, 1, 1))),
        transmission=extensions.get("KHR_materials_transmission", {}).get("transmissionFactor", 0.0),
        solid=volume.get("thicknessFactor", 0.0) > 0, attenuation_color=tuple(volume.get("attenuationColor", (1, 1, 1))),
        attenuation_distance=volume.get("attenuationDistance", math.inf),
        emission=tuple(strength * e for e in entry.get("emissiveFactor", (0, 0, 0))),
        alpha_mode=entry.get("alphaMode", "OPAQUE"), alpha_cutoff=entry.get("alphaCutoff", 0.5),
        double_sided=entry.get("doubleSided", False),
        base_color_texture=_texture(file, surface.get("baseColorTexture"), user),
        metallic_roughness_texture=_texture(file, surface.get("metallicRoughnessTexture"), user),
        normal_texture=_texture(file, entry.get("normalTexture"), user),
        emissive_texture=_texture(file, entry.get("emissiveTexture"), user))


def _environment(file, chosen):
    entry = chosen.get("extras", {}).get("environment")
    if entry is None:
        return None
    if "uri" in entry:
        return Environment(None, file.folder / urllib.parse.unquote(entry["uri"]), entry.get("scale", 1.0),
                           entry.get("rotate", 0.0))
    return Environment(tuple(entry["radiance"]))


def _light(file, index, world):
    entry = file.root["extensions"]["KHR_lights_punctual"]["lights"][index]
    if entry["type"] == "spot" or "range" in entry:
        raise ValueError(f"light {entry.get('name', index)!r}: spots and ranges have no counterpart here")
    direction = -world[:3, 2]
    return PunctualLight(entry["type"], tuple(c * entry.get("intensity", 1.0) for c in entry.get("color", (1, 1, 1))),
                         world[:3, 3], direction / np.linalg.norm(direction))


def _part(file, name, primitive, world):
    if primitive.get("mode", 4) != 4:
        raise ValueError(f"node {name}: only triangle lists are read here")
    attributes = primitive["attributes"]
    if "COLOR_0" in attributes:
        raise ValueError(f"node {name}: vertex colours are not read here")
    linear = world[:3, :3]
    positions = file.accessor(attributes["POSITION"]).astype(np.float64) @ linear.T + world[:3, 3]
    normals = uv = tangents = None
    if "NORMAL" in attributes:
        normals = file.accessor(attributes["NORMAL"]) @ np.linalg.inv(linear)
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    if "TEXCOORD_0" in attributes:
        uv = file.accessor(attributes["TEXCOORD_0"]).astype(np.float64)
    if "TANGENT" in attributes:
        tangents = file.accessor(attributes["TANGENT"]).astype(np.float64)
        tangents[:, :3] = tangents[:, :3] @ linear.T
    if "indices" in primitive:
        triangles = file.accessor(primitive["indices"]).astype(np.uint32).reshape(-1, 3)
    else:
        triangles = np.arange(len(positions), dtype=np.uint32).reshape(-1, 3)
    if np.linalg.det(linear) < 0:
        triangles = triangles[:, ::-1]  # a mirrored node keeps its front on the same side of the object
        if tangents is not None:
            tangents[:, 3] *= -1
    index = primitive.get("material")
    return Part(name, positions, normals, uv, tangents, triangles, _material(file, index), index)


def _refuse_unread(root, node, user):
    """Raises ValueError when a node has what decides its place or its form, and is not read here."""
    unknown = set(node.get("extensions", {})) - {"KHR_lights_punctual"}
    if unknown and "mesh" not in node:  # beside a mesh they describe the same, for those that know them
        raise ValueError(f"node {user}: {', '.join(sorted(unknown))} has no counterpart here")
    if "EXT_mesh_gpu_instancing" in unknown:
        raise ValueError(f"node {user}: instances are not read here")
    mesh = root["meshes"][node["mesh"]] if "mesh" in node else {"primitives": []}
    if "skin" in node or any("targets" in primitive for primitive in mesh["primitives"]):
        raise ValueError(f"node {user}: skins and morph targets are not read here")


def load(path):
    """The default scene of a .gltf or .glb file. Raises ValueError naming what cannot be carried over."""
    file = _File(pathlib.Path(path))
    root = file.root
    chosen = root["scenes"][root.get("scene", 0)]
    scene = Scene([], None, _environment(file, chosen), [])
    if root.get("animations"):
        raise ValueError("animations are not read here")
    stack = [(index, np.eye(4)) for index in reversed(chosen["nodes"])]
    while stack:
        index, parent = stack.pop()
        node = root["nodes"][index]
        world = parent @ _local(node)
        stack += [(child, world) for child in reversed(node.get("children", []))]
        if "camera" in node and scene.camera is None:
            lens = root["cameras"][node["camera"]]["perspective"]
            scene.camera = Camera(world, lens["yfov"], lens.get("aspectRatio", 1.0))
        light = node.get("extensions", {}).get("KHR_lights_punctual", {}).get("light")
        if light is not None:
            scene.lights.append(_light(file, light, world))
        _refuse_unread(root, node, node.get("name", index))
        if "mesh" in node:
            for number, primitive in enumerate(root["meshes"][node["mesh"]]["primitives"]):
                scene.parts.append(_part(file, f"{node.get('name', index)}.{number}", primitive, world))
    return scene


def merged(parts):
    """The parts with those of one material and the same attributes made one: renderers that pay per mesh pay per
    material then. Order, and with it the picture, stays."""
    groups = {}
    for part in parts:
        given = tuple(values is not None for values in (part.normals, part.uv, part.tangents))
        groups.setdefault((part.material_index, given), []).append(part)

    def joined(group, name):
        return None if getattr(group[0], name) is None else np.concatenate([getattr(part, name) for part in group])

    result = []
    for group in groups.values():
        starts = np.cumsum([0] + [len(part.positions) for part in group[:-1]])
        triangles = np.concatenate([part.triangles + np.uint32(start) for part, start in zip(group, starts)])
        result.append(Part(group[0].name, joined(group, "positions"), joined(group, "normals"), joined(group, "uv"),
                           joined(group, "tangents"), triangles, group[0].material, group[0].material_index))
    return result
