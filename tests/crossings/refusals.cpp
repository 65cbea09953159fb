// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What the table's cells are refused by, and the remedy that is given.

#include "mechanics/messages.h"
#include "program/messages.h"
#include "runtime/part/messages.h"
#include "runtime/solid/messages.h"
#include "tests/crossings/table.h"
#include "tools/openfab/messages.h"

namespace openfab::testing {

namespace {

using namespace part::messages;
using namespace program::messages;
using namespace solid::messages;

constexpr Refusal kRefusals[] = {
    {{"bed|bed alone|gaps|rows|tray|beyond|arrange|split", "grown*|program*", "*"},
     kReachNotKnown,
     kReachNotKnownHelp},
    {{"beyond", "*", "*"}, kPartOutsideTray, ""},
    {{"stretch|machine stretch|matrix", "*", "pieces of a file"},
     kPieceUnevenScale,
     kPieceUnevenScaleHelp},
    {{"stretch|machine stretch|matrix", "beams", "*"}, kUnevenStretch, kBeamsUnevenScaleHelp},
    {{"stretch|machine stretch|matrix", "grown*|program*", "*"}, kUnevenStretch, kGrownScaledHelp},
    {{"matrix", "shape|undeclared|of *", "*"}, kShapeScaled, kShapeScaledHelp},
    {{"conduct", "*", "pieces"},
     mechanics::messages::kFlowNotJoined,
     mechanics::messages::kFlowNotJoinedHelp},
    {{"conduct", "primitive", "several that touch"},
     mechanics::messages::kFlowNotJoined,
     mechanics::messages::kFlowNotJoinedHelp},
    {{"cell", "displaced", "*"},
     mechanics::messages::kCellMoves,
     mechanics::messages::kCellMovesHelp},
    {{"strengthen", "*", "pieces*"},
     mechanics::messages::kFieldForOneObject,
     mechanics::messages::kFieldForOneObjectHelp},
    {{"strengthen", "primitive|of group|grown of group", "*"},
     mechanics::messages::kFieldForOneObject,
     mechanics::messages::kFieldForOneObjectHelp},
    {{"split", "shape|undeclared|of *|beams", "several that touch"},
     tools::messages::kPlacementsTouch,
     tools::messages::kPlacementsTouchHelp},
    {{"field", "shape|undeclared|of *|grown*|program*", "*"},
     kFieldCannotMove,
     kFieldCannotMoveHelp},
};

}  // namespace

std::span<const Refusal> refusals() {
    return kRefusals;
}

}  // namespace openfab::testing
