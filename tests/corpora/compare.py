"""Comparison of what tyndall reads with what other readers do."""
import array
import json
import math
import os
import re
import shutil
import subprocess
import tempfile

import meshes


class Unchecked(Exception):
    """The other reader is missing or cannot read the file."""


class Tools:
    def __init__(self, tyndall, timeout):
        self.tyndall = tyndall
        self.timeout = timeout

    def run(self, command, binary=False):
        """Exit status (None: past the time limit; negative: a signal), standard output and error."""
        try:
            done = subprocess.run(command, capture_output=True, timeout=self.timeout, stdin=subprocess.DEVNULL, check=False)
        except subprocess.TimeoutExpired:
            return None, "", ""
        output = done.stdout if binary else done.stdout.decode("utf-8", "replace")
        return done.returncode, output, done.stderr.decode("utf-8", "replace")

    def other(self, command, binary=False):
        """Standard output of another reader."""
        if shutil.which(command[0]) is None:
            raise Unchecked(f"{command[0]} is not installed")
        status, output, errors = self.run(command, binary)
        if status != 0:
            raise Unchecked(f"{command[0]}: {errors.strip()[:200]}")
        return output


def close(a, b, tolerance):
    if math.isnan(a) or math.isnan(b):
        return math.isnan(a) and math.isnan(b)
    return a == b or abs(a - b) <= tolerance


# ---- meshes ----

def mesh(_, path, output):
    found = json.loads(output)
    try:
        triangles, lower, upper, loose = meshes.read(path)
    except (meshes.Unread, KeyError, IndexError, ValueError, TypeError, AttributeError) as reason:
        raise Unchecked(f"meshes.py: {reason!r}") from None
    if found["triangles"] != triangles:
        return f"{found['triangles']} triangles instead of {triangles}"
    if triangles == 0:
        return None if "bounds" not in found else "bounds of nothing"
    size = max(max(map(abs, lower)), max(map(abs, upper)), 1e-30)
    own_lower, own_upper = found["bounds"]
    if loose and all(a - b < 2e-5 * size for a, b in zip(lower + own_upper, own_lower + upper)):
        return None
    for own, other in zip(found["bounds"], (lower, upper)):
        if any(not close(a, b, 2e-5 * size) for a, b in zip(own, other)):
            return f"bounds {found['bounds']} instead of {[lower, upper]}"
    return None


# ---- images ----

def numbers(line):
    return [float(word) for word in re.findall(r"-?(?:nan|inf|\d[\d.]*(?:e[-+]?\d+)?)", re.sub(r"\(.*\)", "", line))]


def layers(text):
    """Sub-images as iinfo prints them: width, height, name, channels, statistics."""
    found = []
    for line in text.splitlines():
        size = re.match(r"\s*(?:subimage +\d+: +|\S.* : +)(\d+) x +(\d+)", line)
        name, value = (line.strip().split(": ", 1) + [""])[:2]
        if size:
            if found and not found[-1].get("channels"):
                found.pop()  # the line of the whole file, before the one of its first sub-image
            found.append({"width": int(size[1]), "height": int(size[2]), "name": "", "uint": ", uint " in line})
        elif not found:
            continue
        elif name == "channel list":
            found[-1]["channels"] = [re.sub(r" \((half|float)\)", "", word) for word in value.split(", ")]
        elif name == "name":
            found[-1]["name"] = value.strip('"')
        elif line.strip().startswith("Stats "):
            found[-1][line.split()[1].rstrip(":")] = numbers(line.split(":", 1)[1])
    return found


def statistics(tools, path, found):
    """Compares each channel's smallest and largest value and its sum."""
    own = {channel["name"]: channel for channel in found["channels"]}
    area = found["width"] * found["height"]
    parts = layers(tools.other(["iinfo", "-v", "-a", "--stats", path]))
    if not parts or any("Min" not in part for part in parts):
        raise Unchecked("iinfo: no statistics")
    for number, part in enumerate(parts):  # a part's name stands before its channels, but for the first
        same = part["width"] * part["height"] == area
        for at, name in enumerate(part["channels"]):
            if "(uint)" in name or part["uint"]:
                raise Unchecked("iinfo: whole numbers as fractions")
            channel = own.get(name if number == 0 else f"{part['name']}.{name}")
            if channel is None:
                return f"no channel {name} of part {part['name']}"
            bad = part["NanCount"][at] + part["InfCount"][at]
            if channel["nan"] + channel["inf"] != bad:
                return f"channel {name}: {channel['nan'] + channel['inf']} values that are not finite instead of {bad:.0f}"
            if bad > 0 or not all(map(math.isfinite, (part["Min"][at], part["Max"][at], part["Avg"][at]))):
                continue
            reach = max(abs(part["Min"][at]), abs(part["Max"][at]))
            mean = part["Avg"][at] * part["width"] * part["height"] / area
            if not close(channel["mean"], mean, 1e-4 * reach + 2e-6):
                return f"channel {name}: mean {channel['mean']} instead of {mean}"
            for key, other in ("min", part["Min"][at]), ("max", part["Max"][at]):
                if same and not close(channel[key], other, 1e-4 * reach + 2e-6):
                    return f"channel {name}: {key} {channel[key]} instead of {other}"
    return None


