# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Level sets, volumetric data, displacements and lattices of 3MF: printed voxels against closed forms, and against
`implicit.py`, an evaluator of its own."""

from __future__ import annotations

import random
import zipfile
from pathlib import Path
from typing import Any, Callable, Sequence

import lib3mf
import numpy as np
import pytest
from conftest import VOXEL, Print, box, run
from functions_3mf import POS, Graph, ball, cube, package, png, strict, volume
from implicit import Model


def test_a_ball_in_a_box_that_cuts_it(tmp_path: Path, imported: Callable[..., Print]) -> None:
    file = package(
        tmp_path / "ball.3mf",
        ball(1, 9.0)
        + f'<object id="2" type="model">{cube(-10, 10)}</object><object id="3" type="model" name="ball">'
        '<v:levelset functionid="1" channel="shape" meshid="2" transform="1 0 0 0 1 0 0 0 1 0 0 0"/></object>',
        '<item objectid="3" transform="1 0 0 0 2 0 0 0 1 30 0 0"/>',
        "v i",
    )
    strict(file)
    made = imported(file)
    assert volume(made) == pytest.approx(2 * 4 / 3 * np.pi * 9**3, rel=2e-3)
    # Twice as long in y.
    used = np.argwhere(made.codes > 0)
    assert np.ptp(used, axis=0) + 1 == pytest.approx([36, 72, 36], abs=1)


def test_materials_are_mixed_by_functions(tmp_path: Path, imported: Callable[..., Print]) -> None:
    g = Graph()
    g.add("decomposevector", "scalar", output="x y z", A=POS)
    tenth = g.constant(0.1)
    up = g.add("multiplication", "scalar", A=("n0.z", "scalar"), B=tenth)
    down = g.add("subtraction", "scalar", A=g.constant(1.0), B=up)
    file = package(
        tmp_path / "mixed.3mf",
        '<basematerials id="1"><base name="hard" displaycolor="#FF0000"/><base name="soft" displaycolor="#0000FF"/></basematerials>'
        + g.function(2, {"up": up, "down": down})
        + '<v:volumedata id="3"><v:composite basematerialid="1"><v:materialmapping functionid="2" channel="up"/>'
        '<v:materialmapping functionid="2" channel="down"/></v:composite></v:volumedata>'
        f'<object id="4" type="model" name="cube">{cube(0, 10, " volumeid=" + chr(34) + "3" + chr(34))}</object>',
        '<item objectid="4" transform="1 0 0 0 1 0 0 0 1 0 0 7"/>',
        "v i",
    )
    made = imported(file)
    assert volume(made) == pytest.approx(1000)
    for z in (0.25, 3.25, 9.75):
        assert made.mix(5, 5, z) == pytest.approx({"hard": z / 10, "soft": 1 - z / 10}, abs=0.003)


@pytest.mark.parametrize("style", ["wrap", "mirror", "clamp"])
@pytest.mark.parametrize("kind", ["linear", "nearest"])
def test_images_are_levels(tmp_path: Path, imported: Callable[..., Print], style: str, kind: str) -> None:
    rng = np.random.default_rng(7)
    sheets = {f"3D/v/{k}.png": png(rng.integers(0, 256, (5, 6), dtype=np.uint8)) for k in range(4)}
    styles = f'tilestyleu="{style}" tilestylev="clamp" tilestylew="{style}"'
    file = package(
        tmp_path / "image.3mf",
        '<v:image3d id="1"><v:imagestack rowcount="5" columncount="6" sheetcount="4">'
        + "".join(f'<v:imagesheet path="/{n}"/>' for n in sheets)
        + "</v:imagestack></v:image3d>"
        f'<v:functionfromimage3d id="2" image3did="1" valueoffset="-1" valuescale="2" {styles} filter="{kind}"/>'
        f'<object id="4" type="model">{cube(-10, 10)}</object><object id="5" type="model"><v:levelset functionid="2" '
        'channel="red" meshid="4" meshbboxonly="true" transform="0.0731 0 0 0 0.0631 0 0 0 0.0831 0.1 0.3 0.2"/></object>',
        '<item objectid="5"/>',
        "v",
        sheets,
    )
    made = imported(file)
    model = Model(file)
    level_set = model.objects("levelset")[0]
    low, high = model.bounds(level_set)
    axes = [np.arange(l + VOXEL / 2, h, VOXEL) for l, h in zip(low, high)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    level = model.level(level_set, points)
    assert volume(made) == pytest.approx(float((level < 0).sum()) * VOXEL**3, rel=4e-3)


def random_graph(rng: random.Random, size: int) -> tuple[Graph, tuple[str, str]]:
    """Returns a graph of all kinds of nodes, whose last value lies between 0 and 1."""
    g = Graph()
    scalars = [g.constant(round(rng.uniform(-2, 2), 3)) for _ in range(2)]
    vectors: list[tuple[str, str]] = [POS, g.add("constvec", "vector", 'x="0.5" y="-1.25" z="2"', "vector")]
    matrices: list[tuple[str, str]] = []

    def one(things: Sequence[tuple[str, str]]) -> tuple[str, str]:
        return rng.choice(things[-4:])

    unary = ["sin", "cos", "abs", "floor", "ceil", "round", "sign", "fract", "arctan", "tanh"]
    binary = ["addition", "subtraction", "multiplication", "min", "max", "division", "fmod", "mod", "arctan2"]
    for _ in range(size):
        lists = {"scalar": scalars, "vector": vectors, "matrix": matrices}
        kind = rng.choice(["unary", "binary", "make", "product", "select", "matrix"])
        of = rng.choice(["scalar", "vector"] + (["matrix"] if matrices else []))
        things = lists[of]
        if kind == "unary":
            name = rng.choice(unary[:8] if of == "matrix" else unary)
            things.append(g.add(name, of, A=one(things)))
        elif kind == "binary":
            name = rng.choice(binary[:5] if of == "matrix" else binary)
            things.append(g.add(name, of, A=one(things), B=one(things)))
        elif kind == "select":
            things.append(g.add("select", of, A=one(things), B=one(things), C=one(things), D=one(things)))
        elif kind == "make":
            if rng.random() < 0.5:
                vectors.append(g.add("composevector", "vector", x=one(scalars), y=one(scalars), z=one(scalars)))
            else:
                name, _ = g.add("decomposevector", "scalar", output="x y z", A=one(vectors))
                scalars.append((name[:-1] + rng.choice("xyz"), "scalar"))
        elif kind == "product":
            if rng.random() < 0.5:
                scalars.append(g.add(rng.choice(["dot"]), "scalar", A=one(vectors), B=one(vectors)))
            else:
                scalars.append(g.add("length", "scalar", A=one(vectors)))
            vectors.append(g.add("cross", "vector", A=one(vectors), B=one(vectors)))
        else:
            make = rng.choice(["matrixfromrows", "matrixfromcolumns"])
            matrices.append(g.add(make, "matrix", A=one(vectors), B=one(vectors), C=one(vectors), D=one(vectors)))
            if rng.random() < 0.5:
                matrices.append(g.add("transpose", "matrix", A=one(matrices)))
            vectors.append(g.add("matvecmultiplication", "vector", A=one(matrices), B=one(vectors)))
    value = g.add("addition", "scalar", A=g.add("length", "scalar", A=vectors[-1]), B=scalars[-1])
    above = g.add("addition", "scalar", A=g.constant(1.0), B=g.add("abs", "scalar", A=value))
    bent = g.add("division", "scalar", A=value, B=above)
    half = g.constant(0.5)
    return g, g.add("addition", "scalar", A=half, B=g.add("multiplication", "scalar", A=bent, B=half))


AT_ONCE = 50


@pytest.mark.parametrize("seed", range(20))
def test_random_graphs(tmp_path: Path, imported: Callable[..., Print], seed: int) -> None:
    rng = random.Random(seed)
    functions, names = "", []
    for number in range(AT_ONCE):
        g, value = random_graph(rng, rng.randint(3, 12))
        functions += g.function(100 + number, {"share": value})
        names.append(f"m{number}")
    bases = "".join(f'<base name="{n}" displaycolor="#{40 + 4 * k:02X}8040"/>' for k, n in enumerate(names))
    mapped = "".join(f'<v:materialmapping functionid="{100 + k}" channel="share"/>' for k in range(AT_ONCE))
    attribute = ' volumeid="3"'
    composite = f'<v:composite basematerialid="1">{mapped}</v:composite>'

    def written(name: str, mixture: str) -> Path:
        return package(
            tmp_path / f"{name}{seed}.3mf",
            f'<basematerials id="1">{bases}</basematerials>{functions}<v:volumedata id="3">{mixture}</v:volumedata>'
            f'<object id="4" type="model" name="cube">{cube(0, 3, attribute)}</object>',
            '<item objectid="4"/>',
            "v i",
        )

    # lib3mf 2.5 knows no mixtures.
    strict(written("functions", ""))
    file = written("random", composite)
    made = imported(file)
    model = Model(file)
    axis = np.arange(VOXEL / 2, 3, VOXEL)
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    points = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    wiggles = [points, points * (1 + 2e-6), points - 2e-6, points + np.array([2e-6, -1e-6, 1e-6])]
    shares = []
    for wiggle in wiggles:
        share = np.stack([model.level(m, wiggle) for m in model.objects("materialmapping")], axis=1)
        shares.append(np.nan_to_num(np.clip(share, 0, 1), nan=0.0))
    # A graph that jumps at a voxel says nothing there; among the others the shares are what they are.
    steady = np.max([np.abs(s - shares[0]) for s in shares[1:]], axis=0) < 1e-4
    assert steady.mean() > 0.95 and steady.sum(axis=0).min() > 0
    order = [made.names.index(n) for n in names]
    seen = np.where(steady, made.fractions[..., order].reshape(len(points), -1), 0)
    wanted = np.where(steady, shares[0], 0)
    # Shares of 16 bits, of which a part may be with those that jump.
    part = seen.sum(axis=1)
    enough = part > 0.05
    assert enough.mean() > 0.9
    error = np.abs(seen[enough] / part[enough, None] - wanted[enough] / wanted[enough].sum(axis=1, keepdims=True))
    assert (error.max(axis=1) * part[enough]).max() < 3e-4


def test_displaced_faces(tmp_path: Path, imported: Callable[..., Print]) -> None:
    """A cube whose top is raised by a map: half of 4 mm everywhere."""
    corners, faces = box(20)
    vertices = "".join(f'<d:vertex x="{x:g}" y="{y:g}" z="{z:g}"/>' for x, y, z in corners)
    triangles = ""
    for a, b, c in faces:
        top = all(corners[i][2] == 20 for i in (a, b, c))
        at = f' did="7" d1="{a % 4}" d2="{b % 4}" d3="{c % 4}"' if top else ""
        triangles += f'<d:triangle v1="{a}" v2="{b}" v3="{c}"{at}/>'
    grey = png(np.full((8, 8), 128, dtype=np.uint8))
    file = package(
        tmp_path / "raised.3mf",
        '<d:displacement2d id="3" path="/3D/t.png" channel="R" tilestyleu="wrap" tilestylev="wrap"/>'
        '<d:normvectorgroup id="8"><d:normvector x="0" y="0" z="1"/></d:normvectorgroup>'
        '<d:disp2dgroup id="7" dispid="3" height="4" nid="8">'
        + "".join(f'<d:disp2dcoord u="{k & 1}" v="{k >> 1}" n="0"/>' for k in range(4))
        + f'</d:disp2dgroup><object id="4" type="model"><d:displacementmesh><d:vertices>{vertices}</d:vertices>'
        f"<d:triangles>{triangles}</d:triangles></d:displacementmesh></object>",
        '<item objectid="4" transform="1 0 0 0 1 0 0 0 1 5 5 0"/>',
        "d",
        {"3D/t.png": grey},
    )
    made = imported(file)
    assert volume(made) == pytest.approx(20 * 20 * (20 + 4 * 128 / 255), rel=0.01)


def lattice_file(file: Path, nodes: Sequence[tuple[float, float, float]], struts: Sequence[tuple[int, int, float, float]]) -> Path:
    """Writes struts (two nodes, two radii) with balls at their ends, using lib3mf."""
    wrapper = lib3mf.get_wrapper()
    model = wrapper.CreateModel()
    mesh = model.AddMeshObject()
    mesh.SetName("truss")
    number = lib3mf.Lib3MF.ctypes.c_float
    for place in nodes:
        mesh.AddVertex(lib3mf.Position((number * 3)(*place)))
    lattice = mesh.BeamLattice()
    lattice.SetMinLength(0.001)
    for a, b, first, second in struts:
        beam = lib3mf.Beam()
        beam.Indices[0], beam.Indices[1] = a, b
        beam.Radii[0], beam.Radii[1] = first, second
        beam.CapModes[0] = beam.CapModes[1] = int(lib3mf.BeamLatticeCapMode.Sphere)
        lattice.AddBeam(beam)
    model.AddBuildItem(mesh, wrapper.GetIdentityTransform())
    model.QueryWriter("3mf").WriteToFile(str(file))
    return file


def test_lattices_of_beams(tmp_path: Path, imported: Callable[..., Print]) -> None:
    """Two beams apart from each other."""
    nodes = [(0, 0, 0), (20, 0, 0), (0, 30, 0), (20, 30, 0)]
    made = imported(lattice_file(tmp_path / "truss.3mf", nodes, [(0, 1, 3.0, 3.0), (2, 3, 2.0, 2.0)]))
    exact = sum(np.pi * r * r * 20 + 4 / 3 * np.pi * r**3 for r in (3.0, 2.0))
    assert volume(made) == pytest.approx(exact, rel=0.01)


class Written:
    """A level set whose function lib3mf writes, node by node."""

    def __init__(self) -> None:
        self.wrapper = lib3mf.get_wrapper()
        self.model = self.wrapper.CreateModel()
        self.shape = self.function()

    def function(self) -> Any:
        made = self.model.AddImplicitFunction()
        made.AddInput("pos", "pos", lib3mf.ImplicitPortType.Vector)
        made.AddOutput("shape", "shape", lib3mf.ImplicitPortType.Scalar)
        return made

    def link(self, function: Any, *links: tuple[str, str]) -> None:
        for source, target in links:
            function.AddLinkByNames(source, target)

    def resource(self, name: str, what: Any) -> None:
        self.shape.AddResourceIdNode(name, "", "").SetResource(what)

    def less(self, value: str, constant: float) -> None:
        """Makes the shape a value minus a constant."""
        self.shape.AddConstantNode("less", "", "").SetConstant(constant)
        self.shape.AddSubtractionNode("out", lib3mf.ImplicitNodeConfiguration.ScalarToScalar, "", "")
        self.link(self.shape, (value, "out.A"), ("less.value", "out.B"), ("out.result", "outputs.shape"))

    def squares(self) -> Any:
        """Adds the function x² + y² + z² - 36."""
        f = self.function()
        f.AddDotNode("dot", "", "")
        f.AddConstantNode("c", "", "").SetConstant(36.0)
        f.AddSubtractionNode("out", lib3mf.ImplicitNodeConfiguration.ScalarToScalar, "", "")
        self.link(f, ("inputs.pos", "dot.A"), ("inputs.pos", "dot.B"), ("dot.result", "out.A"))
        self.link(f, ("c.value", "out.B"), ("out.result", "outputs.shape"))
        return f

    def cube(self, low: float, high: float) -> Any:
        mesh = self.model.AddMeshObject()
        corners, faces = box(high - low, (low, low, low))
        for corner in corners:
            mesh.AddVertex(lib3mf.Position((lib3mf.Lib3MF.ctypes.c_float * 3)(*corner)))
        for face in faces:
            mesh.AddTriangle(lib3mf.Triangle((lib3mf.Lib3MF.ctypes.c_uint32 * 3)(*map(int, face))))
        return mesh

    def save(self, file: Path, half: float) -> Path:
        level_set = self.model.AddLevelSet()
        level_set.SetFunction(self.shape)
        level_set.SetChannelName("shape")
        level_set.SetMesh(self.cube(-half, half))
        level_set.SetMeshBBoxOnly(True)
        self.model.AddBuildItem(level_set, self.wrapper.GetIdentityTransform())
        self.model.QueryWriter("3mf").WriteToFile(str(file))
        return file


def offset_cube(side: float, by: float) -> float:
    """Steiner's formula."""
    return side**3 + 6 * side**2 * by + 3 * np.pi * side * by**2 + 4 / 3 * np.pi * by**3


