# SPDX-License-Identifier: Apache-2.0
"""Blender's render engine eikon: exports the scene as glTF, runs the program eikon, and shows the picture as it grows."""

bl_info = {
    "name": "eikon",
    "author": "The authors of eikon",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "description": "Renders with eikon, a path tracer that states its error",
    "category": "Render",
}


def register():
    from . import engine, settings

    settings.register()
    engine.register()


def unregister():
    from . import engine, settings

    engine.unregister()
    settings.unregister()
