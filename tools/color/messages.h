// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What charts, profiles and tables of inks say: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for.
// Tests name rows, so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::color::messages {

// chart
OPENFAB_MESSAGE(kPatchLayoutUnknown, "the table does not say how its patches lie")
OPENFAB_MESSAGE(kPatchLayoutUnknownHelp, "give the `chart.txt` of the chart, whose OPENFAB_COLUMNS says so")
OPENFAB_MESSAGE(kFolderExists, "`{}` exists already; choose another folder")
OPENFAB_MESSAGE(kCannotMakeFolder, "cannot make the folder {}: {}")
OPENFAB_MESSAGE(kCannotReadBefore, "cannot read {}: ")
OPENFAB_MESSAGE(kCornerOutside, "corner {} lies outside the picture of {} x {}")
OPENFAB_MESSAGE(kCornerOutsideHelp, "corners are X,Y in pixels from the top left of the picture as viewers show it")
OPENFAB_MESSAGE(kCornersOnLine, "the corners lie on a line, or three of them do")
OPENFAB_MESSAGE(kCornersEqual, "corners {} and {} are the same place")
OPENFAB_MESSAGE(kCornersCross, "the sides between the corners cross")
OPENFAB_MESSAGE(kCornersMirrored, "the corners are those of a chart in a mirror")
OPENFAB_MESSAGE(kCornerWithin, "a corner lies between the three others")
OPENFAB_MESSAGE(kCornersHelp, "give those of the chart, around it: top left, top right, bottom right, bottom left")
OPENFAB_MESSAGE(kPatchesTooSmall, "{}: patches are {:.2g} pixels across there, and {} are needed")
OPENFAB_MESSAGE(kPatchesTooSmallHelp, "give the corners of the chart in pixels, or a larger photograph")
OPENFAB_MESSAGE(kNotPrintOfChart, "{}: it is not the print of this chart, of {} x {} patches: they would be {:.3g} x {:.3g} mm")
OPENFAB_MESSAGE(kPatchMissing, "patch {} of the chart is not in {}")
OPENFAB_MESSAGE(kPatchMissingHelp, "print the chart's world as it is, on its own")

// ink_table
OPENFAB_MESSAGE(kInkTableSides, "it is {} x {} x {} with {} channels, not {} in all directions with 4")
OPENFAB_MESSAGE(kInkTableHelp, "tables of inks are made by `openfab color bake`")

// main
OPENFAB_MESSAGE(kSkinAboveZero, "a skin is thicker than 0")
OPENFAB_MESSAGE(kNoChartOfInks, "{} is no chart of inks")
OPENFAB_MESSAGE(kNoChartOfInksHelp, "`openfab color chart` without `--table` makes one")
OPENFAB_MESSAGE(kSimulatedFrom, "simulated from {}")
OPENFAB_MESSAGE(kAbsoluteBy, "`{}` has the profile of a scanner, whose white is L* {:.1f}: colours are measured absolutely, against it; `--relative` counts that white as 100")
OPENFAB_MESSAGE(kRelativeTo, "`{}` has the profile of a camera, whose exposure is arbitrary: colours are relative to the profile's white")
OPENFAB_MESSAGE(kPhotographed, "photographed: {}")
OPENFAB_MESSAGE(kMeasuredOf, "{}, spectra under {}")
OPENFAB_MESSAGE(kFitted, "fitted {} patches; what the others predict for one is off by CIEDE2000 {:.2f} in the mean, {:.2f} at worst\n")
OPENFAB_MESSAGE(kPressProfile, "`{}` asks for more than 100 % at {:.0f} % of the colours, up to {:.0f} %, and is scaled to what voxels can be: that is the profile of a press, whose inks overlap; dark colours will look alike. A chart of `openfab color chart`, measured, makes a profile of this printer")
OPENFAB_MESSAGE(kWindowAndSkinAboveZero, "a window and a skin are larger than 0")
OPENFAB_MESSAGE(kProofOfPrint, "the inks of a print are in it, and no table is looked up: `openfab color proof PRINT.ofr PROFILE -o proof.png`")
OPENFAB_MESSAGE(kProofOfPicture, "a picture is proofed by a table of inks and a profile: `openfab color proof PICTURE TABLE PROFILE -o proof.png`")

