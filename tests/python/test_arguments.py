# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Arguments of calls: numbers and arrays of any kind, and invalid ones."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import BALL, BY_VOLUME

import openfab

WHITE, BLACK = openfab.Material("white", "#ffffff"), openfab.Material("black", "#000000")

VERTICES = np.array([(0, 0, 0), (4, 0, 0), (0, 4, 0), (0, 0, 4)], float)
FACES = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)])


@pytest.mark.parametrize(
    ("given", "usual"),
    [
        ({"voxel": np.float64(0.5)}, {"voxel": 0.5}),
        ({"voxel": np.float32(0.5)}, {"voxel": 0.5}),
        ({"voxel": np.array(0.5)}, {"voxel": 0.5}),
        ({"voxel": Fraction(1, 2)}, {"voxel": 0.5}),
        ({"voxel": np.array([0.5, 0.5, 1])}, {"voxel": (0.5, 0.5, 1)}),
        ({"dpi": 100, "layer": np.float32(0.5)}, {"dpi": "100x100", "layer": "0.5mm"}),
        ({"dpi": (np.int64(100), 50.0)}, {"dpi": "100x50"}),
        ({"voxel": 0.5, "z": (np.float32(1), "4mm")}, {"voxel": 0.5, "slices": (2, 8)}),
        ({"voxel": 0.5, "slices": np.array([2, 8])}, {"voxel": 0.5, "slices": (2, 8)}),
        ({"draft": np.int64(8), "seed": np.uint8(3), "threads": np.array(1)}, {"draft": 8, "seed": 3, "threads": 1}),
        ({"voxel": 0.5, "memory": 1e9}, {"voxel": 0.5, "memory": "1GB"}),
        ({"voxel": 0.5, "uniforms": {"ball.skin": np.float32(0.5)}}, {"voxel": 0.5, "uniforms": {"ball.skin": 0.5}}),
    ],
)
def test_numbers_may_be_of_numpy(ball: openfab.World, given: dict[str, Any], usual: dict[str, Any]) -> None:
    found, expected = openfab.print_world(ball, **given), openfab.print_world(ball, **usual)
    np.testing.assert_array_equal(found.array(), expected.array())
    assert found.info.pitch_mm == expected.info.pitch_mm


def test_numbers_of_shapes_and_placements_may_be_of_numpy() -> None:
    def made(number: Callable[[float], Any]) -> np.ndarray:
        world = openfab.World(printer="generic")
        fablet = openfab.Fablet(text=BALL)
        dense = openfab.Material("dense", "#808080", density_g_cm3=number(2))
        uniforms = {"core": WHITE, "shell": dense, "skin": number(1)}
        shape = openfab.box(number(2), number(4), number(3))
        keys = {"priority": np.int16(2), "support": np.bool_(True), "translate_mm": [number(1), number(2)]}
        first = world.add(shape, fablet, uniforms, **keys)
        first.place(translate=[number(8)] * 3, rotate=[number(0)] * 3, scale=number(1))
        world.add(openfab.sphere(number(3)), fablet, uniforms, matrix=np.eye(4))
        return openfab.sample(world, ([number(-2)] * 3, [number(9)] * 3), voxel=number(1)).fractions

    expected = made(int)
    assert expected.any()
    for kind in (np.int64, np.uint8, np.float32, np.array):
        np.testing.assert_array_equal(made(lambda x: kind(x) if x >= 0 else np.int8(x)), expected)


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"voxel": (0.3, 0.2)}, "`voxel` has 2 elements; write one pitch, or three"),
        ({"voxel": (0.3, 0, 0.2)}, "`voxel` cannot be 0; it is more than 0"),
        ({"voxel": float("nan")}, "`voxel` cannot be nan"),
        ({"voxel": 1j}, "`voxel` cannot be 1j"),
        ({"voxel": True}, "`voxel` cannot be True"),
        ({"voxel": np.zeros((300, 300))}, "`voxel` has 300 elements"),
        ({"slices": (0,)}, "`slices` has 1 elements"),
        ({"slices": "0:3"}, "`slices` cannot be '0:3'"),
        ({"slices": (0.5, 2.7)}, "`slices` cannot be 0.5; it is a whole number"),
        ({"z": 3}, "`z` cannot be 3"),
        ({"dpi": (300, 300, 300)}, "`dpi` has 3 elements"),
        ({"draft": 2.0}, "`draft` cannot be 2.0; it is a whole number"),
        ({"crop": "nowhere"}, "`crop` cannot be 'nowhere'; it is one of `parts`, `tray`"),
        ({"memory": "much"}, "`memory`"),
        ({"memory": [1]}, "`memory` cannot be"),
        ({"printer": 3}, "`printer` cannot be 3"),
        ({"support": 3}, "`support` cannot be 3"),
        ({"uniforms": {"ball.skin": np.zeros((300, 300))}}, "`skin` cannot be an array of float64 of the shape"),
        ({"uniforms": {"ball.skin": None}}, "`skin` cannot be None"),
    ],
)
def test_what_is_no_value_is_told(ball: openfab.World, arguments: dict[str, Any], text: str) -> None:
    with pytest.raises(openfab.InputError, match=text) as caught:
        openfab.print_world(ball, **arguments)._end()
    assert len(str(caught.value)) < 300


