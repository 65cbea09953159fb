// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What prints say: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for. Help of options stands with them
// in parse_options.cpp. Tests name rows, so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::program::messages {

// altered_world
OPENFAB_MESSAGE(kFieldOfNoTexture, "`--field {}`: write NAME=FILE, with the name of a texture of the world")
OPENFAB_MESSAGE(kNoSuchOnlyObject, "`--only-object`: there is no object `{}`; {}")

// build_volume
OPENFAB_MESSAGE(kRoomOfPrinter, "`{}` builds {:.5g} x {:.5g} x {:.5g} mm")
OPENFAB_MESSAGE(kPrintTooLarge, "the print is {:.5g} mm along {}, {:.4g} mm too much: {}; place it closer together, or choose another printer, as `--printer j850` (`openfab printers` lists them)")
OPENFAB_MESSAGE(kBoxOutsideTray, "the `box_mm` of `{}` (number {} of the build), in which it may be made, reaches {:.4g} mm outside the tray along {}{}: {}, from {:.5g} to {:.5g} mm there; make the box smaller, move it, or leave `tray` out of the world")
OPENFAB_MESSAGE(kPartOutsideTray, "`{}` (number {} of the build) is {:.4g} mm outside the tray along {}{}: {}, from {:.5g} to {:.5g} mm there; move it, or leave `tray` out of the world")

// estimate
OPENFAB_MESSAGE(kMoreThan, "more than ")
OPENFAB_MESSAGE(kRoughly, "roughly {}, from {:.2g} % of 8 slices")
OPENFAB_MESSAGE(kKeepsUp, ", which this machine keeps up with: it takes up to {} for a slice, the printer {}")
OPENFAB_MESSAGE(kDoesNotKeepUp, ", which this machine does not keep up with: it takes up to {} for a slice, the printer {}")
OPENFAB_MESSAGE(kMoreOfWaste, ", {:.3g} ml more of waste")
OPENFAB_MESSAGE(kPriceOfMaterial, ", {:.2f} {}")
OPENFAB_MESSAGE(kPriceNotKnown, ", its price is not known")
OPENFAB_MESSAGE(kCost, "cost: about {:.2f} {}{}; {} passes{}\n")
OPENFAB_MESSAGE(kEstimateVoxels, "{} x {} x {} voxels, {:.1f} million; {:.3f} x {:.3f} x {:.3f} mm\n")
OPENFAB_MESSAGE(kEstimateMemory, "memory {}, time {}\n")
OPENFAB_MESSAGE(kPrinterTimeUnknown, "{} slices; how long `{}` takes for them is not known: {}\n")
OPENFAB_MESSAGE(kEstimateSlices, "{} slices, {} on `{}`{}\n")
OPENFAB_MESSAGE(kNotWritten, "`{0}` prints nothing, so `{1}` is not written; without `{0}` it is")
OPENFAB_MESSAGE(kMaterialsNotKnown, "materials are not known: even a coarse print takes too long, or too much memory, for an estimate\n")
OPENFAB_MESSAGE(kEstimateMaterial, "{}: {} {:.3g} ml, {:.3g} g{}\n")

// job
OPENFAB_MESSAGE(kColorsOfPreviews, "{} chooses inks by colour: the faces have the colours of their materials' previews")
OPENFAB_MESSAGE(kColorsOfMixtures, "{} chooses inks by colour: those of mixtures are estimated from the previews of their materials; what inks cannot make, such as a saturated red, is paler than it was asked for")
OPENFAB_MESSAGE(kMeshesMadeFrom, "the meshes are made from voxels of {:g} mm; `--mesh-pitch 0.2mm` sets another size")
OPENFAB_MESSAGE(kNoPrinterNamed, "no printer was named: `{}` prints voxels of {} x {} x {} mm; `--printer j850` or `--voxel 0.1mm` set another pitch")
OPENFAB_MESSAGE(kGiveLayer, "`--layer 30um`")
OPENFAB_MESSAGE(kGiveDpi, "`--dpi 600x600`")
OPENFAB_MESSAGE(kGiveDpiAndLayer, "`--dpi 600x600 --layer 30um`")
OPENFAB_MESSAGE(kPitchNotKnown, "the {} of `{}` {} not known here (`openfab printers {}` says why); give yours, as {}")
OPENFAB_MESSAGE(kPitchStandsIn, "the {} of `{}` {} not known here: this is made of voxels of {:g} x {:g} x {:g} mm")
OPENFAB_MESSAGE(kThicknessOfSlice, "thickness of a slice")
OPENFAB_MESSAGE(kResolutionAcross, "resolution along x and y")
OPENFAB_MESSAGE(kResolutionAndThickness, "resolution and the thickness of a slice")
OPENFAB_MESSAGE(kTrayNotKnown, "`tray` of a world and `--crop tray` count from the tray of `{}`, whose size is not known here; leave them out, or write a profile with `build_volume_mm`")
OPENFAB_MESSAGE(kTooManyMaterials, "the world has {} materials, but `{}` prints at most {} at once")
OPENFAB_MESSAGE(kSupportOfNoMaterial, "`--support {}`: write on, off, or a material of the world; {}")
OPENFAB_MESSAGE(kBoundWithoutEffect, "`max_displacement_mm` of `{}` has no effect: fablet `{}` has no @Surface stage")
OPENFAB_MESSAGE(kKeyOfSupport, "material `{}` has the key colour of the support material of `{}`; change it, or choose another support material with `support` in the world")

