# SPDX-License-Identifier: Apache-2.0
"""Finds the Python modules that the comparisons need, wherever the user keeps them. Standard library only."""

import importlib.util
import os
import pathlib
import subprocess
import sys


def install(home, packages, python="python3"):
    """Makes the virtual environment `home` with the packages of PyPI, if it is not there."""
    if (home / "bin" / "python").exists():
        return
    print(f"making {home}", flush=True)
    subprocess.run([python, "-m", "venv", home], check=True)
    subprocess.run([home / "bin" / "python", "-m", "pip", "install", "--quiet", *packages.split()], check=True)


def need(names, folder, packages):
    """Returns if the modules `names` can be imported. Else starts the script again with the Python of a virtual
    environment that has them, `folder` in the home folder or what EIKON_VERSUS names; with --install among the arguments
    it is made. Else says what to install."""
    missing = [name for name in names if importlib.util.find_spec(name) is None]
    if not missing:
        return
    home = pathlib.Path(os.environ.get("EIKON_VERSUS", pathlib.Path.home() / folder))
    python = home / "bin" / "python"
    if "--install" in sys.argv:
        install(home, packages)
    if python.exists() and pathlib.Path(sys.prefix).resolve() != home.resolve():
        os.execv(python, [str(python), *sys.argv])
    sys.exit(f"Python modules are missing: {', '.join(missing)}. To have them in {home}, which is looked for:\n"
             f"  python3 -m venv {home} && {python} -m pip install {packages}\n"
             f"or name the folder of another virtual environment by the environment variable EIKON_VERSUS.")
