"""The Blender add-on inside a headless Blender: exports, F12, animation, Esc, a missing program, odd names, installation from the
zip; with --full eight scenes rendered by Tyndall and by Cycles in the same run (tests/blender/scenes.py).
usage: test_blender.py SOURCE TYNDALL [--full]
Without Blender the test is skipped (77)."""
import json, os, shutil, subprocess, sys, tempfile

# Means of the scenes differ by 0.6 % at most, but for that of surfaces, where Cycles adds the reflection of its Principled BSDF
# to the diffuse part, 1.1 % (docs/materials.md); blocks of 6 x 6 pixels by 0.9 %, there by 2.3 %.
MEAN, BLOCKS = 0.02, 0.03


def run_blender(blender, script, arguments, folder, **environment):
    """What a script prints as JSON after "RESULT " inside Blender."""
    command = [blender, "-b", "--factory-startup", "--python-exit-code", "9", "--python", script, "--", *arguments]
    # Debian's Blender takes the packages of the first python3 in PATH, of which the system's has NumPy.
    path = os.pathsep.join(["/usr/bin", "/bin", os.environ.get("PATH", "")])
    own = {**os.environ, "PATH": path, "BLENDER_USER_RESOURCES": os.path.join(folder, "user"), "TMPDIR": folder, **environment}
    done = subprocess.run(command, cwd=folder, env=own, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    text = done.stdout.decode(errors="replace")
    lines = [line for line in text.splitlines() if line.startswith("RESULT ")]
    if "No module named 'numpy'" in text:
        print("skipped: Blender's Python has no NumPy (scripts/setup.sh blender)")
        sys.exit(77)
    if done.returncode != 0 or not lines:
        sys.exit(f"Blender ended with {done.returncode}:\n" + "\n".join(text.splitlines()[-40:]))
    return json.loads(lines[-1][len("RESULT "):])


def check_scene(row):
    worst = max(abs(r - 1) for r in row["ratio"])
    allowed = row["noise"] + BLOCKS
    print(f"{row['scene']}: means within {100 * worst:.2f} %, blocks {100 * row['blocks']:.2f} % "
          f"(noise {100 * row['noise']:.2f} %)")
    if not (worst <= MEAN and row["blocks"] <= allowed):
        sys.exit(f"{row['scene']}: Tyndall and Cycles differ: {row}")


def main():
    source, tyndall = map(os.path.abspath, sys.argv[1:3])
    blender = shutil.which("blender")
    if blender is None:
        print("skipped: there is no blender in PATH")
        return 77
    scripts = os.path.join(source, "tests", "blender")
    with tempfile.TemporaryDirectory() as folder:
        archive = os.path.join(folder, "tyndall_blender.zip")
        subprocess.run(["bash", os.path.join(source, "scripts", "blender_addon.sh"), archive], check=True, stdout=subprocess.DEVNULL)
        arguments = [os.path.join(source, "addons", "blender"), tyndall, folder]
        result = run_blender(blender, os.path.join(scripts, "addon.py"), [archive, tyndall, folder], folder)
        print("\n".join(f"ok {name}" for name in result))
        if "--full" in sys.argv:
            for row in run_blender(blender, os.path.join(scripts, "compare.py"), [*arguments, "256"], folder):
                check_scene(row)
            return 0
        for row in run_blender(blender, os.path.join(scripts, "compare.py"), [*arguments, "16", "lamps", "fog", "cloud"], folder):
            check_scene(row)
    return 0


sys.exit(main())
