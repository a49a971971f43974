#!/usr/bin/env python3
"""Makes calls of the C library fail one after another in runs of the command line tool, and checks what is left.

usage: sweep.py TYNDALL LIBRARY [--full] [--only TEXT] [--jobs N] [--threads N] [--keep]

TYNDALL: the program; LIBRARY: fail_calls.so. The current folder is used for scratch. For each command, and each group of
calls and error, the n-th call fails, for n from 1 on until all calls of a run were made to fail: all of them with --full,
else the first ones and then steps. Of each run it is checked that
- it ends in time, by itself and not by a signal, with the exit status 0, 1 or 2;
- with 1 or 2 it says why in one line on stderr, with 0 nothing but warnings;
- each file is as before, or the complete new one; with 0 all are new but for those that a warning names;
- no other file is left;
- interrupted calls (EINTR) and short writes make no difference.
Tables of fault x command, and of their sums, are printed, and every run that failed a check with the command that repeats it."""
import argparse
import collections
import concurrent.futures
import itertools
import json
import os
import pathlib
import re
import shlex
import shutil
import signal
import struct
import subprocess
import sys

THREADS_WANTED = 3  # that commands try to start where starting them fails, besides the first
TIME_LIMIT = 60  # seconds of a run; they take some hundredths
GROUPS = ["write", "fwrite", "fflush", "fclose", "fsync", "rename", "close", "open", "fopen", "read", "truncate", "mmap",
          "malloc", "thread"]  # as the library reports them
# Group, error, and whether all later calls fail, too.
FAULTS = [
    ("write", "ENOSPC", True), ("write", "ENOSPC", False), ("write", "EIO", False), ("write", "EINTR", False),
    ("write", "SHORT", True), ("fwrite", "ENOSPC", True), ("fflush", "EIO", False), ("fclose", "EIO", False),
    ("fsync", "EIO", False), ("fsync", "EINTR", False), ("rename", "EIO", False), ("rename", "ENOSPC", True),
    ("close", "EIO", False), ("close", "EINTR", False), ("open", "EMFILE", False), ("open", "EMFILE", True),
    ("open", "EINTR", False), ("open", "ENOSPC", False), ("fopen", "EMFILE", False),
    ("read", "EIO", False), ("truncate", "ENOSPC", False), ("mmap", "ENOMEM", False), ("mmap", "ENOMEM", True),
    ("malloc", "ENOMEM", False), ("malloc", "ENOMEM", True), ("thread", "EAGAIN", False), ("thread", "EAGAIN", True)]
HARMLESS = ("EINTR", "SHORT")
QUICK_FIRST = 12  # calls that fail one by one, before steps
QUICK_FIRST_FOREVER = 3
PROBLEMS = ["hang", "signal", "leftover", "damaged", "lines", "status", "retry"]

# excluded: groups of calls, or (group, error), whose failure libraries of the command do not survive.
Case = collections.namedtuple("Case", "name arguments inputs outputs program full excluded", defaults=[()])
Fault = collections.namedtuple("Fault", "group error forever")


def quad_mesh():
    """A glTF file of one quad with texture coordinates of its own, for lightmaps."""
    import base64
    corners = struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    positions = struct.pack("<12f", -1, 0, -1, -1, 0, 1, 1, 0, 1, 1, 0, -1)
    uv = struct.pack("<8f", 0.1, 0.1, 0.1, 0.9, 0.9, 0.9, 0.9, 0.1)
    blob = corners + positions + uv
    views, at = [], 0
    for part in (corners, positions, uv):
        views.append({"buffer": 0, "byteOffset": at, "byteLength": len(part)})
        at += len(part)
    return json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"name": "floor", "primitives": [{"attributes": {"POSITION": 1, "TEXCOORD_1": 2}, "indices": 0}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5123, "count": 6, "type": "SCALAR"},
            {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, 0, -1], "max": [1, 0, 1]},
            {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"}],
        "bufferViews": views,
        "buffers": [{"byteLength": len(blob),
                     "uri": "data:application/octet-stream;base64," + base64.b64encode(blob).decode()}]})


