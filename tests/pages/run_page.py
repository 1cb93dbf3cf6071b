#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs every command of a page as a reader would, and fails with the first that does.

  tests/pages/run_page.py EIKON PAGE.md

Commands are the blocks of a page that are indented by four spaces; other listings stand in fences (```). They run in the
order of the page, in one shell, in a folder that looks like the project's with `build-release/eikon` in it. A block below
the line `<!-- not run: REASON -->` is left out, and named with its reason.
"""
import pathlib
import re
import subprocess
import sys
import tempfile
import textwrap

ROOT = pathlib.Path(__file__).resolve().parents[2]


def blocks(text):
    """(number of the first line, commands, reason why it is not run or None) of each indented block."""
    found, block, begin, reason, fenced, after_blank = [], [], 0, None, False, True
    for number, line in enumerate(text.split("\n") + ["end"], 1):
        if line.lstrip().startswith("```"):
            fenced = not fenced
        if not fenced and line.startswith("    ") and (block or after_blank):
            begin = begin if block else number
            block.append(line)
        elif block and not line.strip():
            block.append("")
        elif block:
            found.append((begin, textwrap.dedent("\n".join(block)).strip("\n"), reason))
            block, reason = [], None
        if mark := re.fullmatch(r"\s*<!-- not run: (.*) -->", line):
            reason = mark[1]
        after_blank = not line.strip()
    return found


def main():
    eikon, page = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    script = ["set -euo pipefail"]
    count = 0
    for number, commands, reason in blocks(page.read_text()):
        place = f"{page.relative_to(ROOT)}:{number}"
        if reason:
            print(f"{place}: not run: {reason}", flush=True)
            continue
        count += 1
        script += [f"trap 'echo {place}: a command of this block failed >&2' ERR", f"echo '== {place}'", commands]
    with tempfile.TemporaryDirectory() as folder:
        for entry in ROOT.iterdir():
            if entry.name != "out" and not entry.name.startswith("build"):
                (pathlib.Path(folder) / entry.name).symlink_to(entry)
        build = pathlib.Path(folder) / "build-release"
        build.mkdir()
        (build / "eikon").symlink_to(eikon)
        (pathlib.Path(folder) / "out").mkdir()
        # The line that a page asks for once; those of a page that says it again do no harm.
        script.insert(1, 'export PATH="$PWD/build-release:$PATH"')
        run = subprocess.run(["bash", "-c", "\n".join(script)], cwd=folder, stdin=subprocess.DEVNULL, check=False)
    print(f"{page.relative_to(ROOT)}: {count} blocks of commands" + ("" if run.returncode == 0 else ", one failed"))
    return run.returncode


if __name__ == "__main__":
    sys.exit(main())