// nominal_inks
OPENFAB_MESSAGE(kLineOf, "line {}: {}")
OPENFAB_MESSAGE(kNominalLineHelp, "a line is `cyan,absorption_r,_g,_b,scattering_r,_g,_b` in 1/mm")
OPENFAB_MESSAGE(kUnknownMaterial, "unknown material `{}`")
OPENFAB_MESSAGE(kNotSevenValues, "{} values, not 7")
OPENFAB_MESSAGE(kNotACoefficient, "`{}` is not a coefficient")
OPENFAB_MESSAGE(kNominalMissing, "the table has no `{}`")

// patch_check
OPENFAB_MESSAGE(kPatchOutOfLine, "patch `{}` was measured as Lab {:.1f} {:.1f} {:.1f}, where the others predict {:.1f} {:.1f} {:.1f}: CIEDE2000 {:.1f}; measure it again, or leave its row out")
OPENFAB_MESSAGE(kWhiteIsTinted, "the patch without ink is Lab {:.1f} {:.1f} {:.1f}, which is not white in light of D50: the colours may be of another light (under D65 white has b* -19 here), or the first row is of another patch")
OPENFAB_MESSAGE(kPatchesOutOfLine, "{} more patches are out of line")
OPENFAB_MESSAGE(kPatchesExchanged, "these patches fit each other's place: {}; they were measured, or stand in the table, in the wrong order")
OPENFAB_MESSAGE(kPatchesDisordered, "the patches do not go together ({} of {} are out of line): the rows are in another order than those of the chart, or of another chart; measure row by row from the top, left to right, as in `chart.txt`")

// picture
OPENFAB_MESSAGE(kPixelNotFinite, "pixel ({}, {}) is not a finite number")
OPENFAB_MESSAGE(kChannels, "it has {} channels; 1 to 4 are possible")
OPENFAB_MESSAGE(kPixelCount, "it has {} x {} pixels")
OPENFAB_MESSAGE(kPixelCountHelp, "scale it down to 64 million")
OPENFAB_MESSAGE(kNoMemoryForPicture, "no memory for a picture")

// print_inks
OPENFAB_MESSAGE(kNoMaterialNamed, "no material of {} has a name with `{}`")
OPENFAB_MESSAGE(kNoMaterialNamedHelp, "inks are found through the names of their materials")
OPENFAB_MESSAGE(kWindowTooSmall, "a window of {:g} mm is smaller than the voxels of {}, {:g} x {:g} mm")
OPENFAB_MESSAGE(kWindowTooSmallHelp, "give a larger one, as `--window 4mm`")
OPENFAB_MESSAGE(kAreaTakes, "the area of {} takes {}, more than {}")
OPENFAB_MESSAGE(kAreaTakesHelp, "print it coarser, as with `--draft 2`, or give a larger window, as `--window 4mm`")

// printer_model
OPENFAB_MESSAGE(kChartNotMeasured, "the table is a chart, whose colours are expected, not measured")
OPENFAB_MESSAGE(kChartNotMeasuredHelp, "print it, measure the patches, and give the table of what was measured (`.ti3`)")
OPENFAB_MESSAGE(kNoColours, "{} has no measured colours")
OPENFAB_MESSAGE(kNoColoursHelp, "columns of them are `LAB_L` to `LAB_B`, `XYZ_X` to `XYZ_Z`, `RGB_R` to `RGB_B`, or spectra such as `SPECTRAL_NM380`")
OPENFAB_MESSAGE(kNoMeasuredPatches, "the table has no measured patches of inks")
OPENFAB_MESSAGE(kNoMeasuredPatchesHelp, "a line has the amounts, `CMYK_C` to `CMYK_K`, and what was measured, `LAB_L` to `LAB_B`, `XYZ_X` to `XYZ_Z` or `RGB_R` to `RGB_B`")
OPENFAB_MESSAGE(kPatchCount, "the table has {} different patches, not {} to {}")
OPENFAB_MESSAGE(kPatchCountHelp, "print the chart of `openfab color chart`")
OPENFAB_MESSAGE(kPureCyan, "pure cyan")
OPENFAB_MESSAGE(kPureMagenta, "pure magenta")
OPENFAB_MESSAGE(kPureYellow, "pure yellow")
OPENFAB_MESSAGE(kPureBlack, "pure black")
OPENFAB_MESSAGE(kNoInk, "no ink")
OPENFAB_MESSAGE(kNoPatchOf, "the table has no patch of {}")
OPENFAB_MESSAGE(kNoPatchOfHelp, "the charts of `openfab color chart` have all that are needed")
OPENFAB_MESSAGE(kWhitePatch, "the patch without ink has L* = {:.1f}")
OPENFAB_MESSAGE(kWhitePatchHelp, "where white is the brightest patch, L* and XYZ go to 100, and RGB of a camera to 255")

