# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Converts arguments to numbers and arrays, from any library; an error names the argument that is wrong."""

from __future__ import annotations

import difflib
import math
import numbers
import operator
import os
import reprlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any, SupportsFloat, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import InputError

Real = SupportsFloat
Whole = SupportsIndex

_short = reprlib.Repr()
_short.maxstring = _short.maxother = 80


def short(value: Any) -> str:
    """Returns a short text of a value of any size, for messages."""
    if isinstance(value, np.ndarray) and value.ndim:
        return f"an array of {value.dtype} of the shape {value.shape}"
    return _short.repr(value)


def _is_number(value: Any) -> bool:
    if isinstance(value, (str, bytes, bool, np.bool_, np.flexible, np.datetime64, np.timedelta64)):
        return False
    if isinstance(value, numbers.Complex):
        return isinstance(value, numbers.Real)
    return isinstance(value, SupportsFloat) and getattr(value, "ndim", 0) == 0


def number(value: Any, what: str) -> float:
    """Returns a number; `what` names it in messages."""
    value = value[()] if isinstance(value, np.ndarray) and value.ndim == 0 else value
    if not _is_number(value):
        raise InputError(f"{what} cannot be {short(value)}; it is a number")
    try:
        found = float(value)
    except (TypeError, ValueError, OverflowError):
        found = math.nan
    if not math.isfinite(found):
        raise InputError(f"{what} cannot be {short(value)}; it is a finite number")
    return found


def positive(value: Any, what: str, least: float | None = None) -> float:
    """Returns a number greater than 0, or not less than `least`."""
    found = number(value, what)
    if found < least if least is not None else found <= 0:
        rule = "more than 0" if least is None else f"{least:g} at least"
        raise InputError(f"{what} cannot be {short(value)}; it is {rule}")
    return found


def choice(value: Any, what: str, choices: Sequence[str]) -> str:
    """Returns a word that is one of `choices`."""
    if not isinstance(value, str) or value not in choices:
        near = difflib.get_close_matches(value, choices, 1) if isinstance(value, str) else []
        hint = f"did you mean `{near[0]}`?" if near else f"it is one of {', '.join(f'`{one}`' for one in choices)}"
        raise InputError(f"{what} cannot be {short(value)}; {hint}")
    return str(value)


def whole(value: Any, what: str) -> int:
    """Returns a whole number."""
    value = value[()] if isinstance(value, np.ndarray) and value.ndim == 0 else value
    try:
        if _is_number(value):
            return operator.index(value)
    except TypeError:
        pass
    raise InputError(f"{what} cannot be {short(value)}; it is a whole number")


def is_sequence(value: Any) -> bool:
    """Returns whether a value is an ordered collection, such as a list or an array."""
    return hasattr(value, "__len__") and getattr(value, "ndim", 1) > 0 and not isinstance(value, (str, bytes, Mapping))


def several(value: Any, what: str, counts: Sequence[int], example: str) -> list[Any]:
    """Returns the elements of a sequence whose length is one of `counts`."""
    if not is_sequence(value):
        raise InputError(f"{what} cannot be {short(value)}; write {example}")
    found = list(value)
    if len(found) not in counts:
        raise InputError(f"{what} has {len(found)} elements; write {example}")
    return found


def vector(value: Any, what: str, counts: Sequence[int] = (3,)) -> list[float]:
    """Returns the numbers of a sequence."""
    example = " or ".join("(" + ", ".join("xyz"[:count]) + ")" for count in counts)
    return [number(one, what) for one in several(value, what, counts, example)]


def array(values: ArrayLike, what: str) -> NDArray[Any]:
    """Returns a copy of an array of booleans, integers or floats, in the byte order of this machine."""
    if isinstance(values, np.ma.MaskedArray):
        if np.ma.is_masked(values):
            raise InputError(f"{what} has masked values; say what they are, as by `.filled(0)`")
        values = values.data
    try:
        found = np.array(values)
    except (TypeError, ValueError) as error:
        raise InputError(f"{what} cannot be made an array: {error}") from error
    if found.dtype.kind not in "biuf":
        raise InputError(f"{what} is an array of {found.dtype}; it should be of integers or floats")
    return found.astype(found.dtype.newbyteorder("="), copy=False)


def floats(values: ArrayLike, what: str, kind: type[np.floating[Any]] = np.float32) -> NDArray[Any]:
    """Returns a copy of an array as finite floats."""
    given = array(values, what)
    with np.errstate(over="ignore"):
        found = given.astype(kind)
    odd = np.argwhere(~np.isfinite(found))
    if len(odd):
        place, more = tuple(int(i) for i in odd[0]), f", and {len(odd) - 1} more" if len(odd) > 1 else ""
        raise InputError(
            f"{what} has {given[place]} at [{', '.join(map(str, place))}]{more}; its values should be finite, in the "
            f"range of {np.dtype(kind)}"
        )
    return found


def integers(values: ArrayLike, what: str) -> NDArray[np.int32]:
    """Returns a copy of an array as 32-bit integers; its values must be integers in that range."""
    given = array(values, what)
    limits = np.iinfo(np.int32)
    fits = (given >= limits.min) & (given <= limits.max)
    odd = np.argwhere(~(fits & (given == np.floor(given)) if given.dtype.kind == "f" else fits))
    if len(odd):
        place = tuple(int(i) for i in odd[0])
        raise InputError(
            f"{what} has {given[place]} at [{', '.join(map(str, place))}]; its values should be integers of 32 bits"
        )
    return given.astype(np.int32)


def plain(value: Any, what: str, encode: Callable[[Any, str], Any] | None = None) -> Any:
    """Converts a value to JSON types; `encode` converts the elements of lists."""
    if isinstance(value, (bool, np.bool_)):
        return bool(value)
    if isinstance(value, str):
        return str(value)
    if isinstance(value, np.ndarray) and value.ndim:
        found = array(value, what)
        return (floats(found, what, np.float64) if found.dtype.kind == "f" else found).tolist()
    if isinstance(value, Mapping):
        return {str(key): plain(one, f"{what}, `{key}`", encode) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [(encode or plain)(one, what) for one in value]
    if isinstance(value, os.PathLike):
        return os.fsdecode(value)
    value = value[()] if isinstance(value, np.ndarray) else value
    return whole(value, what) if isinstance(value, numbers.Integral) else number(value, what)
