"""The add-on as a user has it: installed from its zip, F12, animation, Esc, a missing program, odd names. Runs inside Blender:
blender -b --factory-startup --python addon.py -- ZIP TYNDALL FOLDER"""
import json
import os
import sys
import threading
import time

archive, tyndall, folder = sys.argv[sys.argv.index("--") + 1:]
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

import bpy
import numpy as np
import scenes

os.environ["TYNDALL"] = tyndall
done = []


def test(function):
    """Runs a test in a small scene of fog, and notes its name."""
    scenes.fog(folder, tyndall)
    scene = bpy.context.scene
    scene.render.engine = "TYNDALL"
    scene.render.resolution_x, scene.render.resolution_y = 24, 18
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    scene.tyndall.method, scene.tyndall.samples = "path", 8
    function(scene)
    done.append(function.__name__)


def render_to(name, **how):
    scene = bpy.context.scene
    scene.render.filepath = os.path.join(folder, name)
    bpy.ops.render.render(write_still=not how, **how)


def pixels_of(name):
    image = bpy.data.images.load(os.path.join(folder, name))
    out = np.array(image.pixels[:]).reshape(image.size[1], image.size[0], -1)
    bpy.data.images.remove(image)
    return out


def is_installed_from_its_zip():
    install = {"filepath": archive}
    bpy.ops.preferences.addon_install(**install)
    bpy.ops.preferences.addon_enable(module="tyndall")
    assert "tyndall" in bpy.context.preferences.addons
    done.append("is_installed_from_its_zip")


def renders_an_image(scene):
    scene.view_layers[0].use_pass_z = scene.view_layers[0].use_pass_normal = True
    scene.tyndall.components = True
    render_to("image.exr")
    image = pixels_of("image.exr")
    assert image.shape[:2] == (18, 24) and np.isfinite(image).all() and 0.05 < image[..., :3].mean() < 5
    # The sky is above and the floor below: rows are not upside down.
    assert image[-1, :, 2].mean() > 1.2 * image[-1, :, 0].mean()
    assert any(t.name == "Tyndall report" for t in bpy.data.texts)


def depth_is_planar(scene):
    from tyndall import passes
    camera = {"resolution": [40, 20], "fov_y": 60.0, "shift": [0.25, 0.0]}
    tangent = 2 * np.tan(np.radians(30)) / 20
    x = (np.arange(40) + 0.5 - 20 + 5) * tangent
    y = (np.arange(20) + 0.5 - 10) * tangent
    distance = 3 * np.sqrt(1 + x[None, :] ** 2 + y[:, None] ** 2)
    assert abs(passes.planar(distance, camera, None) - 3).max() < 1e-5
    assert abs(passes.planar(distance[4:9, 10:30], camera, (10, 4, 20, 5)) - 3).max() < 1e-5


def renders_a_region(scene):
    scene.render.use_border = scene.render.use_crop_to_border = True
    scene.render.border_min_x, scene.render.border_max_x = 0.25, 0.75
    scene.render.border_min_y, scene.render.border_max_y = 0.5, 1.0
    render_to("region.exr")
    scene.render.use_border = False
    render_to("whole.exr")
    region, whole = pixels_of("region.exr"), pixels_of("whole.exr")
    assert region.shape[:2] == (9, 12)
    assert np.array_equal(region[..., :3], whole[9:18, 6:18, :3])


def renders_an_animation(scene):
    scene.frame_end = 2
    scene.tyndall.samples = 2
    scene.camera.keyframe_insert("location", frame=1)
    scene.camera.location.x += 1
    scene.camera.keyframe_insert("location", frame=2)
    scene.render.use_motion_blur = True
    render_to("frame_####", animation=True)
    first, second = pixels_of("frame_0001.exr"), pixels_of("frame_0002.exr")
    assert not np.array_equal(first, second)


def moves_the_camera_while_the_shutter_is_open(scene):
    from tyndall import operators
    scene.camera.keyframe_insert("location", frame=1)
    scene.camera.location.x += 1
    scene.camera.keyframe_insert("location", frame=2)
    for curve in scene.camera.animation_data.action.fcurves:
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
    scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 0.5
    scene.frame_set(1)
    path, _ = operators.export_to(bpy.context, os.path.join(folder, "motion"))
    with open(path, encoding="utf-8") as file:
        camera = json.load(file)["camera"]
    moved = np.array(camera["motion"]["position"]) - camera["position"]
    assert abs(moved[0] - 0.25) < 1e-3, moved  # half of the shutter's time lies before the first key


