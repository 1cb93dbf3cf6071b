#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the structure of the sources; prints each breach with its place, and exits with 1 if there is one.

  tools/check_structure.py            all checks
  tools/check_structure.py --sizes    all that exceeds LIMITS, allowed exceptions included, for planning

- A folder includes only folders above it in HOST_ORDER or KERNEL_ORDER, and no header includes itself through others.
- Folders, files, functions and parameter lists keep to LIMITS. What exceeds one for a good reason stands in
  tools/structure_exceptions.txt with that reason; an exception that is no longer needed is a breach too.
- Lines that hold nothing but a comment have at most COMMENT_COLUMNS columns.
- Every kernel header compiles alone (needs clang; CLANG names another one than clang-14), but for those that the file
  of exceptions lists as "header": they are written once and included several times with other macros.
"""
import argparse
import collections
import concurrent.futures
import os
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[1]
HOST_ORDER = ["core", "io", "formula", "image", "scene", "gltf", "accel", "device", "film", "guide", "pack", "wavefront", "render",
              "instruments", "page", "job", "view", "cli", "python"]
KERNEL_ORDER = ["shared", "lanes", "guide", "bsdf", "surface", "shapes", "traverse", "lights", "film", "stages", "probe"]
# A reader should be able to take each thing in at once: a folder's names and a function without scrolling, a file in one sitting,
# and the arguments of a call without looking up their order. "header" counts kernel headers that do not compile alone.
LIMITS = {"folder": 22, "file": 400, "function": 60, "parameters": 6, "header": 0}
UNITS = {"folder": "files", "file": "lines", "function": "lines", "parameters": "parameters"}
COMMENT_COLUMNS = 100  # prose in longer lines is hard to read; code may have more columns
EXCEPTIONS = ROOT / "tools/structure_exceptions.txt"
INCLUDE = re.compile(r'^\s*#\s*include "([^"]+)"', re.MULTILINE)


def sources():
    """Sources of host/, kernels/ and tests/, relative to the root."""
    suffixes = {".h", ".cpp", ".cl", ".def"}
    return sorted(p.relative_to(ROOT) for top in ("host", "kernels", "tests") for p in (ROOT / top).rglob("*")
                  if p.suffix in suffixes)


def included(path, text):
    """Project files that `path` includes, relative to the root: host files see host/ and kernels/, kernels see kernels/."""
    tops = ["host", "kernels"] if path.parts[0] == "host" else ["kernels"]
    for name in INCLUDE.findall(text):
        for top in tops:
            if (ROOT / top / name).is_file():
                yield pathlib.Path(top) / name
                break


def edge_breaches(graph):
    """Includes that go from a folder to one below it."""
    for path, targets in graph.items():
        for target in targets:
            for top, order in (("host", HOST_ORDER), ("kernels", KERNEL_ORDER)):
                if path.parts[0] != top or target.parts[0] != top or target.parts[1] == path.parts[1]:
                    continue
                unknown = [p for p in (path, target) if p.parts[1] not in order]
                if unknown:
                    yield f"{unknown[0]}: its folder is not in the order of {top}/"
                elif order.index(target.parts[1]) > order.index(path.parts[1]):
                    yield f"{path}: includes {target}, but {top}/{path.parts[1]} comes before {top}/{target.parts[1]}"


def cycle_breaches(graph):
    """Chains of includes that end where they began."""
    done, reported = set(), set()

    def walk(path, chain):
        if path in chain:
            cycle = chain[chain.index(path):]
            if frozenset(cycle) not in reported:
                reported.add(frozenset(cycle))
                yield " -> ".join(map(str, cycle + [path])) + ": a cycle of includes"
            return
        if path in done:
            return
        for target in graph.get(path, ()):
            yield from walk(target, chain + [path])
        done.add(path)

    for path in graph:
        yield from walk(path, [])


def without_comments(text):
    """The text with comments, strings, and preprocessor lines blanked; line breaks stay."""
    def blank(match):
        return re.sub(r"[^\n]", " ", match[0])
    text = re.sub(r'R"(\w*)\(.*?\)\1"', blank, text, flags=re.DOTALL)
    text = re.sub(r'"(?:[^"\\\n]|\\.)*"|\'(?:[^\'\\\n]|\\.)+\'|//[^\n]*|/\*.*?\*/', blank, text, flags=re.DOTALL)
    return re.sub(r"^[ \t]*#(?:[^\n\\]|\\.|\\\n)*", blank, text, flags=re.MULTILINE)


SCOPE = re.compile(r"\b(namespace|class|struct|union|enum)\b[^()]*$|\bextern\b\s*$")
TAIL = re.compile(r"\)\s*(?:(?:const|noexcept|override|final|mutable)\s*)*(?:->[^{};]*)?$")
NAME = re.compile(r"([~\w:]+|operator\S+)\s*\($")


def functions(text):
    """(name, parameters, lines) of each function with a body, and not of those within functions."""
    text = without_comments(text)
    scopes, head, opened = [], 0, None  # scopes: True where functions may stand
    for place, character in enumerate(text):
        if character == "{":
            words = text[head:place].strip()
            if all(scopes) and opened is None:
                bare = re.sub(r"(?<=\))\s*:(?!:).*$", "", words, flags=re.DOTALL)  # the initialisers of a constructor
                if SCOPE.search(words):
                    scopes.append(True)
                else:
                    if TAIL.search(bare) and "=" not in bare.split("(")[0] and bare.count("(") == bare.count(")"):
                        opened = (bare, text.count("\n", 0, head + len(text[head:place]) - len(text[head:place].lstrip())) + 1)
                    scopes.append(False)
            else:
                scopes.append(False)
            head = place + 1
        elif character == "}":
            if scopes:
                scopes.pop()
            if opened and all(scopes):
                words, line = opened
                yield (*signature(words), text.count("\n", 0, place) + 2 - line)
                opened = None
            head = place + 1
        elif character == ";" and all(scopes):
            head = place + 1


def signature(words):
    """(name, number of parameters) of a function's head."""
    depth, begin = 0, None
    for place in range(len(words) - 1, -1, -1):  # the last outermost parentheses
        depth += {")": 1, "(": -1}.get(words[place], 0)
        if words[place] == ")" and depth == 1:
            end = place
        if words[place] == "(" and depth == 0:
            begin = place
            break
    inside = words[begin + 1:end]
    flat, depth = "", 0
    for character in inside:
        depth -= character in ")>]}"
        flat += character if depth == 0 else " "
        depth += character in "(<[{"
    match = NAME.search(words[:begin + 1])
    return (match[1] if match else words[:begin].split()[-1] if words[:begin].split() else "?",
            0 if flat.strip() in ("", "void") else flat.count(",") + 1)


