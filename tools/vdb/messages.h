// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of OpenVDB, written and read: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for.
// Tests name rows, so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::tools::messages {

// convert
OPENFAB_MESSAGE(kNotAnArrayOfOpenFab, "`{}` does not describe an array of OpenFab")
OPENFAB_MESSAGE(kArrayOfEndedPrint, "is of a print that ended early; print it again")
OPENFAB_MESSAGE(kCannotReadArray, "cannot read `{}`: ")
OPENFAB_MESSAGE(kNotTheDescribedArray, "is not the array that `{}` describes")
OPENFAB_MESSAGE(kArrayFileCutShort, "`{}` is cut short")
OPENFAB_MESSAGE(kEightSlicesTooLarge, "{}: eight slices of {} x {} voxels take more than `--memory` allows, {}; allow more, as with `--memory 4GB`")
OPENFAB_MESSAGE(kRowsTooLarge, "{}: rows of {} voxels take more than `--memory` allows, {}")

// sparse_grids
OPENFAB_MESSAGE(kGridsTooLarge, "the voxels that are not void up to slice {} take more than the {} that `--memory` leaves for them; allow more, as `--memory 4GB`, or print fewer slices, as `--slices 0:200`, or at a coarser pitch")
OPENFAB_MESSAGE(kCannotWriteTo, "cannot write to `{}`: {}")
OPENFAB_MESSAGE(kDiskFailed, "the disk failed")

// vdb_volume
OPENFAB_MESSAGE(kGridEmpty, "its grid `{}` is empty")
OPENFAB_MESSAGE(kGridTooLarge, "its grid `{}` has {} voxels along {}, and at most {} are possible")
OPENFAB_MESSAGE(kNoGrid, "it has no grid")
OPENFAB_MESSAGE(kSeveralGrids, "it has several grids, ")
OPENFAB_MESSAGE(kSeveralGridsHelp, ", and `field` names none")
OPENFAB_MESSAGE(kNoSuchGrid, "it has no grid `{}`; it has {}")
OPENFAB_MESSAGE(kGridNotLinear, "its grid `{}` is not placed by a linear transform")
OPENFAB_MESSAGE(kGridStaggered, "its grid `{}` is staggered: its components lie on the faces of voxels")
OPENFAB_MESSAGE(kGridStaggeredHelp, "write it with values at the centres of voxels")
OPENFAB_MESSAGE(kGridTypeNotRead, "its grid `{}` is of type {}, which is not read")

}  // namespace openfab::tools::messages
