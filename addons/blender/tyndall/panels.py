"""The panels of the engine in the properties of render and view layer."""
import bpy

# Panels of Blender that serve any engine: dimensions, frame range, stereo, metadata, output, colour management, and the data of
# lights, worlds, cameras and volumes.
OTHERS = {"RENDER_PT_color_management", "RENDER_PT_color_management_curves", "EEVEE_MATERIAL_PT_context_material",
          "EEVEE_MATERIAL_PT_surface", "EEVEE_MATERIAL_PT_volume", "EEVEE_WORLD_PT_surface", "EEVEE_WORLD_PT_volume",
          "VIEWLAYER_PT_layer"}


class _Panel:
    bl_space_type, bl_region_type = "PROPERTIES", "WINDOW"
    COMPAT_ENGINES = {"TYNDALL"}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES


class TYNDALL_PT_render(_Panel, bpy.types.Panel):
    bl_label, bl_context = "Tyndall", "render"

    def draw(self, context):
        layout, settings = self.layout, context.scene.tyndall
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(settings, "method")
        layout.prop(settings, "samples")
        column = layout.column(align=True)
        column.active = settings.method == "path"
        column.prop(settings, "error")
        column.prop(settings, "seconds")
        column.prop(settings, "denoise")
        layout.prop(settings, "seed")
        layout.prop(settings, "animate_seed")
        layout.prop(settings, "threads")
        layout.prop(settings, "soft_lamps")
        layout.prop(settings, "motion_steps")
        layout.prop(settings, "distant_light")
        layout.prop(settings, "folder")


class TYNDALL_PT_expected(_Panel, bpy.types.Panel):
    bl_label, bl_context = "Error and Time", "render"

    def draw(self, context):
        layout, settings = self.layout, context.scene.tyndall
        layout.operator("tyndall.predict")
        self._lines(settings.expected)
        layout.operator("tyndall.compare")
        self._lines(settings.compared)

    def _lines(self, text):
        line = ""
        column = self.layout.column(align=True)
        for word in text.split():
            if len(line) + len(word) > 52:
                column.label(text=line)
                line = ""
            line += word + " "
        if line:
            column.label(text=line)


class TYNDALL_PT_passes(_Panel, bpy.types.Panel):
    bl_label, bl_context = "Passes", "view_layer"

    def draw(self, context):
        layout, settings = self.layout, context.scene.tyndall
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(context.view_layer, "use_pass_z", text="Depth")
        layout.prop(context.view_layer, "use_pass_normal", text="Normal")
        for name in ("components", "transmittance", "albedo", "variance"):
            layout.prop(settings, name)


CLASSES = (TYNDALL_PT_render, TYNDALL_PT_expected, TYNDALL_PT_passes)


def _shared():
    """Panels that Blender's own engines without panels of their own have."""
    for panel in bpy.types.Panel.__subclasses__():
        engines = getattr(panel, "COMPAT_ENGINES", None)
        if engines is None or panel in CLASSES:
            continue
        name = getattr(panel, "bl_idname", panel.__name__) or panel.__name__
        if "BLENDER_RENDER" in engines or panel.__name__ in OTHERS or name in OTHERS:
            yield panel


def register():
    for c in CLASSES:
        bpy.utils.register_class(c)
    for panel in _shared():
        panel.COMPAT_ENGINES.add("TYNDALL")


def unregister():
    for panel in _shared():
        panel.COMPAT_ENGINES.discard("TYNDALL")
    for c in reversed(CLASSES):
        bpy.utils.unregister_class(c)
