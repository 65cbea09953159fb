// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of bleed: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is
// for. Tests name rows, so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::process::messages {

OPENFAB_MESSAGE(kSigmaNegative, "`sigma_um` has {:.6g}")
OPENFAB_MESSAGE(kSigmaNegativeHelp, "it cannot be negative")
OPENFAB_MESSAGE(kPairWithoutTwoNames, "`materials` of a pair is not an array of two names")
OPENFAB_MESSAGE(kPairWithoutTwoNamesHelp, "write, say, [\"white\", \"black\"]")
OPENFAB_MESSAGE(kBleedsIntoItself, "`{}` does not bleed into itself")
OPENFAB_MESSAGE(kBleedsIntoItselfHelp, "name two materials")
OPENFAB_MESSAGE(kPairsNoArray, "`pairs` is {}")
OPENFAB_MESSAGE(kPairsNoArrayHelp, "it must be an array of at most {} objects with `materials` and `sigma_um`")
OPENFAB_MESSAGE(kBleedTwice, "bleed of `{}` and `{}` is given twice; the later one counts")
OPENFAB_MESSAGE(kBleedIdle, "bleed of `{}` changes nothing: no material of this print has that name or channel; {}")
OPENFAB_MESSAGE(kBleedOfSupport, "bleed of `{}` and `{}` changes nothing: support is added after the mixtures")
OPENFAB_MESSAGE(kBleedNotKnown, "`--bleed {}`: neither the printer's profile nor `--process` has `bleed`")
OPENFAB_MESSAGE(kBleedTooFar, "`bleed` reaches {} voxels along {}, over all of its steps; at most {} are possible; take fewer `steps`, or a coarser pitch")
OPENFAB_MESSAGE(kBleedWithoutMixtures, "fablet `{}` has a dither rule of its own, which leaves no mixtures for the process's `bleed`; print with `--dither blue_noise`, or with `--bleed off`")

}  // namespace openfab::process::messages
