# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Checks the values of uniforms as soon as they are set, with the rules of the print that binds them."""

from __future__ import annotations

import re
from typing import Any

from ._given import short
from .errors import InputError
from .fablet import Uniform

_INTEGERS = {"int": (-(2**31), 2**31 - 1), "uint": (0, 2**32 - 1)}
_LARGEST_FLOAT = 3.4028234663852886e38
# The print compares with the kernel's limits, which may be rounded.
_SLACK = 1e-6
_MOST_KEYS = 16


def check_bound(declared: Uniform, value: Any, encoded: Any) -> None:
    """Raises if a uniform cannot have a value; `encoded` is the value as a world file has it."""
    flat = _flat(encoded)
    what, of = f"`{declared.name}`", _type(declared)
    if declared.kind == "curve":
        _check_curve(declared, value, encoded)
        return
    if declared.kind != "value":
        wanted = {"material": "Material or VOID", "object": "Object"}.get(declared.kind, "Texture")
        if not all(isinstance(one, str) for one in flat):
            raise InputError(f"{what} cannot be {short(value)}; it is a `{of}`", help=f"give it a {wanted}")
        _check_count(declared, value, len(flat), declared.array_length)
        return
    scalar = re.match("[a-z]*", declared.type)
    kind = scalar.group() if scalar else ""
    if declared.choices:
        flat = [_chosen(declared, value, one) for one in flat]
    wrong = next((one for one in flat if isinstance(one, str) or isinstance(one, bool) != (kind == "bool")), None)
    if wrong is not None:
        raise InputError(
            f"{what} cannot be {short(value)}; it is a `{of}`",
            help=f"give it {'True or False' if kind == 'bool' else 'numbers' if _count(declared) > 1 else 'a number'}",
        )
    _check_count(declared, value, len(flat), _count(declared))
    for one in flat:
        if kind in _INTEGERS and (one != int(one) or not _INTEGERS[kind][0] <= one <= _INTEGERS[kind][1]):
            low, high = _INTEGERS[kind]
            raise InputError(f"{what} cannot be {short(value)}; a `{kind}` is a whole number from {low} to {high}")
        if kind == "float" and abs(one) > _LARGEST_FLOAT:
            raise InputError(f"{what} cannot be {short(value)}; that is beyond the range of a `float`")
        _check_limits(declared, value, float(one))


def _chosen(declared: Uniform, value: Any, one: Any) -> Any:
    """Returns the value for a name or label, or the value itself."""
    for name, label, number in declared.choices:
        if one in (name, label) if isinstance(one, str) else one == number:
            return bool(number) if declared.type == "bool" else number
    labels = ", ".join(f"`{label}`" for _, label, _ in declared.choices)
    raise InputError(f"`{declared.name}` cannot be {short(value)}", help=f"it is one of {labels}")


def _check_curve(declared: Uniform, value: Any, encoded: Any) -> None:
    ramp = declared.type == "ColorRamp"
    help_ = f'give it a curve, as {{"keys": {"[[0, 1, 0, 0], [1, 0, 0, 1]]" if ramp else "[[0, 1], [5, 2]]"}}}'
    keys = encoded.get("keys") if isinstance(encoded, dict) else None
    wrong = f"`{declared.name}` cannot be {short(value)}"
    if not isinstance(keys, list) or not all(isinstance(key, list) for key in keys):
        raise InputError(f"{wrong}; it is a `{declared.type}`", help=help_)
    if not 1 <= len(keys) <= _MOST_KEYS:
        raise InputError(f"{wrong}; a curve has 1 to {_MOST_KEYS} keys, not {len(keys)}")
    numbers = [_flat(key) for key in keys]
    for key in numbers:
        if len(key) != (4 if ramp else 2) or any(isinstance(one, (bool, str)) for one in key):
            raise InputError(f"{wrong}; a key of a `{declared.type}` has {4 if ramp else 2} numbers", help=help_)
        for one in key[1:]:
            _check_limits(declared, value, float(one))
    if any(after[0] <= before[0] for before, after in zip(numbers, numbers[1:], strict=False)):
        raise InputError(f"{wrong}; the places of its keys do not rise")


def _check_count(declared: Uniform, value: Any, found: int, room: int) -> None:
    if found != room:
        values = "value" if room == 1 else "values"
        raise InputError(f"`{declared.name}` cannot be {short(value)}; a `{_type(declared)}` has {room} {values}")


def _check_limits(declared: Uniform, value: Any, one: float) -> None:
    for key, sign in (("min", 1), ("max", -1)):
        try:
            limit = float(declared.annotations[key])
        except (KeyError, ValueError):
            continue
        if sign * (limit - one) > _SLACK * max(1.0, abs(limit)):
            raise InputError(f"`{declared.name}` cannot be {short(value)}; its `{key}` is {limit:.9g}")


def _type(declared: Uniform) -> str:
    return f"{declared.type}[{declared.array_length}]" if declared.array_length > 1 else declared.type


def _count(declared: Uniform) -> int:
    return declared.components * declared.array_length


def _flat(encoded: Any) -> list[Any]:
    return [one for part in encoded for one in _flat(part)] if isinstance(encoded, list) else [encoded]
