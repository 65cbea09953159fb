# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import gc
import inspect
import json
from pathlib import Path
from typing import Any, Callable

import numpy as np
import pytest
from conftest import BALL, BY_VOLUME

import openfab
from openfab import _core

RED, BLUE = openfab.Material("red", "#ff0000"), openfab.Material("blue", "#0000ff")

BOX_VERTICES = np.array([(x, y, z) for z in (0, 3) for y in (-2, 2) for x in (-1, 1)], float)
BOX_FACES = np.array(
    [(0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6)]
    + [(1, 3, 5), (3, 7, 5)]
)

BY_PICTURE = """fablet ByPicture {
    @uniform { ImageTexture2D picture; Material one, other; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        float3 p = attr.voxelCenter;
        float t = picture.Sample1(p.x / 4 + 0.5, p.y / 4 + 0.5, 0, 0);
        mc.Set(one, t);
        mc.Set(other, 1 - t);
        return mc;
    }
}
"""


def solid(mesh: object, **keys: object) -> openfab.World:
    world = openfab.World(printer="generic", **keys)
    world.add(mesh, openfab.Fablet(text=BALL), {"core": RED, "shell": BLUE})
    return world


def test_a_mesh_of_arrays_prints_as_the_primitive() -> None:
    arrays = openfab.print_world(solid(openfab.Mesh(BOX_VERTICES, BOX_FACES)), voxel=0.25).array()
    primitive = openfab.print_world(solid(openfab.box(2, 4, 3)), voxel=0.25).array()
    np.testing.assert_array_equal(arrays, primitive)
    assert arrays.shape == (12, 16, 8) and arrays.all()


def test_a_trimesh_is_a_mesh() -> None:
    trimesh = pytest.importorskip("trimesh")
    made = trimesh.creation.box(extents=(2, 4, 3))
    made.apply_translation((0, 0, 1.5))
    codes = openfab.print_world(solid(made), voxel=0.25).array()
    np.testing.assert_array_equal(codes, openfab.print_world(solid(openfab.box(2, 4, 3)), voxel=0.25).array())


def test_attributes_reach_the_fablet() -> None:
    text = """fablet ByAttribute {
        @uniform { Material one, other; }
        @Volume(@varying { VolumeAttributes attr, @nearest float heat, @nearest int zone })
        {
            MaterialComposition mc;
            if (zone == 7) mc.Set(one, 1);
            else { mc.Set(one, heat); mc.Set(other, 1 - heat); }
            return mc;
        }
    }
    """
    top = np.isin(BOX_FACES, (4, 5, 6, 7)).all(axis=1)
    mesh = openfab.Mesh(
        BOX_VERTICES, BOX_FACES, vertex_attributes={"heat": (BOX_VERTICES[:, 1] + 2) / 4},
        face_attributes={"zone": np.where(top, 7, 0)},
    )
    world = openfab.World(printer="generic")
    world.add(mesh, openfab.Fablet(text=text), {"one": RED, "other": BLUE})
    red = openfab.sample(world, voxel=0.25, sampling="centre").fractions[..., 0]
    assert (red[-1] == 1).all()
    np.testing.assert_allclose(red[0, :, 4], (np.arange(16) + 0.5) / 16, atol=1e-4)


@pytest.mark.parametrize("names", ["s t", "v u", "r g b", "blue green red", "a_0 a_1", "a_y a_x", "k_w k_z k_y k_x"])
def test_attributes_keep_their_names(names: str) -> None:
    values = {name: 1.0 + k for k, name in enumerate(names.split())}
    materials = {f"m{k}": openfab.Material(f"m{k}", f"#00000{k}") for k in range(len(values))}
    declared = ", ".join(f"@nearest float {name}" for name in values)
    parts = " ".join(f"mc.Set({material}, {name});" for material, name in zip(materials, values))
    text = f"""fablet Named {{
        @uniform {{ Material {", ".join(materials)}; }}
        @Volume(@varying {{ VolumeAttributes attr, {declared} }}) {{ MaterialComposition mc; {parts} return mc; }}
    }}"""
    attributes = {name: np.full(8, value) for name, value in values.items()}
    mesh = openfab.Mesh(BOX_VERTICES, BOX_FACES, vertex_attributes=attributes)
    world = openfab.World(printer="generic")
    world.add(mesh, openfab.Fablet(text=text), materials)
    expected = np.array(list(values.values())) / sum(values.values())
    np.testing.assert_allclose(openfab.sample(world, voxel=1, sampling="centre").fractions[0, 0, 0], expected, atol=1e-4)


