# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Prepares a MaterialX document as its shader generator does: colour spaces, units and resolved file names become nodes and
values, inputs of coordinates that are not connected are those of the surface, and nodes defined as graphs become graphs."""

from __future__ import annotations

import math
from functools import partial
from typing import Any, Callable, Iterator

if __package__:
    from .materialx_nodes import LooksError, address_mode
else:
    from materialx_nodes import LooksError, address_mode  # type: ignore[import-not-found, no-redef]

# Other names of the colour spaces of MaterialX' colour management.
ALIASES = {
    "gamma18": "g18_rec709", "g18_rec709_scene": "g18_rec709", "gamma22": "g22_rec709", "g22_rec709_scene": "g22_rec709",
    "gamma24": "rec709_display", "lin_ap1": "acescg", "lin_ap1_scene": "acescg", "g22_ap1_scene": "g22_ap1",
    "srgb_rec709_scene": "srgb_texture", "lin_adobergb_scene": "lin_adobergb", "g22_adobergb_scene": "adobergb",
    "srgb_p3d65_scene": "srgb_displayp3", "lin_p3d65_scene": "lin_displayp3",
}
LINEAR = {"", "lin_rec709", "lin_rec709_scene", "none", "raw"}
COLORS = ("color3", "color4")
NUMBERS = {"float", "vector2", "vector3", "vector4"}


def graphs_of(parent: Any, library: Any) -> Iterator[Any]:
    """Yields a document or graph, and the graphs in it that are not the library's: also those of files that it includes."""
    yield parent
    for child in parent.getChildren():
        if child.getCategory() == "nodegraph" and not (child.hasSourceUri() and library.getNodeGraph(child.getName()) is not None):
            yield from graphs_of(child, library)


