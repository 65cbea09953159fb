# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Looks of MaterialX' own suites (a folder with its repository's `resources`), against the GLSL that MaterialX writes, run by OpenGL.

Each material of each document is imported, and compiled code prints what its functions (colour, weight, opacity, displacement) and
each output of the document's graphs give at 64 points. The expected values at these points come from MaterialX' shader generator
for the same input or output, with its colour management and its units.
"""

from __future__ import annotations

import functools
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any, Callable, NamedTuple

import moderngl
import MaterialX as mx
import numpy as np
from MaterialX import PyMaterialXGenGlsl as gen_glsl
from MaterialX import PyMaterialXGenShader as gen
from outcome import Refused, Unread, Wrong
from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "python" / "openfab"))
import materialx as looks  # noqa: E402
from materialx_document import Prepared, flatten  # noqa: E402
from materialx_nodes import FORMULAS, TYPES, LooksError, Writer  # noqa: E402

MOST = 2e-5  # of the value, where it is above 1: sines and powers of a library differ in the last bits
GROUP = 16  # functions that are compiled at once
UNIT_MM = 10
ARGUMENTS = {"p": "p", "uv": "uv", "n": "n"}


class Case(NamedTuple):
    """A function of ours, and the element of its document whose shader has its value."""

    name: str
    kind: str
    text: str  # of the function `the_value`
    textures: list[dict[str, Any]]
    element: Callable[[Any], Any]  # in the document


def is_known(category: str) -> bool:
    return category in FORMULAS or hasattr(Writer, "of_" + category)


@functools.lru_cache(2)
def prepared(file: Path) -> tuple[looks.Looks, Any]:
    document = looks.read(file)
    made = looks.Looks(file)
    Prepared(document, looks.library(), UNIT_MM, made.note)
    flatten(document, looks.library(), is_known, looks.MODELS)
    return made, document


def outputs_of(document: Any) -> list[Any]:
    """Returns the outputs of values that stand in the document and in graphs that define no nodes."""
    graphs = [g for g in document.getNodeGraphs() if not g.hasSourceUri() or g.getSourceUri() == document.getSourceUri()]
    found = [o for parent in [document, *graphs] if parent is document or parent.getNodeDef() is None for o in parent.getOutputs()]
    return [o for o in found if not o.hasSourceUri() or o.getSourceUri() == document.getSourceUri()]


def function(name: str, kind: str, written: Any) -> str:
    parameters = {"p": "float3 p", "uv": "float2 uv", "n": "float3 n"}
    lines = "".join(f"        {line}\n" for line in written.lines)
    return f"    {kind} {name}({', '.join(parameters[one] for one in ('p', 'uv', 'n') if one in written.reads)})\n    {{\n{lines}        return {written.result};\n    }}\n"


@functools.lru_cache(2)
def original(file: Path) -> Any:
    document = mx.createDocument()
    mx.readFromXmlFile(document, str(file))
    document.importLibrary(looks.library())
    return document


class Reference:
    """MaterialX' shaders, on the OpenGL of this machine."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.gl = moderngl.create_standalone_context(backend="egl")
        self.library = looks.library()

    def shader(self, element: Any) -> Any:
        generator = gen_glsl.GlslShaderGenerator.create()
        colors = gen.DefaultColorManagementSystem.create(generator.getTarget())
        colors.loadLibrary(self.library)
        generator.setColorManagementSystem(colors)
        units = gen.UnitSystem.create(generator.getTarget())
        units.loadLibrary(self.library)
        registry = mx.UnitConverterRegistry.create()
        for kind in ("distance", "angle"):
            definition = self.library.getUnitTypeDef(kind)
            registry.addUnitConverter(definition, mx.LinearUnitConverter.create(definition))
        units.setUnitConverterRegistry(registry)
        generator.setUnitSystem(units)
        context = gen.GenContext(generator)
        context.getOptions().targetColorSpaceOverride = "lin_rec709"
        context.getOptions().targetDistanceUnit = "centimeter"
        context.registerSourceCodeSearchPath(mx.getDefaultDataSearchPath())
        return generator.generate("look", element, context)

    def output(self, document: Any, element: Any) -> Any:
        """Returns an output of numbers with the value of an output, or of an input of a shader."""
        if element.getCategory() == "output" and element.getType() not in ("integer", "boolean"):
            return element
        kind = element.getType()
        outer = element
        while outer.getParent() is not None and outer.getParent().getCategory() not in ("nodegraph", "materialx"):
            outer = outer.getParent()
        home = outer.getParent()
        node = home.addNode("convert" if kind in ("integer", "boolean") else "dot", home.createValidChildName("asked"), "float" if kind in ("integer", "boolean") else kind)
        port = node.addInput("in", kind)
        if element.hasValueString():
            port.setValueString(element.getValueString())
        for name in ("nodename", "nodegraph", "output", "interfacename", "colorspace", "unit", "unittype"):
            if element.hasAttribute(name):
                port.setAttribute(name, element.getAttribute(name))
        made = home.addOutput(home.createValidChildName("asked_out"), node.getType())
        made.setNodeName(node.getName())
        return made

    def texture(self, file: str, folder: Path, wrap: tuple[str, str], default: list[float], nearest: bool) -> Any:
        path = next((base / file for base in (folder, self.root) if (base / file).is_file()), None)
        if path is None:
            raise Unread(f"there is no picture {file}")
        with Image.open(path) as picture:
            if picture.mode.startswith("I"):
                raise Unread("Pillow reads 8 bits of 16")
            pixels = np.asarray(picture.convert("RGBA"), np.float32)[::-1] / np.float32(255)
        texture = self.gl.texture(pixels.shape[1::-1], 4, pixels.tobytes(), dtype="f4")
        sampler = self.gl.sampler(texture=texture, repeat_x=wrap[0] == "periodic", repeat_y=wrap[1] == "periodic",
                                  filter=(moderngl.NEAREST,) * 2 if nearest else (moderngl.LINEAR,) * 2)
        if "constant" in wrap:
            sampler.border_color = tuple((default + [1.0] * 4)[:4])
        return sampler

    def values(self, case: Case, file: Path, points: np.ndarray) -> tuple[np.ndarray, float]:
        """Returns four numbers at each point, of p, uv and n, and how far others may be from them: Mesa has arcs to three digits."""
        document = original(file)
        made = self.shader(self.output(document, case.element(document)))
        code = made.getSourceCode("pixel")
        block = re.search(r"in VertexData\s*\{(.*?)\} vd;", code, re.S)
        names = re.findall(r"(\w+) (\w+);", block[1]) if block else []
        values = {"position": "p", "normal": "n", "texcoord": "uv", "color": "vec4(1.0)"}
        sets = []
        for kind, name in names:
            which = next((v for k, v in values.items() if name.startswith(k)), None)
            if which is None:
                raise Unread(f"it reads {name}")
            sets.append(f"vd.{name} = {which}{'.xy' if kind == 'vec2' else ''};")
        out = f"out VertexData {{ {block[1]} }} vd;" if block else ""
        vertex = ("#version 400\nin vec3 p; in vec3 uv; in vec3 n; uniform float count;\n" + out + "\nvoid main() { " + " ".join(sets) + " gl_PointSize = 1.0; gl_Position = vec4((2.0 * float(gl_VertexID) + 1.0) / count - 1.0, 0.0, 0.0, 1.0); }")
        program = self.gl.program(vertex_shader=vertex, fragment_shader=code)
        program["count"] = float(len(points))
        uniforms = {u.getVariable(): u for b in made.getStage("pixel").getUniformBlocks().values() for u in b}
        held: list[Any] = []
        for name, one in uniforms.items():
            if name not in program or one.getType().getName() != "filename":
                continue  # the shader's text has its value
            if one.getValue() is None:
                raise Unread("a file without a name")
            stem = name.removesuffix("_file")
            number = lambda key, usual: uniforms[key].getValue().getData() if key in uniforms and uniforms[key].getValue() is not None else usual  # noqa: E731
            modes = ("constant", "clamp", "periodic", "mirror")
            wrap = (modes[number(stem + "_uaddressmode", 2)], modes[number(stem + "_vaddressmode", 2)])
            if "mirror" in wrap or wrap.count("constant") == 1:
                raise Unread("samplers here do not mirror, and have a border along both axes or none")
            written = uniforms[stem + "_default"].getValue() if stem + "_default" in uniforms else None
            default = [float(v) for v in written.getValueString().split(",")] if written is not None else []
            sampler = self.texture(one.getValue().getValueString(), file.parent, wrap, default, number(stem + "_filtertype", 1) == 0)
            sampler.use(len(held))
            program[name].value = len(held)
            held.append(sampler)
        target = self.gl.framebuffer([self.gl.texture((len(points), 1), 4, dtype="f4")])
        target.use()
        self.gl.enable(moderngl.PROGRAM_POINT_SIZE)
        read = [(self.gl.buffer(np.ascontiguousarray(points[:, 3 * i : 3 * i + 3], np.float32).tobytes()), "3f", name) for i, name in enumerate(("p", "uv", "n")) if name in program]
        array = self.gl.vertex_array(program, read)
        array.render(moderngl.POINTS, len(points))
        return np.frombuffer(target.read(components=4, dtype="f4"), np.float32).reshape(-1, 4), 5e-4 if re.search(r"= mx_(asin|acos)\(", code) else MOST