@pytest.mark.parametrize("kind", ["uint8", "uint16", "float32", "float64"])
def test_a_picture_is_an_array(kind: str) -> None:
    rng = np.random.default_rng(3)
    values = rng.random((16, 16))
    scale = {"uint8": 255, "uint16": 65535}.get(kind, 1)
    picture = (values * scale).round().astype(kind)
    world = openfab.World(printer="generic")
    texture = openfab.Texture(picture, filter="nearest", space="linear")
    world.add(openfab.box(4, 4, 1), openfab.Fablet(text=BY_PICTURE), {"picture": texture, "one": RED, "other": BLUE})
    found = openfab.sample(world, voxel=0.25, sampling="centre").fractions[0, :, :, 0]
    # The picture's first row is at the highest y.
    np.testing.assert_allclose(found, (picture / scale)[::-1], atol=2e-5)


def test_pictures_have_channels() -> None:
    text = BY_PICTURE.replace("0, 0);", "2, 0);")
    picture = np.zeros((4, 4, 3), np.float32)
    picture[..., 2] = 0.75
    world = openfab.World(printer="generic")
    world.add(openfab.box(4, 4, 1), openfab.Fablet(text=text), {"picture": picture, "one": RED, "other": BLUE})
    np.testing.assert_allclose(openfab.sample(world, voxel=1, sampling="centre").fractions[..., 0], 0.75, atol=2e-5)


def test_a_volume_is_an_array() -> None:
    rng = np.random.default_rng(4)
    field = rng.random((6, 8, 10)).astype(np.float32)
    world = openfab.World(printer="generic")
    volume = openfab.Texture.volume(field, origin_mm=(-2.5, -2, 0), spacing_mm=0.5, filter="nearest")
    world.add(openfab.box(5, 4, 3), openfab.Fablet(text=BY_VOLUME), {"field": volume, "one": RED, "other": BLUE})
    np.testing.assert_allclose(openfab.sample(world, voxel=0.5, sampling="centre").fractions[..., 0], field, atol=2e-5)


# Two cubes of 1 that are 2 apart, with x of 0 to 4 as the field `along`, 0 to 1.
CUBES_VTU = """<VTKFile type="UnstructuredGrid" version="1.0"><UnstructuredGrid>
<Piece NumberOfPoints="16" NumberOfCells="2"><PointData>
<DataArray type="Float32" Name="along" format="ascii">0 .25 .25 0 0 .25 .25 0 .75 1 1 .75 .75 1 1 .75</DataArray>
<DataArray type="Float32" Name="flat" format="ascii">1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1</DataArray>
</PointData><Points><DataArray type="Float32" NumberOfComponents="3" format="ascii">
0 0 0  1 0 0  1 1 0  0 1 0  0 0 1  1 0 1  1 1 1  0 1 1
3 0 0  4 0 0  4 1 0  3 1 0  3 0 1  4 0 1  4 1 1  3 1 1
</DataArray></Points><Cells>
<DataArray type="Int32" Name="connectivity" format="ascii">0 1 2 3 4 5 6 7  8 9 10 11 12 13 14 15</DataArray>
<DataArray type="Int32" Name="offsets" format="ascii">8 16</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">12 12</DataArray>
</Cells></Piece></UnstructuredGrid></VTKFile>"""


def by_field(folder: Path, **keys: Any) -> openfab.World:
    (folder / "cubes.vtu").write_text(CUBES_VTU)
    world = openfab.World(printer="generic")
    volume = openfab.Texture.volume(folder / "cubes.vtu", filter="nearest", **keys)
    world.add(openfab.box(40, 10, 10), openfab.Fablet(text=BY_VOLUME), {"field": volume, "one": RED, "other": BLUE})
    return world


