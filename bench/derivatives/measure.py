#!/usr/bin/env python3
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""What derivatives by 4 and by 16 numbers cost, against the volume stage alone, in one run: processor seconds of the stage
with its queries, in turn, every voxel evaluated. Limits: 2.5 times for 4 numbers, 6 times for 16.

    python bench/derivatives/measure.py [--rounds N] [--voxel MM]
"""
from __future__ import annotations

import argparse
import statistics

import openfab
from openfab import _core
from openfab._options import fields_of
from openfab.printing import Print

BODIES = {
    # Name: expressions of the point p, the distance d and the uniforms u[0] to u[15].
    "arithmetic": "float w = 1; for (int i = 0; i < 16; ++i) w += u[i] * sin(u[i] * p.x + p.y * 0.1 * float(i)); w = w * w",
    "noise": "float w = 1; for (int i = 0; i < 4; ++i) w += u[4 * i] * noise(p * u[4 * i + 1] + u[4 * i + 2]) * exp(-u[4 * i + 3] * d * d)",
    "distance": "float w = 1; for (int i = 0; i < 16; ++i) w += smoothstep(0.0, u[i], d + 0.1 * float(i))",
    "queries": "float w = 1; for (int i = 0; i < 4; ++i) w += u[4 * i] * exp(-distance(p + float3(u[4 * i + 1], u[4 * i + 2], u[4 * i + 3]))) ",
    "loop": "float w = 1; int k = 0; @bound(20) while (k < 12 + int(abs(p.x))) { w = w * 0.5 + sin(w * u[k % 16]); k++; } w = w * w",
}
TEXT = """fablet Many {{
    @uniform {{ float u[16] = {{{values}}}; Material one, other; }}
    @Volume(@varying {{ VolumeAttributes attr }})
    {{
        float3 p = attr.voxelCenter;
        float d = -distance(p);
        {body};
        MaterialComposition mc;
        mc.Set(one, abs(w));
        mc.Set(other, 1.0);
        return mc;
    }}
}}"""


def seconds(world: openfab.World, voxel: float, derivatives: tuple[str, ...]) -> float:
    fields = fields_of(voxel=voxel, support=False, sampling="centre", threads=1)
    fields["culling"] = False
    with Print(world, fields, _core.Target.SLICES, fractions=True, derivatives=derivatives) as running:
        for _ in running:
            pass
    phases = running.statistics["seconds_by_phase"]
    return float(phases["slab"] + phases["nearest"])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--voxel", type=float, default=0.25)
    options = parser.parse_args()
    values = ", ".join(f"{0.2 + 0.05 * k:.2f}" for k in range(16))
    print(f"{'body':12} {'alone, s':>9} {'by 4':>6} {'by 16':>6}")
    for name, body in BODIES.items():
        text = TEXT.format(values=values, body=body)
        worlds = []
        for few in (False, True):
            # Four of the numbers as uniforms of their own.
            own = text
            if few:
                own = text.replace(f"float u[16] = {{{values}}}", "float4 v = float4(0.2, 0.25, 0.3, 0.35)")
                own = own.replace("float3 p =", f"float u[16] = {{v.x, v.y, v.z, v.w, {values.split(', ', 4)[4]}}};\n        float3 p =")
            world = openfab.World(printer="generic")
            materials = {"one": openfab.Material("one", "#ffffff"), "other": openfab.Material("other", "#000000")}
            world.add(openfab.torus(12, 8), openfab.Fablet(text=own), materials, name="ring")
            worlds.append(world)
        runs = {"alone": (worlds[0], ()), "4 alone": (worlds[1], ()), "4": (worlds[1], ("ring.v",)), "16": (worlds[0], ("ring.u",))}
        times: dict[str, list[float]] = {key: [] for key in runs}
        for round_ in range(options.rounds + 1):
            for key, (world, by) in runs.items():
                spent = seconds(world, options.voxel, by)
                if round_ > 0:  # the first compiles
                    times[key].append(spent)
        alone, few_alone, four, all_ = (statistics.median(times[key]) for key in runs)
        print(f"{name:12} {alone:9.3f} {four / few_alone:6.2f} {all_ / alone:6.2f}", flush=True)


if __name__ == "__main__":
    main()
