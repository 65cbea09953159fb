// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What the viewer says: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for. Tests name rows, so
// wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::viewer::messages {

// browser
OPENFAB_MESSAGE(kOpenTheAddress, "open the address in a browser of this machine; Ctrl-C ends the viewer")

// dropped
OPENFAB_MESSAGE(kTooManyFilesLike, "there are too many files like `{}` beside the world")
OPENFAB_MESSAGE(kNameCannotBeUsed, "this file name cannot be used")
OPENFAB_MESSAGE(kPartMissing, "a part of the file is missing")
OPENFAB_MESSAGE(kTooLargeToDrop, "files of up to 1 GiB can be dropped here; `openfab import` takes any")
OPENFAB_MESSAGE(kCannotWrite, "cannot write `{}`")
OPENFAB_MESSAGE(kImportFailed, "this file cannot be read as a mesh")
OPENFAB_MESSAGE(kImportMadeNoMesh, "no mesh came of the file")
OPENFAB_MESSAGE(kFirstMeshShown, "the file has {} meshes; the first is shown\n")
OPENFAB_MESSAGE(kNeitherMeshNorPicture, "`{}` is neither a mesh nor a picture: drop OBJ, STL, PLY, glTF, 3MF, AMF or OFF, or PNG, JPEG, TIFF, OpenEXR, BMP")
OPENFAB_MESSAGE(kStepIsDropped, "`{}` is STEP, which is not read when it is dropped: export its solids as 3MF or STL, and drop that")
OPENFAB_MESSAGE(kOtherIsDropped, "`{}` is {}")
OPENFAB_MESSAGE(kCanBeRepaired, "It can be repaired: press Repair")
OPENFAB_MESSAGE(kHasNotCome, "`{}` has not arrived")
OPENFAB_MESSAGE(kTextureOfWorld, "`{}` is a texture of the world now: put it on the part, or choose it at a uniform\n")

// source_text
OPENFAB_MESSAGE(kCannotRead, "cannot read `{}`: ")

// full_print
OPENFAB_MESSAGE(kPrintRunsAlready, "a print is already running; stop it, or wait for it")

// graph_compiler
OPENFAB_MESSAGE(kNoLineToCompiler, "cannot make a line to openflc: {}")
OPENFAB_MESSAGE(kCompilerTakesTooLong, "this takes the compiler too long")
OPENFAB_MESSAGE(kCompilerEndedDrawing, "openflc ended while it drew the graph")
OPENFAB_MESSAGE(kCompilerDidNotAnswer, "openflc did not answer")

// graph_places
OPENFAB_MESSAGE(kNoPlaces, "this does not say where nodes are")
OPENFAB_MESSAGE(kPlacesTaken, "`{}` is something else than the places of nodes, which are not kept")

// http_connections
OPENFAB_MESSAGE(kMemoryRanOut, "memory ran out")
OPENFAB_MESSAGE(kNoDescriptorLeft, "the system has no descriptor left for the server")
OPENFAB_MESSAGE(kServerEnded, "the server ended: ")
OPENFAB_MESSAGE(kServerSocketFailed, "the server ended: its socket failed")
OPENFAB_MESSAGE(kBodyTooLarge, "the body is too large")
OPENFAB_MESSAGE(kRequestTooLong, "the request took too long")

// http_message
OPENFAB_MESSAGE(kNoHttpRequest, "this is not an HTTP request")
OPENFAB_MESSAGE(kOnlyHttp11, "only HTTP/1.1 is supported here")
OPENFAB_MESSAGE(kNoAddress, "the address is malformed")
OPENFAB_MESSAGE(kNoHeader, "a header is malformed")
OPENFAB_MESSAGE(kLengthNoNumber, "the length of the body is not a number")
OPENFAB_MESSAGE(kChunkedBody, "a body in chunks is not read; give its length")
OPENFAB_MESSAGE(kExpectNotRead, "`Expect` is not supported: send the body at once")
OPENFAB_MESSAGE(kMoreThanOneHost, "there is more than one `Host`")
OPENFAB_MESSAGE(kTooManyHeaders, "too many headers")
OPENFAB_MESSAGE(kAddressTooLong, "the address is too long")
OPENFAB_MESSAGE(kHeadersTooLong, "the headers are too long")

// http_server
OPENFAB_MESSAGE(kNoRandomNumbers, "the system gives no random numbers")
OPENFAB_MESSAGE(kOtherName, "this server does not answer to that name")
OPENFAB_MESSAGE(kOnlyGetAndPost, "only GET and POST are answered")
OPENFAB_MESSAGE(kOtherSites, "this server does not answer pages of other sites")
OPENFAB_MESSAGE(kTokenWrong, "the token is wrong: open the address that `openfab view` has written")
OPENFAB_MESSAGE(kNotAnAddressHere, "`--listen`: `{}` is not an address of this machine; write `--listen 0.0.0.0` for all of them")
OPENFAB_MESSAGE(kIsItTaken, "is it taken?")
OPENFAB_MESSAGE(kCannotListen, "cannot listen at `{}`{}: {}")

