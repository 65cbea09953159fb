# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""What becomes of a file of a suite: as expected, refused, not compared, or wrong."""

from __future__ import annotations


class Refused(Exception):
    """Our message."""


class Unread(Exception):
    """Why there is nothing to compare with."""


class Wrong(Exception):
    """Other numbers, a crash, no end."""


def outcome_of(problem: Exception | None) -> tuple[str, str]:
    """Returns the outcome's name, and why."""
    if problem is None:
        return "as expected", ""
    kinds: dict[type, str] = {Refused: "refused", Unread: "not compared", Wrong: "wrong", AssertionError: "wrong"}
    return next((name for kind, name in kinds.items() if isinstance(problem, kind)), "wrong"), str(problem) or type(problem).__name__
