# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Evaluates functions of 3MF's implicit and volumetric extensions with numpy, in double precision: the twin that what
`openfab import` writes is compared with. Written from the specification alone; points are rows of an array."""

from __future__ import annotations

import io
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path
from typing import Any, Callable

import numpy as np
from PIL import Image

Array = np.ndarray


def tag(element: ET.Element) -> str:
    return element.tag.rsplit("}", 1)[1]


def numbers(text: str) -> Array:
    return np.array([float(word) for word in text.split()])


def child(element: ET.Element, name: str) -> list[ET.Element]:
    return [port for one in element if tag(one) == name for port in one]


def per_component(function: Callable[..., Array]) -> Callable[..., Array]:
    """Marks a function for scalars (n), vectors (n, 3) and matrices (n, 4, 4) alike."""
    return function


UNARY: dict[str, Callable[[Array], Array]] = {
    "sin": np.sin, "cos": np.cos, "tan": np.tan, "arcsin": np.arcsin, "arccos": np.arccos, "arctan": np.arctan,
    "asin": np.arcsin, "acos": np.arccos, "atan": np.arctan, "abs": np.abs, "sqrt": np.sqrt, "exp": np.exp,
    "log": np.log, "log2": np.log2, "log10": np.log10, "cosh": np.cosh, "sinh": np.sinh, "tanh": np.tanh,
    "round": np.round, "ceil": np.ceil, "floor": np.floor, "sign": np.sign, "fract": lambda a: a - np.floor(a),
}  # fmt: skip
BINARY: dict[str, Callable[[Array, Array], Array]] = {
    "addition": np.add, "subtraction": np.subtract, "multiplication": np.multiply, "division": np.divide,
    "arctan2": np.arctan2, "atan2": np.arctan2, "min": np.minimum, "max": np.maximum, "pow": np.power,
    "fmod": lambda a, b: a - b * np.trunc(a / b), "mod": lambda a, b: a - b * np.floor(a / b),
}  # fmt: skip


class Model:
    """A 3MF file whose functions are evaluated."""

    def __init__(self, file: Path):
        self.zip = zipfile.ZipFile(file)
        self.root = ET.fromstring(self.zip.read("3D/3dmodel.model"))
        self.by_id = {int(e.get("id", -1)): e for e in self.root.iter() if e.get("id")}
        self.images: dict[int, Array] = {}

    def objects(self, kind: str) -> list[ET.Element]:
        return [e for e in self.root.iter() if tag(e) == kind]

    # --- functions

    def call(self, function: int, output: str, inputs: dict[str, Any]) -> Any:
        element = self.by_id[function]
        if tag(element) == "functionfromimage3d":
            return self.image(element, inputs["pos"])[output]
        nodes = {e.get("identifier"): e for e in element if tag(e) not in ("in", "out")}
        known: dict[str, dict[str, Any]] = {"inputs": inputs}
        ref = next(p.get("ref", "") for p in child(element, "out") if p.get("identifier") == output)

        def value(reference: str) -> Any:
            name, port = reference.split(".")
            if name not in known:
                known[name] = self.node(nodes[name], value)
            outputs = known[name]
            return outputs[port] if port in outputs else next(iter(outputs.values()))

        return value(ref)

    def node(self, e: ET.Element, value: Callable[[str], Any]) -> dict[str, Any]:
        kind = tag(e)
        ports = {p.get("identifier", ""): p.get("ref", "") for p in child(e, "in")}

        def of(name: str) -> Any:
            return value(ports[name])

        if kind == "constant":
            return {"value": np.float64(e.get("value", "0"))}
        if kind == "constvec":
            return {"vector": np.array([[float(e.get(a, "0")) for a in "xyz"]])}
        if kind == "constmat":
            return {"matrix": numbers(e.get("matrix", "")).reshape(1, 4, 4)}
        if kind == "constresourceid":
            return {"value": int(e.get("value", "0"))}
        if kind == "composevector":
            return {"result": np.stack(np.broadcast_arrays(*(np.atleast_1d(of(a)) for a in "xyz")), axis=-1)}
        if kind == "vectorfromscalar":
            return {"result": np.repeat(np.atleast_1d(of("A"))[:, None], 3, axis=1)}
        if kind == "decomposevector":
            return {a: of("A")[..., i] for i, a in enumerate("xyz")}
        if kind == "composematrix":
            cells = [np.atleast_1d(of(f"m{r}{c}")) for r in range(4) for c in range(4)]
            return {"result": np.stack(np.broadcast_arrays(*cells), axis=-1).reshape(-1, 4, 4)}
        if kind in ("matrixfromcolumns", "matrixfromrows"):
            four = np.stack(np.broadcast_arrays(*(of(a) for a in "ABCD")), axis=1)  # n, 4, 3
            out = np.zeros((len(four), 4, 4))
            out[:, :, :3] = four
            out[:, 3, 3] = 1
            return {"result": out if kind == "matrixfromrows" else np.swapaxes(out, 1, 2)}
        if kind == "dot":
            return {"result": np.sum(of("A") * of("B"), axis=-1)}
        if kind == "cross":
            return {"result": np.cross(of("A"), of("B"))}
        if kind == "length":
            return {"result": np.sqrt(np.sum(of("A") ** 2, axis=-1))}
        if kind in ("matvecmultiplication", "matrixvectormultiplication"):
            vector = of("B")
            one = np.concatenate([vector, np.ones((len(vector), 1))], axis=1)
            return {"result": (of("A") @ one[:, :, None])[:, :3, 0]}
        if kind == "transpose":
            return {"result": np.swapaxes(of("A"), 1, 2)}
        if kind == "inverse":
            return {"result": np.linalg.inv(of("A"))}
        if kind == "select":
            return {"result": np.where(of("A") < of("B"), of("C"), of("D"))}
        if kind == "clamp":
            return {"result": np.maximum(of("min"), np.minimum(of("A"), of("max")))}
        if kind in UNARY:
            return {"result": UNARY[kind](of("A"))}
        if kind in BINARY:
            return {"result": BINARY[kind](of("A"), of("B"))}
        if kind == "functioncall":
            function = next(value(r) for n, r in ports.items() if n.lower() == "functionid")
            inputs = {n: value(r) for n, r in ports.items() if n.lower() != "functionid"}
            outputs = [p.get("identifier", "") for p in child(e, "out")]
            return Lazy(lambda output: self.call(function, output, inputs), outputs)
        raise ValueError(f"unknown node {kind}")

    # --- images

    def image(self, e: ET.Element, uvw: Array) -> dict[str, Array]:
        """Texels lie at (i + 0.5) / n; rows go down from v = 1."""
        number = int(e.get("image3did", "0"))
        if number not in self.images:
            sheets = [s.get("path", "").lstrip("/") for s in self.by_id[number].iter() if tag(s) == "imagesheet"]
            self.images[number] = np.stack([self.sheet(s)[::-1] for s in sheets])  # w, v, u, channel
        grid = self.images[number]
        scale, offset = float(e.get("valuescale", "1")), float(e.get("valueoffset", "0"))
        corners = []
        for axis, name in enumerate("uvw"):
            n = grid.shape[2 - axis]
            style, s = e.get(f"tilestyle{name}", "wrap"), uvw[:, axis]
            if style == "mirror":
                s = 1 - np.abs(s - 2 * np.floor(s / 2) - 1)
            t = s * n - 0.5
            if e.get("filter", "linear") == "nearest":
                t = np.round(t)
            low = np.floor(t)
            pairs = [(low.astype(int), 1 - (t - low)), (low.astype(int) + 1, t - low)]
            corners.append([(i % n if style == "wrap" else np.clip(i, 0, n - 1), w) for i, w in pairs])
        out = np.zeros((len(uvw), 4))
        for iu, wu in corners[0]:
            for iv, wv in corners[1]:
                for iw, ww in corners[2]:
                    out += grid[iw, iv, iu] * (wu * wv * ww)[:, None]
        out = out * scale + offset
        return {"color": out[:, :3], "red": out[:, 0], "green": out[:, 1], "blue": out[:, 2], "alpha": out[:, 3]}

    def sheet(self, path: str) -> Array:
        with Image.open(io.BytesIO(self.zip.read(path))) as picture:
            deep = picture.mode.startswith("I")
            pixels = np.asarray(picture if deep else picture.convert("RGBA"), dtype=np.float64)
        if deep:
            return np.concatenate([np.repeat(pixels[:, :, None] / 65535, 3, axis=2), np.ones((*pixels.shape, 1))], axis=2)
        return pixels / 255

    # --- level sets

    def level(self, of: ET.Element, points: Array) -> Array:
        """Returns the values of a level set's, colour's or property's function at points of its object."""
        matrix = numbers(of.get("transform", "1 0 0 0 1 0 0 0 1 0 0 0")).reshape(4, 3)
        moved = points @ matrix[:3] + matrix[3]
        with np.errstate(all="ignore"):
            value = self.call(int(of.get("functionid", "0")), of.get("channel", ""), {"pos": moved})
        return np.broadcast_to(value, (len(points), *np.shape(value)[1:]))

    def bounds(self, level_set: ET.Element) -> tuple[Array, Array]:
        mesh = self.by_id[int(level_set.get("meshid", "0"))]
        corners = np.array([[float(v.get(a, "0")) for a in "xyz"] for v in mesh.iter() if tag(v) == "vertex"])
        return corners.min(axis=0), corners.max(axis=0)


class Lazy(dict):
    """Outputs of a call, each computed on demand."""

    def __init__(self, call: Callable[[str], Any], names: list[str]):
        super().__init__({n: None for n in names})
        self.call, self.known = call, {}

    def __contains__(self, name: object) -> bool:
        return True

    def __getitem__(self, name: str) -> Any:
        if name not in self.known:
            self.known[name] = self.call(name)
        return self.known[name]
