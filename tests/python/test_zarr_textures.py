# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Stores of Zarr as textures: what zarr-python writes prints as numpy's own file of the same numbers."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from conftest import BY_VOLUME, TOOL

zarr = pytest.importorskip("zarr")
pytest.importorskip("zarr.codecs")
import numcodecs  # noqa: E402
from zarr.codecs import BloscCodec, BytesCodec, Crc32cCodec, GzipCodec, TransposeCodec, ZstdCodec  # noqa: E402

SHAPE = (23, 19, 26)
CHUNKS = (5, 8, 6)


def numbers(kind: str) -> Any:
    """Random ones, and zeros that fill whole chunks, which zarr-python leaves out."""
    random = np.random.default_rng(5)
    values = (random.random(SHAPE) * (1 if kind.startswith("f") else 250 * 256 ** (np.dtype(kind).itemsize - 1))).astype(kind)
    values[:10, :, :12] = 0
    return values


def codes_of(folder: Path, texture: str, *options: str, **keys: Any) -> Any:
    """Of a print whose part is turned in the volume."""
    (folder / "field.fl").write_text(BY_VOLUME)
    uniforms = {"field": "field", "one": "a", "other": "b"}
    world = {
        "openfab": 1,
        "printer": "generic",
        "fablets": {"field": {"source": "field.fl", "fablet": "ByVolume"}},
        "materials": {"a": {"key": "#ffffff"}, "b": {"key": "#000000"}},
        "textures": {"field": {"file": texture, "wrap": "clamp", "filter": "trilinear", **keys}},
        "meshes": {"box": {"box": [24, 16, 20]}},
        "objects": {"box": {"mesh": "box", "fablet": "field", "uniforms": uniforms}},
        "build": [{"object": "box", "rotate_deg": [10, 20, 30]}],
    }
    path = folder / "box.fab.json"
    path.write_text(json.dumps(world))
    command = [TOOL, "print", path, "-o", folder / "codes.npy", "--voxel", "0.5mm", "--progress", "none", *options]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return np.load(folder / "codes.npy")


COMPRESSORS = {
    "none": (None, None),
    "zstd": (ZstdCodec(level=1, checksum=True), numcodecs.Zstd(3)),
    "gzip": (GzipCodec(level=5), numcodecs.GZip(5)),
    "zlib": (None, numcodecs.Zlib(1)),
    "crc32c": (Crc32cCodec(), None),
    "blosc": (BloscCodec(cname="lz4", shuffle="shuffle"), numcodecs.Blosc("zstd", 3, numcodecs.Blosc.BITSHUFFLE)),
}


@pytest.mark.parametrize("codec", COMPRESSORS)
@pytest.mark.parametrize("kind", ["u1", "u2", "f4"])
def test_prints_are_those_of_numpys_file(tmp_path: Path, kind: str, codec: str) -> None:
    values = numbers(kind)
    np.save(tmp_path / "v.npy", values)
    three, two = COMPRESSORS[codec]
    zarr.create_array(tmp_path / "a.zarr", data=values, chunks=CHUNKS, compressors=three, zarr_format=3)
    zarr.create_array(
        tmp_path / "b.zarr", data=values, chunks=CHUNKS, shards=(10, 24, 12), compressors=three, zarr_format=3,
        serializer=BytesCodec(endian="big"),
    )
    zarr.create_array(
        tmp_path / "c.zarr", data=values, chunks=CHUNKS, compressors=three, zarr_format=3,
        filters=TransposeCodec(order=(1, 2, 0)),
    )
    big = values.astype(np.dtype(kind).newbyteorder(">"))
    zarr.create_array(tmp_path / "d.zarr", data=big, chunks=CHUNKS, compressors=two, order="F", zarr_format=2)
    missing = [path for path in (tmp_path / "a.zarr").glob("c/0/*/0")]
    assert not missing, "chunks of zeros are left out"
    expected = codes_of(tmp_path, "v.npy")
    assert len(np.unique(expected)) == 3
    for store in ("a", "b", "c", "d"):
        try:
            codes = codes_of(tmp_path, f"{store}.zarr")
        except AssertionError as error:
            if codec == "blosc" and "scripts/setup --blosc" in str(error):
                pytest.skip("built without Blosc")
            raise
        assert (codes == expected).all(), store
    assert (codes_of(tmp_path, "d.zarr", "--threads", "1", "--memory", "60MB") == expected).all()


def test_a_print_is_its_own_texture(tmp_path: Path) -> None:
    """The codes of a store, by its shards or by zarr's rules, are those of the same print as an array."""
    np.save(tmp_path / "v.npy", numbers("u1"))
    codes = codes_of(tmp_path, "v.npy")
    np.save(tmp_path / "codes_as_numbers.npy", codes.astype("f4"))
    world = tmp_path / "box.fab.json"
    command = [TOOL, "print", world, "-o", tmp_path / "p.zarr", "--voxel", "0.5mm"]
    subprocess.run([str(word) for word in command], check=True, capture_output=True)
    place = {"origin_mm": [0, 0, 0], "spacing_mm": 0.5, "filter": "nearest"}
    expected = codes_of(tmp_path, "codes_as_numbers.npy", **place)
    assert (codes_of(tmp_path, "p.zarr", **place) == expected).all()
    assert (codes_of(tmp_path, "p.zarr", field="0", **place) == expected).all()


def test_a_large_store_is_read_by_its_coarser_level(tmp_path: Path) -> None:
    """64 GB of numbers in all, most of whose chunks are links to one, at the pitch of the print, in 300 MB."""
    store = tmp_path / "s.zarr"
    group = zarr.open_group(store, mode="w", zarr_format=3)
    sides = [4096 >> level for level in range(6)]
    datasets = []
    for level, side in enumerate(sides):
        chunk = min(side, 256)
        array = group.create_array(str(level), shape=(side,) * 3, chunks=(chunk,) * 3, dtype="u1", compressors=ZstdCodec(level=1))
        array[:chunk, :chunk, :chunk] = 40 * level + 20
        folder = store / str(level) / "c"
        for z in range(side // chunk):
            for y in range(side // chunk):
                for x in range(side // chunk):
                    file = folder / str(z) / str(y) / str(x)
                    file.parent.mkdir(parents=True, exist_ok=True)
                    if not file.exists():
                        file.symlink_to(folder / "0" / "0" / "0")
        scale = 24 / side
        datasets.append({"path": str(level), "coordinateTransformations": [{"type": "scale", "scale": [scale] * 3}]})
    axes = [{"name": name, "type": "space", "unit": "millimeter"} for name in "zyx"]
    group.attrs["ome"] = {"version": "0.5", "multiscales": [{"axes": axes, "datasets": datasets}]}
    coarse = np.full((128,) * 3, 40 * 5 + 20, np.uint8)
    np.save(tmp_path / "v.npy", coarse)
    expected = codes_of(tmp_path, "v.npy", spacing_mm=24 / 128)
    codes = codes_of(tmp_path, "s.zarr", "--memory", "300MB", pitch_mm=0.2)
    assert (codes == expected).all()
    with pytest.raises(AssertionError, match="pitch_mm"):
        codes_of(tmp_path, "s.zarr", "--memory", "300MB")
