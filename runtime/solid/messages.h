// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of shapes and of what grows: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for.
// Tests name rows, so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::solid::messages {

// grow/grow_solid
OPENFAB_MESSAGE(kBeamsNotDisplaced, "the fablet has a @Surface stage, and what grows are beams, which have no surface to displace")
OPENFAB_MESSAGE(kBeamsNotDisplacedHelp, "give the nodes other radii")

// grow/grown
OPENFAB_MESSAGE(kTooManyNodesAtOnce, "more than {} nodes have bounds that reach the same few voxels, of those that grow around ({:.4g}, {:.4g}, {:.4g}) mm on level {}")
OPENFAB_MESSAGE(kTooManyNodesAtOnceHelp, "let `children` become 0 where beams are smaller than voxels, and give nodes a tighter `reach` or `box`")
OPENFAB_MESSAGE(kTooManyBeamsAtOnce, "more than {} beams lie within a few voxels at ({:.4g}, {:.4g}, {:.4g}) mm, on level {}")
OPENFAB_MESSAGE(kTooManyBeamsAtOnceHelp, "let `children` become 0 where beams are smaller than voxels")

// grow/program_answer
OPENFAB_MESSAGE(kNoKnownLine, "`{}` is not a `beam`, `flat`, `place`, `mesh`, `more` or `done`")
OPENFAB_MESSAGE(kNoKnownLineHelp, "write only answers to the standard output, and the rest to the standard error")
OPENFAB_MESSAGE(kAtLine, "line {}: {}")
OPENFAB_MESSAGE(kFloatAttributes, ", {}{} number{} of float attributes{}")
OPENFAB_MESSAGE(kTwice, "twice ")
OPENFAB_MESSAGE(kOfEachEnd, ", of each end")
OPENFAB_MESSAGE(kIntAttributes, ", {} of int ones")
OPENFAB_MESSAGE(kNotABeam, "`{}` is not a beam")
OPENFAB_MESSAGE(kNotABeamHelp, "write `{} X Y Z X Y Z RADIUS RADIUS`{}")
OPENFAB_MESSAGE(kBeamRadii, "`{}` has radii of {:.4g} and {:.4g} mm")
OPENFAB_MESSAGE(kBeamRadiiHelp, "one of them must be above 0, and none below")
OPENFAB_MESSAGE(kPlaceUnlisted, "`{}` places `{}`, which is not in the world's `places`")
OPENFAB_MESSAGE(kPlaceUnlistedHelp, "list the objects that it may place there")
OPENFAB_MESSAGE(kNotAPlace, "`{}` is not a place")
OPENFAB_MESSAGE(kNotAPlaceHelp, "write `place NAME X Y Z`, or with its axes `place NAME X Y Z XX XY XZ YX YY YZ ZX ZY ZZ`{}")
OPENFAB_MESSAGE(kNotAMesh, "`{}` is not a mesh")
OPENFAB_MESSAGE(kNotAMeshHelp, "write `mesh VERTICES TRIANGLES`{}, then a line `X Y Z` for each vertex and a line `A B C` for each triangle, of vertices that count from 0")
OPENFAB_MESSAGE(kMeshCounts, "a mesh of {} vertices and {} triangles")
OPENFAB_MESSAGE(kMeshCountsHelp, "a closed mesh has at least 4 of each, and at most {} are possible")
OPENFAB_MESSAGE(kTriangleVertex, "triangle {} has the vertex {}")
OPENFAB_MESSAGE(kTriangleVertexHelp, "there are {}, which count from 0")
OPENFAB_MESSAGE(kVertex, "vertex")
OPENFAB_MESSAGE(kTriangle, "triangle")
OPENFAB_MESSAGE(kEndsInMesh, "the answer ends before {} {} of a mesh")
OPENFAB_MESSAGE(kEndsInMeshHelp, "the line `mesh` says how many vertices and triangles follow")
OPENFAB_MESSAGE(kNotOfMesh, "`{}` is not {} {} of a mesh")
OPENFAB_MESSAGE(kNotOfMeshHelp, "it must be three numbers")
OPENFAB_MESSAGE(kNotAMore, "`{}` is not a `more`")
OPENFAB_MESSAGE(kNotAMoreHelp, "write `more KEY X Y Z X Y Z`: a word, and two corners of a box, the lower first")
OPENFAB_MESSAGE(kKeyTooLong, "a key of {} bytes")
OPENFAB_MESSAGE(kKeyTooLongHelp, "the longest has {}: keep what is long in the program, under a number")
OPENFAB_MESSAGE(kCornersSwapped, "`{}` has the upper corner first")
OPENFAB_MESSAGE(kLowerCornerFirst, "the lower corner comes first")

// grow/program_source
OPENFAB_MESSAGE(kAskedBefore, "`{}`, asked `{}`: {}")
OPENFAB_MESSAGE(kAskedAtLine, "`{}`, asked `{}`: line {}: {}")
OPENFAB_MESSAGE(kAnswersOtherwise, "`{}` answers `{}` differently than before")
OPENFAB_MESSAGE(kAnswersOtherwiseHelp, "what grows from a key must depend on the key alone: not on the time, the order of questions, or chance without the key as its seed")
OPENFAB_MESSAGE(kABeam, "a beam")
OPENFAB_MESSAGE(kWhatItPlaces, "what it places")
OPENFAB_MESSAGE(kAMesh, "a mesh")
OPENFAB_MESSAGE(kReachesOutside, "{} reaches from {} to {}, outside of {} to {}")
OPENFAB_MESSAGE(kEnlargeWorldBox, "make the world's `box_mm` larger")
OPENFAB_MESSAGE(kEnlargeMoreBox, "that is the box that `more` gave: make it larger")
OPENFAB_MESSAGE(kOfLine, "of line {}")
OPENFAB_MESSAGE(kEdgesNotClosed, "each edge has two triangles that run along it in opposite directions, counter-clockwise from outside")
OPENFAB_MESSAGE(kBoxOf, "the box of `{}`")
OPENFAB_MESSAGE(kMoreTooDeep, "`more`, {} levels deep")
OPENFAB_MESSAGE(kMoreTooDeepHelp, "let the program come to an end")

