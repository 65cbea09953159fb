// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of series of DICOM: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for. Tests name
// rows, so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::tools::messages {

// choose_frames
OPENFAB_MESSAGE(kFramesOfSeveral, "its slices are of several {}: {}")
OPENFAB_MESSAGE(kFramesOfSeveralChoose, "a volume is of one: choose it with `{}`")
OPENFAB_MESSAGE(kFramesOfSeveralHelp, "a volume is of one: write its slices as files of their own")
OPENFAB_MESSAGE(kNothingToChoose, "it has nothing that `{}` could choose")
OPENFAB_MESSAGE(kLeaveItOut, "leave it out")
OPENFAB_MESSAGE(kNoneChosen, "`{}` is {:g}, but its {} are {}")
OPENFAB_MESSAGE(kSegmentsOfOneName, "`{}` is the name of several segments; it has {}")
OPENFAB_MESSAGE(kNoSuchSegment, "it has no segment `{}`; it has {}")

// dicom_pixels
OPENFAB_MESSAGE(kPixelsCutShort, "it is cut short: it has {} of {} bytes of pixels")
OPENFAB_MESSAGE(kCopyItAgain, "copy it again from its source")
OPENFAB_MESSAGE(kPixelsDamaged, "it is damaged")
OPENFAB_MESSAGE(kPackedPixelsDamaged, "its compressed pixels are damaged, or of an unknown kind")

OPENFAB_MESSAGE(kPackedBits, "its pixels of one bit are compressed (transfer syntax {}), which is not read")
OPENFAB_MESSAGE(kCompressionNotDecoded, "its pixels, compressed as {} ({}), could not be decoded")

// dicom_series
OPENFAB_MESSAGE(kSlicesAreMissing, "{:.0f} slice{} missing between {}, at ({:g}, {:g}, {:g}) mm, and {}, at ({:g}, {:g}, {:g}) mm: they are {:.3f} mm apart, others {:.3f} mm")
OPENFAB_MESSAGE(kSlicesAreMissingHelp, "copy the whole series")
OPENFAB_MESSAGE(kUnequalFramesHelp, "it is one file: write it again with planes at equal distances")
OPENFAB_MESSAGE(kSliceOutOfStep, "it lies {:.3f} mm from {}, where slices are {:.3f} mm apart")
OPENFAB_MESSAGE(kSliceAtSamePlace, "it lies where {} does")
OPENFAB_MESSAGE(kSliceAtSamePlaceHelp, "a volume has one slice at each place: keep one of the times, echoes or copies")
OPENFAB_MESSAGE(kSliceBesideLine, "it lies beside the line of the others")
OPENFAB_MESSAGE(kNoSlices, "it has no slices")
OPENFAB_MESSAGE(kNoSlicesHelp, "name the folder that holds the slices of a series")
OPENFAB_MESSAGE(kPassedOverNoSlices, "{}: passed over files that are no slices: {}")
OPENFAB_MESSAGE(kPassedOverOtherSeries, "{}: passed over files of other series: {}")
OPENFAB_MESSAGE(kPlaceUnknown, "{} does not say where it lies: its first pixel is put at 0, 0, 0")
OPENFAB_MESSAGE(kStoredMonochrome1, "values are as stored in {}, which is shown with the lowest in white (MONOCHROME1)")
OPENFAB_MESSAGE(kObliqueSlices, "its slices are not along x, y and z, so it is resampled")
OPENFAB_MESSAGE(kObliqueSlicesHelp, "give the value around it with `outside`: -1000 is air")
OPENFAB_MESSAGE(kObliqueLabels, "its slices are not along x, y and z, and between labels there is nothing")
OPENFAB_MESSAGE(kObliqueLabelsHelp, "name one with `segment`, which is then 1 and all else 0")
OPENFAB_MESSAGE(kPlaceOfVolume, "{} lies where it says in the volume of its ultrasound probe, not in the patient")
OPENFAB_MESSAGE(kContiguous, "{} does not say how far apart its slices are: their thickness is taken")
OPENFAB_MESSAGE(kOtherValues, "values of {} are its rescaled ones; it has others, too (Real World Value Mapping)")
OPENFAB_MESSAGE(kRelativeDose, "values of {} are shares of a dose, not Gy (Dose Units)")
OPENFAB_MESSAGE(kPixelsBehind, "{} has more pixels than its frames take: the rest is left out")
OPENFAB_MESSAGE(kRounded, "values of {} and its like have more digits than are kept: they are rounded to 24 bits")
OPENFAB_MESSAGE(kNotMapped, "it has a stored number for which its mapping (Real World Value Mapping) has no value")
OPENFAB_MESSAGE(kValueNotANumber, "it has a value that is not a number")
OPENFAB_MESSAGE(kGiveOutside, "give the value there with `outside`")

// frame_labels
OPENFAB_MESSAGE(kFrameList, "its list of {} is not one number for each of {} frames")
OPENFAB_MESSAGE(kFrameIncrement, "its frames follow each other by ({:04x},{:04x}) (Frame Increment Pointer), which is not known")
OPENFAB_MESSAGE(kFrameIncrementHelp, "write it with a position for each frame, or one slice a file")

