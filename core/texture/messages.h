// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of pictures and volumes: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for. Tests
// name rows, so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::texture::messages {

// cache
OPENFAB_MESSAGE(kNoPipe, "cannot create a pipe: {}")
OPENFAB_MESSAGE(kCannotStart, "cannot start {}: {}")
OPENFAB_MESSAGE(kCannotWaitForHelper, "cannot wait for the texture helper: {}")
OPENFAB_MESSAGE(kNoConverter, "{} must be converted, but `openfab`, the program that does it, was found neither beside this one nor on the PATH; put it there, or set OPENFAB_HELPER to it")
OPENFAB_MESSAGE(kCannotConvert, "cannot convert {}: {} {}")
OPENFAB_MESSAGE(kEndedBySignal, "was ended by signal {}")
OPENFAB_MESSAGE(kFailedWithCode, "failed with exit code {}")
OPENFAB_MESSAGE(kNotCached, "filtered textures are not cached: {}")
OPENFAB_MESSAGE(kNoCacheFolder, "neither HOME nor XDG_CACHE_HOME is set")
OPENFAB_MESSAGE(kFolderNotUsed, "the folder `{}` cannot be used: ")
OPENFAB_MESSAGE(kNothingIsKept, "nothing can be kept in the folder `{}`: ")
OPENFAB_MESSAGE(kCannotReadBecause, "cannot read {}: ")

// data_files
OPENFAB_MESSAGE(kDataFilesMalformed, "its data files, `{}`, are not a pattern with a first and a last number and a step, nor a list")
OPENFAB_MESSAGE(kDataFilesMalformedHelp, "write it as `s%03d.raw 0 99 1`, or `LIST` with a name a line behind it")

// meta_header
OPENFAB_MESSAGE(kNotMetaImage, "it is not a MetaImage file: no line names its ElementDataFile")

// nifti_header
OPENFAB_MESSAGE(kNotNifti, "it is not a NIfTI file")
OPENFAB_MESSAGE(kHeaderDamaged, "its header is damaged")

// nrrd_header
OPENFAB_MESSAGE(kNotNrrd, "it is not an NRRD file")
OPENFAB_MESSAGE(kDataFileUnreadable, "its data file `{}` cannot be read: ")

// pyramid
OPENFAB_MESSAGE(kPyramidEmpty, "{} is not an .oftx file: it is empty")
OPENFAB_MESSAGE(kCannotRead, "cannot read {}: {}")

// pyramid_file
OPENFAB_MESSAGE(kCannotWrite, "cannot write {}: {}")
OPENFAB_MESSAGE(kCannotBeRead, "cannot be read: ")
OPENFAB_MESSAGE(kPyramidTooShort, "is not an .oftx file: it is too short")
OPENFAB_MESSAGE(kChecksumWrong, "is damaged: its checksum is wrong")
OPENFAB_MESSAGE(kAlphaAlone, "it has an alpha channel and nothing else")
OPENFAB_MESSAGE(kTooShort, "it is too short")
OPENFAB_MESSAGE(kNotPyramid, "is not an .oftx file")
OPENFAB_MESSAGE(kPyramidVersion, "is an .oftx file of version {}")
OPENFAB_MESSAGE(kPyramidVersionHelp, "this program reads version {}")
OPENFAB_MESSAGE(kIsDamaged, "is damaged: ")
OPENFAB_MESSAGE(kHeaderContradictory, "is damaged: its header contradicts itself")
OPENFAB_MESSAGE(kFileCutShort, "is cut short or damaged: it has {} bytes, but its header says {}")
OPENFAB_MESSAGE(kLevelTableContradictory, "is damaged: its level table contradicts its size")