def image(tools, path, output):
    found = json.loads(output)
    kind = os.path.splitext(path)[1].lower()
    if kind == ".exr":
        fault = statistics(tools, path, found)
        if fault or any(channel["nan"] + channel["inf"] for channel in found["channels"]):
            return fault
        if len(layers(tools.other(["iinfo", "-v", "-a", path]))) > 1:
            return None
    with tempfile.TemporaryDirectory() as folder:
        own, other = os.path.join(folder, "own.exr"), os.path.join(folder, "other.exr")
        status, _, errors = tools.run([tools.tyndall, "convert", path, own, "--quiet"])
        if status != 0:
            return f"convert: status {status}: {errors.strip()[:200]}"
        reach = 1
        if kind in (".exr", ".hdr"):
            other = path
            if kind == ".hdr":  # oiiotool cannot read the old run lengths
                other = os.path.join(folder, "other.exr")
                tools.other(["oiiotool", path, "-d", "float", "--compression", "zip", "-o", other])
            reach = max(max(abs(channel["min"]), abs(channel["max"])) for channel in found["channels"])
        else:
            names = [channel["name"] for channel in found["channels"]]
            planes = len(layers(tools.other(["iinfo", "-v", path]))[0]["channels"])
            if planes == 4 and len(names) == 3:
                raise Unchecked("oiiotool: CMYK by another formula")
            # As three equal channels, since oiiotool takes the alpha of two channels for a colour.
            gray, colors = ("0,0,0", "R,G,B") if len(names) in (1, 3) else ("0,0,0,1", "R,G,B,A")
            pick = gray if planes < 3 else "0,1,2" if planes == 3 else "0,1,2,3"
            if len(names) < 3:
                tools.other(["oiiotool", own, "--ch", gray, "--chnames", colors, "--compression", "zip", "-o", own])
            if kind == ".webp":  # of which oiiotool multiplies colours by alpha whatever it is told
                tools.other(["dwebp", "-quiet", path, "-o", os.path.join(folder, "other.png")])
                path = os.path.join(folder, "other.png")
            tools.other(["oiiotool", "--iconfig", "oiio:UnassociatedAlpha", "1", path, "-d", "float", "--ch", pick, "--chnames",
                         colors, "--colorconvert:unpremult=0", "sRGB", "linear", "--compression", "zip", "-o", other])
        # Half the precision of 8 bits, of which some files' sRGB curves are rounded by other readers; of large values what
        # oiiotool rounds in its own arithmetic.
        status, text, errors = tools.run(["oiiotool", own, "--origin", "+0+0", "--fullpixels", other, "--origin", "+0+0",
                                         "--fullpixels", "--fail", str(max(2e-4, 1e-6 * reach)), "--hardfail",
                                         str(max(2e-3, 1e-5 * reach)), "--diff"])
        return None if status == 0 else " ".join((text + errors).split())[:300]


# ---- volumes ----

def floats(data):
    """Values of a raw float NRRD without its header."""
    values = array.array("f")
    values.frombytes(data[data.index(b"\n\n") + 2:])
    return values


def nrrd(tools, path, output):
    found = json.loads(output)
    unu = "unu" if shutil.which("unu") else "teem-unu"
    with tempfile.TemporaryDirectory() as folder:
        whole, part, own = (os.path.join(folder, name) for name in ("whole.nrrd", "part.nrrd", "own.nrrd"))
        tools.other([unu, "convert", "-t", "float", "-i", path, "-o", whole])
        header = tools.other([unu, "head", whole])
        sizes = [int(word) for word in re.search(r"^sizes: (.*)", header, re.M)[1].split()]
        axes = [axis for axis in range(len(sizes)) if sizes[axis] == found["components"]
                and sizes[:axis] + sizes[axis + 1:] == found["size"][:len(sizes) - 1]]
        last = found["components"] - 1
        status, _, errors = tools.run([tools.tyndall, "convert", path, own, "--codec", "none", "--component", str(last)])
        if status != 0:
            return f"convert: status {status}: {errors.strip()[:200]}"
        with open(own, "rb") as file:
            values = floats(file.read())
        candidates = [[]] if sizes == found["size"][:len(sizes)] and last == 0 else []
        candidates += [["slice", "-a", str(axis), "-p", str(last), "-i", whole] for axis in axes]
        for candidate in candidates:
            if candidate:
                tools.other([unu] + candidate + ["-o", part])
            raw = tools.other([unu, "save", "-f", "nrrd", "-e", "raw", "-en", "little", "-i", part if candidate else whole,
                               "-o", "-"], binary=True)
            others = floats(raw)
            if len(others) == len(values) and all(close(a, b, 1e-6 * abs(b)) for a, b in zip(values, others)):
                return None
        return f"values differ from those of {unu}, sizes {sizes}"


def volume(tools, path, output):
    found = {grid["name"]: grid for grid in json.loads(output)["grids"]}
    if path.endswith(".nvdb"):
        raise Unchecked("no other reader of NanoVDB files")
    for line in tools.other(["vdb_print", path]).splitlines():
        words = line.split()
        if len(words) < 3:
            continue
        grid = found.get(words[0], found.get("") if words[0].startswith("<") else None)
        count = re.search(r"(\d+)x(\d+)x(\d+)\s+([\d.]+)([KMG]?)Vox", line)
        if grid is None or count is None:
            raise Unchecked(f"vdb_print: {line.strip()}")
        size = [b - a + 1 for a, b in zip(grid["lower"], grid["upper"])]
        if size != [int(count[axis]) for axis in (1, 2, 3)]:
            return f"grid {words[0]}: {size} voxels instead of {count[0]}"
        scale = {"": 1, "K": 1e3, "M": 1e6, "G": 1e9}[count[5]]
        stated = float(count[4]) * scale
        if not close(grid["active_voxels"], stated, 0.06 * scale + 0.01 * stated):
            return f"grid {words[0]}: {grid['active_voxels']} active voxels instead of {count[0]}"
    return None
