// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What converters of pictures and volumes say: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for.
// Tests name rows, so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::tools::messages {

// array_numbers
OPENFAB_MESSAGE(kNotBase64, "an array of it is not valid base64")
OPENFAB_MESSAGE(kArrayOfOtherSize, "an array of it has another size than it states, or its header is damaged")
OPENFAB_MESSAGE(kCompressedDataDamaged, "compressed data of it is damaged")
OPENFAB_MESSAGE(kNumberNotFinite, "`{}` in it is not a finite number")
OPENFAB_MESSAGE(kNoField, "it has no field: no array of numbers on points or cells")
OPENFAB_MESSAGE(kSeveralFields, "it has several fields, {}, and `field` names none")
OPENFAB_MESSAGE(kSeveralFieldsChoose, "choose one with `field`")
OPENFAB_MESSAGE(kNoSuchField, "it has no field `{}`; it has {}")
OPENFAB_MESSAGE(kFieldComponents, "its field `{}` has {} components; 1 to 4 are possible")
OPENFAB_MESSAGE(kArrayCutShort, "it is cut short: an array has fewer numbers than it states")

// byte_stream
OPENFAB_MESSAGE(kCompressedOfOtherSize, "its compressed data is damaged, or has another size than it states")
OPENFAB_MESSAGE(kPartCutShort, "data file {} of {} is cut short")

// cell_field
OPENFAB_MESSAGE(kValueNotFinite, "it holds a value that is not a finite number, or is beyond a float; `outside` stands in for NaN alone")
OPENFAB_MESSAGE(kCellsInAPlane, "its cells lie in a plane")
OPENFAB_MESSAGE(kNoCellsWithVolume, "it has no cells with a volume: tetrahedra, hexahedra or wedges")
OPENFAB_MESSAGE(kCornerNotFinite, "a corner of a cell is not a finite point")

// check_memory
OPENFAB_MESSAGE(kTakesTooMuchMemory, "it takes {} of memory, more than the {} of `--memory`; scale it down, or give it `--memory {}MB`")

// command_line
OPENFAB_MESSAGE(kOutputMissing, "`--output` is missing; only `--check` does without it")
OPENFAB_MESSAGE(kCheckIsForPictures, "`--check` is for pictures, not for volumes")
OPENFAB_MESSAGE(kPitchAboveZero, "`--pitch` must be above 0")
OPENFAB_MESSAGE(kWouldOverwrite, "`-o {}` would overwrite the image; name another output")

// convert
OPENFAB_MESSAGE(kPixelNotFinite, "pixel ({}, {}) is not a finite number")
OPENFAB_MESSAGE(kCannotReadBefore, "cannot read {}: ")
OPENFAB_MESSAGE(kImageChannels, "it has {} channels; 1 to 4 are possible")
OPENFAB_MESSAGE(kPictureChannels, "it has {} channels ({}); 1 to 4 are possible: write one with red, green, blue and alpha alone")
OPENFAB_MESSAGE(kChannelsLeftOut, "of {} the channels {} are left out: red, green, blue and alpha are the picture")
OPENFAB_MESSAGE(kUncalibrated, "EXIF says that its colours are not sRGB, and there is no profile; they are taken as sRGB: embed the profile that they have")
OPENFAB_MESSAGE(kProfileUnused, "its profile is damaged, of another kind of colours, or of ICC version 5, and is not used; its colours are taken as they are without one")
OPENFAB_MESSAGE(kInksWithoutProfile, "it has inks (CMYK) and no profile that says how they look; they are taken as ideal ones, (1 - C) (1 - K): embed the profile of the print, or convert it to RGB")
OPENFAB_MESSAGE(kInksProfileUnused, "it has inks (CMYK), and its profile is none of four inks, or the file is a TIFF of other than four channels of 8 or 16 bits; they are taken as ideal ones, (1 - C) (1 - K): embed the profile of the print, or convert it to RGB")
OPENFAB_MESSAGE(kNoteOnColors, "{}: {}")
OPENFAB_MESSAGE(kSeveralPictures, "{} holds several pictures; the first is read")
OPENFAB_MESSAGE(kUnknownSpace, "unknown space `{}`; known: `auto`, `srgb`, `linear`, `data`")
OPENFAB_MESSAGE(kCannotRead, "cannot read {}: {}")

// jpeg_inks
OPENFAB_MESSAGE(kInksOfUnknownSense, "it is a JPEG of inks (CMYK) without Adobe's marker, which says that its numbers are what the inks leave white; without it programs differ, and one has the negative of the other")
OPENFAB_MESSAGE(kInksOfUnknownSenseHelp, "convert it to RGB, or save it as a TIFF with its profile")