// frame_values
OPENFAB_MESSAGE(kMappingTable, "its values go through a table (Real World Value LUT), which is not supported")
OPENFAB_MESSAGE(kMappingNotANumber, "slope or intercept of its Real World Value Mapping is not a number")
OPENFAB_MESSAGE(kNoMapping, "it does not say what its numbers mean (Real World Value Mapping)")
OPENFAB_MESSAGE(kSeveralMappings, "its numbers mean several things (items of its Real World Value Mapping that differ)")
OPENFAB_MESSAGE(kSeveralMappingsHelp, "write it with one of them")
OPENFAB_MESSAGE(kNoHighestFraction, "it does not say which number is the whole (Maximum Fractional Value)")

// packed_frames
OPENFAB_MESSAGE(kFramesOfItems, "its compressed pixels have {} of {} frames")
OPENFAB_MESSAGE(kFramesInFragments, "its {} frames are in {} fragments, and nothing says which is whose")
OPENFAB_MESSAGE(kWriteUncompressed, "write it without compression")

// pixel_format
OPENFAB_MESSAGE(kNoSegments, "it is a segmentation without segments")
OPENFAB_MESSAGE(kContours, "it holds contours (RT Structure Set), which are not read")
OPENFAB_MESSAGE(kContoursHelp, "convert it to a segmentation (DICOM SEG)")
OPENFAB_MESSAGE(kSurfaces, "it holds surfaces, which are not read")
OPENFAB_MESSAGE(kSurfacesHelp, "convert them to a mesh (STL), or to a segmentation (DICOM SEG)")
OPENFAB_MESSAGE(kHeightMap, "it is a map of heights, which is not read")
OPENFAB_MESSAGE(kTiles, "its frames are tiles of a picture, not slices")

// dicom_slice
OPENFAB_MESSAGE(kSyntaxNotRead, "its pixels are {} ({}), which is not read")
OPENFAB_MESSAGE(kNoPicture, "it holds no picture")
OPENFAB_MESSAGE(kValuesPerPixel, "it has {} values a pixel; a scan has one")
OPENFAB_MESSAGE(kPixelsAreColours, "its pixels are colours ({})")
OPENFAB_MESSAGE(kMosaic, "its picture is made of several slices (a mosaic)")
OPENFAB_MESSAGE(kMosaicHelp, "write it as one slice a file, or as frames")
OPENFAB_MESSAGE(kModalityLut, "its values go through a table (Modality LUT), which is not supported")
OPENFAB_MESSAGE(kPixelBits, "its pixels of {} bits in {} are not read; 1, 8, 16 and 32 are")
OPENFAB_MESSAGE(kFrameCount, "its number of frames, {}, is not a number from 1 to {}")
OPENFAB_MESSAGE(kNoImagePosition, "it does not say where it lies (Image Position)")
OPENFAB_MESSAGE(kNoImageOrientation, "it does not say which way it is turned (Image Orientation)")
OPENFAB_MESSAGE(kNoPixelSpacing, "it does not say how large its pixels are (Pixel Spacing)")
OPENFAB_MESSAGE(kOrientationNotOrthogonal, "the axes of its orientation are not at right angles, of length 1")
OPENFAB_MESSAGE(kThicknessNotANumber, "its thickness is not a number")
OPENFAB_MESSAGE(kFrameOffsets, "the offsets of its frames are not {} numbers")
OPENFAB_MESSAGE(kFrameOffsetsStart, "the offsets of its frames begin with {:g}: neither with 0 nor with its position along z")
OPENFAB_MESSAGE(kFrameDistanceNotANumber, "the distance of its frames is not a number")
OPENFAB_MESSAGE(kNoSliceSpacing, "it does not say how far apart its frames are (Spacing Between Slices)")
OPENFAB_MESSAGE(kRescaleNotANumber, "its rescale slope or intercept is not a number")
OPENFAB_MESSAGE(kInFrame, "frame {}: ")
OPENFAB_MESSAGE(kNotDicom, "it is not a DICOM file, or damaged")
OPENFAB_MESSAGE(kNoPixels, "it has no pixels")

// series_list
OPENFAB_MESSAGE(kTooManySeries, "its slices are of more than {} series, sizes and orientations")
OPENFAB_MESSAGE(kTooManySeriesHelp, "name the files of one with a pattern")
OPENFAB_MESSAGE(kSeriesLine, "{} ({}{} x {} pixels of {:.3g} x {:.3g} mm, {}, {} slice{}")
OPENFAB_MESSAGE(kNoSuchSeries, "it has no series {}; it has {}")
OPENFAB_MESSAGE(kNotOfOneSeries, "its slices are not of one {}: {}")
OPENFAB_MESSAGE(kNotOfOneSeriesBrackets, "name one with `field`, by the text before the brackets, or remove the others")
OPENFAB_MESSAGE(kNotOfOneSeriesIdentifier, "name one with `field`, by its number, description or identifier (UID)")

// segment_list
OPENFAB_MESSAGE(kNoSegmentation, "it is no segmentation, so it does not say what is a part")
OPENFAB_MESSAGE(kNoSegmentationHelp, "print it by a threshold: docs/how-to/scan.md")
OPENFAB_MESSAGE(kSegmentNowhere, "segment {} (`{}`) is nowhere, and left out")
OPENFAB_MESSAGE(kCannotWriteList, "cannot write {}")

}  // namespace openfab::tools::messages
