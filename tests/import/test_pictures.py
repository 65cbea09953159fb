# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""One picture in many formats, written by Pillow and OpenEXR, gives the same skin, or is refused with a message."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from conftest import BLUE, GREEN, RED, TOOL, WHITE, YELLOW, box, close, like, linear, quad_picture, srgb
from PIL import Image


def plate(folder: Path) -> Path:
    corners, faces = box()
    path = folder / "plate.obj"
    path.write_text(
        "".join(f"v {x} {y} {z}\n" for x, y, z in corners)
        + "".join(f"vt {x / 4} {y / 4}\n" for x, y, z in corners)
        + "".join(f"f {a + 1}/{a + 1} {b + 1}/{b + 1} {c + 1}/{c + 1}\n" for a, b, c in faces)
    )
    return path


@pytest.fixture
def skin(tmp_path, imported):
    """Prints a plate with a picture."""
    return lambda picture: imported(plate(tmp_path), "--unit", "mm", "--picture", picture)


def corners(made) -> list:
    """Returns the colours as seen, row by row."""
    return [made.look(x, y, 3.75) for y in (3.25, 0.75) for x in (0.75, 3.25)]


def assert_quad(made, colors=(RED, GREEN, BLUE, YELLOW), within: float = 2) -> None:
    seen = corners(made)
    assert all(like(a, b, within) for a, b in zip(seen, colors)), seen


QUAD = Image.fromarray(quad_picture(16))


