# SPDX-License-Identifier: Apache-2.0
"""The render engine: one `eikon render` for each picture, whose growing state goes to Blender's render window."""
import tempfile
import threading
import time

import bpy
import numpy as np

from .export import Export
from .picture import PictureReceiver
from .program import Eikon, EikonError, find_eikon
from .settings import ENGINE

POLL_S = 0.1
SHOWING_SHARE = 0.1  # the most of the time that goes into pictures before the last
MISS_DEPTH = 1e10  # Blender's depth where nothing is


class Pass:
    """A pass of Blender's that is made of a layer of eikon's."""

    def __init__(self, name, letters, kind, layer, wanted):
        self.name, self.letters, self.kind, self.layer, self.wanted = name, letters, kind, layer, wanted

    def planes(self, channels):
        """The layer's channels, each rows from the top; None while there are none."""
        names = [self.layer + "." + letter for letter in self.letters]
        return [channels[name] for name in names] if all(name in channels for name in names) else None


PASSES = (
    Pass("Depth", "Z", "VALUE", "depth", lambda scene, layer: layer.use_pass_z),
    Pass("Normal", "XYZ", "VECTOR", "normal", lambda scene, layer: layer.use_pass_normal),
    Pass("Position", "XYZ", "VECTOR", "position", lambda scene, layer: layer.use_pass_position),
    Pass("Emit", "RGB", "COLOR", "emission", lambda scene, layer: layer.use_pass_emit),
    Pass("Albedo", "RGB", "COLOR", "albedo", lambda scene, layer: scene.eikon.use_pass_albedo),
)


def cosines(export):
    """The cosine between each pixel's ray and the axis of a perspective camera; 1 for others. Rows from the top."""
    (x0, y0, x1, y1), (width, height) = export.window()
    data = export.camera.data
    if data.type != "PERSP":
        return np.ones((y1 - y0, x1 - x0), np.float32)
    corners = data.view_frame(scene=export.scene)  # of the picture, in the camera's space
    half_x = max(abs(corner.x / corner.z) for corner in corners)
    half_y = max(abs(corner.y / corner.z) for corner in corners)
    x = ((np.arange(x0, x1) + 0.5) / width * 2 - 1) * half_x
    y = ((np.arange(y0, y1) + 0.5) / height * 2 - 1) * half_y
    return (1 / np.sqrt(1 + x[None, :] ** 2 + y[:, None] ** 2)).astype(np.float32)


def combined(channels):
    """Rows of red, green, blue and alpha, of the denoised picture once there is one."""
    prefix = "denoised." if "denoised.R" in channels else ""
    planes = [channels[prefix + letter] for letter in "RGB"]
    planes.append(channels["A"] if "A" in channels else np.ones_like(planes[0]))
    return np.stack(planes, axis=-1)


def pass_pixels(item, planes, along_axis):
    """Values of a pass from those of a layer: Blender's axes, and its depth, which is along the axis of the camera."""
    if item.name == "Depth":
        depth = planes[0] * along_axis
        return np.where(np.isfinite(depth), depth, np.float32(MISS_DEPTH))[..., None]
    if item.name in {"Normal", "Position"}:
        x, y, z = (np.where(np.isfinite(plane), plane, 0) for plane in planes)
        return np.stack([x, -z, y], axis=-1)
    return np.stack(planes, axis=-1)


def set_pixels(target, rows):
    """Sets a pass of Blender's, whose rows start at the bottom."""
    values = np.ascontiguousarray(rows[::-1], np.float32)
    try:
        target.rect.foreach_set(values.reshape(-1))
    except TypeError:  # Blender 3 wants one value for each pixel there
        target.rect = values.reshape(-1, values.shape[-1])


