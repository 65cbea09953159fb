// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of slices and arrays: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for. Tests name
// rows, so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::raster::messages {

// folder_sink
OPENFAB_MESSAGE(kCannotRead, "cannot read `{}`")
OPENFAB_MESSAGE(kNotAFile, "`{}` {}, and a file of the print belongs there; remove it, and `--resume` makes the file again")
OPENFAB_MESSAGE(kIsAFolder, "is a folder")
OPENFAB_MESSAGE(kIsNoFile, "is a pipe, a socket or a device")
OPENFAB_MESSAGE(kOutputIsFile, "`{}` is a file; the output is a folder of slices")
OPENFAB_MESSAGE(kCannotCreateFolder, "cannot create the folder `{}`: {}")
OPENFAB_MESSAGE(kNotOfPrint, "`{}` holds `{}`, which is not part of a print; give an empty folder, or one with an earlier print")
OPENFAB_MESSAGE(kCannotReadFolder, "cannot read the folder `{}`: {}")
OPENFAB_MESSAGE(kNoGreyMaterial, "`--grey-material {}`: no material of the print; {}")
OPENFAB_MESSAGE(kSlicesWithoutManifest, "it has slices and no {}")
OPENFAB_MESSAGE(kHashOfOther, "`{}`: its slices have the hash {}, and its manifest says {}, so they are not what was printed; print again with `--resume`, which now makes all of them again")
OPENFAB_MESSAGE(kMaterialsAlike, "two of its materials look the same in the slices")

// formats
OPENFAB_MESSAGE(kArrayNotResumed, "an array does not keep what it was made of; print an .ofr file, and make an array of it with `openfab export`")

// grey_stack
OPENFAB_MESSAGE(kNoGreyPartMaterial, "`--grey-material {}`: no material of the print's parts; {}")

// manifest
OPENFAB_MESSAGE(kManifestLacks, "its manifest does not give `{}`")
OPENFAB_MESSAGE(kManifestDamaged, "its manifest.json is damaged")

}  // namespace openfab::raster::messages
