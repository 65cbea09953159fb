# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""The arguments of prints as `program::Options`, like those from the command line of `openfab print`."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypedDict

from . import _core
from ._given import Real, Whole, choice, is_sequence, number, positive, several, short, whole
from ._printers import known_printer
from .errors import InputError, raise_error


class SharedArguments(TypedDict, total=False):
    """The arguments that `openfab.print_world` shares with a print over many machines."""

    printer: str | os.PathLike[str] | None
    voxel: Real | str | Sequence[Real] | None
    dpi: Real | str | Sequence[Real] | None
    layer: Real | str | None
    draft: Whole | None
    slices: Sequence[Whole] | None
    z: Sequence[Real | str] | None
    support: bool | str | None
    dither: str | None
    seed: Whole | None
    crop: Literal["parts", "tray"] | None
    format: str | None
    token_file: str | os.PathLike[str] | None
    tls_ca: str | os.PathLike[str] | None


def fields_of(**arguments: Any) -> dict[str, Any]:
    """Returns the fields of Options for the arguments that are not None."""
    fields: dict[str, Any] = {}
    for key, value in arguments.items():
        if value is not None:
            for name, field in _fields(key, f"`{key}`", value).items():
                fields[name] = {**fields.get(name, {}), **field} if isinstance(field, dict) else field
    return fields


def options_of(*parts: Mapping[str, Any]) -> _core.Options:
    """Returns Options with some fields; raises if they are invalid."""
    options = _core.Options()
    for name, value in (item for fields in parts for item in fields.items()):
        try:
            setattr(options, name, value)
        except TypeError:
            raise InputError(f"`{name}` cannot be {short(value)}; the number is out of range") from None
    if (error := options.validate()) is not None:
        raise_error(error)
    return options


def view_of(text: str) -> _core.View:
    """Returns the view described by a text such as `model:30:30,cut=x`."""
    view: _core.View = _known(_core.parse_view(f"view={text}"))
    return view


def _fields(key: str, what: str, value: Any) -> dict[str, Any]:
    if key == "voxel" and is_sequence(value):
        x, y, z = (positive(one, what) for one in several(value, what, (3,), "one pitch, or three, of x, y and z"))
        return {"dpi": (25.4 / x, 25.4 / y), "layer_mm": z}
    if key in ("voxel", "layer", "mesh_pitch"):
        return {f"{key}_mm": _length(key, value)}
    if key == "dpi":
        if isinstance(value, str):
            return {key: tuple(_known(_core.parse_dpi(value)))}
        pair = several(value, what, (2,), "one resolution, or two, of x and y") if is_sequence(value) else [value] * 2
        return {key: tuple(number(one, what) for one in pair)}
    if key == "slices":
        return {key: tuple(whole(one, what) for one in several(value, what, (2,), "the first slice, and one past the last"))}
    if key == "z":
        heights = several(value, what, (2,), "the lowest height, and the highest")
        return {"z_range_mm": tuple(_length(key, one) for one in heights)}
    if key in ("draft", "seed", "threads"):
        return {key: whole(value, what)}
    if key == "memory":
        size = _known(_core.parse_memory(value)) if isinstance(value, str) else int(number(value, what))
        return {"memory_bytes": size, "memory_given": True}
    if key == "support" and not isinstance(value, str):
        if value not in (True, False):
            raise InputError(f"{what} cannot be {short(value)}; it is True, False or the name of a material")
        return {key: "on" if value else "off"}
    if key == "crop":
        return {"crop_tray": choice(value, what, ("parts", "tray")) == "tray"}
    if key == "sampling":
        return {"sample_centres": choice(value, what, ("volume", "centre")) == "centre"}
    if key == "printer":
        return {key: known_printer(value, what)}
    if isinstance(value, (str, os.PathLike)):
        if f"--{key}" in _core.effect_options():
            return {"effects": {f"--{key}": os.fsdecode(value)}}
        return {{"process": "process_file"}.get(key, key): os.fsdecode(value)}
    raise InputError(f"{what} cannot be {short(value)}")


def _length(key: str, value: Any) -> float:
    """Returns a length in mm; a plain number is in mm already."""
    if isinstance(value, str):
        return float(_known(_core.parse_length(f"--{key.replace('_', '-')}", value)))
    return number(value, f"`{key}`")


def _known(found: Any) -> Any:
    if isinstance(found, _core.Error):
        raise_error(found)
    return found
