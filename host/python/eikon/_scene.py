# SPDX-License-Identifier: Apache-2.0
"""Scenes from arrays: a glTF document in memory, which the reader of files reads."""
from __future__ import annotations

import json
import math
import os
import struct
import zlib
from pathlib import Path
from typing import TYPE_CHECKING, Any, Dict, List, Optional, Sequence, Union

from . import _eikon
from ._picture import shown, write_whole

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

FLOAT, UINT32 = 5126, 5125  # component types of glTF
TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4"}


def png_of(pixels: NDArray[np.uint8]) -> bytes:
    """An 8-bit PNG of an array of shape (height, width), or with 3 or 4 channels."""
    kinds = {1: 0, 3: 2, 4: 6}  # colour types of PNG
    pixels = pixels[:, :, None] if pixels.ndim == 2 else pixels
    if pixels.dtype.name != "uint8" or pixels.ndim != 3 or pixels.shape[2] not in kinds:
        raise _eikon.UsageError(f"an image is an array of uint8 of shape (height, width), or with 3 or 4 channels, not "
                                f"{pixels.dtype.name} of shape {pixels.shape}")
    height, width, channels = pixels.shape

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    header = struct.pack(">IIBBBBB", width, height, 8, kinds[channels], 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 1)) + chunk(b"IEND", b"")


