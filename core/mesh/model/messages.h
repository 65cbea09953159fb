// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of meshes as they are checked, loaded and made: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what
// it is for. Tests name rows, so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::mesh::messages {

// check/mesh_check
OPENFAB_MESSAGE(kEqualCorners, "{}: mesh `{}` has {} triangle{} with two equal corners; left out")
OPENFAB_MESSAGE(kRepeatedTriangles, "{}: mesh `{}` has {} triangle{} over the corners of another; left out")
OPENFAB_MESSAGE(kCornersInALine, "{}: mesh `{}` has {} triangle{} without area, with corners in a line; kept, since they close the surface")
OPENFAB_MESSAGE(kMeshTooLarge, "mesh `{}` is {:.6g} x {:.6g} x {:.6g} mm in size, or that far from its origin")
OPENFAB_MESSAGE(kMeshTooLargeHelp, "at most 100 m are possible: check its `unit`; `openfab import --recentre` moves distant parts to the origin")
OPENFAB_MESSAGE(kMeshSizeUnlikely, "{}: mesh `{}` is {:.6g} x {:.6g} x {:.6g} mm; if that is wrong, give its `\"unit\": \"cm\"` (mm, cm, m, um or in), or a `\"scale\"` where it is built")
OPENFAB_MESSAGE(kInconsistentlyOriented, "inconsistently oriented")
OPENFAB_MESSAGE(kNotClosed, "mesh `{}` is not a closed surface: {}, one from {} to {}")
OPENFAB_MESSAGE(kNotClosedHelp, "close it so that each edge has two triangles that run along it in opposite directions, or let `\"repair\": \"winding\"` of its object do that (`openfab import --repair winding` writes it)")
OPENFAB_MESSAGE(kNoFaceWithArea, "{}: mesh `{}` has no face with an area")
OPENFAB_MESSAGE(kOpenAfterRepair, "{}: mesh `{}` has {} after its repair")
OPENFAB_MESSAGE(kNotClosedRepaired, "{}: mesh `{}` is not a closed surface: {}; repaired")
OPENFAB_MESSAGE(kTrianglesTurned, ", {} triangles turned")
OPENFAB_MESSAGE(kHolesClosed, ", {} hole{} closed, the widest {:.4g} mm across at {}")
OPENFAB_MESSAGE(kMeshNoFaces, "{}: mesh `{}` has no faces")
OPENFAB_MESSAGE(kEnclosesNoVolume, "{}: mesh `{}` encloses no volume ({:.3g} mm3); it is flat")

// check/mesh_shells
OPENFAB_MESSAGE(kTooManyShells, "{}: mesh `{}` has so many shells one behind another along x that it takes too long to find which are inside others; unite them, or make it several meshes")
OPENFAB_MESSAGE(kShellsInsideOut, "{}: mesh `{}` has {} inside out (clockwise seen from outside); flipped")
OPENFAB_MESSAGE(kShellsOverlap, "{}: mesh `{}` has {} of shells that overlap, one at {}; their volume is printed once, but distances count inner surfaces, too. Unite its pieces if that matters")
OPENFAB_MESSAGE(kShellsInsideShells, "{}: mesh `{}` has {} inside another that cuts nothing out, at {}; for a cavity, flip its triangles")

// load/bodies
OPENFAB_MESSAGE(kBodiesThatCut, "{}: {} are not parts, but cut others or instruct a slicer; left out. `openfab import` makes a world from the file in which negative bodies cut")

// load/face_numbers
OPENFAB_MESSAGE(kFaceInTwoGroups, "the face is in group `{}` ({}) and in `{}` ({}) of \"groups\"")
OPENFAB_MESSAGE(kFaceInTwoGroupsHelp, "a face has one value")
OPENFAB_MESSAGE(kGroupNotMapped, "the face is in group {}, which \"groups\" of mesh `{}` does not map")
OPENFAB_MESSAGE(kGroupNotInFile, "\"groups\" of mesh `{}` maps `{}`, which no face of {} is in; {}")
OPENFAB_MESSAGE(kNoGroupsToNumber, "`groups_attribute` of mesh `{}` has no effect: {} tells no groups or materials apart, so no face has a `{}`")
OPENFAB_MESSAGE(kFileNamesNoGroups, "the file names no groups")
OPENFAB_MESSAGE(kFileHas, "the file has ")
OPENFAB_MESSAGE(kAndMore, " and {} more")
OPENFAB_MESSAGE(kPicturesWithoutCoordinates, "pictures of faces without texture coordinates")
OPENFAB_MESSAGE(kPicturesWithoutCoordinatesHelp, "give all faces coordinates, or `--mapping box`")
OPENFAB_MESSAGE(kAttributeOfSomeFaces, "{}: some faces of mesh `{}` have no `{}`, this one first; the attribute is dropped")