SCENE = {"tyndall": 1, "camera": {"position": [0, 1, 5], "target": [0, 0, 0]},
         "media": [{"bounds": [[-1, -1, -1], [1, 1, 1]], "sigma_s": 0.5, "sigma_a": 0.1}],
         "lights": [{"type": "directional", "direction": [-1, -2, -0.5], "irradiance": 1}],
         "geometry": [{"file": "floor.gltf"}]}


def cases(tyndall):
    """Commands: arguments, files that they find, files or folders that they write, the program."""
    small = ["--size", "8x8", "--spp", "1", "--seed", "1"]
    figure = str(pathlib.Path(tyndall).with_name("tyndall-figure"))
    raw = ["--raw-size", "8,8,8"]
    listed = [
        Case("render EXR", ["render", "scene.json", "-o", "out.exr"] + small, ["scene.json", "floor.gltf"], ["out.exr"],
             tyndall, False),
        Case("render PNG", ["render", "builtin:cube_g0", "-o", "out.png"] + small, [], ["out.png"], tyndall, False),
        Case("render both", ["render", "builtin:cube_g0", "-o", "out.exr", "--png", "out.png", "--stats", "out.json"]
             + small, [], ["out.exr", "out.png", "out.json"], tyndall, False),
        Case("render --resume", ["render", "builtin:cube_g0", "-o", "old.exr", "--resume", "--size", "8x8", "--spp", "4",
                                 "--seed", "1"], ["old.exr", "old.exr.state"], ["old.exr", "old.exr.state"], tyndall,
             False),
        Case("convert NRRD", ["convert", "in.raw", "out.nrrd"] + raw, ["in.raw"], ["out.nrrd"], tyndall, False),
        Case("convert NanoVDB", ["convert", "in.raw", "out.nvdb"] + raw, ["in.raw"], ["out.nvdb"], tyndall, False),
        Case("convert OpenVDB", ["convert", "in.raw", "out.vdb"] + raw, ["in.raw"], ["out.vdb"], tyndall, False),
        Case("convert from VDB", ["convert", "in.vdb", "out.nrrd"], ["in.vdb"], ["out.nrrd"], tyndall, False),
        Case("convert VTI", ["convert", "in.raw", "out.vti"] + raw, ["in.raw"], ["out.vti"], tyndall, False),
        Case("convert from VTI", ["convert", "in.vti", "out.nrrd"], ["in.vti"], ["out.nrrd"], tyndall, False),
        # c-blosc crashes if one of its allocations fails.
        Case("convert from blosc", ["convert", "blosc.vdb", "out.nrrd"], ["blosc.vdb"], ["out.nrrd"], tyndall, True,
             ("malloc",)),
        Case("convert image", ["convert", "a.exr", "out.png"], ["a.exr"], ["out.png"], tyndall, True),
        Case("bake", ["bake", "scene.json", "-o", "baked", "--method", "path", "--size", "8x8", "--spp", "1"],
             ["scene.json", "floor.gltf"], ["baked"], tyndall, False),
        Case("compare", ["compare", "a.exr", "b.exr", "-o", "pages"], ["a.exr", "b.exr"], ["pages"], tyndall, False),
        Case("compare scene", ["compare", "builtin:cube_g0", "--methods", "path", "-o", "pages", "--size", "8x8", "--spp",
                               "1", "--reference-spp", "2"], [], ["pages"], tyndall, True),
        Case("diff", ["diff", "a.exr", "b.exr"], ["a.exr", "b.exr"], [], tyndall, False),
        Case("merge", ["merge", "a.exr", "b.exr", "-o", "out.exr"], ["a.exr", "b.exr"], ["out.exr"], tyndall, False),
        Case("screen", ["screen", "a.exr", "-o", "out.exr", "--medium", "fog:5"], ["a.exr"], ["out.exr"], tyndall, False),
        Case("help --man", ["help", "--man", "man"], ["man"], ["man"], tyndall, True),
    ]
    if os.path.exists(figure):
        # Fontconfig crashes, hangs or prints by itself without memory or its files.
        listed.append(Case("figure", ["fld-limiters", "-o", "figures", "--quick"], [], ["figures"], figure, False,
                           ("malloc", "mmap", "read", ("open", "EINTR"))))
    return listed


