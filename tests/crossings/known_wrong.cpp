// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Cells that are not as their twin: those that documents say to be otherwise, and those that are wrong.

#include "tests/crossings/table.h"

namespace openfab::testing {

namespace {

constexpr Known kDocumented[] = {
    {{"gaps|rows|arrange", "displaced", "*"},
     "boxes that place things are those before displacement (world/WORLDS.md)"},
    {{"support", "displaced", "*"},
     "support may lie on top, up to the greatest displacement (world/WORLDS.md)"},
};

constexpr Known kWrong[] = {
    {{"bed|bed alone|gaps|rows|tray|arrange|split", "shape|undeclared|of *|grown*|program*", "*"},
     "the box of the world stands for the solid before the print"},
    {{"bed|bed alone|gaps|rows|tray|arrange", "beams", "*"},
     "boxes of turned beams and of their pieces are those of a box around them"},
};

}  // namespace

std::span<const Known> documented() {
    return kDocumented;
}

std::span<const Known> known_wrong() {
    return kWrong;
}

}  // namespace openfab::testing
