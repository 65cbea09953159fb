# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Derivatives of fractions by uniforms, against closed forms in NumPy."""
from __future__ import annotations

import warnings

import numpy as np
import pytest
from numpy.typing import NDArray

import openfab

WHITE, BLACK = openfab.Material("white", "#ffffff"), openfab.Material("black", "#000000")

# The amounts are u exp(-|p - v|^2 / 9), and a[0] + a[1] p.x^2 + 2.
GRADED = """fablet Graded {
    @uniform {
        float u = 3; float3 v = float3(1, -1, 0.5); float a[2] = {0.3, 0.05}; float2x2 m = float2x2(1, 2, 3, 4);
        int n = 3; ImageTexture2D picture; Material one, other;
    }
    @Volume(@varying { VolumeAttributes attr })
    {
        float3 p = attr.voxelCenter;
        MaterialComposition mc;
        mc.Set(one, u * exp(-dot(p - v, p - v) / 9) + 0 * mul(m, p.xy).y);
        mc.Set(other, a[0] + a[1] * p.x * p.x + float(n) - 1 + 0 * picture.Sample1(p.x, p.y, 0));
        return mc;
    }
}
"""


def graded(**uniforms: object) -> openfab.World:
    world = openfab.World(printer="generic")
    fablet = openfab.Fablet(text=GRADED)
    picture = np.full((2, 2), 0.5, np.float32)
    values = {"one": WHITE, "other": BLACK, "picture": picture, **uniforms}
    world.add(openfab.box(6, 6, 6), fablet, values, name="cube")
    return world


def centres(samples: openfab.Samples) -> NDArray[np.float64]:
    """The voxels' centres in the object's own coordinates, (z, y, x, 3)."""
    z, y, x = np.meshgrid(*(np.arange(n) for n in samples.fractions.shape[:3]), indexing="ij")
    return (np.stack([x, y, z], -1) + 0.5) * samples.pitch_mm + samples.origin_mm