// convert_volume
OPENFAB_MESSAGE(kTooManyPages, "it has more than {} pages; write its slices as separate files")
OPENFAB_MESSAGE(kPixelOfSliceNotFinite, "pixel ({}, {}) of slice {} is not a finite number, or is beyond a float; `outside` stands in for NaN alone")
OPENFAB_MESSAGE(kPaletteAsColours, "{} has a palette: its colours are read, not its numbers; if they are labels, write it without one, in grey")
OPENFAB_MESSAGE(kPagesAmongPictures, "it holds several pictures, among files of one slice each; write each slice as a file of its own")
OPENFAB_MESSAGE(kSliceOfOtherSize, "slice {} is {} x {} with {} channels, the first is {} x {} with {}")
OPENFAB_MESSAGE(kNotNifti, "it is not a NIfTI file")
OPENFAB_MESSAGE(kAnalyze75, "it is an Analyze 7.5 file, which does not say where left and right are")
OPENFAB_MESSAGE(kAnalyze75Help, "write it as NIfTI")
OPENFAB_MESSAGE(kOnlyNumbers, "it holds only numbers")
OPENFAB_MESSAGE(kOnlyNumbersHdrHelp, "name the header that says what they are: .hdr")
OPENFAB_MESSAGE(kOnlyNumbersRawHelp, "name a header that says what they are: .nhdr, .mhd or .xdmf")
OPENFAB_MESSAGE(kIsGzip, "it is compressed as a whole, by gzip")
OPENFAB_MESSAGE(kIsGzipHelp, "unpack it first: gzip -d")
OPENFAB_MESSAGE(kArchiveOfArrays, "it is an archive of arrays")
OPENFAB_MESSAGE(kArchiveOfArraysHelp, "write one of them as .npy: numpy.save")
OPENFAB_MESSAGE(kIsHdf5, "it is an HDF5 file, which does not say what its arrays are")
OPENFAB_MESSAGE(kIsHdf5Help, "write an .xdmf file that names its array, or NRRD")
OPENFAB_MESSAGE(kIsMatlab, "it is a MATLAB file before version 7.3, which is not read")
OPENFAB_MESSAGE(kIsMatlabHelp, "write it with `save(file, name, '-v7.3')` and an .xdmf file that names its array, or as NRRD or NPY")
OPENFAB_MESSAGE(kPartsOfGrid, "it lists the parts of a grid, which are VTK files")
OPENFAB_MESSAGE(kPartsOfGridHelp, "name one of them, or merge them into one")
OPENFAB_MESSAGE(kVolumesNotRead, "volumes of `{}` are not read")
OPENFAB_MESSAGE(kVolumesNotReadHelp, "write NRRD, NIfTI, MetaImage or a VTK file")
OPENFAB_MESSAGE(kNotMrc, "it is not an MRC file: it has no `MAP` at byte 208")
OPENFAB_MESSAGE(kNotNrrd, "it is not an NRRD file")
OPENFAB_MESSAGE(kOtherArray, "{} beside it is of another array")
OPENFAB_MESSAGE(kOtherArrayHelp, "move it away; `spacing_mm` and `origin_mm` of the texture place an array that has none")
OPENFAB_MESSAGE(kNotNpy, "it is not an NPY file")

// crossed_field
OPENFAB_MESSAGE(kPlaceNotFinite, "a place along {} of its grid is not a finite number")
OPENFAB_MESSAGE(kPlacesNotMonotonic, "the places along {} of its grid neither rise nor fall")

// exr_header
OPENFAB_MESSAGE(kHeaderDamaged, "its header is damaged")
OPENFAB_MESSAGE(kExrCompressionNotRead, "it is compressed as {} (number {}), which is newer than the OpenEXR that reads it")
OPENFAB_MESSAGE(kExrCompressionNotReadHelp, "save it with ZIP or PIZ")

// meta_image
OPENFAB_MESSAGE(kUnknownNumberType, "its numbers are of type `{}`, which is not known")
OPENFAB_MESSAGE(kVolumeDimensions, "it has {} dimensions; a volume has 3, or a 4th of 1")
OPENFAB_MESSAGE(kDimSizeMalformed, "its `DimSize` is not three sizes")
OPENFAB_MESSAGE(kTransformMalformed, "its `TransformMatrix`, `ElementSpacing` or `Offset` is malformed")
OPENFAB_MESSAGE(kIntensityMalformed, "its `ElementToIntensityFunctionSlope` or `…Offset` is malformed")
OPENFAB_MESSAGE(kHeaderSizeIs, "its `HeaderSize` is `{}`")
OPENFAB_MESSAGE(kPackedBehindHeader, "its compressed numbers follow a header of `HeaderSize` bytes")
OPENFAB_MESSAGE(kPackedBehindHeaderHelp, "write it without one")

