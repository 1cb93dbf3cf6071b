#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes a corpus of damaged scenes: good files in which one thing at a time is made to lie.

Every number, string and member of a document that uses all that eikon reads; headers, lengths and contents of binary
chunks, pictures, environments and compressed meshes; files that loop, nest, expand or point where they must not.
Standard library only; the same bytes every time.

    make_corpus.py FOLDER      one folder per case with its files, and FOLDER/cases.txt:
                               NAME <tab> SCENE <tab> good|bad|any

good: the scene must load; bad: it must be refused; any: either, but cleanly (many damaged files are still legal).
"""

import argparse
import base64
import copy
import json
import os
import struct
import sys
import zlib

# A grid of 3 x 3 vertices and 8 triangles, as Draco 1.5.5 and meshoptimizer 0.18 encode it.
DRACO = bytes.fromhex(
    "445241434f02020101000000090802080200037fda07ff0111ff028840ff02884003ff0000000000010000010009030000020101090300010301"
    "030902000202010101000c03ad2a235515032a624cffff3f00fe0f000000e0ff0000000000000000ff070000000000bf000000bf000000000000"
    "803f0b00030101018001713cfff7910303a0cc8aff0000007f00000008010101000b03ad2a1f5515032a624cffffff3f0000fc0f0000000000ff"
    "03000000000000000000000000803f0a"
)
MESHOPT_VERTICES = bytes.fromhex(
    "a0000000013fffc000827eff827eff827e00000001030c0000827e000000000000000000000000000000000000000000000000000000bf000000"
    "bf00000000"
)
MESHOPT_TRIANGLES = bytes.fromhex("e0fe0ffe136f0f5f020f0801f304040104007687566778a9866589689801690000")
MESHOPT_OCTAHEDRAL = bytes.fromhex(
    "a0000000000000000000000000000000000000000000000000000000000000000000007f00"
)
# 8 x 8 pixels, baseline.
JPEG = bytes.fromhex(
    "ffd8ffe000104a46494600010100000100010000ffdb004300100b0c0e0c0a100e0d0e1211101318281a181616183123251d283a333d3c393338"
    "3740485c4e404457453738506d51575f626768673e4d71797064785c656763ffdb0043011112121815182f1a1a2f634238426363636363636363"
    "636363636363636363636363636363636363636363636363636363636363636363636363636363636363ffc0001108000800080301220002110103"
    "1101ffc4001500010100000000000000000000000000000004ffc4001810010003010000000000000000000000000004052231ffc40015010101"
    "00000000000000000000000000000203ffc4001b11000201050000000000000000000000000304000112132131ffda000c030100021103110 03f"
    "00960527320225609776345a2e1a6e7fffd9".replace(" ", "")
)


def png(width=4, height=4, claim=None, rows=None, depth=8, kind=2, interlace=0, good_crc=True):
    """A PNG whose header may claim another size (width, height) than its rows have."""
    channels = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}.get(kind, 3)
    if rows is None:
        rows = b"".join(b"\0" + bytes((x * 37 + y * 11) & 255 for x in range(width * channels)) for y in range(height))

    def chunk(name, data):
        crc = zlib.crc32(name + data) ^ (0 if good_crc else 1)
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", crc)

    size = claim or (width, height)
    header = struct.pack(">IIBBBBB", size[0], size[1], depth, kind, 0, 0, interlace)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b"")


def hdr(width=8, height=4, claim=None, extra=""):
    size = claim or (width, height)
    text = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n{extra}\n-Y {size[1]} +X {size[0]}\n"
    return text.encode() + bytes((128, 100, 90, 129)) * (width * height)


def exr(width=8, height=4, window=None, channels=("B", "G", "R"), compression=0, line_order=0, offsets=None, drop=0):
    """An OpenEXR scanline file of half zeros and ones, not compressed."""
    x0, y0, x1, y1 = window or (0, 0, width - 1, height - 1)

    def attribute(name, kind, data):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(data)) + data

    channel_list = b"".join(c.encode() + b"\0" + struct.pack("<iBBBBii", 1, 0, 0, 0, 0, 1, 1) for c in channels) + b"\0"
    box = struct.pack("<iiii", x0, y0, x1, y1)
    head = struct.pack("<ii", 20000630, 2)
    head += attribute("channels", "chlist", channel_list)
    head += attribute("compression", "compression", bytes([compression]))
    head += attribute("dataWindow", "box2i", box) + attribute("displayWindow", "box2i", box)
    head += attribute("lineOrder", "lineOrder", bytes([line_order]))
    head += attribute("pixelAspectRatio", "float", struct.pack("<f", 1))
    head += attribute("screenWindowCenter", "v2f", struct.pack("<ff", 0, 0))
    head += attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + b"\0"
    line = struct.pack("<e", 1.0) * (width * len(channels))
    table, at, lines = b"", len(head) + 8 * height, b""
    for y in range(height):
        table += struct.pack("<Q", at if offsets is None else offsets)
        data = struct.pack("<ii", y, len(line)) + line
        lines += data
        at += len(data)
    whole = head + table + lines
    return whole[: len(whole) - drop]


def data_uri(data, kind="application/octet-stream"):
    return f"data:{kind};base64," + base64.b64encode(data).decode()


class Document:
    """A glTF document and the one buffer that it shares."""

    def __init__(self):
        self.buffer = bytearray()
        self.json = {
            "asset": {"version": "2.0"},
            "scene": 0,
            "scenes": [{"nodes": []}],
            "nodes": [],
            "meshes": [],
            "accessors": [],
            "bufferViews": [],
            "buffers": [],
        }

    def view(self, data, **more):
        while len(self.buffer) % 4:
            self.buffer.append(0)
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.buffer), "byteLength": len(data), **more})
        self.buffer += data
        return len(self.json["bufferViews"]) - 1

    def accessor(self, data, component, count, kind, **more):
        self.json["accessors"].append(
            {"bufferView": self.view(data), "componentType": component, "count": count, "type": kind, **more}
        )
        return len(self.json["accessors"]) - 1

    def node(self, **node):
        self.json["nodes"].append(node)
        self.json["scenes"][0]["nodes"].append(len(self.json["nodes"]) - 1)

    def finish(self, uri=None):
        entry = {"byteLength": len(self.buffer)}
        entry["uri"] = uri or data_uri(bytes(self.buffer))
        self.json["buffers"] = [entry]
        return self.json


POINTS = [(x * 0.5 - 0.5, y * 0.5 - 0.5, 0.0) for y in range(3) for x in range(3)]
CORNERS = [v for y in range(2) for x in range(2) for a in [y * 3 + x] for v in (a, a + 1, a + 4, a, a + 4, a + 3)]


def grid_attributes(doc):
    flat = [c for p in POINTS for c in p]
    uv = [c for p in POINTS for c in (p[0] + 0.5, p[1] + 0.5)]
    return {
        "POSITION": doc.accessor(
            struct.pack("<27f", *flat), 5126, 9, "VEC3", min=[-0.5, -0.5, 0.0], max=[0.5, 0.5, 0.0]
        ),
        "NORMAL": doc.accessor(struct.pack("<27f", *([0.0, 0.0, 1.0] * 9)), 5126, 9, "VEC3"),
        "TANGENT": doc.accessor(struct.pack("<36f", *([1.0, 0.0, 0.0, 1.0] * 9)), 5126, 9, "VEC4"),
        "TEXCOORD_0": doc.accessor(struct.pack("<18f", *uv), 5126, 9, "VEC2"),
        "TEXCOORD_1": doc.accessor(struct.pack("<18H", *[int(c * 65535) for c in uv]), 5123, 9, "VEC2", normalized=True),
        "COLOR_0": doc.accessor(bytes([200, 100, 50, 255] * 9), 5121, 9, "VEC4", normalized=True),
    }


def full_document():
    """One of everything that is read."""
    doc = Document()
    indices = doc.accessor(struct.pack("<24H", *CORNERS), 5123, 24, "SCALAR")
    attributes = grid_attributes(doc)
    sparse = {
        "bufferView": attributes["POSITION"] + 0,
        "componentType": 5126,
        "count": 9,
        "type": "VEC3",
        "sparse": {
            "count": 2,
            "indices": {"bufferView": doc.view(struct.pack("<2H", 1, 7)), "componentType": 5123},
            "values": {"bufferView": doc.view(struct.pack("<6f", 0, -0.5, 0.1, 0, 0.5, 0.1))},
        },
    }
    sparse["bufferView"] = doc.json["accessors"][attributes["POSITION"]]["bufferView"]
    doc.json["accessors"].append(sparse)
    sparse_index = len(doc.json["accessors"]) - 1
    quantised = doc.accessor(
        struct.pack("<36h", *[int(c * 32767) for p in POINTS for c in (*p, 0.0)]), 5122, 9, "VEC3", normalized=True
    )
    doc.json["bufferViews"][-1]["byteStride"] = 8
    image_view = doc.view(png())
    texture = {"index": 0, "texCoord": 0, "extensions": {"KHR_texture_transform": {"offset": [0.1, 0.2], "rotation": 0.5, "scale": [2, 3], "texCoord": 1}}}
    doc.json.update(
        {
            "extensionsUsed": [
                "KHR_materials_ior", "KHR_materials_specular", "KHR_materials_transmission", "KHR_materials_volume",
                "KHR_materials_emissive_strength", "KHR_materials_unlit", "KHR_texture_transform",
                "KHR_lights_punctual", "KHR_mesh_quantization",
            ],
            "extensionsRequired": ["KHR_mesh_quantization"],
            "extensions": {
                "KHR_lights_punctual": {
                    "lights": [
                        {"type": "point", "color": [1, 0.5, 0.25], "intensity": 10, "range": 5, "name": "bulb"},
                        {"type": "spot", "intensity": 20, "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.6}},
                        {"type": "directional", "intensity": 3},
                    ]
                }
            },
            "images": [
                {"bufferView": image_view, "mimeType": "image/png"},
                {"uri": data_uri(JPEG, "image/jpeg")},
                {"uri": data_uri(png(3, 5, kind=6), "image/png")},
            ],
            "samplers": [{"magFilter": 9729, "minFilter": 9987, "wrapS": 33071, "wrapT": 33648}, {"magFilter": 9728}],
            "textures": [{"source": 0, "sampler": 0}, {"source": 1, "sampler": 1}, {"source": 2}],
            "materials": [
                {
                    "name": "all",
                    "pbrMetallicRoughness": {
                        "baseColorFactor": [0.8, 0.7, 0.6, 0.9],
                        "metallicFactor": 0.5,
                        "roughnessFactor": 0.4,
                        "baseColorTexture": texture,
                        "metallicRoughnessTexture": {"index": 1, "texCoord": 1},
                    },
                    "normalTexture": {"index": 2, "scale": 0.8},
                    "occlusionTexture": {"index": 1, "strength": 0.5},
                    "emissiveTexture": {"index": 1},
                    "emissiveFactor": [0.1, 0.2, 0.3],
                    "alphaMode": "MASK",
                    "alphaCutoff": 0.3,
                    "doubleSided": True,
                    "extensions": {
                        "KHR_materials_emissive_strength": {"emissiveStrength": 5},
                        "KHR_materials_ior": {"ior": 1.4},
                        "KHR_materials_specular": {
                            "specularFactor": 0.5,
                            "specularColorFactor": [1, 0.9, 0.8],
                            "specularTexture": {"index": 2},
                            "specularColorTexture": {"index": 1},
                        },
                    },
                },
                {
                    "name": "glass",
                    "pbrMetallicRoughness": {"metallicFactor": 0, "roughnessFactor": 0},
                    "alphaMode": "BLEND",
                    "extensions": {
                        "KHR_materials_transmission": {"transmissionFactor": 1, "transmissionTexture": {"index": 0}},
                        "KHR_materials_volume": {
                            "thicknessFactor": 0.1,
                            "attenuationDistance": 0.5,
                            "attenuationColor": [0.9, 0.5, 0.1],
                        },
                    },
                },
                {"name": "flat", "extensions": {"KHR_materials_unlit": {}}},
            ],
            "meshes": [
                {
                    "name": "grid",
                    "primitives": [{"attributes": attributes, "indices": indices, "material": 0, "mode": 4}],
                },
                {"primitives": [{"attributes": {"POSITION": sparse_index}, "indices": indices, "material": 1}]},
                {"primitives": [{"attributes": {"POSITION": quantised}, "mode": 5, "material": 2}, {"attributes": {"POSITION": quantised}, "mode": 6}]},
            ],
            "cameras": [
                {"type": "perspective", "perspective": {"yfov": 0.8, "aspectRatio": 1.5, "znear": 0.1, "zfar": 100}},
                {"type": "orthographic", "orthographic": {"xmag": 2, "ymag": 1, "znear": 0.1, "zfar": 10}},
            ],
        }
    )
    doc.node(mesh=0, name="a", translation=[0, 0, -1], rotation=[0, 0, 0.7071068, 0.7071068], scale=[1, 2, 1])
    doc.node(mesh=1, matrix=[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.5, 0, 0, 1])
    doc.node(mesh=2, children=[3])
    doc.json["nodes"].append({"camera": 0, "translation": [0, 0, 4]})
    doc.node(camera=1, translation=[0, 0, 5])
    for light in range(3):
        doc.node(extensions={"KHR_lights_punctual": {"light": light}}, translation=[0, 2, 0])
    doc.json["scenes"][0]["extras"] = {"environment": {"radiance": [0.5, 0.6, 0.7]}}
    return doc


def compressed_document(extension):
    doc = Document()
    if extension == "KHR_draco_mesh_compression":
        view = doc.view(DRACO)
        for kind in ("VEC3", "VEC3", "VEC2"):
            doc.json["accessors"].append({"componentType": 5126, "count": 9, "type": kind})
        doc.json["accessors"][0].update({"min": [-0.5, -0.5, 0], "max": [0.5, 0.5, 0]})
        doc.json["accessors"].append({"componentType": 5123, "count": 24, "type": "SCALAR"})
        payload = {"bufferView": view, "attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}}
        primitive = {
            "attributes": {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2},
            "indices": 3,
            "extensions": {extension: payload},
        }
    else:
        offsets = []
        for data in (MESHOPT_VERTICES, MESHOPT_TRIANGLES, MESHOPT_OCTAHEDRAL):
            while len(doc.buffer) % 4:
                doc.buffer.append(0)
            offsets.append((len(doc.buffer), len(data)))
            doc.buffer += data
        shapes = [(12, 9, "ATTRIBUTES", "NONE"), (2, 24, "TRIANGLES", "NONE"), (4, 9, "ATTRIBUTES", "OCTAHEDRAL")]
        for (offset, size), (stride, count, mode, how) in zip(offsets, shapes):
            view = {
                "buffer": 1,
                "byteLength": stride * count,
                "extensions": {
                    extension: {
                        "buffer": 0, "byteOffset": offset, "byteLength": size, "byteStride": stride, "count": count,
                        "mode": mode, "filter": how,
                    }
                },
            }
            if mode == "ATTRIBUTES":
                view["byteStride"] = stride
            doc.json["bufferViews"].append(view)
        doc.json["accessors"] = [
            {"bufferView": 0, "componentType": 5126, "count": 9, "type": "VEC3", "min": [-0.5, -0.5, 0], "max": [0.5, 0.5, 0]},
            {"bufferView": 1, "componentType": 5123, "count": 24, "type": "SCALAR"},
            {"bufferView": 2, "componentType": 5120, "count": 9, "type": "VEC3", "normalized": True},
        ]
        primitive = {"attributes": {"POSITION": 0, "NORMAL": 2}, "indices": 1}
    doc.json["extensionsUsed"] = doc.json["extensionsRequired"] = [extension]
    if extension == "EXT_meshopt_compression":
        doc.json["extensionsUsed"] = doc.json["extensionsRequired"] = [extension, "KHR_mesh_quantization"]
    doc.json["meshes"] = [{"primitives": [primitive]}]
    doc.node(mesh=0)
    return doc


def finish_compressed(doc, extension):
    root = doc.finish()
    if extension == "EXT_meshopt_compression":
        root["buffers"].append({"byteLength": 256, "extensions": {extension: {"fallback": True}}})
        root["bufferViews"][1]["byteOffset"] = 108
        root["bufferViews"][2]["byteOffset"] = 156
    return root


def glb(root, binary, magic=0x46546C67, version=2, length=None, json_length=None, json_type=0x4E4F534A, bin_length=None,
        bin_type=0x004E4942):
    text = json.dumps(root).encode()
    text += b" " * (-len(text) % 4)
    binary = bytes(binary) + b"\0" * (-len(binary) % 4)
    chunks = struct.pack("<II", len(text) if json_length is None else json_length, json_type) + text
    chunks += struct.pack("<II", len(binary) if bin_length is None else bin_length, bin_type) + binary
    return struct.pack("<III", magic, version, 12 + len(chunks) if length is None else length) + chunks


def paths(value, at=()):
    """Every place in a document, members and elements."""
    if isinstance(value, dict):
        for key in value:
            yield (*at, key)
            yield from paths(value[key], (*at, key))
    elif isinstance(value, list):
        for i in range(len(value)):
            yield (*at, i)
            yield from paths(value[i], (*at, i))


def get(root, at):
    for step in at:
        root = root[step]
    return root


def replaced(root, at, value):
    result = copy.deepcopy(root)
    get(result, at[:-1])[at[-1]] = value
    return result


def without(root, at):
    result = copy.deepcopy(root)
    del get(result, at[:-1])[at[-1]]
    return result


NUMBERS = [-1, 4294967296, 1e308, 0.5, 0, 9007199254740993, -1e-300, 65535]
STRINGS = ["", "../../../../etc/passwd", "file:///etc/passwd", "%2e%2e/%2e%2e/etc/passwd", "/dev/zero", "a\u0000b", "x" * 70000]
WRONG = ["text", None, [], {}, True, [[[]]]]


class Corpus:
    def __init__(self, folder):
        self.folder = folder
        self.cases = []

    def add(self, name, expect, root=None, data=None, scene=None, files=None):
        """A case: `root` as scene.gltf, or `data` as the file `scene`; `files`: name -> bytes beside it."""
        name = f"{len(self.cases):04d}_{name}"
        where = os.path.join(self.folder, name)
        os.makedirs(where)
        scene = scene or ("scene.gltf" if root is not None else "scene.glb")
        files = dict(files or {})
        files[scene] = json.dumps(root).encode() if root is not None else data
        for file, content in files.items():
            with open(os.path.join(where, file), "wb") as out:
                out.write(content)
        self.cases.append((name, f"{name}/{scene}", expect))

    def write(self):
        with open(os.path.join(self.folder, "cases.txt"), "w", encoding="utf-8") as out:
            out.writelines("\t".join(case) + "\n" for case in self.cases)


def label(at):
    text = "_".join(str(step) for step in at)
    return "".join(c if c.isalnum() or c == "_" else "-" for c in text)[-80:]


def mutate_document(corpus, name, root, share):
    """One change at a time in every place of a document. share: so many of the hostile values for each number."""
    count = 0
    for at in paths(root):
        value = get(root, at)
        count += 1
        if isinstance(value, bool):
            corpus.add(f"{name}_bool_{label(at)}", "any", replaced(root, at, WRONG[count % len(WRONG)]))
        elif isinstance(value, (int, float)):
            for k in range(share):
                corpus.add(f"{name}_number_{label(at)}", "any", replaced(root, at, NUMBERS[(count + 3 * k) % len(NUMBERS)]))
            corpus.add(f"{name}_type_{label(at)}", "any", replaced(root, at, WRONG[count % len(WRONG)]))
        elif isinstance(value, str):
            corpus.add(f"{name}_string_{label(at)}", "any", replaced(root, at, STRINGS[count % len(STRINGS)]))
            corpus.add(f"{name}_type_{label(at)}", "any", replaced(root, at, WRONG[1 + count % (len(WRONG) - 1)]))
        else:
            corpus.add(f"{name}_type_{label(at)}", "any", replaced(root, at, ["text", None, 7, True][count % 4]))
        if count % 2 == 0:
            corpus.add(f"{name}_without_{label(at)}", "any", without(root, at))


def mutate_bytes(corpus, name, data, make, step):
    """Truncations and changed bytes of one binary part. make(bytes) -> arguments of Corpus.add"""
    for size in sorted({0, 1, 4, 8, len(data) // 3, len(data) // 2, len(data) - 1}):
        corpus.add(f"{name}_cut_{size}", "any", **make(data[:size]))
    for at in range(0, len(data), step):
        for value in (0x00, 0x7F, 0xFF):
            changed = bytearray(data)
            changed[at] = value if changed[at] != value else value ^ 0x55
            corpus.add(f"{name}_byte_{at}_{value:02x}", "any", **make(bytes(changed)))
        if at + 4 <= len(data):
            changed = bytearray(data)
            changed[at : at + 4] = b"\xff\xff\xff\x7f"
            corpus.add(f"{name}_word_{at}", "any", **make(bytes(changed)))


def textured(image, kind="image/png"):
    root = small_document()
    root["images"] = [{"uri": data_uri(image, kind)}]
    root["textures"] = [{"source": 0}]
    root["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
    root["meshes"][0]["primitives"][0]["material"] = 0
    return root


def small_document():
    doc = Document()
    attributes = grid_attributes(doc)
    indices = doc.accessor(struct.pack("<24H", *CORNERS), 5123, 24, "SCALAR")
    doc.json["meshes"] = [
        {"primitives": [{"attributes": {k: attributes[k] for k in ("POSITION", "TEXCOORD_0")}, "indices": indices}]}
    ]
    doc.node(mesh=0)
    return doc.finish()


def with_environment(name):
    root = small_document()
    root["scenes"][0]["extras"] = {"environment": {"uri": name, "scale": 1, "rotate": 30}}
    return root


def pictures(corpus):
    for kind in (0, 2, 4, 6):
        corpus.add(f"png_kind_{kind}", "good", textured(png(5, 3, kind=kind)))
    corpus.add("png_interlaced_flag", "any", textured(png(interlace=1)))
    corpus.add("jpeg_as_it_is", "good", textured(JPEG, "image/jpeg"))
    corpus.add("jpeg_called_png", "good", textured(JPEG, "image/png"))
    for claim in ((0, 4), (4, 0), (0x7FFFFFFF, 0x7FFFFFFF), (0xFFFFFFFF, 1), (100000, 100000), (65535, 65535), (4, 5)):
        corpus.add(f"png_claims_{claim[0]}x{claim[1]}", "bad", textured(png(claim=claim)))
    corpus.add("png_claims_fewer_rows", "any", textured(png(claim=(4, 2))))
    for depth, kind in ((3, 2), (16, 3), (0, 0), (8, 5), (255, 255)):
        corpus.add(f"png_depth_{depth}_kind_{kind}", "bad", textured(png(depth=depth, kind=kind)))
    corpus.add("png_bad_crc", "any", textured(png(good_crc=False)))
    # 900 MB of zeros in less than a megabyte.
    zeros = zlib.compressobj(9)
    squeezed = b"".join(zeros.compress(bytes(30001)) for _ in range(30000)) + zeros.flush()

    def chunk(name, data):
        return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))

    bomb = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", 30000, 30000, 8, 0, 0, 0, 0))
    bomb += chunk(b"IDAT", squeezed) + chunk(b"IEND", b"")
    corpus.add("png_bomb", "bad", textured(bomb))
    for at in (i for i in range(len(JPEG) - 9) if JPEG[i] == 0xFF and JPEG[i + 1] == 0xC0):
        for height, width in ((0, 8), (8, 0), (65500, 65500), (65535, 65535)):
            changed = JPEG[: at + 5] + struct.pack(">HH", height, width) + JPEG[at + 9 :]
            corpus.add(f"jpeg_claims_{width}x{height}", "bad" if 0 in (height, width) else "any", textured(changed, "image/jpeg"))
    for name, magic in (("gif", b"GIF89a\x01\0\x01\0"), ("bmp", b"BM" + bytes(60)), ("webp", b"RIFF\x24\0\0\0WEBPVP8 "),
                        ("ktx2", b"\xabKTX 20\xbb\r\n\x1a\n" + bytes(80)), ("psd", b"8BPS\0\1" + bytes(40)),
                        ("text", b"no picture at all")):
        # Formats with a name are left out and named; what has none is an error.
        corpus.add(f"image_{name}", "bad" if name in ("psd", "text") else "good", textured(magic))
    mutate_bytes(corpus, "png", png(), lambda d: {"root": textured(d)}, 5)
    mutate_bytes(corpus, "jpeg", JPEG, lambda d: {"root": textured(d, "image/jpeg")}, 9)


def environments(corpus):
    corpus.add("hdr_good", "good", with_environment("sky.hdr"), files={"sky.hdr": hdr()})
    corpus.add("exr_good", "good", with_environment("sky.exr"), files={"sky.exr": exr()})
    corpus.add("environment_missing", "bad", with_environment("sky.exr"))
    corpus.add("environment_outside", "bad", with_environment("../sky.hdr"), files={"sky.hdr": hdr()})
    corpus.add("environment_absolute", "bad", with_environment("/etc/passwd"))
    corpus.add("environment_is_a_picture", "bad", with_environment("sky.png"), files={"sky.png": png()})
    for claim in ((0, 4), (8, 0), (100000, 100000), (2147483647, 2147483647), (-8, 4), (8, 5)):
        corpus.add(f"hdr_claims_{claim[0]}x{claim[1]}", "bad", with_environment("sky.hdr"), files={"sky.hdr": hdr(claim=claim)})
    for window in ((0, 0, 2147483646, 2147483646), (0, 0, 200000, 200000), (5, 5, 0, 0), (-2147483648, 0, 2147483647, 3),
                   (0, 0, 7, 2000000000)):
        corpus.add(f"exr_window_{'_'.join(map(str, window))}", "bad", with_environment("sky.exr"), files={"sky.exr": exr(window=window)})
    for offsets in (0, 1, 0xFFFFFFFFFFFFFFFF, 1 << 40):
        corpus.add(f"exr_offsets_{offsets:x}", "any", with_environment("sky.exr"), files={"sky.exr": exr(offsets=offsets)})
    corpus.add("exr_without_colour", "bad", with_environment("sky.exr"), files={"sky.exr": exr(channels=("Q",))})
    corpus.add("exr_compression_200", "bad", with_environment("sky.exr"), files={"sky.exr": exr(compression=200)})
    mutate_bytes(corpus, "hdr", hdr(), lambda d: {"root": with_environment("sky.hdr"), "files": {"sky.hdr": d}}, 11)
    mutate_bytes(corpus, "exr", exr(), lambda d: {"root": with_environment("sky.exr"), "files": {"sky.exr": d}}, 13)


def containers(corpus):
    root = small_document()
    binary = base64.b64decode(root["buffers"][0]["uri"].split(",")[1])
    del root["buffers"][0]["uri"]
    corpus.add("glb_good", "good", data=glb(root, binary))
    for name, value in (("magic", 0), ("version", 1), ("version", 3), ("length", 0), ("length", 11), ("length", 0xFFFFFFFF),
                        ("json_length", 0), ("json_length", 0xFFFFFFFF), ("json_length", 0x7FFFFFF0), ("json_type", 0x41414141)):
        corpus.add(f"glb_{name}_{value:x}", "bad", data=glb(root, binary, **{name: value}))
    for name, value in (("bin_length", 0), ("bin_length", 0xFFFFFFFF), ("bin_length", 5), ("bin_type", 0)):
        corpus.add(f"glb_{name}_{value:x}", "any", data=glb(root, binary, **{name: value}))
    whole = glb(root, binary)
    for size in (0, 1, 3, 11, 12, 19, 20, 21, len(whole) // 2, len(whole) - 1):
        corpus.add(f"glb_cut_{size}", "bad", data=whole[:size])
    for at in range(12, len(whole), 29):
        changed = bytearray(whole)
        changed[at] ^= 0xFF
        corpus.add(f"glb_byte_{at}", "any", data=bytes(changed))
    for name, text in (("empty", b""), ("null", b"null"), ("number", b"1"), ("array", b"[]"), ("brace", b"{"), ("bom", b"\xef\xbb\xbf{}"),
                       ("utf8", b'{"asset":{"version":"2.0","copyright":"\xff\xfe"}}'), ("utf16", "{}".encode("utf-16")),
                       ("twice", b'{"asset":{"version":"2.0"},"asset":{"version":"1.0"}}'), ("no_asset", b"{}")):
        corpus.add(f"json_{name}", "bad" if name not in ("twice", "bom") else "any", data=text, scene="scene.gltf")
    for opening, closing in (("[", "]"), ('{"a":', "}")):
        deep = '{"asset":{"version":"2.0"},"extras":' + opening * 100000 + "1" + closing * 100000 + "}"
        corpus.add("json_100000_deep", "bad", data=deep.encode(), scene="scene.gltf")
    corpus.add("json_long_number", "any", data=b'{"asset":{"version":"2.0"},"scene":' + b"9" * 100000 + b"}", scene="scene.gltf")


def graphs(corpus):
    root = small_document()
    deep = copy.deepcopy(root)
    deep["nodes"] = [{"children": [i + 1]} for i in range(10000)] + [{"mesh": 0}]
    corpus.add("nodes_10000_deep", "good", deep)
    loop = copy.deepcopy(root)
    loop["nodes"] = [{"children": [1], "mesh": 0}, {"children": [2]}, {"children": [0]}]
    corpus.add("nodes_loop", "bad", loop)
    corpus.add("node_is_its_own_child", "bad", replaced(root, ("nodes", 0), {"mesh": 0, "children": [0]}))
    shared = copy.deepcopy(root)
    shared["nodes"] = [{"children": [2]}, {"children": [2]}, {"mesh": 0}]
    shared["scenes"][0]["nodes"] = [0, 1]
    corpus.add("node_with_two_parents", "bad", shared)
    wide = copy.deepcopy(root)
    wide["nodes"] = [{"mesh": 0} for _ in range(20000)]
    wide["scenes"][0]["nodes"] = list(range(20000))
    corpus.add("nodes_20000_wide", "good", wide)
    for name, rotation in (("zero", [0, 0, 0, 0]), ("long", [0, 0, 0, 2]), ("huge", [1e300, 0, 0, 1e300])):
        corpus.add(f"rotation_{name}", "any", replaced(root, ("nodes", 0), {"mesh": 0, "rotation": rotation}))
    corpus.add("scale_1e30", "bad", replaced(root, ("nodes", 0), {"mesh": 0, "scale": [1e30, 1, 1]}))
    for bits in (0x7FC00000, 0x7F800000, 0xFF800000, 0x7F7FFFFF):
        doc = Document()
        points = bytearray(struct.pack("<27f", *[c for p in POINTS for c in p]))
        points[12:16] = struct.pack("<I", bits)
        position = doc.accessor(bytes(points), 5126, 9, "VEC3")
        doc.json["meshes"] = [{"primitives": [{"attributes": {"POSITION": position}}]}]
        doc.node(mesh=0)
        corpus.add(f"position_{bits:08x}", "bad", doc.finish())
    huge = replaced(root, ("accessors", 0, "count"), 4000000000)
    corpus.add("accessor_claims_4e9", "bad", huge)
    corpus.add("sparse_claims_4e9", "bad", replaced(root, ("accessors", 0), {
        "componentType": 5126, "count": 4000000000, "type": "VEC3",
        "sparse": {"count": 1, "indices": {"bufferView": 0, "componentType": 5121}, "values": {"bufferView": 0}}}))
    for uri in ("../scene.bin", "/etc/passwd", "..\\scene.bin", "%2e%2e%2fscene.bin", "http://example.com/a.bin", "file:///etc/passwd",
                "a/../../scene.bin", "", ".", "scene.bin\u0000.txt", "data:;base64,!!!!", "data:,plain"):
        corpus.add("uri_of_a_buffer", "bad", replaced(root, ("buffers", 0, "uri"), uri))


def compressed(corpus):
    for extension, name, payloads in (
        ("KHR_draco_mesh_compression", "draco", [DRACO]),
        ("EXT_meshopt_compression", "meshopt", [MESHOPT_VERTICES, MESHOPT_TRIANGLES, MESHOPT_OCTAHEDRAL]),
    ):
        root = finish_compressed(compressed_document(extension), extension)
        corpus.add(f"{name}_good", "good", root)
        mutate_document(corpus, name, root, 1)
        binary = base64.b64decode(root["buffers"][0]["uri"].split(",")[1])

        def make(data, root=root):
            return {"root": replaced(root, ("buffers", 0, "uri"), data_uri(data))}

        for at in range(0, len(binary), 3):
            for value in (0x00, 0xFF):
                changed = bytearray(binary)
                changed[at] = value if changed[at] != value else 0x55
                corpus.add(f"{name}_byte_{at}_{value:02x}", "any", **make(bytes(changed)))
        for payload in payloads:
            start = binary.index(payload)
            for size in (0, 1, len(payload) // 2):
                zeroed = binary[: start + size] + bytes(len(payload) - size) + binary[start + len(payload) :]
                corpus.add(f"{name}_zeroed_after_{size}", "any", **make(zeroed))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", help="is created; must not exist")
    args = parser.parse_args()
    try:
        os.makedirs(args.folder)
    except OSError as error:
        sys.exit(f"make_corpus.py: cannot create {args.folder}: {error.strerror}; choose a new folder")
    corpus = Corpus(args.folder)
    everything = full_document().finish()
    corpus.add("everything", "good", everything)
    mutate_document(corpus, "all", everything, 1)
    pictures(corpus)
    environments(corpus)
    containers(corpus)
    graphs(corpus)
    compressed(corpus)
    corpus.write()
    print(f"{len(corpus.cases)} cases in {args.folder}")


if __name__ == "__main__":
    main()