// option_texts
OPENFAB_MESSAGE(kNotATime, "not a time above 0")
OPENFAB_MESSAGE(kNotARange, "not a range")
OPENFAB_MESSAGE(kNotAPart, "not a part, from 1, of a number of parts")
OPENFAB_MESSAGE(kBadValue, "`{}`: `{}` is {}; write `{} {}`")
OPENFAB_MESSAGE(kOfOption, "`{}`: {}")
OPENFAB_MESSAGE(kNotAResolution, "not a resolution")
OPENFAB_MESSAGE(kNotThreeNumbers, "not three numbers")

// options
OPENFAB_MESSAGE(kPitchOutside, "outside 0.1um to 100mm")
OPENFAB_MESSAGE(kNotACount, "not a whole number from 1 to {}")
OPENFAB_MESSAGE(kEmptyRange, "an empty or negative range")
OPENFAB_MESSAGE(kVoxelAndDpi, "`--voxel` and `--dpi`/`--layer` both set the pitch; give one of them")
OPENFAB_MESSAGE(kMeshPitchAndOthers, "`--mesh-pitch` and `--voxel`, `--dpi` or `--layer` both set the pitch; give one of them")
OPENFAB_MESSAGE(kHeightsAndSlices, "give one of `--z` and `--slices`")
OPENFAB_MESSAGE(kPartAndRange, "`--part` and `--z` or `--slices` both choose slices; give one of them")
OPENFAB_MESSAGE(kDpiOutside, "not a resolution between 1 and 100000 dpi")
OPENFAB_MESSAGE(kPitchOfPrintOutside, "outside 0.1um to 100m")
OPENFAB_MESSAGE(kNoSuchFormat, "there is no output format `{}`; choose from {}")
OPENFAB_MESSAGE(kFractionsNoZarr, "`--fractions {}`: fractions are written as an array of numpy, not as Zarr; write `--fractions {}`")
OPENFAB_MESSAGE(kFractionsNoVdb, "`--fractions {0}`: OpenVDB is written by `openfab export`; write `--fractions {1}`, and then `openfab export {1} -o {0}`")
OPENFAB_MESSAGE(kNotToStandardOutput, "{} {} and cannot go to standard output; use `--format ofr`")
OPENFAB_MESSAGE(kSlicesAreAFolder, "slices are a folder")
OPENFAB_MESSAGE(kIsFinishedLast, "is finished last")
OPENFAB_MESSAGE(kNotStreamed, "{} cannot be streamed; a receiver gets `--format ofr`")
OPENFAB_MESSAGE(kCentreAndSupersample, "give one of `--sampling centre` and `--fractions-supersample`")
OPENFAB_MESSAGE(kFractionsAndResume, "`--fractions` needs all slices, and `--resume` does not make those again that are there; leave one of them out")
OPENFAB_MESSAGE(kResumeWithoutOutput, "`--resume` continues a file or folder of slices; write `-o OUT` with the name of the one that was cut short")
OPENFAB_MESSAGE(kNoMemory, "no memory")
OPENFAB_MESSAGE(kNoSetting, "`--set`: `{}` is not a setting; write `--set OBJECT.UNIFORM=VALUE`")
OPENFAB_MESSAGE(kNoneOfChoices, "none of {}")
OPENFAB_MESSAGE(kNoSuchEffect, "no effect of machines has the option `{}`")