// mrc
OPENFAB_MESSAGE(kMrcMode, "its numbers are of mode {}, which is not read")
OPENFAB_MESSAGE(kMrcModeHelp, "write it as mode 0, 1, 2, 6 or 12")
OPENFAB_MESSAGE(kMrcAxes, "its header does not say which axis is x, y and z")
OPENFAB_MESSAGE(kMrcImages, "it is a stack of {} images, each by itself, not of slices (space group 0, one section a volume)")
OPENFAB_MESSAGE(kMrcImagesHelp, "if they are slices, write it as a volume: space group 1, as many sections")
OPENFAB_MESSAGE(kMrcVolumes, "it holds {} volumes behind each other")
OPENFAB_MESSAGE(kMrcAngles, "its cell is not at right angles, which is not read")

// nifti
OPENFAB_MESSAGE(kSingleBits, "single bits")
OPENFAB_MESSAGE(kFloats128, "floats of 128 bits")
OPENFAB_MESSAGE(kUnknownNumberCode, "its numbers are of type {}, which is not known")
OPENFAB_MESSAGE(kNumbersAre, "its numbers are {}")
OPENFAB_MESSAGE(kNumbersAreHelp, "write them as floats of 32 or 64 bits")
OPENFAB_MESSAGE(kOneVolume, "it has one volume, and no field `{}`")
OPENFAB_MESSAGE(kVolumesInTime, "it has {} volumes in time")
OPENFAB_MESSAGE(kOneOfThemHelp, "write one of them")
OPENFAB_MESSAGE(kVolumesInTimeHelp, "choose one with `field`: 0 to {}")
OPENFAB_MESSAGE(kAxesWithoutDirections, "its axes have no finite directions")
OPENFAB_MESSAGE(kNiftiDimensions, "it has {} dimensions; a volume has 3, with time a 4th and components a 5th")
OPENFAB_MESSAGE(kTimeAndComponents, "it has volumes in time of several components; write one of them")
OPENFAB_MESSAGE(kVoxOffsetOutside, "its `vox_offset` is not a place in the file")
OPENFAB_MESSAGE(kPackedHeaderAlone, "its header is compressed, and its numbers are in a separate file")
OPENFAB_MESSAGE(kPackedHeaderAloneHelp, "write it as one file, .nii.gz")

// nrrd
OPENFAB_MESSAGE(kNotAWholeNumberFrom, "its `{}` is `{}`; it must be a whole number of {} or more")
OPENFAB_MESSAGE(kByteSkipOfPacked, "its `byte skip` is -1, which is only for the encoding `raw`: the end of other data does not say where they begin")
OPENFAB_MESSAGE(kBothSkips, "it has a `line skip` and a `byte skip` of -1, which counts from the end; give only one of them")
OPENFAB_MESSAGE(kFewerLinesThanSkip, "it has fewer lines than its `line skip`")
OPENFAB_MESSAGE(kNrrdDimensions, "it has {} dimensions; it must have 3, or 4 where one is of channels")
OPENFAB_MESSAGE(kEntriesForAxes, "its `{}` has {} entries for {} axes")
OPENFAB_MESSAGE(kAxesInSpace, "{} of its {} axes lie in space, and a volume has 3")
OPENFAB_MESSAGE(kAxesUnknown, "its first axis, of {}, is taken for that of channels, which its last one, of {}, may be, too; `kinds` says which axes are `space`")
OPENFAB_MESSAGE(kLeftHanded, "its space is left-handed ({}), and what it shows would be printed mirrored")
OPENFAB_MESSAGE(kLeftHandedHelp, "write it in a space that is right-handed")
OPENFAB_MESSAGE(kTurnedToBack, "{}: its space is left-handed (left-anterior-superior), so it is read as left-posterior-superior: y runs to the back")
OPENFAB_MESSAGE(kFourAxesInSpace, "4 of its axes lie in space, and a volume has 3")
OPENFAB_MESSAGE(kSeveralUnits, "its axes have several units, ")
OPENFAB_MESSAGE(kSeveralUnitsHelp, "write it in one")
OPENFAB_MESSAGE(kUnknownUnit, "its unit of length is `{}`, which is not known")
OPENFAB_MESSAGE(kUnknownUnitHelp, "give it with `unit`: mm, cm, m, um or in")
OPENFAB_MESSAGE(kSpaceDirectionsMalformed, "its `space directions` are malformed; write them as `(1,0,0) (0,1,0) (0,0,1)`")
OPENFAB_MESSAGE(kSpacingsNotAboveZero, "its `spacings` are not above 0")
OPENFAB_MESSAGE(kSpaceOriginMalformed, "its `space origin` is malformed")
OPENFAB_MESSAGE(kNoEndian, "it does not say `endian`, little or big, of numbers of {} bytes")
OPENFAB_MESSAGE(kUnknownEncoding, "its encoding `{}` is unknown; known: raw, text, gzip")
OPENFAB_MESSAGE(kStepsOfTime, "it has {} steps of time; write one of them")
OPENFAB_MESSAGE(kAxisMaxsLeftOut, "{}: its `axis maxs` are left out; texels are of 1 mm; write it with `spacings`")
OPENFAB_MESSAGE(kOldRangeLeftOut, "{}: its `old min` and `old max`, between which its numbers lay, are left out; numbers are as they are stored")
OPENFAB_MESSAGE(kAxisMinsLeftOut, "{}: its `axis mins` are left out; give its place with `origin_mm`")

