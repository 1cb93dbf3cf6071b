#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The add-on for Blender, in Blender as a Python module: blender_test.py EIKON [unittest arguments]

EIKON_BPY names a Python that has the modules bpy (4.2 to 5.0, of PyPI) and numpy; otherwise that of ~/eikon-cycles, with which
tools/versus runs Cycles, is taken. Without either the test is left out."""
import contextlib
import importlib.util
import math
import os
import pathlib
import shlex
import shutil
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = pathlib.Path()
SKIPPED = 77


def find_bpy():
    """Returns if bpy is here; else starts the script again with the Python that has it, or ends it as skipped."""
    if importlib.util.find_spec("bpy") is not None:
        return
    python = os.environ.get("EIKON_BPY") or str(pathlib.Path.home() / "eikon-cycles/bin/python")
    if not os.access(python, os.X_OK) or sys.executable == python:
        print("left out: EIKON_BPY does not name a Python that has bpy and numpy")
        sys.exit(SKIPPED)
    os.execv(python, [python, *sys.argv])


find_bpy()
# Blender makes a folder of its own there, and does not come to remove it.
SCRATCH = tempfile.mkdtemp(prefix="eikon_blender_")
os.environ["TMPDIR"] = SCRATCH
import bpy  # noqa: E402  isort: skip
import addon_utils  # noqa: E402  which bpy makes known
import numpy as np  # noqa: E402

sys.path[:0] = [str(ROOT / "tools/blender"), str(ROOT / "tools/versus")]
from blender_picture import read  # noqa: E402


def add(data, location=(0, 0, 0), rotation=(0, 0, 0), scale=(1, 1, 1)):
    """A new object of data; an empty one of None."""
    thing = bpy.data.objects.new("thing" if data is None else data.name, data)
    thing.location, thing.rotation_euler, thing.scale = location, rotation, scale
    bpy.context.scene.collection.objects.link(thing)
    return thing


def mesh(kind, material=None, **options):
    getattr(bpy.ops.mesh, "primitive_%s_add" % kind)(**options)
    thing = bpy.context.object
    if material is not None:
        thing.data.materials.append(material)
    return thing


def material(name, kind, **inputs):
    """A material of one node, such as BsdfPrincipled or Emission."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    node, output = nodes.new("ShaderNode" + kind), nodes.new("ShaderNodeOutputMaterial")
    for name_of_input, value in inputs.items():
        node.inputs[name_of_input.replace("_", " ")].default_value = value
    links.new(node.outputs[0], output.inputs["Surface"])
    return made


def diffuse(name, value):
    return material(name, "BsdfPrincipled", Base_Color=(value, value, value, 1), Specular_IOR_Level=0.0, Roughness=1.0)