@pytest.mark.parametrize("signed", [True, False])
def test_a_level_set_of_a_mesh(tmp_path: Path, imported: Callable[..., Print], signed: bool) -> None:
    """The points within 3.5 mm of a cube, and of its surface alone."""
    to = Written()
    to.resource("cube", to.cube(-5, 5))
    to.shape.AddMeshNode("far", "", "")
    to.link(to.shape, ("cube.value", "far.mesh"), ("inputs.pos", "far.pos"))
    to.less("far.distance", 3.5)
    file = to.save(tmp_path / "offset.3mf", 10)
    if not signed:
        # lib3mf 2.5 writes AddUnsignedMeshNode as a signed one.
        model = zipfile.ZipFile(file).read("3D/3dmodel.model").decode()
        resources = model.split("<resources>")[1].split("</resources>")[0].replace("i:mesh", "i:unsignedmesh")
        file = package(tmp_path / "shell.3mf", resources.replace("p:UUID", "name"), '<item objectid="3"/>', "v i")
    strict(file)
    made = imported(file)
    hollow = 0 if signed else (10 - 2 * 3.5) ** 3
    assert volume(made) == pytest.approx(offset_cube(10, 3.5) - hollow, rel=6e-3)


@pytest.mark.parametrize("cap", ["Butt", "HemiSphere", "Sphere"])
def test_a_level_set_of_beams(tmp_path: Path, imported: Callable[..., Print], cap: str) -> None:
    """The points within 2 mm of a beam of 12 mm."""
    to = Written()
    mesh = to.model.AddMeshObject()
    for x in (-6, 6):
        mesh.AddVertex(lib3mf.Position((lib3mf.Lib3MF.ctypes.c_float * 3)(x, 0, 0)))
    lattice = mesh.BeamLattice()
    lattice.SetMinLength(0.001)
    beam = lib3mf.Beam()
    beam.Indices[0], beam.Indices[1] = 0, 1
    beam.Radii[0] = beam.Radii[1] = 6.0
    beam.CapModes[0] = beam.CapModes[1] = int(getattr(lib3mf.BeamLatticeCapMode, cap))
    lattice.AddBeam(beam)
    to.resource("beam", mesh)
    to.shape.AddBeamLatticeNode("far", "", "")
    to.link(to.shape, ("beam.value", "far.beamlattice"), ("inputs.pos", "far.pos"))
    to.less("far.distance", 2.0)
    made = imported(to.save(tmp_path / "beam.3mf", 15))
    if cap == "Butt":
        # Steiner's formula of a cylinder.
        r, h, by = 6, 12, 2
        area, bend = 2 * np.pi * r * (r + h), np.pi * h + np.pi**2 * r
        exact = np.pi * r * r * h + area * by + bend * by**2 + 4 / 3 * np.pi * by**3
    else:
        exact = np.pi * 64 * 12 + 4 / 3 * np.pi * 512
    assert volume(made) == pytest.approx(exact, rel=0.012)


