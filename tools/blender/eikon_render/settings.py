# SPDX-License-Identifier: Apache-2.0
"""Declares what the user sets: where the program is, and how it renders."""
import bpy

ENGINE = "EIKON"


class EikonPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    program: bpy.props.StringProperty(
        name="Program", subtype="FILE_PATH", default="",
        description="The file of the program eikon; empty: it is looked for in PATH")

    def draw(self, context):
        self.layout.prop(self, "program")


class EikonSettings(bpy.types.PropertyGroup):
    samples: bpy.props.IntProperty(name="Samples", default=64, min=1, max=1 << 24, description="Samples per pixel")
    seconds: bpy.props.FloatProperty(
        name="Time Limit", default=0.0, min=0.0, max=1e6, subtype="TIME_ABSOLUTE", unit="TIME_ABSOLUTE",
        description="Seconds after which a render ends with what it has; 0: none")
    seed: bpy.props.IntProperty(name="Seed", default=0, min=0, description="Images of different seeds are independent")
    denoise: bpy.props.BoolProperty(
        name="Denoise", default=False, description="Denoise the finished picture by Open Image Denoise 2, where it is installed")
    use_pass_albedo: bpy.props.BoolProperty(
        name="Albedo", default=False, description="Deliver the reflectance of what is seen, as pass Albedo")
    lamps: bpy.props.BoolProperty(
        name="Lamps of Their Size", default=True,
        description="Point lights are spheres of their radius, and so the camera sees them; else they are points")
    flags: bpy.props.StringProperty(
        name="More Flags", default="", description="Further flags of `eikon render`, such as --max-depth 8 --guiding on")


class EikonPanel:
    """The base of panels that are there while eikon is the render engine."""
    COMPAT_ENGINES = {ENGINE}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES


class EIKON_PT_sampling(EikonPanel, bpy.types.Panel):
    bl_label = "Sampling"
    bl_space_type, bl_region_type, bl_context = "PROPERTIES", "WINDOW", "render"

    def draw(self, context):
        layout, settings = self.layout, context.scene.eikon
        layout.use_property_split = True
        for name in ("samples", "seconds", "seed", "denoise", "lamps"):
            layout.prop(settings, name)
        layout.prop(context.scene.render, "film_transparent", text="Transparent Sky")
        layout.prop(settings, "flags")


class EIKON_PT_passes(EikonPanel, bpy.types.Panel):
    bl_label = "Passes"
    bl_space_type, bl_region_type, bl_context = "PROPERTIES", "WINDOW", "view_layer"

    def draw(self, context):
        self.layout.use_property_split = True
        for name in ("use_pass_z", "use_pass_normal", "use_pass_position", "use_pass_emit"):
            self.layout.prop(context.view_layer, name)
        self.layout.prop(context.scene.eikon, "use_pass_albedo")


CLASSES = (EikonPreferences, EikonSettings, EIKON_PT_sampling, EIKON_PT_passes)


def panels():
    """Blender's own panels that say something to this engine: those of any engine, but what it does not read."""
    leave_out = {"VIEWLAYER_PT_filter", "VIEWLAYER_PT_layer_passes", "RENDER_PT_simplify", "RENDER_PT_freestyle"}
    # EEVEE's, for nodes of materials and the world, and for lights.
    take = {"EEVEE_MATERIAL_PT_context_material", "EEVEE_MATERIAL_PT_surface", "EEVEE_WORLD_PT_surface", "DATA_PT_EEVEE_light"}
    for panel in bpy.types.Panel.__subclasses__():
        any_engine = "BLENDER_RENDER" in getattr(panel, "COMPAT_ENGINES", ())
        if (any_engine and panel.__name__ not in leave_out) or panel.__name__ in take:
            yield panel


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.eikon = bpy.props.PointerProperty(type=EikonSettings)
    for panel in panels():
        panel.COMPAT_ENGINES.add(ENGINE)


def unregister():
    for panel in bpy.types.Panel.__subclasses__():
        getattr(panel, "COMPAT_ENGINES", set()).discard(ENGINE)
    del bpy.types.Scene.eikon
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)
