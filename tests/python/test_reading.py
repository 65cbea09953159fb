# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Prints read back from files as arrays."""

from __future__ import annotations

import pickle
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import openfab

OUTPUTS = {"ofr": "ball.ofr", "npy": "ball.npy", "png": "slices", "bmp": "bitmaps"}


def written(world: openfab.World, folder: Path, format: str, **options: Any) -> Path:
    out = folder / OUTPUTS[format]
    openfab.print_world(world, out, format=format, **{"voxel": (0.1, 0.2, 0.3), "seed": 5, **options})
    return out


@pytest.fixture
def codes(ball: openfab.World) -> Any:
    return openfab.print_world(ball, voxel=(0.1, 0.2, 0.3), seed=5).array()


@pytest.mark.parametrize("format", OUTPUTS)
def test_what_was_written_is_read(ball: openfab.World, tmp_path: Path, format: str, codes: Any) -> None:
    found = openfab.read(written(ball, tmp_path, format))
    assert isinstance(found, openfab.Voxels)
    assert found.shape == codes.shape and len(found) == len(codes) and found.is_complete
    assert np.array_equal(np.asarray(found), codes) and np.asarray(found, np.int64).dtype == np.int64
    said = openfab.print_world(ball, voxel=(0.1, 0.2, 0.3)).info
    assert found.info.size == said.size and found.info.slices == said.slices
    assert np.allclose(found.info.pitch_mm, said.pitch_mm) and np.allclose(found.info.origin_mm, said.origin_mm)
    assert [one.name for one in found.info.materials] == ["white", "black"]
    assert found.info.materials[1].key == (0, 0, 0, 255)
    for _ in range(2):
        assert all(np.array_equal(one.codes, codes[one.z]) for one in found)
    assert found.hash == openfab.print_world(ball, tmp_path / "x.ofr", voxel=(0.1, 0.2, 0.3), seed=5).statistics["hash"]


@pytest.mark.parametrize("format", ["ofr", "npy"])
def test_indices_are_those_of_numpy(ball: openfab.World, tmp_path: Path, format: str, codes: Any) -> None:
    found = openfab.read(written(ball, tmp_path, format))
    keys: list[Any] = [
        3, -1, np.int64(2), slice(None), slice(2, 7), slice(None, None, -1), slice(15, 3, -4), slice(5, 5), ..., (),
        (3, 4), (3, 4, 5), (-3, -4, -5), (slice(1, 4), 7), (..., 6), (2, ...), (slice(2, 9, 3), slice(20, 3, -2), slice(1, 50, 7)),
        (slice(None), slice(None, None, -1), slice(None, None, -1)), (0, slice(4, 1), 3), (slice(100, 200), ...),
    ]
    for key in keys:
        there, here = found[key], codes[key]
        assert np.array_equal(there, here) and np.shape(there) == np.shape(here), key


@pytest.mark.parametrize(
    ("key", "kind", "text"),
    [
        (1000, IndexError, "index 1000 along z is beyond the 20 that ball.ofr has"),
        ((0, -31), IndexError, "index -31 along y"),
        ((0, 0, 60), IndexError, "index 60 along x"),
        ((0, 0, 0, 0), openfab.InputError, "more than the three axes"),
        ((..., 0, ...), openfab.InputError, "more than the three axes"),
        (1.5, openfab.InputError, "along z cannot be 1.5"),
        ([1, 2], openfab.InputError, "cannot be an index along z"),
        (slice("a"), openfab.InputError, "along z is no slice"),
    ],
)
def test_bounds_are_checked(ball: openfab.World, tmp_path: Path, key: Any, kind: Any, text: str) -> None:
    found = openfab.read(written(ball, tmp_path, "ofr"))
    assert found.shape == (20, 30, 60)  # type: ignore[union-attr]
    with pytest.raises(kind, match=text):
        found[key]  # type: ignore[index]


def test_a_box_in_millimetres(ball: openfab.World, tmp_path: Path, codes: Any) -> None:
    found = openfab.read(written(ball, tmp_path, "ofr"))
    assert isinstance(found, openfab.Voxels)
    x0, y0, z0 = found.info.origin_mm
    box = found.box((x0 + 0.5, y0 + 0.4, z0 + 0.6), (x0 + 1.21, y0 + 1, z0 + 1.8))
    assert np.array_equal(box.codes, codes[2:6, 2:5, 5:13])
    assert np.allclose(box.origin_mm, (x0 + 0.5, y0 + 0.4, z0 + 0.6)) and box.materials == found.info.materials
    every = found.box(found.info.origin_mm, np.array([6, 6, 6]) + found.info.origin_mm)
    assert np.array_equal(every.codes, codes)
    with pytest.raises(openfab.InputError, match="beyond the voxels, which are from 0 to 6 mm along z"):
        found.box((x0, y0, z0 - 0.1), (x0 + 1, y0 + 1, z0 + 1))
    assert np.array_equal(pickle.loads(pickle.dumps(found))[3], codes[3])  # which opens the file again
    with pytest.raises(openfab.InputError, match="is none; give its lowest and its highest corner"):
        found.box((0, 0, 1), (1, 1, 1))