// ome_series
OPENFAB_MESSAGE(kOmePlaneMissing, "its description has {} planes, of which not all are among its {} pages")
OPENFAB_MESSAGE(kOmeElsewhere, "what its pages are is said by another file (BinaryOnly)")
OPENFAB_MESSAGE(kOmeElsewhereHelp, "name that file, or write this one with its own description")
OPENFAB_MESSAGE(kSeveralImages, "it has {} images, {}")
OPENFAB_MESSAGE(kHeightUnknown, "its pixels are {:.6g} x {:.6g} mm, but how far slices are apart is not said, so texels are of 1 mm; give `spacing_mm`")

// optional_converter
OPENFAB_MESSAGE(kSetupDicom, "run `scripts/setup --dicom` and build again")
OPENFAB_MESSAGE(kSetupVdb, "run `scripts/setup --vdb` and build again")
OPENFAB_MESSAGE(kSetupHdf5, "run `scripts/setup --hdf5` and build again, or write the data of the XDMF file as XML or Binary")
OPENFAB_MESSAGE(kBuiltWithoutReader, "this `openfab` was built without its reader of {} volumes")
OPENFAB_MESSAGE(kCannotStart, "cannot start `{}`: {}")

// picture_format
OPENFAB_MESSAGE(kSizeMissingOrTooLarge, "its size is missing or too large")
OPENFAB_MESSAGE(kBitmapCutShort, "it is cut short: it is {} x {} pixels, one digit each")
OPENFAB_MESSAGE(kCutShortAtPixel, "it is cut short at pixel ({}, {})")
OPENFAB_MESSAGE(kPixelNotABit, "pixel ({}, {}) is neither 0 nor 1")

// placed_grid
OPENFAB_MESSAGE(kResampledTooLarge, "resampled at {:g} mm it has {:.0f} texels along {}, and at most {:.0f} are possible; give it a coarser `pitch_mm`")
OPENFAB_MESSAGE(kAxesInAPlane, "the axes of its grid lie in a plane")

// print_volume
OPENFAB_MESSAGE(kPrintLacksSlices, "{} of the {} slices of this print are there")
OPENFAB_MESSAGE(kPrintLacksSlicesHelp, "let the print end, or name a pattern of the pictures that are to be read, as `slice_*.png`")
OPENFAB_MESSAGE(kNotAsManifestSays, "its pictures are not as its `manifest.json` says")

// slice_names
OPENFAB_MESSAGE(kSeriesHasGap, "the numbers of its slices have a gap: {} is followed by {}; slices are stacked without one")
OPENFAB_MESSAGE(kSeveralSeries, "its files are not slices of one {}: {} and {}")
OPENFAB_MESSAGE(kSeveralSeriesHelp, "name one series by a pattern, `{}`; if all are slices, name them by one number that rises")
OPENFAB_MESSAGE(kSeriesOfSeveralNumbers, "the names of its slices have several numbers: {} is followed by {}, and {} is the last; give them one number that rises if that is wrong")
OPENFAB_MESSAGE(kTakenAsSlices, "the numbers in the names of its slices, {} to {}, look like those of {}s; they are taken as slices")

// still_image
OPENFAB_MESSAGE(kNotASupportedPicture, "it is not a supported picture; supported: {}")
OPENFAB_MESSAGE(kPictureEmpty, "it is empty")
OPENFAB_MESSAGE(kCubeOfFaces, "it is a cube of six faces around a point (`envmap`), which is no flat picture; save one face, or the surroundings by latitude and longitude")
OPENFAB_MESSAGE(kDeepImage, "it is a deep image, which is not read")
OPENFAB_MESSAGE(kExrWholeNumbers, "its channel `{}` holds whole numbers, which are names of objects and no light")
OPENFAB_MESSAGE(kExrWholeNumbersHelp, "write it as half or float")
OPENFAB_MESSAGE(kIsAVolume, "it is a volume, not a picture")
OPENFAB_MESSAGE(kPictureDamaged, "it is damaged")

