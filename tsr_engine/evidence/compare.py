"""Compares records exactly, for tests that replays and resumed runs equal the original."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from numbers import Integral

import numpy as np
from numpy.typing import NDArray


def differences(a: object, b: object, *, ignore: frozenset[str] = frozenset(), path: str = "") -> Iterator[str]:
    """Yield the differences between two records, bit by bit: a dotted path with both values for each.

    Floats are equal if their bits are (``0.0`` and ``-0.0`` differ; every NaN equals every other).

    Args:
        a: a record, array, sequence, mapping or scalar.
        b: the record to compare it with.
        ignore: names of fields to skip, such as ``timings``.
        path: prefix of the reported places.
    """
    if is_dataclass(a) and type(a) is type(b):
        for item in fields(a):
            if item.name not in ignore:
                inner = getattr(a, item.name), getattr(b, item.name)
                yield from differences(*inner, ignore=ignore, path=f"{path}.{item.name}".lstrip("."))
    elif isinstance(a, np.ndarray) and isinstance(b, np.ndarray):
        if a.shape != b.shape or a.dtype != b.dtype:
            yield f"{path}: {a.dtype}{a.shape} against {b.dtype}{b.shape}"
        elif not _same_bits(a, b):
            yield f"{path}: {a.tolist()} against {b.tolist()}"
    elif isinstance(a, (tuple, list)) and isinstance(b, (tuple, list)):
        if len(a) != len(b):
            yield f"{path}: {len(a)} items against {len(b)}"
        for i, (x, y) in enumerate(zip(a, b, strict=False)):
            yield from differences(x, y, ignore=ignore, path=f"{path}[{i}]")
    elif isinstance(a, Mapping) and isinstance(b, Mapping):
        if a.keys() != b.keys():
            yield f"{path}: keys {sorted(a)} against {sorted(b)}"
        for key in a.keys() & b.keys():
            yield from differences(a[key], b[key], ignore=ignore, path=f"{path}[{key!r}]")
    elif isinstance(a, float) and isinstance(b, float):
        if struct.pack("<d", a) != struct.pack("<d", b) and not (math.isnan(a) and math.isnan(b)):
            yield f"{path}: {a!r} against {b!r}"
    elif isinstance(a, Integral) and isinstance(b, Integral):
        if int(a) != int(b):
            yield f"{path}: {a!r} against {b!r}"
    elif type(a) is not type(b) or a != b:
        yield f"{path}: {a!r} against {b!r}"


def _same_bits(a: NDArray[np.number], b: NDArray[np.number]) -> bool:
    if a.tobytes() == b.tobytes():
        return True
    if a.dtype.kind != "f":
        return False
    same = (a == b) & (np.signbit(a) == np.signbit(b))
    return bool((same | (np.isnan(a) & np.isnan(b))).all())