def test_normalised_distances_and_gradients(tmp_path: Path, imported: Callable[..., Print]) -> None:
    """x² + y² + z² - 36 over its slope, 2 r, is 0.5 at r = 6.52; its slope is 12 at r = 6."""
    to = Written()
    to.resource("f", to.squares())
    node = to.shape.AddNormalizeDistanceNode("n", "", "")
    node.SetScalarOutputName("shape")
    node.SetVectorInputName("pos")
    to.shape.AddConstantNode("h", "", "").SetConstant(0.01)
    to.link(to.shape, ("f.value", "n.functionID"), ("inputs.pos", "n.pos"), ("h.value", "n.step"))
    to.less("n.result", 0.5)
    made = imported(to.save(tmp_path / "normal.3mf", 8))
    assert volume(made) == pytest.approx(4 / 3 * np.pi * ((1 + 145**0.5) / 2) ** 3, rel=0.01)

    to = Written()
    to.resource("f", to.squares())
    node = to.shape.AddFunctionGradientNode("g", "", "")
    node.SetScalarOutputName("shape")
    node.SetVectorInputName("pos")
    to.shape.AddConstantNode("h", "", "").SetConstant(0.01)
    to.link(to.shape, ("f.value", "g.functionID"), ("inputs.pos", "g.pos"), ("h.value", "g.step"))
    to.less("g.magnitude", 12.0)
    made = imported(to.save(tmp_path / "slope.3mf", 8))
    assert volume(made) == pytest.approx(4 / 3 * np.pi * 216, rel=0.01)