// pyramid_layout
OPENFAB_MESSAGE(kPictureEmpty, "the picture is empty ({} x {})")
OPENFAB_MESSAGE(kPictureTooWide, "the picture is {} x {}")
OPENFAB_MESSAGE(kPictureTooWideHelp, "at most {} pixels a side are possible")
OPENFAB_MESSAGE(kPictureChannels, "the picture has {} channels")
OPENFAB_MESSAGE(kChannelsHelp, "1 to 4 are possible")
OPENFAB_MESSAGE(kPictureTooLarge, "the picture is {} x {} with {} channels, which is too large")
OPENFAB_MESSAGE(kPictureTooLargeHelp, "scale it down, or read only one channel with \"channels\": \"luminance\"")
OPENFAB_MESSAGE(kVolumeEmpty, "the volume is empty ({})")
OPENFAB_MESSAGE(kVolumeTooWide, "the volume is {}")
OPENFAB_MESSAGE(kVolumeTooWideHelp, "at most {} texels a side are possible")
OPENFAB_MESSAGE(kVolumePlaceNotFinite, "the volume's origin and spacing must be finite, and its spacing above 0")
OPENFAB_MESSAGE(kVolumeChannels, "the volume has {} channels")
OPENFAB_MESSAGE(kVolumeTooLarge, "the volume is {} with {} channels, which is too large")
OPENFAB_MESSAGE(kVolumeTooLargeHelp, "scale it down")

// volume
OPENFAB_MESSAGE(kTooManyFiles, "it has more than {} files in it and below")
OPENFAB_MESSAGE(kFolderEmpty, "the folder is empty")
OPENFAB_MESSAGE(kNoSuchFile, "no such file")

// xdmf_grid
OPENFAB_MESSAGE(kSizesNotWhole, "its `Dimensions` are not whole numbers of at least 1, or are too large")
OPENFAB_MESSAGE(kWritePlain, "write the file with its data as XML or Binary, or as a .vtu")
OPENFAB_MESSAGE(kPrecisionUnknown, "its precision is `{}`; 1, 2, 4 or 8 bytes are possible")
OPENFAB_MESSAGE(kNumberTypeUnknown, "its numbers have the unknown type `{}`")
OPENFAB_MESSAGE(kNumberBytesUnknown, "numbers of {} bytes are not supported")
OPENFAB_MESSAGE(kItemComputed, "it is computed from others (`{}`)")
OPENFAB_MESSAGE(kItemReference, "it is a reference to another")
OPENFAB_MESSAGE(kItemReferenceHelp, "write the numbers where they are used")
OPENFAB_MESSAGE(kItemFormatUnknown, "its format `{}` is unknown")
OPENFAB_MESSAGE(kItemCompressed, "it is compressed with `{}`")
OPENFAB_MESSAGE(kItemCompressedHelp, "write it uncompressed")
OPENFAB_MESSAGE(kSeekNoNumber, "its `Seek` is `{}`, which is not a number of bytes")
OPENFAB_MESSAGE(kSlabRowsMissing, "its hyperslab must have a start, a stride and a count for each side of its array")
OPENFAB_MESSAGE(kSlabBeyondArray, "its hyperslab goes beyond the {} numbers along a side of its array")
OPENFAB_MESSAGE(kSlabCountDiffers, "its hyperslab has {} numbers, its `Dimensions` say {}")
OPENFAB_MESSAGE(kNotXdmf, "it is not an XDMF file")
OPENFAB_MESSAGE(kGridInArray, "a `Grid` does not belong in a `DataItem`")
OPENFAB_MESSAGE(kTooManyArrays, "its grid has more than {} arrays")
OPENFAB_MESSAGE(kNoGrid, "it has no grid")
OPENFAB_MESSAGE(kSeveralGrids, "it has more than one grid")
OPENFAB_MESSAGE(kSeveralGridsHelp, "merge them, or write each to a file of its own")
OPENFAB_MESSAGE(kIncludeElsewhere, "its grid includes parts by `xi:include` that are not the cells and points of the only other grid")
OPENFAB_MESSAGE(kIncludeElsewhereHelp, "write the grid with its own Topology, Geometry and Attribute")
OPENFAB_MESSAGE(kSeriesNested, "it has a series of steps inside another")
OPENFAB_MESSAGE(kGridTypeUnknown, "it has a grid of type `{}`")
OPENFAB_MESSAGE(kGridTypeUnknownHelp, "write a Uniform one")
OPENFAB_MESSAGE(kSlabNumbersElsewhere, "the numbers of its hyperslab are not in the file itself")
OPENFAB_MESSAGE(kSlabWithoutTwoItems, "its hyperslab does not have two items: which part, and of which array")
OPENFAB_MESSAGE(kTopologyWithoutCount, "its topology does not say how many elements it has")
OPENFAB_MESSAGE(kBaseOffsetNotWhole, "its `BaseOffset` is not a whole number")
OPENFAB_MESSAGE(kElementFunction, "it is a function on finite elements, as `write_checkpoint` of FEniCS writes it")
OPENFAB_MESSAGE(kElementFunctionHelp, "write its values at the nodes: `XDMFFile.write`")
OPENFAB_MESSAGE(kPartReference, "its {} is a reference to another")
OPENFAB_MESSAGE(kPartReferenceHelp, "write it where it is used, or take it with `xi:include`")
OPENFAB_MESSAGE(kCornersOrdered, "its corners are in an order of their own")
OPENFAB_MESSAGE(kCornersOrderedHelp, "write it without `Order`")
OPENFAB_MESSAGE(kNoDataFile, "it names no data file")
OPENFAB_MESSAGE(kXmlTooLarge, "it is {} of text, more than a quarter of the {} that `--memory` allows")
OPENFAB_MESSAGE(kXmlTooLargeHelp, "write its data as Binary, or allow more, as `--memory 4GB`")
OPENFAB_MESSAGE(kAtLine, "line {}: {}")

