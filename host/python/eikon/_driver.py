# SPDX-License-Identifier: Apache-2.0
"""Where the system has no OpenCL driver, one for the processor from PyPI is used: `pip install eikon[intel]` or `eikon[pocl]`."""
import os
import site
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Iterator, Optional

SYSTEM = Path("/etc/OpenCL/vendors")
VARIABLES = ("OCL_ICD_VENDORS", "OCL_ICD_FILENAMES")  # by which a user names drivers to the loader of OpenCL
LIBRARIES = ("/lib", "/usr/lib", "/usr/local/lib", "/lib64", "/usr/lib64", "/usr/local/lib64")


def drivers_of_pypi() -> Iterator[Path]:
    """Libraries of intel-opencl-rt and pocl-binary-distribution, the newer driver first."""
    for folder in (sys.prefix, site.getuserbase()):
        yield from Path(folder, "lib").glob("libintelocl.so")
    spec = find_spec("pocl_binary_distribution")
    if spec is not None and spec.origin is not None:
        yield from sorted((Path(spec.origin).parent.parent / "pyopencl/.libs").glob("libpocl*.so"))


def has_library(icd: Path) -> bool:
    """False if the library that the file of a driver names is gone: packages leave such files behind."""
    try:
        name = icd.read_text().strip()
    except (OSError, UnicodeDecodeError):
        return False
    if os.path.isabs(name):
        return os.path.exists(name)
    folders = [*LIBRARIES, *filter(None, os.environ.get("LD_LIBRARY_PATH", "").split(":"))]
    return any(Path(folder, name).exists() or any(Path(folder).glob(f"*/{name}")) for folder in folders)


def choose_driver() -> Optional[Path]:
    """The driver of PyPI to use; None where the user or the system names one, or there is none."""
    if any(name in os.environ for name in VARIABLES):
        return None
    driver = next(drivers_of_pypi(), None)
    return None if driver is None or any(map(has_library, SYSTEM.glob("*.icd"))) else driver


_driver = choose_driver()
if _driver is not None:
    os.environ["OCL_ICD_VENDORS"] = str(_driver)
