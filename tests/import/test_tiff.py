# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""TIFFs written by tifffile: each texel has the number that was written, or the file is refused by name."""

from __future__ import annotations

import itertools
import struct
from pathlib import Path

import numpy as np
import pytest
import tifffile
from oftx import Refused, volume

TYPES = ["uint8", "uint16", "uint32", "uint64", "int8", "int16", "int32", "int64", "float16", "float32", "float64"]
COMPRESSIONS = [None, "lzw", "zlib", "packbits", "lzma", "zstd"]
LAYOUTS: list[dict] = [{}, {"rowsperstrip": 1}, {"rowsperstrip": 7}, {"rowsperstrip": 80}, {"tile": (16, 16)}, {"tile": (64, 32)}]
SHAPE = (2, 80, 37)  # pages of more than 64 rows, and sides that no tile divides


def numbers(kind: str, shape: tuple[int, ...], seed: int = 1) -> np.ndarray:
    """Returns numbers of which a float holds each."""
    random = np.random.default_rng(seed)
    if kind.startswith("float"):
        return random.standard_normal(shape).astype("float16").astype(kind)
    least, most = np.iinfo(kind).min, np.iinfo(kind).max
    drawn = random.integers(max(least, -(2**24)), min(most, 2**24), shape, endpoint=True)
    return drawn.astype(kind)


def meant(stored: np.ndarray) -> np.ndarray:
    """Returns the numbers that docs/how-to/fields.md promises."""
    if stored.dtype == np.uint8 or stored.dtype == np.uint16:
        return stored / np.float64(np.iinfo(stored.dtype).max)
    return stored.astype(np.float64)


def check(file: Path, stored: np.ndarray, *options: object) -> str:
    """Compares all texels; `stored` by z, y, x, or with channels behind."""
    seen = volume(file, *options)
    wanted = meant(stored.reshape(seen.values.shape))
    bound = 1e-7 * np.abs(wanted)  # the rounding of a fraction to a float; integers and floats are exact
    exact = stored.dtype not in (np.uint8, np.uint16)
    assert np.all(np.abs(seen.values - wanted) <= (0 if exact else bound))
    return seen.told


def cells() -> list[tuple]:
    """Returns each type with each compression and predictor, and all else in turn, so that each pair occurs."""
    others = itertools.cycle(itertools.product("<>", (False, True), LAYOUTS, ("contig", "separate")))
    step = itertools.count()
    out = []
    for kind, compression, predictor in itertools.product(TYPES, COMPRESSIONS, (False, True)):
        if predictor and compression in (None, "packbits"):
            continue
        for _ in range(3):
            for _ in range(next(step) % 5):
                next(others)
            order, big, layout, planes = next(others)
            out.append((kind, compression, predictor, order, big, layout, planes))
    return out


@pytest.mark.parametrize("kind, compression, predictor, order, big, layout, planes", cells())
def test_each_cell(tmp_path, kind, compression, predictor, order, big, layout, planes):
    three = planes == "separate" or kind == "uint16"
    data = numbers(kind, (*SHAPE, 3) if three else SHAPE)
    file = tmp_path / "a.tif"
    written = data.transpose(0, 3, 1, 2) if three and planes == "separate" else data
    extra = {"planarconfig": planes} if three else {}
    try:
        tifffile.imwrite(file, written, byteorder=order, bigtiff=big, compression=compression, predictor=predictor,
                         photometric="minisblack", metadata=None, **layout, **extra)
    except (ValueError, NotImplementedError) as trouble:
        pytest.skip(f"tifffile does not write it: {trouble}")
    assert np.array_equal(tifffile.imread(file).reshape(written.shape), written)
    check(file, data, "--space", "linear")


@pytest.mark.parametrize("bits", [1, 2, 4])
@pytest.mark.parametrize("order", "<>")
def test_packed_bits(tmp_path, bits, order):
    data = np.random.default_rng(3).integers(0, 2**bits, SHAPE).astype("uint8")
    file = tmp_path / "a.tif"
    if bits == 1:
        tifffile.imwrite(file, data.astype(bool), byteorder=order, photometric="minisblack")
    else:
        write_packed(file, data, bits, order)
    seen = volume(file)
    assert np.abs(seen.values[..., 0] - data / (2**bits - 1)).max() < 1e-7


def test_twelve_bits(tmp_path):
    data = np.random.default_rng(3).integers(0, 4096, SHAPE).astype("uint16")
    write_packed(tmp_path / "a.tif", data, 12, "<")
    assert np.abs(volume(tmp_path / "a.tif").values[..., 0] - data / 4095).max() < 1e-7