def test_a_volume_is_a_field_of_a_file(tmp_path: Path) -> None:
    world = by_field(tmp_path, field="along", unit="cm", pitch_mm=0.5, outside=0.6, origin_mm=(-20, -5, 0))
    row = openfab.sample(world, ((-20, 0, 5), (20, 0.5, 5.5)), voxel=0.5, sampling="centre").fractions[0, 0, :, 0]
    along = (np.arange(80) + 0.5) / 80
    np.testing.assert_allclose(row[:20], along[:20], atol=2e-5)
    np.testing.assert_allclose(row[26:54], 0.6, atol=2e-5)
    np.testing.assert_allclose(row[60:], along[60:], atol=2e-5)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({}, "along"),
        ({"field": "across"}, "across"),
        ({"field": "flat", "unit": "yard"}, "`unit` of texture"),
        ({"field": "flat", "pitch_mm": -1}, "`pitch_mm` cannot be -1; it is more than 0"),
        ({"field": "flat", "outside": 1e31}, "`outside` of texture"),
    ],
)
def test_fields_are_refused_as_in_a_world(tmp_path: Path, keys: dict[str, Any], message: str) -> None:
    with pytest.raises(openfab.InputError, match=message):
        openfab.sample(by_field(tmp_path, **keys), voxel=2, sampling="centre")


def test_files_go_with_their_owners() -> None:
    mesh = openfab.Mesh(BOX_VERTICES, BOX_FACES)
    path = mesh._file.path()
    assert path.exists()
    del mesh
    gc.collect()
    assert not path.exists()


def test_objects_are_placed_many_times() -> None:
    world = openfab.World(printer="generic")
    pin = world.add(openfab.box(1, 1, 1), openfab.Fablet(text=BALL), {"core": RED, "shell": BLUE}, place=False)
    pin.place(translate=(0, 0, 0))
    pin.place(translate=(3, 0, 0), uniforms={"core": openfab.VOID, "shell": openfab.VOID})
    pin.place(translate=(6, 0, 0))
    # What prints nothing takes no place beyond the others.
    pin.place(translate=(9, 0, 0), uniforms={"core": openfab.VOID, "shell": openfab.VOID})
    codes = openfab.print_world(world, voxel=0.25).array()
    assert codes[:, :, :4].all() and not codes[:, :, 4:24].any() and codes[:, :, 24:].all()
    assert codes.shape == (4, 4, 28)


def test_mistakes_are_told_when_they_are_made() -> None:
    world = openfab.World()
    fablet = openfab.Fablet(text=BALL)
    with pytest.raises(openfab.InputError, match="no uniform `skim`") as caught:
        world.add(openfab.sphere(1), fablet, {"skim": 1})
    assert caught.value.help == "did you mean `skin`?"
    with pytest.raises(openfab.InputError, match="shape"):
        openfab.Mesh(BOX_VERTICES[:, :2], BOX_FACES)
    with pytest.raises(openfab.InputError, match="no mesh"):
        world.add(3, fablet)
    with pytest.raises(openfab.InputError, match="two materials are called"):
        world.add(openfab.sphere(1), fablet, {"core": RED, "shell": openfab.Material("red", "#880000")})
        openfab.print_world(world)


def test_a_mistake_in_the_world_has_its_place() -> None:
    world = openfab.World(printer="generic", support="resin")
    world.add(openfab.sphere(1), openfab.Fablet(text=BALL), {"core": RED, "shell": BLUE})
    with pytest.raises(openfab.InputError, match="resin") as caught:
        openfab.print_world(world, voxel=0.2).array()
    assert caught.value.file.endswith(".fab.json") and caught.value.line > 0


def test_a_file_that_is_no_world_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "a.fab.json").write_text("{")
    for name in ("a.fab.json", "b.fab.json"):
        with pytest.raises(openfab.InputError):
            openfab.load(tmp_path / name)


RULES = """import dither;
int coarse(DitherAttributes voxel) { return dither_dots(voxel, 0.6, 0.3); }
int fine(DitherAttributes voxel) { return dither_dots(voxel, 0.2, 0.3); }
"""


