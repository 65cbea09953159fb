// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What profiles and searches of schedules say: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for.
// Tests name rows, so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::tuner::messages {

// candidates
OPENFAB_MESSAGE(kScheduleOfFile, "the schedule that was in this file")

// journal
OPENFAB_MESSAGE(kNoJournalOfThis, "{}: it is not a journal of this world, printed like this, on this machine")
OPENFAB_MESSAGE(kNoJournalOfThisHelp, "remove it, or name another with `--journal FILE`")
OPENFAB_MESSAGE(kCannotBeWritten, "{}: cannot be written: {}")

// main
OPENFAB_MESSAGE(kWriteATime, "`{} {}`: write a time from {} to {}")

// stand
OPENFAB_MESSAGE(kVoxelsDiffer, "its voxels differ from those of the first schedule")

// tune
OPENFAB_MESSAGE(kSchedulesKnown, "{} schedules are known from {}\n")
OPENFAB_MESSAGE(kNoSlabKernel, "no fablet of this world has a slab kernel: their volume stages are cut into segments")
OPENFAB_MESSAGE(kNoSlabKernelHelp, "`openfab profile` shows where the print spends its time")
OPENFAB_MESSAGE(kHasSchedule, "{} has a schedule, which is compared with what is found\n")
OPENFAB_MESSAGE(kOfFirstsTime, "{:>7} {:.3f} of the first's time: {}\n")
OPENFAB_MESSAGE(kTrialRefused, "{:>7} refused: {}: {}\n")
OPENFAB_MESSAGE(kScheduleFails, "a schedule fails, which is a bug of OpenFab: {}")
OPENFAB_MESSAGE(kChangesToTry, "{} slabs of {}, {} changes to try\n")
OPENFAB_MESSAGE(kCompared, "compared: {}: {}\n")
OPENFAB_MESSAGE(kNoneFaster, "no schedule is faster than the first one beyond noise\n")
OPENFAB_MESSAGE(kVerdictIs, "{:.3f}, with 99 % confidence below {:.3f}, {:.3f} to {:.3f} by place")
OPENFAB_MESSAGE(kInterruptedBest, "interrupted; `{}` has the schedule that won before, or the first, and the journal what was measured")
OPENFAB_MESSAGE(kInterruptedBestHelp, "the same command continues from the journal")
OPENFAB_MESSAGE(kNoOutput, "no output given; write `-o FILE.sched` with the name of the schedule to make")
OPENFAB_MESSAGE(kNameEnds, "`-o {}`: name a file that ends in .sched")

// workload
OPENFAB_MESSAGE(kKeepsNoSlices, "`{}` keeps no slices and takes no `{}`; `openfab print` does")
OPENFAB_MESSAGE(kNotAWorld, "`{}` is not a world (.fab.json); make one of a mesh with `openfab import`")
OPENFAB_MESSAGE(kInFolder, "the folder `{}`: ")
OPENFAB_MESSAGE(kKernelNotKept, "no kernel is kept for the next run: {}")

}  // namespace openfab::tuner::messages