@pytest.mark.parametrize(
    "name, image, options",
    [
        ("rgb.png", QUAD, {}),
        ("rgba.png", QUAD.convert("RGBA"), {}),
        ("palette.png", QUAD.quantize(8), {}),
        ("interlaced.png", QUAD, {"interlace": 1}),
        ("rgb.bmp", QUAD, {}),
        ("palette.bmp", QUAD.quantize(8), {}),
        ("rgb.tga", QUAD, {}),
        ("rle.tga", QUAD, {"compression": "tga_rle"}),
        ("rgba.tga", QUAD.convert("RGBA"), {}),
        ("bottom_up.tga", QUAD, {"orientation": -1}),
        ("top_down.tga", QUAD, {"orientation": 1}),
        ("palette.gif", QUAD.quantize(8), {}),
        ("lossless.webp", QUAD, {"lossless": True}),
        ("rgb.tif", QUAD, {}),
        ("lzw.tif", QUAD, {"compression": "tiff_lzw"}),
        ("deflate.tif", QUAD.convert("RGBA"), {"compression": "tiff_adobe_deflate"}),
        ("rgb.ppm", QUAD, {}),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_lossless_kinds(tmp_path, skin, name, image, options):
    image.save(tmp_path / name, **options)
    assert_quad(skin(tmp_path / name))


@pytest.mark.parametrize("options", [{}, {"progressive": True}], ids=["baseline", "progressive"])
def test_jpeg(tmp_path, skin, options):
    QUAD.save(tmp_path / "quad.jpg", quality=100, subsampling=0, **options)
    assert_quad(skin(tmp_path / "quad.jpg"), within=4)


@pytest.mark.parametrize("orientation", range(1, 9))
def test_orientation_of_jpeg(tmp_path, skin, orientation):
    # A camera stores the picture turned, and says how to turn it back: by the inverse of what Exif names.
    stored = {
        1: None,
        2: Image.Transpose.FLIP_LEFT_RIGHT,
        3: Image.Transpose.ROTATE_180,
        4: Image.Transpose.FLIP_TOP_BOTTOM,
        5: Image.Transpose.TRANSPOSE,
        6: Image.Transpose.ROTATE_90,
        7: Image.Transpose.TRANSVERSE,
        8: Image.Transpose.ROTATE_270,
    }[orientation]
    exif = Image.Exif()
    exif[0x0112] = orientation
    image = QUAD if stored is None else QUAD.transpose(stored)
    image.save(tmp_path / "turned.jpg", quality=100, subsampling=0, exif=exif)
    assert_quad(skin(tmp_path / "turned.jpg"), within=4)


@pytest.mark.parametrize("bits", [1, 8, 16])
def test_grey(tmp_path, skin, bits):
    # Left 188, or black where there is one bit; right white.
    left = 0 if bits == 1 else 188
    pixels = np.full((16, 16), 255, dtype=np.uint8)
    pixels[:, :8] = left
    if bits == 16:
        image = Image.fromarray((pixels.astype(np.uint16) * 257))
    else:
        image = Image.fromarray(pixels).convert("1" if bits == 1 else "L")
    image.save(tmp_path / "grey.png")
    made = skin(tmp_path / "grey.png")
    assert like(made.look(3.25, 2, 3.75), WHITE)
    if bits == 1:
        assert close(made.mix(0.75, 2, 3.75), {"cyan": 0.2 / 1.4, "magenta": 0.2 / 1.4, "yellow": 0.2 / 1.4, "black": 0.8 / 1.4})
    elif bits == 8:
        assert like(made.look(0.75, 2, 3.75), [188] * 3)
    else:
        # 16 bits without a word of their space: linear light, as docs say, or sRGB; not something else.
        expected = ([188] * 3, [round(255 * (1.055 * (188 / 255) ** (1 / 2.4) - 0.055))] * 3)
        assert any(like(made.look(0.75, 2, 3.75), e) for e in expected)


@pytest.mark.parametrize("mode", ["RGBA", "LA", "P", "PA of tRNS"])
def test_what_is_transparent_is_bare(tmp_path, skin, mode):
    pixels = np.zeros((16, 16, 4), dtype=np.uint8)
    pixels[:, :8] = (188, 188, 188, 255)
    image = Image.fromarray(pixels)
    options = {}
    if mode == "LA":
        image = image.convert("LA")
    elif mode == "P":
        image = image.convert("RGB").quantize(4)
        options["transparency"] = image.getpixel((12, 2))
    elif mode == "PA of tRNS":
        # An alpha for each entry of the palette.
        image = image.convert("RGB").quantize(4)
        alphas = bytearray(255 for _ in range(4))
        alphas[image.getpixel((12, 2))] = 0
        options["transparency"] = bytes(alphas)
    image.save(tmp_path / "logo.png", **options)
    made = skin(tmp_path / "logo.png")
    assert like(made.look(0.75, 2, 3.75), [188] * 3)
    assert made.mix(3.25, 2, 3.75) == {"white": 1.0}


def test_alpha_is_coverage(tmp_path, skin):
    pixels = np.full((8, 8, 4), (*RED, 102), dtype=np.uint8)
    Image.fromarray(pixels).save(tmp_path / "half.png")
    mix = skin(tmp_path / "half.png").mix(2, 2, 3.75)
    d = [-np.log10(linear(c)) / 1.2 for c in RED]
    grey = 0.8 * min(d)
    inks = {"cyan": d[0] - grey, "magenta": d[1] - grey, "yellow": d[2] - grey, "black": grey}
    expected = {name: 0.4 * amount for name, amount in inks.items()}
    expected["white"] = 1 - sum(expected.values())
    assert close(mix, expected), mix


@pytest.mark.parametrize("half", [True, False], ids=["half", "float"])
def test_exr(tmp_path, skin, half):
    kind = np.float16 if half else np.float32
    pixels = np.vectorize(linear)(quad_picture(16)).astype(kind)
    OpenEXR.File({"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}, {"RGB": pixels}).write(
        str(tmp_path / "quad.exr")
    )
    assert_quad(skin(tmp_path / "quad.exr"))


def test_exr_chromaticities(tmp_path, skin):
    # ACES AP0, white D60. A grey stays a grey whatever the primaries, if the white is adapted.
    aces = (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.077, 0.32168, 0.33767)
    pixels = np.full((8, 8, 3), linear(188), dtype=np.float32)
    pixels[:, :4] = (0.5, 0.4, 0.35)
    OpenEXR.File(
        {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage, "chromaticities": aces}, {"RGB": pixels}
    ).write(str(tmp_path / "ap0.exr"))
    made = skin(tmp_path / "ap0.exr")
    assert like(made.look(3.25, 2, 3.75), [188] * 3, 3)
    expected = [srgb(c) for c in to_srgb(aces) @ np.array([0.5, 0.4, 0.35])]
    assert like(made.look(0.75, 2, 3.75), expected, 3), expected


def to_srgb(chromaticities) -> np.ndarray:
    """Converts linear light from these primaries and white to those of sRGB; Bradford's matrix adapts the white."""

    def to_xyz(c) -> tuple[np.ndarray, np.ndarray]:
        columns = np.array([[c[i] / c[i + 1], 1, (1 - c[i] - c[i + 1]) / c[i + 1]] for i in (0, 2, 4, 6)]).T
        white = columns[:, 3]
        return columns[:, :3] * np.linalg.solve(columns[:, :3], white), white

    theirs, white = to_xyz(chromaticities)
    ours, d65 = to_xyz((0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329))
    bradford = np.array([[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]])
    adapt = np.linalg.inv(bradford) @ np.diag(bradford @ d65 / (bradford @ white)) @ bradford
    return np.linalg.inv(ours) @ adapt @ theirs


@pytest.mark.parametrize("name", ["quad.ico", "quad.pcx", "quad.jp2"])
def test_other_kinds_are_refused_with_a_word(tmp_path, name):
    QUAD.save(tmp_path / name)
    commands = [
        ["import", plate(tmp_path), "-o", tmp_path / "w", "--picture", tmp_path / name, "--unit", "mm"],
        ["print", tmp_path / "w" / "plate.fab.json", "-o", tmp_path / "o.npy", "--voxel", "0.5mm"],
    ]
    told = ""
    for command in commands:
        done = subprocess.run([TOOL, *command], capture_output=True, text=True)
        told += done.stderr
        if done.returncode != 0:
            break
    assert done.returncode == 1 and name in told and "PNG" in told, told