// profile_read
OPENFAB_MESSAGE(kScannerProfile, "a profile of a scanner or camera")
OPENFAB_MESSAGE(kDisplayProfile, "a profile of a display")
OPENFAB_MESSAGE(kDeviceLink, "a link between two devices")
OPENFAB_MESSAGE(kAbstractProfile, "an abstract profile")
OPENFAB_MESSAGE(kColourSpaceProfile, "a profile of a colour space")
OPENFAB_MESSAGE(kNamedColours, "a list of named colours")
OPENFAB_MESSAGE(kPrinterProfile, "a printer's profile")
OPENFAB_MESSAGE(kUnknownClass, "a profile of an unknown class")
OPENFAB_MESSAGE(kPrinterProfileWanted, "a printer's profile is wanted: output class, CMYK, as `openfab color profile` makes")
OPENFAB_MESSAGE(kNotIcc, "it is not an ICC profile: {}")
OPENFAB_MESSAGE(kTooShort, "it is too short")
OPENFAB_MESSAGE(kProfileIs, "it is {}")
OPENFAB_MESSAGE(kPrinterOfSpace, "it is for a printer of {}")
OPENFAB_MESSAGE(kNoTables, "it has no tables from inks to colours and back (A2B0, B2A0)")
OPENFAB_MESSAGE(kTablesDamaged, "its tables are damaged: {}")
OPENFAB_MESSAGE(kCannotBeRead, "they cannot be read")
OPENFAB_MESSAGE(kTablesNotFinite, "its tables give values that are not numbers")

// profile_write
OPENFAB_MESSAGE(kNoMemoryForProfile, "no memory for a profile")
OPENFAB_MESSAGE(kNoMemoryForTables, "no memory for the tables of a profile")
OPENFAB_MESSAGE(kProfileNotWritten, "the profile could not be written")