// xdmf_steps
OPENFAB_MESSAGE(kSeveralSeries, "it has several series of steps, of {}, and `field` names none")
OPENFAB_MESSAGE(kTimesNotNumbers, "the times of its steps are not numbers")
OPENFAB_MESSAGE(kTimeNotNumber, "the time of a step is `{}`, which is not a number")
OPENFAB_MESSAGE(kNoSeriesOfField, "none of its series of steps has a field `{}`; they have {}")
OPENFAB_MESSAGE(kNoSteps, "it has no steps for `time` to choose from")
OPENFAB_MESSAGE(kNoStepsHelp, "leave `time` out")
OPENFAB_MESSAGE(kNoStepAtTime, "none of its {} steps has the time {:g}; they have {}")

// zarr_array
OPENFAB_MESSAGE(kZarrAt, "`{}`, line {}: {}")
OPENFAB_MESSAGE(kZarrKeyMissing, "`{}` is missing")
OPENFAB_MESSAGE(kZarrNotSides, "`{}` is not a list of at most 8 whole numbers that are possible")
OPENFAB_MESSAGE(kZarrFill, "its fill value is no number of its type")
OPENFAB_MESSAGE(kZarrFillHelp, "a number, or `NaN`, `Infinity` or `-Infinity` of floats, is taken")
OPENFAB_MESSAGE(kZarrAxesDiffer, "its shape, its chunks and those within shards do not have as many sides")
OPENFAB_MESSAGE(kZarrShardSides, "the sides of a shard are not multiples of those of its chunks")
OPENFAB_MESSAGE(kZarrChunkTooLarge, "its chunks are larger than any memory")
OPENFAB_MESSAGE(kZarrType, "its numbers are `{}`, which are not read")
OPENFAB_MESSAGE(kZarrTypeHelp, "write integers of 8 to 64 bits, floats of 16 to 64 or bool")
OPENFAB_MESSAGE(kZarrCodec, "its codec `{}` is not read here")
OPENFAB_MESSAGE(kZarrCodecHelp, "blosc, crc32c, gzip, zlib and zstd are, behind transpose and bytes, and sharding_indexed alone: copy it with one of these")
OPENFAB_MESSAGE(kZarrFilter, "its filter `{}` is not read")
OPENFAB_MESSAGE(kZarrEndian, "its order of bytes is `{}`, neither little nor big")
OPENFAB_MESSAGE(kZarrOrder, "the order of its axes names not each of them once")
OPENFAB_MESSAGE(kZarrNoBytes, "its codecs do not say how numbers become bytes: `bytes` is missing")
OPENFAB_MESSAGE(kZarrIndexPlace, "the index of its shards lies at `{}`, neither start nor end")
OPENFAB_MESSAGE(kZarrIndexCodecs, "the index of its shards has other codecs than bytes, and crc32c behind it")
OPENFAB_MESSAGE(kZarrKeys, "its files are named by `{}`, which is not read; default and v2 are, with / or .")
OPENFAB_MESSAGE(kZarrExtension, "its extension `{}` must be understood to read it, and is not")
OPENFAB_MESSAGE(kZarrGrid, "its chunks are `{}`; regular ones are read")

