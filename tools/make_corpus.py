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
import os
import struct
import sys
import zlib

from scene_builders.corpus_cases import Corpus, mutate_bytes, mutate_document, replaced
from scene_builders.corpus_files import (
    compressed_document,
    data_uri,
    Document,
    DRACO,
    exr,
    finish_compressed,
    full_document,
    glb,
    hdr,
    JPEG,
    MESHOPT_OCTAHEDRAL,
    MESHOPT_TRIANGLES,
    MESHOPT_VERTICES,
    png,
    POINTS,
    small_document,
    textured,
)
from scene_builders.corpus_found import claims, leftovers, mended, morphing_document, morphs
from scene_builders.corpus_motion import motion, moving_document
from scene_builders.corpus_pictures import JPEG_CMYK, KTX2_ETC1S, KTX2_UASTC, WEBP_LOSSLESS, WEBP_LOSSY
from scene_builders.png_file import GREY, pack_png


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
    corpus.add("png_bomb", "bad", textured(pack_png((30000, 30000), squeezed, GREY)))
    for at in (i for i in range(len(JPEG) - 9) if JPEG[i] == 0xFF and JPEG[i + 1] == 0xC0):
        for height, width in ((0, 8), (8, 0), (65500, 65500), (65535, 65535)):
            changed = JPEG[: at + 5] + struct.pack(">HH", height, width) + JPEG[at + 9 :]
            corpus.add(f"jpeg_claims_{width}x{height}", "bad" if 0 in (height, width) else "any", textured(changed, "image/jpeg"))
    for name, magic in (("gif", b"GIF89a\x01\0\x01\0"), ("bmp", b"BM" + bytes(60)), ("dds", b"DDS " + bytes(124)),
                        ("avif", b"\0\0\0\x1cftypavif" + bytes(40)), ("psd", b"8BPS\0\1" + bytes(40)),
                        ("text", b"no picture at all")):
        # Formats with a name are left out and named; what has none is an error.
        corpus.add(f"image_{name}", "bad" if name in ("psd", "text") else "good", textured(magic))
    mutate_bytes(corpus, "png", png(), lambda d: {"root": textured(d)}, 5)
    mutate_bytes(corpus, "jpeg", JPEG, lambda d: {"root": textured(d, "image/jpeg")}, 9)


def ktx2(width=3, height=2, depth=0, layers=0, faces=1, levels=1, vk_format=37, scheme=0, texels=None, offset=104, length=None):
    """A KTX2 of 8-bit RGBA, without a description of its format."""
    texels = bytes(range(4 * width * height)) if texels is None else texels
    header = struct.pack("<9I", vk_format, 1, width, height, depth, layers, faces, levels, scheme) + bytes(32)
    size = len(texels) if length is None else length
    return b"\xabKTX 20\xbb\r\n\x1a\n" + header + struct.pack("<3Q", offset, size, size) + texels


def texture_kinds(corpus):
    """WebP, KTX2, JPEGs of inks, and materials of specular colour and glossiness."""
    for name, picture in (("webp_lossless", WEBP_LOSSLESS), ("webp_lossy", WEBP_LOSSY), ("jpeg_cmyk", JPEG_CMYK), ("ktx2", ktx2()),
                          ("ktx2_etc1s", KTX2_ETC1S), ("ktx2_uastc", KTX2_UASTC)):
        corpus.add(f"{name}_good", "good", textured(picture))
        mutate_bytes(corpus, name, picture, lambda d: {"root": textured(d)}, 7)
    corpus.add("webp_animated", "bad", textured(WEBP_LOSSY[:20] + bytes((WEBP_LOSSY[20] | 2,)) + WEBP_LOSSY[21:]))
    corpus.add("webp_without_picture", "bad", textured(b"RIFF\x24\0\0\0WEBPVP8 "))
    for key, value in (("width", 0), ("width", 0xFFFFFFFF), ("height", 0), ("height", 0xFFFFFFFF), ("depth", 9), ("layers", 7), ("faces", 6),
                       ("vk_format", 145), ("scheme", 3), ("offset", 1 << 63), ("offset", 105), ("length", 0xFFFFFFFFFFFFFFFF)):
        # The texels stay those of 3 x 2 pixels, whatever the header claims.
        corpus.add(f"ktx2_{key}_{value:x}", "bad", textured(ktx2(**{"texels": bytes(24), key: value})))
    for scheme in (0, 1, 2):
        corpus.add(f"ktx2_undescribed_{scheme}", "bad", textured(ktx2(vk_format=0, scheme=scheme)))
    both = textured(WEBP_LOSSLESS)
    both["images"].append({"uri": data_uri(png(), "image/png")})
    both["extensionsUsed"] = ["EXT_texture_webp", "KHR_texture_basisu", "KHR_materials_pbrSpecularGlossiness"]
    both["textures"] = [{"source": 1, "extensions": {"EXT_texture_webp": {"source": 0}}},
                        {"source": 1, "extensions": {"KHR_texture_basisu": {"source": 0}}}]
    both["materials"][0]["extensions"] = {"KHR_materials_pbrSpecularGlossiness": {
        "diffuseFactor": [0.5, 0.25, 0.125, 1], "specularFactor": [0.5, 0.75, 1], "glossinessFactor": 0.75,
        "diffuseTexture": {"index": 0}, "specularGlossinessTexture": {"index": 1}}}
    corpus.add("glossy_good", "good", both)
    mutate_document(corpus, "glossy", both, 1)


