# SPDX-License-Identifier: Apache-2.0
"""The flags that scripts share: --eikon FILE of every script that runs eikon, and counts."""

import argparse
import os
import pathlib
import shutil

ROOT = pathlib.Path(__file__).resolve().parents[2]


def program_path(text):
    """Returns the absolute path of a program: that of the file, or of the program of this name in PATH. The file may be
    missing, since some scripts do not run eikon with all of their flags."""
    return os.path.abspath(shutil.which(text) or text)


def add_eikon_flag(parser):
    """Adds --eikon to a parser; its value is an absolute path as a string."""
    parser.add_argument("--eikon", type=program_path, default=str(ROOT / "build-release/eikon"), metavar="FILE",
                        help="the program [build-release/eikon of this project]")


def at_least(least):
    """Returns a type for argparse: whole numbers that are not smaller."""
    def count(text):
        try:
            number = int(text)
        except ValueError:
            number = None
        if number is None or number < least:
            raise argparse.ArgumentTypeError(f"{text!r} is not a whole number from {least} on")
        return number
    return count
