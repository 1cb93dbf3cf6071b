# SPDX-License-Identifier: Apache-2.0
"""Files as people have them, for make_corpus.py: rules broken where the meaning is beyond doubt, leftovers that nothing
uses, morph targets, hidden nodes, and a few kilobytes that claim memory by the gigabyte."""

import copy
import struct

from scene_builders.corpus_files import data_uri, Document, grid_attributes, CORNERS, POINTS, small_document


def morphing_document(target_count=3):
    doc = Document()
    attributes = grid_attributes(doc)
    indices = doc.accessor(struct.pack("<24H", *CORNERS), 5123, 24, "SCALAR")
    targets = []
    for t in range(target_count):
        up = doc.accessor(struct.pack("<27f", *[c * (t + 1) for p in POINTS for c in (0, 0, p[0])]), 5126, 9, "VEC3")
        turn = doc.accessor(struct.pack("<27f", *([0.1, 0.0, 0.0] * 9)), 5126, 9, "VEC3")
        uv = doc.accessor(bytes([0, 128] * 9), 5121, 9, "VEC2", normalized=True)
        doc.json["accessors"].append({
            "componentType": 5126, "count": 9, "type": "VEC4",
            "sparse": {"count": 2,
                       "indices": {"bufferView": doc.view(struct.pack("<2H", 0, 8)), "componentType": 5123},
                       "values": {"bufferView": doc.view(struct.pack("<8f", *[-0.5] * 8))}}})
        colour = len(doc.json["accessors"]) - 1
        targets.append({"POSITION": up, "NORMAL": turn, "TANGENT": turn, "TEXCOORD_0": uv, "COLOR_0": colour})
    doc.json["meshes"] = [
        {"primitives": [{"attributes": attributes, "indices": indices, "targets": targets}], "weights": [0.5] * target_count}
    ]
    doc.node(mesh=0)
    doc.node(mesh=0, weights=[-2, 0, 1000][:target_count], extensions={"KHR_node_visibility": {"visible": True}}, children=[2])
    doc.json["nodes"].append({"mesh": 0, "extensions": {"KHR_node_visibility": {"visible": False}}})
    doc.json["extensionsUsed"] = ["KHR_node_visibility"]
    return doc


def changed(root, change):
    result = copy.deepcopy(root)
    change(result)
    return result


def leftovers(corpus):
    root = small_document()
    for kind, wrong in (("accessors", {"componentType": 1}), ("materials", {"doubleSided": 5}), ("nodes", {"mesh": 99}),
                        ("meshes", {"primitives": [{"attributes": {"POSITION": 99}}]}), ("animations", {"samplers": 3}),
                        ("nodes", 7), ("accessors", None), ("meshes", []), ("materials", "x")):
        corpus.add(f"unused_{kind}", "good", changed(root, lambda r, k=kind, w=wrong: r.setdefault(k, []).append(w)))
        corpus.add(f"unused_{kind}_by_the_thousand", "bad",
                   changed(root, lambda r, k=kind, w=wrong: r.setdefault(k, []).extend([w] * 5000)))
    for kind in ("accessors", "meshes", "nodes"):
        corpus.add(f"used_{kind}", "bad", changed(root, lambda r, k=kind: r[k].__setitem__(0, {"name": 7})))