def test_what_is_no_world_is_told() -> None:
    with pytest.raises(openfab.InputError, match=r"'ball.fab.json' is no world; pass .* openfab.load"):
        openfab.sample("ball.fab.json", voxel=0.5, sampling="centre")  # type: ignore[arg-type]


def test_means_need_all_values(ball: openfab.World) -> None:
    samples = openfab.sample(ball, voxel=2, sampling="centre")
    with pytest.raises(openfab.InputError, match="no value for black; give one for each of white, black"):
        samples.mean({"white": 1.0})
    np.testing.assert_array_equal(samples.mean({"white": np.float32(1), "black": 1}).max(), 1)


@pytest.mark.parametrize(
    ("placement", "text"),
    [
        ({"translate": 5}, "`translate` cannot be 5"),
        ({"rotate": (1, 2)}, "`rotate` has 2 elements"),
        ({"scale": "big"}, "`scale` cannot be 'big'"),
        ({"matrix": np.eye(5)}, r"`matrix` has the shape \(5, 5\)"),
        ({"matrix": np.diag([1, 1, 1, 2.0])}, "the last row of `matrix`"),
        ({"translate_mm": [float("inf"), 0]}, "`translate_mm` of a placement cannot be inf"),
    ],
)
def test_a_wrong_placement_leaves_no_object(ball: openfab.World, placement: dict[str, Any], text: str) -> None:
    one = ball.objects["ball"]
    with pytest.raises(openfab.InputError, match=text):
        ball.add(openfab.sphere(1), one.fablet, dict(one), name="other", **placement)
    with pytest.raises(openfab.InputError, match=text):
        one.place(**placement)
    assert list(ball.objects) == ["ball"] and len(ball._placements) == 1


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: openfab.Material("w", "#ffffff", density_g_cm3=1j), "`density_g_cm3` of material `w` cannot be 1j"),
        (lambda: openfab.Texture("a.png", wrap=object()), "a texture, `wrap` cannot be"),
        (lambda: openfab.FileMesh("a.obj", groups={"a": 1j}), "`groups` of a mesh, `a` cannot be 1j"),
        (lambda: openfab.World(tray=object()), "`tray` of a world cannot be"),
        (lambda: openfab.sphere("3mm"), "`diameter` cannot be '3mm'"),
        (lambda: openfab.extrusion([[(0, 0), (1, 0), (1,)]], 3), "a corner of a polygon has 1 elements"),
    ],
)
def test_what_a_world_is_made_of_is_checked(make: Callable[[], Any], text: str) -> None:
    with pytest.raises(openfab.InputError, match=text):
        make()