def write_packed(file: Path, pages: np.ndarray, bits: int, order: str) -> None:
    """Writes rows of bits, from the highest of each byte on; tifffile has no writer of these."""
    out = bytearray(b"II*\0" if order == "<" else b"MM\0*")
    out += struct.pack(order + "I", 8)
    for page, rows in enumerate(pages):
        height, width = rows.shape
        shifts = np.arange(bits - 1, -1, -1)
        packed = np.packbits((rows[..., None] >> shifts & 1).reshape(height, -1).astype("uint8"), axis=1).tobytes()
        tags = [(256, width), (257, height), (258, bits), (259, 1), (262, 1), (273, 0), (277, 1), (278, height), (279, len(packed))]
        begin = len(out) + 2 + 12 * len(tags) + 4
        out += struct.pack(order + "H", len(tags))
        for tag, value in tags:
            out += struct.pack(order + "HHII", tag, 4, 1, begin if tag == 273 else value)
        out += struct.pack(order + "I", begin + len(packed) if page + 1 < len(pages) else 0) + packed
    file.write_bytes(out)


@pytest.mark.parametrize("compression", ["jpegxl", "jpeg2000", "png", "jpegxr"])
@pytest.mark.parametrize("layout", [{}, {"tile": (16, 16)}])
def test_compressions_that_are_not_read_are_named(tmp_path, compression, layout):
    data = np.full(SHAPE, 200, "uint8")
    try:
        tifffile.imwrite(tmp_path / "a.tif", data, compression=compression, photometric="minisblack", **layout)
    except (ValueError, ImportError) as trouble:
        pytest.skip(str(trouble))
    with pytest.raises(Refused, match="compressed as"):
        volume(tmp_path / "a.tif")


@pytest.mark.parametrize("compression", ["jpeg", "webp", "lerc"])
def test_lossy_compressions(tmp_path, compression):
    data = np.full((*SHAPE, 3), 200, "uint8") if compression != "lerc" else np.full(SHAPE, 200, "float32")
    tifffile.imwrite(tmp_path / "a.tif", data, compression=compression,
                     photometric="rgb" if data.ndim == 4 else "minisblack")
    try:
        seen = volume(tmp_path / "a.tif", "--space", "linear").values
    except Refused as refused:
        assert "compressed as" in str(refused)
        return
    assert np.abs(seen - (200 if compression == "lerc" else 200 / 255)).max() < 0.02


@pytest.mark.parametrize("compression", [None, "lzw", "zlib", "packbits", "lzma", "zstd", "lerc"])
@pytest.mark.parametrize("layout", [{"rowsperstrip": 16}, {"tile": (16, 16)}])
@pytest.mark.parametrize("fault", ["damaged", "behind the end", "no place", "no bytes"])
def test_damaged_chunks(tmp_path, compression, layout, fault):
    if compression in (None, "packbits") and fault == "damaged":
        pytest.skip("any bytes are numbers")
    file = tmp_path / "a.tif"
    data = np.full((4, 64, 32), 200, "uint8")
    tifffile.imwrite(file, data, compression=compression, photometric="minisblack", metadata=None, **layout)
    tiled = "tile" in layout
    with tifffile.TiffFile(file) as opened:
        page = opened.pages[2]
        at, size = page.dataoffsets[1], page.databytecounts[1]
        places = page.tags["TileOffsets" if tiled else "StripOffsets"]
        counts = page.tags["TileByteCounts" if tiled else "StripByteCounts"]
    raw = bytearray(file.read_bytes())
    if fault == "damaged":
        raw[at : at + size] = b"\xa5" * size
    else:
        entry, value = {"behind the end": (places, len(raw) + 99), "no place": (places, 0), "no bytes": (counts, 0)}[fault]
        width = {3: 2, 4: 4}[int(entry.dtype)]
        raw[entry.valueoffset + width : entry.valueoffset + 2 * width] = min(value, 256**width - 1).to_bytes(width, "little")
    file.write_bytes(raw)
    with pytest.raises(Refused):
        volume(file)


@pytest.mark.parametrize("kind", ["uint8", "uint16", "float32"])
@pytest.mark.parametrize("truncate", [False, True])
def test_imagej(tmp_path, kind, truncate):
    data = numbers(kind, (8, 16, 12))
    file = tmp_path / "a.tif"
    tifffile.imwrite(file, data, imagej=True, resolution=(1 / 0.2, 1 / 0.25), truncate=truncate,
                     metadata={"spacing": 3, "unit": "micrometer", "axes": "ZYX"})
    check(file, data)
    seen = volume(file)
    assert np.allclose(seen.extent, (12 * 0.2e-3, 16 * 0.25e-3, 8 * 3e-3))