// stored_grid
OPENFAB_MESSAGE(kTextInSeveralFiles, "its numbers are text in several files; write them to one, or as bytes")
OPENFAB_MESSAGE(kUnequalFiles, "its numbers do not divide into {} files of one size")
OPENFAB_MESSAGE(kCutShort, "it is cut short")
OPENFAB_MESSAGE(kNotANumber, "`{}` in it is not a number")
OPENFAB_MESSAGE(kNotANumberLong, "`{}...` in it is not a number")
OPENFAB_MESSAGE(kSideNotPossible, "a side of {} is not possible")
OPENFAB_MESSAGE(kTooLarge, "it is too large")
OPENFAB_MESSAGE(kBytesBehind, "its file goes on for {} bytes behind the numbers that its header states, which are left out")
OPENFAB_MESSAGE(kPackedBehindTooMuch, "{} of compressed data stand before its numbers, more than the {} of `--memory`; write it without them")

// structured_cells
OPENFAB_MESSAGE(kNoCellBetweenPoints, "its grid has {} x {} x {} points and no cell between them")
OPENFAB_MESSAGE(kMoreThanPoints, "it has more than {} points")

// tiff_image
OPENFAB_MESSAGE(kDepthNotRead, "its pages are volumes (ImageDepth) in strips or in tiles of several layers, which are not read")
OPENFAB_MESSAGE(kDepthNotReadHelp, "write each slice as a page")
OPENFAB_MESSAGE(kCompressionNotRead, "its pixels are compressed as {} ({}), which is not read")
OPENFAB_MESSAGE(kCompressionNotReadHelp, "write it with LZW, Deflate or Zstandard, or not compressed")
OPENFAB_MESSAGE(kSamplesNotRead, "its samples are {}-bit {}, which are not read")
OPENFAB_MESSAGE(kSamplesNotReadHelp, "write them as integers of 8, 16, 32 or 64 bits, or as floats")
OPENFAB_MESSAGE(kChunkMissing, "its {} {} is missing, or lies outside of the file")
OPENFAB_MESSAGE(kChunkDamaged, "its {} {} is damaged or missing")
OPENFAB_MESSAGE(kOldJpegNotRead, "its pixels are compressed by the JPEG of TIFF 6.0 (old-style), which is not read")
OPENFAB_MESSAGE(kOldJpegHelp, "write it anew, with LZW or Deflate, or not compressed")
OPENFAB_MESSAGE(kChunkHelp, "copy it again from its source, or write it anew")

// tiff_series
OPENFAB_MESSAGE(kTiffUnitUnknown, "its unit of length, `{}`, is not known, so texels are of 1 mm; give `spacing_mm`")
OPENFAB_MESSAGE(kTiffDescription, "the description of its pages is malformed")
OPENFAB_MESSAGE(kImagesContradict, "its description says {} images, but {} channels, {} slices and {} frames")
OPENFAB_MESSAGE(kPagesContradict, "its description says {} pages, and it has {}; write it anew")
OPENFAB_MESSAGE(kCalibrationLeftOut, "its calibration, {:.9g} + {:.9g} x, is left out: numbers are as they are stored")
OPENFAB_MESSAGE(kShapeOfMoreAxes, "it is an array of {}, and which axis is that of slices is not said; write it as ImageJ's or OME's, or one volume of it")
OPENFAB_MESSAGE(kAxisOfPages, "its pages are {} places of an axis `{}`, which is not that of slices")
OPENFAB_MESSAGE(kNoDataAsStored, "what it stores where there are no data, {}, is read as a value (GDAL_NODATA)")
OPENFAB_MESSAGE(kScalingLeftOut, "its scale and offset (GDAL_METADATA) are left out: numbers are as they are stored")
OPENFAB_MESSAGE(kStkPlanes, "it holds {} planes behind one directory (MetaMorph), which are not read")
OPENFAB_MESSAGE(kWriteAsPagesHelp, "write each slice as a page, as ImageJ and OME do")
OPENFAB_MESSAGE(kLsmPages, "its description (Zeiss) says {} slices of {} times, and it has {} pages")
OPENFAB_MESSAGE(kOrientationLeftOut, "its orientation ({}) is left out: its first row and column, as they are stored, are the lowest")
OPENFAB_MESSAGE(kResolutionLeftOut, "its resolution, {:.6g} x {:.6g} mm a pixel, is left out, as it does not say how far slices are apart; texels have `spacing_mm`, 1 mm where it is not given")

// tiff_makers
OPENFAB_MESSAGE(kPagesByTurns, "its pages are channels, slices or times by turns ({}), and which is which is not read")

