// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of displaced surfaces: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for. Tests
// name rows, so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::surface::messages {

// kernel_args
OPENFAB_MESSAGE(kArraysDoNotFit, "part `{}`: the mesh's arrays do not fit fablet `{}`")
OPENFAB_MESSAGE(kKernelMissing, "fablet `{}` has a surface stage but lacks a kernel of it")
OPENFAB_MESSAGE(kNoUv, "part `{}`: the surface stage of fablet `{}` reads the attribute `uv`, which the mesh lacks")
OPENFAB_MESSAGE(kFrameValue, "the surface stage of fablet `{}` reads frame value {}, which depends on the grid")
OPENFAB_MESSAGE(kArgumentOfOther, "the surface stage of fablet `{}` reads argument kind {}, which belongs to another stage")

// patch_table
OPENFAB_MESSAGE(kEdgeTooLong, "part `{}`: an edge of triangle {} is {:.6g} mm long and would be diced into more than {} pieces of {:.6g} mm; split the mesh's edges below {:.6g} mm or print at a coarser pitch")
OPENFAB_MESSAGE(kUnbounded, "part `{}`: nothing bounds the displacement that the surface stage of fablet `{}` gives triangle {}; set the object's `max_displacement_mm`")
OPENFAB_MESSAGE(kBoundsFailed, "surface_bounds of fablet `{}` failed with code {}")

// surface
OPENFAB_MESSAGE(kKernelFailed, "the surface kernel of fablet `{}` failed with code {}")
OPENFAB_MESSAGE(kNotFinite, "part `{}`: some displacements are not numbers, or are infinite; the surface stays where it is there")
OPENFAB_MESSAGE(kCutToBound, "part `{}`: some displacements are longer than its `max_displacement_mm`, {:.6g}, and are cut to it")

}  // namespace openfab::surface::messages
