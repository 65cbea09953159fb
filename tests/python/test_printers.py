# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
from __future__ import annotations

import openfab


def test_printers_are_known_by_name() -> None:
    known = openfab.printers()
    j850 = known["j850"]
    assert (j850.maker, j850.model) == ("Stratasys", "J850 Prime")
    assert j850.pitch_mm == (25.4 / 600, 25.4 / 300, 0.027)
    assert j850.build_volume_mm == (490, 390, 200)
    assert j850.inks["VeroClear"] == 1.185
    assert {source["seen"] for source in j850.sources} <= {"read", "quoted", "unread"}


def test_what_is_not_known_is_none() -> None:
    j55 = openfab.printers()["j55"]
    assert j55.pitch_mm[:2] == (None, None)
    assert "dpi" in j55.unknown
    assert openfab.printers()["inkjet_kit"].build_volume_mm == (None, None, None)