class AddOn(unittest.TestCase):
    def setUp(self):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        addon_utils.enable("eikon_render", default_set=True)
        self.addCleanup(addon_utils.disable, "eikon_render", default_set=True)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.set_program(PROGRAM)
        self.scene = bpy.context.scene
        self.scene.render.engine = "EIKON"
        self.scene.render.resolution_x, self.scene.render.resolution_y = 48, 32
        self.scene.view_settings.view_transform = "Raw"
        self.scene.render.image_settings.file_format = "OPEN_EXR"
        self.scene.render.image_settings.color_depth = "32"
        self.scene.render.image_settings.color_mode = "RGBA"
        self.scene.eikon.samples = 16
        self.set_world(0.0)

    def set_program(self, program):
        bpy.context.preferences.addons["eikon_render"].preferences.program = str(program)

    def set_world(self, *radiance):
        world = bpy.data.worlds.new("world")
        world.use_nodes = True
        rgb = radiance if len(radiance) == 3 else radiance * 3
        world.node_tree.nodes["Background"].inputs["Color"].default_value = (*rgb, 1)
        self.scene.world = world

    def add_camera(self, location, rotation, **data):
        made = bpy.data.cameras.new("view")
        for name, value in data.items():
            setattr(made, name, value)
        self.scene.camera = add(made, location, rotation)

    def room(self):
        """Some things that show which way is up, left and near; a camera that looks down at them."""
        self.add_camera((0.5, -6, 3.5), (math.radians(62), 0, math.radians(4)), lens=35)
        mesh("plane", diffuse("grey", 0.5), size=8)
        mesh("cube", material("red", "BsdfPrincipled", Base_Color=(0.8, 0.1, 0.1, 1)), size=1, location=(-1.4, 0, 0.5))
        mesh("uv_sphere", material("gold", "BsdfPrincipled", Base_Color=(1, 0.8, 0.3, 1), Metallic=1.0, Roughness=0.2),
             radius=0.6, location=(0.9, -0.5, 0.6))
        mesh("cone", material("lamp", "Emission", Color=(0.2, 0.5, 1, 1), Strength=3.0), radius1=0.4, depth=1,
             location=(0.2, 1.6, 0.5))
        light = bpy.data.lights.new("window", "AREA")
        light.energy, light.size, light.size_y, light.shape = 120, 2, 1, "RECTANGLE"
        add(light, (-2, -1, 4), (0.3, -0.4, 0))
        self.set_world(0.2, 0.3, 0.4)

    def render(self, engine="EIKON", name="picture.exr"):
        self.scene.render.engine = engine
        self.scene.render.filepath = str(self.folder / name)
        with open(os.devnull, "w", encoding="utf-8") as nothing, contextlib.redirect_stdout(nothing):
            bpy.ops.render.render(write_still=True)
        return read(self.folder / name)

    def render_by_cycles(self, samples):
        cycles = self.scene.cycles
        cycles.device, cycles.samples, cycles.use_adaptive_sampling, cycles.use_denoising = "CPU", samples, False, False
        cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
        cycles.pixel_filter_type, cycles.filter_width = "BOX", 1.0
        return self.render("CYCLES", "cycles.exr")

    def spy(self):
        """Makes the program a script that keeps its arguments and the exported files. Returns the folder where they are."""
        kept = self.folder / "kept"
        kept.mkdir()
        script = self.folder / "spy"
        script.write_text('#!/bin/sh\nfor word in "$@"; do printf "%%s\\n" "$word"; done > %s/words\n'
                          'cp -r . %s\nexec %s "$@"\n' % (kept, kept, shlex.quote(str(PROGRAM))))
        script.chmod(0o755)
        self.set_program(script)
        return kept