// zarr_store
OPENFAB_MESSAGE(kZarrField, "`{}` names nothing within the store")
OPENFAB_MESSAGE(kZarrUnread, "`{}` cannot be read: ")
OPENFAB_MESSAGE(kZarrNoObject, "`{}` is not an object of JSON")
OPENFAB_MESSAGE(kZarrNoNode, "`{}` is neither an array nor a group of Zarr")
OPENFAB_MESSAGE(kZarrVersion, "`{}` is of Zarr version {}; 2 and 3 are read")
OPENFAB_MESSAGE(kZarrGroup, "`{}` is a group, and no image of OME-Zarr")
OPENFAB_MESSAGE(kZarrGroupHelp, "name one of its arrays or images by its path, as `field`")
OPENFAB_MESSAGE(kZarrAxesOfImage, "its axes are not x, y and z, each once, and others of one place or of channels")
OPENFAB_MESSAGE(kZarrTransform, "its transformation `{}` is not read; identity, scale and translation are")
OPENFAB_MESSAGE(kZarrTransformNumbers, "its {} is not a list of {} finite numbers")
OPENFAB_MESSAGE(kZarrScale, "its scale is not above 0")
OPENFAB_MESSAGE(kZarrNoLevels, "its multiscales have no datasets, or more than 64")
OPENFAB_MESSAGE(kZarrUnit, "its lengths are in `{}`, which is not known")
OPENFAB_MESSAGE(kZarrUnitHelp, "name their unit as `unit`")
OPENFAB_MESSAGE(kZarrSides, "`{}` has {} axes, and no names for x, y and z")
OPENFAB_MESSAGE(kZarrSidesHelp, "three, z, y, x, are read, or four with up to 4 channels as the last")
OPENFAB_MESSAGE(kZarrNoArray, "`{}` is not an array")
OPENFAB_MESSAGE(kZarrSidesDiffer, "`{}` has {} axes, and its image {}")
OPENFAB_MESSAGE(kZarrChannels, "it has {} channels; a volume has at most 4")
OPENFAB_MESSAGE(kZarrChannelsHelp, "write those that are wanted as a store of their own")
OPENFAB_MESSAGE(kZarrOtherAxis, "its axis {}, from 0, has {} places and is none of space")
OPENFAB_MESSAGE(kZarrOtherAxisHelp, "write the one time, or place, that is wanted as a store of its own")
OPENFAB_MESSAGE(kZarrTooManyFiles, "it is cut into {:.0f} files, and at most {:.0f} are read")
OPENFAB_MESSAGE(kZarrTooManyFilesHelp, "copy it with larger chunks or shards, or take a coarser level by `pitch_mm`")

}  // namespace openfab::texture::messages