def test_uniforms_are_checked_when_they_are_set(ball: openfab.World) -> None:
    one = ball.objects["ball"]
    for wrong in (float("nan"), np.inf, None, object(), np.zeros(3), [1, [2, 3]], np.array([1j])):
        with pytest.raises(openfab.InputError, match="`skin`"):
            one["skin"] = wrong
    assert one["skin"] == 0.8


@pytest.mark.parametrize(
    ("keys", "text"),
    [
        ({"faces": FACES + 0.7}, "`faces` has 0.7 at"),
        ({"faces": FACES + 2**32}, "`faces` has 4294967296 at"),
        ({"faces": FACES + 1}, "face 1 has the vertex 4; there are 4, from 0 to 3"),
        ({"faces": [[0, 1, 2], [0, 1]]}, "`faces` cannot be made an array"),
        ({"vertices": VERTICES * np.nan}, "`vertices` has nan at"),
        ({"vertices": VERTICES[:, :2]}, "`vertices` has the shape"),
        ({"vertices": VERTICES + 1j}, "`vertices` is an array of complex128"),
        ({"normals": VERTICES[:3]}, "`normals` has the shape"),
        ({"uv": np.zeros((4, 2, 3))}, r"`uv` has the shape \(4, 2, 3\)"),
        ({"face_attributes": {"zone": np.arange(4) + 2**32}}, "face attribute `zone` has 4294967296 at"),
        ({"face_attributes": {"zone": list("abcd")}}, "face attribute `zone` is an array of <U1"),
        ({"vertex_attributes": {"s": [0, np.nan, 1, np.nan]}}, r"attribute `s` has nan at \[1\], and 1 more"),
        ({"vertex_attributes": {"s": np.full(4, 1e300)}}, "attribute `s` has 1e.300 at"),
        ({"vertex_attributes": {"s": np.zeros((4, 5))}}, r"attribute `s` has the shape \(4, 5\)"),
        ({"vertex_attributes": {"s": np.zeros((4, 2, 2))}}, r"attribute `s` has the shape \(4, 2, 2\)"),
        ({"vertex_attributes": {"s": np.ma.masked_less([0, 1, 2, 3], 2)}}, "attribute `s` has masked values"),
        ({"vertex_attributes": {"n": VERTICES}}, "pass `normals`"),
        ({"vertex_attributes": {"uv": VERTICES[:, :2]}}, "pass `uv`"),
        ({"vertex_attributes": {"x": range(4)}}, "cannot be called `x`"),
        ({"vertex_attributes": {"": range(4)}}, "cannot be called ''"),
        ({"vertex_attributes": {"my stress": range(4)}}, "cannot be called 'my stress'"),
        ({"vertex_attributes": {"s\nelement face 0": range(4)}}, "cannot be called"),
        ({"vertex_attributes": {"s": VERTICES[:, :2], "s_1": range(4)}}, "`s` and `s_1` are too alike"),
    ],
)
def test_wrong_arrays_of_meshes_are_told(keys: dict[str, Any], text: str) -> None:
    with pytest.raises(openfab.InputError, match=text):
        openfab.Mesh(**{"vertices": VERTICES, "faces": FACES, **keys})


def test_arrays_of_meshes_are_of_any_kind_that_fits() -> None:
    usual = openfab.Mesh(VERTICES, FACES)
    for faces in (FACES.astype(float), FACES.astype(">i2"), FACES.astype(np.uint64), FACES.tolist()):
        np.testing.assert_array_equal(openfab.Mesh(VERTICES.astype(">f4"), faces).faces, usual.faces)


def test_arrays_of_a_mesh_stay() -> None:
    mesh = openfab.Mesh(VERTICES, FACES)
    with pytest.raises(ValueError, match="read-only"):
        mesh.vertices[:] = 2 * VERTICES
    with pytest.raises(AttributeError):
        mesh.vertices = 2 * VERTICES  # type: ignore[misc]


