"""Arrays in and out, with NumPy where it is and without where it is not."""
from __future__ import annotations

import array as _array
from typing import Any, Optional

try:
    import numpy
except ImportError:  # the package does not need it
    numpy = None  # type: ignore


def view(memory: Any) -> Any:
    """A view without a copy: a numpy.ndarray, or without NumPy a memoryview."""
    return numpy.asarray(memory) if numpy is not None else memoryview(memory)


def is_array(value: Any) -> bool:
    """True for what an array can be made of without a loop: not for lists and tuples of numbers."""
    if isinstance(value, (str, bytes, bytearray, dict)):
        return False
    return hasattr(value, "__array_interface__") or hasattr(value, "__dlpack__") or hasattr(value, "__array__") or (
        isinstance(value, (memoryview, _array.array)))


def axes_of(value: Any) -> int:
    """Number of axes of an array."""
    shape = getattr(value, "shape", None)
    return len(shape) if shape is not None else 1


def to_input(value: Any, what: str) -> Any:
    """An object that the extension module can read: as it is where possible."""
    if hasattr(value, "requires_grad") and value.requires_grad:
        value = value.detach()
    try:
        memoryview(value)
        return value
    except TypeError:
        pass
    if hasattr(value, "__dlpack__"):
        return value
    if hasattr(value, "__array__"):
        return value.__array__()
    if numpy is not None:
        return numpy.asarray(value)
    return flatten(value, what)


def flatten(value: Any, what: str) -> Any:
    """Nested lists of numbers as one array of doubles, for machines without NumPy."""
    out = _array.array("d")

    def add(item: Any) -> None:
        if isinstance(item, (int, float)):
            out.append(item)
            return
        for part in item:
            add(part)

    try:
        add(value)
    except TypeError:
        raise TypeError(f"{what}: expected an array or nested lists of numbers") from None
    return out


def to_float32(value: Any) -> Any:
    """float32 with the same shape, the same memory where it is that already."""
    if numpy is None:
        return value
    made = numpy.asarray(to_input(value, "array"))
    return made if made.dtype == numpy.float32 else made.astype(numpy.float32)


def split_channels(value: Any) -> list[Any]:
    """The three parts of an array (..., 3), each in C order."""
    if numpy is None:
        raise TypeError("volumes of three values per voxel need NumPy")
    made = numpy.asarray(to_input(value, "array"))
    return [numpy.ascontiguousarray(made[..., c], dtype=numpy.float32) for c in range(3)]


def to_plain(value: Any) -> Any:
    """Numbers of NumPy, torch and the like as Python's own; small arrays as lists. None if it is neither."""
    if hasattr(value, "tolist"):
        return value.tolist()
    if hasattr(value, "item"):
        return value.item()
    return None


def xarray_or_none() -> Optional[Any]:
    """The module xarray, where it is installed."""
    try:
        import xarray
    except ImportError:
        return None
    return xarray