// tiff_stack
OPENFAB_MESSAGE(kTiffCut, "it is cut short: page {} lies outside of the file")
OPENFAB_MESSAGE(kReducedLeftOut, "{} pages that are smaller copies of others, or masks, are left out")
OPENFAB_MESSAGE(kFramesInTime, "it has {} frames in time")
OPENFAB_MESSAGE(kFramesInTimeHelp, "write one of them; if they are slices, say so where it is written (ImageJ: Image, Properties)")
OPENFAB_MESSAGE(kPlanesInOtherFile, "some of its pages lie in another file, `{}`")
OPENFAB_MESSAGE(kPlanesInOtherFileHelp, "name the folder of all of them")
OPENFAB_MESSAGE(kSliceOfOtherKind, "slice {} has numbers of another kind than the first")
OPENFAB_MESSAGE(kColoursOfSeries, "its pages are not all slices, and its colours are not stored as red, green and blue")
OPENFAB_MESSAGE(kColoursOfSeriesHelp, "write it in red, green and blue, or in grey")
OPENFAB_MESSAGE(kPaletteAsNumbers, "{} has a palette: its numbers are read, {} as 1, not its colours, which `\"space\": \"srgb\"` gives")
OPENFAB_MESSAGE(kWhiteIsLeast, "{}: its lowest number is white (MinIsWhite); numbers are read as they are stored")

// volume_files
OPENFAB_MESSAGE(kUnknownNumberKind, "its numbers are of kind {}, which is not known")
OPENFAB_MESSAGE(kNpyDimensions, "it has {} dimensions; they must be (z, y, x) or (z, y, x, channel)")
OPENFAB_MESSAGE(kLutSize, "LUT_3D_SIZE is {:g}; 2 to {} are possible")
OPENFAB_MESSAGE(kLutIs1d, "it holds a 1-D table; a 3-D one is needed")
OPENFAB_MESSAGE(kLutHasShaper, "a 1-D table in front of the 3-D one is not read; bake both into a 3-D one")
OPENFAB_MESSAGE(kLutWord, "line {}: the word `{}` is not known; TITLE, LUT_3D_SIZE, LUT_3D_INPUT_RANGE, DOMAIN_MIN and DOMAIN_MAX are")
OPENFAB_MESSAGE(kLutTwoDomains, "it has `DOMAIN_MIN` or `DOMAIN_MAX` and `LUT_3D_INPUT_RANGE`, words of two dialects that may contradict each other")
OPENFAB_MESSAGE(kLutTwoDomainsHelp, "leave the words of one dialect out")
OPENFAB_MESSAGE(kLutDomain, "the domain of the table ends before it begins")
OPENFAB_MESSAGE(kLineNotThreeNumbers, "line {} is not three numbers")
OPENFAB_MESSAGE(kColourBeforeLutSize, "line {} has a colour, with no LUT_3D_SIZE before it")
OPENFAB_MESSAGE(kLineNotUnderstood, "line {} is not understood")
OPENFAB_MESSAGE(kNoLutSize, "it has no LUT_3D_SIZE")
OPENFAB_MESSAGE(kLutRows, "it has {} rows of colours; LUT_3D_SIZE {} asks for {}")

// vtk_file
OPENFAB_MESSAGE(kNotVtkXml, "it is not a VTK XML file")
OPENFAB_MESSAGE(kVtkKindNotRead, "it holds {}, which is not read")
OPENFAB_MESSAGE(kVtkSurfaceHelp, "it is a surface, which has no values inside: print it as a mesh, written as .stl, .obj or .ply")
OPENFAB_MESSAGE(kVtkKindNotReadHelp, "write it as ImageData (.vti), RectilinearGrid (.vtr), StructuredGrid (.vts) or UnstructuredGrid (.vtu)")
OPENFAB_MESSAGE(kExtentMalformed, "its extent, origin, spacing or direction has the wrong number of values")
OPENFAB_MESSAGE(kSeveralPieces, "it has several pieces")
OPENFAB_MESSAGE(kSeveralPiecesHelp, "write it as one")
OPENFAB_MESSAGE(kPieceExtentMalformed, "the extent of its piece is not six numbers")
OPENFAB_MESSAGE(kPointsAndCellsOutside, "its numbers of points and cells are not between 0 and {}")
OPENFAB_MESSAGE(kUnusualComponents, "array `{}` has an unusual number of components")
OPENFAB_MESSAGE(kOffsetNotWhole, "array `{}` has an offset that is no whole number")
OPENFAB_MESSAGE(kAppendedDataMissingStart, "its appended data has no beginning")
OPENFAB_MESSAGE(kAtLine, "line {}: {}")
OPENFAB_MESSAGE(kNoPiece, "it has no piece")
OPENFAB_MESSAGE(kGhostsLeftOut, "{}: its array `{}` is left out, and what it hides is read")
OPENFAB_MESSAGE(kNoPoints, "it has no points")
OPENFAB_MESSAGE(kNoArrayOfCells, "it has no `{}` of its cells")
OPENFAB_MESSAGE(kAxesArrays, "it has {} arrays of coordinates, where 3 are read")
OPENFAB_MESSAGE(kPackedBy, "its data is compressed with {}")
OPENFAB_MESSAGE(kPackedByHelp, "write it with zlib (vtkZLibDataCompressor), or not compressed")
OPENFAB_MESSAGE(kAppendedDataMissing, "its appended data is missing")