@pytest.mark.parametrize("kind", [">u2", ">f4", ">f8", "masked"])
def test_textures_are_read_in_any_byte_order(kind: str) -> None:
    usual = np.array([[[0, 13000, 40000, 65535]]], "u2") if kind == ">u2" else np.array([[[0, 0.2, 0.6, 1]]], "f4")
    given = np.ma.masked_less(usual, -1) if kind == "masked" else usual.astype(kind)
    volume = openfab.Texture.volume(given, origin_mm=(-2, -0.5, 0), spacing_mm=1, filter="nearest")
    world = openfab.World(printer="generic")
    uniforms = {"field": volume, "one": WHITE, "other": BLACK}
    world.add(openfab.box(4, 1, 1), openfab.Fablet(text=BY_VOLUME), uniforms)
    found = openfab.sample(world, voxel=1, sampling="centre").fractions[0, 0, :, 0]
    np.testing.assert_allclose(found, usual[0, 0] / (65535 if kind == ">u2" else 1), atol=2e-5)
    picture, expected = openfab.Texture(given[0]), openfab.Texture(usual[0])
    assert picture._file is not None and expected._file is not None
    assert picture._file.path().read_bytes() == expected._file.path().read_bytes()


@pytest.mark.parametrize(
    ("values", "text"),
    [
        (np.full((4, 4), 1 + 1j), "complex128"),
        (np.zeros((4, 4), "m8[s]"), "timedelta64"),
        (np.full((4, 4), "a"), "<U1"),
        (np.ma.masked_less(np.eye(4), 0.5), "masked values"),
        (np.zeros((0, 4)), "shape"),
        ([[1, 2], [3]], "cannot be made an array"),
    ],
)
def test_wrong_arrays_of_textures_are_told(values: Any, text: str) -> None:
    with pytest.raises(openfab.InputError, match=f"a picture .*{text}"):
        openfab.Texture(values)
    with pytest.raises(openfab.InputError, match=f"a volume .*{text}"):
        openfab.Texture.volume([values] if isinstance(values, list) else values[None])


def test_keys_of_fields_are_for_files() -> None:
    with pytest.raises(openfab.InputError, match="`field`, `unit`, `pitch_mm` of a volume: an array has none"):
        openfab.Texture.volume(np.zeros((3, 3, 3)), field="s", pitch_mm=0.5, unit="cm")


def test_help_is_in_the_text(ball: openfab.World) -> None:
    with pytest.raises(openfab.InputError, match="no uniform `skim`; did you mean `skin`?"):
        ball.objects["ball"]["skim"] = 1


def test_a_slip_in_a_world_has_its_place(tmp_path: Path) -> None:
    file = tmp_path / "bad.fab.json"
    file.write_text('{\n  "openfab": 1,,\n}')
    with pytest.raises(openfab.InputError, match=r"bad.fab.json:2:\d+: ") as caught:
        openfab.load(file)
    assert (caught.value.file, caught.value.line) == (str(file), 2) and caught.value.column > 10


def test_objects_are_named_and_removed(ball: openfab.World) -> None:
    first = ball.objects["ball"]
    ball.add(openfab.sphere(1), first.fablet, dict(first), name="ball1", translate=(20, 0))
    ball.add(openfab.sphere(1), first.fablet, dict(first), translate=(40, 0))
    assert list(ball.objects) == ["ball", "ball1", "ball2"]
    ball.remove("ball")
    ball.remove("ball2")
    assert openfab.print_world(ball, voxel=0.5).info.size == (2, 2, 2)
    with pytest.raises(openfab.InputError, match="no object `ball`"):
        ball.remove("ball")
    with pytest.raises(openfab.InputError, match="no object `ball` any more"):
        first.place()


