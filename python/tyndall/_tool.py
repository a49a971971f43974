"""The program `tyndall` from Python: commands that write files, serve pages or come as programs of their own."""
from __future__ import annotations

import atexit
import contextlib
import json
import logging
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import threading
import webbrowser
from typing import Any, Iterable, Iterator, Mapping, Optional, Sequence, Union

from . import _core
from ._errors import ArgumentError, Error, InputError, Unsupported
from ._image import Image
from ._progress import Progress, ProgressChoice, Reporter
from ._saved import save_scene
from ._scene import Scene

Path = Union[str, os.PathLike[str]]
_USAGE = 2  # exit status of wrong usage and wrong input
_SILENT = ("bench", "figure")  # commands without progress as JSON
_logger = logging.getLogger("tyndall")


def tool() -> str:
    """Path of the program: that of the environment variable TYNDALL, of the package, of the build, or in PATH."""
    given = os.environ.get("TYNDALL")
    if given:
        if os.access(given, os.X_OK):
            return given
        raise Unsupported(f"TYNDALL is {given}, which is no program")
    module = pathlib.Path(_core.__file__).resolve().parent
    for path in (module / "bin" / "tyndall", module.parent.parent / "bin" / "tyndall"):
        if os.access(path, os.X_OK):
            return str(path)
    found = shutil.which("tyndall")
    if found:
        return found
    raise Unsupported("the program tyndall is not installed: it is in the package by default, or name it by the "
                      "environment variable TYNDALL")


def _word(value: Any) -> str:
    if isinstance(value, (list, tuple)):
        return ",".join(_word(part) for part in value)
    if hasattr(value, "tolist"):
        return _word(value.tolist())
    return os.fspath(value) if isinstance(value, os.PathLike) else str(value)


def _options(options: Mapping[str, Any]) -> list[str]:
    """Keywords as options of a command line."""
    words = []
    for key, value in options.items():
        name = "--" + key.rstrip("_").replace("_", "-")
        if value is None or value is False:
            continue
        if key == "define":
            words += [text for path, new in value.items() for text in ("-D", f"{path}={json.dumps(new)}")]
        elif value is True:
            words.append(name)
        elif key == "size" and isinstance(value, (list, tuple)) and len(value) == 2:
            words += [name, "x".join(_word(side) for side in value)]
        elif key == "feature" and isinstance(value, (list, tuple)):
            words += [text for item in value for text in (name, _word(item))]
        else:
            words += [name, _word(value)]
    return words


@contextlib.contextmanager
def _files(arguments: Iterable[Any]) -> Iterator[list[str]]:
    """Arguments of a command: scenes and images as files of a folder that lives as long as the command."""
    with contextlib.ExitStack() as stack:
        folder = ""
        words = []
        for i, argument in enumerate(arguments):
            if isinstance(argument, (Scene, Image)) and not folder:
                folder = stack.enter_context(tempfile.TemporaryDirectory(prefix="tyndall."))
            if isinstance(argument, Scene):
                words.append(os.path.join(folder, f"scene{i}.json"))
                save_scene(argument, words[-1])
            elif isinstance(argument, Image):
                words.append(os.path.join(folder, f"image{i}.exr"))
                argument.save(words[-1])
            else:
                words.append(_word(argument))
        yield words


def _fail(command: str, status: int, lines: Sequence[str]) -> Error:
    message = lines[-1] if lines else f"tyndall {command} ended with the status {status}"
    if status != _USAGE:
        return Error(message, status)
    return ArgumentError(message) if message.startswith("--") or " --help')" in message else InputError(message)


def _listen(process: subprocess.Popen[str], report: Any, lines: list[str]) -> None:
    """Reads progress and messages until the program closes its standard error."""
    stopped = False
    assert process.stderr is not None
    for line in process.stderr:
        text = line.rstrip("\n")
        if not text.startswith("{"):
            if text:
                lines.append(re.sub(r"^tyndall(-\w+)?: ", "", text))
            continue
        if report is None or stopped:
            continue
        state = json.loads(text)
        if report(*(state.get(key, 0) for key in Progress._fields)) is False:
            stopped = True
            process.send_signal(signal.SIGINT)