class Ours:
    """Compiled code of functions, at points."""

    def __init__(self, bin_folder: Path) -> None:
        self.openflc = bin_folder / "openflc"

    def run(self, folder: Path, cases: list[Case]) -> tuple[np.ndarray, list[np.ndarray]]:
        functions, calls, textures, copies = "", "", {}, {}
        for i, case in enumerate(cases):
            text = case.text.replace(" the_value(", f" value_{i}(")
            reads = [one for one, what in (("p", "float3 p"), ("uv", "float2 uv"), ("n", "float3 n")) if re.search(rf"the_value\([^)]*{what}", case.text)]
            for one in case.textures:
                if not re.search(rf"\b{one['uniform']}\.Sample", text):
                    continue
                name = f"t{i}_{one['uniform']}"
                text = re.sub(rf"\b{one['uniform']}\.Sample", f"{name}.Sample", text)
                copy = folder / f"{len(copies)}{one['path'].suffix}"
                if one["path"] not in copies:
                    copies[one["path"]] = copy.name
                    shutil.copy(one["path"], copy)
                textures[name] = {"file": copies[one["path"]], "wrap": one["wrap"], "space": "data", **({"filter": "nearest"} if one["nearest"] else {})}
            functions += re.sub(r"(\.Sample\d\((?:[^()]|\([^()]*\))*, 0)\)", r"\1, 0)", text)  # no footprint
            call = f"value_{i}({', '.join(reads)})"
            calls += f'        printf("{i + 1} %.9g\\n", {call if case.kind.startswith("float") else "float(" + call + ")" if case.kind == "int" else "(" + call + " ? 1.0 : 0.0)"});\n'
        shutil.copy(Path(looks.__file__).with_name("materialx.fl"), folder)
        uniforms = "".join(f" ImageTexture2D {name};" for name in textures)
        (folder / "v.fl").write_text(
            "import color;\nimport materialx;\nfablet V {\n    @uniform { Material a;" + uniforms + " }\n" + functions +
            "    @Volume(@varying { VolumeAttributes attr })\n    {\n        float3 p = attr.voxelCenter * 0.37 - float3(0.71, 0.4, 0.83);\n"
            "        float2 uv = p.yz * 0.31 + float2(p.x * 0.117 + 0.53, 0.47);\n        float3 n = normalize(p + float3(0.013, -0.21, 0.31));\n"
            '        printf("0 %.9g %.9g %.9g\\n", p, uv, n);\n' + calls + "        MaterialComposition mc;\n        mc.Set(a, 1);\n        return mc;\n    }\n}\n")
        world = {"openfab": 1, "printer": "generic", "fablets": {"f": {"source": "v.fl", "fablet": "V"}}, "materials": {"a": {"key": "#ffffff"}}, "textures": textures,
                 "meshes": {"m": {"box": [4, 4, 4]}}, "objects": {"o": {"mesh": "m", "fablet": "f", "uniforms": {"a": "a", **{name: name for name in textures}}}}, "build": [{"object": "o"}]}
        (folder / "v.fab.json").write_text(looks.json.dumps(world))
        words = [self.openflc, "run", "--prints", "--print-lines", "1000000", folder / "v.fl", folder / "v.fab.json", "--voxel", "1mm", "--progress", "none", "-o", folder / "v.npy"]
        done = subprocess.run(words, capture_output=True, text=True, check=False, timeout=600)
        if done.returncode != 0:
            raise Wrong(f"it does not compile: {' '.join(done.stderr.split())[:300]}")
        lines: list[list[list[float]]] = [[] for _ in range(len(cases) + 1)]
        for line in done.stderr.splitlines():
            if "mm: " in line:
                which, *numbers = line.split("mm: ")[1].split()
                lines[int(which)].append([float(one) for one in numbers])
        arrays = [np.array(one) for one in lines]
        points = arrays[0]
        return np.concatenate([points[:, :5], np.zeros((len(points), 1)), points[:, 5:]], axis=1), arrays[1:]


