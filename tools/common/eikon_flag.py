# SPDX-License-Identifier: Apache-2.0
"""Gives every script that runs eikon the same flag for it: --eikon FILE."""

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
