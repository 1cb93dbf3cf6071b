#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the examples of the package's docstrings and of its page, in a folder with scenes/ and out/."""
import doctest
import os
import pathlib
import re
import sys
import tempfile

import eikon
from eikon import _scene

ROOT = pathlib.Path(__file__).resolve().parents[2]


def main():
    runner = doctest.DocTestRunner()
    finder, parser = doctest.DocTestFinder(), doctest.DocTestParser()
    page = ROOT / "host/python/README.md"
    text = re.sub(r"(?m)^```.*$", "", page.read_text())
    tests = [*finder.find(eikon), *finder.find(_scene), parser.get_doctest(text, {}, page.name, str(page), 0)]
    tests = [test for test in tests if test.examples]
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        pathlib.Path("out").mkdir()
        pathlib.Path("scenes").symlink_to(ROOT / "scenes")
        for test in tests:
            runner.run(test)
        os.chdir(ROOT)
    print(f"{len(tests)} texts, {runner.tries} examples, {runner.failures} failed")
    return 1 if runner.failures or len(tests) < 3 else 0


if __name__ == "__main__":
    sys.exit(main())
