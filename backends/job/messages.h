// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of a print's record and its story: OPENFAB_MESSAGE(name, "text"), by file. Tests name rows, so wording is
// changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::job::messages {

// story
OPENFAB_MESSAGE(kNoRecord, "`{}` is not the record of a print")
OPENFAB_MESSAGE(kEventsBefore, "{} events before")
OPENFAB_MESSAGE(kStarted, "started {}, process {} on {}")
OPENFAB_MESSAGE(kResumed, "resumed {}, process {} on {}")
OPENFAB_MESSAGE(kAfterSlices, ", after {} slices")
OPENFAB_MESSAGE(kFrom, ", from {}")
OPENFAB_MESSAGE(kChangedSince, "; changed since: {}")
OPENFAB_MESSAGE(kChangedMeanwhile, "; changed while it ran: {}")
OPENFAB_MESSAGE(kStopped, "stopped {}")
OPENFAB_MESSAGE(kBySignal, " by {}")
OPENFAB_MESSAGE(kFromProcess, " from process {}")
OPENFAB_MESSAGE(kByError, " by an error")
OPENFAB_MESSAGE(kByLimit, " by a limit")
OPENFAB_MESSAGE(kWithItsLine, " with its line")
OPENFAB_MESSAGE(kBeforeSlice, ", before slice {}")
OPENFAB_MESSAGE(kComplete, "complete {}, hash {}")
OPENFAB_MESSAGE(kRuns, "it runs")
OPENFAB_MESSAGE(kNobodyWrites, "interrupted: no process writes it any more")

}  // namespace openfab::job::messages