// grow/rule_source
OPENFAB_MESSAGE(kLetChildrenEnd, "let `children` become 0: `attr.level` tells how deep a node is")
OPENFAB_MESSAGE(kRuleBefore, "the rule `{}` of `{}`: {}")
OPENFAB_MESSAGE(kGrowKernelFailed, "the grow kernel of fablet `{}` failed with code {}")
OPENFAB_MESSAGE(kNotFinite, "has an end or a radius that is no finite number")
OPENFAB_MESSAGE(kNotFiniteHelp, "find what divides by 0, takes a root of less than 0, or overflows there")
OPENFAB_MESSAGE(kNodeRadius, "has a radius of {:.4g} mm")
OPENFAB_MESSAGE(kNodeRadiusHelp, "a node that is nothing itself has radius 0")
OPENFAB_MESSAGE(kLongAndOutside, "is {:.2g} mm long, {} levels deep, and outside of the bounds of a node that it grows of")
OPENFAB_MESSAGE(kBeamOutside, "is from {} to {} with radius {:.4g}, outside of {} to {}")
OPENFAB_MESSAGE(kEnlargeNodeBox, "that is the box of a node that it grows of, by its `reach` or `box`, or the world's `box_mm`: make it larger")
OPENFAB_MESSAGE(kEndOrEnlarge, "let `children` become 0, or make larger what bounds the node: the `reach` or `box` of a node that it grows of, or the world's `box_mm`")
OPENFAB_MESSAGE(kTooManyChildren, "has {} children; the most are {}")
OPENFAB_MESSAGE(kTooManyChildrenHelp, "let some of them grow from nodes in between")
OPENFAB_MESSAGE(kChildrenTooDeep, "has children, {} levels deep")
OPENFAB_MESSAGE(kNoSuchObject, "has the object {}")
OPENFAB_MESSAGE(kNoSuchObjectHelp, "`object` is 0 for none, or the number of one of the {} `Object` uniforms of the fablet, from 1")
OPENFAB_MESSAGE(kObjectWith, "has an object with ")
OPENFAB_MESSAGE(kObjectOutside, "has an object that reaches from {} to {}, outside of {} to {}")
OPENFAB_MESSAGE(kNodeReach, "has a reach of {:.4g} mm")
OPENFAB_MESSAGE(kNodeReachHelp, "`reach` is how far what grows of it gets from its beam")
OPENFAB_MESSAGE(kNodeBox, "has a box from {} to {}")
OPENFAB_MESSAGE(kChildrenOutside, "has children, {} levels deep, outside of the bounds of a node that it grows of")
OPENFAB_MESSAGE(kGrowsOutside, "grows outside of {} to {}")
OPENFAB_MESSAGE(kFirstNode, "its first node")
OPENFAB_MESSAGE(kChildOnLevel, "child {} on level {}, at {} mm,")

// grow/standing
OPENFAB_MESSAGE(kAxisLength, "an axis of length {:.4g}")
OPENFAB_MESSAGE(kAxisLengthHelp, "axes point where x, y and z of what stands there point, and their lengths scale it")
OPENFAB_MESSAGE(kAxesNotAlike, "axes of lengths {:.4g}, {:.4g}, {:.4g}, {:.4g} degrees apart")
OPENFAB_MESSAGE(kAxesNotAlikeHelp, "what stands there is turned, mirrored and scaled alike along all axes: they are at right angles and of one length")

// kinds/kinds
OPENFAB_MESSAGE(kReachNotKnown, "`{}` is made where a print comes near, so how far it reaches in its `box_mm` is not known before: it can be put neither on the bed, nor in rows or a grid with gaps, nor on trays")
OPENFAB_MESSAGE(kReachNotKnownHelp, "place it by `translate_mm` with three numbers, and copies by `step_mm`")

// shape/shape_check
OPENFAB_MESSAGE(kShapeBefore, "the shape `{}` of `{}` {}")
OPENFAB_MESSAGE(kNowhereNegative, "is nowhere negative in its `box_mm`")
OPENFAB_MESSAGE(kNowhereNegativeHelp, "a shape is negative inside: look at its sign, and at the box")
OPENFAB_MESSAGE(kNegativeAtNoPoint, "is negative at none of the points of its `box_mm` that were looked at, {:.3g} mm apart")
OPENFAB_MESSAGE(kNegativeAtNoPointHelp, "a shape is negative inside: look at its sign, and at the box; where the solid is smaller than that, make the box smaller")
OPENFAB_MESSAGE(kShapeOpen, "is open: it is {:.4g}, inside, at {} mm, on the border of its `box_mm`")
OPENFAB_MESSAGE(kShapeOpenHelp, "make the box larger, or intersect the shape with a box inside that one")
OPENFAB_MESSAGE(kShapeKernelFailed, "a shape kernel of fablet `{}` failed with code {}")
OPENFAB_MESSAGE(kShapeNaN, "is not a number (NaN) at {} mm")
OPENFAB_MESSAGE(kShapeNaNHelp, "find what divides by 0, takes a root of less than 0, or subtracts infinities there")

}  // namespace openfab::solid::messages