class EikonEngine(bpy.types.RenderEngine):
    bl_idname = ENGINE
    bl_label = "eikon"
    bl_use_preview = False
    bl_use_postprocess = True
    bl_use_shading_nodes_custom = False
    bl_use_eevee_viewport = True

    def update_render_passes(self, scene=None, renderlayer=None):
        self.register_pass(scene, renderlayer, "Combined", 4, "RGBA", "COLOR")
        for item in PASSES:
            if item.wanted(scene, renderlayer):
                self.register_pass(scene, renderlayer, item.name, len(item.letters), item.letters, item.kind)

    def is_cancelled(self):
        """True once the user has pressed Esc."""
        return self.test_break()

    def render(self, depsgraph):
        with tempfile.TemporaryDirectory(prefix="eikon-") as folder:
            try:
                self._render(depsgraph, folder)
            except EikonError as error:
                if not bpy.app.background:
                    self.error_set(str(error))  # over the picture; without a report, Blender 4.2 crashes
                self.report({"ERROR"}, str(error))

    def _render(self, depsgraph, folder):
        scene, layer = depsgraph.scene, depsgraph.view_layer
        passes = [item for item in PASSES if item.wanted(scene, layer)]
        program = find_eikon(bpy.context.preferences.addons[__package__].preferences.program)
        self.update_stats("", "exporting the scene")
        export = Export(scene, depsgraph, folder)
        self._in_main_thread(export.write)
        if self.is_cancelled():
            return
        flags = export.flags([item.layer for item in passes])
        canvas = Canvas(self, export, passes, layer.name)
        with PictureReceiver() as receiver:
            with Eikon(program, [*flags, "-o", folder + "/image.exr", "--tev", receiver.address], folder) as eikon:
                self._follow(eikon, receiver, canvas)
        for line in [*export.notes, *eikon.lines]:
            self.report({"WARNING"}, line)

    def _follow(self, eikon, receiver, canvas):
        """Shows the picture until eikon has ended. Raises EikonError for what it says."""
        next_s, status, cancelled = 0.0, "", False
        while not eikon.wait(POLL_S):
            self.update_progress(eikon.progress)
            if status != eikon.status:
                status = eikon.status
                self.update_stats("", status)
            if self.is_cancelled() and not cancelled:
                cancelled = True
                eikon.cancel()
            if time.monotonic() >= next_s:
                begin_s = time.monotonic()
                canvas.show(receiver)
                end_s = time.monotonic()
                next_s = end_s + (end_s - begin_s) / SHOWING_SHARE
        receiver.join()
        canvas.show(receiver)
        canvas.end()
        if cancelled:
            return
        failure = eikon.failure() or receiver.error
        if failure:
            raise EikonError(failure)

    def _in_main_thread(self, function):
        """Calls a function in the main thread, where operators belong. Raises what it raises."""
        if threading.current_thread() is threading.main_thread():
            function()
            return
        done, raised = threading.Event(), []

        def run():
            try:
                window = bpy.context.window_manager.windows[0]
                with bpy.context.temp_override(window=window):
                    function()
            except BaseException as error:  # pylint: disable=broad-except
                raised.append(error)
            done.set()

        bpy.app.timers.register(run)
        while not done.wait(POLL_S):
            if self.is_cancelled() and bpy.app.timers.is_registered(run):
                bpy.app.timers.unregister(run)
                return
        if raised:
            raise raised[0]


class Canvas:
    """The picture in Blender's render window."""

    def __init__(self, engine, export, passes, layer):
        self.engine, self.passes, self.layer = engine, passes, layer
        self.window, _ = export.window()
        self.along_axis = cosines(export)
        self.seen, self.result = 0, None
        for item in passes:
            engine.add_pass(item.name, len(item.letters), item.letters, layer=layer)

    def show(self, receiver):
        """Shows what has arrived since the last time."""
        self.seen, channels = receiver.copy(self.seen)
        if channels is None:
            return
        x0, y0, x1, y1 = self.window
        channels = {name: plane[y0:y1, x0:x1] for name, plane in channels.items()}
        if self.result is None:
            self.result = self.engine.begin_result(0, 0, x1 - x0, y1 - y0, layer=self.layer)
        targets = self.result.layers[0].passes
        set_pixels(targets["Combined"], combined(channels))
        for item in self.passes:
            planes = item.planes(channels)
            if planes is not None:
                set_pixels(targets[item.name], pass_pixels(item, planes, self.along_axis))
        self.engine.update_result(self.result)

    def end(self):
        if self.result is not None:
            self.engine.end_result(self.result)


def register():
    bpy.utils.register_class(EikonEngine)


def unregister():
    bpy.utils.unregister_class(EikonEngine)
