// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What readers of prints say: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for. Tests name
// rows, so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::prints::messages {

// folder_print
OPENFAB_MESSAGE(kNoFolderOfSlices, "no folder of slices: ")
OPENFAB_MESSAGE(kManifestOfOther, "its manifest.json is not that of a folder of slices")
OPENFAB_MESSAGE(kMaterialsOfOneColour, "two of its materials have one colour in the slices")
OPENFAB_MESSAGE(kSlicesOfFractions, "its slices are pictures of the fractions of one material, which say nothing of the others; print in another format")
OPENFAB_MESSAGE(kSliceNotThere, "slice {} is not there")
OPENFAB_MESSAGE(kCannotOpen, "cannot open `{}`: ")
OPENFAB_MESSAGE(kCannotRead, "cannot read `{}`: ")
OPENFAB_MESSAGE(kSliceDamaged, "slice {}: it is damaged, or was not written by OpenFab")

// gcvf_print
OPENFAB_MESSAGE(kNoGcvf, "it is not a GCVF: its `ConfigFile.xml` {}")
OPENFAB_MESSAGE(kConfigMissing, "is missing")
OPENFAB_MESSAGE(kConfigLacks, "has no `{}` that is possible")
OPENFAB_MESSAGE(kNotOfMaterials, "its slices are of `{}`, and only those of `Materials` are read here")
OPENFAB_MESSAGE(kColourOfNoMaterial, "slice {}: its colour {} {} {} {} at pixel {}, {} is of none of the materials in `ConfigFile.xml`")
OPENFAB_MESSAGE(kSliceIsNoPicture, "slice {}: {}")

// ofr_print
OPENFAB_MESSAGE(kOfSlice, "slice {}: {}")
OPENFAB_MESSAGE(kCannotBeRead, "it cannot be read")

// png_pixels
OPENFAB_MESSAGE(kNoPng, "it is no PNG, or damaged")
OPENFAB_MESSAGE(kPictureOfOtherSize, "it has {} x {} pixels, and slices have {} x {}")
OPENFAB_MESSAGE(kPngOfSixteenBits, "it has 16 bits a channel, and slices of materials have at most 8")

// print_file
OPENFAB_MESSAGE(kSlicesTakeEach, "{}: slices of {} x {} voxels take {} each, and `--memory` allows {} for four; raise it if you trust the file")

}  // namespace openfab::prints::messages
