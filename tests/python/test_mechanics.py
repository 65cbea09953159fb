# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""`openfab.mechanics`: numpy results of the program, against closed forms."""

from __future__ import annotations

import json
from pathlib import Path

import numpy
import pytest
from conftest import TOOL

from openfab import InputError, OutsideError, mechanics

ONE = """fablet One {
    @uniform { Material stuff; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        mc.Set(stuff, 1);
        return mc;
    }
}
"""


@pytest.fixture
def bar(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A bar of 20 x 4 x 4 mm, pulled by 16 N."""
    monkeypatch.setenv("OPENFAB_PROGRAM", str(TOOL))
    (tmp_path / "one.fl").write_text(ONE)
    (tmp_path / "mechanics.json").write_text(
        json.dumps({"materials": {"stuff": {"E_MPa": 100, "nu": 0, "strength_MPa": 10, "density_g_cm3": 1}}})
    )
    world = {
        "openfab": 1,
        "printer": "generic",
        "fablets": {"one": {"source": "one.fl", "fablet": "One"}},
        "materials": {"stuff": {"key": "#23415e"}},
        "meshes": {"bar": {"box": [20, 4, 4]}},
        "objects": {"bar": {"mesh": "bar", "fablet": "one", "uniforms": {"stuff": "stuff"}}},
        "build": [{"object": "bar"}],
        "cases": {"pull": {"held": [{"side": "-x"}], "loads": [{"side": "+x", "force_N": [16, 0, 0]}]}},
    }
    file = tmp_path / "bar.fab.json"
    file.write_text(json.dumps(world))
    return file


def test_a_bar_is_stretched(bar: Path) -> None:
    result = mechanics.part(bar, "pull", voxel_mm=1)
    assert result.von_mises_MPa.shape == (4, 4, 20)
    numpy.testing.assert_allclose(result.von_mises_MPa, 1, rtol=1e-4)
    numpy.testing.assert_allclose(result.safety, 10, rtol=1e-4)
    numpy.testing.assert_allclose(result.displacement_mm[2, 2, :, 0], (numpy.arange(20) + 0.5) * 0.01, atol=1e-5)
    assert result.numbers["most_moved_mm"] == pytest.approx(0.2, rel=1e-4)
    assert result.materials == ["stuff"]


def test_it_stands(bar: Path) -> None:
    result = mechanics.stand(bar, voxel_mm=1, arguments=["--modes", "0"])
    assert result.stands
    assert result.margin_deg == pytest.approx(45)


def test_what_is_wrong_is_an_error(bar: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="there is no case `push`"):
        mechanics.part(bar, "push", voxel_mm=1)
    monkeypatch.delenv("OPENFAB_PROGRAM")
    monkeypatch.setenv("PATH", "")
    with pytest.raises(OutsideError, match="not on the PATH"):
        mechanics.part(bar, voxel_mm=1)