def compared(ours: np.ndarray, theirs: np.ndarray, most: float) -> str:
    """Returns what differs."""
    size = ours.shape[1]
    theirs = theirs[:, :size].astype(float)
    held = np.isfinite(theirs)
    if not held.any():
        raise Unread("its values are not finite")
    far = np.where(held, np.abs(ours - theirs) / np.maximum(1, np.abs(theirs)), 0)
    far = np.where(np.isnan(far), np.inf, far)
    worst = np.unravel_index(np.argmax(far), far.shape)
    if far[worst] <= most:
        return ""
    return f"{ours[worst[0]]}, not {theirs[worst[0]]}, and {np.count_nonzero(np.max(far, axis=1) > most)} of {len(ours)} points differ"


class Suite:
    def __init__(self, root: Path, bin_folder: Path) -> None:
        self.root, self.ours, self.reference = root, Ours(bin_folder), Reference(root)
        self.shadow = tempfile.TemporaryDirectory()
        self.files = sorted(f for f in (root / "resources" / "Materials").rglob("*.mtlx") if f.is_file())
        self.found: list[tuple[str, str, Exception | None]] = []  # kind, name, outcome
        self.cases: list[tuple[str, Path, Case]] = []

    def tried(self, kind: str, name: str, work: Any) -> Any:
        """Returns what the work gives; notes a refusal, and as wrong whatever else it raises."""
        try:
            return work()
        except LooksError as refused:
            self.found.append((kind, name, Refused(str(refused))))
        except Exception as problem:
            self.found.append((kind, name, Wrong(f"{type(problem).__name__} {problem}")))
        return None

    def placed(self, file: Path) -> Path:
        """Returns the document in a folder with `resources`, which some name pictures from."""
        if "resources/" not in file.read_text(errors="replace"):
            return file
        folder = Path(self.shadow.name) / str(len(list(Path(self.shadow.name).iterdir())))
        folder.mkdir()
        for beside in [*file.parent.iterdir(), self.root / "resources"]:
            if not (folder / beside.name).exists():
                (folder / beside.name).symlink_to(beside.resolve())
        return folder / file.name

    def gather(self, file: Path) -> None:
        """Writes the functions of a document's materials and outputs."""
        name = str(file.relative_to(self.root / "resources" / "Materials"))
        file = self.placed(file)
        try:
            document = original(file)
        except Exception as problem:
            self.found.append(("document", name, Unread(f"MaterialX: {problem}"[:200])))
            return
        shaders = looks.shaders_of(document)
        before = len(self.found)
        if shaders:
            self.tried("document", name, lambda: self.whole(file))
            if len(self.found) == before:
                self.found.append(("document", name, None))
        else:
            self.found.append(("document", name, Refused("it has no material with a surface")))
        for material, shader, displacement in shaders:
            self.tried("material", f"{name} {material}", lambda m=material, s=shader, d=displacement: self.material(file, f"{name} {m}", m))
        for element in outputs_of(document):
            path = element.getNamePath()
            if element.getType() in TYPES:
                self.tried("output", f"{name} {path}", lambda at=path: self.output(file, f"{name} {at}", at))

    def whole(self, file: Path) -> None:
        with tempfile.TemporaryDirectory() as folder:
            looks.import_looks(file, Path(folder) / "made")

    def material(self, file: Path, name: str, material: str) -> None:
        made, document = prepared(file)
        _, shader, displacement = next(one for one in looks.shaders_of(document) if one[0] == material)
        fablet = looks.Fablet(made, document, material, shader, displacement)
        roles = looks.MODELS[shader.getCategory()]
        ports = dict(zip(("base_color", "base_weight", "opacity", "transmission"), roles))
        for kind, which, written in fablet.functions:
            node = self.shader_of(original(file), material)[1 if which == "displacement" else 0]
            port = "displacement" if which == "displacement" else ports[which]
            if node.getInput(port) is None or node.getCategory() != shader.getCategory() and which != "displacement":
                continue  # a default of the model, or a model in a graph
            self.cases.append((f"{name} {which}", file, Case(name, kind, function("the_value", kind, written), made.textures, functools.partial(self.input_of, material, which == "displacement", port))))
        self.found.append(("material", name, None))

    @staticmethod
    def shader_of(document: Any, material: str) -> tuple[Any, Any]:
        return next(one[1:] for one in looks.shaders_of(document) if one[0] == material)

    def input_of(self, material: str, displaced: bool, port: str, document: Any) -> Any:
        return self.shader_of(document, material)[displaced].getInput(port)

    def output(self, file: Path, name: str, path: str) -> None:
        made, document = prepared(file)
        output = document.getDescendant(path)
        kind = TYPES[output.getType()]
        writer = Writer(made, document, "Look")
        writer.out.result = writer.value(output, kind)
        self.cases.append((name, file, Case(name, kind, function("the_value", kind, writer.out), made.textures, lambda document: document.getDescendant(path))))

    def compare(self) -> None:
        for begin in range(0, len(self.cases), GROUP):
            group = self.cases[begin : begin + GROUP]
            try:
                with tempfile.TemporaryDirectory() as folder:
                    points, ours = self.ours.run(Path(folder), [case for _, _, case in group])
                results: list[Any] = [(points, one) for one in ours]
            except Wrong:  # one of them does not compile
                results = []
                for _, _, case in group:
                    try:
                        with tempfile.TemporaryDirectory() as folder:
                            points, ours = self.ours.run(Path(folder), [case])
                        results.append((points, ours[0]))
                    except Wrong as wrong:
                        results.append(wrong)
            for (name, file, case), result in zip(group, results):
                self.found.append(("value", name, result if isinstance(result, Exception) else self.judged(file, case, *result)))

    def judged(self, file: Path, case: Case, points: np.ndarray, ours: np.ndarray) -> Exception | None:
        try:
            said = compared(ours, *self.reference.values(case, file, points))
        except Unread as unread:
            return unread
        except Exception as problem:
            return Unread(f"MaterialX: {type(problem).__name__} {problem}"[:300])
        return Wrong(said) if said else None

    def run(self) -> list[tuple[str, str, Exception | None]]:
        for file in self.files:
            self.gather(file)
        self.compare()
        return self.found

