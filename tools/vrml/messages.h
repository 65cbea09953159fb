// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of VRML files: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for. Tests name rows,
// so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::tools::messages {

// scene
OPENFAB_MESSAGE(kNotVrml, "it is not a VRML file, or damaged")
OPENFAB_MESSAGE(kNotVrmlHelp, "VRML files begin with `#VRML V2.0 utf8`")
OPENFAB_MESSAGE(kCannotRead, "it cannot be read: {}")
OPENFAB_MESSAGE(kNoFaces, "it has no faces")
OPENFAB_MESSAGE(kMoreThanTriangles, "it has more than {} triangles")
OPENFAB_MESSAGE(kLinesLeftOut, "{}: {} lines and points have no volume and are left out")
OPENFAB_MESSAGE(kTextsLeftOut, "{}: {} texts are flat and are left out; make solids of them in the program that made the file")
OPENFAB_MESSAGE(kNoSuchColour, "the colours of a shape are fewer than its faces or vertices refer to; export it again")
OPENFAB_MESSAGE(kOtherFilesLeftOut, "{}: {} parts in other files are left out; export the scene as one file")
OPENFAB_MESSAGE(kPixelsLeftOut, "{}: {} pictures that are written in the file itself, or are films, are left out; export pictures as files")
OPENFAB_MESSAGE(kPictureElsewhere, "{}: its picture `{}` is not a file in its folder or below, and is left out")

// wavefront
OPENFAB_MESSAGE(kCannotCopy, "cannot copy `{}` to `{}`: {}")

}  // namespace openfab::tools::messages