def blurs_objects_that_move(scene):
    scenes.moving(folder, tyndall)
    scene = bpy.context.scene
    scene.render.engine, scene.tyndall.method, scene.tyndall.samples = "TYNDALL", "path", 4
    scene.render.image_settings.file_format, scene.render.image_settings.color_depth = "OPEN_EXR", "32"
    places = []
    for steps in (1, 4):
        scene.tyndall.motion_steps, scene.tyndall.folder = steps, os.path.join(folder, f"steps_{steps}")
        render_to(f"moving_{steps}.exr")
        with open(os.path.join(scene.tyndall.folder, "scene.json"), encoding="utf-8") as file:
            document = json.load(file)
        places.append(document["lights"][0]["position"][0])
        assert document["render"]["spp"] == 4 // steps, document["render"]
        assert scene.frame_current == 1 and scene.frame_subframe == 0
    # The lamp moves from 0 to 0.5 in two frames, and the last of four steps is at 3/8 of one frame after the middle.
    assert abs(places[0] - 0.25) < 1e-4 and abs(places[1] - 0.25 - 0.25 * 3 / 8) < 1e-4, places
    sharp, blurred = pixels_of("moving_1.exr"), pixels_of("moving_4.exr")
    assert abs(sharp - blurred).max() > 0.05


def keeps_what_there_is_on_escape(scene):
    from tyndall import engine, process
    scene.tyndall.samples = 1 << 24
    began, follow, runs = time.monotonic(), engine.TyndallEngine._follow, []

    # Blender sets its flag of a break by events of a window; without one the test asks in its place.
    def escape(self, run, *rest):
        runs.append(run)
        while run.fraction == 0 and run.is_running() and time.monotonic() < began + 60:
            time.sleep(0.05)
        run.cancel()
        follow(self, run, *rest)

    engine.TyndallEngine._follow = escape
    try:
        render_to("escaped.exr")
    finally:
        engine.TyndallEngine._follow = follow
    assert [run.process.returncode for run in runs] == [130], runs
    image = pixels_of("escaped.exr")
    assert time.monotonic() < began + 90 and 0.05 < image[..., :3].mean() < 5


def tells_that_the_program_is_missing(scene):
    from tyndall import process
    os.environ["TYNDALL"] = os.path.join(folder, "nothing here")
    try:
        assert process.find_program() is None
        failed = ""
        try:
            render_to("missing.exr")
        except RuntimeError as error:
            failed = str(error)
        assert "tyndall" in failed and "PATH" in failed, failed
    finally:
        os.environ["TYNDALL"] = tyndall


def takes_odd_names(scene):
    from tyndall import operators
    odd = "a 'b' \"c\" \\ \u96f2 \u00fc"
    for target in scene.objects:
        target.name = odd
        if target.data:
            target.data.name = odd
    for material in bpy.data.materials:
        material.name = odd
    scene.name = scene.world.name = odd
    scene.tyndall.folder = os.path.join(folder, "out 'of' \u96f2")
    render_to("odd.exr")
    assert pixels_of("odd.exr")[..., :3].mean() > 0.05
    with open(os.path.join(scene.tyndall.folder, "scene.json"), encoding="utf-8") as file:
        assert json.load(file)["media"][0]["name"].startswith("a 'b' \"c\" \\ \u96f2")


def reports_what_it_cannot_say(scene):
    from tyndall import operators
    tree = bpy.data.materials["Fog"].node_tree
    noise = tree.nodes.new("ShaderNodeTexNoise")
    tree.links.new(noise.outputs[0], next(n for n in tree.nodes if n.type == "PRINCIPLED_VOLUME").inputs["Density"])
    scene.camera.data.type = "PANO"
    _, report = operators.export_to(bpy.context, os.path.join(folder, "reported"))
    text = report.text()
    assert "Noise Texture" in text and "pano" in text, text
    assert text.splitlines()[0] == "left out or approximated:", text
    assert all(line.startswith(("- left out: ", "- approximated: ")) for line in text.splitlines()[1:]), text
    with open(os.path.join(folder, "reported", "scene.json"), encoding="utf-8") as file:
        assert json.load(file)["comment"][1:] == report.lines()
    with open(os.path.join(folder, "reported", "report.txt"), encoding="utf-8") as file:
        assert file.read() == text


