# SPDX-License-Identifier: Apache-2.0
"""Exports a scene by Blender's glTF exporter, and finds the flags of `eikon render` for the rest."""
import contextlib
import json
import math
import pathlib
import shlex

import bpy

from . import document as documents
from .program import EikonError

# Options of bpy.ops.export_scene.gltf; those that an older exporter does not have are left out.
OPTIONS = {
    "export_format": "GLTF_SEPARATE", "export_yup": True, "export_apply": True, "export_cameras": True, "export_lights": True,
    # W / sr and W / m^2, so that lights fit to emissive surfaces and the world.
    "export_import_convert_lighting_mode": "COMPAT",
    # The scene as it is at the frame: modifiers and poses are in the meshes, and so are shape keys
    # where there are modifiers.
    "export_animations": False, "export_skins": False, "export_morph": True, "export_current_frame": True,
    "use_renderable": True, "use_active_scene": True, "export_gn_mesh": True, "export_extras": False,
    "export_attributes": False, "will_save_settings": False,
}


@contextlib.contextmanager
def modifiers_of_renders():
    """Makes modifiers, which the exporter applies as they are in the viewport, those of renders meanwhile."""
    changed = []

    def change(modifier, name, value):
        if getattr(modifier, name) != value:
            changed.append((modifier, name, getattr(modifier, name)))
            setattr(modifier, name, value)

    try:
        for thing in bpy.data.objects:
            for modifier in thing.modifiers if thing.library is None else ():
                change(modifier, "show_viewport", modifier.show_render)
                if modifier.type in {"SUBSURF", "MULTIRES"}:
                    change(modifier, "levels", modifier.render_levels)
        yield
    finally:
        for modifier, name, value in changed:
            setattr(modifier, name, value)