def environment_kinds(corpus):
    """Cube maps, and colours of other primaries."""
    for width, height in ((8, 6), (6, 8), (12, 2), (2, 12)):
        corpus.add(f"hdr_cube_{width}x{height}", "good", with_environment("sky.hdr"), files={"sky.hdr": hdr(width, height)})
    for number, line in enumerate((".64 .33 .29 .60 .15 .06 .3333 .3333", "0 0 0 0 0 0 0 0", "1 1 1 1 1 1 1 1", "1e30 0 0 1 0 0 .3 .3", "1 2",
                                   "nan nan nan nan nan nan nan nan", "-1 0 0 -1 0 0 -1 -1", "")):
        picture = hdr(extra=f"PRIMARIES= {line}\n")
        corpus.add(f"hdr_primaries_{number}", "bad" if number else "good", with_environment("sky.hdr"), files={"sky.hdr": picture})
    xyz = hdr().replace(b"rgbe", b"xyze")
    corpus.add("hdr_xyze", "good", with_environment("sky.hdr"), files={"sky.hdr": xyz})


def tables(corpus):
    """Measured materials; only damaged ones, since a good table is 35 MB."""
    def by_table(uri):
        root = small_document()
        root["materials"] = [{"extensions": {"EIKON_materials_measured": {"uri": uri}}}]
        root["meshes"][0]["primitives"][0]["material"] = 0
        return root

    header = struct.pack("<3i", 90, 90, 180)
    for name, uri in (("missing", "x.binary"), ("outside", "../x.binary"), ("absolute", "/etc/passwd"), ("number", 7),
                      ("list", ["x.binary"]), ("long", "x" * 100000)):
        corpus.add(f"table_{name}", "bad", by_table(uri))
    for sizes in ((90, 90, 180), (0, 0, 0), (-1, -1, -1), (65536, 65536, 65536), (2147483647, 2147483647, 2147483647),
                  (-90, -90, 180), (180, 90, 90)):
        for rest in (b"", bytes(8), b"\xff" * 4096):
            corpus.add(f"table_{'_'.join(map(str, sizes))}_and_{len(rest)}", "bad", by_table("x.binary"),
                       files={"x.binary": struct.pack("<3i", *sizes) + rest})
    for length in range(12):
        corpus.add(f"table_header_of_{length}", "bad", by_table("x.binary"), files={"x.binary": header[:length]})


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
    corpus.add("node_with_two_parents", "good", shared)
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


def with_formula(f, bounds=(-1, -1, -1, 1, 1, 1)):
    root = small_document()
    root["extensionsUsed"] = ["EIKON_implicit_surface"]
    root["nodes"].append({"name": "surface", "extensions": {"EIKON_implicit_surface": {"f": f, "bounds": list(bounds)}}})
    root["scenes"][0]["nodes"].append(len(root["nodes"]) - 1)
    return root