def starts_frames_from_the_light_of_the_one_before(scene):
    from tyndall import engine
    stats, show, lamp = [], engine.TyndallEngine._show, scene.objects["Lamp"]
    scene.frame_end, scene.tyndall.method, scene.tyndall.animate_seed = 3, "dom", False
    scene.tyndall.folder = os.path.join(folder, "warm")
    lamp.keyframe_insert("location", frame=1)
    lamp.location.x += 0.1
    lamp.keyframe_insert("location", frame=3)

    def keep(self, result, *rest):
        with open(os.path.join(scene.tyndall.folder, "stats.json"), encoding="utf-8") as file:
            stats.append({**json.load(file), "process": rest[-1].process.pid})
        show(self, result, *rest)

    engine.TyndallEngine._show = keep
    try:
        render_to("warm_####", animation=True)
        scene.frame_set(3)
        render_to("cold.exr")
    finally:
        engine.TyndallEngine._show = show
    sweeps = [sum(s["dom"]["sweeps"]) for s in stats]
    assert len({s["process"] for s in stats[:3]}) == 1 and stats[3]["process"] != stats[0]["process"], stats
    # Both are within dom's tolerance of the solution.
    warm, cold = pixels_of("warm_0003.exr")[..., :3], pixels_of("cold.exr")[..., :3]
    assert abs(warm - cold).max() < 2e-3 * cold.max(), (abs(warm - cold).max(), cold.max())
    print("warm starts:", sweeps, float(abs(warm - cold).max() / cold.max()))


def leaves_out_light_that_does_not_arrive(scene):
    from tyndall import operators
    scenes.air(folder, tyndall)
    kinds = {}
    for distant in (False, True):
        bpy.context.scene.tyndall.distant_light = distant
        path, report = operators.export_to(bpy.context, os.path.join(folder, "air"))
        with open(path, encoding="utf-8") as file:
            kinds[distant] = sorted(light["type"] for light in json.load(file)["lights"])
        assert any("medium without end" in line for line in report.lines()), report.lines()
    assert kinds == {False: ["point"], True: ["directional", "environment", "point"]}, kinds


def expects_an_error_and_a_time(scene):
    scene.tyndall.method = "auto"
    assert bpy.ops.tyndall.predict() == {"FINISHED"}
    assert "about" in scene.tyndall.expected and " s" in scene.tyndall.expected, scene.tyndall.expected


def is_compared_with_path(scene):
    scene.tyndall.method, scene.tyndall.folder = "dom", os.path.join(folder, "compared")
    assert bpy.ops.tyndall.compare(seconds=1) == {"FINISHED"}
    assert scene.tyndall.compared.startswith("dom: mean "), scene.tyndall.compared


def shows_a_scene_that_changes(scene):
    from tyndall import exporter, live
    there = os.path.join(folder, "live")
    path, _ = exporter.write_scene(bpy.context.evaluated_depsgraph_get(), there, settings={"spp": 4})
    for kind in (live.Viewer, live.Renders):
        arrived = threading.Event()
        try:
            shown = kind(tyndall, path, (24, 18), "path", arrived.set)
        except OSError:
            assert kind is live.Viewer  # the program is built without its viewer
            continue
        try:
            assert arrived.wait(60), kind
            arrived.clear()
            shown.set_camera({"position": [0, -9, 3], "target": [0, 0, 9], "up": [0, 0, 1], "fov_y": 40.0}, False)
            end = time.monotonic() + 60
            # The sky alone is in view: one radiance everywhere.
            while time.monotonic() < end and (shown.image.std((0, 1)).max() > 1e-3 or shown.image.shape[0] < 18):
                arrived.wait(1)
                arrived.clear()
            assert shown.image.std((0, 1)).max() <= 1e-3 and shown.image.shape == (18, 24, 3), kind
        finally:
            shown.close()


is_installed_from_its_zip()
for function in (renders_an_image, depth_is_planar, renders_a_region, renders_an_animation,
                 moves_the_camera_while_the_shutter_is_open, blurs_objects_that_move, keeps_what_there_is_on_escape,
                 tells_that_the_program_is_missing, takes_odd_names, reports_what_it_cannot_say,
                 leaves_out_light_that_does_not_arrive, expects_an_error_and_a_time,
                 is_compared_with_path, shows_a_scene_that_changes):
    test(function)
if "TYNDALL_IN_FULL" in os.environ:  # a minute of solves
    test(starts_frames_from_the_light_of_the_one_before)
print("RESULT " + json.dumps(done))