def test_a_mesh_of_arrays_is_called_as_its_object() -> None:
    world = openfab.World(printer="generic")
    world.add(openfab.Mesh(VERTICES, FACES[:3]), openfab.Fablet(text=BALL), {"core": WHITE, "shell": BLACK}, name="lid")
    with pytest.raises(openfab.InputError, match="^the arrays of mesh `lid`: mesh `lid` is not a closed surface"):
        openfab.print_world(world, voxel=1).array()


EVERY_KIND = """fablet Kinds {
    @uniform {
        float skin = 0.5 [[ float min = 0, float max = 2 ]];
        float3 tint = float3(1, 1, 1);
        int count = 1;
        uint code = 1;
        bool on = true;
        float steps[4] = {0, 1, 2, 3};
        Material core;
        ImageTexture2D picture;
        ImageTexture3D field;
        Spline curve [[ float max = 1 ]];
        ColorRamp ramp;
    }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        float t = skin + tint.x + count + code + (on ? 1 : 0) + steps[1] + picture.Sample1(0, 0, 0);
        mc.Set(core, saturate(t + field.Sample1(attr.voxelCenter, 0, 0)) * curve.At(0.5) * ramp.At(0.5).g);
        return mc;
    }
}
"""

CURVES = {
    "curve": {"keys": np.array([[0, 0], [1, 1]]), "interpolation": "linear"},
    "ramp": {"keys": [[0, 1, 0, 0], (1, (0, 1, 0))]},
}


@pytest.mark.parametrize(
    ("name", "value", "text"),
    [
        ("skin", "thick", "`skin` cannot be 'thick'; it is a `float`"),
        ("skin", True, "`skin` cannot be True; it is a `float`"),
        ("skin", float("nan"), "finite"), ("skin", 1j, "`skin` cannot be 1j"), ("skin", 1e39, "beyond the range of a `float`"),
        ("skin", WHITE, "it is a `float`"), ("skin", None, "`skin` cannot be None"), ("skin", [1, 2], "has 1 value"),
        ("skin", -0.1, "its `min` is 0"), ("skin", 2.5, "its `max` is 2"),
        ("tint", (1, 2), "a `float3` has 3 values"), ("tint", 1, "a `float3` has 3 values"), ("tint", (1, "a", 2), "`float3`"),
        ("count", 1.5, "a `int` is a whole number from -2147483648"), ("count", 2**31, "whole number"), ("count", "1", "`int`"),
        ("code", -1, "a `uint` is a whole number from 0 to 4294967295"), ("on", 1, "it is a `bool`"),
        ("steps", (1, 2, 3), r"a `float\[4\]` has 4 values"), ("core", 1, "it is a `Material`"),
        ("core", [WHITE, BLACK], "has 1 value"), ("picture", np.zeros((2, 2, 2, 2)), "a picture has the shape"),
        ("picture", openfab.Texture.volume(np.zeros((2, 2, 2))), "`picture` cannot be a volume; it is a `ImageTexture2D`"),
        ("field", openfab.Texture(np.zeros((2, 2))), "`field` cannot be a picture; it is a `ImageTexture3D`"),
        ("curve", 1, "it is a `Spline`"), ("curve", {"key": []}, "it is a `Spline`"), ("curve", {"keys": []}, "1 to 16 keys"),
        ("curve", {"keys": [[0, 2]]}, "its `max` is 1"), ("curve", {"keys": [[0, 0], [0, 1]]}, "do not rise"),
        ("curve", {"keys": [[0, 1, 1, 1]]}, "a `Spline` has 2 numbers"), ("ramp", {"keys": [[0, 1]]}, "has 4 numbers"),
    ],
)
def test_a_wrong_value_is_refused_where_it_is_given(name: str, value: Any, text: str) -> None:
    world = openfab.World(printer="generic")
    fablet = openfab.Fablet(text=EVERY_KIND)
    good = {"core": WHITE, "picture": np.zeros((2, 2)), "field": np.zeros((2, 2, 2)), **CURVES}
    made = world.add(openfab.box(1, 1, 1), fablet, good)
    with pytest.raises(openfab.InputError, match=text):
        made[name] = value
    with pytest.raises(openfab.InputError, match=text):
        made.place(uniforms={name: value})
    with pytest.raises(openfab.InputError, match=text):
        openfab.print_world(world, voxel=0.5, uniforms={f"Kinds.{name}".lower(): value})
    assert name not in made or made[name] is not value


