"""The program `tyndall` as a process of its own: where it is, runs with progress and cancelling, short questions."""
import atexit
import json
import os
import shutil
import signal
import subprocess
import threading
import weakref

MISSING = ("the program \"tyndall\" is not there: set its path in the add-on's preferences, "
           "or the environment variable TYNDALL, or put it into PATH")
WINDOWS = os.name == "nt"


def find_program(preferred=""):
    """The path of the program by the preferences, TYNDALL or PATH; None where there is none. A wrong path of the
    preferences or of TYNDALL is not passed over."""
    for path in (preferred, os.environ.get("TYNDALL", "")):
        if path:
            path = os.path.expanduser(path)
            return path if os.path.isfile(path) and os.access(path, os.X_OK) else None
    return shutil.which("tyndall")


def _options():
    if WINDOWS:
        return {"creationflags": subprocess.CREATE_NEW_PROCESS_GROUP | subprocess.CREATE_NO_WINDOW}
    return {"start_new_session": True}


_started = weakref.WeakSet()


def start(command, **options):
    """A process that ends with Blender at the latest."""
    process = subprocess.Popen(command, **{"stdin": subprocess.DEVNULL, **options}, **_options())
    _started.add(process)
    return process


@atexit.register
def _end_all():
    for process in list(_started):
        if process.poll() is None:
            process.kill()


def answer(program, arguments, seconds=30):
    """What the program prints for some arguments; None where it fails."""
    try:
        done = subprocess.run([program, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, timeout=seconds, **_options())
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done.stdout.decode(errors="replace") if done.returncode == 0 else None


def maximum_of_grid(program, file, grid):
    """The maximum of a grid of a volume file; None where it is not known."""
    text = answer(program, ["info", file, "--grid", grid, "--json"])
    try:
        values = json.loads(text)["range"]
        return float(values[1])
    except (TypeError, ValueError, KeyError, IndexError):
        return None


class Run:
    """A run of the program with `--progress json`. fraction, stage and remaining are the newest progress; lines what else it
    said on stderr, of which the last is the reason of a failure. One that stays (`--more`) answers each image on stdout, and
    is running until then."""

    def __init__(self, program, arguments, folder=None, stays=False):
        self.fraction, self.stage, self.remaining, self.lines = 0.0, "", None, []
        self.cancelled, self.stays, self.answered = False, stays, threading.Event()
        pipe = subprocess.PIPE if stays else subprocess.DEVNULL
        self.process = start([program, *arguments, "--progress", "json"], cwd=folder, stdin=pipe, stdout=pipe,
                             stderr=subprocess.PIPE)
        self.answer = ""
        self.readers = [threading.Thread(target=read, daemon=True) for read in (self._read, self._read_answers)[:1 + stays]]
        for reader in self.readers:
            reader.start()

    def ask(self, scene, image, stats):
        """Begins another image."""
        self.fraction, self.stage, self.remaining, self.lines, self.answer = 0.0, "", None, [], ""
        self.answered.clear()
        try:
            self.process.stdin.write(f"{scene}\t{image}\t{stats}\n".encode())
            self.process.stdin.flush()
        except OSError:
            self.answered.set()

    def stays_on(self):
        """True if it can be asked for another image."""
        return self.stays and not self.cancelled and self.process.poll() is None

    def close(self):
        """Ends it."""
        if self.stays:
            try:
                self.process.stdin.close()
            except OSError:
                pass
            self.stays = False
            self.finish(5)
        self.__exit__()

    def _read_answers(self):
        for raw in self.process.stdout:
            self.answer = raw.decode(errors="replace").strip()
            self.answered.set()
        self.answered.set()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()

    def _read(self):
        for raw in self.process.stderr:
            line = raw.decode(errors="replace").strip()
            if line.startswith("{"):
                try:
                    self._take(json.loads(line))
                    continue
                except ValueError:
                    pass
            if line:
                self.lines.append(line)

    def _take(self, progress):
        self.fraction = float(progress.get("fraction", self.fraction))
        self.stage = progress.get("stage", self.stage)
        self.remaining = progress.get("remaining", self.remaining)

    def is_running(self):
        return self.process.poll() is None and not (self.stays and self.answered.is_set())

    def cancel(self):
        """Asks the program to write what it has and to end."""
        if not self.cancelled and self.is_running():
            self.cancelled = True
            self.process.send_signal(signal.CTRL_BREAK_EVENT if WINDOWS else signal.SIGINT)

    def finish(self, seconds=120):
        """Waits for the end; a program that does not end is killed. Returns the exit status, of one that stays 0 for an image
        that is done."""
        if self.stays and not self.cancelled and self.answered.wait(seconds) and self.process.poll() is None:
            return 0 if self.answer == "done" else 1
        try:
            self.process.wait(seconds)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self.readers[0].join(5)
        return self.process.returncode

    def reason(self):
        """Why the run failed, in one sentence."""
        if self.answer.startswith("failed "):
            return self.answer[len("failed "):]
        own = [line for line in self.lines if line.startswith("tyndall:")]
        return (own or self.lines or [f"the program ended with status {self.process.returncode}"])[-1]


def predict(program, scene_file, size):
    """The line of method auto about a scene, "path, about 2 %, 0.09 s (reason)"; None where there is none."""
    out = os.path.join(os.path.dirname(scene_file), "prediction.exr")
    run = Run(program, ["render", scene_file, "--method", "auto", "-o", out, "--size", f"{size[0]}x{size[1]}"])
    found = None
    while found is None and run.is_running():
        found = next((line for line in run.lines if line.startswith("method: ")), None)
        run.readers[0].join(0.02)
    run.cancel()
    run.finish()
    found = found or next((line for line in run.lines if line.startswith("method: ")), None)
    if os.path.exists(out):
        os.remove(out)
    return (found[len("method: "):], None) if found else (None, run.reason())