// load/finish_mesh
OPENFAB_MESSAGE(kIntersectsItself, "{}: mesh `{}` intersects itself: {}{} pair{} of triangles cross, one at {}; its volume is printed once, but distances count inner surfaces, too. Unite its pieces if that matters")
OPENFAB_MESSAGE(kAtLeast, "at least ")
OPENFAB_MESSAGE(kUnitAsAsked, "as asked")
OPENFAB_MESSAGE(kUnitOfFile, "as the file says")
OPENFAB_MESSAGE(kUnitAssumed, "assumed, as the file gives none")
OPENFAB_MESSAGE(kUnitGuessed, "{}: mesh `{}` is {:.4g} x {:.4g} x {:.4g} in a unit that the file does not give; taken as metres. Give `\"unit\": \"mm\"` (or cm, m, um, in) if it is another")
OPENFAB_MESSAGE(kUnitFromSize, "guessed from the size")

// load/load_beams
OPENFAB_MESSAGE(kLatticeNamesOf3mf, "{}: lattices have names in 3MF files only")
OPENFAB_MESSAGE(kLatticeNamesOf3mfHelp, "leave out `body`")

// load/load_mesh
OPENFAB_MESSAGE(kOtherFormat, "{}, which is not read; {}")
OPENFAB_MESSAGE(kSaveWithMeshLab, "save it as PLY or OBJ with MeshLab, which keeps its colours")
OPENFAB_MESSAGE(kImportVrml, "`openfab import` makes an OBJ of it where Coin is there (`scripts/setup --vrml`), or save it as PLY or OBJ with MeshLab, which keeps its colours")
OPENFAB_MESSAGE(kImportUsd, "`openfab import` makes an OBJ of it where USD's library is there (`pip install usd-core`), or save it as GLB with Blender, which keeps its colours")
OPENFAB_MESSAGE(kSaveWithBlender, "save it as GLB with Blender, which keeps its colours")
OPENFAB_MESSAGE(kSaveDae, "save it as PLY or OBJ with MeshLab, or as GLB with Blender up to 4, which keep its colours")
OPENFAB_MESSAGE(kSaveAs3mf, "save it as 3MF with the program that made it")
OPENFAB_MESSAGE(kSaveAsObj, "save it as OBJ with the program that made it")
OPENFAB_MESSAGE(kSaveAsStep, "save it as STEP with the program that made it")
OPENFAB_MESSAGE(kNoMeshExtension, "{} does not have the extension of a mesh; supported: {}")
OPENFAB_MESSAGE(kNoBodyOfMesh, "{} has no body `{}` for mesh `{}`")
OPENFAB_MESSAGE(kTooManyBodies, "{}: it has so many bodies one behind another along x that it takes too long to find which lie in others; set their priorities by hand")
OPENFAB_MESSAGE(kBodyNotPrinted, "`{}`, which is not printed")
OPENFAB_MESSAGE(kBodyNotPrintedHelp, "make it a part in the program that wrote it")
OPENFAB_MESSAGE(kBodyWithoutVolume, "`{}`, which encloses no volume")
OPENFAB_MESSAGE(kBodyWithoutVolumeHelp, "give it a thickness")

// model/mesh_memory
OPENFAB_MESSAGE(kTooLargeToRead, "{}: reading a mesh of {} triangles takes {} MB, but {} MB are allowed; allow more, as with `--memory 4GB`, or use a simpler mesh")

// model/mesh_source
OPENFAB_MESSAGE(kPlaceInFile, " (in the file ({:.6g}, {:.6g}, {:.6g}))")
OPENFAB_MESSAGE(kFirstAt, ", first at ")
OPENFAB_MESSAGE(kLeftOut, "{}{} left out{}")

// model/outline
OPENFAB_MESSAGE(kPolygonFewerThan3Corners, "the polygon has fewer than 3 corners")
OPENFAB_MESSAGE(kPolygonTwiceAtCorner, "the polygon has the same corner twice in a row, at ({}, {})")
OPENFAB_MESSAGE(kPolygonTwiceAtCornerHelp, "give each corner once; the last is joined to the first")
OPENFAB_MESSAGE(kPolygonTooManyCorners, "the polygon has {} corners; at most {} are allowed")
OPENFAB_MESSAGE(kPolygonTooManyCornersHelp, "make a mesh of it, and give its file")
OPENFAB_MESSAGE(kPolygonMeetsItself, "the polygon meets itself: the side from ({}, {}) to ({}, {}) and that from ({}, {}) to ({}, {})")

// model/polygon
OPENFAB_MESSAGE(kTooMuchEffort, "the concave polygons up to here have too many corners")
OPENFAB_MESSAGE(kSplitPolygons, "split them into triangles where the mesh is made")

}  // namespace openfab::mesh::messages
