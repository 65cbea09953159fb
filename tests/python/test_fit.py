# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""`openfab.fit`: what it finds, against closed forms and SciPy's root where it is installed."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from conftest import TOOL

import openfab

BALL = """fablet Ball {
    @uniform { float skin = 0.5; Material core, shell; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        float t = smoothstep(0.5, 1, -distance(attr.voxelCenter) / skin);
        mc.Set(core, t);
        mc.Set(shell, 1 - t);
        return mc;
    }
}
"""


@pytest.fixture
def ball(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A ball of 12 mm with a skin."""
    monkeypatch.setenv("OPENFAB_PROGRAM", str(TOOL))
    (tmp_path / "ball.fl").write_text(BALL)
    world = {
        "openfab": 1,
        "printer": "j750",
        "fablets": {"ball": {"source": "ball.fl", "fablet": "Ball"}},
        "materials": {"white": {"key": "#ffffff"}, "black": {"key": "#000000"}},
        "meshes": {"sphere": {"sphere": 12}},
        "objects": {"ball": {"mesh": "sphere", "fablet": "ball", "uniforms": {"core": "white", "shell": "black"}}},
        "build": [{"object": "ball"}],
    }
    file = tmp_path / "ball.fab.json"
    file.write_text(json.dumps(world))
    return file


GOALS = {"unknowns": {"ball.skin": {"min": 0.1, "max": 5}}, "goals": [{"share": "black", "equal": 0.3}]}


def share_of_black(world: Path, uniforms: dict[str, float]) -> float:
    """Of a print, counted."""
    codes = openfab.print_world(openfab.load(world), draft=2, uniforms=uniforms).array()
    return float((codes == 2).sum() / (codes != 0).sum())


def test_a_share_is_found_and_printed(ball: Path, tmp_path: Path) -> None:
    found = openfab.fit(ball, GOALS, tmp_path / "fitted.fab.json")
    assert found.reached
    (goal,) = found.goals
    assert (goal.name, goal.at_least, goal.at_most) == ("share of black", 0.3, 0.3)
    assert goal.mixtures == pytest.approx(0.3, abs=3e-4)
    assert goal.printed == pytest.approx(0.3, abs=3e-4)
    assert share_of_black(ball, found.uniforms) == pytest.approx(0.3, abs=1e-3)
    assert share_of_black(tmp_path / "fitted.fab.json", {}) == pytest.approx(0.3, abs=1e-3)


def test_it_is_the_root_that_scipy_finds(ball: Path) -> None:
    optimize = pytest.importorskip("scipy.optimize")
    root = optimize.brentq(lambda skin: share_of_black(ball, {"ball.skin": skin}) - 0.3, 0.1, 5, xtol=1e-4)
    assert openfab.fit(ball, GOALS).uniforms["ball.skin"] == pytest.approx(root, rel=2e-3)


def test_what_is_not_reached_is_no_error(ball: Path) -> None:
    goals = {"unknowns": {"ball.skin": {"min": 0.1, "max": 0.2}}, "goals": GOALS["goals"]}
    found = openfab.fit(ball, goals, arguments=["--draft", "3"])
    assert not found.reached
    assert not found.goals[0].reached
    assert found.uniforms["ball.skin"] == pytest.approx(0.2)


def test_errors_have_their_place(ball: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(openfab.InputError, match="did you mean `skin`"):
        openfab.fit(ball, {"unknowns": {"ball.skn": {"min": 0, "max": 1}}, "goals": GOALS["goals"]})
    monkeypatch.delenv("OPENFAB_PROGRAM")
    monkeypatch.setenv("PATH", "")
    with pytest.raises(openfab.OutsideError, match="OPENFAB_PROGRAM"):
        openfab.fit(ball, GOALS)
