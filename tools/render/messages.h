// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What renderings say: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for. Tests name rows, so
// wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::render::messages {

// film
OPENFAB_MESSAGE(kNoMemoryForPicture, "no memory for the picture's file")

// main
OPENFAB_MESSAGE(kNoSize, "`--size`: `{}` is not a size; write `800x600`, of at most {} pixels a side")
OPENFAB_MESSAGE(kWritePngOrPfm, "`-o`: write a .png file, or .pfm for linear light, not `{}`")
OPENFAB_MESSAGE(kInTime, "`--time`: {}")

// optics
OPENFAB_MESSAGE(kFileMustHoldObject, "the file must hold an object")
OPENFAB_MESSAGE(kNotOptics, "this is not a file of optical properties")
OPENFAB_MESSAGE(kNotOpticsHelp, "it begins with `\"openfab_optics\": 1`")
OPENFAB_MESSAGE(kUnknownKey, "unknown key `{}`")
OPENFAB_MESSAGE(kKnownKeys, "keys here are {}")
OPENFAB_MESSAGE(kNumberBetween, "{} is a number from {} to {}")
OPENFAB_MESSAGE(kKeyMissing, "`{}` is missing")
OPENFAB_MESSAGE(kNumberOrThree, "`{}` is a number or three: red, green, blue")
OPENFAB_MESSAGE(kSurfaceIsObject, "`surface` is an object")
OPENFAB_MESSAGE(kMaterialsIsObject, "`materials` is an object")
OPENFAB_MESSAGE(kIsAnObject, "`{}` is an object")
OPENFAB_MESSAGE(kAlsoIsAList, "`also` is a list of names")

// read_print
OPENFAB_MESSAGE(kSliceHasMaterial, "{}: slice {} has the material {}, but the print has only {}")
OPENFAB_MESSAGE(kNothingPrinted, "{}: nothing is printed there")
OPENFAB_MESSAGE(kPictureBeyondMemory, "{}: a picture of it does not fit `--memory`, {}")

// render
OPENFAB_MESSAGE(kOptionOfWorlds, "`{}` is of worlds, and the voxels of `{}` are there already: leave it out")
OPENFAB_MESSAGE(kPrintingWorld, "printing the world ...\n")
OPENFAB_MESSAGE(kVoxelsTakenTogether, "the print does not fit `--memory` at its own pitch; its voxels are taken {} x {} x {} together, {:.3g} x {:.3g} x {:.3g} mm")
OPENFAB_MESSAGE(kPrintNotComplete, "the print is not complete: {} of {} slices are there")
OPENFAB_MESSAGE(kLightGuessed, "nothing is known of how light passes through {}: it is guessed from the preview colours; `--optics FILE.json` can give it")
OPENFAB_MESSAGE(kNothingTraced, "nothing was traced yet; no picture")
OPENFAB_MESSAGE(kInterruptedPicture, "interrupted; `{}` is what was traced until then")
OPENFAB_MESSAGE(kPictureTakes, "a picture of {} x {} takes {}, and `--memory` allows {} for all")

// scene
OPENFAB_MESSAGE(kNoLight, "`--light`: there is no light `{}`; choose from studio, behind, dome, or TURN:TILT, degrees from the camera's right to its left and above it")
OPENFAB_MESSAGE(kNoView, "`--view`: there is no view `{}`; choose from top, bottom, front, right, back, left, model:TURN:TILT with a turn of -360 to 360 and a tilt of 5 to 90 degrees")
OPENFAB_MESSAGE(kNoColour, "`--backdrop`: `{}` is not a colour; write `#c8c8c8`, or `none` for darkness")

}  // namespace openfab::render::messages