def test_some_slices_know_their_place(ball: openfab.World, tmp_path: Path, codes: Any) -> None:
    for format in OUTPUTS:
        found = openfab.read(written(ball, tmp_path, format, slices=(7, 12)))
        assert isinstance(found, openfab.Voxels)
        assert found.shape[0] == 5 and found.info.slices == (7, 12) and [one.z for one in found] == [7, 8, 9, 10, 11]
        assert np.array_equal(found[...], codes[7:12])
        low, pitch = np.array(found.info.origin_mm), np.array(found.info.pitch_mm)
        box = found.box(low + (0, 0, 8) * pitch, low + (60, 30, 10) * pitch)
        assert np.array_equal(box.codes, codes[8:10])


def test_fractions_are_read(ball: openfab.World, tmp_path: Path, tool: Any) -> None:
    world = tmp_path / "ball.fab.json"
    (tmp_path / "ball.fl").write_text(ball.objects["ball"].fablet.text or "")
    import json

    said = ball.to_json()
    said["fablets"]["Ball"]["source"] = "ball.fl"
    world.write_text(json.dumps(said))
    tool(world, "-o", str(tmp_path / "x.ofr"), "--voxel", "0.5mm", "--fractions", str(tmp_path / "mix.npy"), "--sampling", "centre")
    found = openfab.read(tmp_path / "mix.npy")
    assert isinstance(found, openfab.Samples)
    one = openfab.print_world(ball, voxel=0.5, fractions=True)
    every = np.stack([slice.fractions for slice in one])
    assert np.array_equal(found.fractions, every) and np.allclose(found.origin_mm, one.info.origin_mm)
    middle = np.array(found.origin_mm) + 3
    assert found.at([middle]).shape == (1, 2) and found.mean({"white": 1, "black": 0}).shape == every.shape[:3]


def test_a_file_that_was_cut_short(ball: openfab.World, tmp_path: Path, codes: Any) -> None:
    file = written(ball, tmp_path, "ofr")
    data = file.read_bytes()
    file.write_bytes(data[: len(data) // 2])
    found = openfab.read(file)
    assert isinstance(found, openfab.Voxels)
    assert 0 < len(found) < len(codes) and not found.is_complete and "not complete" in repr(found)
    assert np.array_equal(found[...], codes[: len(found)])
    # One slice is damaged: the others are read.
    file.write_bytes(data[:1200] + bytes([data[1200] ^ 255]) + data[1201:])
    found = openfab.read(file)
    good = 0
    for place in range(len(codes)):
        try:
            good += int(np.array_equal(found[place], codes[place]))  # type: ignore[index]
        except openfab.InputError as error:
            assert f"slice {place}" in str(error)
    assert good == len(codes) - 1


@pytest.mark.parametrize(
    ("name", "content", "text"),
    [
        ("none.ofr", None, "cannot open"), ("none.npy", None, "cannot open"), ("x.ofr", b"hello", "not an .ofr file"),
        ("x.npy", b"hello", "no array of numpy"), ("folder", None, "cannot open"),
    ],
)
def test_what_is_no_print_is_an_error(tmp_path: Path, name: str, content: bytes | None, text: str) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(openfab.InputError, match=text):
        openfab.read(tmp_path / name)


def test_arrays_of_others_are_errors(ball: openfab.World, tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    with pytest.raises(openfab.InputError, match="manifest"):
        openfab.read(tmp_path / "empty")
    np.save(tmp_path / "x.npy", np.zeros((2, 3, 4)))
    with pytest.raises(openfab.InputError, match="x.npy.json"):
        openfab.read(tmp_path / "x.npy")
    file = written(ball, tmp_path, "npy")
    shutil.copy(str(file) + ".json", tmp_path / "x.npy.json")
    with pytest.raises(openfab.InputError, match="neither codes nor fractions"):
        openfab.read(tmp_path / "x.npy")
    (tmp_path / "x.npy.json").write_text("[]")
    with pytest.raises(openfab.InputError, match="not what OpenFab writes"):
        openfab.read(tmp_path / "x.npy")
    with pytest.raises(openfab.InputError, match="`memory`"):
        openfab.read(written(ball, tmp_path, "ofr"), memory=100)


def test_a_file_is_shown_in_a_notebook(ball: openfab.World, tmp_path: Path) -> None:
    shown = openfab.read(written(ball, tmp_path, "ofr"))._repr_html_()  # type: ignore[union-attr]
    assert "60 × 30 × 20 voxels" in shown and shown.count("data:image/png") > 10