class Prepared:
    """A document whose values are all in linear light, the look's unit and degrees."""

    def __init__(self, document: Any, library: Any, unit_mm: float, note: Callable[[Any, str], None]) -> None:
        self.document, self.library, self.unit_mm, self.note = document, library, unit_mm, note
        self.made: dict[str, Any] = {}  # by a picture's node: what was put behind it
        self.spaces = sorted({*ALIASES, *(one.getName()[3:-len("_to_lin_rec709_color3")] for one in document.getNodeDefs() if one.getName().endswith("_to_lin_rec709_color3"))})
        graphs = [*graphs_of(document, library)]
        # All are looked at before any is changed: attributes hold for what is within.
        todo = [work for graph in graphs for node in graph.getNodes() for work in self.work_of(graph, node)]
        for work in todo:
            work()
        for graph in graphs:
            for name in ("fileprefix", "colorspace"):
                graph.removeAttribute(name)
            for node in graph.getNodes():
                node.removeAttribute("fileprefix")

    def space_of(self, port: Any) -> str:
        """Returns the colour space of an input's value as MaterialX' library names it; "" for linear light."""
        space: str = port.getActiveColorSpace()
        if space in LINEAR:
            return ""
        name = ALIASES.get(space, space)
        if self.document.getNodeDef(f"ND_{name}_to_lin_rec709_color3") is None:
            raise LooksError(f"{port.getNamePath()}: the colour space `{space}` is not known; {', '.join(self.spaces)} are")
        return name

    def work_of(self, graph: Any, node: Any) -> Iterator[Callable[[], None]]:
        """Yields what is to be done with a node's inputs."""
        definition = node.getNodeDef()
        for port in node.getInputs():
            source = port
            if port.hasInterfaceName() and graph.getCategory() == "nodegraph" and graph.getNodeDef() is not None:
                continue  # of a definition in the file: its values come from where it is used
            while (before := self.before(source)) is not None:
                source = before
            if source.getConnectedNode() is not None or source.getConnectedOutput() is not None or not source.hasValueString():
                continue
            declared = definition.getActiveInput(port.getName()) if definition is not None else None
            if source is port and declared is not None and declared.getAttribute("defaultgeomprop"):
                yield partial(self.forget, node, port)
                continue
            kind = port.getType()
            if kind == "filename":
                yield from self.picture(graph, node, port, source)
                continue
            space = self.space_of(source) if kind in COLORS else ""
            factor = self.factor(source) if kind in NUMBERS else 1
            if space:
                yield partial(self.linear_value, graph, node, port, source, space)
            elif source is not port or factor != 1:
                yield partial(self.own_value, port, source, factor)

    def before(self, port: Any) -> Any:
        """Returns the input whose value another has: of a graph, or of a node that passes on a file's name."""
        outer = port.getInterfaceInput() if port.hasInterfaceName() else None
        if outer is not None and outer is not port:
            return outer
        node = port.getConnectedNode() if port.getType() == "filename" else None
        if node is not None and node.getCategory() != "dot":
            raise LooksError(f"{port.getNamePath()}: the name of the file comes from `{node.getName()}`; write the name itself")
        return node.getInput("in") if node is not None else None

    def forget(self, node: Any, port: Any) -> None:
        self.note(node, f"the value written on `{port.getName()}` is not used, as in MaterialX' shaders: an input of coordinates that is not connected takes those of the surface")
        node.removeInput(port.getName())

    def picture(self, graph: Any, node: Any, port: Any, source: Any) -> Iterator[Callable[[], None]]:
        file = source.getResolvedValueString()

        def name_it() -> None:
            for name in ("interfacename", "nodename"):
                port.removeAttribute(name)
            port.setValueString(file)

        yield name_it
        outputs = [("", node.getType())] if node.getType() != "multioutput" else [(one.getName(), one.getType()) for one in (node.getNodeDef().getActiveOutputs() if node.getNodeDef() else [])]
        factor = self.factor(source)
        for name, kind in outputs:
            space = self.space_of(source) if kind in COLORS and file else ""
            if space:
                yield partial(self.behind, graph, node, name, kind, f"{space}_to_lin_rec709", {})
            elif factor != 1 and kind in NUMBERS:
                self.note(node, f"the unit `{source.getUnit()}` of the picture is not used, as in MaterialX' shaders: its numbers are lengths of the look; multiply them")
        if node.getCategory() == "image" and outputs[0][0] == "" and "constant" in (address_mode(node, "uaddressmode"), address_mode(node, "vaddressmode")):
            # The default beyond the picture is a value of its own: no colour of the picture, nor a length of it.
            node.setAttribute("beyond", "elsewhere")
            yield partial(self.behind, graph, node, "", node.getType(), "beyond_picture", {"of": ("string", node.getName())}, last=True)

    def factor(self, port: Any) -> float:
        """Returns what turns an input's value into the look's unit, or into degrees."""
        unit = port.getUnit() or (port.getActiveUnit() if port.getUnitType() else "")
        if not unit:
            return 1
        for definition in self.document.getUnitDefs():
            scale = definition.getChild(unit)
            if scale is None:
                continue
            if definition.getUnitType() == "distance":
                return float(scale.getAttribute("scale")) * 1000 / self.unit_mm
            if definition.getUnitType() == "angle":
                return math.degrees(1) if unit == "radian" else float(scale.getAttribute("scale"))
        raise LooksError(f"{port.getNamePath()}: the unit `{unit}` is not known")

    def linear_value(self, graph: Any, node: Any, port: Any, source: Any, space: str) -> None:
        made = graph.addNode(f"{space}_to_lin_rec709", graph.createValidChildName(f"{node.getName()}_{port.getName()}"), port.getType())
        value = made.addInput("in", port.getType())
        value.setValueString(source.getValueString())
        name = port.getName()
        node.removeInput(name)
        node.addInput(name, made.getType()).setNodeName(made.getName())

    def own_value(self, port: Any, source: Any, factor: float) -> None:
        text = source.getValueString()
        if factor != 1:
            text = ", ".join(repr(float(one) * factor) for one in text.replace(",", " ").split())
        for name in ("interfacename", "unit", "unittype"):
            port.removeAttribute(name)
        port.setValueString(text)

    def behind(self, graph: Any, node: Any, output: str, kind: str, category: str, more: dict[str, tuple[str, str]], last: bool = False) -> None:
        """Puts a node behind another's output, or behind the last that was put there; what read that reads the node."""
        behind = self.made.get(node.getNamePath()) if last else None
        readers = [port for port in self.readers(graph, behind or node, output)]
        made = graph.addNode(category, graph.createValidChildName(f"{node.getName()}_linear"), kind)
        self.made[node.getNamePath()] = made
        node = behind or node
        first = made.addInput("in", kind)
        first.setNodeName(node.getName())
        if output:
            first.setOutputString(output)
        for name, (held, value) in more.items():
            port = made.addInput(name, held)
            port.setValueString(value)
        for port in readers:
            port.setNodeName(made.getName())
            port.removeAttribute("output")

    def readers(self, graph: Any, node: Any, output: str) -> Iterator[Any]:
        ports = [port for other in graph.getNodes() for port in other.getInputs()] + list(graph.getOutputs())
        ports += [port for inner in graphs_of(graph, self.library) if inner is not graph for port in inner.getInputs()]
        for port in ports:
            if port.getNodeName() == node.getName() and (not output or (port.getOutputString() or "") == output):
                yield port


def flatten(document: Any, library: Any, is_known: Callable[[str], bool], models: dict[str, Any]) -> None:
    """Replaces nodes that MaterialX, or the file, defines as graphs by these graphs."""

    def leads_to_model(node: Any) -> bool:
        implementation = node.getImplementation()
        return implementation is not None and implementation.getCategory() == "nodegraph" and any(one.getCategory() in models for one in implementation.getNodes())

    def wanted(node: Any) -> bool:
        if node.getCategory() in models or node.getType() in ("material", "displacementshader"):
            return False
        return leads_to_model(node) if node.getType() == "surfaceshader" else not is_known(node.getCategory())

    for graph in reversed([*graphs_of(document, library)]):
        graph.flattenSubgraphs("genglsl", wanted)