@pytest.mark.parametrize("truncate", [False, True])
def test_channels_of_imagej(tmp_path, truncate):
    data = numbers("uint16", (8, 2, 16, 12))
    file = tmp_path / "a.tif"
    tifffile.imwrite(file, data, imagej=True, truncate=truncate, metadata={"axes": "ZCYX"})
    for channel in (0, 1):
        check(file, data[:, channel], "--field", channel + 1)
    with pytest.raises(Refused, match="`1`, `2`"):
        volume(file)
    with pytest.raises(Refused):
        volume(file, "--field", "3")


def test_frames_of_imagej_are_no_slices(tmp_path):
    tifffile.imwrite(tmp_path / "a.tif", numbers("uint16", (5, 16, 12)), imagej=True, metadata={"axes": "TYX"})
    with pytest.raises(Refused, match="5 frames"):
        volume(tmp_path / "a.tif")


@pytest.mark.parametrize("axes", ["CZYX", "ZCYX"])
def test_ome(tmp_path, axes):
    data = numbers("uint16", (3, 4, 16, 12))
    file = tmp_path / "a.ome.tif"
    channels = data.shape[axes.index("C")]
    names = [f"dye {c}" for c in range(channels)]
    tifffile.imwrite(file, data, metadata={"axes": axes, "Channel": {"Name": names}, "PhysicalSizeX": 0.5,
                                           "PhysicalSizeY": 0.5, "PhysicalSizeZ": 2})
    for c in range(channels):
        part = np.take(data, c, axes.index("C"))
        check(file, part, "--field", names[c])
        check(file, part, "--field", c + 1)
        assert np.allclose(volume(file, "--field", names[c]).extent, (6e-3, 8e-3, 2e-3 * len(part)))
    with pytest.raises(Refused, match="dye 0"):
        volume(file)


def test_microscopes_of_other_makers(tmp_path):
    file = tmp_path / "a.tif"
    data = numbers("uint16", (6, 16, 12))
    tifffile.imwrite(file, data[:1], metadata=None, extratags=[(33629, 5, 6, [1, 1] * 6, True)])  # MetaMorph
    with pytest.raises(Refused, match="6 planes"):
        volume(file)
    for slices, times in ((6, 1), (3, 2)):
        about = struct.pack("<IiiiiiiiIIddd", 0x00400494C, 512, 12, 16, slices, 1, times, 2, 0, 0, 1e-6, 2e-6, 3e-6)
        zeiss = (34412, 1, 512, about.ljust(512, b"\0"), True)
        tifffile.imwrite(file, data, metadata=None, photometric="minisblack", extratags=[zeiss])
        if times == 1:
            check(file, data)
            assert np.allclose(volume(file).extent, (12e-3, 32e-3, 18e-3))
        else:
            with pytest.raises(Refused, match="2 frames"):
                volume(file)


@pytest.mark.parametrize("sorted_tags", [True, False])
@pytest.mark.parametrize("tag", [254, 255])
def test_smaller_copies_of_older_writers(tmp_path, tag, sorted_tags):
    file = tmp_path / "a.tif"
    data = numbers("int16", (4, 16, 12))
    with tifffile.TiffWriter(file) as writer:
        for k, page in enumerate(data):
            old = {"extratags": [(255, 3, 1, 2 if k == 2 else 1, True)]} if tag == 255 else {"subfiletype": int(k == 2)}
            writer.write(page, metadata=None, contiguous=False, **old)
    if not sorted_tags:
        raw = bytearray(file.read_bytes())
        with tifffile.TiffFile(file) as opened:
            begins = [page.offset + 2 for page in opened.pages]
        for begin in begins:  # the first three entries, backwards
            raw[begin : begin + 36] = raw[begin + 24 : begin + 36] + raw[begin + 12 : begin + 24] + raw[begin : begin + 12]
        file.write_bytes(raw)
    assert "smaller copies" in check(file, np.delete(data, 2, 0))