def test_a_world_names_the_dither_rule(tmp_path: Path, tool: Callable[..., dict[str, Any]]) -> None:
    (tmp_path / "screens.fl").write_text(RULES)
    hashes = {}
    for rule in ("coarse", "fine"):
        world = solid(openfab.box(2, 4, 3), dither={"source": tmp_path / "screens.fl", "rule": rule})
        hashes[rule] = openfab.print_world(world, tmp_path / "a.ofr", voxel=0.1).statistics["hash"]
        saved = tmp_path / f"{rule}.fab.json"
        (tmp_path / "ball.fl").write_text(BALL)
        described = world.to_json()
        described["fablets"]["Ball"]["source"] = "ball.fl"
        saved.write_text(json.dumps(described))
        print_ = openfab.print_world(openfab.load(saved), tmp_path / "b.ofr", voxel=0.1)
        assert print_.statistics["hash"] == hashes[rule]
        assert tool(saved, "-o", str(tmp_path / "c.ofr"), "--voxel", "0.1mm")["hash"] == hashes[rule]
    plain = openfab.print_world(solid(openfab.box(2, 4, 3)), tmp_path / "a.ofr", voxel=0.1).statistics["hash"]
    assert len({plain, *hashes.values()}) == 3


def test_a_dither_rule_that_is_none_says_which_there_are(tmp_path: Path) -> None:
    (tmp_path / "screens.fl").write_text(RULES)
    world = solid(openfab.box(2, 4, 3), dither={"source": tmp_path / "screens.fl", "rule": "course"})
    with pytest.raises(openfab.CompileError, match="`coarse`, `fine`"):
        openfab.print_world(world, tmp_path / "a.ofr", voxel=0.5)


ROUND = """fablet Round {
    @uniform { float radius = 3; }
    @Shape(@varying { ShapeAttributes attr }) [[ distance ]] { return length(attr.p) - radius; }
}
"""


def test_a_shape_is_where_its_function_is_negative() -> None:
    for uniforms, radius in ((None, 3.0), ({"radius": 2}, 2.0)):
        codes = openfab.print_world(
            solid(openfab.shape(ROUND, [(-4, -4, -4), (4, 4, 4)], uniforms)), voxel=0.25
        ).array()
        at = (np.indices(codes.shape) + 0.5) * 0.25 - radius
        np.testing.assert_array_equal(codes != 0, (at**2).sum(0) < radius**2)


def test_a_text_that_is_given_twice_is_one_fablet() -> None:
    source = """fablet Solid {
        @uniform { Material resin; float radius = 3; }
        @Shape(@varying { ShapeAttributes attr }) [[ distance ]] { return length(attr.p) - radius; }
        @Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc; mc.Set(resin, 1); return mc; }
    }"""
    world = openfab.World(printer="generic")
    shape = openfab.shape(source, [(-4, -4, -4), (4, 4, 4)])
    world.add(shape, openfab.Fablet(text=source), {"resin": RED, "radius": 2})
    assert list(world.to_json()["fablets"]) == ["Solid"]
    codes = openfab.print_world(world, voxel=0.25).array()
    at = (np.indices(codes.shape) + 0.5) * 0.25 - 2
    np.testing.assert_array_equal(codes != 0, (at**2).sum(0) < 4)


def test_shapes_of_one_fablet_have_values_of_their_own() -> None:
    fablet = openfab.Fablet(text=ROUND)
    world = solid(openfab.shape(fablet, [(-4, -4, -4), (4, 4, 4)], {"radius": 2}))
    world.add(openfab.shape(fablet, [(-4, -4, -4), (4, 4, 4)]), openfab.Fablet(text=BALL), {"core": RED, "shell": BLUE})
    described = world.to_json()
    stages = [described["fablets"][mesh["shape"]] for mesh in described["meshes"].values()]
    assert [stage.get("uniforms") for stage in stages] == [{"radius": 2}, None]


@pytest.mark.parametrize(
    ("box", "uniforms", "said"),
    [
        ([(0, 0, 0)], None, r"`box` has the shape \(1, 3\)"),
        ([(0, 0, 0), (1, 0, 1)], None, "`box` is empty"),
        ([(0, 0, 0), (1, 1, 1)], {"size": 1}, "`Round` has no uniform `size`"),
    ],
)
def test_a_shape_is_checked_when_it_is_made(box: Any, uniforms: Any, said: str) -> None:
    with pytest.raises(openfab.InputError, match=said):
        openfab.shape(ROUND, box, uniforms)


def test_a_text_of_one_line_is_no_file() -> None:
    source = "fablet A { @Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc; return mc; } }"
    with pytest.raises(openfab.InputError, match="fablet `A` has no @Shape or @Grow stage"):
        openfab.shape(source, [(0, 0, 0), (1, 1, 1)])


