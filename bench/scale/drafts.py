#!/usr/bin/env python3
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Prints worlds at drafts 1 to 8 and compares their costs: a coarser draft must never cost more.

    bench/scale/drafts.py [--bin build/release/bin] [--drafts 1-8] [WORLD.fab.json ...]

The default is all worlds of the gallery. Each print has one thread and its own process, for which the kernel counts
processor seconds and peak memory. The least of `--times` runs counts. Writes a table, and lists coarser drafts that take
more than a tenth and 0.05 s, or a tenth and 8 MB, above the cheapest finer one.
"""

import argparse
import os
import pathlib
import subprocess
import sys
import tempfile

TOP = pathlib.Path(__file__).resolve().parent.parent.parent


def print_world(program: pathlib.Path, world: pathlib.Path, draft: int, out: pathlib.Path) -> tuple[float, float] | None:
    """Returns processor seconds and peak memory in MB, or None if the print failed."""
    command = [str(program), "print", world.name, "-o", str(out), "--draft", str(draft), "--threads", "1"]
    child = subprocess.Popen(command, cwd=world.parent, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    return (usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1000) if child.returncode == 0 else None


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("worlds", nargs="*", type=pathlib.Path)
    parser.add_argument("--bin", type=pathlib.Path, default=TOP / "build/release/bin")
    parser.add_argument("--drafts", default="1-8", help="the first and the last")
    parser.add_argument("--times", type=int, default=2, help="runs of each print")
    options = parser.parse_args()
    first, last = (int(word) for word in options.drafts.split("-"))
    drafts = range(first, last + 1)
    worlds = options.worlds or sorted((TOP / "gallery").glob("*/*.fab.json"))
    broken = []
    print("| world | " + " | ".join(f"{d}: s, MB" for d in drafts) + " |")
    print("| --- " * (len(drafts) + 1) + "|")
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "a.ofr"
        for world in worlds:
            world = world.resolve()
            # Compiles, and converts what the caches hold from then on.
            if print_world(options.bin / "openfab", world, last, out) is None:
                print(f"| {world.name.removesuffix('.fab.json')} | does not print here |", flush=True)
                continue
            cells = []
            least = (float("inf"), float("inf"))
            for draft in drafts:
                runs = [print_world(options.bin / "openfab", world, draft, out) for _ in range(options.times)]
                done = [run for run in runs if run is not None]
                if not done:
                    cells.append("failed")
                    continue
                seconds, megabytes = (min(values) for values in zip(*done))
                cells.append(f"{seconds:.2f}, {megabytes:.0f}")
                if seconds > 1.1 * least[0] + 0.05 or megabytes > 1.1 * least[1] + 8:
                    broken.append(f"{world.name}: draft {draft} takes {cells[-1]}, a finer one {least[0]:.2f}, {least[1]:.0f}")
                least = (min(least[0], seconds), min(least[1], megabytes))
            print(f"| {world.name.removesuffix('.fab.json')} | " + " | ".join(cells) + " |", flush=True)
    print(*broken, sep="\n")
    return 1 if broken else 0


if __name__ == "__main__":
    sys.exit(main())
