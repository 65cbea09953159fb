// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of GrabCAD's packages: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for. Tests
// name rows, so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::gcvf::messages {

// coarse_mesh
OPENFAB_MESSAGE(kTooManyTriangles, "the coarse mesh of the print has more triangles than STL can hold")

// format
OPENFAB_MESSAGE(kNotResumed, "a package is closed after its last slice, so nothing is left of one that was cut short; print an .ofr file, and make a gcvf of it with `openfab export`")

// gcvf_sink
OPENFAB_MESSAGE(kTooManyMaterials, "the print has {} materials and a gcvf holds at most {}; leave some out of the world, or write another format")
OPENFAB_MESSAGE(kSameKeys, "two materials have the same key colour, and a gcvf tells materials apart by their colours; give each its own `key` in the world")
OPENFAB_MESSAGE(kTooManySlices, "the print has {} slices and a gcvf holds at most {}; print it in parts, the first with `--slices 0:{}`")
OPENFAB_MESSAGE(kEndedEarly, "the print ended early; a gcvf of some of its slices could not be told from a whole one, so none was written")

}  // namespace openfab::gcvf::messages
