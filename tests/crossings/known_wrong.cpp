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
    {{"estimate|statistics", "grown*|program*", "*"},
     "passes and their waste are those of all of its `box_mm`, which is printed (docs/process.md)"},
    {{"part", "grown*|program*", "several that touch"},
     "elements begin at the `box_mm`, those of the twin at the part (docs/mechanics.md): where two "
     "solids touch by a "
     "fraction of an element, the stiffness is another"},
    {{"field", "beams", "*"},
     "sections of beams stay round where a field stretches them one way (docs/process.md)"},
};

}  // namespace

std::span<const Known> documented() {
    return kDocumented;
}

std::span<const Known> known_wrong() {
    return {};
}

}  // namespace openfab::testing
