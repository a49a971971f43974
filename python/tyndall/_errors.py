"""Exceptions, and the library's log. Imported by the extension module, so that it imports nothing of the package."""
from __future__ import annotations

import logging
import re
from typing import Optional

_logger = logging.getLogger("tyndall")
_SECTIONS = "media|lights|camera|geometry|render|frame|tyndall|meters_per_unit|up_axis"
_PLACE = re.compile(r"(?P<file>[^\n]+?):(?P<line>\d+): (?:(?P<key>[A-Za-z_][\w.\[\]]*): )?")
_KEY = re.compile(rf"(?P<key>(?:{_SECTIONS})\b[\w.\[\]]*): ")
_FILE = re.compile(r"(?:cannot (?:open|read|write|replace) )?(?P<file>[^\s:][^\n:]*\.\w+): ")


class Error(Exception):
    """A call failed. The message is one sentence, such as "cloud.json:14: media[0].g: 1.2 is outside (-1, 1)".

    Attributes: `file`, `line` and `key` are the place in a scene file that the message names, or None; `code` is the
    number of the C API's ty_result.
    """

    def __init__(self, message: str = "", code: int = 0) -> None:
        super().__init__(message)
        self.code = code
        self.file: Optional[str] = None
        self.line: Optional[int] = None
        self.key: Optional[str] = None
        found = _PLACE.match(message) or _KEY.match(message) or _FILE.match(message)
        if found:
            parts = found.groupdict()
            self.file = parts.get("file")
            self.key = parts.get("key")
            self.line = int(parts["line"]) if parts.get("line") else None


class Cancelled(Error):
    """A progress function returned False, and there is no partial result."""


class ArgumentError(Error, ValueError):
    """An argument is wrong."""


class InputError(Error, ValueError):
    """The content of a file or a scene is wrong."""


class FileError(Error, OSError):
    """A file cannot be opened, read or written."""


class OutOfMemory(Error, MemoryError):
    """There is not enough memory."""


class Unsupported(Error, NotImplementedError):
    """This build or this machine lacks what the call needs."""


_KINDS = {1: Cancelled, 2: ArgumentError, 3: InputError, 4: FileError, 5: OutOfMemory, 6: Unsupported}


def make_error(code: int, message: str) -> Error:
    """The exception of a result of the C API."""
    return _KINDS.get(code, Error)(message, code)


def emit_log(level: int, text: str) -> None:
    """Passes a line of the library's log on to logging.getLogger("tyndall"); errors are exceptions besides."""
    _logger.log((logging.INFO, logging.WARNING, logging.DEBUG)[min(max(level, 0), 2)], "%s", text)