def checked_run(words, folder):
    subprocess.run(words, cwd=folder, check=True, stdout=subprocess.DEVNULL)


def make_inputs(tyndall, folder):
    folder.mkdir()
    (folder / "floor.gltf").write_text(quad_mesh())
    (folder / "scene.json").write_text(json.dumps(SCENE))
    (folder / "in.raw").write_bytes(bytes(i * 7 % 256 for i in range(512)))
    small = ["--size", "8x8", "--aov", "depth", "-q"]
    for name, seed in (("a.exr", "1"), ("b.exr", "2")):
        checked_run([tyndall, "render", "scene.json", "-o", name, "--spp", "1", "--seed", seed] + small, folder)
    checked_run([tyndall, "render", "builtin:cube_g0", "-o", "old.exr", "--resume", "--size", "8x8", "--spp", "2",
                 "--seed", "1", "-q"], folder)
    for name, codec in (("in.vdb", "zip"), ("blosc.vdb", "blosc"), ("in.vti", "zip")):
        checked_run([tyndall, "convert", "in.raw", name, "--raw-size", "8,8,8", "--codec", codec], folder)
    (folder / "man").mkdir()


def files_below(folder):
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def without_numbers(name, content):
    return re.sub(rb"-?[0-9][0-9.e+-]*", b"#", content) if re.search(r"\.(json|md|html|csv)$", name) else content


class Reference:
    """The files of runs without faults; bytes in which such runs differ (times, identifiers) do not count."""

    def __init__(self, runs, printed):
        self.printed = printed
        self.files = {}
        for name in runs[0]:
            contents = [without_numbers(name, run[name]) for run in runs]
            varying = set()
            for other in contents[1:]:
                for i, (a, b) in enumerate(zip(contents[0], other)):
                    if a != b:
                        varying.update(range(i - 8, i + 9))
            self.files[name] = (contents[0], varying, len({len(c) for c in contents}) == 1)

    def has(self, name, content):
        if name not in self.files:
            return False
        expected, varying, fixed = self.files[name]
        # A bake writes both anew after each of its parts, with what is done so far.
        if name.endswith("bake.state"):
            return content.startswith(b"tyndall bake state 1\n") and content.endswith(b"\n")
        if name.endswith("bake.json"):
            try:
                return "files" in json.loads(content)
            except ValueError:
                return False
        content = without_numbers(name, content)
        if not fixed:  # compressed times
            return abs(len(content) - len(expected)) <= 64
        return len(content) == len(expected) and all(
            a == b or i in varying for i, (a, b) in enumerate(zip(content, expected)))


