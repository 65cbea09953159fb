# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Stands in for `openfab print`, `openflc check` and `openflc describe` where the wheel's own programs run them."""

from __future__ import annotations

import json
import sys
from pathlib import Path

from . import _core
from .errors import Error
from .world import load


def main(words: list[str]) -> int:
    """Does what a program with these words does, with the compiler and the runtime of the package; returns its exit code."""
    if words[:2] == ["openfab", "print"] and len(words) > 2 and words[2].endswith(".fab.json"):
        return _print(words[2:])
    if words[:3] == ["openflc", "--diagnostics", "json"] and len(words) == 5 and words[3] in ("check", "describe"):
        return _interface(words[3], words[4])
    print(f"error: `{' '.join(words[:4])}` is not in the Python package; OPENFAB_PROGRAM names an `openfab`", file=sys.stderr)
    return 2


def _print(words: list[str]) -> int:
    try:
        allowed = [word.removeprefix("--allow=") for word in words if word.startswith("--allow=")]
        program = load(words[0], allow=allowed)._snapshot().program()
    except Error as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    return program.main(["openfab print", *words])


def _interface(what: str, file: str) -> int:
    found = _core.read_file_interface(Path(file))
    said = found.diagnostics
    if said.fault:
        print(f"error: {said.fault}", file=sys.stderr)
        return said.code
    text = found.json if what == "describe" and said.code == 0 else said.json or '{"diagnostics": []}'
    print(json.dumps(json.loads(text)))  # a line
    return said.code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
