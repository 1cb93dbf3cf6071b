# SPDX-License-Identifier: Apache-2.0
"""Collects the cases of the corpus of damaged scenes, and damages documents and binary files in all their places."""

import copy
import json
import os


def paths(value, at=()):
    """Yields every place in a document, of members and elements, as a tuple of keys and indices."""
    if isinstance(value, dict):
        for key in value:
            yield (*at, key)
            yield from paths(value[key], (*at, key))
    elif isinstance(value, list):
        for i in range(len(value)):
            yield (*at, i)
            yield from paths(value[i], (*at, i))


def value_at(root, at):
    """Returns the value at a place in a document."""
    for step in at:
        root = root[step]
    return root


def replaced(root, at, value):
    """Returns a copy of a document with another value at a place."""
    result = copy.deepcopy(root)
    value_at(result, at[:-1])[at[-1]] = value
    return result


def without(root, at):
    """Returns a copy of a document without the member or element at a place."""
    result = copy.deepcopy(root)
    del value_at(result, at[:-1])[at[-1]]
    return result


NUMBERS = [-1, 4294967296, 1e308, 0.5, 0, 9007199254740993, -1e-300, 65535]
STRINGS = ["", "../../../../etc/passwd", "file:///etc/passwd", "%2e%2e/%2e%2e/etc/passwd", "/dev/zero", "a\u0000b", "x" * 70000]
WRONG = ["text", None, [], {}, True, [[[]]]]


class Corpus:
    """The cases of a corpus, each in a folder of its own below `folder`."""

    def __init__(self, folder):
        self.folder = folder
        self.cases = []

    def add(self, name, expect, root=None, data=None, scene=None, files=None):
        """Writes a case: `root` as scene.gltf, or `data` as the file `scene` [scene.glb]; `files`: name -> bytes beside it.

        expect: "good", "bad" or "any", as make_corpus.py explains them."""
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
        """Writes the list of all cases, cases.txt."""
        with open(os.path.join(self.folder, "cases.txt"), "w", encoding="utf-8") as out:
            out.writelines("\t".join(case) + "\n" for case in self.cases)


def label(at):
    """Returns a place in a document as a part of a file's name, 80 characters of it at most."""
    text = "_".join(str(step) for step in at)
    return "".join(c if c.isalnum() or c == "_" else "-" for c in text)[-80:]


def mutate_document(corpus, name, root, share):
    """Adds cases with one change at a time in every place of a document. share: so many of the hostile values for each number."""
    count = 0
    for at in paths(root):
        value = value_at(root, at)
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
    """Adds cases in which one binary part is cut off or has a changed byte. make(bytes) returns the arguments of Corpus.add; of
    every `step` bytes one is changed."""
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
