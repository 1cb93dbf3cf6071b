#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes mutants of scenes: good files of which a few random bytes, or a few random parts of the JSON, are changed.

  tools/make_mutants.py FOLDER [--count N] [--seed S] [SCENE...]

SCENE is a .gltf file; without one, all of scenes/ are the seeds. FOLDER gets the mutants, the files that they name, and
cases.txt, as tests/corpus/run_corpus.py reads it. The same arguments give the same bytes. Standard library only.
"""

import argparse
import base64
import copy
import json
import pathlib
import random
import shutil

from scene_builders.corpus_files import glb

ROOT = pathlib.Path(__file__).resolve().parents[1]
NUMBERS = [0, -1, 1, 2, 0.5, -0.0, 1e-300, 1e308, -1e38, 255, 256, 65535, 65536, 2**31, 2**32, 2**53 + 1, 5120, 5121, 5123, 5125, 5126, 34963]
STRINGS = ["", "name", "MAT4", "SCALAR", "VEC3", "BLEND", "MASK", "POSITION", "\u001b[2J", "..", "data:,", "sky.hdr", "x" * 5000]
PREFIX = "data:application/octet-stream;base64,"


def places(value, at=()):
    """The path of every member and element below a value."""
    children = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, child in children:
        yield (*at, key)
        if not (isinstance(child, list) and len(child) > 64):  # long lists are data: their elements are not chosen
            yield from places(child, (*at, key))


def parent_of(document, at):
    for step in at[:-1]:
        document = document[step]
    return document


def value_at(document, at):
    return parent_of(document, at)[at[-1]]


def change_number(chance, value):
    return chance.choice([*NUMBERS, value + 1, value - 1, -value, value * 2, float(value), value / 3])


def mutate_json(chance, document):
    """Changes one part of a document in place."""
    every = list(places(document))
    if not every:
        return
    at = chance.choice(every)
    parent, key = parent_of(document, at), at[-1]
    value = parent[key]
    kind = chance.randrange(8)
    if kind == 0:
        del parent[key]
    elif kind == 1:  # a part of another place
        parent[key] = copy.deepcopy(value_at(document, chance.choice(every)))
    elif kind == 2 and isinstance(parent, dict):  # another key, perhaps one of another object
        names = [step[-1] for step in every if isinstance(step[-1], str)]
        parent[chance.choice(names)] = parent.pop(key)
    elif kind == 3 and isinstance(value, list):
        chance.shuffle(value)
    elif kind == 4 and isinstance(value, list) and value:
        value.append(copy.deepcopy(chance.choice(value)))
    elif kind == 5:
        parent[key] = chance.choice([None, True, [], {}, [[]], chance.choice(STRINGS), chance.choice(NUMBERS)])
    elif isinstance(value, (int, float)) and not isinstance(value, bool):
        parent[key] = change_number(chance, value)
    elif isinstance(value, str):
        parent[key] = mutate_uri(chance, value) if value.startswith("data:") else chance.choice(STRINGS)
    else:
        parent[key] = chance.choice([*NUMBERS, *STRINGS])


def mutate_bytes(chance, data):
    """A copy of `data` with one to eight places flipped, set, cut out, repeated or cut off."""
    data = bytearray(data)
    for _ in range(chance.choice([1, 1, 2, 8])):
        if not data:
            break
        i, length = chance.randrange(len(data)), chance.choice([1, 2, 4, 16])
        kind = chance.randrange(5)
        if kind == 0:
            data[i] ^= 1 << chance.randrange(8)
        elif kind == 1:
            data[i:i + length] = bytes(chance.choice([0, 255, 127, 128, 34, 44, 91, 123]) for _ in range(length))
        elif kind == 2:
            del data[i:i + length]
        elif kind == 3:
            data[i:i] = data[i:i + length]
        elif chance.random() < 0.2:
            del data[i:]
    return bytes(data)


def mutate_uri(chance, uri):
    """Changes the bytes of a data URI."""
    head, _, body = uri.partition(",")
    try:
        return head + "," + base64.b64encode(mutate_bytes(chance, base64.b64decode(body))).decode()
    except ValueError:
        return uri[:chance.randrange(len(uri))]


def mutant(chance, seed):
    """(suffix, bytes) of a mutant of a document."""
    if chance.random() < 0.3:
        return "gltf", mutate_bytes(chance, json.dumps(seed).encode())
    document = copy.deepcopy(seed)
    for _ in range(chance.choice([1, 1, 1, 2, 3, 6])):
        mutate_json(chance, document)
    if chance.random() < 0.8:
        return "gltf", json.dumps(document).encode()
    buffers = document.get("buffers") if isinstance(document, dict) else None
    first = buffers[0] if isinstance(buffers, list) and buffers and isinstance(buffers[0], dict) else {}
    uri, binary = first.get("uri"), b""
    if isinstance(uri, str) and uri.startswith(PREFIX):
        try:
            binary = base64.b64decode(uri[len(PREFIX):])
            del first["uri"]
        except ValueError:
            pass
    whole = glb(document, binary)
    return "glb", mutate_bytes(chance, whole) if chance.random() < 0.3 else whole


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("scenes", nargs="*", type=pathlib.Path)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    seeds = sorted(args.scenes or (ROOT / "scenes").glob("*.gltf"))
    args.folder.mkdir(parents=True, exist_ok=True)
    for folder in {seed.parent for seed in seeds}:
        for file in folder.iterdir():
            if file.is_file() and file.suffix not in (".gltf", ".md"):
                shutil.copy(file, args.folder)
    documents = [json.loads(seed.read_bytes()) for seed in seeds]
    chance = random.Random(args.seed)
    with open(args.folder / "cases.txt", "w", encoding="utf-8") as cases:
        for i in range(args.count):
            which = chance.randrange(len(seeds))
            suffix, data = mutant(chance, documents[which])
            name = f"{i:06}_{seeds[which].stem}.{suffix}"
            (args.folder / name).write_bytes(data)
            cases.write(f"{name}\t{name}\tany\n")


if __name__ == "__main__":
    main()
