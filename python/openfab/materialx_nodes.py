# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Converts MaterialX nodes to OpenFL: a function for each shader input, a statement for each node that it reads."""

from __future__ import annotations

import re
import struct
from dataclasses import dataclass, field
from typing import Any, Protocol

TYPES = {
    "float": "float", "integer": "int", "boolean": "bool", "color3": "float3", "vector3": "float3", "vector2": "float2",
    "color4": "float4", "vector4": "float4",
}
SIZES = {"float": 1, "int": 1, "bool": 1, "float2": 2, "float3": 3, "float4": 4}

# Nodes and their formulas; {} are inputs. Nodes that MaterialX defines as graphs of these are flattened first.
FORMULAS = {
    "add": "{in1} + {in2}", "subtract": "{in1} - {in2}", "multiply": "{in1} * {in2}", "divide": "{in1} / {in2}",
    "modulo": "mx_modulo({in1}, {in2})", "absval": "abs({in})", "floor": "floor({in})", "ceil": "ceil({in})",
    "round": "round({in})", "power": "pow({in1}, {in2})", "sin": "sin({in})", "cos": "cos({in})", "tan": "tan({in})",
    "asin": "asin({in})", "acos": "acos({in})", "sqrt": "sqrt({in})", "ln": "log({in})", "exp": "exp({in})",
    "fract": "frac({in})", "sign": "mx_sign({in})", "clamp": "clamp({in}, {low}, {high})", "min": "min({in1}, {in2})",
    "max": "max({in1}, {in2})", "normalize": "normalize({in})", "magnitude": "length({in})",
    "dotproduct": "dot({in1}, {in2})", "crossproduct": "cross({in1}, {in2})", "distance": "distance({in1}, {in2})",
    "invert": "{amount} - {in}", "mix": "lerp({bg}, {fg}, {mix})", "smoothstep": "mx_smoothstep({in}, {type}({low}), {type}({high}))",
    "remap": "{outlow} + ({in} - {inlow}) * ({outhigh} - {outlow}) / ({inhigh} - {inlow})",
    "ifgreater": "{value1} > {value2} ? {in1} : {in2}", "ifgreatereq": "{value1} >= {value2} ? {in1} : {in2}",
    "ifequal": "{value1} == {value2} ? {in1} : {in2}", "and": "{in1} && {in2}", "or": "{in1} || {in2}", "not": "!{in}",
    "plus": "{mix} * ({bg} + {fg}) + (1 - {mix}) * {bg}", "minus": "{mix} * ({bg} - {fg}) + (1 - {mix}) * {bg}",
    "difference": "{mix} * abs({bg} - {fg}) + (1 - {mix}) * {bg}",
    "screen": "{mix} * (1 - (1 - {fg}) * (1 - {bg})) + (1 - {mix}) * {bg}",
    "burn": "mx_burn({fg}, {bg}, {mix})", "dodge": "mx_dodge({fg}, {bg}, {mix})",
    "inside": "{in} * {mask}", "outside": "{in} * (1 - {mask})", "dot": "{in}", "constant": "{value}",
    "rotate2d": "mx_rotate({in}, {amount})", "rotate3d": "mx_rotate({in}, {amount}, {axis})",
    "ramplr": "lerp({valuel}, {valuer}, saturate({texcoord}.x))", "ramptb": "lerp({valuet}, {valueb}, saturate(1 - {texcoord}.y))",
    "splitlr": "{texcoord}.x < {center} ? {valuel} : {valuer}", "splittb": "{texcoord}.y < {center} ? {valueb} : {valuet}",
    "luminance": "mx_luminance({in}, {lumacoeffs})", "rgbtohsv": "mx_rgb_to_hsv({in})", "hsvtorgb": "mx_hsv_to_rgb({in})",
    "srgb_texture_to_lin_rec709": "mx_from_srgb({in})",
    "cellnoise2d": "mx_cell({texcoord})", "cellnoise3d": "mx_cell({position})",
}


class LooksError(Exception):
    """An error in a file, as a message for users."""


class Pictures(Protocol):
    """Collects the pictures of nodes, and notes on what was left out."""

    textures: list[dict[str, Any]]

    def note(self, node: Any, text: str) -> None: ...

    def texture(self, name: str, node: Any) -> str: ...


