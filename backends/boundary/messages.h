// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of meshes of prints: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for. Tests name
// rows, so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::boundary::messages {

// formats
OPENFAB_MESSAGE(kMeshNotResumed, "a mesh is closed by its last slice, so nothing is left of one that was cut short; print an .ofr file, and make meshes of it with `openfab export`")

OPENFAB_MESSAGE(kBelowBed, "the lowest slice is at z = {:g} mm, as the world has it, and an STL has nothing that puts it on the bed: some slicers leave out what is below 0; move it there, or write `--format 3mf`, which is placed")

// mesh_sink
OPENFAB_MESSAGE(kVoxelsTooFine, "voxels of {:.3g} um are too fine for the coordinates of a mesh that lies {:.4g} mm from the origin; use `--mesh-pitch {:.3g}um` or more, or move it closer")
OPENFAB_MESSAGE(kEndedEarly, "the print ended early; a mesh of some of its slices would be cut open, so none was written")

// mixed_sink
OPENFAB_MESSAGE(kTooManyMixtures, "slicers number at most {} filaments, and the print has {} and more mixtures of them, in quarters, than are left")
OPENFAB_MESSAGE(kTooManyMixturesHelp, "use fewer, or `--format filament` with `--dither own` and `dither_layers`, which mixes layers of voxels")
OPENFAB_MESSAGE(kNoMixtures, "a finished print has one material in each voxel, and `filament-mixed` is of mixtures")
OPENFAB_MESSAGE(kNoMixturesHelp, "print the world with `--format filament-mixed`, or write `--format filament`")

// stl_writer
OPENFAB_MESSAGE(kOutputIsFolder, "`{}` is a folder; name the files, as in `-o {}`")
OPENFAB_MESSAGE(kTooManyTriangles, "`{}` would have more than {} triangles, which STL cannot hold; use a coarser pitch, as `--mesh-pitch 0.4mm`")
OPENFAB_MESSAGE(kNothingPrinted, "nothing was printed: the print holds no material, so there is no mesh to write")

// threemf_writer
OPENFAB_MESSAGE(kTooManyFilaments, "the print has {} materials, but slicers number at most {} filaments; write `--format 3mf`, a mesh for each material")
OPENFAB_MESSAGE(kMeshTooLarge, "the mesh of `{}` is larger than 3MF can hold; use a coarser pitch, as `--mesh-pitch 0.4mm`")

}  // namespace openfab::boundary::messages
