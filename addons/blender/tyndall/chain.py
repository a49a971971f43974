"""Runs of the program for images. Frames of method dom share one process, `tyndall render --more`, in which each frame starts
from the light of the one before; it ends with Blender's render."""
import tempfile

import bpy

from . import process, tev

WARM = ("dom",)  # methods that take the light of another frame

_kept = []


class Chain:
    """A process for one image or, if it stays, for several with the same options; and the receiver of its tev images."""

    def __init__(self, program, options, stays):
        self.program, self.options, self.stays, self.run = program, list(options), stays, None
        self.receiver = tev.Receiver()

    def image(self, scene, image, stats, folder):
        """Begins an image; returns the process.Run."""
        if self.run is not None:
            self.run.ask(scene, image, stats)
            return self.run
        arguments = ["render", scene, "-o", image, "--stats", stats, *self.options, "--tev", f"127.0.0.1:{self.receiver.port}"]
        if self.stays:
            arguments.append("--more")
        self.run = process.Run(self.program, arguments, tempfile.gettempdir() if self.stays else folder, self.stays)
        return self.run

    def end(self):
        """After an image: closes what need not stay."""
        if self not in _kept:
            self.close()

    def close(self):
        if self.run is not None:
            self.run.close()
        self.receiver.close()


def begin(program, options, method, paths):
    """A chain for an image with options of the program; paths: of its files."""
    stays = method in WARM and not any(c in path for path in paths for c in "\t\r\n")
    for chain in list(_kept):
        if stays and chain.program == program and chain.options == list(options) and chain.run.stays_on():
            return chain
        end_all()
    out = Chain(program, options, stays)
    if stays:
        _kept.append(out)
    return out


@bpy.app.handlers.persistent
def end_all(*_):
    """Ends the processes that stay: a render, of one image or of an animation, has come to its end."""
    while _kept:
        _kept.pop().close()


def register():
    bpy.app.handlers.render_complete.append(end_all)
    bpy.app.handlers.render_cancel.append(end_all)


def unregister():
    end_all()
    for handlers in (bpy.app.handlers.render_complete, bpy.app.handlers.render_cancel):
        if end_all in handlers:
            handlers.remove(end_all)
