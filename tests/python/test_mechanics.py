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


LAYERS = """fablet Layers {
    @uniform { Material stiff, soft; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        mc.Set(attr.voxelCenter[2] < 2 ? stiff : soft, 1);
        return mc;
    }
}
"""


def test_scikit_fem_moves_it_as_we_do(bar: Path) -> None:
    """Two layers of fully integrated hexahedra, bent and twisted, have the same displacements."""
    fem = pytest.importorskip("skfem")
    helpers = pytest.importorskip("skfem.helpers")
    materials = {"stiff": (2000.0, 0.35), "soft": (50.0, 0.45)}
    (bar.parent / "one.fl").write_text(LAYERS)
    (bar.parent / "mechanics.json").write_text(
        json.dumps({"materials": {name: {"E_MPa": e, "nu": nu} for name, (e, nu) in materials.items()}})
    )
    world = json.loads(bar.read_text())
    world["fablets"]["one"]["fablet"] = "Layers"
    world["materials"] = {"stiff": {"key": "#23415e"}, "soft": {"key": "#e0e0e0"}}
    world["objects"]["bar"]["uniforms"] = {"stiff": "stiff", "soft": "soft"}
    world["cases"]["pull"]["loads"][0]["force_N"] = [1, -2, 3]
    bar.write_text(json.dumps(world))
    ours = mechanics.part(bar, voxel_mm=1, arguments=["--full", "--tolerance", "1e-9"])

    mesh = fem.MeshHex.init_tensor(numpy.arange(21.0), numpy.arange(5.0), numpy.arange(5.0))
    basis = fem.Basis(mesh, fem.ElementVector(fem.ElementHex1()), intorder=2)
    middles = mesh.p[:, mesh.t].mean(axis=1)
    lame = [
        [e * nu / ((1 + nu) * (1 - 2 * nu)), e / (2 * (1 + nu))]
        for e, nu in (materials["stiff" if z < 2 else "soft"] for z in middles[2])
    ]
    one = basis.with_element(fem.ElementHex0())
    lam, mu = (one.interpolate(values) for values in numpy.array(lame).T)

    @fem.BilinearForm
    def stiffness(u, v, w):  # type: ignore[no-untyped-def]
        e, f = helpers.sym_grad(u), helpers.sym_grad(v)
        return w.lam * helpers.trace(e) * helpers.trace(f) + 2 * w.mu * helpers.ddot(e, f)

    @fem.LinearForm
    def pull(v, w):  # type: ignore[no-untyped-def]
        return (v[0] - 2 * v[1] + 3 * v[2]) / 16

    ends = fem.FacetBasis(mesh, basis.elem, facets=mesh.facets_satisfying(lambda x: x[0] == 20))
    held = basis.get_dofs(lambda x: x[0] == 0)
    matrix, forces = stiffness.assemble(basis, lam=lam, mu=mu), pull.assemble(ends)
    moved = fem.solve(*fem.condense(matrix, forces, D=held))[basis.nodal_dofs]
    theirs = numpy.zeros_like(ours.displacement_mm)
    x, y, z = middles.astype(int)
    theirs[z, y, x] = moved[:, mesh.t].mean(axis=1).T
    assert numpy.abs(theirs).max() > 0.01
    assert numpy.abs(theirs - ours.displacement_mm).max() < 1e-4 * numpy.abs(theirs).max()


def test_a_bar_conducts(bar: Path) -> None:
    world = json.loads(bar.read_text())
    world["cases"] = {"sense": {"held": [{"side": "-x", "volt": 0}, {"side": "+x", "volt": 5}]}}
    bar.write_text(json.dumps(world))
    with pytest.raises(InputError, match="has no `conductivity_S_m`"):
        mechanics.conduct(bar, voxel_mm=1)
    with pytest.raises(InputError, match="is of current"):
        mechanics.part(bar, voxel_mm=1)
    # What only conducts needs no modulus.
    bar.with_name("mechanics.json").write_text('{"materials": {"stuff": {"conductivity_S_m": 25}}}')
    result = mechanics.conduct(bar, voxel_mm=1)
    ohm = 20 / (25e-3 * 16)
    assert result.numbers["resistance_ohm"] == pytest.approx(ohm, rel=1e-5)
    numpy.testing.assert_allclose(result.level[2, 2], (numpy.arange(20) + 0.5) / 4, atol=1e-5)
    numpy.testing.assert_allclose(result.density, 5 / ohm / 16, rtol=1e-4)


def test_it_stands(bar: Path) -> None:
    result = mechanics.stand(bar, voxel_mm=1, arguments=["--modes", "0"])
    assert result.stands
    # The foot is looked at in voxels of its own, whose edge may be half of one within the part's.
    assert result.margin_deg == pytest.approx(45, abs=0.5)


def test_what_is_wrong_is_an_error(bar: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="there is no case `push`"):
        mechanics.part(bar, "push", voxel_mm=1)
    monkeypatch.setenv("OPENFAB_PROGRAM", str(bar.with_name("no_such_program")))
    with pytest.raises(OutsideError, match="no_such_program"):
        mechanics.part(bar, voxel_mm=1)


def test_the_packages_own_program_prints_the_same(bar: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    by_tool = mechanics.part(bar, voxel_mm=1)
    monkeypatch.delenv("OPENFAB_PROGRAM")
    monkeypatch.setenv("PATH", "/usr/bin:/bin")
    by_package = mechanics.part(bar, voxel_mm=1)
    assert by_package.numbers == by_tool.numbers
    numpy.testing.assert_array_equal(by_package.von_mises_MPa, by_tool.von_mises_MPa)
    assert mechanics.stand(bar, voxel_mm=1, arguments=["--modes", "0"]).stands
    # A fablet alone is compiled, too.
    cell = mechanics.cell(bar.with_name("one.fl"), "2mm", voxel_mm=0.5)
    assert cell.numbers["young_MPa"] == pytest.approx([100, 100, 100], rel=1e-3)
    bar.with_name("wrong.fl").write_text("fablet Wrong {")
    with pytest.raises(InputError, match="wrong.fl"):
        mechanics.cell(bar.with_name("wrong.fl"), "2mm", voxel_mm=0.5)