def covered_by_beams(file: Path, step: float) -> float:
    """Returns the volume of a lattice as read by lib3mf: cones between circles, and balls for spherical caps."""
    model = lib3mf.get_wrapper().CreateModel()
    model.QueryReader("3mf").ReadFromFile(str(file))
    items = model.GetMeshObjects()
    total = 0.0
    while items.MoveNext():
        mesh = items.GetCurrentMeshObject()
        beams = mesh.BeamLattice().GetBeams()
        if not beams:
            continue
        nodes = np.array([list(v.Coordinates) for v in mesh.GetVertices()])
        most = max(max(b.Radii) for b in beams)
        low, high = nodes.min(axis=0) - most - step, nodes.max(axis=0) + most + step
        shape = np.ceil((high - low) / step).astype(int)
        inside = np.zeros(shape, dtype=bool)
        for beam in beams:
            assert list(beam.CapModes) == [int(lib3mf.BeamLatticeCapMode.Sphere)] * 2
            a, b = nodes[beam.Indices[0]], nodes[beam.Indices[1]]
            r = np.array(list(beam.Radii))
            near = np.maximum(((np.minimum(a, b) - r.max() - low) / step).astype(int) - 1, 0)
            far = np.minimum(((np.maximum(a, b) + r.max() - low) / step).astype(int) + 2, shape)
            grid = np.stack(np.meshgrid(*(np.arange(n, f) for n, f in zip(near, far)), indexing="ij"), axis=-1)
            p = low + (grid + 0.5) * step
            along = np.clip((p - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
            off = np.linalg.norm(p - a - along[..., None] * (b - a), axis=-1)
            cone = (along > 0) & (along < 1) & (off < r[0] + along * (r[1] - r[0]))
            balls = (np.linalg.norm(p - a, axis=-1) < r[0]) | (np.linalg.norm(p - b, axis=-1) < r[1])
            inside[tuple(slice(n, f) for n, f in zip(near, far))] |= cone | balls
        total += float(inside.sum()) * step**3
    return total


def test_a_lattice_of_tapered_struts(tmp_path: Path, imported: Callable[..., Print]) -> None:
    """Forty crossing struts with random ends and radii, against the beams that lib3mf reads back."""
    rng = random.Random(3)
    nodes = [tuple(rng.uniform(-12, 12) for _ in range(3)) for _ in range(20)]
    struts = [(a, b, rng.uniform(0.8, 2.0), rng.uniform(0.8, 2.0)) for a, b in (rng.sample(range(20), 2) for _ in range(40))]
    file = lattice_file(tmp_path / "struts.3mf", nodes, struts)
    assert volume(imported(file)) == pytest.approx(covered_by_beams(file, VOXEL / 2), rel=0.01)


def told(file: Path, *options: Any) -> str:
    with pytest.raises(AssertionError) as error:
        run("import", file, *options)
    return str(error.value)


def test_cycles_have_their_place(tmp_path: Path) -> None:
    file = package(
        tmp_path / "ring.3mf",
        '<i:implicitfunction id="1" displayname="ring"><i:in><i:vector identifier="pos"/></i:in>'
        '<i:abs identifier="a"><i:in><i:scalarref identifier="A" ref="b.result"/></i:in><i:out><i:scalar identifier="result"/></i:out></i:abs>'
        '<i:sin identifier="b"><i:in><i:scalarref identifier="A" ref="a.result"/></i:in><i:out><i:scalar identifier="result"/></i:out></i:sin>'
        '<i:out><i:scalarref identifier="shape" ref="b.result"/></i:out></i:implicitfunction>'
        f'<object id="2" type="model">{cube(-10, 10)}</object><object id="3" type="model">'
        '<v:levelset functionid="1" channel="shape" meshid="2"/></object>',
        '<item objectid="3"/>',
        "v i",
    )
    assert "function 1 `ring`, node `b`: it depends on itself: b <- a <- b" in told(file, "-o", tmp_path / "w")
