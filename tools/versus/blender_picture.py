# SPDX-License-Identifier: Apache-2.0
"""Pictures by way of Blender, which reads OpenEXR files without another package. Needs the modules bpy and numpy."""
import bpy
import numpy as np


def read(path):
    """The picture of an EXR file: rows from the top, [y, x, channel], as 32-bit floats."""
    image = bpy.data.images.load(str(path))
    image.colorspace_settings.name = "Non-Color"
    width, height = image.size
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(height, width, -1)[::-1]
