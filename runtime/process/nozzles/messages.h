// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of dead nozzles: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is
// for. Tests name rows, so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::process::messages {

OPENFAB_MESSAGE(kSubstitutesInCircle, "dead nozzles: in row {} neither `{}` nor any of its substitutes can be printed, since they stand in for each other; name another substitute")
OPENFAB_MESSAGE(kNozzlesNoArray, "`nozzles` is {}")
OPENFAB_MESSAGE(kNozzlesNoArrayHelp, "it must be an array of numbers, from 0, and ranges such as [12, 20]")
OPENFAB_MESSAGE(kRangeWithoutTwoNumbers, "a range in `nozzles` does not have two numbers")
OPENFAB_MESSAGE(kRangeWithoutTwoNumbersHelp, "write the first and the last, such as [12, 20]")
OPENFAB_MESSAGE(kRangeEndsBeforeBegin, "a range in `nozzles` ends before it begins")
OPENFAB_MESSAGE(kRangeEndsBeforeBeginHelp, "swap its numbers")
OPENFAB_MESSAGE(kStandsInForItself, "`{}` cannot stand in for itself")
OPENFAB_MESSAGE(kStandsInForItselfHelp, "name another material")
OPENFAB_MESSAGE(kNoSuchNozzle, "there is no nozzle {} in a head of {}")
OPENFAB_MESSAGE(kNoSuchNozzleHelp, "they are numbered from 0")
OPENFAB_MESSAGE(kDeadNoArray, "`dead` is {}")
OPENFAB_MESSAGE(kDeadNoArrayHelp, "it must be an array of objects with `material`, `nozzles` and `substitute`")
OPENFAB_MESSAGE(kTooManyDead, "`dead` has {} entries")
OPENFAB_MESSAGE(kTooManyDeadHelp, "at most {} are allowed")
OPENFAB_MESSAGE(kSubstituteIs, "dead nozzles of `{}`: the substitute `{}` is {}")
OPENFAB_MESSAGE(kNoMaterialOfPrint, "no material of this print")
OPENFAB_MESSAGE(kSubstituteIsSupport, "support, which mixtures cannot hold; name a material")
OPENFAB_MESSAGE(kDeadNozzlesTwice, "dead nozzles: `{}` and `{}` are one material")
OPENFAB_MESSAGE(kNozzlesStay, "the nozzles stay as they are from slice {} on: {}")
OPENFAB_MESSAGE(kDeadNozzlesIdle, "dead nozzles of `{}` change nothing: no material of this print has that name or channel; {}")
OPENFAB_MESSAGE(kDeadNozzlesBeyond, "dead nozzle {} of `{}` changes nothing: the tray of printer `{}` has {} rows of voxels, {} of a pass; rows count from 0, and `head` says where they begin anew")

}  // namespace openfab::process::messages