// vtk_legacy
OPENFAB_MESSAGE(kNoDataSet, "it has no DATASET")
OPENFAB_MESSAGE(kNeitherAsciiNorBinary, "it is `{}`; ASCII and BINARY are read")
OPENFAB_MESSAGE(kUnknownKeyword, "`{}` is no VTK keyword that is read")
OPENFAB_MESSAGE(kIsASurface, "it holds a surface (POLYDATA), which has no volume")
OPENFAB_MESSAGE(kIsASurfaceHelp, "write it as a mesh: STL, PLY or OBJ")
OPENFAB_MESSAGE(kDataSetNotRead, "it holds {}; STRUCTURED_POINTS, RECTILINEAR_GRID, STRUCTURED_GRID and UNSTRUCTURED_GRID are read")
OPENFAB_MESSAGE(kMoreThanCells, "it has more than {} cells")
OPENFAB_MESSAGE(kNoCellOffsets, "it has no offsets of its cells")
OPENFAB_MESSAGE(kOffsetsWithoutConnectivity, "its OFFSETS are not followed by CONNECTIVITY")
OPENFAB_MESSAGE(kNoLookupTable, "array `{}` has no LOOKUP_TABLE")

// vtk_legacy_numbers
OPENFAB_MESSAGE(kCornersBeyondCells, "its cells have more corners than its CELLS say")
OPENFAB_MESSAGE(kArrayCount, "array `{}` has {} numbers, where the grid has {}")

// vtk_readers
OPENFAB_MESSAGE(kExtentNotPossible, "its extent {:g} to {:g} is not possible")
OPENFAB_MESSAGE(kSpacingIsZero, "its spacing is 0")
OPENFAB_MESSAGE(kPointsNotThree, "its points do not have three coordinates")
OPENFAB_MESSAGE(kCellDamaged, "cell {} is damaged")
OPENFAB_MESSAGE(kVtkCellTypeNotSampled, "cell {} is of VTK's type {:.0f}; tetrahedra (10), hexahedra (11, 12) and wedges (13) are sampled; write linear cells")
OPENFAB_MESSAGE(kCellCorners, "cell {} has {} corners instead of {}")
OPENFAB_MESSAGE(kCornerIsNoPoint, "cell {} has a corner that is not one of the points")
OPENFAB_MESSAGE(kCellsWithoutVolume, "{} cells without a volume (points, lines, faces) are left out")

// vtk_words
OPENFAB_MESSAGE(kWordTooLong, "a word in it is too long")
OPENFAB_MESSAGE(kLineTooLong, "a line in it is too long")

// write_volume
OPENFAB_MESSAGE(kItsFieldAlone, "its field")
OPENFAB_MESSAGE(kIntegersRounded, "{}: some of its integers are rounded; a float holds all up to 16777216, and few beyond")
OPENFAB_MESSAGE(kPitchWithoutEffect, "it is not resampled, so `pitch_mm` has no effect")
OPENFAB_MESSAGE(kPitchWithoutEffectHelp, "its texels are as large as it says, or `spacing_mm`: leave `pitch_mm` out")
OPENFAB_MESSAGE(kKeyWithoutEffect, "it has no {}, so `{}` has no effect")
OPENFAB_MESSAGE(kKeyWithoutEffectHelp, "leave `{}` out")
OPENFAB_MESSAGE(kNamedFields, "fields with names")
OPENFAB_MESSAGE(kLengthsInAnyUnit, "lengths but in millimetres")
OPENFAB_MESSAGE(kUnitOfLengths, "lengths of its own")
OPENFAB_MESSAGE(kPlacesWithoutValue, "places without a value")
OPENFAB_MESSAGE(kNoStepsOfTime, "it has no time steps for `time` to choose from")
OPENFAB_MESSAGE(kNoStepsOfTimeHelp, "leave `time` out")
OPENFAB_MESSAGE(kNoFramesToChoose, "it has no frames for `{}` to choose from; DICOM files have")
OPENFAB_MESSAGE(kNoFramesToChooseHelp, "leave `{}` out")
OPENFAB_MESSAGE(kCannotReadMemory, "cannot read {}: it takes more memory than `--memory` allows, {}")
OPENFAB_MESSAGE(kCannotReadMemoryHelp, "scale it down, or raise it")

