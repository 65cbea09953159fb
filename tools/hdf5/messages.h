// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of data sets of HDF5: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for. Tests name
// rows, so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::tools::messages {

// data_set
OPENFAB_MESSAGE(kNotHdf5, "its data file is not an HDF5 file, or is damaged")
OPENFAB_MESSAGE(kNoDataSetOfName, "there is no data set `{}` in its data file")
OPENFAB_MESSAGE(kNumbersElsewhere, "the data set `{}` has its numbers in other files")
OPENFAB_MESSAGE(kNumbersElsewhereHelp, "write it with its numbers in its own file")
OPENFAB_MESSAGE(kDataSetWithoutNumbers, "the data set `{}` does not hold numbers")
OPENFAB_MESSAGE(kDataSetSides, "the data set `{}` has the sides {}, not {} as its `Dimensions` state")
OPENFAB_MESSAGE(kDataSetSidesHelp, "state them in the order in which the data set has them, z, y, x")
OPENFAB_MESSAGE(kDataSetCount, "the data set `{}` does not have the {} numbers of its `Dimensions`")
OPENFAB_MESSAGE(kDataSetDamaged, "a data set of its HDF5 file is damaged, or compressed with an unknown filter")
OPENFAB_MESSAGE(kFilterNotRead, "the data set `{}` is compressed by {} (filter {}), which is not read")
OPENFAB_MESSAGE(kFilterNotReadHelp, "write it with gzip, or not compressed")
OPENFAB_MESSAGE(kChunksNotWritten, "{} of {} chunks of the data set `{}` were never written, and it has no fill value; write all of it")
OPENFAB_MESSAGE(kChunksAreFill, "{} of {} chunks of the data set `{}` were never written: they have its fill value")

// vtk_hdf
OPENFAB_MESSAGE(kVtkHdfKind, "it is VTKHDF of the type `{}`; of VTKHDF, ImageData is read")
OPENFAB_MESSAGE(kVtkHdfKindHelp, "write it as .vti, .vtu, .vtr or .vts")
OPENFAB_MESSAGE(kVtkHdfSurfaceHelp, "it is a surface, which has no values inside: print it as a mesh, written as .stl, .obj or .ply")
OPENFAB_MESSAGE(kVtkHdfSteps, "it holds {} steps in time; a volume is of one")
OPENFAB_MESSAGE(kVtkHdfStepsHelp, "write one of them to a file of its own")
OPENFAB_MESSAGE(kVtkHdfPlace, "its WholeExtent, Origin, Spacing or Direction is damaged")
OPENFAB_MESSAGE(kVtkHdfSides, "the data set `{}` has the sides {}; those of the image are {}")

}  // namespace openfab::tools::messages
