// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of output files and of prints that go on: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what
// it is for. Tests name rows, so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::backends::messages {

// what several of the sinks say
OPENFAB_MESSAGE(kSliceNotCompressed, "slice {} could not be compressed")
OPENFAB_MESSAGE(kInterruptedReading, "interrupted while `{}` was read; nothing was changed")
OPENFAB_MESSAGE(kWholeSlicesBefore, "{}; {} whole slices were written before")
OPENFAB_MESSAGE(kRestTakes, ", the rest takes about {}")
OPENFAB_MESSAGE(kOutOfMemory, "out of memory")

// deflate_spool
OPENFAB_MESSAGE(kSpoolFailed, "cannot {} a temporary file in `{}`: {}")
OPENFAB_MESSAGE(kSpoolWriteTo, "write to")

// output_file
OPENFAB_MESSAGE(kCannotWriteTo, "cannot write to")
OPENFAB_MESSAGE(kStandardOutput, "standard output")
OPENFAB_MESSAGE(kResumeNeedsFile, "`--resume` needs a file to continue; {} keeps nothing of an earlier print")
OPENFAB_MESSAGE(kOutputIsFolder, "`{}` is a folder; the output is a file")
OPENFAB_MESSAGE(kPipeUnread, "`{}` is a pipe that nobody reads")
OPENFAB_MESSAGE(kCannotCreate, "cannot create")

// output_folder
OPENFAB_MESSAGE(kCannotOpenFolder, "cannot open the folder")
OPENFAB_MESSAGE(kCannotRead, "cannot read")
OPENFAB_MESSAGE(kCannotRename, "cannot rename")
OPENFAB_MESSAGE(kCannotRemove, "cannot remove")

// output_lock
OPENFAB_MESSAGE(kAnotherProcess, "another process")
OPENFAB_MESSAGE(kProcessNumber, "process {}")
OPENFAB_MESSAGE(kProcessNamed, "process {} (`{}`)")
OPENFAB_MESSAGE(kBeingWritten, "`{}` is being written by {}; wait until it is done, or name another output")

// package
OPENFAB_MESSAGE(kPackageFailed, "{} a package failed with code {}")
OPENFAB_MESSAGE(kAddingTo, "adding to")
OPENFAB_MESSAGE(kWritingTo, "writing to")

// part_file
OPENFAB_MESSAGE(kCannotCreatePart, "cannot create `{}`: {}")

// resume_check
OPENFAB_MESSAGE(kNotTheSame, "the {} are not the same")
OPENFAB_MESSAGE(kIsOther, "the {} is `{}` there and `{}` here")
OPENFAB_MESSAGE(kNumberOfMaterials, "number of materials")
OPENFAB_MESSAGE(kMaterialNumber, "material {}")
OPENFAB_MESSAGE(kNoProvenance, "it does not record what it was made from (an earlier version of this program wrote it)")
OPENFAB_MESSAGE(kOtherSettings, "it records different settings than this program does")
OPENFAB_MESSAGE(kPitchInMm, "pitch in mm")
OPENFAB_MESSAGE(kSizeInVoxels, "size in voxels")
OPENFAB_MESSAGE(kOriginInMm, "origin in mm")
OPENFAB_MESSAGE(kRangeOfSlices, "range of slices")
OPENFAB_MESSAGE(kOtherBits, "it has a different number of bits per voxel")
OPENFAB_MESSAGE(kResumeRefused, "cannot resume `{}`: {}; use the same world and options as the first run, or start over without `--resume`")

}  // namespace openfab::backends::messages
