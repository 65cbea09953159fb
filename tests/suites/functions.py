# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Level sets of 3MF files, imported and printed, against the evaluator of tests/import/implicit.py: each voxel's centre on one side."""

from __future__ import annotations

import json
import sys
import tempfile
from pathlib import Path
from typing import Any, Callable

import numpy as np
from outcome import Unread, Wrong

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "import"))
from implicit import Model, numbers, tag  # noqa: E402

STEPS = 100  # voxels along the longest side
UNITS = {"micron": 1e-3, "millimeter": 1, "centimeter": 10, "inch": 25.4, "foot": 304.8, "meter": 1000}
NEAR = 2e-5  # of the values around a voxel: floats of ours decide otherwise there


def placed(model: Model) -> list[tuple[Any, np.ndarray]]:
    """Returns the level sets of the build, and their transforms."""
    found = []
    for item in model.objects("item"):
        held = [e for e in model.by_id[int(item.get("objectid", "0"))] if tag(e) == "levelset"]
        if not held:
            raise Unread("not all of its objects are level sets")
        found.append((held[0], numbers(item.get("transform", "1 0 0 0 1 0 0 0 1 0 0 0")).reshape(4, 3)))
    return found


def is_box(model: Model, level_set: Any) -> bool:
    """Returns whether the mesh that bounds a level set is a box, or only its box counts."""
    if level_set.get("meshbboxonly") == "true":
        return True
    lo, hi = model.bounds(level_set)
    corners = [[float(v.get(a, "0")) for a in "xyz"] for v in model.by_id[int(level_set.get("meshid", "0"))].iter() if tag(v) == "vertex"]
    return all(c in (a, b) for corner in corners for c, a, b in zip(corner, lo, hi))


def compare(run: Callable[[list[str]], str], tool: str, file: Path) -> None:
    try:
        model = Model(file)
        unit = UNITS[model.root.get("unit", "millimeter")]
        sets = placed(model)
        if not all(is_box(model, one) for one, _ in sets):
            raise Unread("a mesh bounds its level set")
        boxes = [np.array([np.array(c) @ t[:3] + t[3] for c in np.array(np.meshgrid(*zip(*model.bounds(one)))).reshape(3, -1).T]) * unit for one, t in sets]
    except (ValueError, KeyError) as problem:
        raise Unread(f"{type(problem).__name__} {problem}") from problem
    lo, hi = np.min([b.min(axis=0) for b in boxes], axis=0), np.max([b.max(axis=0) for b in boxes], axis=0)
    with tempfile.TemporaryDirectory() as folder:
        run([tool, "import", str(file), "-o", f"{folder}/w"])
        world = next(Path(folder).glob("w/*.fab.json"))
        out = Path(folder) / "a.npy"
        where = json.loads(world.read_text())  # where the file has it, not down on the bed
        where["build"] = [{**one, "translate_mm": (one["translate_mm"] + [0])[:3], "on_bed": False} for one in where["build"]]
        world.write_text(json.dumps(where))
        pitch = float(np.max(hi - lo)) / STEPS
        run([tool, "print", str(world), "-o", str(out), "--voxel", f"{pitch:.6g}mm", "--support", "off", "--progress", "none"])
        codes, about = np.load(out) != 0, json.loads(Path(f"{out}.json").read_text())
    steps, origin = np.array(about["pitch_mm"]), np.array(about["origin_mm"])
    first = np.floor((lo - origin) / steps).astype(int) - 1
    count = np.ceil((hi - origin) / steps).astype(int) + 1 - first
    ours = np.zeros(count[::-1], bool)  # of the whole box, by z, y, x
    begin = -first[::-1]
    ours[tuple(slice(b, b + n) for b, n in zip(begin, codes.shape))] = codes
    wrong = solid = 0
    for z in range(count[2]):
        x, y = np.meshgrid(np.arange(count[0]), np.arange(count[1]))
        at = origin + (np.stack([x, y, np.full_like(x, z)], axis=-1).reshape(-1, 3) + first + 0.5) * steps
        inside, unsure = np.zeros(len(at), bool), np.zeros(len(at), bool)
        for level_set, transform in sets:
            own = (at / unit - transform[3]) @ np.linalg.inv(transform[:3])
            low, high = model.bounds(level_set)
            within = np.all((own >= low) & (own <= high), axis=1)
            edge = np.min(np.abs(np.concatenate([own - low, own - high], axis=1)), axis=1) < 1e-4
            try:
                value = model.level(level_set, own)
            except (ValueError, KeyError, StopIteration) as problem:
                raise Unread(f"{type(problem).__name__} {problem}") from problem
            inside |= within & (value <= 0)
            unsure |= edge | (np.abs(value) < NEAR * np.maximum(1, np.abs(own).max(axis=1)))
        here = ours[z].reshape(-1)
        wrong += int(np.count_nonzero((here != inside) & ~unsure))
        solid += int(np.count_nonzero(inside))
    if wrong:
        raise Wrong(f"{wrong} voxels differ, of {solid} that are solid")
