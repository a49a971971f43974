"""Progress of long calls: what a progress function receives, and the bar that is shown without one."""
from __future__ import annotations

import sys
from typing import Any, Callable, NamedTuple, Optional, Union


class Progress(NamedTuple):
    """The state of a long call, about twenty times a second."""

    stage: str
    """Name of the stage, such as "path"."""
    fraction: float
    """Fraction of the whole work that is done, 0..1."""
    seconds: float
    """Time since the work began, s."""
    remaining: float
    """Estimate of the time to go, s; negative while unknown."""
    done: int
    """Samples per pixel that are complete; 0 in work that is not counted in samples."""
    total: int
    """Samples per pixel in all; 0 in work without samples, or bounded by time or error alone."""


ProgressFunction = Callable[[Progress], Any]
ProgressChoice = Union[None, bool, ProgressFunction]

_WIDTH = 24
_PATIENCE = 0.5  # seconds before a bar appears


def _time(seconds: float) -> str:
    whole = int(seconds + 0.5)
    return f"{whole // 60}:{whole % 60:02d}"


def describe(progress: Progress) -> str:
    """One line: a bar, the stage, the time so far and to go."""
    full = int(_WIDTH * min(max(progress.fraction, 0.0), 1.0))
    left = f", {_time(progress.remaining)} to go" if progress.remaining >= 0 else ""
    samples = f" {progress.done}/{progress.total} spp" if progress.total else ""
    bar = "#" * full + "." * (_WIDTH - full)
    return f"{progress.stage}: {100 * progress.fraction:3.0f}% [{bar}]{samples} {_time(progress.seconds)}{left}"


class TerminalBar:
    """A bar on one line of a terminal's standard error."""

    def __init__(self) -> None:
        self.length = 0

    def __call__(self, progress: Progress) -> None:
        if progress.seconds < _PATIENCE and not self.length:
            return
        text = describe(progress)
        sys.stderr.write("\r" + text.ljust(self.length))
        sys.stderr.flush()
        self.length = len(text)

    def close(self) -> None:
        """Clears the line."""
        if self.length:
            sys.stderr.write("\r" + " " * self.length + "\r")
            sys.stderr.flush()
        self.length = 0


class NotebookBar:
    """A bar in the output of a notebook's cell, which goes when the work is done."""

    def __init__(self, display: Callable[..., Any]) -> None:
        self.display = display
        self.handle: Any = None

    def __call__(self, progress: Progress) -> None:
        if progress.seconds < _PATIENCE and self.handle is None:
            return
        if self.handle is None:
            self.handle = self.display(_Bar(progress), display_id=True)
        else:
            self.handle.update(_Bar(progress))

    def close(self) -> None:
        """Empties the output."""
        if self.handle is not None:
            self.handle.update(_Bar(None))
        self.handle = None


class _Bar:
    def __init__(self, progress: Optional[Progress]) -> None:
        self.progress = progress

    def __repr__(self) -> str:
        return describe(self.progress) if self.progress else ""

    def _repr_html_(self) -> str:
        if not self.progress:
            return ""
        text = describe(self.progress).replace("<", "&lt;")
        return f'<progress max="1" value="{self.progress.fraction:.4f}"></progress> <code>{text}</code>'


def _notebook_display() -> Optional[Callable[..., Any]]:
    """IPython's display function in a notebook's kernel, or None."""
    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython is not None and hasattr(ipython, "get_ipython") else None
    if shell is None or not hasattr(shell, "kernel"):
        return None
    from IPython.display import display  # type: ignore

    return display


class Reporter:
    """The progress function of one call, as the extension module calls it; used in a with statement."""

    def __init__(self, choice: ProgressChoice) -> None:
        self.bar: Any = None
        if callable(choice):
            self.function: Optional[ProgressFunction] = choice
        elif choice is False:
            self.function = None
        else:
            display = _notebook_display()
            if display is not None:
                self.bar = NotebookBar(display)
            elif choice is True or (sys.stderr is not None and sys.stderr.isatty()):
                self.bar = TerminalBar()
            self.function = self.bar

    def __enter__(self) -> Optional[Callable[..., Any]]:
        function = self.function
        if function is None:
            return None
        return lambda *state: function(Progress(*state))

    def __exit__(self, *_: Any) -> None:
        if self.bar is not None:
            self.bar.close()
