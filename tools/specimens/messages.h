// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/message.h"

// clang-format off
namespace openfab::specimens::messages {

// Every text that the trays of test pieces and their measurements put into an error or a note.

// The list
OPENFAB_MESSAGE(kListEmpty, "{}: no specimens in it")
OPENFAB_MESSAGE(kColumnMissing, "no column `{}`; `openfab specimens make` writes it")
OPENFAB_MESSAGE(kCellNoNumber, "`{}` is a number, not `{}`")
OPENFAB_MESSAGE(kLabelNoNumber, "a label is a whole number from 1, not {}")
OPENFAB_MESSAGE(kLabelTwice, "label {} is there twice")
OPENFAB_MESSAGE(kSizeNotPositive, "a width of {} mm and a thickness of {} mm: both are larger than 0")
OPENFAB_MESSAGE(kPieceUnknown, "unknown test piece `{}`; {}")
OPENFAB_MESSAGE(kTwoPieces, "a list has one kind of test piece: `{}` stands beside `{}`")

// Trays
OPENFAB_MESSAGE(kPieceTooLarge, "a {} is {:.4g} x {:.4g} x {:.4g} mm with its label, the tray of `{}` {:.4g} x {:.4g} x {:.4g} mm")
OPENFAB_MESSAGE(kPieceTooLargeHelp, "choose a smaller piece, such as `--piece iso527-5b`, or another direction, such as `--along y`")

// Curves
OPENFAB_MESSAGE(kFolderUnreadable, "cannot read the folder {}: {}")
OPENFAB_MESSAGE(kTwoCurves, "specimen {} has two curves: {} and {}")
OPENFAB_MESSAGE(kNoCurves, "no curve of a specimen in {}")
OPENFAB_MESSAGE(kNoCurvesHelp, "name each file by the label of its specimen: 7.csv, or 007.txt")
OPENFAB_MESSAGE(kCurveEmpty, "{}: a curve has three rows of numbers at least, of a strain and a stress")
OPENFAB_MESSAGE(kNoHeader, "no header")
OPENFAB_MESSAGE(kColumnNotFound, "{}: no column of {} or {}: {}")
OPENFAB_MESSAGE(kColumnNotFoundHelp, "name it, or give its number: `{} 2`")
OPENFAB_MESSAGE(kColumnsAlike, "{}: `{}` and `{}` may both be the {}; choose with `{} NAME`")
OPENFAB_MESSAGE(kColumnUnknown, "{}: no column `{}`: {}")
OPENFAB_MESSAGE(kCurveUnit, "{}: `{}` is in `{}`, no unit of {}: {}")
OPENFAB_MESSAGE(kCurveCell, "no number in `{}` or in `{}`")
OPENFAB_MESSAGE(kCurveCellHelp, "remove rows that are no part of the curve")
OPENFAB_MESSAGE(kCurveFlat, "{}: the stress does not rise")
OPENFAB_MESSAGE(kTooFewInRange, "{}: {} points between strains of {} and {}, of {} up to a strain of {:.4g} at the greatest stress; a slope needs 3")
OPENFAB_MESSAGE(kTooFewInRangeHelp, "choose other strains, such as `--range 0.02:0.1` for a soft material")

// Tables
OPENFAB_MESSAGE(kNotOneNumber, "`{}` is `{}`, not a number")
OPENFAB_MESSAGE(kOneUniform, "no tables: they have one uniform, and {} were swept")
OPENFAB_MESSAGE(kTableRows, "no {}.json: {} kinds were measured, and a table has 2 to {}")
OPENFAB_MESSAGE(kTableMaterials, "no {}.json: {} materials, and a table has 2 to 4")
OPENFAB_MESSAGE(kTableNotMonotonic, "no {}.json: the {} neither rises nor falls throughout, so that it does not say which mixture has it")
OPENFAB_MESSAGE(kNotAlone, "no mechanics.json: `{}` was not measured alone")
OPENFAB_MESSAGE(kNoPoisson, "no mechanics.json: Poisson's ratio of `{0}` is not measured by such a test; give it, as `--nu {0}=0.4`")

}  // namespace openfab::specimens::messages