def amounts(p: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    away = p - (1, -1, 0.5)
    bell = np.exp(-np.sum(away**2, -1) / 9)
    return 3 * bell, 0.3 + 0.05 * p[..., 0] ** 2 + 2, away


def test_derivatives_are_the_closed_forms() -> None:
    names = ["cube.u", "cube.v", "cube.a", "cube.m"]
    samples = openfab.sample(graded(), voxel=0.5, jacobian=names)
    assert list(samples.jacobian) == names
    p = centres(samples)
    one, other, away = amounts(p)
    total = one + other
    share = one / total
    np.testing.assert_allclose(samples.fractions[..., 0], share, atol=2e-5)
    of_one, of_other = other / total**2, -one / total**2  # the change of the share by each amount
    expected = {
        "cube.u": of_one * one / 3,
        "cube.v": (of_one * one)[..., None] * away * 2 / 9,
        "cube.a": of_other[..., None] * np.stack([np.ones_like(one), p[..., 0] ** 2], -1),
        "cube.m": np.zeros((*one.shape, 2, 2)),
    }
    for name in names:
        got = samples.jacobian[name]
        np.testing.assert_allclose(got[..., 0, *[slice(None)] * (got.ndim - 4)], expected[name], atol=1e-5, err_msg=name)
        np.testing.assert_allclose(got[..., 1, *[slice(None)] * (got.ndim - 4)], -expected[name], atol=1e-5, err_msg=name)


def test_keys_of_curves() -> None:
    text = """fablet Curved {
    @uniform { Spline share; ColorRamp tint; Material one, other; }
    @Volume(@varying { VolumeAttributes attr })
    {
        float3 p = attr.voxelCenter;
        float s = share.At(p.x) * tint.At(p.y).g;
        MaterialComposition mc; mc.Set(one, s); mc.Set(other, 1 - s); return mc;
    }
}
"""
    lines = {"keys": [[-3, 0.2], [-1, 0.2], [2, 0.7], [3, 0.1]], "interpolation": "linear"}
    world = openfab.World(printer="generic")
    ramp = {"keys": [[-3, 0, 0.5, 0], [3, 0, 1, 0]]}
    world.add(openfab.box(6, 6, 6), openfab.Fablet(text=text), {"one": WHITE, "other": BLACK, "share": lines, "tint": ramp}, name="cube")
    samples = openfab.sample(world, voxel=0.5, jacobian=["cube.share[1]", "cube.share[2]", "cube.tint[0]"])
    p = centres(samples)
    green = 0.5 + (p[..., 1] + 3) / 12
    for key, hat in (1, [0, 1, 0, 0]), (2, [0, 0, 1, 0]):
        expected = np.interp(p[..., 0], [-3, -1, 2, 3], hat) * green
        np.testing.assert_allclose(samples.jacobian[f"cube.share[{key}]"][..., 0], expected, atol=1e-5)
    by_tint = samples.jacobian["cube.tint[0]"]
    assert by_tint.shape[-2:] == (2, 3)
    share = np.interp(p[..., 0], [-3, -1, 2, 3], [0.2, 0.2, 0.7, 0.1])
    np.testing.assert_allclose(by_tint[..., 0, 1], share * (3 - p[..., 1]) / 6, atol=1e-5)
    assert not by_tint[..., 0::2].any()
    with pytest.raises(openfab.InputError, match="`tint` has 2 keys, and none of the number 4"):
        openfab.sample(world, voxel=0.5, jacobian="cube.tint[4]")
    with pytest.raises(openfab.CompileError, match="by all of `share`"):
        openfab.sample(world, voxel=0.5, jacobian="cube.share")


def test_points_have_the_derivatives_of_their_voxels() -> None:
    world = graded()
    whole = openfab.sample(world, voxel=0.5, jacobian="cube.v")
    points = np.array([[[0.1, 0.2, 0.3], [-2.2, 1.1, 2.6]], [[2.9, -2.9, 0.1], [40, 0, 0]]])
    some = openfab.sample_at(world, points, voxel=0.5, jacobian="cube.v")
    assert some.jacobian["cube.v"].shape == (2, 2, 2, 3)
    at = np.floor((points.reshape(-1, 3)[:3] - whole.origin_mm) / whole.pitch_mm).astype(int)
    np.testing.assert_array_equal(
        some.jacobian["cube.v"].reshape(4, 2, 3)[:3], whole.jacobian["cube.v"][at[:, 2], at[:, 1], at[:, 0]]
    )
    assert not some.jacobian["cube.v"][1, 1].any(), "beside the part"


def test_bits_depend_on_no_threads_and_fractions_on_no_derivatives() -> None:
    world = graded()
    one = openfab.sample(world, voxel=0.25, jacobian=["cube.u", "cube.a"], threads=1)
    two = openfab.sample(world, voxel=0.25, jacobian=["cube.u", "cube.a"], threads=4)
    plain = openfab.sample(world, voxel=0.25, sampling="centre")
    np.testing.assert_array_equal(one.fractions, plain.fractions)
    for name in one.jacobian:
        np.testing.assert_array_equal(one.jacobian[name], two.jacobian[name])
    assert not plain.jacobian


def test_an_element_of_an_array_has_the_derivative_of_the_array() -> None:
    whole = openfab.sample(graded(), voxel=0.5, jacobian="cube.a").jacobian["cube.a"]
    one = openfab.sample(graded(), voxel=0.5, jacobian=["cube.a[1]", "cube.u"]).jacobian
    np.testing.assert_array_equal(one["cube.a[1]"], whole[..., 1])
    assert one["cube.u"].any()


# The distance to a ball of radius r is |p| - r; the shell is soft.
BALL = """fablet Ball {
    @uniform { float r = 3; float thick = 1; Material core, shell; }
    @Shape(@varying { ShapeAttributes attr }) { return 3 * (length(attr.p) - r); }
    @Volume(@varying { VolumeAttributes attr })
    {
        float inside = -distance(attr.voxelCenter);
        MaterialComposition mc;
        float t = inside / (inside + thick);
        mc.Set(core, t);
        mc.Set(shell, 1 - t);
        return mc;
    }
}
"""


def test_the_distance_to_a_shape_moves_with_its_surface() -> None:
    world = openfab.World(printer="generic")
    fablet = openfab.Fablet(text=BALL)
    shape = openfab.Shape(fablet, [[-4, -4, -4], [4, 4, 4]])
    world.add(shape, fablet, {"core": WHITE, "shell": BLACK}, name="ball")
    samples = openfab.sample(world, voxel=0.5, jacobian=["ball.r", "ball.thick"])
    # The distance is that to the diced surface, which the fractions tell: t = inside / (inside + 1). It grows as r does.
    t = samples.fractions[..., 0]
    inside = t > 0.05
    assert inside.sum() > 500
    for name, expected in {"ball.r": (1 - t) ** 2, "ball.thick": -t * (1 - t)}.items():
        np.testing.assert_allclose(samples.jacobian[name][inside][:, 0], expected[inside], atol=1e-4, err_msg=name)


def test_objects_of_one_fablet_have_columns_of_their_own() -> None:
    world = openfab.World(printer="generic")
    fablet = openfab.Fablet(text="""fablet Two {
        @uniform { float u = 1; Material one, other; }
        @Volume(@varying { VolumeAttributes attr })
        { MaterialComposition mc; mc.Set(one, u); mc.Set(other, 1.0); return mc; }
    }""")
    for name, u, x in (("left", 1.0, -5.0), ("right", 3.0, 5.0)):
        added = world.add(openfab.box(2, 2, 2), fablet, {"one": WHITE, "other": BLACK, "u": u}, name=name, place=False)
        added.place(translate=(x, 0, 0))
    samples = openfab.sample(world, voxel=0.5, jacobian=["right.u", "left.u"])
    left, right = samples.jacobian["left.u"][..., 0], samples.jacobian["right.u"][..., 0]
    # Every block has one mixture, which culling fills in other prints.
    assert set(np.unique(left)) == {0.0, np.float32(0.25)}
    assert set(np.unique(right)) == {0.0, np.float32(1 / 16)}
    assert not (left * right).any()


@pytest.mark.parametrize(
    "names, said",
    [
        (["cube.w"], "declares no uniform `w`"),
        (["ball.u"], "no object `ball`"),
        (["cube.a[2]"], "`a` has 2 elements"),
        (["cube.a[x]"], "declares no uniform"),
        (["u"], "OBJECT.UNIFORM"),
        (["cube.n"], "`int`"),
    ],
)
def test_what_has_no_derivative_is_named(names: list[str], said: str) -> None:
    with pytest.raises(openfab.Error, match=said):
        openfab.sample(graded(), voxel=0.5, jacobian=names)


def test_means_have_no_derivatives() -> None:
    with pytest.raises(openfab.InputError, match="centres"):
        openfab.sample(graded(), voxel=0.5, jacobian="cube.u", sampling="volume")


def test_a_fraction_that_jumps_is_told() -> None:
    world = openfab.World(printer="generic")
    fablet = openfab.Fablet(text="""fablet Jumps {
    @uniform { float u = 0.3; float w = 2; Material one, other; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        mc.Set(one, attr.voxelCenter.x < u ? w : 1);
        mc.Set(other, 1.0);
        return mc;
    }
}""")
    world.add(openfab.box(2, 2, 2), fablet, {"one": WHITE, "other": BLACK}, name="cube")
    with pytest.warns(openfab.CompilerWarning, match="jumps with `u`"):
        by_u = openfab.sample(world, voxel=0.5, jacobian="cube.u").jacobian["cube.u"]
    assert not by_u.any()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        by_w = openfab.sample(world, voxel=0.5, jacobian="cube.w").jacobian["cube.w"]
    np.testing.assert_allclose(np.unique(by_w[..., 0]), [0, 1 / 9], atol=1e-7)


def test_a_lookup_that_moves_is_refused_at_its_place() -> None:
    world = openfab.World(printer="generic")
    fablet = openfab.Fablet(text="""fablet Moved {
    @uniform { float u = 1; ImageTexture2D picture; Material one; }
    @Volume(@varying { VolumeAttributes attr })
    { MaterialComposition mc; mc.Set(one, picture.Sample1(attr.voxelCenter.x * u, 0.5, 0)); return mc; }
}""")
    world.add(openfab.box(2, 2, 2), fablet, {"one": WHITE, "picture": np.ones((2, 2), np.float32)}, name="cube")
    with pytest.raises(openfab.CompileError) as raised:
        openfab.sample(world, voxel=0.5, jacobian="cube.u")
    assert "[no-derivative]" in str(raised.value)
    assert "fablet.fl:4:" in str(raised.value)


# A cube of half side u, and a ball of radius u: the first value is 0 on both sides of the surface's formula.
SOLIDS = {
    "cube": "float3 q = abs(p) - u; return length(max(q, 0)) + min(max(q.x, max(q.y, q.z)), 0);",
    "ball": "return length(p - float3(0.25, 0, 0)) - u;",
}


@pytest.mark.parametrize("declared", ["", "[[ distance ]]"])
@pytest.mark.parametrize("solid", SOLIDS)
@pytest.mark.parametrize("scale", [1, 1.5])
def test_a_shape_moves_by_its_scale(solid: str, declared: str, scale: float) -> None:
    fablet = openfab.Fablet(text=f"""fablet Solid {{
        @uniform {{ float u = 2; Material one, other; }}
        @Shape(@varying {{ ShapeAttributes attr }}) {declared} {{ float3 p = attr.p; {SOLIDS[solid]} }}
        @Volume(@varying {{ VolumeAttributes attr }})
        {{ MaterialComposition mc; mc.Set(one, 10 + distance(attr.voxelCenter)); mc.Set(other, 10.0); return mc; }}
    }}""")
    world = openfab.World(printer="generic")
    added = world.add(
        openfab.shape(fablet, [[-3, -3, -3], [3, 3, 4]]), fablet, {"one": WHITE, "other": BLACK}, name="it", place=False
    )
    added.place(scale=scale)
    samples = openfab.sample(world, voxel=0.3, jacobian="it.u")
    share = samples.fractions[..., 0]
    inside = share > 0.1
    assert inside.sum() > 500
    # The share is a / (a + 10), where a is 10 + d, and d shrinks by the scale.
    np.testing.assert_allclose(
        samples.jacobian["it.u"][inside][:, 0], -scale * (1 - share[inside]) ** 2 / 10, atol=2e-4
    )


def test_a_mesh_does_not_move_with_its_fablets_shape() -> None:
    world = openfab.World(printer="generic")
    world.add(openfab.box(3, 3, 3), openfab.Fablet(text=BALL), {"core": WHITE, "shell": BLACK}, name="block")
    samples = openfab.sample(world, voxel=0.5, jacobian=["block.r", "block.thick"])
    assert samples.jacobian["block.thick"].any()
    assert not samples.jacobian["block.r"].any()
