# SPDX-License-Identifier: Apache-2.0
"""Where the system has no OpenCL driver, that of the package pocl-binary-distribution (`pip install eikon[pocl]`) is used."""
import os
from importlib.util import find_spec
from pathlib import Path
from typing import Optional

SYSTEM = Path("/etc/OpenCL/vendors")
VARIABLES = ("OCL_ICD_VENDORS", "OCL_ICD_FILENAMES")


def installed_driver() -> Optional[Path]:
    """The library of pocl-binary-distribution, or None."""
    spec = find_spec("pocl_binary_distribution")
    if spec is None or spec.origin is None:
        return None
    folder = Path(spec.origin).parent.parent / "pyopencl/.libs"
    return next(iter(sorted(folder.glob("libpocl*.so"))), None)


def use_installed_driver() -> None:
    """Names the driver to the loader of OpenCL, unless the user or the system names one."""
    if any(name in os.environ for name in VARIABLES) or any(SYSTEM.glob("*.icd")):
        return
    driver = installed_driver()
    if driver is not None:
        os.environ["OCL_ICD_VENDORS"] = str(driver)


use_installed_driver()
