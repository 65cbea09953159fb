# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Shows worlds and prints in notebooks. The page contains everything; nothing is fetched."""

from __future__ import annotations

import base64
import html
import uuid

import numpy as np
from numpy.typing import NDArray

from . import _core, _files
from .errors import InputError
from .previewing import preview
from .printing import Print
from .reading import Voxels
from .slices import PrintInfo
from .world import AnyWorld, FileWorld, World

# The number of voxels in the print for a picture.
_PICTURE_VOXELS = 1.5e6


def show_in_notebooks() -> None:
    """Adds the display methods of notebooks to worlds and prints, whose own modules know nothing of display."""
    for kind in (World, FileWorld):
        setattr(kind, "_repr_png_", world_png)
    for shown in (Print, Voxels):
        setattr(shown, "_repr_html_", print_html)
    setattr(Print, "_repr_png_", lambda self: world_png(self._world))


def world_png(world: AnyWorld) -> bytes:
    """Returns a picture of a world, made from a coarse print of it."""
    with Print(world, {}, _core.Target.NOTHING) as setup:
        info = setup.info
    voxels = float(np.prod([float(n) for n in info.size]))
    volume = voxels * float(np.prod(info.pitch_mm))
    pitch = max((volume / _PICTURE_VOXELS) ** (1 / 3), min(info.pitch_mm))
    (picture,) = preview(world, voxel=pitch)
    return _files.png(picture)


def slice_png(codes: NDArray[np.uint8], info: PrintInfo) -> bytes:
    """Returns a picture of one slice, +y up, in the colours of its materials; void is transparent."""
    palette = np.array([(0, 0, 0, 0), *((*m.preview[:3], 255) for m in info.materials)], np.uint8)
    return _files.png(codes[::-1], palette)


def print_html(print_: Print | Voxels) -> str:
    """Returns a page with a slider over the thumbnails of a print or a file; before there are any, its grid and materials."""
    try:
        info = print_.info
    except InputError:  # closed before anything was known
        return f"<div>{html.escape(repr(print_))}</div>"
    (x, y, z), (px, py, pz) = info.size, info.pitch_mm
    head = (
        f"<b>{html.escape(info.title)}</b> on {html.escape(info.printer)}: {x} × {y} × {z} voxels of "
        f"{px:.4g} × {py:.4g} × {pz:.4g} mm"
    )
    legend = " ".join(
        f"<span style='display:inline-block;width:1em;height:1em;border:1px solid #888;vertical-align:middle;"
        f"background:rgb{material.preview[:3]}'></span> {html.escape(material.name)}"
        for material in info.materials
    )
    thumbnails = print_.thumbnails
    if not thumbnails:
        return f"<div>{head}<br>{legend}</div>"
    sources = [
        f'"data:image/png;base64,{base64.b64encode(slice_png(codes, info)).decode()}"' for _, codes in thumbnails
    ]
    heights = [f'"slice {z} of {info.size[2]}, {(z + 0.5) * pz:.3f} mm"' for z, _ in thumbnails]
    middle = len(sources) // 2
    ident = "openfab" + uuid.uuid4().hex
    width = min(480, max(160, 2 * thumbnails[0][1].shape[1]))
    aspect = f"{x * px:.6g} / {y * py:.6g}"
    return f"""<div id="{ident}">{head}<br>
<img src={sources[middle]} style="width:{width}px;aspect-ratio:{aspect};image-rendering:pixelated;background:#ddd"><br>
<input type="range" min="0" max="{len(sources) - 1}" value="{middle}" style="width:{width}px">
<span>{heights[middle][1:-1]}</span>
<br>{legend}
<script>(function () {{
  const root = document.getElementById("{ident}"), slices = [{",".join(sources)}], texts = [{",".join(heights)}];
  root.querySelector("input").addEventListener("input", function () {{
    root.querySelector("img").src = slices[this.value];
    root.querySelector("span").textContent = texts[this.value];
  }});
}})();</script></div>"""
