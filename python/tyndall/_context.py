"""The context that objects are made with when none is given."""
from __future__ import annotations

import threading
from typing import Optional

from ._core import Context

_lock = threading.Lock()
_default: Optional[Context] = None


def default_context() -> Context:
    """The context of all objects for which no other is given: one thread per processor, on the processor."""
    global _default
    with _lock:
        if _default is None:
            _default = Context()
        return _default


def set_default(threads: int = -1, device: Optional[str] = None) -> Context:
    """Makes and returns another default context, for objects that are made from now on.

    threads: 1..1024, or -1: one per processor. device: "cpu", "cuda:N" or "auto", as docs/device.md tells.
    """
    global _default
    context = Context(threads, device)
    with _lock:
        _default = context
    return context