// samples
OPENFAB_MESSAGE(kNotATable, "it is not a table of patches")
OPENFAB_MESSAGE(kNotATableHelp, "one begins with the names of its columns, such as `CMYK_C,CMYK_M,CMYK_Y,CMYK_K,LAB_L,LAB_A,LAB_B`, or is CGATS text with BEGIN_DATA_FORMAT")
OPENFAB_MESSAGE(kNoPatches, "the table has no patches")
OPENFAB_MESSAGE(kColumnsNotACount, "OPENFAB_COLUMNS is not a number of patches")
OPENFAB_MESSAGE(kTooManyColumns, "too many columns")
OPENFAB_MESSAGE(kColumnMissing, "the table has no column `{}`")
OPENFAB_MESSAGE(kColumnGoesWith, "it goes with `{}`")
OPENFAB_MESSAGE(kNeitherInksNorColours, "the table has neither inks nor colours of its patches")
OPENFAB_MESSAGE(kNeitherInksNorColoursHelp, "columns are `CMYK_C` ... `CMYK_K`, or `RGB_R`, `RGB_G`, `RGB_B`")
OPENFAB_MESSAGE(kValueNotANumber, "`{}` of column {} is not a number")
OPENFAB_MESSAGE(kValueOutside, "{} of column {} is not between {} and {}")
OPENFAB_MESSAGE(kRowsMissing, "the table says that it has {} rows, and has {}")
OPENFAB_MESSAGE(kRowsMissingHelp, "it broke off, or was stopped; measure or copy it again")
OPENFAB_MESSAGE(kNoEndOfData, "the table ends without END_DATA")
OPENFAB_MESSAGE(kOtherLight, "the colours are of `{}`, not of D50 and the observer of 2 degrees")
OPENFAB_MESSAGE(kOtherLightHelp, "let the program that measured them give XYZ or Lab for D50 and 2 degrees")
OPENFAB_MESSAGE(kNoSpectra, "there are no spectra, and colours of D50 cannot be those of another light")
OPENFAB_MESSAGE(kNoSpectraHelp, "leave out `--light`, or let the program that measured them give spectra, 380 to 730 nm")
OPENFAB_MESSAGE(kTooManyValues, "more than the {} values of the {} columns")
OPENFAB_MESSAGE(kValuesForColumns, "{} values for {} columns")
OPENFAB_MESSAGE(kTooManyPatches, "more than {} patches")
OPENFAB_MESSAGE(kInksArePercent, "amounts are percent of the voxels, 0 to 100, and not shares or values of 8 bits")
OPENFAB_MESSAGE(kInksBelowOnePercent, "no patch has more than {:.3g} % of an ink")
OPENFAB_MESSAGE(kColumnTwice, "the table has two columns `{}`")
OPENFAB_MESSAGE(kColumnTwiceHelp, "leave one of them out")
OPENFAB_MESSAGE(kWhiteOfPaper, "the table says that its colours are relative to the paper's white, and so is the absolute intent of a profile of them")
OPENFAB_MESSAGE(kInksAddUp, "the inks add up to {:.5g} %")
OPENFAB_MESSAGE(kInksAddUpHelp, "a voxel is one material, so amounts add up to at most 100 %; the rest is white")

// spectra
OPENFAB_MESSAGE(kSpectrumTooShort, "spectra have {} values from {:g} to {:g} nm")
OPENFAB_MESSAGE(kSpectrumTooShortHelp, "colours need them from 400 to 700 nm or further, in steps of 20 nm or less")
OPENFAB_MESSAGE(kWavelengthTwice, "columns `{}` and `{}` are of one wavelength")
OPENFAB_MESSAGE(kWavelengthTwiceHelp, "give the table of one measuring condition (M0, M1 or M2)")
OPENFAB_MESSAGE(kWavelengthsUneven, "wavelengths are not at equal steps: `{}` stands where {:.4g} nm would")

// cxf
OPENFAB_MESSAGE(kNotCxf, "it is XML, but not CxF 3, whose first element is `CxF`")
OPENFAB_MESSAGE(kCxfNoObjects, "the CxF has no object with amounts of ink and with a measured colour")
OPENFAB_MESSAGE(kCxfNoObjectsHelp, "an object has `DeviceColorValues` with `ColorCMYK`, and `ColorValues` with a `ReflectanceSpectrum`, `ColorCIELab` or `ColorCIEXYZ`: {} have amounts, {} have colours; export both from the program that measured them, or a CGATS table with columns `CMYK_C` …")
OPENFAB_MESSAGE(kCxfObject, "object `{}`: {}")
OPENFAB_MESSAGE(kCxfNotNumbers, "`{}` are not numbers")
OPENFAB_MESSAGE(kCxfValueOutside, "{:g} of {} is not between {:g} and {:g}")
OPENFAB_MESSAGE(kCxfNoStart, "its spectrum does not say at which wavelength it starts (`StartWL`), or in which steps (`Increment`)")
OPENFAB_MESSAGE(kCxfCondition, "no measurement is of condition `{}`; there is {}")
OPENFAB_MESSAGE(kCxfOtherKind, "it has no measurement as the others have")
OPENFAB_MESSAGE(kCxfChosen, "of the measurements {}, `{}` counts; `--condition` chooses")

}  // namespace openfab::color::messages
