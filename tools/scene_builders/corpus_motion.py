# SPDX-License-Identifier: Apache-2.0
"""Files that move, for make_corpus.py: animations of every kind and skins, and keys and weights that lie."""

import copy
import struct

from scene_builders.corpus_files import CORNERS, Document, grid_attributes

IDENTITY = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]


def moving_document():
    """A skin of two joints, a morph target, and an animation of every interpolation and kind of target."""
    doc = Document()
    attributes = grid_attributes(doc)
    indices = doc.accessor(struct.pack("<24H", *CORNERS), 5123, 24, "SCALAR")
    attributes["JOINTS_0"] = doc.accessor(bytes([0, 1, 0, 0] * 9), 5121, 9, "VEC4")
    attributes["WEIGHTS_0"] = doc.accessor(bytes([128, 127, 0, 0] * 9), 5121, 9, "VEC4", normalized=True)
    attributes["JOINTS_1"] = doc.accessor(struct.pack("<36H", *[1, 0, 0, 0] * 9), 5123, 9, "VEC4")
    attributes["WEIGHTS_1"] = doc.accessor(struct.pack("<36f", *[0.0] * 36), 5126, 9, "VEC4")
    lift = doc.accessor(struct.pack("<27f", *[0.0, 0.0, 0.5] * 9), 5126, 9, "VEC3")
    binds = doc.accessor(struct.pack("<32f", *IDENTITY, *IDENTITY), 5126, 2, "MAT4")
    times = doc.accessor(struct.pack("<3f", 0, 0.5, 1), 5126, 3, "SCALAR")
    places = doc.accessor(struct.pack("<9f", 0, 0, 0, 0, 1, 0, 0, 0, 2), 5126, 3, "VEC3")
    turns = doc.accessor(struct.pack("<12h", 0, 0, 0, 32767, 0, 0, 23170, 23170, 0, 0, 32767, 0), 5122, 3, "VEC4", normalized=True)
    spline = doc.accessor(struct.pack("<27f", *[0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.5, 0.0] * 3), 5126, 9, "VEC3")
    weights = doc.accessor(bytes([0, 255, 128]), 5121, 3, "SCALAR", normalized=True)
    colours = doc.accessor(struct.pack("<12f", *[0.5, 0.25, 0.75, 1.0] * 3), 5126, 3, "VEC4")
    doc.json["materials"] = [{"name": "paint"}]
    doc.json["meshes"] = [{"primitives": [{"attributes": attributes, "indices": indices, "material": 0,
                                           "targets": [{"POSITION": lift}]}], "weights": [0.25]}]
    doc.node(mesh=0, skin=0)
    doc.node(name="upper", children=[2], translation=[0, 0.5, 0])
    doc.json["nodes"].append({"name": "lower", "rotation": [0, 0, 0, 1]})
    doc.json["skins"] = [{"name": "hide", "joints": [1, 2], "inverseBindMatrices": binds, "skeleton": 1}]
    channels = [({"node": 1, "path": "translation"}, places, "LINEAR"), ({"node": 2, "path": "rotation"}, turns, "LINEAR"),
                ({"node": 1, "path": "scale"}, spline, "CUBICSPLINE"), ({"node": 0, "path": "weights"}, weights, "STEP"),
                ({"path": "pointer", "extensions": {"KHR_animation_pointer": {
                    "pointer": "/materials/0/pbrMetallicRoughness/baseColorFactor"}}}, colours, "LINEAR")]
    doc.json["animations"] = [{
        "name": "walk",
        "channels": [{"sampler": i, "target": target} for i, (target, _, _) in enumerate(channels)],
        "samplers": [{"input": times, "output": output, "interpolation": kind} for _, output, kind in channels]}]
    doc.json["extensionsUsed"] = ["KHR_animation_pointer"]
    return doc


def changed(root, change):
    result = copy.deepcopy(root)
    change(result)
    return result


def motion(corpus):
    """Adds files with all that one may claim of its animations and skins. A damaged animation leaves a scene that stands still."""
    root = moving_document().finish()
    corpus.add("motion_good", "good", root)

    def keys(times):
        doc = moving_document()
        clock = doc.accessor(struct.pack(f"<{len(times)}f", *times), 5126, len(times), "SCALAR")
        doc.json["animations"][0]["samplers"][0]["input"] = clock
        return doc.finish()

    nan, infinite = float("nan"), float("inf")
    for times in ([1, 0, 2], [0, nan, 1], [0, 1, infinite], [0, 0, 0], [-1, 0, 1], [], [0], [0, 1, 2, 3], [1e38, 2e38, 3e38]):
        corpus.add(f"motion_{len(times)}_times", "good", keys(times))
    for count in (0, 2, 4, 1 << 20, 1 << 31):
        corpus.add("motion_zeros", "good", changed(root, lambda r, c=count: r["accessors"].append(
            {"componentType": 5126, "count": c, "type": "SCALAR"}) or r["animations"][0]["samplers"][0].update(
                input=len(r["accessors"]) - 1)))
    for name, pointer in (("up", "/materials/0/../../nodes"), ("deep", "/materials/0" + "/a" * 5000), ("slashes", "/" * 70000),
                          ("number", "/nodes/99999999999999999999/scale"), ("stars", "/materials/*/alphaCutoff"),
                          ("transform", "/materials/0/extras/extensions/KHR_texture_transform/offset"), ("root", "/"), ("none", "")):
        corpus.add(f"motion_pointer_{name}", "good", changed(root, lambda r, p=pointer: r["animations"][0]["channels"][4][
            "target"]["extensions"]["KHR_animation_pointer"].update(pointer=p)))
    corpus.add("motion_channels_by_the_thousand", "good", changed(root, lambda r: r["animations"][0].update(
        channels=r["animations"][0]["channels"] * 5000)))
    corpus.add("motion_animations_by_the_thousand", "good", changed(root, lambda r: r.update(animations=r["animations"] * 2000)))
    for name, joints in (("none", []), ("far", [1, 99]), ("twice", [1, 1]), ("skinned_node", [0, 0])):
        corpus.add(f"skin_joints_{name}", "good" if name in ("twice", "skinned_node") else "bad",
                   changed(root, lambda r, j=joints: r["skins"][0].update(joints=j)))
    corpus.add("skin_joint_out_of_range", "bad", changed(root, lambda r: r["skins"][0].update(joints=[1])))
    corpus.add("skin_joints_loop", "bad", changed(root, lambda r: r["nodes"][2].update(children=[1])))
    corpus.add("skin_joints_outside", "good", changed(root, lambda r: r["scenes"][0].update(nodes=[0])))
    corpus.add("skin_joints_by_the_thousand", "bad", changed(root, lambda r: r["skins"][0].update(joints=[1, 2] * 100000)))
    corpus.add("skins_by_the_thousand", "good", changed(root, lambda r: (r.update(skins=r["skins"] * 3000), r["nodes"].extend(
        {"mesh": 0, "skin": i} for i in range(3000)), r["scenes"][0]["nodes"].extend(range(3, 3003)))))