def measured():
    """(kind, place, number) of everything that LIMITS bound."""
    folders = collections.Counter()
    tracked = subprocess.run(["git", "-C", ROOT, "ls-files", "-z"], capture_output=True, text=True, check=False).stdout
    for name in filter(None, tracked.split("\0")):
        if (ROOT / name).is_file():
            folders[str(pathlib.PurePath(name).parent)] += 1
    for folder, count in folders.items():
        yield "folder", folder, count
    for path in sources():
        text = (ROOT / path).read_text()
        yield "file", str(path), text.count("\n")
        if path.suffix == ".def" or path.parts[0] == "tests":  # a test's body is a list of claims
            continue
        for name, parameters, lines in functions(text):
            yield "function", f"{path}:{name}", lines
            if "kernel void" not in text or f"kernel void {name}(" not in text:  # a kernel's arguments are bound by name
                yield "parameters", f"{path}:{name}", parameters


def exceptions():
    """{(kind, place): number} of the file of exceptions."""
    table = {}
    for number, line in enumerate(EXCEPTIONS.read_text().splitlines(), 1):
        if line.strip() and not line.startswith("#"):
            fields = line.split(maxsplit=3)
            if len(fields) < 4 or fields[0] not in LIMITS:
                sys.exit(f"{EXCEPTIONS}:{number}: wants KIND PLACE NUMBER REASON")
            table[fields[0], fields[1]] = int(fields[2])
    return table