class Picture(AddOn):
    def test_is_the_one_that_eikon_renders_of_the_export(self):
        self.room()
        kept = self.spy()
        picture = self.render()
        words = (kept / "words").read_text().splitlines()
        for unwanted in ("--tev", "--progress", "-o"):
            at = words.index(unwanted)
            del words[at:at + 2]
        words[1] = str(kept / "scene.gltf")
        subprocess.run([PROGRAM, *words, "-o", self.folder / "direct.exr"], check=True)
        direct = read(self.folder / "direct.exr")
        self.assertEqual(picture[..., :3].tobytes(), direct[..., :3].tobytes())
        self.assertTrue(np.all(picture[..., 3] == 1))
        self.assertGreater(picture[..., :3].std(), 0.05)

    def test_looks_like_that_of_cycles_from_any_camera(self):
        self.room()
        self.scene.eikon.samples = 256
        cameras = {"landscape": {}, "portrait": {"size": (32, 48)}, "fit to height": {"sensor_fit": "VERTICAL"},
                   "parallel": {"type": "ORTHO", "ortho_scale": 6.0}, "half": {"percentage": 50}}
        for name, change in cameras.items():
            with self.subTest(camera=name):
                data = self.scene.camera.data
                data.type, data.ortho_scale = change.get("type", "PERSP"), change.get("ortho_scale", 6.0)
                data.sensor_fit = change.get("sensor_fit", "AUTO")
                self.scene.render.resolution_percentage = change.get("percentage", 100)
                self.scene.render.resolution_x, self.scene.render.resolution_y = change.get("size", (48, 32))
                ours, theirs = self.render()[..., :3], self.render_by_cycles(256)[..., :3]
                self.assertEqual(ours.shape, theirs.shape)
                self.assertAlmostEqual(ours.mean() / theirs.mean(), 1, delta=0.03)
                difference = np.abs(ours - theirs).mean() / theirs.mean()
                self.assertLess(difference, 0.06)
                self.assertGreater(np.abs(ours[::-1] - theirs).mean() / theirs.mean(), 0.3)  # the comparison sees something

    def test_has_modifiers_poses_shape_keys_and_instances(self):
        self.add_camera((0, -8, 3), (math.radians(72), 0, 0), lens=35)
        self.set_world(0.8)
        blue = material("blue", "BsdfPrincipled", Base_Color=(0.1, 0.2, 0.8, 1), Roughness=1.0)
        rounded = mesh("cube", blue, size=1.6, location=(-2.2, 0, 0.5))
        rounded.modifiers.new("round", "SUBSURF").render_levels = 3
        keyed = mesh("plane", blue, size=1.2, location=(0, 0, 0.6), rotation=(math.radians(90), 0, 0))
        keyed.shape_key_add(name="Basis")
        key = keyed.shape_key_add(name="wide")
        for point in key.data:
            point.co.x *= 2
        key.value = 0.5
        bpy.ops.object.armature_add(location=(2.2, 0, 0))
        armature = bpy.context.object
        bar = mesh("cube", blue, size=1, location=(2.2, 0, 0.5), scale=(0.3, 0.3, 1))
        bar.vertex_groups.new(name="Bone").add(range(8), 1.0, "REPLACE")
        bar.modifiers.new("bend", "ARMATURE").object = armature
        armature.pose.bones[0].rotation_mode = "XYZ"
        armature.pose.bones[0].rotation_euler = (0, 0, math.radians(60))
        group = bpy.data.collections.new("group")
        green = material("green", "BsdfPrincipled", Base_Color=(0.1, 0.7, 0.1, 1), Roughness=1.0)
        group.objects.link(mesh("cone", green, radius1=0.4, depth=1))
        for x in (-1, 1):
            instance = add(None, (x, 0, 2))
            instance.instance_type, instance.instance_collection = "COLLECTION", group
        self.scene.eikon.samples = 64
        ours, theirs = self.render()[..., :3], self.render_by_cycles(64)[..., :3]
        difference = np.abs(ours - theirs).mean() / theirs.mean()
        self.assertLess(difference, 0.01)
        self.assertEqual(rounded.modifiers[0].levels, 1)  # as the user left it
        bone = armature.pose.bones[0]
        changes = {"shape key": lambda: setattr(key, "value", 0.0), "pose": lambda: setattr(bone, "rotation_euler", (0, 0, 0)),
                   "modifier": lambda: setattr(rounded.modifiers[0], "render_levels", 0),
                   "instance": lambda: setattr(instance, "instance_type", "NONE")}
        for name, change in changes.items():
            with self.subTest(without=name):
                change()
                other = np.abs(self.render()[..., :3] - theirs).mean() / theirs.mean()
                self.assertGreater(other, difference + 0.002)
                difference = other

    def test_of_a_border_is_that_part(self):
        self.room()
        whole = self.render()
        render = self.scene.render
        render.use_border = True
        render.border_min_x, render.border_max_x, render.border_min_y, render.border_max_y = 0.25, 0.75, 0.5, 1.0
        self.assertEqual(self.render()[0:16, 12:36, :3].tobytes(), whole[0:16, 12:36, :3].tobytes())
        render.use_crop_to_border = True
        part = self.render()
        self.assertEqual(part.shape[:2], (16, 24))
        self.assertEqual(part[..., :3].tobytes(), whole[0:16, 12:36, :3].tobytes())

    def test_may_be_of_another_scene_than_the_one_that_is_open(self):
        self.room()
        picture = self.render()
        full = self.scene
        bpy.context.window.scene = bpy.data.scenes.new("empty")
        self.assertNotEqual(bpy.context.scene, full)
        bpy.ops.render.render(write_still=True, scene=full.name)
        self.assertEqual(read(self.folder / "picture.exr").tobytes(), picture.tobytes())

    def test_has_the_sky_left_out_on_request(self):
        self.room()
        self.scene.render.film_transparent = True
        alpha = self.render()[..., 3]
        self.assertEqual(alpha[0, 0], 0)
        self.assertEqual(alpha[-1, 24], 1)

    def test_is_of_the_frame(self):
        self.room()
        cube = bpy.data.objects["Cube"]
        for frame, x in ((1, -1.4), (11, 1.6)):
            cube.location.x = x
            cube.keyframe_insert("location", frame=frame)
        self.scene.frame_set(1)
        first = self.render()
        self.scene.frame_set(11)
        last = self.render()
        red = [np.argmax((picture[..., 0] - picture[..., 1]).sum(axis=0)) for picture in (first, last)]
        self.assertLess(red[0], red[1])