// output_check
OPENFAB_MESSAGE(kWouldOverwrite, "`{} {}` would overwrite {}; name another output")
OPENFAB_MESSAGE(kWhichIsAnInput, "`{}`, which is an input")
OPENFAB_MESSAGE(kOutputIsAFolder, "`{}` is a folder; the output is a file")
OPENFAB_MESSAGE(kCannotCreate, "cannot create `{}`: {}")
OPENFAB_MESSAGE(kOutputsAreOneFile, "`{} {}` and `{} {}` are one file; name another output")

// outputs
OPENFAB_MESSAGE(kCannotResume, "`--resume` cannot continue `{}`: {}")
OPENFAB_MESSAGE(kKeepsNothing, "it is not a file that keeps what was written")
OPENFAB_MESSAGE(kOrAPicture, ", or `--preview {}` for a picture")
OPENFAB_MESSAGE(kSlicesFillAFolder, "`-o {0}`: {1} slices fill a folder; write `-o {2} --format {1}`{3}")
OPENFAB_MESSAGE(kNativeFormatUnknown, "the printer `{}` takes the format `{}`, which there is not; its `native_format` is one of {}")
OPENFAB_MESSAGE(kOutputNoVdb, "`-o {0}`: OpenVDB is written by `openfab export`; write `-o {1}.ofr`, and then `openfab export {1}.ofr -o {0}`")
OPENFAB_MESSAGE(kNoFormatOfExtension, "`-o {0}`: there is no output format `{1}`; choose from {3}, or a folder of png slices, `-o {2}`; a folder of this very name is `-o {0}/`")
OPENFAB_MESSAGE(kNoPalette, "`--png indexed` is about the pictures of the format png, and this one is {}")
OPENFAB_MESSAGE(kNoReceiver, "`{}` is about a receiver, tcp://HOST:PORT, tls://HOST:PORT or unix:PATH, and the output is `{}`")
OPENFAB_MESSAGE(kNotMirrored, "`--flip-x` mirrors the pictures of {}; of an .ofr file `openfab export --flip-x` makes them, and {} is never mirrored")
OPENFAB_MESSAGE(kMeshPitchOfSlices, "`--mesh-pitch` is for the formats {}; `--voxel 0.1mm` sets the pitch of slices")
OPENFAB_MESSAGE(kNotSliceBySlice, "the format {} is not made slice by slice, which a print over several machines is")
OPENFAB_MESSAGE(kNotSliceBySliceHelp, "print an .ofr file, and make {} of it with `openfab export`")

// parse_options
OPENFAB_MESSAGE(kNotASeed, "not a whole number from 0 to 2^64 - 1")
OPENFAB_MESSAGE(kNoInstructionSet, "none of sse41, avx2 and avx512")
OPENFAB_MESSAGE(kOnlySse41, "not sse41, the one set of this machine")
OPENFAB_MESSAGE(kNotSlabs, "not a whole number from 1 to 1024")
OPENFAB_MESSAGE(kAboutFractions, "`{}` is about the array that `--fractions FILE.npy` writes; name one")
OPENFAB_MESSAGE(kNoOutput, "no output given; write `-o OUT` or `--preview FILE.png`")

// rates
OPENFAB_MESSAGE(kNoRate, "there is no derivative by `{}`: {}")
OPENFAB_MESSAGE(kNoRateHelp, "name uniforms as OBJECT.UNIFORM: floats, their vectors, matrices and arrays, keys of curves")
OPENFAB_MESSAGE(kRateOfType, "it is a `{}`")
OPENFAB_MESSAGE(kRateOfNone, "no object `{}` is placed")
OPENFAB_MESSAGE(kRateUndeclared, "its fablet declares no uniform `{}`")
OPENFAB_MESSAGE(kRateBeyond, "`{}` has {} elements")
OPENFAB_MESSAGE(kRatesWithEffects, "derivatives do not follow the machine's effects on a print; leave `process` out")

// statistics
OPENFAB_MESSAGE(kMixturesAreLost, "{:.3g} % of the voxels are mixtures, and a mesh has one material or filament: the largest amount has the place, and colours of several inks are lost; a machine that takes coloured meshes gets them with `--format 3mf` and its printer, and `--dither majority` says that this is meant")
OPENFAB_MESSAGE(kLeftOutOfGrey, "the grey pictures are of `{}` alone, and {} is not in them: print once for each material, as with `--grey-material NAME`")
OPENFAB_MESSAGE(kNothingPrinted, "nothing was printed: no voxel has any material; ")
OPENFAB_MESSAGE(kAmountsNotUsable, "; {} amounts of materials were negative or not a number, which count as 0")

// prepare
OPENFAB_MESSAGE(kOtherInstructionSets, "fablet `{}` was compiled for other instruction sets than this machine's, {}")
OPENFAB_MESSAGE(kOtherInstructionSetsHelp, "`openflc build --target both` makes a program for every machine")

