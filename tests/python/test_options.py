# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Options of prints: the fields of program::Options, their checks, and their names in messages."""

from __future__ import annotations

import inspect
import re
from pathlib import Path
from typing import Any

import pytest

import openfab
from openfab import _core
from openfab._options import SharedArguments, fields_of, options_of
from openfab.errors import worded

PROGRAM = Path(__file__).parents[2] / "program"

# Fields that Python does not set, and why.
REASONS = {
    "probe_mm": "`sample` has boxes of voxels",
    "part": "`slices` says it",
    "words": "what a command line gave, for the record beside its output; a print from Python has none",
    "slab_limit_seconds": "whoever waits for the print interrupts it",
    "no_cache": "OPENFAB_NO_CACHE says it",
    "resume": "an output of Python is there once it is complete",
    "any_pitch": "a print says its pitch",
    "stats_file": "`Print.statistics` has them",
    "fractions_file": "slices have them, and `sample` gives them",
    "more_outputs": "files of a host that is a program",
    "progress": "a bar or a function of Python's shows it",
    "extents_file": "for tools beside the print",
    "only_object": "for tools beside the print",
    "as_built": "for tools beside the print",
    "altered": "for tools beside the print",
    "estimate": "the target of a print says it",
    "dry_run": "the target of a print says it",
    "isa": "kernels are compiled for this machine, in this process",
    "help": "of the command line",
    "text": "of the command line",
}
# A value of each field that is not the default.
VALUES: dict[str, Any] = {
    "voxel_mm": 0.5, "dpi": (600.0, 300.0), "layer_mm": 0.25, "mesh_pitch_mm": 0.125, "pitch_mm": (0.5, 0.25, 0.125),
    "draft": 4, "z_range_mm": (1.0, 2.5), "slices": (2, 8), "crop_tray": True, "output": "a.ofr", "format": "ofr",
    "token_file": "token", "tls_ca": "ca.pem", "png_indexed": True, "grey_material": "white", "flip_x": True,
    "fractions_supersample": 2, "sample_centres": True, "inputs": ["a.obj"], "memory_bytes": 300_000_000,
    "memory_given": True, "threads": 2, "culling": False, "slabs_in_flight": 3, "input": "w.fab.json", "allow": ["meshes"],
    "settings": ["ball.skin=1"], "printer": "j750", "process_file": "p.json", "effects": {"--bleed": "show", "--nozzles": "n.json"},
    "support": "off", "dither": "own", "seed": 2**64 - 1, "previews": [],
}


def fields() -> list[str]:
    """The fields of Options, as the headers declare them."""
    found = []
    for header in ("grid_options.h", "output_options.h", "run_options.h", "options.h"):
        text = re.sub(r"//.*", "", (PROGRAM / header).read_text())
        (body,) = re.findall(r"^struct \w*Options\b[^{;]*\{\n(.*?)^\};", text, re.S | re.M)
        found += re.findall(r"^    [\w:<>, ]+ (\w+)(?: =\s[^;]*)?;", body, re.M)
        assert len(re.findall(";", body)) == len(re.findall(r"^    [\w:<>, ]+ (\w+)(?: =\s[^;]*)?;", body, re.M)), header
    return found


def test_every_field_can_be_set_or_has_a_reason() -> None:
    declared = fields()
    assert len(declared) > 40 and len(set(declared)) == len(declared)
    assert sorted(declared) == sorted([*VALUES, *REASONS])
    for name in REASONS:
        assert not hasattr(_core.Options, name), f"`{name}` can be set, so it needs no reason"


@pytest.mark.parametrize("name", VALUES)
def test_a_field_keeps_its_value(name: str) -> None:
    options = _core.Options()
    before = getattr(options, name)
    assert name == "previews" or before != VALUES[name]
    setattr(options, name, VALUES[name])
    found = getattr(options, name)
    assert (tuple(found) if isinstance(VALUES[name], tuple) else found) == VALUES[name]


def test_a_field_that_is_none_is_refused() -> None:
    with pytest.raises(AttributeError):
        options_of({"voxels_mm": 1})


def test_arguments_become_fields() -> None:
    assert fields_of(voxel=(0.5, 0.25, 0.125)) == {"dpi": (50.8, 101.6), "layer_mm": 0.125}
    assert fields_of(voxel="1cm", z=(1, "4mm"), dpi="600x300", memory="1GB", crop="tray") == {
        "voxel_mm": 10.0, "z_range_mm": (1.0, 4.0), "dpi": (600.0, 300.0), "memory_bytes": 1_000_000_000,
        "memory_given": True, "crop_tray": True,
    }
    assert fields_of(process=Path("p.json"), support=False, draft=None) == {"process_file": "p.json", "support": "off"}


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"voxel": 200}, '`voxel`: `200mm` is outside 0.1um to 100mm; write `voxel="0.1mm"`'),
        ({"voxel": 1, "layer": 1}, "`voxel` and `dpi`/`layer` both set the pitch; give one of them"),
        ({"slices": (5, 5)}, '`slices`: `5:5` is an empty or negative range; write `slices=(0, 64)`'),
        ({"draft": 0}, "`draft`: `0` is not a whole number from 1 to 1000; write `draft=4`"),
        ({"format": "jpeg"}, "there is no output format `jpeg`; choose from"),
        ({"seed": -1}, "`seed` cannot be -1; the number is out of range"),
        ({"draft": 2**40}, "`draft` cannot be 1099511627776; the number is out of range"),
    ],
)
def test_wrong_values_are_told_as_of_arguments(arguments: dict[str, Any], text: str) -> None:
    with pytest.raises(openfab.InputError) as caught:
        options_of(fields_of(**arguments))
    assert str(caught.value).startswith(text)


@pytest.mark.parametrize(
    ("said", "expected"),
    [
        ("`--mesh-pitch` is for 3mf", "`mesh_pitch` is for 3mf"),
        ("give `--dpi 600x600 --layer 30um`", 'give `dpi="600x600", layer="30um"`'),
        ("`-o my file.png`: no; write `-o my file --format png`", '`out="my file.png"`: no; write `out="my file", format="png"`'),
        ("write `--z 3mm:5mm`", 'write `z=("3mm", "5mm")`'),
        ("write `--set OBJECT.UNIFORM=VALUE`", 'write `uniforms={"OBJECT.UNIFORM": VALUE}`'),
        ("`openfab export --flip-x` and `--resume`", "`openfab export --flip-x` and `--resume`"),
    ],
)
def test_options_are_called_as_arguments(said: str, expected: str) -> None:
    assert worded(said) == expected


def test_a_print_over_machines_shares_arguments() -> None:
    over = pytest.importorskip("openfab.distributed")
    here = inspect.signature(openfab.print_world).parameters
    there = inspect.signature(over.print_world).parameters
    assert set(SharedArguments.__annotations__) < set(there) and "arguments" not in there
    for name, annotation in SharedArguments.__annotations__.items():
        assert there[name] == here[name]
        assert getattr(annotation, "__forward_arg__", annotation) == here[name].annotation