// xdmf_reader
OPENFAB_MESSAGE(kCannotBeRead, "{} cannot be read: ")
OPENFAB_MESSAGE(kLiesInHdf5, "it lies in an HDF5 file, `{}:{}`, which is not read")
OPENFAB_MESSAGE(kLiesInHdf5Help, "write the file with its data as XML or Binary, or as a .vtu")
OPENFAB_MESSAGE(kItsField, "its field `{}`")
OPENFAB_MESSAGE(kNumbersFor, "{} has {} numbers, for {} {}")
OPENFAB_MESSAGE(kFieldSides, "its field `{}` has the sides {}, and its grid {}")
OPENFAB_MESSAGE(kFieldSidesHelp, "both are in the order z, y, x, and components come last")
OPENFAB_MESSAGE(kFirstOfSteps, "{}: of its {} steps of time the first is read; `time` chooses another")
OPENFAB_MESSAGE(kNotThreeNumbers, " is not of three numbers")
OPENFAB_MESSAGE(kRegularGeometry, "its regular grid has a geometry `{}`; ORIGIN_DXDYDZ with two arrays is read")
OPENFAB_MESSAGE(kOriginOfGrid, "the origin of its grid")
OPENFAB_MESSAGE(kSpacingOfGrid, "the spacing of its grid")
OPENFAB_MESSAGE(kStructuredDimensions, "its structured grid must have three dimensions")
OPENFAB_MESSAGE(kGridPoints, "its grid has {} points instead of {}")
OPENFAB_MESSAGE(kRectilinearGeometry, "its rectilinear grid has a geometry `{}`; VXVYVZ with three arrays is read")
OPENFAB_MESSAGE(kAxisPlaces, "axis {} of its grid has {} places for {} points")
OPENFAB_MESSAGE(kAxisOfGrid, "an axis of its grid")
OPENFAB_MESSAGE(kOneCellArray, "it must have exactly one cell array")
OPENFAB_MESSAGE(kMoreThanPointsOrCells, "it has more than {} points or cells")
OPENFAB_MESSAGE(kPointsGivenAs, "its points are given as `{}`; XYZ and X_Y_Z are read")
OPENFAB_MESSAGE(kPointArrays, "its points are not as many arrays as their geometry asks for")
OPENFAB_MESSAGE(kXdmfTypesNotSampled, "its cells are of type `{}`; tetrahedra, hexahedra, wedges and Mixed of them are sampled")
OPENFAB_MESSAGE(kItsTopology, "its topology")
OPENFAB_MESSAGE(kTopologyCount, "its topology has {} numbers, which does not fit {} cells")
OPENFAB_MESSAGE(kTopologyTooShort, "its topology has fewer numbers than its cells take")
OPENFAB_MESSAGE(kXdmfCellTypeNotSampled, "cell {} is of XDMF's type {:g}; tetrahedra (6), wedges (8) and hexahedra (9) are sampled; write linear cells")
OPENFAB_MESSAGE(kTopologyTooLong, "its topology has more numbers than its cells take")
OPENFAB_MESSAGE(kItsPoints, "its points")

// zarr_chunks
OPENFAB_MESSAGE(kZarrFileTooLarge, "it has {} bytes, far more than the {} of a chunk")
OPENFAB_MESSAGE(kZarrOfFile, "`{}`: ")
OPENFAB_MESSAGE(kZarrOfChunk, "chunk {} of its shard: ")
OPENFAB_MESSAGE(kZarrChunkSize, "it decodes to {} bytes instead of {}")
OPENFAB_MESSAGE(kZarrChunkDamaged, "its {} is damaged, cut short, or of more bytes than a chunk has")
OPENFAB_MESSAGE(kZarrChecksum, "its CRC-32C is wrong: it was damaged")
OPENFAB_MESSAGE(kZarrNoBlosc, "its chunks are compressed by Blosc, and this OpenFab was built without it")
OPENFAB_MESSAGE(kZarrNoBloscHelp, "run `scripts/setup --blosc` and build again, or copy the store with zstd or gzip")
OPENFAB_MESSAGE(kZarrBloscOf, "Blosc of {}")
OPENFAB_MESSAGE(kZarrShardShort, "it has {} bytes, fewer than its index of {}")
OPENFAB_MESSAGE(kZarrIndexChecksum, "the CRC-32C of its index is wrong: it was damaged")
OPENFAB_MESSAGE(kZarrIndexLies, "its index says that chunk {} has {} bytes from {}, which is not within its {}")

// zarr_volume
OPENFAB_MESSAGE(kZarrNoChunks, "none of its chunks is there, so all of it has the fill value; is the store whole?")
OPENFAB_MESSAGE(kZarrNoUnit, "it names no unit of its lengths, which are taken as millimetres; `unit` says another")
OPENFAB_MESSAGE(kZarrTooLarge, "{}; of its {} levels the one with texels of {:g} mm is read, of up to {:g} mm there are: `pitch_mm` takes a coarser one")

}  // namespace openfab::tools::messages
