# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Worlds as functions of 3MF (`openfab export`): lib3mf reads them, and they print the same when imported again."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import lib3mf
import numpy as np
import pytest
from conftest import Print, run
from implicit import Model

GYROID = """
fablet Body {
    @uniform { Material a, b; float cell = 6, wall = 0.47; }
    @Shape(@varying { ShapeAttributes attr })
    {
        float3 q = attr.p * (6.2831853 / cell);
        float g = dot(sin(q), cos(q.yzx));
        float sheet = (abs(g) - wall) * cell / 6.2831853;
        return max(sheet, length(attr.p) - 9);
    }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        float3 p = attr.voxelCenter;
        float t = p.z > 0 ? saturate(p.x / 9) : saturate(0.5 + 0.1 * (p.y % 3));
        mc.Set(a, t);
        mc.Set(b, 1 - t);
        return mc;
    }
}
"""
CORED = """
fablet Body {
    @uniform { Material a, b; float skin = 1.5; }
    @Shape(@varying { ShapeAttributes attr }) [[ distance ]] { return length(attr.p) - 7; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        float t = smoothstep(0.5, 1, -distance(attr.voxelCenter) / skin);
        mc.Set(a, t);
        mc.Set(b, 1 - t);
        return mc;
    }
}
"""
HOLED = """
fablet Body {
    @uniform { Material a, b; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        float3 p = attr.voxelCenter;
        if (length(p.xy - float2(3, -2)) < 2.2) return mc;
        mc.Set(p.z > 5 ? a : b, 1);
        return mc;
    }
}
"""
SKINNED = """
fablet Body {
    @uniform { Material a, b; float skin = 1; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        float t = smoothstep(0, 1, -distance(attr.voxelCenter) / skin);
        mc.Set(a, t);
        mc.Set(b, 1 - t);
        return mc;
    }
}
"""
BOX = [[-10, -10, -10], [10, 10, 10]]
SHAPE = {"shape": "body", "box_mm": BOX}


def world(folder: Path, source: str, mesh: Any, build: list[dict[str, Any]] | None = None) -> Path:
    (folder / "body.fl").write_text(source)
    file = folder / "part.fab.json"
    materials = {"hard": "#dc5050", "soft & clear": "#5050dc"}
    file.write_text(
        json.dumps(
            {
                "openfab": 1,
                "printer": "generic",
                "fablets": {"body": {"source": "body.fl", "fablet": "Body"}},
                "materials": {n: {"key": c, "preview": c + "ff"} for n, c in materials.items()},
                "meshes": {"body": mesh},
                "objects": {
                    "thing": {"mesh": "body", "fablet": "body", "uniforms": {"a": "hard", "b": "soft & clear"}}
                },
                "build": build or [{"object": "thing"}],
            }
        )
    )
    return file


def strict(file: Path) -> int:
    """Returns the number of functions that lib3mf reads in strict mode without a warning."""
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(file))
    assert reader.GetWarningCount() == 0
    functions, count = model.GetFunctions(), 0
    while functions.MoveNext():
        count += 1
    return count


def again(folder: Path, file: Path) -> Print:
    """Imports and prints a file at its old place, since an import stands on the bed."""
    made = folder / "again"
    run("import", file, "-o", made)
    read = made / f"{file.stem}.fab.json"
    text = json.loads(read.read_text())
    for one in text["build"]:
        if one.get("translate_mm") == [0, 0]:
            del one["translate_mm"]
    read.write_text(json.dumps(text))
    return Print(made, read, "")


def same(one: Print, other: Print) -> None:
    assert one.codes.shape == other.codes.shape
    order = [other.names.index(n) for n in one.names]
    assert np.abs(one.fractions - other.fractions[..., order]).max() < 2 / 65536
    recode = np.array([0] + [one.names.index(n) + 1 for n in other.names])
    assert (one.codes == recode[other.codes]).mean() > 0.9999


@pytest.mark.parametrize("composite", [False, True])
@pytest.mark.parametrize("source", [GYROID, CORED], ids=["gyroid", "cored"])
def test_shapes_come_back(tmp_path: Path, source: str, composite: bool) -> None:
    first = world(tmp_path, source, SHAPE)
    file = tmp_path / "out.3mf"
    told = run("export", first, "-o", file, *(["--composite"] if composite else []))
    assert told == ""
    if not composite:
        assert strict(file) == 1
    one = Print(tmp_path, first, "")
    same(one, again(tmp_path, file))
    # An evaluator that is neither.
    model = Model(file)
    level_set = model.objects("levelset")[0]
    # Voxels lie elsewhere than these points: their number is a volume.
    axis = np.arange(-9.75, 10, 0.5)
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    level = model.level(level_set, np.stack([x, y, z], axis=-1).reshape(-1, 3))
    assert int((level < 0).sum()) == pytest.approx(int((one.codes > 0).sum()), rel=2e-3)


def test_void_of_a_mesh_is_a_level_set(tmp_path: Path) -> None:
    first = world(tmp_path, HOLED, {"box": [12, 10, 8]}, [{"object": "thing"}, {"object": "thing", "translate_mm": [20, 0, 0]}])
    file = tmp_path / "out.3mf"
    run("export", first, "-o", file)
    assert strict(file) == 1
    one, other = Print(tmp_path, first, ""), again(tmp_path, file)
    assert one.counts() == pytest.approx(other.counts(), rel=0.02)
    assert sum(one.counts().values()) * 0.125 == pytest.approx(2 * (12 * 10 * 8 - 8 * np.pi * 2.2**2), rel=0.02)


def test_what_asks_for_distances_is_a_stack(tmp_path: Path) -> None:
    first = world(tmp_path, SKINNED, {"sphere": 5})
    file = tmp_path / "out.3mf"
    told = run("export", first, "-o", file, "--voxel", "0.5mm")
    assert "object `thing`: it asks for the distance to a surface" in told and "images" in told
    same(Print(tmp_path, first, ""), again(tmp_path, file))


def test_beams_are_a_lattice(tmp_path: Path) -> None:
    (tmp_path / "truss.txt").write_text(
        "node 0 0 0 2\nnode 12 0 0 2\nnode 12 9 0 2\nstrut 0 1\nstrut 1 2\nball 2\n"
    )
    source = "fablet Body { @uniform { Material a, b; } @Volume(@varying { VolumeAttributes attr }) " \
        "{ MaterialComposition mc; mc.Set(a, 1); return mc; } }"  # fmt: skip
    first = world(tmp_path, source, {"beams": "truss.txt"})
    file = tmp_path / "out.3mf"
    run("export", first, "-o", file)
    assert strict(file) == 0
    one, other = Print(tmp_path, first, ""), again(tmp_path, file)
    assert sum(one.counts().values()) == pytest.approx(sum(other.counts().values()), rel=0.01)


def test_several_placements_share_an_object(tmp_path: Path) -> None:
    places = [{"object": "thing"}, {"object": "thing", "translate_mm": [25, 0, 0], "rotate_deg": [0, 0, 30]}]
    first = world(tmp_path, CORED, SHAPE, places)
    file = tmp_path / "out.3mf"
    run("export", first, "-o", file)
    assert strict(file) == 1
    one, other = Print(tmp_path, first, ""), again(tmp_path, file)
    assert one.counts() == pytest.approx(other.counts(), rel=0.01)
