"""Takes the screenshots of docs/blender.md: Blender's window with the add-on, its viewport and its panels. Needs `blender`,
`Xvfb`, a software OpenGL (scripts/setup.sh blender) and `cwebp` (webp).
usage: scripts/blender_pictures.py TYNDALL OUT_FOLDER"""
import os, shutil, subprocess, sys, tempfile, time

HERE = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
WINDOW = """
import sys
sys.path[:0] = [{source!r} + "/addons/blender", {source!r} + "/tests/blender"]
import bpy
import scenes, tyndall
tyndall.register()
scenes.smoke({folder!r}, {tyndall!r})
scene = bpy.context.scene
scene.render.engine, scene.tyndall.method, scene.tyndall.samples = "TYNDALL", "path", 256
scene.render.resolution_x, scene.render.resolution_y = 640, 480
bpy.context.preferences.view.show_splash = False
step = 0


def go():
    global step
    step += 1
    window = bpy.context.window_manager.windows[0]
    for area in window.screen.areas:
        if area.type == "VIEW_3D" and step == 2:
            area.spaces[0].region_3d.view_perspective = "CAMERA"
            area.spaces[0].overlay.show_overlays = False
            area.spaces[0].shading.type = "RENDERED"
        if area.type == "PROPERTIES" and step == 2:
            area.spaces[0].context = "RENDER"
    if step == 4:
        bpy.ops.tyndall.predict()
    if step == 25:
        with bpy.context.temp_override(window=window, area=window.screen.areas[0]):
            bpy.ops.screen.screenshot(filepath={folder!r} + "/viewport.png")
        bpy.ops.wm.quit_blender()
        return None
    return 1.0


bpy.app.timers.register(go, first_interval=2)
"""


def main():
    tyndall, out = map(os.path.abspath, sys.argv[1:3])
    for program in ("blender", "Xvfb", "cwebp"):
        if shutil.which(program) is None:
            print(f"skipped: there is no {program}")
            return 77
    with tempfile.TemporaryDirectory() as folder:
        script = os.path.join(folder, "window.py")
        with open(script, "w") as file:
            file.write(WINDOW.format(source=HERE, folder=folder, tyndall=tyndall))
        screen = subprocess.Popen(["Xvfb", ":93", "-screen", "0", "1100x700x24", "+extension", "GLX"], stderr=subprocess.DEVNULL)
        try:
            time.sleep(2)
            subprocess.run(["blender", "--factory-startup", "-noaudio", "-p", "0", "0", "1100", "700", "--python", script], check=True,
                           stdout=subprocess.DEVNULL, timeout=280,
                           env={**os.environ, "PATH": "/usr/bin:" + os.environ["PATH"], "DISPLAY": ":93", "LIBGL_ALWAYS_SOFTWARE": "1", "TYNDALL": tyndall})
        finally:
            screen.terminate()
            screen.wait()
        subprocess.run(["cwebp", "-quiet", "-q", "80", os.path.join(folder, "viewport.png"), "-o",
                        os.path.join(out, "blender.webp")], check=True)
    return 0


sys.exit(main())
