// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of .ofr files: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for. Tests name rows,
// so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::ofr::messages {

// format
OPENFAB_MESSAGE(kTooShort, "not an .ofr file: too short for a header")
OPENFAB_MESSAGE(kNotOfr, "not an .ofr file")
OPENFAB_MESSAGE(kOtherVersion, "has version {} of the format; this program reads {} to {}")
OPENFAB_MESSAGE(kImpossibleLength, "the header is damaged: it gives an impossible length")
OPENFAB_MESSAGE(kCutShortInHeader, "is cut short in the header")
OPENFAB_MESSAGE(kHeaderChecksum, "the header is damaged: its checksum is wrong")
OPENFAB_MESSAGE(kBadGrid, "the header gives a grid of {} x {} x {} voxels")
OPENFAB_MESSAGE(kBadPitch, "the header gives no usable pitch and origin")
OPENFAB_MESSAGE(kBadBits, "the header gives {} bits a voxel; 4 and 8 are possible")
OPENFAB_MESSAGE(kBadSlices, "the header gives the slices {} to {} of a grid with {}")
OPENFAB_MESSAGE(kSlicesTooLarge, "the header gives slices of {} bytes; the limit is {}")
OPENFAB_MESSAGE(kBadMaterials, "the header gives {} materials in {} bits a voxel")
OPENFAB_MESSAGE(kHeaderFieldsDiffer, "the header's fields and its length do not agree")
OPENFAB_MESSAGE(kSliceHeaderDamaged, "its header is damaged")
OPENFAB_MESSAGE(kIndexTooShort, "the index is too short")
OPENFAB_MESSAGE(kIndexChecksum, "the index is damaged: its checksum is wrong")
OPENFAB_MESSAGE(kIndexFieldsDiffer, "the index's fields and its length do not agree")

// ofr_reader
OPENFAB_MESSAGE(kCannotOpen, "cannot open `{}`: {}")
OPENFAB_MESSAGE(kNoIndex, "has no index (an interrupted print?)")
OPENFAB_MESSAGE(kIndexDamaged, "the index is damaged")
OPENFAB_MESSAGE(kWholeSlices, "slice {}: {}; {} of {} slices are whole")
OPENFAB_MESSAGE(kTooMuchMemory, "{}: slices of {} x {} voxels take {} to read, and `--memory` allows {}; if you trust the file, allow more, as with `--memory 4GB`")
OPENFAB_MESSAGE(kSliceMissing, "is missing, the file ends before it (an interrupted print?)")
OPENFAB_MESSAGE(kSliceCutShort, "the file is cut short in it")
OPENFAB_MESSAGE(kOtherSlice, "slice {} is there instead")
OPENFAB_MESSAGE(kCodesBeyond, "it has codes beyond the {} materials of the header")
OPENFAB_MESSAGE(kAllWholeButIndex, "all {} slices are whole, but the index ")
OPENFAB_MESSAGE(kIndexMissing, "is missing (an interrupted print?)")
OPENFAB_MESSAGE(kDamaged, "is damaged")
OPENFAB_MESSAGE(kCutShortOrDamaged, "is cut short or damaged")
OPENFAB_MESSAGE(kCutShort, "is cut short")
OPENFAB_MESSAGE(kIndexListsOthers, "the index does not list the slices that the file has")
OPENFAB_MESSAGE(kIndexCountsOthers, "the index gives {} voxels of code {}, the slices have {}")
OPENFAB_MESSAGE(kIndexHashOther, "the index gives another hash than the slices have")
OPENFAB_MESSAGE(kBytesAfterEnd, "has bytes after its end")

// ofr_sink
OPENFAB_MESSAGE(kCannotReadUnchanged, "cannot read `{}`; nothing was changed")

// slice_codec
OPENFAB_MESSAGE(kDataDamaged, "its data are damaged")
OPENFAB_MESSAGE(kChecksumWrong, "its checksum is wrong")

}  // namespace openfab::ofr::messages