// live
OPENFAB_MESSAGE(kCannotMakeFolder, "cannot make a folder: ")
OPENFAB_MESSAGE(kNoSuchFablet, "there is no fablet {}")
OPENFAB_MESSAGE(kChangedMeanwhile, "`{}` was changed meanwhile, by another window or program; nothing was saved")
OPENFAB_MESSAGE(kChangedMeanwhileHelp, "copy your text, and load the page again")
OPENFAB_MESSAGE(kValueKinds, "a value is a number, true, false, a name, a list of such, or a curve")
OPENFAB_MESSAGE(kNoSuchObject, "there is no object `{}`")
OPENFAB_MESSAGE(kNoSuchUniform, "`{}` has no uniform `{}`")
OPENFAB_MESSAGE(kValuesFailed, "the print with these values failed, so they are not written")
OPENFAB_MESSAGE(kValuesNotPrinted, "the print with these values has not begun yet")

// live_api
OPENFAB_MESSAGE(kNotAText, "not a text")
OPENFAB_MESSAGE(kNotAWholeNumber, "not a whole number in its limits")
OPENFAB_MESSAGE(kTooLargeForFablet, "that is too large for a fablet")
OPENFAB_MESSAGE(kAPrintNotAWorld, "this is a print, not a world")
OPENFAB_MESSAGE(kNameMissing, "`name` is missing")
OPENFAB_MESSAGE(kWorldOnlyLookedAt, "the world is only looked at; start `openfab view --watch` to change it")

// world_files
OPENFAB_MESSAGE(kCalledNow, "the world's `{}` is called `{}` now, too\n")
OPENFAB_MESSAGE(kFolderIsTaken, "another program is writing in `{}`; try again once it is done")
OPENFAB_MESSAGE(kDropOnceMore, "the world was changed meanwhile; drop the file once more")
OPENFAB_MESSAGE(kNoSuchTemplate, "there is no template `{}`")

// live_graph
OPENFAB_MESSAGE(kOverIsOneOf, "`over` is one of slice, line, voxel and surface")
OPENFAB_MESSAGE(kPointIsThreeNumbers, "`point_mm` is three numbers")
OPENFAB_MESSAGE(kAxisIs, "`axis` is 0, 1 or 2")
OPENFAB_MESSAGE(kNoPrintYet, "there is no print yet")
OPENFAB_MESSAGE(kNoSuchTexture, "there is no texture `{}`")

// tried_text
OPENFAB_MESSAGE(kNoUniformValue, "this is not the value of a uniform")
OPENFAB_MESSAGE(kNoWorldYet, "there is no world yet")

// node_look
OPENFAB_MESSAGE(kRunFailed, "the values could not be computed")

// parameters
OPENFAB_MESSAGE(kParameterIs, "`{}` is {}")
OPENFAB_MESSAGE(kWholeNumberFromTo, "a whole number from {} to {}")
OPENFAB_MESSAGE(kOneOf, "one of `{}`")
OPENFAB_MESSAGE(kEightHexDigits, "eight hexadecimal digits, RRGGBBAA, for each code from void on")

// part_finder
OPENFAB_MESSAGE(kPlacementOf, "{}, {} of {}")

// part_edit
OPENFAB_MESSAGE(kNotOfThePart, "this is nothing that the panel of the part changes")
OPENFAB_MESSAGE(kNoSuchPrinter, "there is no printer of this name")
OPENFAB_MESSAGE(kNothingToUndo, "there is nothing to undo: the world was changed by something else since")

// print_api
OPENFAB_MESSAGE(kOtherPrintShown, "another print is shown now")
OPENFAB_MESSAGE(kNoSuchPrint, "there is no such print")
OPENFAB_MESSAGE(kNoSuchVoxel, "there is no voxel {}")
OPENFAB_MESSAGE(kSlicesNeverCoarse, "slices are never coarse")
OPENFAB_MESSAGE(kTileBesidePrint, "that tile lies outside the print")
OPENFAB_MESSAGE(kVoxelBesidePrint, "that voxel lies outside the print")
OPENFAB_MESSAGE(kWorldNotKnown, "the world of this print is not known")

// prober
OPENFAB_MESSAGE(kSourcesNotKnown, "the print does not say what it was made of")
OPENFAB_MESSAGE(kProbeFailed, "the amounts could not be computed")
OPENFAB_MESSAGE(kProbeWithoutFractions, "the print tells no amounts")
OPENFAB_MESSAGE(kWorldChanged, "the world has changed since it was printed: {}")

// session
OPENFAB_MESSAGE(kGridsDiffer, "the prints have {} x {} x {} and {} x {} x {} voxels; only grids of one size can be compared voxel by voxel")

// view
OPENFAB_MESSAGE(kCannotOpen, "cannot open `{}`: ")
OPENFAB_MESSAGE(kFabletIsForMesh, "`--fablet` is for a print of a mesh: name the mesh, `--world MESH --fablet FABLET`; a world names its own fablets")
OPENFAB_MESSAGE(kWorldIsNoWorld, "`--world {}` is not a world (.fab.json); of a print of a mesh give its `--fablet`, too, or print a world of the mesh, which `openfab import` makes")
OPENFAB_MESSAGE(kWorldIsForPrint, "`--world` is for a print; the file is a world itself")
OPENFAB_MESSAGE(kFabletIsForPrint, "`--fablet` is for a print of a mesh; a world names its own")
OPENFAB_MESSAGE(kWorldCannotBeCompared, "a world cannot be compared; print it to an .ofr file first")
OPENFAB_MESSAGE(kWatchIsForWorld, "`--watch` is for a world (.fab.json)")
OPENFAB_MESSAGE(kSetIsForWorld, "`--set` and `--allow` are for a world (.fab.json), or for the `--world` of a print")
OPENFAB_MESSAGE(kNothingAtAddress, "there is nothing at this address")

// world_text

}  // namespace openfab::viewer::messages
