# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""The package holds its own sources and nothing else: the build back end takes all that lies in its folder."""

from __future__ import annotations

from pathlib import Path

FOLDER = Path(__file__).parents[2] / "python/openfab"
DATA = {"materialx.fl", "py.typed"}


def test_the_folder_of_the_package_holds_sources_alone():
    files = [file for file in FOLDER.rglob("*") if file.is_file() and "__pycache__" not in file.parts]
    assert FOLDER / "__init__.py" in files
    assert [file for file in files if file.suffix != ".py" and file.relative_to(FOLDER).as_posix() not in DATA] == []
    for file in files:
        if file.suffix == ".py":
            assert "The OpenFab Authors" in file.read_text(encoding="utf-8").splitlines()[0], file