@dataclass
class Written:
    """A function of a look: its statements, and the inputs that they read."""

    result: str = ""
    lines: list[str] = field(default_factory=list)
    reads: set[str] = field(default_factory=set)  # p, uv, n


def name_of(text: str, taken: set[str]) -> str:
    """Returns a valid and unused OpenFL name for a node's variable."""
    base = re.sub(r"\W+", "_", text).strip("_").lower() or "value"
    if base[0].isdigit() or base.startswith("mx_"):
        base = "v" + base
    name, i = base, 2
    while name in taken:
        name, i = f"{base}_{i}", i + 1
    taken.add(name)
    return name


# Names that OpenFL or the functions here use; those that begin as the module's functions do are reserved, too.
RESERVED = set(
    """p uv n attr float float2 float3 float4 int int2 int3 int4 bool bool2 bool3 bool4 uint uint2 uint3 uint4 void
    if else for while return true false fablet import const struct switch case default break continue do in out inout
    lerp clamp saturate noise mix min max abs floor ceil round trunc frac fmod sqrt rsqrt sin cos tan asin acos atan atan2 exp exp2
    log log2 pow step smoothstep dot cross length distance normalize reflect select and or any all hash fbm cellular nearest radians
    degrees mul sign transpose determinant printf assert color depth density opacity displacement base_color base_weight
    transmission unit ink rgb cover mc material materialcomposition inks ink_amounts ink_limit rgb_to_cmyk rgb_to_hsv hsv_to_rgb
    srgb_to_linear linear_to_srgb luminance white black cyan magenta yellow clear profile uvout""".split()
)


def number(value: float) -> str:
    """Returns the shortest text of the same float."""
    single = struct.pack("f", value)
    return next((text for digits in range(1, 10) if struct.pack("f", float(text := f"{value:.{digits}g}")) == single), repr(value))


def literal(value: Any, kind: str) -> str:
    """Returns a MaterialX value as an OpenFL literal."""
    if kind == "bool":
        return "true" if value else "false"
    if kind == "int":
        return str(int(value))
    if kind == "float":
        text = number(value)
        return text if re.search(r"[.en]", text) else text + ".0"  # `1 / 4` of whole numbers would be 0
    parts = [number(one) for one in value]
    return f"{kind}({parts[0]})" if len(set(parts)) == 1 else f"{kind}({', '.join(parts)})"


def address_mode(node: Any, name: str) -> str:
    """Returns what is beyond a picture: periodic, clamp, mirror or constant."""
    port = node.getInput(name)
    return (port.getValueString() if port is not None else "") or "periodic"