class Lights(AddOn):
    def test_are_as_bright_as_those_of_cycles(self):
        self.add_camera((0, -4, 4), (math.radians(45), 0, 0))
        mesh("plane", diffuse("white", 0.8), size=20)
        self.scene.eikon.samples = 256
        lights = {"SUN": {"energy": 2.0}, "POINT": {"energy": 100.0, "shadow_soft_size": 0.3},
                  "point without size": {"type": "POINT", "energy": 100.0, "shadow_soft_size": 0.0},
                  "SPOT": {"energy": 300.0, "shadow_soft_size": 0.0, "spot_size": 2.5, "spot_blend": 0.0},
                  "AREA": {"energy": 80.0, "shape": "SQUARE", "size": 1.5},
                  "rectangle": {"type": "AREA", "energy": 80.0, "shape": "RECTANGLE", "size": 2.0, "size_y": 0.5},
                  "disc": {"type": "AREA", "energy": 80.0, "shape": "DISK", "size": 1.5},
                  "ellipse": {"type": "AREA", "energy": 80.0, "shape": "ELLIPSE", "size": 2.0, "size_y": 0.7}}
        for name, values in lights.items():
            with self.subTest(light=name):
                light = bpy.data.lights.new(name, values.get("type", name))
                for key, value in values.items():
                    if key != "type":
                        setattr(light, key, value)
                light.color = (1, 0.5, 0.25)
                thing = add(light, (0.5, 1, 3), (0.2, -0.3, 0.4), (1.2, 0.8, 1))
                ours, theirs = self.render()[8:24, 12:36, :3], self.render_by_cycles(256)[8:24, 12:36, :3]
                for c in range(3):
                    self.assertAlmostEqual(ours[..., c].mean() / theirs[..., c].mean(), 1, delta=0.02)
                self.assertLess(np.abs(ours - theirs).mean() / theirs.mean(), 0.05)
                bpy.data.objects.remove(thing)

    def test_of_the_world_may_be_a_picture_that_is_turned(self):
        self.add_camera((0, 0, 1), (math.radians(100), 0, math.radians(30)), lens=20)
        mesh("uv_sphere", material("mirror", "BsdfPrincipled", Base_Color=(1, 1, 1, 1), Metallic=1.0, Roughness=0.0),
             radius=0.3, location=(-0.4, 1.2, 0.9))
        sky = bpy.data.images.new("sky", 64, 32, float_buffer=True)
        y, x = np.mgrid[0:32, 0:64]
        rgb = np.stack([0.2 + x / 64, 0.2 + y / 32, 1.2 - x / 64, np.ones_like(x)], axis=-1).astype(np.float32)
        sky.pixels.foreach_set(rgb.reshape(-1))
        sky.pack()
        nodes, links = self.scene.world.node_tree.nodes, self.scene.world.node_tree.links
        texture, mapping, place = (nodes.new("ShaderNode" + kind) for kind in ("TexEnvironment", "Mapping", "TexCoord"))
        texture.image = sky
        sky.colorspace_settings.name = "Linear Rec.709"
        mapping.inputs["Rotation"].default_value[2] = 0.7
        links.new(place.outputs["Generated"], mapping.inputs["Vector"])
        links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
        links.new(texture.outputs["Color"], nodes["Background"].inputs["Color"])
        nodes["Background"].inputs["Strength"].default_value = 1.5
        ours, theirs = self.render()[..., :3], self.render_by_cycles(64)[..., :3]
        self.assertLess(np.abs(ours - theirs).mean() / theirs.mean(), 0.02)

    def test_blur_what_is_out_of_focus(self):
        self.add_camera((0, -3, 0), (math.radians(90), 0, 0), lens=50)
        mesh("cube", material("lamp", "Emission", Strength=1.0), size=1, location=(0, 1, 0))
        dof = self.scene.camera.data.dof
        self.scene.eikon.samples = 256
        sharp = self.render()[..., 0]
        dof.use_dof, dof.aperture_fstop, dof.focus_distance = True, 0.1, 1.0
        ours, theirs = self.render()[..., 0], self.render_by_cycles(256)[..., 0]
        self.assertLess(np.abs(ours - theirs).mean() / theirs.mean(), 0.03)
        self.assertGreater(np.abs(sharp - theirs).mean() / theirs.mean(), 0.1)


