# SPDX-License-Identifier: Apache-2.0
"""eikon: a path tracer for glTF 2.0 scenes, on any OpenCL device, whose images state their own error.

>>> import eikon
>>> image = eikon.render("scenes/cornell.gltf", spp=4, size=(32, 24))
>>> image.rgb.shape
(24, 32, 3)
"""
from . import _driver as _driver  # before the module, which loads the drivers
from ._eikon import DeviceError, Error, InputError, InternalError, UsageError
from ._eikon import version as __version__
from ._picture import Comparison, Picture, PredictedError, compare, read
from ._render import Device, Progress, Reading, Render, devices, merge, meter, render
from ._scene import Scene

__all__ = [
    "Comparison", "Device", "DeviceError", "Error", "InputError", "InternalError", "Picture", "PredictedError", "Progress",
    "Reading", "Render", "Scene", "UsageError", "__version__", "compare", "devices", "merge", "meter", "read", "render",
]