// print_main
OPENFAB_MESSAGE(kSummaryMaterial, ", {} {:.2f} ml")
OPENFAB_MESSAGE(kSummaryResumed, " ({} resumed)")
OPENFAB_MESSAGE(kSummary, "{}: {} slices{} in {}, {:.1f} M voxels/s{}\n")
OPENFAB_MESSAGE(kStandardOutput, "standard output")
OPENFAB_MESSAGE(kResumeHelp, "the same command with `--resume` continues from there")
OPENFAB_MESSAGE(kGreyMaterialWithoutPictures, "`--grey-material` is about the pictures of the formats grey and tiff")
OPENFAB_MESSAGE(kSupersampleWithoutArray, "`--fractions-supersample` is about grey pictures, or the array that `--fractions FILE.npy` writes; name one")
OPENFAB_MESSAGE(kGreyAndFractions, "grey pictures and the array of `--fractions` are prints of their own: make them one after the other")
OPENFAB_MESSAGE(kGreyOfNoMaterial, "`--grey-material {}`: the print has no such material; {}")
OPENFAB_MESSAGE(kInterruptedBeforeSlices, "error: interrupted before the first slice\n")
OPENFAB_MESSAGE(kInterruptedBeforeNewSlices, "error: interrupted before the first new slice; those that were there are kept\n")

// process
OPENFAB_MESSAGE(kCostIdle, "`{}` names {}, which no material of this print has as its name or channel, and has nothing for {}")
OPENFAB_MESSAGE(kAboutWithoutScale, "`about_mm` of the process has no effect without `scale`")

// process_field
OPENFAB_MESSAGE(kADisplacementField, "a displacement field")
OPENFAB_MESSAGE(kOfDisplacementField, "the displacement field: ")
OPENFAB_MESSAGE(kFieldNumbers, "the displacement field {} has {} numbers at each place")
OPENFAB_MESSAGE(kFieldNumbersHelp, "it must have three: how far the machine moves what is there, in mm")
OPENFAB_MESSAGE(kFieldNotFinite, "the displacement field {} has a number that is not finite")
OPENFAB_MESSAGE(kFieldTooSteep, "the displacement field {} moves neighbouring places by {:.3g} of their distance differently; at most {} is possible")
OPENFAB_MESSAGE(kFieldTooSteepHelp, "are its numbers in mm, and `spacing_mm` right?")
OPENFAB_MESSAGE(kFieldCannotMove, "object `{}` is a shape by a function or a program, which a displacement field cannot move")
OPENFAB_MESSAGE(kFieldCannotMoveHelp, "print it with `process` without `field`")
OPENFAB_MESSAGE(kFieldWithoutInverse, "the displacement field has no inverse at {:.4g}, {:.4g}, {:.4g} mm")
OPENFAB_MESSAGE(kFieldMovesReferred, "object `{}` stands at several places, each moved otherwise by the displacement field, and a fablet refers to it")
OPENFAB_MESSAGE(kFieldMovesReferredHelp, "make an object of its own of each")
OPENFAB_MESSAGE(kFieldTooManyTriangles, "object `{}` takes more than {} triangles of {:.3g} mm to be displaced")
OPENFAB_MESSAGE(kFieldTooManyBeams, "object `{}` takes more than {} beams of {:.3g} mm to be displaced")
OPENFAB_MESSAGE(kFieldTooManyTrianglesHelp, "give a field with a coarser grid")

// progress
OPENFAB_MESSAGE(kSlowSlab, "slices {} to {} have taken {} so far")
OPENFAB_MESSAGE(kProgress, "slice {} of {}  {:.0f} %")
OPENFAB_MESSAGE(kProgressRate, "  {:.1f} M voxels/s")

// supersample
OPENFAB_MESSAGE(kPartsLargerThanVoxels, "the fractions of a voxel are means over {} x {} x {} parts, which are larger than the printer's voxels, of which it has {:.0f} x {:.0f} x {:.0f}")

// print_record
OPENFAB_MESSAGE(kNoRecordOfPrint, "the record of the print is not kept: {}")

// slab_watch
OPENFAB_MESSAGE(kSlabTooLong, "slices {} to {} took longer than {}, the `--slab-limit`; {} slices were written before, and are kept")
OPENFAB_MESSAGE(kSlabTooLongHelp, "`--draft 4` tells where the time goes sooner; a longer limit, as `--slab-limit 1h --resume`, goes on")

}  // namespace openfab::program::messages