def test_right_values_of_every_kind_are_printed() -> None:
    world = openfab.World(printer="generic")
    values = {
        "skin": np.float32(2), "tint": np.ones(3), "count": -(2**31), "code": np.uint32(2**32 - 1), "on": np.bool_(False),
        "steps": np.arange(4), "core": openfab.VOID, "picture": np.zeros((2, 2)), "field": np.zeros((2, 2, 2)),
        **CURVES,
    }
    made = world.add(openfab.box(1, 1, 1), openfab.Fablet(text=EVERY_KIND), values)
    made["steps"] = [[0, 1], [2, 3]]
    assert openfab.print_world(world, voxel=0.5).array().shape == (2, 2, 2)


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: openfab.Material("w", "white"), "`key` of material `w` cannot be 'white'; write it as #rrggbb, which is"),
        (lambda: openfab.Material("w", "#ffffff80"), "which is opaque"),
        (lambda: openfab.Material("w", "#ffffff", preview="#fff"), "#rrggbb or #rrggbbaa"),
        (lambda: openfab.Material("w", "#ffffff", density_g_cm3=0), "`density_g_cm3` of material `w` cannot be 0"),
        (lambda: openfab.Material("", "#ffffff"), "a material cannot be called ''"),
        (lambda: openfab.box(1, 0, 1), "`depth` cannot be 0; it is more than 0"),
        (lambda: openfab.sphere(-1), "`diameter` cannot be -1"),
        (lambda: openfab.cone(0, 0, 1), "one of them is more"), (lambda: openfab.cone(-1, 0, 1), "`low_diameter` cannot be -1"),
        (lambda: openfab.Texture(np.zeros((2, 2)), wrap="repeet"), "`wrap` of a texture cannot be 'repeet'; did you mean"),
        (lambda: openfab.Texture(np.zeros((2, 2)), space="rgb"), "`space` of a texture cannot be 'rgb'"),
        (lambda: openfab.Texture(np.zeros((2, 2)), wrap=("clamp", "x")), "`wrap` of a texture cannot be 'x'; it is one of"),
        (lambda: openfab.Texture.volume(np.zeros((2, 2, 2)), spacing_mm=0), "`spacing_mm` cannot be 0"),
        (lambda: openfab.World(pritner="j750"), "a key of a world cannot be 'pritner'"),
        (lambda: openfab.World(trai=(1, 2)), "did you mean `tray`"),
    ],
)
def test_things_are_refused_where_they_are_made(make: Callable[[], Any], text: str) -> None:
    with pytest.raises(openfab.InputError, match=text):
        make()


@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        ({"voxel": -1}, "`voxel`: `-1mm` is outside"), ({"layer": 0}, "`layer`: `0mm` is outside"),
        ({"dpi": (300, 0)}, "`dpi`: `300x0` is not a resolution"), ({"draft": 0}, "`draft`: `0` is not a whole number from 1"),
        ({"threads": -1}, "`threads`: `-1` is not a whole"), ({"memory": -5}, "`memory`: `-5B` is no memory"),
        ({"slices": (5, 5)}, "`slices`: `5:5` is an empty"), ({"slices": (-1, 5)}, "`slices`: `-1:5` is an empty or negative"),
    ],
)
def test_wrong_options_are_refused_by_the_call(ball: openfab.World, arguments: dict[str, Any], text: str) -> None:
    with pytest.raises(openfab.InputError, match=text):
        openfab.print_world(ball, **arguments)
    with pytest.raises(openfab.InputError, match="a key of a placement cannot be 'translat'; did you mean `translate_mm`"):
        ball.objects["ball"].place(translat=(1, 2, 3))