class Writer:
    """Writes the function of one input of a shader."""

    def __init__(self, look: Pictures, document: Any, material: str) -> None:
        self.look, self.document, self.material = look, document, material
        self.out = Written()
        self.taken = set(RESERVED) | {texture["uniform"] for texture in look.textures}
        self.known: dict[tuple[str, str], str] = {}
        self.kinds: dict[str, str] = {}

    def fail(self, node: Any, what: str) -> LooksError:
        return LooksError(f"{node.getNamePath()}: {what}")

    def value(self, port: Any, kind: str) -> str:
        """Returns the value of an input, from a connection or its own."""
        node = self.connected(port)
        if node is not None:
            source, output = node
            text, has = self.node(source, output)
            channels = port.getAttribute("channels")
            if channels:
                text = f"{bracket(text)}.{channels.translate(str.maketrans('rgba', 'xyzw'))}"
                has = f"float{len(channels)}" if len(channels) > 1 else "float"
            return self.convert(text, has, kind)
        if port.hasInterfaceName():
            outer = port.getInterfaceInput()
            if outer is not None and outer is not port:
                return self.value(outer, kind)
        value = port.getValue()
        if value is None:
            geometry = port.getAttribute("defaultgeomprop")
            if geometry:
                return self.geometry(geometry, port)
            return literal([0] * SIZES[kind] if SIZES[kind] > 1 else 0, kind)
        if kind in ("float", "int", "bool"):
            return literal(value, kind)
        return literal(list(value) if not isinstance(value, (int, float)) else [value] * SIZES[kind], kind)

    def connected(self, port: Any) -> tuple[Any, str] | None:
        """Returns the node that an input reads, and which of its outputs: an output of a graph has names of its own."""
        graph_output = port.getConnectedOutput()
        if graph_output is not None and port.getNodeGraphString():
            port = graph_output
        node = port.getConnectedNode()
        if node is None and port.getNodeName():
            raise self.fail(port, f"reads `{port.getNodeName()}`, which is no node beside it")
        return None if node is None else (node, port.getOutputString())

    def geometry(self, name: str, port: Any) -> str:
        which = {"uv": "uv", "n": "n", "p": "p"}.get(re.sub(r"(object|world|\d+)$", "", name.lower()))
        if which is None:
            raise self.fail(port, f"reads `{name}`, which a print does not have; positions, normals and texture coordinates are there")
        self.out.reads.add(which)
        return which

    def convert(self, text: str, has: str, kind: str) -> str:
        if has == kind:
            return text
        if SIZES[has] == 1 and kind not in ("bool", "int"):
            return f"{kind}({text})"
        if SIZES[kind] == 1:
            return f"{bracket(text)}.x" if SIZES[has] > 1 else f"{kind}({text})"
        if SIZES[has] < SIZES[kind]:
            rest = ["0"] * (SIZES[kind] - SIZES[has])
            if kind == "float4":
                rest[-1] = "1"
            return f"{kind}({', '.join([text] + rest)})"
        return f"{bracket(text)}.{'xyzw'[:SIZES[kind]]}"

    def node(self, node: Any, output: str = "") -> tuple[str, str]:
        """Returns a node's value and its type; the value is a variable's name, or an expression short enough to be inlined."""
        key = (node.getNamePath(), output)
        if key in self.known:
            return self.known[key], self.kinds[self.known[key]]
        text, kind = self.expression(node, output)
        category = node.getCategory()
        if category in ("constant", "dot", "position", "texcoord", "normal") and re.fullmatch(r"[\w.\-]+|float\d\([^()]*\)", text):
            return text, kind
        name = name_of(node.getName(), self.taken)
        self.known[key], self.kinds[name] = name, kind
        self.out.lines.append(f"{kind} {name} = {text};")
        return name, kind

    def port(self, node: Any, name: str) -> Any:
        """Returns an input of the node, or else that of the node's definition."""
        found = node.getInput(name)
        if found is None:
            definition = node.getNodeDef()
            found = definition.getActiveInput(name) if definition is not None else None
        if found is None:
            raise self.fail(node, f"has no input `{name}`")
        return found

    def input(self, node: Any, name: str, kind: str | None = None) -> str:
        port = self.port(node, name)
        has = TYPES.get(port.getType())
        if has is None:
            raise self.fail(node, f"`{name}` is a {port.getType()}, which has no place in a fablet")
        text = self.value(port, has)
        return self.convert(text, has, kind) if kind else text

    def has(self, node: Any, name: str) -> bool:
        definition = node.getNodeDef()
        return node.getInput(name) is not None or (definition is not None and definition.getActiveInput(name) is not None)

    def expression(self, node: Any, output: str) -> tuple[str, str]:
        category = node.getCategory()
        kind = TYPES.get(node.getType() if node.getType() != "multioutput" else "float")
        if kind is None:
            raise self.fail(node, f"gives a {node.getType()}, which has no place in a fablet")
        special = getattr(self, "of_" + category, None)
        if special is not None:
            return special(node, kind, output), kind
        if category in ("position", "texcoord", "normal"):
            if category == "texcoord" and self.port(node, "index").getValue():
                self.look.note(node, "texture coordinates are the first set here")
            return self.convert(self.geometry({"position": "p", "texcoord": "uv", "normal": "n"}[category], node), {"texcoord": "float2"}.get(category, "float3"), kind), kind
        formula = FORMULAS.get(category)
        if formula is None:
            raise self.fail(node, f"nodes of the kind `{category}` are not known here; bake it to a picture in the program that made it")
        if category in ("ifequal", "ifgreater", "ifgreatereq") and node.getType() == "boolean" and not self.has(node, "in1"):
            formula = formula.split(" ?")[0]
        ports = {one: self.input(node, one) for one in re.findall(r"{(\w+)}", formula) if one != "type"}
        inside_call = not any(op in formula for op in "+-*/?&|!<>=.")
        shown = {one: text if inside_call else bracket(text) for one, text in ports.items()}
        text = formula.format(**shown, type=kind)
        if category in ("floor", "ceil", "round") and kind == "int":
            text = f"int({text})"
        return text, kind

    def of_noise2d(self, node: Any, kind: str, _: str) -> str:
        return self.noise(node, kind, "mx_noise", self.input(node, "texcoord"), "", self.input(node, "pivot"))

    def of_noise3d(self, node: Any, kind: str, _: str) -> str:
        return self.noise(node, kind, "mx_noise", self.input(node, "position"), "", self.input(node, "pivot"))

    def of_fractal2d(self, node: Any, kind: str, _: str) -> str:
        return self.noise(node, kind, "mx_fractal", self.input(node, "texcoord"), self.octaves(node), "0.0")

    def of_fractal3d(self, node: Any, kind: str, _: str) -> str:
        return self.noise(node, kind, "mx_fractal", self.input(node, "position"), self.octaves(node), "0.0")

    def octaves(self, node: Any) -> str:
        return "".join(f", {self.input(node, one)}" for one in ("octaves", "lacunarity", "diminish"))

    def noise(self, node: Any, kind: str, function: str, at: str, more: str, pivot: str) -> str:
        plane = node.getCategory().endswith("2d")
        far = {("mx_noise", False): "float3(19, 73, 29)", ("mx_noise", True): "float2(19, 73)", ("mx_fractal", False): "float3(19, 193, 17)", ("mx_fractal", True): "float2(19, 193)"}[function, plane]
        value = {
            "float": f"{function}({at}{more})", "float3": f"{function}3({at}{more})",
            "float2": f"{function}3({at}{more}).xy" if function == "mx_noise" else f"float2({function}({at}{more}), {function}({bracket(at)} + {far}{more}))",
            "float4": f"float4({function}3({at}{more}), {function}({bracket(at)} + {far}{more}))",
        }[kind]
        amplitude = self.input(node, "amplitude", kind if SIZES[kind] > 1 and SIZES[TYPES[self.port(node, "amplitude").getType()]] > 1 else "float")
        if amplitude not in ("1.0", f"{kind}(1)"):
            value = f"{value} * {bracket(amplitude)}"
        return value if pivot == "0.0" else f"{value} + {bracket(pivot)}"

    def of_worleynoise2d(self, node: Any, kind: str, _: str) -> str:
        return self.worley(node, kind, self.input(node, "texcoord"))

    def of_worleynoise3d(self, node: Any, kind: str, _: str) -> str:
        return self.worley(node, kind, self.input(node, "position"))

    def worley(self, node: Any, kind: str, at: str) -> str:
        style = self.input(node, "style") if self.has(node, "style") else "0"
        arguments = f"({at}, {self.input(node, 'jitter')}, {style})"
        return {"float": f"mx_worley{arguments}", "float2": f"mx_worley3{arguments}.xy", "float3": f"mx_worley3{arguments}"}[kind]

    def of_atan2(self, node: Any, _kind: str, _: str) -> str:
        names = ("iny", "inx") if self.has(node, "iny") else ("in1", "in2")
        return f"atan2({self.input(node, names[0])}, {self.input(node, names[1])})"

    def combine(self, node: Any, kind: str, _: str = "") -> str:
        parts = [self.input(node, f"in{i}") for i in range(1, 5) if self.has(node, f"in{i}")]
        return f"{kind}({', '.join(parts)})"

    of_combine2 = of_combine3 = of_combine4 = combine

    def separate(self, node: Any, _kind: str, output: str) -> str:
        letters = {"outx": "x", "outy": "y", "outz": "z", "outw": "w", "outr": "x", "outg": "y", "outb": "z", "outa": "w"}
        return f"{bracket(self.input(node, 'in'))}.{letters[output or 'outx']}"

    of_separate2 = of_separate3 = of_separate4 = separate

    def of_extract(self, node: Any, _kind: str, _: str) -> str:
        index = self.input(node, "index")
        text = bracket(self.input(node, "in"))
        return f"{text}.{'xyzw'[int(index)]}" if re.fullmatch("[0-3]", index) else f"{text}[{index}]"

    def of_swizzle(self, node: Any, kind: str, _: str) -> str:
        channels = self.port(node, "channels").getValueString()
        source = bracket(self.input(node, "in"))
        one = SIZES[TYPES[self.port(node, "in").getType()]] == 1
        parts = [c if c in "01" else source if one else f"{source}.{c.translate(str.maketrans('rgba', 'xyzw'))}" for c in channels]
        return parts[0] if len(parts) == 1 else f"{kind}({', '.join(parts)})"

    def of_convert(self, node: Any, kind: str, _: str) -> str:
        return self.input(node, "in", kind)

    def of_switch(self, node: Any, kind: str, _: str) -> str:
        which = bracket(self.input(node, "which"))
        cases = [self.input(node, f"in{i}") for i in range(1, 11) if self.has(node, f"in{i}")]
        text = f"{kind}(0)"
        for i, case in reversed(list(enumerate(cases))):
            text = f"{which} < {i + 1} ? {bracket(case)} : {text}"
        return text

    def of_image(self, node: Any, kind: str, _: str) -> str:
        file = self.port(node, "file").getResolvedValueString()
        if not file:
            return self.input(node, "default")
        texture = self.look.texture(file, node)
        at = self.input(node, "texcoord")
        text = f"{texture}.Sample{max(SIZES[kind], 3) if SIZES[kind] == 2 else SIZES[kind]}({at}, 0)" + (".xy" if kind == "float2" else "")
        return text if node.getAttribute("beyond") else self.or_default(node, text)

    def or_default(self, image: Any, text: str) -> str:
        """Returns the default beyond a picture whose address mode is `constant`."""
        at = bracket(self.input(image, "texcoord"))
        inside = [f"{at}.{letter} >= 0 && {at}.{letter} <= 1" for letter, name in (("x", "uaddressmode"), ("y", "vaddressmode")) if address_mode(image, name) == "constant"]
        return f"{' && '.join(inside)} ? {text} : {bracket(self.input(image, 'default'))}" if inside else text

    def of_beyond_picture(self, node: Any, _kind: str, _: str) -> str:
        """Writes what stands behind a picture's conversion."""
        return self.or_default(node.getParent().getChild(node.getInput("of").getValueString()), self.input(node, "in"))

    def of_transformmatrix(self, node: Any, kind: str, _: str) -> str:
        port = self.port(node, "mat")
        held = port.getConnectedNode()
        value = (held.getInput("value") if held is not None and held.getCategory() == "constant" and held.getInput("value") is not None else port).getValue()
        if value is None or kind != "float3" or value.numRows() != 3 or (held is not None and held.getCategory() != "constant"):
            raise self.fail(node, "turns by a matrix that is not a constant of 3 x 3; bake it to a picture in the program that made it")
        at = self.input(node, "in")
        if not re.fullmatch(r"\w+", at):
            name = name_of(node.getName() + "_in", self.taken)
            self.out.lines.append(f"float3 {name} = {at};")
            at = name
        return f"float3({', '.join(f'dot({at}, {literal([value[row, column] for row in range(3)], kind)})' for column in range(3))})"

    def of_geomcolor(self, node: Any, kind: str, _: str) -> str:
        self.look.note(node, "colours of vertices are white here")
        return literal([1] * SIZES[kind] if SIZES[kind] > 1 else 1, kind)

    def still(self, node: Any, kind: str, _: str) -> str:
        self.look.note(node, "a print does not move: 0")
        return literal([0] * SIZES[kind] if SIZES[kind] > 1 else 0, kind)

    of_time = of_frame = still


def bracket(text: str) -> str:
    """Returns an expression in brackets if a neighbouring operator could split it."""
    return text if re.fullmatch(r"[\w.]+|\w+\([^()]*(\([^()]*\)[^()]*)*\)(\.\w+)?", text) else f"({text})"
