# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Files written by `openfab print` are read back: voxel for voxel, and by other programs' readers."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import lib3mf
import numpy as np
import pytest
from conftest import TOOL, Print, run

FABLET = """fablet Layers {
    @uniform { Material low, middle, high; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        float3 p = attr.voxelCenter;
        mc.Set(p.z < 2 ? low : (p.x < 4 ? middle : high), 1);
        return mc;
    }
}
"""


@pytest.fixture
def layers(tmp_path) -> Path:
    """Returns a box of three materials that meet at an edge."""
    (tmp_path / "layers.fl").write_text(FABLET)
    path = tmp_path / "layers.fab.json"
    materials = {"low": "#ff0000", "middle": "#00ff00", "high": "#0000ff"}
    path.write_text(
        json.dumps(
            {
                "openfab": 1,
                "printer": "generic",
                "fablets": {"l": {"source": "layers.fl", "fablet": "Layers"}},
                "materials": {name: {"key": key} for name, key in materials.items()},
                "meshes": {"m": {"extrusion": {"polygons": [[[0, 0], [8, 0], [8, 6], [0, 6]]], "height": 4}}},
                "objects": {"o": {"mesh": "m", "fablet": "l", "uniforms": {name: name for name in materials}}},
                "build": [{"object": "o"}],
            }
        )
    )
    return path


def names(made: Print) -> np.ndarray:
    """Returns the name of each voxel's material."""
    return np.array(["", *made.names])[made.codes]


def expected() -> np.ndarray:
    out = np.full((8, 12, 16), "high", dtype="<U6")
    out[:, :, :8] = "middle"
    out[:4] = "low"
    return out


def test_3mf_of_three_materials(tmp_path, layers, imported):
    assert (names(Print(tmp_path, layers, "")) == expected()).all()
    run("print", layers, "-o", tmp_path / "out.3mf", "--mesh-pitch", "0.5mm")
    made = imported(tmp_path / "out.3mf")
    assert made.codes.shape == (8, 12, 16)
    assert (names(made) == expected()).all()


def test_3mf_is_fine_for_lib3mf(tmp_path, layers):
    run("print", layers, "-o", tmp_path / "out.3mf", "--mesh-pitch", "0.5mm")
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(tmp_path / "out.3mf"))
    assert reader.GetWarningCount() == 0
    meshes = model.GetMeshObjects()
    found = 0
    while meshes.MoveNext():
        assert meshes.GetCurrentMeshObject().IsManifoldAndOriented()
        found += 1
    assert found == 3


def test_fractions_as_npy_are_a_volume(tmp_path, layers):
    first = Print(tmp_path, layers, "")
    world = json.loads(layers.read_text())
    (tmp_path / "again.fl").write_text(
        """fablet Again {
    @uniform { ImageTexture3D field; Material one, other; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        float t = field.Sample1(attr.voxelCenter, 0, 0);
        mc.Set(one, t);
        mc.Set(other, 1 - t);
        return mc;
    }
}
"""
    )
    low = first.fractions[..., first.names.index("low")]
    np.save(tmp_path / "low.npy", low)
    world["fablets"] = {"l": {"source": "again.fl", "fablet": "Again"}}
    world["textures"] = {
        "t": {"file": "low.npy", "origin_mm": [0, 0, 0], "spacing_mm": 0.5, "wrap": "clamp", "filter": "nearest"}
    }
    world["objects"]["o"]["uniforms"] = {"field": "t", "one": "low", "other": "high"}
    layers.write_text(json.dumps(world))
    again = Print(tmp_path, layers, "")
    assert (again.fractions[..., again.names.index("low")] == low).all()


def test_vdb_of_fractions_is_a_volume(tmp_path, layers):
    out = tmp_path / "mix.vdb"
    run("print", layers, "-o", tmp_path / "print.npy", "--fractions", tmp_path / "mix.npy", "--voxel", "0.5mm")
    done = subprocess.run([TOOL, "export", tmp_path / "mix.npy", "-o", out], capture_output=True, text=True)
    if done.returncode != 0 and "--vdb" in done.stderr:
        pytest.skip("this build has no OpenVDB")
    assert done.returncode == 0, done.stderr
    run("texture", "--volume", out, "--field", "low", "-o", tmp_path / "low.oftx")