def _communicate(process: subprocess.Popen[str], report: Any, lines: list[str]) -> str:
    """Standard output. An interrupt is passed on to the program, which keeps what it has."""
    out: list[str] = []
    assert process.stdout is not None
    reader = threading.Thread(target=lambda: out.append(process.stdout.read()), daemon=True)  # type: ignore
    reader.start()
    try:
        _listen(process, report, lines)
        process.wait()
    except BaseException:
        process.send_signal(signal.SIGINT)
        process.wait()
        raise
    finally:
        reader.join()
        process.stderr.close()  # type: ignore
        process.stdout.close()
    return "".join(out)


def run(command: str, *arguments: Any, progress: ProgressChoice = None, **options: Any) -> str:
    """Runs a command of the program, as `tyndall help COMMAND` describes it; its standard output.

    arguments: paths, or Scenes and Images, which are written to files for the command. options: its options,
    run("bake", scene, output="baked", quality="high", resume=True): True is an option without a value, sequences are
    joined by commas, size=(640, 480) is 640x480, and define is a dict of changes of the scene. progress: as of
    Scene.render(); of "bench" and "figure" there is none. Warnings go to logging.getLogger("tyndall"). Raises InputError
    and ArgumentError for the exit status 2, else Error; Ctrl-C interrupts the program, which keeps what is finished.
    """
    lines: list[str] = []
    with _files(arguments) as words, Reporter(progress) as report:
        shown = [] if command in _SILENT else ["--progress", "json" if report is not None else "none"]
        with subprocess.Popen([tool(), command, *words, *_options(options), *shown], text=True, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True) as process:
            out = _communicate(process, report, lines)
    if process.returncode != 0:
        raise _fail(command, process.returncode, lines)
    for line in lines:
        _logger.log(logging.WARNING if "warning" in line else logging.INFO, "%s", line)
    return out


def bench(*names: str, **options: Any) -> Any:
    """Measures speed, as `tyndall bench`, which comes with the build and not with the package; the measurements.

    names: groups, or none for all of them. options: those of the command, such as seconds=1.
    """
    return json.loads(run("bench", *(names or ("all",)), json=True, **options))


def figure(name: str, output: Path, **options: Any) -> dict[str, Any]:
    """Makes a figure or a table of a paper again, as `tyndall figure`, which comes with the build and not with the package.

    name: a figure, all of one paper ("i3rc") or "all". Writes FIGURE.png, .csv and .json to the folder `output`. Returns the
    contents of the latter by figure: measured and expected values.
    """
    run("figure", name, output=output, **options)
    made = sorted(pathlib.Path(output).glob("*.json" if name == "all" else f"{name}*.json"))
    return {path.stem: json.loads(path.read_text(encoding="utf-8")) for path in made}


def merge(images: Sequence[Union[Image, Path]], **options: Any) -> Image:
    """Joins renderings of one scene, size and method: those of different seeds to their mean, crops to a whole.

    images: two or more, or their .exr files. Means are weighted by samples (the channel samples.N, else tyndall.spp), and
    variances are those of that mean, as by `tyndall merge`.
    """
    if len(images) < 2:
        raise ArgumentError(f"images: two or more are merged, not {len(images)}")
    with tempfile.TemporaryDirectory(prefix="tyndall.") as folder:
        path = os.path.join(folder, "merged.exr")
        run("merge", *images, output=path, progress=False, **options)
        return Image.read(path)


def convert(source: Path, target: Path, **options: Any) -> None:
    """Converts a volume, an image (also to textures, .ktx2 and .dds), or a scene of pbrt-v4 or Mitsuba, by extensions.

    options: those of `tyndall convert`, such as mipmaps=True, grid="heat", raw_size=(64, 64, 64).
    """
    run("convert", source, target, progress=False, **options)


