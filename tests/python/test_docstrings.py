# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Every public name has a docstring with numpydoc sections: parameters, return value, exceptions, units, shapes."""

from __future__ import annotations

import dataclasses
import inspect
import re
from collections.abc import Iterator
from typing import Any

import pytest

import openfab
from openfab import mechanics

HEADING = re.compile(r"^([A-Z][A-Za-z ]+)\n-{3,}$", re.M)
SECTIONS = ("Parameters", "Attributes", "Returns", "Yields", "Raises", "Examples", "Notes")
# Arguments with a unit, which their entries must name.
UNITS = {
    r"mm": "translate|matrix|width|depth|height|diameter|low_diameter|high_diameter|section|length|vertices|points|box|low|high|"
    r"origin|spacing|pitch|layer|z|mesh_pitch|voxel|polygons?|max_displacement_mm|origin_mm|pitch_mm|voxel_mm|displacement_mm",
    r"degrees": "rotate", r"[Bb]ytes": "memory|memory_bytes", r"[Ss]econds": "seconds|workers_timeout", r"g/cm³": "density_g_cm3",
}


def sections(text: str) -> dict[str, str]:
    parts = HEADING.split(inspect.cleandoc(text))
    return {"": parts[0], **dict(zip(parts[1::2], parts[2::2]))}


def entries(text: str) -> dict[str, tuple[str, str]]:
    """Returns the names in a section, with type and text."""
    out: dict[str, tuple[str, str]] = {}
    if not text.strip():
        return out
    for block in re.split(r"\n(?=\S)", text.strip()):
        head, _, said = block.partition("\n")
        names, _, kind = head.partition(" : ")
        for name in names.split(","):
            out[name.strip().lstrip("*")] = (kind, said.strip())
    return out


def public() -> Iterator[tuple[str, Any]]:
    modules = [openfab, mechanics]
    try:
        from openfab import distributed

        modules.append(distributed)
    except ImportError:
        pass
    for module in modules:
        for name in module.__all__:
            thing = getattr(module, name)
            if not callable(thing):
                continue
            yield f"{module.__name__}.{name}", thing
            if inspect.isclass(thing):
                for member, value in vars(thing).items():
                    if not member.startswith("_") and (callable(value) or isinstance(value, (property, classmethod))):
                        yield f"{module.__name__}.{name}.{member}", value


THINGS = dict(public())


def parameters(thing: Any) -> list[str]:
    return [name for name in inspect.signature(thing).parameters if name not in ("self", "cls")]


@pytest.mark.parametrize("name", THINGS)
def test_docstring(name: str) -> None:
    thing = THINGS[name]
    function = thing.__func__ if isinstance(thing, classmethod) else thing
    text = inspect.getdoc(function) or ""
    assert text, f"{name} has no docstring"
    found = sections(text)
    summary = text.split("\n\n")[0]
    assert "\n" not in summary and summary.endswith("."), f"the summary of {name} is a line that ends in a full stop"
    assert set(found) <= {"", *SECTIONS}, f"{name} has an unknown section"
    if isinstance(function, property):
        return
    if inspect.isclass(function):
        check_class(name, function, found)
        return
    wanted = parameters(function)
    said = entries(found.get("Parameters", ""))
    assert sorted(said) == sorted(wanted) or not wanted and not said, f"{name} has {wanted}, and describes {sorted(said)}"
    check_entries(name, {**said})
    returned = inspect.signature(function).return_annotation
    assert ("Returns" in found) == (returned not in ("None", None)), f"{name} returns {returned}"
    if "NDArray" in str(returned):
        assert "shape" in found["Returns"], f"{name} does not tell the shape of what it returns"
    assert not wanted or "Raises" in found, f"{name} does not tell what it raises"


def check_class(name: str, kind: type, found: dict[str, str]) -> None:
    said = {**entries(found.get("Parameters", "")), **entries(found.get("Attributes", ""))}
    check_entries(name, said)
    fields = getattr(kind, "_fields", ())
    if dataclasses.is_dataclass(kind):
        fields = tuple(one.name for one in dataclasses.fields(kind))
    if fields:
        assert set(fields) <= set(said), f"{name} does not describe {set(fields) - set(said)}"
    elif "__init__" in vars(kind) and kind not in MADE_BY_OTHERS:
        assert set(parameters(kind.__init__)) <= set(said), f"{name} takes {parameters(kind.__init__)}"


# A function or a method makes them; their classes say which.
MADE_BY_OTHERS = (
    openfab.Print, openfab.Object, openfab.Voxels,
    mechanics.PartResult, mechanics.CellResult, mechanics.StandResult, mechanics.StrengthenResult,
)


def check_entries(name: str, said: dict[str, tuple[str, str]]) -> None:
    for entry, (kind, text) in said.items():
        whole = f"{kind} {text}"
        assert text, f"{name} says nothing of `{entry}`"
        if "array" in kind:
            assert "shape" in kind, f"{name} does not tell the shape of `{entry}`"
        for unit, names in UNITS.items():
            if re.fullmatch(names, entry) and (kind not in ("str", "int") or unit == "[Bb]ytes"):
                assert re.search(unit, whole), f"{name} does not tell the unit of `{entry}`: {unit}"


def test_those_that_others_make_say_so() -> None:
    for kind in MADE_BY_OTHERS:
        assert "makes it" in (kind.__doc__ or "").replace("`", "")