class Passes(AddOn):
    @unittest.skipIf(bpy.app.version >= (5, 0, 0), "writes passes by the compositor of Blender 4")
    def test_agree_with_those_of_cycles(self):
        self.room()
        bpy.data.objects.remove(bpy.data.objects["Cone"])
        layer = self.scene.view_layers[0]
        layer.use_pass_z = layer.use_pass_normal = layer.use_pass_position = True
        self.scene.eikon.use_pass_albedo = True
        self.scene.eikon.samples = 64
        self.scene.use_nodes = True
        nodes, links = self.scene.node_tree.nodes, self.scene.node_tree.links
        nodes.clear()
        source, files, out = (nodes.new("CompositorNode" + kind) for kind in ("RLayers", "OutputFile", "Composite"))
        links.new(source.outputs["Image"], out.inputs["Image"])
        files.format.file_format, files.format.color_depth = "OPEN_EXR", "32"
        files.base_path = str(self.folder)

        def passes(engine, names):
            self.scene.render.engine = engine
            source.layer = source.layer  # its outputs are those of the engine
            files.file_slots.clear()
            for name in names:
                files.file_slots.new(engine + name + "#")
                links.new(source.outputs[name], files.inputs[-1])
            if engine == "CYCLES":
                self.render_by_cycles(64)
            else:
                self.render()
            return {name: read(self.folder / ("%s%s%d.exr" % (engine, name, self.scene.frame_current))) for name in names}

        ours = passes("EIKON", ["Depth", "Normal", "Position", "Albedo"])
        theirs = passes("CYCLES", ["Depth", "Normal", "Position"])
        seen = theirs["Depth"][..., 0] < 1e9
        self.assertTrue(0.5 < seen.mean() < 1)
        # Cycles has one sample's depth, eikon the mean over the pixel: they differ where it holds
        # an edge.
        depth = np.abs(ours["Depth"][..., 0] / theirs["Depth"][..., 0] - 1)[seen]
        self.assertLess(np.median(depth), 0.01)
        self.assertGreater(np.mean(ours["Depth"][..., 0][~seen] > 1e9), 0.9)
        for name, most in (("Normal", 0.02), ("Position", 0.08)):
            self.assertLess(np.median(np.abs(ours[name] - theirs[name])[seen][:, :3]), most, name)
        self.assertAlmostEqual(ours["Albedo"][-1, 24, 0], 0.5, delta=0.1)


class Failures(AddOn):
    def refused(self, *words):
        with self.assertRaises(RuntimeError) as raised:
            self.render()
        for word in words:
            self.assertIn(word, str(raised.exception))
        self.assertEqual(str(raised.exception).strip().count("eikon: "), 1)

    def test_are_told_in_a_line(self):
        self.room()
        self.scene.eikon.flags = "--nonsense 3"
        self.refused("--nonsense")
        self.scene.eikon.flags = "--max-depth 'x"
        self.refused("More Flags")
        self.scene.eikon.flags = "--devices nowhere"
        self.refused("nowhere")
        self.scene.eikon.flags = ""
        self.set_program(self.folder / "missing")
        self.refused("missing", "is not there")
        (self.folder / "text").write_text("no program")
        self.set_program(self.folder / "text")
        self.refused("cannot start")
        self.set_program("")
        with mock.patch.dict(os.environ, {"PATH": str(self.folder)}):
            self.refused("not in PATH")

    def test_of_what_is_cancelled_are_none_and_the_program_ends(self):
        self.room()
        self.scene.eikon.samples = 1 << 24
        started, looks = [], []
        from eikon_render import engine

        def start(*arguments):
            started.append(real(*arguments))
            return started[-1]

        def breaks(_):
            if started and started[0].progress >= 0 and started[0].status == "rendering":
                looks.append(1)
            return len(looks) > 5

        real = engine.Eikon
        with mock.patch.object(engine, "Eikon", start), mock.patch.object(engine.EikonEngine, "is_cancelled", breaks):
            picture = self.render()
        self.assertIn(started[0].process.returncode, (130, 143))
        self.assertGreater(picture[..., :3].mean(), 0)


if __name__ == "__main__":
    PROGRAM = pathlib.Path(sys.argv.pop(1)).resolve()
    result = unittest.main(verbosity=2, warnings="ignore", exit=False).result
    sys.stdout.flush()
    sys.stderr.flush()
    shutil.rmtree(SCRATCH, ignore_errors=True)
    os._exit(0 if result.wasSuccessful() else 1)  # bpy 4.2 crashes when Python ends, after any render by an engine in Python
