// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of prints as a whole: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for. Tests name
// rows, so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::pipeline::messages {

// check
OPENFAB_MESSAGE(kArgumentKind, "fablet `{}`: argument {} of kernel {} cannot have its kind, {}")
OPENFAB_MESSAGE(kKernelWithoutCode, "fablet `{}` has no code for kernel {}")
OPENFAB_MESSAGE(kOtherInterface, "fablet `{}` was compiled for version {} of the kernel interface; this is {}")
OPENFAB_MESSAGE(kSlotsUnbound, "object `{}`: {} of {} material slots are bound")
OPENFAB_MESSAGE(kNoMaterialCode, "object `{}` uses material code {}")
OPENFAB_MESSAGE(kNoSuchDither, "there is no dither `{}`; one of: {}")
OPENFAB_MESSAGE(kThreadsOutside, "--threads {} is not possible: 1 to 1024, or 0 for all cores")
OPENFAB_MESSAGE(kTooManyMaterials, "this print uses {} materials, and at most {} are possible: {}")
OPENFAB_MESSAGE(kNoSupportMaterial, "support has the material code {}, but there is no such material")
OPENFAB_MESSAGE(kVoxelOutside, "a voxel of {} x {} x {} mm is not possible")
OPENFAB_MESSAGE(kLowerDisplacement, "lower its `max_displacement_mm`, {:.3g}")
OPENFAB_MESSAGE(kBoundDisplacement, "bound it by the object's `max_displacement_mm`")
OPENFAB_MESSAGE(kPartSize, "`{}` (number {} of the build) is {:.3g} x {:.3g} x {:.3g} voxels")
OPENFAB_MESSAGE(kAndMoreParts, "; and {} more parts")
OPENFAB_MESSAGE(kPartVanishes, "; anything thinner than a voxel prints only where it contains the centre of one")
OPENFAB_MESSAGE(kPartLost, "nothing of `{}` (number {} of the build) is in the print: no voxel's centre lies in it; print finer, or thicken it")
OPENFAB_MESSAGE(kMorePartsLost, "nothing of {} more parts is in the print")
OPENFAB_MESSAGE(kEmptyShare, "{}{:.3g} % of `{}`")
OPENFAB_MESSAGE(kMoreEmpty, ", and of {} more objects")
OPENFAB_MESSAGE(kPartsEmpty, "without material, as all amounts are 0 there: {}; unless that is a lattice, `mc.Set(other, 1 - amount)` fills it")
OPENFAB_MESSAGE(kPartsEmptyNegative, "without material, as no amount is above 0 there, and negative ones and NaN count as 0: {}; `saturate(amount)` keeps one between 0 and 1, and `mc.Set(other, 1 - saturate(amount))` gives the rest to another material")
OPENFAB_MESSAGE(kMorePartsThin, "{} more parts are thinner than a voxel")
OPENFAB_MESSAGE(kPrintsSlowly, "`{}` (number {} of the build) may print many times as slowly as other parts of its size: its displaced surface crosses itself or is displaced farther than it is thick, so that about {:.0f} micropolygons may be nearest to any one point, and below {:.0f} are usual; unite the mesh's pieces, {}, or print coarser, as with `--draft 2`; `--estimate` tells how long it takes")
OPENFAB_MESSAGE(kMorePrintSlowly, "{} more parts print slowly")

// grid
OPENFAB_MESSAGE(kReachesFarthest, "object `{}` reaches farthest: it is {}")
OPENFAB_MESSAGE(kBeforeDisplacement, " before its displacement, and {} after; look at what its surface stage returns, or bound it by `max_displacement_mm`")
OPENFAB_MESSAGE(kNothingToPrint, "there is nothing to print: no part has a surface")
OPENFAB_MESSAGE(kBeginsTooFar, "the {} {:.6g} mm from the origin along {}; at most {:.0f} voxels of {} mm are possible")
OPENFAB_MESSAGE(kWindowBegins, "window begins")
OPENFAB_MESSAGE(kPartsBegin, "parts begin")
OPENFAB_MESSAGE(kSpansTooFar, "the {} {:.6g} mm along {}: {:.6g} voxels of {} mm; at most {:.0f} are possible; {}")
OPENFAB_MESSAGE(kWindowSpans, "window spans")
OPENFAB_MESSAGE(kPartsSpan, "parts span")
OPENFAB_MESSAGE(kSliceTooLarge, "a slice of {} x {} voxels is too large: at most {} voxels are possible; {}")
OPENFAB_MESSAGE(kMorePartsThanSlabs, "--part {}/{}: the print has {} slabs of 8 slices, and a part has one at least; ask for fewer parts")
OPENFAB_MESSAGE(kSlicesPastEnd, "--slices {}:{} reaches past the end of the print: slices to {} were printed")
OPENFAB_MESSAGE(kSlicesOutside, "--slices {}:{} is outside the print, which has slices 0:{}")
OPENFAB_MESSAGE(kNoSliceInRange, "--z {}mm:{}mm holds no slice: the print is {:.6g} mm high")

// memory_planner
OPENFAB_MESSAGE(kBudgetTooSmall, "a memory budget of {} is too small: {}; allow more, as `--memory 4GB`{}")
OPENFAB_MESSAGE(kSurfacesTake, "the displaced surfaces of this print take about {} to set up")
OPENFAB_MESSAGE(kSimplerMeshes, ", or print simpler meshes")
OPENFAB_MESSAGE(kPrintNeeds, "this print needs at least {} with {} thread{}")
OPENFAB_MESSAGE(kFewerThreads, ", or take fewer threads, as `--threads 1`")

// overlaps
OPENFAB_MESSAGE(kMorePairsOverlap, "{} more pairs of parts overlap")
OPENFAB_MESSAGE(kPartsOverlap, "`{}` (number {} of the build) and `{}` (number {}) overlap in {} voxels, {:.3g} ml, near ({:.4g}, {:.4g}, {:.4g}) mm; the later one gets them; a `priority` would decide")

// print_job
OPENFAB_MESSAGE(kInterruptedAfter, "interrupted after {} of {} slices; what was written is kept")

// print_setup
OPENFAB_MESSAGE(kInterruptedBefore, "interrupted before the first slice")
OPENFAB_MESSAGE(kPrintTakes, "the print takes {}, more than the {} that it takes by default; `--memory 4GB` sets a limit")
OPENFAB_MESSAGE(kPartBefore, "part `{}`: ")

// slab_trial
OPENFAB_MESSAGE(kTrialFailed, "slices from {}: a kernel failed with code {}: {}")

// slice_committer
OPENFAB_MESSAGE(kKernelFailed, "slices {} to {}: a kernel failed with code {}: {}")
OPENFAB_MESSAGE(kLinesNotShown, "{}:{}: {} more line{} not shown")
OPENFAB_MESSAGE(kSliceDiffers, "slice {} differs from the one already written: the program or an input has changed since; start over without `--resume`")

}  // namespace openfab::pipeline::messages