def size_breaches():
    """Yields what exceeds its limit, or the number that the file of exceptions allows it; and exceptions that are of no use."""
    allowed, needed = exceptions(), set()
    for kind, place, number in measured():
        if number <= LIMITS[kind]:
            continue
        needed.add((kind, place))
        bound = allowed.get((kind, place), LIMITS[kind])
        if number > bound:
            yield f"{place}: {number} {UNITS[kind]} in one {kind.replace('parameters', 'list')}, at most {bound}"
    for kind, place in allowed.keys() - needed:
        if kind == "header" and (ROOT / place).is_file():
            continue
        yield f"tools/structure_exceptions.txt: {kind} {place} needs no exception"


def comment_breaches():
    """Lines of comments that are too long to read."""
    for path in sources():
        for number, line in enumerate((ROOT / path).read_text().splitlines(), 1):
            if len(line) > COMMENT_COLUMNS and line.lstrip().startswith("//"):
                yield f"{path}:{number}: a comment of {len(line)} columns, at most {COMMENT_COLUMNS}"


def lone_header_breaches():
    """Kernel headers that do not compile when nothing is included before them."""
    clang = os.environ.get("CLANG", "clang-14")
    if not shutil.which(clang):
        yield f"{clang} is not installed, so no kernel header was compiled alone"
        return
    def names(pattern, file):
        return re.findall(pattern, (ROOT / "kernels/shared" / file).read_text(), re.MULTILINE)
    features = names(r"^EK_(?:LOBE|LIGHT|SHAPE_KIND|OPTION|AOV)\((\w+)", "features.def")
    layouts = names(r"^EK_(?:LAYOUT|CELLS)\((\w+)", "layouts.def")
    common = [clang, "-x", "cl", "-cl-std=CL1.2", "-Xclang", "-finclude-default-header", "-fsyntax-only", "-Wall", "-Wextra",
              "-Wundef", "-Werror", "-Wno-unused-parameter", "-Wno-unused-function", "-Wno-bitwise-instead-of-logical",
              "-I", str(ROOT / "kernels"), "-DEK_CHUNK=1024", "-DEK_STACK_SIZE=64", "-DEK_SMALL_TREE=0", "-DEK_MEDIUM_TREE=1",
              "-DEK_LARGE_TREE=1"] + [f"-DEK_HAS_{f}=1" for f in features]
    wide = ["-DEK_WIDTH=16", "-DEK_CHUNKED=1", "-DEK_CPU=1"] + [f"-DEK_LAYOUT_{x}={int(x == 'bvh16')}" for x in layouts + ["none"]]

    def compile_alone(path):
        flags = list(wide)
        if path.parts[1:3] in (("traverse", "gpu"), ("traverse", "classic")):  # these are for one structure each, one lane wide
            flags = ["-DEK_WIDTH=1", "-DEK_CHUNKED=0", "-DEK_CPU=0"] + [f"-DEK_LAYOUT_{x}={int(x == path.stem)}" for x in layouts + ["none"]]
        run = subprocess.run([*common, *flags, "-"], input=f'#include "{path.relative_to("kernels")}"\n', text=True,
                             capture_output=True, check=False)
        error = next((line for line in run.stderr.split("\n") if "error" in line), run.stderr[:200])
        return None if run.returncode == 0 else f"{path}: does not compile alone: {error}"

    templates = {place for kind, place in exceptions() if kind == "header"}
    headers = [p for p in sources() if p.parts[0] == "kernels" and p.suffix == ".h" and str(p) not in templates]
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        yield from filter(None, pool.map(compile_alone, headers))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--sizes", action="store_true", help="print all that exceeds LIMITS, and check nothing")
    options = parser.parse_args()
    if options.sizes:
        table = sorted(measured(), key=lambda row: -row[2] / LIMITS[row[0]])
        for kind, place, number in table:
            if number > LIMITS[kind]:
                print(f"{kind:10} {place:80} {number}")
        return 0
    graph = {p: list(included(p, (ROOT / p).read_text())) for p in sources() if p.parts[0] != "tests"}
    breaches = [*edge_breaches(graph), *cycle_breaches(graph), *size_breaches(), *comment_breaches(), *lone_header_breaches()]
    for breach in breaches:
        print(breach)
    print(f"check_structure: {len(graph)} files, {len(breaches)} breaches" if breaches
          else f"check_structure: {len(graph)} files, no breach")
    return 1 if breaches else 0


if __name__ == "__main__":
    sys.exit(main())
