# SPDX-License-Identifier: Apache-2.0
"""Good files in pieces, for make_corpus.py to damage: pictures, environments, glTF documents plain and compressed.
Whatever a file says of itself (sizes, counts, checksums) can be given otherwise."""

import base64
import json
import struct
import zlib

from .glb_file import field_offsets, pack_glb
from .png_file import pack_png

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
    return pack_png(claim or (width, height), zlib.compress(rows, 9), kind, depth, interlace, good_crc)


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
    if extension.endswith("_meshopt_compression"):
        doc.json["extensionsUsed"] = doc.json["extensionsRequired"] = [extension, "KHR_mesh_quantization"]
    doc.json["meshes"] = [{"primitives": [primitive]}]
    doc.node(mesh=0)
    return doc


def finish_compressed(doc, extension):
    root = doc.finish()
    if extension.endswith("_meshopt_compression"):
        root["buffers"].append({"byteLength": 256, "extensions": {extension: {"fallback": True}}})
        root["bufferViews"][1]["byteOffset"] = 108
        root["bufferViews"][2]["byteOffset"] = 156
    return root


def glb(root, binary, **lies):
    """Returns a .glb file of the document `root`; lies: numbers that its headers have instead of the true ones, by the
    names of field_offsets()."""
    data = bytearray(pack_glb(json.dumps(root).encode(), binary))
    offsets = field_offsets(data)
    for name, value in lies.items():
        struct.pack_into("<I", data, offsets[name], value)
    return bytes(data)


def small_document():
    doc = Document()
    attributes = grid_attributes(doc)
    indices = doc.accessor(struct.pack("<24H", *CORNERS), 5123, 24, "SCALAR")
    doc.json["meshes"] = [
        {"primitives": [{"attributes": {k: attributes[k] for k in ("POSITION", "TEXCOORD_0")}, "indices": indices}]}
    ]
    doc.node(mesh=0)
    return doc.finish()


def textured(image, kind="image/png"):
    root = small_document()
    root["images"] = [{"uri": data_uri(image, kind)}]
    root["textures"] = [{"source": 0}]
    root["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
    root["meshes"][0]["primitives"][0]["material"] = 0
    return root