class Export:
    """A scene on its way to eikon.

    scene       Blender's, as it is at the frame
    folder      where its files go
    camera      the object that the picture is taken with
    notes       lines on what will look different"""

    def __init__(self, scene, depsgraph, folder):
        self.scene, self.depsgraph, self.folder = scene, depsgraph, pathlib.Path(folder)
        self.camera = scene.camera
        self.notes = []
        self.file = self.folder / "scene.gltf"
        if self.camera is None or self.camera.type != "CAMERA":
            raise EikonError("eikon: the scene has no camera")
        if self.camera.data.type == "PANO":
            raise EikonError("eikon: camera '%s' is panoramic; leave it perspective, and give the flag --panorama"
                             % self.camera.name)

    def write(self):
        """Writes the file. To be called in the main thread. Raises EikonError."""
        known = bpy.ops.export_scene.gltf.get_rna_type().properties.keys()
        options = {name: value for name, value in OPTIONS.items() if name in known}
        try:
            with bpy.context.temp_override(scene=self.scene.original), modifiers_of_renders():
                bpy.ops.export_scene.gltf(filepath=str(self.file), check_existing=False, **options)
        except (RuntimeError, TypeError, AttributeError) as error:
            lines = [line for line in str(error).strip().splitlines() if not line.startswith("Location:")]
            raise EikonError("eikon: the scene cannot be exported as glTF: %s" % (lines or [""])[-1]) from error
        document = json.loads(self.file.read_text(encoding="utf-8"))
        self._add_camera(document)
        self._add_lights(document)
        self.file.write_text(json.dumps(document), encoding="utf-8")

    def _add_camera(self, document):
        camera = documents.keep_camera(document, self.camera.name)
        if camera is None:
            raise EikonError("eikon: camera '%s' was not exported; is it hidden from renders?" % self.camera.name)
        data = self.camera.data
        if data.shift_x != 0 or data.shift_y != 0:
            self.notes.append("eikon: the shift of camera '%s' is left out" % self.camera.name)
        if data.dof.use_dof and data.type == "PERSP":
            focus = data.dof.focus_distance
            if data.dof.focus_object is not None:
                way = data.dof.focus_object.matrix_world.translation - self.camera.matrix_world.translation
                focus = -way.dot(self.camera.matrix_world.col[2].to_3d().normalized())
            if focus > 0:
                documents.add_lens(document, camera, data, focus)

    def _add_lights(self, document):
        spheres = set()
        for instance in self.depsgraph.object_instances:
            thing = instance.object
            if thing.type != "LIGHT" or not instance.show_self:
                continue
            light, name, world = thing.data, thing.original.name, instance.matrix_world.copy()
            if light.type == "AREA":
                documents.add_area_light(document, name, light, world)
            elif light.type == "POINT" and light.shadow_soft_size > 0 and self.scene.eikon.lamps and not light.use_nodes:
                documents.add_sphere_light(document, name, light, world)
                spheres.add(name)
        documents.drop_point_lights(document, spheres)

    # ---- flags

    def window(self):
        """(x0, y0, x1, y1) of the border in pixels from the top left, the whole picture's without one; and its size."""
        render = self.scene.render
        width = max(1, int(render.resolution_x * render.resolution_percentage / 100))
        height = max(1, int(render.resolution_y * render.resolution_percentage / 100))
        if not render.use_border:
            return (0, 0, width, height), (width, height)
        x0, x1 = int(render.border_min_x * width), int(render.border_max_x * width)
        y0, y1 = int(render.border_min_y * height), int(render.border_max_y * height)
        return (x0, height - y1, x1, height - y0), (width, height)

    def flags(self, layers):
        """The words after `eikon render`, but for where the picture goes. layers: of --aov"""
        settings, render = self.scene.eikon, self.scene.render
        window, size = self.window()
        if render.pixel_aspect_x != render.pixel_aspect_y:
            self.notes.append("eikon: pixels are square; the aspect of the scene's is left out")
        flags = [str(self.file), "--size", "%dx%d" % size, "--spp", str(settings.samples), "--seed", str(settings.seed)]
        if window != (0, 0, *size):
            flags += ["--crop", "%d,%d,%d,%d" % window]
        if settings.seconds > 0:
            flags += ["--time", repr(settings.seconds)]
        if settings.denoise:
            flags += ["--denoise"]
        if render.film_transparent:
            flags += ["--transparent"]
        if layers:
            flags += ["--aov", ",".join(layers)]
        flags += self._environment()
        try:
            return flags + shlex.split(settings.flags)
        except ValueError as error:
            raise EikonError("eikon: More Flags: %s" % error) from error

    def _environment(self):
        """The flags of the world: a colour, or a picture around the scene."""
        world = self.scene.world
        if world is None:
            return ["--env", "none"]
        if not world.use_nodes:
            return ["--env", ",".join(repr(value) for value in world.color)]
        output = world.node_tree.get_output_node("ALL")
        links = output.inputs["Surface"].links if output is not None else ()
        if not links:
            return ["--env", "none"]
        background = links[0].from_node
        if background.type != "BACKGROUND" or background.inputs["Strength"].links:
            self.notes.append("eikon: the world is left out; its surface has to be a Background with a strength that is a number")
            return ["--env", "none"]
        strength = background.inputs["Strength"].default_value
        colour = background.inputs["Color"]
        if not colour.links:
            return ["--env", ",".join(repr(strength * value) for value in colour.default_value[:3])]
        picture = colour.links[0].from_node
        if picture.type != "TEX_ENVIRONMENT" or picture.image is None or picture.projection != "EQUIRECTANGULAR":
            self.notes.append("eikon: the world is left out; its colour has to be fixed, or an equirectangular Environment Texture")
            return ["--env", "none"]
        return ["--env", self._environment_file(picture.image), "--env-scale", repr(strength),
                "--env-rotate", repr(self._environment_turn(picture))]

    def _environment_file(self, image):
        """The file of a picture; a copy if it is packed or of a format that eikon does not read as an environment."""
        path = pathlib.Path(bpy.path.abspath(image.filepath, library=image.library))
        if image.packed_file is None and path.suffix.lower() in {".exr", ".hdr"} and path.is_file():
            return str(path)
        copy = image.copy()
        try:
            copy.filepath_raw = str(self.folder / "environment.exr")
            copy.file_format = "OPEN_EXR"
            copy.save()
        except RuntimeError as error:
            raise EikonError("eikon: the picture of the world cannot be read: %s" % str(error).strip()) from error
        finally:
            bpy.data.images.remove(copy)
        return str(self.folder / "environment.exr")

    def _environment_turn(self, picture):
        """Degrees of --env-rotate. The middle of a picture is +X in Blender, and -Z, which is Blender's +Y, in eikon."""
        links = picture.inputs["Vector"].links
        turn = 0.0
        if links and links[0].from_node.type == "MAPPING":
            rotation = links[0].from_node.inputs["Rotation"].default_value
            turn = math.degrees(rotation[2])
            if rotation[0] != 0 or rotation[1] != 0:
                self.notes.append("eikon: the environment is turned about the vertical axis only")
        elif links and links[0].from_node.type != "TEX_COORD":
            self.notes.append("eikon: the coordinates of the environment are left out")
        return -90.0 - turn
