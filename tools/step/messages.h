// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of STEP files: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for. Tests name rows,
// so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::tools::messages {

// main
OPENFAB_MESSAGE(kToleranceAboveZero, "`--tolerance` must be above 0")

// step_solids
OPENFAB_MESSAGE(kNotStep, "it is not a STEP file, or damaged")
OPENFAB_MESSAGE(kNotStepHelp, "STEP files begin with ISO-10303-21")
OPENFAB_MESSAGE(kShapesCannotBeRead, "its shapes cannot be read")
OPENFAB_MESSAGE(kOnlySurfaces, "it has no solids, only surfaces or curves")
OPENFAB_MESSAGE(kNoSolids, "it has no solids")
OPENFAB_MESSAGE(kNoSolidsHelp, "export closed solids from the program that made it")
OPENFAB_MESSAGE(kShapesLeftOut, "{}: {} shapes that are no solids are left out: close them in the program that made them")
OPENFAB_MESSAGE(kAssembliesTooDeep, "assemblies are nested too deep")
OPENFAB_MESSAGE(kMoreThanSolids, "it has more than {} solids")
OPENFAB_MESSAGE(kFaceNotDivided, "a face of the solid `{}` cannot be divided into triangles")
OPENFAB_MESSAGE(kFaceNotDividedHelp, "heal the solid in the program that made it")
OPENFAB_MESSAGE(kOpenCascadeCannotRead, "{}: OpenCASCADE cannot read it: {}")

}  // namespace openfab::tools::messages
