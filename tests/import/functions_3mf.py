# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""3MF files with functions, written node by node."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import lib3mf
import numpy as np
from conftest import VOXEL, Print, box
from PIL import Image

CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
SPACES = {
    "v": "http://schemas.3mf.io/3dmanufacturing/volumetric/2022/01",
    "i": "http://schemas.3mf.io/3dmanufacturing/implicit/2023/12",
    "d": "http://schemas.3mf.io/3dmanufacturing/displacement/2023/10",
    "b": "http://schemas.microsoft.com/3dmanufacturing/beamlattice/2017/02",
}
RELS = "http://schemas.openxmlformats.org/package/2006/relationships"


def cube(low: float, high: float, attributes: str = "") -> str:
    corners, faces = box(high - low, (low, low, low))
    vertices = "".join(f'<vertex x="{x:g}" y="{y:g}" z="{z:g}"/>' for x, y, z in corners)
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in faces)
    return f"<mesh{attributes}><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh>"


def package(file: Path, resources: str, build: str, required: str, more: dict[str, bytes] | None = None) -> Path:
    spaces = " ".join(f'xmlns:{p}="{s}"' for p, s in SPACES.items())
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED) as out:
        content = "".join(
            f'<Default Extension="{e}" ContentType="{t}"/>'
            for e, t in (
                ("rels", "application/vnd.openxmlformats-package.relationships+xml"),
                ("model", "application/vnd.ms-package.3dmanufacturing-3dmodel+xml"),
                ("png", "image/png"),
            )
        )
        out.writestr(
            "[Content_Types].xml",
            f'<?xml version="1.0"?><Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">{content}</Types>',
        )
        out.writestr(
            "_rels/.rels",
            f'<?xml version="1.0"?><Relationships xmlns="{RELS}"><Relationship Target="/3D/3dmodel.model" Id="r0" '
            'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>',
        )
        if more:
            parts = "".join(
                f'<Relationship Target="/{name}" Id="p{k}" '
                'Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dtexture"/>'
                for k, name in enumerate(more)
            )
            out.writestr(
                "3D/_rels/3dmodel.model.rels",
                f'<?xml version="1.0"?><Relationships xmlns="{RELS}">{parts}</Relationships>',
            )
        out.writestr(
            "3D/3dmodel.model",
            f'<?xml version="1.0" encoding="UTF-8"?><model unit="millimeter" xml:lang="en-US" xmlns="{CORE}" {spaces} '
            f'requiredextensions="{required}"><resources>{resources}</resources><build>{build}</build></model>',
        )
        for name, data in (more or {}).items():
            out.writestr(name, data)
    return file


class Graph:
    """Nodes of one function, added one by one; each is "NAME.OUTPUT" with a type."""

    def __init__(self) -> None:
        self.text: list[str] = []

    def add(self, kind: str, result: str, attributes: str = "", output: str = "result", **inputs: tuple[str, str]) -> tuple[str, str]:
        name = f"n{len(self.text)}"
        refs = "".join(f'<i:{t}ref identifier="{n}" ref="{r}"/>' for n, (r, t) in inputs.items())
        into = f"<i:in>{refs}</i:in>" if refs else ""
        outs = "".join(f'<i:{result} identifier="{o}"/>' for o in output.split())
        self.text.append(f'<i:{kind} identifier="{name}" {attributes}>{into}<i:out>{outs}</i:out></i:{kind}>')
        return f"{name}.{output.split()[0]}", result

    def constant(self, value: float) -> tuple[str, str]:
        return self.add("constant", "scalar", f'value="{value!r}"', "value")

    def function(self, number: int, outputs: dict[str, tuple[str, str]]) -> str:
        outs = "".join(f'<i:{t}ref identifier="{n}" ref="{r}"/>' for n, (r, t) in outputs.items())
        return (
            f'<i:implicitfunction id="{number}" displayname="f{number}"><i:in><i:vector identifier="pos"/></i:in>'
            f"{''.join(self.text)}<i:out>{outs}</i:out></i:implicitfunction>"
        )


POS = ("inputs.pos", "vector")


def ball(number: int, radius: float) -> str:
    g = Graph()
    far = g.add("length", "scalar", A=POS)
    return g.function(number, {"shape": g.add("subtraction", "scalar", A=far, B=g.constant(radius))})


def volume(made: Print) -> float:
    return float((made.codes > 0).sum()) * VOXEL**3


def strict(file: Path) -> None:
    """Checks that lib3mf reads the file in strict mode without a warning."""
    model = lib3mf.get_wrapper().CreateModel()
    reader = model.QueryReader("3mf")
    reader.SetStrictModeActive(True)
    reader.ReadFromFile(str(file))
    assert reader.GetWarningCount() == 0


def png(array: np.ndarray) -> bytes:
    out = io.BytesIO()
    Image.fromarray(array).save(out, "PNG")
    return out.getvalue()