def unwrap(level: Path, output: Path, **options: Any) -> Any:
    """Gives the meshes of a glTF file second texture coordinates, for lightmaps; what each node got.

    output: a .glb file. options: those of `tyndall unwrap`: density (texels per metre), padding (texels), stretch, all_.
    """
    return json.loads(run("unwrap", level, output=output, json=True, **options))


def export(baked: Path, output: Path, engine: str = "three", **options: Any) -> dict[str, Any]:
    """Writes the lightmaps and probes of a folder of Scene.bake_files() as an engine loads them; the content of export.json.

    engine: "three", "godot", "unity" or "unreal" (docs/engines.md). options: those of `tyndall export`.
    """
    run("export", baked, output=output, for_=engine, **options)
    return json.loads((pathlib.Path(output) / "export.json").read_text(encoding="utf-8"))


class View:
    """The viewer of a scene or a photograph, served until close(), the end of a with statement or of Python.

    url: the page's address, which holds a token: who has it may look, and change the scene in the viewer's memory.
    """

    def __init__(self, files: contextlib.ExitStack, process: subprocess.Popen[str], url: str) -> None:
        self._files = files
        self._process = process
        self.url = url
        atexit.register(self.close)

    @property
    def closed(self) -> bool:
        """True once the viewer has ended."""
        return self._process.poll() is not None

    def wait(self) -> None:
        """Waits until the viewer ends; Ctrl-C ends it."""
        try:
            self._process.wait()
        except KeyboardInterrupt:
            self.close()

    def close(self) -> None:
        """Ends the viewer."""
        atexit.unregister(self.close)
        if not self.closed:
            self._process.send_signal(signal.SIGINT)
        self._process.wait()
        if self._process.stdout is not None:
            self._process.stdout.close()
        self._files.close()

    def __enter__(self) -> "View":
        return self

    def __exit__(self, *_: Any) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<tyndall.View {'closed' if self.closed else self.url}>"

    def _repr_html_(self) -> str:
        return "closed" if self.closed else f'<a href="{self.url}" target="_blank">{self.url}</a>'


def view(source: Union[Scene, Image, Path], distance: Union[None, Image, Path] = None, *, open: bool = True,
         **options: Any) -> View:
    """Shows a scene in the browser, live, or a photograph through a medium (docs/view.md); returns at once.

    source: a Scene, as it is now, or a path; or a photograph with distances, of itself or of another image, and a medium:
    view("photo.exr", medium="fog:50"). open: opens the browser. options: those of `tyndall view`: method, size, port,
    record (a folder for images), remote. What is changed in the page does not change the Scene.
    """
    with contextlib.ExitStack() as files:
        words = files.enter_context(_files([source] if distance is None else [source, distance]))
        errors = files.enter_context(tempfile.TemporaryFile("w+"))
        process = subprocess.Popen([tool(), "view", *words, *_options(options), "--no-open", "--progress", "none"],
                                   text=True, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=errors,
                                   start_new_session=True)
        url = process.stdout.readline().strip()  # type: ignore
        if not url:
            process.wait()
            process.stdout.close()  # type: ignore
            errors.seek(0)
            raise _fail("view", process.returncode, [re.sub("^tyndall: ", "", line) for line in
                                                     errors.read().splitlines()])
        made = View(files.pop_all(), process, url)
    if open:
        webbrowser.open(url)
    return made


def bake_files(scene: Union[Scene, Path], folder: Path, *, progress: ProgressChoice = None,
               **options: Any) -> dict[str, Any]:
    """Bakes to a folder of files, as `tyndall bake`; see Scene.bake_files()."""
    target = pathlib.Path(folder)
    source: Any = scene
    if isinstance(scene, Scene):
        target.mkdir(parents=True, exist_ok=True)
        source = target / "scene.json"
        save_scene(scene, source)
    run("bake", source, output=target, progress=progress, **options)
    return json.loads((target / "bake.json").read_text(encoding="utf-8"))