def mended(corpus):
    root = small_document()
    first = root["nodes"][0]
    for name, stride in (("12", 12), ("13", 13), ("3", 3), ("0", 0), ("253", 253)):
        def stretch(r, stride=stride):
            r["bufferViews"][0]["byteStride"] = stride
            r["bufferViews"][0]["byteLength"] = 12 + 8 * 13
        corpus.add(f"stride_{name}", "good" if stride in (0, 12, 13) else "bad", changed(root, stretch))
    for name, uri in (("upper_case", root["buffers"][0]["uri"].replace("data:", "DATA:").replace(";base64", ";BASE64")),
                      ("escaped", "data:," + "%00" * root["buffers"][0]["byteLength"])):
        corpus.add(f"data_uri_{name}", "good", changed(root, lambda r, u=uri: r["buffers"][0].update(uri=u)))
    for uri in ("data:,%", "data:,%0", "data:,%zz", "data:,a b", "data:", "DATA", "data:;base64", "Data:;Base64,====",
                "data:,\u00e9"):
        corpus.add("data_uri_broken", "bad", changed(root, lambda r, u=uri: r["buffers"][0].update(uri=u)))
    for name, number in (("whole", 9.0), ("fraction", 9.5), ("huge", 9e30), ("negative", -9.0), ("zero", -0.0)):
        corpus.add(f"count_{name}", "good" if name == "whole" else "any",
                   changed(root, lambda r, n=number: r["accessors"][0].update(count=n)))
    corpus.add("buffer_without_bytes", "good", changed(root, lambda r: r["buffers"].append({"byteLength": 1 << 40})))
    corpus.add("buffer_without_bytes_used", "bad", changed(root, lambda r: r["buffers"][0].pop("uri")))

    def graph(nodes, listed):
        return changed(root, lambda r: (r.update(nodes=nodes), r["scenes"][0].update(nodes=listed)))

    corpus.add("scene_lists_a_child", "good", graph([{"children": [1]}, first], [0, 1]))
    corpus.add("scene_lists_a_child_alone", "good", graph([{"children": [1]}, first], [1]))
    corpus.add("scene_lists_a_node_twice", "bad", graph([first], [0, 0]))
    corpus.add("children_twice", "bad", graph([{"children": [1, 1]}, first], [0]))
    corpus.add("children_multiply", "bad",
               graph([{"children": [2 * (i // 2) + 2, 2 * (i // 2) + 3]} for i in range(80)] + [first, first], [0, 1]))
    for count in (0, 1, 9):
        normals = struct.pack("<27f", *([float("nan")] * (3 * count) + [0.0, 0.0, 1.0] * (9 - count)))
        def bend(r, normals=normals):
            r["buffers"].append({"byteLength": len(normals), "uri": data_uri(normals)})
            r["bufferViews"].append({"buffer": 1, "byteLength": len(normals)})
            r["accessors"].append(
                {"bufferView": len(r["bufferViews"]) - 1, "componentType": 5126, "count": 9, "type": "VEC3"})
            r["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = len(r["accessors"]) - 1
        corpus.add(f"normals_bad_{count}", "good", changed(root, bend))
    pointer = b"version https://git-lfs.github.com/spec/v1\noid sha256:" + b"a" * 64 + b"\nsize 12345\n"
    for scene in ("scene.gltf", "scene.glb"):
        corpus.add("git_lfs_scene", "bad", data=pointer, scene=scene)
    corpus.add("git_lfs_buffer", "bad", changed(root, lambda r: r["buffers"][0].update(uri="a.bin")), files={"a.bin": pointer})


def morphs(corpus):
    root = morphing_document().finish()
    corpus.add("morph_good", "good", root)
    for weights in ([], [1], [1, 2, 3, 4], [1e300, 0, 0], [0, 0, 0, 0, 0], "x", [None], {}):
        kind = "good" if weights in ([], [0, 0, 0, 0, 0]) else "bad"
        corpus.add("morph_weights", kind, changed(root, lambda r, w=weights: r["nodes"][0].update(weights=w)))
    shared = changed(root, lambda r: (
        r["meshes"][0]["primitives"][0].update(targets=r["meshes"][0]["primitives"][0]["targets"][:1] * 200000),
        r["meshes"][0].update(weights=[1] * 200000), r["nodes"].pop(), r["nodes"][1].pop("children"),
        r["nodes"][1].pop("weights")))
    corpus.add("morph_targets_by_the_thousand", "bad", shared)


def claims(corpus):
    """Files of some kilobytes that claim much."""
    root = small_document()
    zeros = {"componentType": 5126, "count": 1 << 24, "type": "VEC3"}

    def nothing(r, count):
        r["accessors"].append(zeros)
        r["meshes"] = [{"primitives": [{"attributes": {"POSITION": len(r["accessors"]) - 1}}] * count}]

    for count in (1, 100, 5000):
        corpus.add(f"zeros_{count}", "any", changed(root, lambda r, c=count: nothing(r, c)))
    corpus.add("extras_of_nodes", "good", changed(root, lambda r: r["nodes"][0].update(extras=[[]] * 100000)))
