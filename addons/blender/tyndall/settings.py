"""What the panel sets: properties of a scene, and the preferences of the add-on."""
import bpy

METHODS = [("auto", "Auto", "The method that suits the scene, by expected error and time"),
           ("path", "Path", "The reference: path tracing, with noise"),
           ("dom", "Discrete ordinates", "Any medium, without noise"),
           ("fld", "Flux-limited diffusion", "Multiple scattering, without noise"),
           ("pop", "Principal ordinates", "Forward-scattering media, without noise"),
           ("lpv", "Light propagation volumes", "Surfaces in fog, where everything moves"),
           ("octaves", "Octaves", "The baseline of game engines")]


class TyndallSettings(bpy.types.PropertyGroup):
    method: bpy.props.EnumProperty(name="Method", items=METHODS, default="auto")
    samples: bpy.props.IntProperty(
        name="Samples", description="Paths per pixel, of method path and of the surfaces of others", default=64, min=1, max=16777216)
    error: bpy.props.FloatProperty(
        name="Error", description="Stop at this relative error of the pixels, percent (path alone); 0: at the samples",
        default=0, min=0, max=100, subtype="PERCENTAGE")
    seconds: bpy.props.FloatProperty(
        name="Time", description="Stop after so many seconds (path alone); 0: at the samples", default=0, min=0)
    seed: bpy.props.IntProperty(name="Seed", default=0, min=0)
    animate_seed: bpy.props.BoolProperty(name="New noise in each frame", default=True)
    threads: bpy.props.IntProperty(name="Threads", description="0: one per processor", default=0, min=0)
    denoise: bpy.props.BoolProperty(name="Denoise", description="Show the denoised light of method path", default=False)
    components: bpy.props.BoolProperty(name="Scattering", description="Passes of single and multiple scattering", default=False)
    transmittance: bpy.props.BoolProperty(name="Transmittance", default=False)
    albedo: bpy.props.BoolProperty(name="Albedo", default=False)
    variance: bpy.props.BoolProperty(name="Variance", description="Variance of the pixels (path)", default=False)
    folder: bpy.props.StringProperty(
        name="Folder", description="Where the scene file and its meshes are kept; empty: a temporary folder", subtype="DIR_PATH")
    soft_lamps: bpy.props.BoolProperty(
        name="Soft Lamps", description="Point lights and spots with their radius: soft shadows, and balls that the camera sees; "
        "otherwise points", default=True)
    motion_steps: bpy.props.IntProperty(
        name="Motion Steps", description="Instants of the shutter's time at which objects that move are rendered, where motion blur "
        "is on; 1: sharp", default=8, min=1, max=256)
    distant_light: bpy.props.BoolProperty(
        name="Sun in World Volume", description="Let light of the sun and the world into the world's volume through the sides of "
        "a box, which in Cycles does not arrive", default=False)
    expected: bpy.props.StringProperty(name="Expected", description="Expected error and time of method auto")
    compared: bpy.props.StringProperty(name="Compared", description="The last comparison with path")


class TyndallPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__
    program: bpy.props.StringProperty(
        name="Program", description="The path of tyndall; empty: by the environment variable TYNDALL, or PATH", subtype="FILE_PATH")

    def draw(self, context):
        from . import process
        self.layout.prop(self, "program")
        found = process.find_program(self.program)
        self.layout.label(text=found if found else process.MISSING, icon="CHECKMARK" if found else "ERROR")


def program_of(context):
    """The program by the preferences of the add-on, where it is enabled, or by the environment."""
    addon = context.preferences.addons.get(__package__)
    return addon.preferences.program if addon is not None and addon.preferences is not None else ""


CLASSES = (TyndallSettings, TyndallPreferences)


def register():
    for c in CLASSES:
        bpy.utils.register_class(c)
    bpy.types.Scene.tyndall = bpy.props.PointerProperty(type=TyndallSettings)


def unregister():
    del bpy.types.Scene.tyndall
    for c in reversed(CLASSES):
        bpy.utils.unregister_class(c)