def test_a_shape_needs_the_stage() -> None:
    assert openfab.Fablet(text=ROUND).has_shape
    with pytest.raises(openfab.InputError, match="fablet `Ball` has no @Shape or @Grow stage"):
        openfab.shape(openfab.Fablet(text=BALL), [(0, 0, 0), (1, 1, 1)])


def test_every_key_that_is_a_path_counts_from_the_working_directory(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = {"name": "own", "pitch_mm": [1, 1, 1], "build_volume_mm": [90, 90, 90], "max_materials": 8, "native_format": "ofr"}
    (tmp_path / "own.printer.json").write_text(json.dumps(own))
    (tmp_path / "pins.txt").write_text("0 0 0\n6 0 0\n")
    (tmp_path / "cuts.json").write_text(json.dumps({"normal": [1, 0, 0], "at_mm": 0, "back": "left", "front": "right"}))
    monkeypatch.chdir(tmp_path)
    fablet = openfab.Fablet(text=BALL)
    world = openfab.World(printer="own.printer.json", groups={"row": [{"object": "ball", "transforms": "pins.txt"}]})
    made = world.add(
        openfab.box(2, 4, 3), fablet, {"core": RED, "shell": BLUE}, pieces="cuts.json", piece="left", transforms="pins.txt"
    )
    monkeypatch.chdir("/")
    # Of 1 mm: halves of a box of 2 mm, 6 mm apart.
    codes = openfab.print_world(world).array()
    assert codes.shape == (3, 4, 7) and (codes[:, :, [0, 6]] != 0).all() and not codes[:, :, 1:6].any()
    described = world.to_json()
    assert described["groups"]["row"][0]["transforms"] == str(tmp_path / "pins.txt")
    assert described["objects"][made.name]["pieces"] == str(tmp_path / "cuts.json")


def test_a_group_is_placed_with_values_of_its_own() -> None:
    groups = {"pair": [{"object": "one"}, {"object": "one", "translate_mm": [6, 0, 0]}]}
    world = openfab.World(printer="generic", groups=groups)
    text = """fablet One { @uniform { Material stuff; }
        @Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc; mc.Set(stuff, 1); return mc; } }"""
    world.add(openfab.box(2, 2, 2), openfab.Fablet(text=text), {"stuff": RED}, name="one", place=False)
    world.place_group("pair")
    world.place_group("pair", translate=(0, 4), uniforms={"one.stuff": BLUE})
    codes = openfab.print_world(world, voxel=1).array()
    expected = np.zeros((2, 6, 8), np.uint8)
    for y, code in ((0, 1), (4, 2)):
        expected[:, y:y + 2, :2] = expected[:, y:y + 2, 6:] = code
    np.testing.assert_array_equal(codes, expected)
    for name, uniforms in (("pare", {}), ("pair", {"two.stuff": RED}), ("pair", {"one.stuf": RED})):
        with pytest.raises(openfab.InputError, match="did you mean|cannot be"):
            world.place_group(name, uniforms=uniforms)
    assert len(world.to_json()["build"]) == 2


def test_every_key_of_a_world_has_a_way_to_give_it() -> None:
    """A new key of the loader is given here, or this fails."""

    def names(call: Any) -> set[str]:
        given = inspect.signature(call).parameters.values()
        return {"**" if one.kind is inspect.Parameter.VAR_KEYWORD else one.name for one in given}

    # Whatever is no argument of theirs is a key.
    for call in (openfab.World, openfab.World.add, openfab.Object.place, openfab.FileMesh):
        assert "**" in names(call), call
    assert set(_core.world_keys("material")) == names(openfab.Material) - {"name"}
    told = {"picture", "volume"}
    assert set(_core.world_keys("texture")) == {"file"} | (
        (names(openfab.Texture) | names(openfab.Texture.volume)) - told
    )
    assert set(_core.world_keys("fablet")) == {"source", "fablet", "uniforms"}


def test_keys_of_a_mesh_file_are_those_of_a_world(tmp_path: Path) -> None:
    file = tmp_path / "two.obj"
    file.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\no a\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n")
    assert openfab.FileMesh(file, body="a")._spec() == {"file": str(file), "body": "a"}
    with pytest.raises(openfab.InputError, match="a key of a mesh cannot be 'bodi'; did you mean `body`"):
        openfab.FileMesh(file, bodi="a")