@pytest.mark.parametrize("photometric", ["ycbcr", "separated", "cielab"])
def test_damaged_chunks_of_colours(tmp_path, photometric):
    file = tmp_path / "a.tif"
    data = np.random.default_rng(4).integers(0, 255, (3, 64, 32, 4 if photometric == "separated" else 3)).astype("uint8")
    plain = {"subsampling": (1, 1)} if photometric == "ycbcr" else {}
    tifffile.imwrite(file, data, photometric=photometric, compression="lzw", rowsperstrip=16, metadata=None, **plain)
    volume(file)
    raw = bytearray(file.read_bytes())
    with tifffile.TiffFile(file) as opened:
        at, size = opened.pages[1].dataoffsets[1], opened.pages[1].databytecounts[1]
    raw[at : at + size] = b"\xa5" * size
    file.write_bytes(raw)
    with pytest.raises(Refused):
        volume(file)


def test_shape_of_tifffile(tmp_path):
    file = tmp_path / "a.tif"
    data = numbers("float32", (6, 16, 12))
    tifffile.imwrite(file, data)
    check(file, data)
    tifffile.imwrite(file, data, truncate=True)
    check(file, data)
    tifffile.imwrite(file, numbers("float32", (2, 3, 16, 12)), photometric="minisblack")
    with pytest.raises(Refused, match="2 x 3 x 16 x 12"):
        volume(file)
    four = numbers("float32", (2, 3, 16, 12))
    tifffile.imwrite(file, four, metadata={"axes": "CZYX"}, photometric="minisblack")
    check(file, four[1], "--field", "2")


@pytest.mark.parametrize("tile", [(1, 16, 16), (4, 16, 16), None])
def test_pages_that_are_volumes(tmp_path, tile):
    data = numbers("int16", (6, 40, 30))
    tifffile.imwrite(tmp_path / "a.tif", data, tile=tile, volumetric=True, photometric="minisblack")
    try:
        check(tmp_path / "a.tif", data)
    except Refused as refused:
        assert "ImageDepth" in str(refused) and tile != (1, 16, 16)


def test_folders_of_stacks(tmp_path):
    folder = tmp_path / "stacks"
    folder.mkdir()
    data = numbers("int16", (8, 16, 12))
    for k in range(2):
        tifffile.imwrite(folder / f"part{k}.tif", data[4 * k : 4 * k + 4], metadata=None, photometric="minisblack")
    check(folder, data)
    ome = tmp_path / "ome"
    ome.mkdir()
    for name, part in (("part0", data[:4]), ("part1", data[4:])):
        tifffile.imwrite(ome / f"{name}.ome.tif", part, metadata={"axes": "ZYX"}, photometric="minisblack")
    check(ome, data)


def test_integers_that_no_float_holds_are_told(tmp_path):
    file = tmp_path / "a.tif"
    for kind, value in (("int32", 2**24 + 1), ("uint32", 2**32 - 1), ("int64", 2**53 + 1), ("uint64", 2**64 - 1)):
        tifffile.imwrite(file, np.full(SHAPE, value, kind), metadata=None)
        seen = volume(file)
        assert "rounded" in seen.told
        assert np.all(seen.values == np.float32(value))


def test_nan_is_outside(tmp_path):
    data = numbers("float32", SHAPE)
    data[:, 10:20] = np.nan
    tifffile.imwrite(tmp_path / "a.tif", data, metadata=None)
    with pytest.raises(Refused, match="finite"):
        volume(tmp_path / "a.tif")
    check(tmp_path / "a.tif", np.nan_to_num(data, nan=-7), "--outside=-7")


def test_what_is_left_out_is_told(tmp_path):
    file = tmp_path / "a.tif"
    data = np.arange(2 * 80 * 37, dtype="uint8").reshape(SHAPE)
    tifffile.imwrite(file, data, photometric="palette", colormap=np.zeros((3, 256), "uint16"), metadata=None)
    assert "palette" in check(file, data)
    tifffile.imwrite(file, data, photometric="miniswhite", metadata=None)
    assert "MinIsWhite" in check(file, data)
    tifffile.imwrite(file, data, photometric="minisblack", resolution=(100, 100), resolutionunit="CENTIMETER", metadata=None)
    assert "0.1 x 0.1 mm" in check(file, data)
    tifffile.imwrite(file, data, photometric="minisblack", metadata=None, extratags=[(274, 3, 1, 4, False)])
    assert "orientation (4)" in check(file, data)
    with tifffile.TiffWriter(file) as writer:
        writer.write(data[0], photometric="minisblack", metadata=None)
        writer.write(data[0, ::2, ::2], photometric="minisblack", subfiletype=1, metadata=None)
        writer.write(data[1], photometric="minisblack", metadata=None)
    assert "smaller copies" in check(file, data)