class Scene:
    """A scene of arrays. Units are metres; +Y is up; colours are linear Rec. 709.

    Every method returns a number by which others name what it added.

    >>> import eikon
    >>> scene = eikon.Scene()
    >>> paper = scene.material(pbrMetallicRoughness={"baseColorFactor": [0.8, 0.8, 0.8, 1], "metallicFactor": 0})
    >>> lamp = scene.material(emissiveFactor=[1, 1, 1], extensions={"KHR_materials_emissive_strength": {"emissiveStrength": 9}})
    >>> square = [[-1, 0, -1], [-1, 0, 1], [1, 0, 1], [1, 0, -1]]
    >>> floor = scene.mesh(square, [[0, 1, 2], [0, 2, 3]], material=paper)
    >>> light = scene.mesh(square, [[0, 2, 1], [0, 3, 2]], material=lamp)
    >>> _ = scene.add(floor)
    >>> _ = scene.add(light, translation=(0, 2, 0), scale=(0.2, 1, 0.2))
    >>> image = eikon.render(scene, look_at=((0, 1, 3), (0, 0.5, 0)), fov=50, size=(32, 32), spp=4)
    """

    def __init__(self) -> None:
        self._json: Dict[str, Any] = {"asset": {"version": "2.0", "generator": f"eikon {_eikon.version}"}, "scene": 0,
                                      "scenes": [{"nodes": []}], "nodes": []}
        self._data = bytearray()
        self._extensions: set[str] = set()

    def mesh(self, positions: ArrayLike, indices: Optional[ArrayLike] = None, *, normals: Optional[ArrayLike] = None,
             texcoords: Optional[ArrayLike] = None, texcoords1: Optional[ArrayLike] = None,
             tangents: Optional[ArrayLike] = None, colors: Optional[ArrayLike] = None, material: Optional[int] = None,
             name: Optional[str] = None) -> int:
        """Adds a mesh of triangles; add() places it.

        positions   (n, 3), metres
        indices     (m, 3): three corners per triangle, anticlockwise from the front [each three positions are one]
        normals     (n, 3), unit [flat triangles]
        texcoords   (n, 2): u to the right, v down from the top of the image; texcoords1: the second set
        tangents    (n, 4): unit, and the sign of the bitangent
        colors      (n, 3) or (n, 4), linear: they multiply the base colour
        raises      UsageError for another shape, no positions, and values that are not finite
        """
        attributes = {}
        count = len(positions)  # type: ignore[arg-type]
        if count == 0:
            raise _eikon.UsageError("mesh: there are no positions")
        for key, array, widths in (("POSITION", positions, (3,)), ("NORMAL", normals, (3,)), ("TEXCOORD_0", texcoords, (2,)),
                                   ("TEXCOORD_1", texcoords1, (2,)), ("TANGENT", tangents, (4,)), ("COLOR_0", colors, (3, 4))):
            if array is not None:
                attributes[key] = self._floats(key, array, count, widths)
        primitive: Dict[str, Any] = {"attributes": attributes}
        if indices is not None:
            primitive["indices"] = self._indices(indices)
        if material is not None:
            primitive["material"] = material
        return self._append("meshes", {"primitives": [primitive], **({"name": name} if name else {})})

    def add(self, mesh: Optional[int] = None, *, matrix: Optional[ArrayLike] = None, **node: Any) -> int:
        """Places a mesh; one mesh may be placed any number of times, and takes memory once.

        matrix  (4, 4), world from object; or glTF's translation=, rotation= (a quaternion x, y, z, w) and scale=
        node    any other field of a node of glTF, such as name= or extras=
        """
        if mesh is not None:
            node["mesh"] = mesh
        if matrix is not None:
            node["matrix"] = self._columns(matrix)
        self._note_extensions(node)
        number = self._append("nodes", plain(node))
        self._json["scenes"][0]["nodes"].append(number)
        return number

    def material(self, **fields: Any) -> int:
        """Adds a material, by the names that glTF gives its fields: pbrMetallicRoughness, emissiveFactor, alphaMode, extensions...

        The value of a texture (baseColorTexture, ...) is an image: an array of uint8 of shape (height, width, 3 or 4), the bytes
        of a PNG, JPEG or WebP file, or a path; or a dict that has it as "image" beside texCoord, scale and sampler fields.
        """
        self._note_extensions(fields)
        return self._append("materials", plain(self._with_textures(fields)))

    def light(self, kind: str, *, matrix: Optional[ArrayLike] = None, color: Sequence[float] = (1, 1, 1), intensity: float = 1,
              **fields: Any) -> int:
        """Adds a light without extent [KHR_lights_punctual]. `point` shines from the matrix's origin, in W/sr; `spot` (with
        innerConeAngle= and outerConeAngle=, radians) and `directional` (W/m^2) shine along its -Z."""
        self._extensions.add("KHR_lights_punctual")
        if kind == "spot":
            fields = {"spot": {k: fields.pop(k) for k in ("innerConeAngle", "outerConeAngle") if k in fields}, **fields}
        lights = self._json.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {"lights": []})["lights"]
        lights.append(plain({"type": kind, "color": list(color), "intensity": intensity, **fields}))
        return self.add(matrix=matrix, extensions={"KHR_lights_punctual": {"light": len(lights) - 1}})

    def camera(self, *, fov: Optional[float] = None, height: Optional[float] = None, aspect: Optional[float] = None,
               matrix: Optional[ArrayLike] = None, name: Optional[str] = None) -> int:
        """Adds a camera that looks along the -Z of its matrix (4, 4), world from camera, with +Y up.

        fov     vertical field of view of a perspective camera, degrees; or else
        height  of what an orthographic camera sees, metres
        aspect  width / height
        """
        if (fov is None) == (height is None):
            raise _eikon.UsageError("camera: takes fov (perspective) or height (orthographic)")
        camera: Dict[str, Any] = {"name": name} if name else {}
        if fov is not None:
            camera.update(type="perspective", perspective={"yfov": math.radians(fov), "znear": 0.01})
            if aspect is not None:
                camera["perspective"]["aspectRatio"] = aspect
        elif height is not None:
            half = height / 2
            camera.update(type="orthographic",
                          orthographic={"xmag": half * (aspect or 1), "ymag": half, "znear": 0.01, "zfar": 1e6})
        number = self._append("cameras", camera)
        self.add(matrix=matrix, camera=number)
        return number

    def to_glb(self) -> bytes:
        """The scene as the bytes of a .glb file. raises UsageError if a number of it is not finite"""
        document = dict(self._json)
        if self._data:
            document["buffers"] = [{"byteLength": len(self._data)}]
        if self._extensions:
            document["extensionsUsed"] = sorted(self._extensions)
        try:
            text = json.dumps(document, separators=(",", ":"), allow_nan=False).encode()
        except ValueError as error:
            raise _eikon.UsageError("scene: a number of a node, material, light or camera is not finite") from error
        text += b" " * (-len(text) % 4)
        data = bytes(self._data) + b"\0" * (-len(self._data) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text
        if data:
            chunks += struct.pack("<II", len(data), 0x004E4942) + data
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks

    def save(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """Writes the scene as a .glb file. raises UsageError for another ending, InputError when the file cannot be written"""
        target = Path(os.fsdecode(path))
        if target.suffix.lower() != ".glb":
            raise _eikon.UsageError(f"save: a scene is written as a .glb file, and '{shown(target)}' is named otherwise")
        data = self.to_glb()
        write_whole(target, lambda temporary: temporary.write_bytes(data))

    def _append(self, kind: str, value: Dict[str, Any]) -> int:
        values: List[Any] = self._json.setdefault(kind, [])
        values.append(value)
        return len(values) - 1

    def _view(self, data: bytes) -> int:
        self._data += b"\0" * (-len(self._data) % 4)
        view = {"buffer": 0, "byteOffset": len(self._data), "byteLength": len(data)}
        self._data += data
        return self._append("bufferViews", view)

    def _floats(self, key: str, array: ArrayLike, count: int, widths: Sequence[int]) -> int:
        import numpy as np

        if np.iscomplexobj(array):
            raise _eikon.UsageError(f"mesh: {key} has complex numbers")
        values = np.ascontiguousarray(array, "<f4")
        if values.ndim != 2 or len(values) != count or values.shape[1] not in widths:
            shapes = " or ".join(f"({count}, {width})" for width in widths)
            raise _eikon.UsageError(f"mesh: {key} has the shape {shapes}, not {values.shape}")
        if not np.isfinite(values).all():
            raise _eikon.UsageError(f"mesh: {key} has values that are not finite")
        accessor: Dict[str, Any] = {"bufferView": self._view(values.tobytes()), "componentType": FLOAT, "count": count,
                                    "type": TYPES[values.shape[1]]}
        if key == "POSITION":
            accessor.update(min=values.min(0).tolist(), max=values.max(0).tolist())
        return self._append("accessors", accessor)

    def _indices(self, array: ArrayLike) -> int:
        import numpy as np

        values = np.asarray(array)
        if values.dtype.kind not in "ui" or values.size % 3 != 0 or (
                values.size and (values.min() < 0 or values.max() >= 2 ** 32)):
            raise _eikon.UsageError(f"mesh: indices are whole numbers from 0 below 2^32, three per triangle, not {values.dtype.name} of "
                                    f"shape {values.shape}")
        data = np.ascontiguousarray(values, "<u4").tobytes()
        return self._append("accessors", {"bufferView": self._view(data), "componentType": UINT32, "count": values.size,
                                          "type": "SCALAR"})

    def _image(self, image: Any) -> int:
        if isinstance(image, (str, os.PathLike)):
            image = Path(image).read_bytes()
        data = bytes(image) if isinstance(image, (bytes, bytearray, memoryview)) else png_of(image)
        kind = "jpeg" if data[:2] == b"\xff\xd8" else "webp" if data[8:12] == b"WEBP" else "png"
        return self._append("images", {"bufferView": self._view(data), "mimeType": f"image/{kind}"})

    def _texture(self, value: Any) -> Dict[str, Any]:
        info = dict(value) if isinstance(value, dict) else {"image": value}
        if "image" not in info:
            return info  # names a texture by glTF's index
        number = self._image(info.pop("image"))
        is_webp = self._json["images"][number]["mimeType"] == "image/webp"
        texture: Dict[str, Any] = {"source": number}
        if is_webp:
            self._extensions.add("EXT_texture_webp")
            texture = {"extensions": {"EXT_texture_webp": {"source": number}}}
        sampler = {key: info.pop(key) for key in ("magFilter", "minFilter", "wrapS", "wrapT") if key in info}
        if sampler:
            texture["sampler"] = self._append("samplers", sampler)
        return {"index": self._append("textures", texture), **info}

    def _with_textures(self, fields: Dict[str, Any]) -> Dict[str, Any]:
        """Replaces images by textures, at any depth."""
        done = {}
        for key, value in fields.items():
            if key.endswith("Texture"):
                value = self._texture(value)
            elif isinstance(value, dict):
                value = self._with_textures(value)
            done[key] = value
        return done

    def _note_extensions(self, fields: Dict[str, Any]) -> None:
        """Names every extension that is used, at any depth."""
        for key, value in fields.items():
            if key == "extensions":
                self._extensions.update(value)
            if isinstance(value, dict):
                self._note_extensions(value)

    @staticmethod
    def _columns(matrix: ArrayLike) -> List[float]:
        import numpy as np

        values = np.asarray(matrix, np.float64)
        if values.shape != (4, 4):
            raise _eikon.UsageError(f"a matrix has the shape (4, 4), not {values.shape}")
        return [float(value) for value in values.T.ravel()]  # glTF stores columns


def plain(value: Any) -> Any:
    """Arrays and tuples as lists, for JSON."""
    if isinstance(value, dict):
        return {key: plain(each) for key, each in value.items()}
    if hasattr(value, "tolist"):
        return value.tolist()
    return [plain(each) for each in value] if isinstance(value, (list, tuple)) else value