class Sweep:
    def __init__(self, options):
        self.options = options
        self.root = pathlib.Path.cwd() / "sweep"
        if self.root.exists():
            shutil.rmtree(self.root)
        self.root.mkdir()
        self.inputs = self.root / "inputs"
        self.environment = {k: v for k, v in os.environ.items() if not k.startswith("TYNDALL_FAULT")}
        self.environment["XDG_CACHE_HOME"] = str(self.root / "cache")
        (self.root / "cache").mkdir()
        make_inputs(options.tyndall, self.inputs)
        self.rows = collections.defaultdict(collections.Counter)
        self.failures = []
        self.number = itertools.count(1)

    def prepare(self, case, names):
        """A folder with the inputs, and an earlier file in place of each output."""
        folder = self.root / f"run{next(self.number)}"
        folder.mkdir()
        for name in case.inputs:
            source = self.inputs / name
            if source.is_dir():
                shutil.copytree(source, folder / name)
            else:
                shutil.copyfile(source, folder / name)
        for name in names:
            path = folder / name
            path.parent.mkdir(exist_ok=True)
            if not path.exists() and not name.endswith(".state"):  # which the command would read
                path.write_bytes(b"an earlier file\n")
        return folder

    def command(self, case, fault):
        quiet = ["-q"]
        if case.name in ("diff", "help --man") or "convert" in case.name:
            quiet = []
        count = 1 + THREADS_WANTED if fault.group == "thread" else self.options.threads
        threads = [] if case.name == "help --man" else ["--threads", str(count)]
        return [case.program] + case.arguments + quiet + threads

    def settings(self, fault, at, folder):
        return {"LD_PRELOAD": self.options.library, "TYNDALL_FAULT_CALL": fault.group, "TYNDALL_FAULT_AT": str(at),
                "TYNDALL_FAULT_ERROR": fault.error, "TYNDALL_FAULT_FOREVER": "1" if fault.forever else "0",
                "TYNDALL_FAULT_SCOPE": self.options.scope, "TYNDALL_FAULT_FILES": "regular",
                "TYNDALL_FAULT_REPORT": str(folder) + ".report"}

    def execute(self, case, fault, folder, settings):
        """Exit status (None: it hung), stdout, stderr, numbers of the report."""
        environment = {**self.environment, **settings}
        process = subprocess.Popen(self.command(case, fault), cwd=folder, env=environment, stdin=subprocess.DEVNULL,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True)
        try:
            printed, errors = process.communicate(timeout=TIME_LIMIT)
            status = process.returncode
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            printed, errors = process.communicate()
            status = None
        report = pathlib.Path(str(folder) + ".report")
        numbers = struct.unpack(f"<{1 + len(GROUPS)}q", report.read_bytes())
        report.unlink()
        return status, printed, errors.decode(errors="replace"), numbers

    def reference(self, case):
        runs, calls = [], None
        # The first by several threads, on which the time that is expected depends.
        for group in ("thread", "none", "none"):
            folder = self.prepare(case, [])
            none = Fault("none", "EIO", False)
            status, printed, errors, numbers = self.execute(case, Fault(group, "EIO", False), folder,
                                                            self.settings(none, 0, folder))
            if status != 0:
                sys.exit(f"{case.name}: exit status {status} without a fault: {errors}")
            runs.append(files_below(folder))
            calls = dict(zip(GROUPS, numbers[1:]))
            shutil.rmtree(folder)
        for name in case.inputs:  # inputs that the command does not write
            if not any(name == o or name.startswith(o + "/") for o in case.outputs):
                for run in runs:
                    run.pop(name, None)
        # What a command prints that writes no file: numbers of the images.
        return Reference(runs, None if case.outputs else printed), calls

    def problem(self, fault, reference, earlier, folder, status, errors, failed):
        """The first check that the run fails, and the words to say so; (None, "")."""
        if status is None:
            return "hang", f"no end within {TIME_LIMIT} s"
        if status < 0 or status > 2:
            return "signal", f"exit status {status}: {errors[:300]}"
        lines = errors.splitlines()
        said = [line for line in lines if not line.startswith("tyndall: warning: ")]
        if status == 0 and said:
            return "lines", f"exit status 0, yet: {errors[:300]}"
        if status != 0 and (len(said) != 1 or not re.match(r"tyndall: .{8,}[^: ]$", said[0])):
            return "lines", f"exit status {status} and not one line: {errors[:300]!r}"
        left = files_below(folder)
        strange = sorted(set(left) - set(earlier) - set(reference.files))
        if strange:
            return "leftover", f"left behind: {strange}"
        for name, content in earlier.items():
            if name not in left:
                return "damaged", f"{name} is gone"
            if left[name] != content and not reference.has(name, left[name]):
                return "damaged", f"{name} is neither the earlier file nor the new one"
            warned = any(name in line for line in lines)
            if status == 0 and name in reference.files and not reference.has(name, left[name]) and not warned:
                return "status", f"exit status 0, and {name} was not written"
        for name in sorted(set(reference.files) - set(left)):
            if status == 0 and not any(name in line for line in lines):
                return "status", f"exit status 0, and {name} is not there"
        if fault.error in HARMLESS and (status != 0 or lines) and failed:
            return "retry", f"{fault.error} was not retried: {errors[:200]}"
        return None, ""

    def run(self, case, fault, at, reference):
        folder = self.prepare(case, reference.files)
        earlier = files_below(folder)
        settings = self.settings(fault, at, folder)
        status, printed, errors, numbers = self.execute(case, fault, folder, settings)
        failed = numbers[0] > 0
        kind, words = self.problem(fault, reference, earlier, folder, status, errors, failed)
        if kind is None and status == 0 and reference.printed not in (None, printed):
            kind, words = "status", f"exit status 0, and it printed {printed[:200]}"
        row = self.rows[(fault, case.name)]
        row["runs"] += 1
        row[f"exit {status}"] += 1
        if kind is not None:
            row[kind] += 1
            names = " ".join(f"{k}={v}" for k, v in settings.items() if k != "TYNDALL_FAULT_REPORT")
            self.failures.append(f"{case.name}, {fault.group} {at} {fault.error}{' on' if fault.forever else ''}: {words}"
                                 f"\n    {names} {shlex.join(self.command(case, fault))}")
        if not (kind and self.options.keep):
            shutil.rmtree(folder)
        return failed

    def numbers(self, calls, forever):
        """The calls to fail, of so many."""
        first = self.options.dense if self.options.full else QUICK_FIRST_FOREVER if forever else QUICK_FIRST
        chosen, at = set(range(1, min(calls, first) + 1)), float(first)
        while at * self.options.step < calls:
            at = max(at + 1, at * self.options.step)
            chosen.add(int(at))
        if calls > 0:
            chosen.add(calls)
        return sorted(chosen)

    def sweep(self, pool):
        chosen = [case for case in cases(self.options.tyndall) if self.options.full or not case.full]
        chosen = [case for case in chosen if self.options.only is None or self.options.only in case.name]
        prepared = list(pool.map(lambda case: (case, *self.reference(case)), chosen))
        jobs = []
        for case, reference, calls in prepared:
            for fault in map(lambda f: Fault(*f), FAULTS):
                if self.options.group is not None and self.options.group != fault.group:
                    continue
                if fault.group in case.excluded or (fault.group, fault.error) in case.excluded:
                    continue
                count = max(calls[fault.group], THREADS_WANTED if fault.group == "thread" else 0)
                for at in self.numbers(count, fault.forever):
                    jobs.append((case, fault, at, reference))
        print(f"{len(jobs)} runs", flush=True)
        list(pool.map(lambda job: self.run(*job), jobs))
        return len(jobs)

    def print_table(self, heads, names_of):
        """Sums of the rows that have the same names."""
        columns = ["runs", "exit 0", "exit 1", "exit 2"] + PROBLEMS
        sums = collections.defaultdict(collections.Counter)
        for (fault, command), row in self.rows.items():
            words = f"{fault.group} {fault.error}{', and all later' if fault.forever else ''}"
            sums[names_of(words, command)].update(row)
            sums[("all",) * len(heads)].update(row)
        sums[("all",) * len(heads)] = sums.pop(("all",) * len(heads))
        print("\n| " + " | ".join(heads + columns) + " |\n" + "|---" * len(heads + columns) + "|")
        for names, row in sums.items():
            print("| " + " | ".join(list(names) + [str(row[column]) for column in columns]) + " |")

    def print_tables(self):
        if not self.rows:
            return
        self.print_table(["fault", "command"], lambda fault, command: (fault, command))
        self.print_table(["fault"], lambda fault, command: (fault,))
        self.print_table(["command"], lambda fault, command: (command,))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("tyndall")
    parser.add_argument("library")
    parser.add_argument("--full", action="store_true", help="all commands, and every call up to --dense")
    parser.add_argument("--only", help="only commands whose name has this text")
    parser.add_argument("--group", help="only faults of this group of calls")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--threads", type=int, default=1, help="of each command")
    parser.add_argument("--dense", type=int, default=400, help="with --full: up to this call every one fails")
    parser.add_argument("--step", type=float, default=4, help="ratio of the numbers of later calls")
    parser.add_argument("--scope", choices=["main", "all"], default="main", help="calls that count")
    parser.add_argument("--keep", action="store_true", help="keep the folders of runs that failed")
    options = parser.parse_args()
    options.tyndall = os.path.abspath(options.tyndall)
    options.library = os.path.abspath(options.library)
    sweep = Sweep(options)
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        count = sweep.sweep(pool)
    sweep.print_tables()
    for failure in sweep.failures:
        print("FAILED:", failure)
    print(f"{count} runs, {len(sweep.failures)} failed")
    return 1 if sweep.failures or count == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