def formulas(corpus):
    seeds = ("x^2+y^2+z^2-1", "(x^2+y^2+z^2+3)^2-16*(x^2+y^2)", "sin(x)*cos(y)+sin(y)*cos(z)+sin(z)*cos(x)",
             "exp(-(x^2+y^2))+exp(-((x-1)^2+z^2))-0.5", "min(max(x,y),z)-abs(x*y)/sqrt(z^2+1)", "tan(x)-log(y+2)^-3*atan(z)*pi")
    for seed in seeds:
        corpus.add("formula_good", "good", with_formula(seed))
    bad = ("", " ", "x+", "2x", "x)", "(x", "foo(x)", "x+w", "3", "x/0", "x^y^", "sin x", "min(x)", "x;system(1)", "x+1e39", "x + .",
           "x\u0000+y", "\u00b2x", "\ud83d\ude00", "x" * 5000, "(" * 70 + "x" + ")" * 70, "-" * 5000 + "x", "*".join(["x"] * 3000),
           "log(0-1)*x", "x*(1e38*1e38)", "__kernel", "get_global_id(0)", "x // y", "/* */ x", "x\n#include y", "nan", "inf*x")
    for i, text in enumerate(bad):
        corpus.add(f"formula_bad_{i}", "bad", with_formula(text))
    for bounds in ((), (-1, -1, -1, 1, 1), (1, -1, -1, -1, 1, 1), (0, 0, 0, 0, 0, 0), (-1e300, -1, -1, 1, 1, 1), (1e6, 0, 0, 1000000.01, 1, 1),
                   ("a", 0, 0, 1, 1, 1), (None, 0, 0, 1, 1, 1)):
        corpus.add("formula_bounds", "bad", with_formula("x", bounds))
    # Characters that come, go, double and change places; the same every time.
    state = 12345

    def below(n):
        nonlocal state
        state = (state * 1103515245 + 12345) & 0x7FFFFFFF
        return (state >> 8) % n

    letters = "xyz0123456789.+-*/^(),e \t\n_#;=abcdefghijklmnopqrstuvw\u00ff\u0001"
    for i in range(400):
        text = seeds[below(len(seeds))]
        for _ in range(1 + below(5)):
            at, kind = below(len(text) + 1), below(4)
            if kind == 0:
                text = text[:at] + letters[below(len(letters))] + text[at:]
            elif kind == 1:
                text = text[:at] + text[at + 1 + below(4):]
            elif kind == 2:
                other = seeds[below(len(seeds))]
                text = text[:at] + other[below(len(other)):][: below(12)] + text[at:]
            else:
                text = text + text[at:]
        corpus.add(f"formula_changed_{i}", "any", with_formula(text))


def instances(corpus):
    root = small_document()
    translations = len(root["accessors"])
    root["extensionsUsed"] = ["EXT_mesh_gpu_instancing"]
    root["nodes"][0]["extensions"] = {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": translations}}}
    for count in (0, -1, 4000000000, 1 << 62):
        kind = "any" if count == 0 else "bad"  # a mesh that stands nowhere is no harm
        claims = copy.deepcopy(root)
        claims["accessors"].append({"bufferView": 0, "componentType": 5126, "count": count, "type": "VEC3"})
        corpus.add(f"instances_claim_{count}", kind, claims)
        claims = copy.deepcopy(root)
        claims["accessors"].append({"componentType": 5126, "count": count, "type": "VEC3"})
        corpus.add(f"instances_of_nothing_{count}", kind, claims)


def compressed(corpus):
    for extension, name, payloads in (
        ("KHR_draco_mesh_compression", "draco", [DRACO]),
        ("EXT_meshopt_compression", "meshopt", [MESHOPT_VERTICES, MESHOPT_TRIANGLES, MESHOPT_OCTAHEDRAL]),
        ("KHR_meshopt_compression", "meshopt_khr", [MESHOPT_VERTICES]),
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
    texture_kinds(corpus)
    environments(corpus)
    environment_kinds(corpus)
    tables(corpus)
    containers(corpus)
    graphs(corpus)
    formulas(corpus)
    instances(corpus)
    compressed(corpus)
    mutate_document(corpus, "morph", morphing_document(1).finish(), 1)
    mutate_document(corpus, "motion", moving_document().finish(), 1)
    for group in (morphs, motion, leftovers, mended, claims):
        group(corpus)
    corpus.write()
    print(f"{len(corpus.cases)} cases in {args.folder}")


if __name__ == "__main__":
    main()
