// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of functions of 3MF: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for. Tests name
// rows, so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::tools::messages {

// displaced_text
OPENFAB_MESSAGE(kDisplacedAndScaled, "it is displaced, and not scaled alike in all directions")
OPENFAB_MESSAGE(kApplyTheScale, "apply the scale in the program that made it")
OPENFAB_MESSAGE(kNoSuchMap, "the displacement {} refers to the map {}, which does not exist")

// fablet_ir
OPENFAB_MESSAGE(kCompilerLine, "line {} of the compiler's text is `{}`")
OPENFAB_MESSAGE(kNoVolumeStage, "the compiler's text has no volume stage")

// fablet_text
OPENFAB_MESSAGE(kLevelSetOf, "the level set of ")
OPENFAB_MESSAGE(kMeshIdIsNoMesh, "`meshid` refers to object {}, which is not a mesh")
OPENFAB_MESSAGE(kBoundIsFlat, "object {}, which bounds it, is flat")
OPENFAB_MESSAGE(kSmallestFeature, "{}: its smallest feature is {:g} mm")
OPENFAB_MESSAGE(kBoundNotConvex, "{}: the mesh that bounds it is not convex: it is printed as that mesh, void where the level set is outside, and its surface is the mesh's")
OPENFAB_MESSAGE(kTransformIsFlat, "its transform is flat")
OPENFAB_MESSAGE(kNoSuchVolumeData, "it refers to volumetric data {}, which does not exist")
OPENFAB_MESSAGE(kColourAndMixture, "{}: it has both a colour and a mixture of materials; the mixture is printed")
OPENFAB_MESSAGE(kColourOf, "the colour of ")
OPENFAB_MESSAGE(kNoBaseMaterials, "`basematerialid` is {}, which does not name base materials")
OPENFAB_MESSAGE(kMixesMoreThanThereAre, "it mixes {} materials, and there are {}")
OPENFAB_MESSAGE(kMixesTooMany, "it mixes {} materials; at most {} are possible")
OPENFAB_MESSAGE(kMixtureOf, "the mixture of ")
OPENFAB_MESSAGE(kTheProperty, "the property `{}`")
OPENFAB_MESSAGE(kPropertyIsFunction, "{}: its property `{}`{} is the function `{}` of the fablet, and says nothing of what is printed until a stage uses it")
OPENFAB_MESSAGE(kRequiredByFile, ", which the file requires,")
OPENFAB_MESSAGE(kDistancesAndScaled, "it asks for distances of meshes, and is not scaled alike in all directions")
OPENFAB_MESSAGE(kObjectOfFile, "object {}")
OPENFAB_MESSAGE(kLatticeWithoutBeams, "the lattice of {} has no beams")

// function_gradient
OPENFAB_MESSAGE(kWantsResourceVectorScalar, "it needs a resource, a vector and a scalar")
OPENFAB_MESSAGE(kGradientOfNoScalar, "it is the gradient of something that is not a scalar")

// function_image
OPENFAB_MESSAGE(kNoSuchImage, "it refers to the image {}, which does not exist")
OPENFAB_MESSAGE(kTheImage, "image {}")
OPENFAB_MESSAGE(kNoRowsColumnsSheets, "it has no rows, columns or sheets")
OPENFAB_MESSAGE(kSheetCount, "`sheetcount` is {}, and there are {} sheets")
OPENFAB_MESSAGE(kNoOutput, "it has no output `{}`")
OPENFAB_MESSAGE(kImageOutputs, "a function from an image has `color`, `red`, `green`, `blue` and `alpha`")

// function_nodes
OPENFAB_MESSAGE(kUsesNoise, "it uses noise")
OPENFAB_MESSAGE(kLooksUpTexture, "it looks up a texture")
OPENFAB_MESSAGE(kVaryingLoop, "it has a loop whose number of trips varies")
OPENFAB_MESSAGE(kAsksNearestPoint, "it asks for the nearest point of a surface")
OPENFAB_MESSAGE(kAsksDerivative, "it asks for a derivative along the surface")
OPENFAB_MESSAGE(kUsesRandomNumbers, "it uses random numbers")
OPENFAB_MESSAGE(kCalculatesWithBits, "it calculates with bits of integers")
OPENFAB_MESSAGE(kAsksDistance, "it asks for the distance to a surface")
OPENFAB_MESSAGE(kReadsAttributes, "it reads attributes of the nearest surface point")
OPENFAB_MESSAGE(kDependsOnPlacement, "it depends on which placement it is in")
OPENFAB_MESSAGE(kDependsOnVoxels, "it depends on the size or the place of voxels")
OPENFAB_MESSAGE(kReadsThePrints, "it reads the `{}` of the print")
OPENFAB_MESSAGE(kFunctionNumberNotFinite, "one of its numbers is not finite")
OPENFAB_MESSAGE(kTooManyNodes, "it is more than {} nodes")

// function_text
OPENFAB_MESSAGE(kTheFunction, "function {}")
OPENFAB_MESSAGE(kTheNamedFunction, "function {} `{}`")
OPENFAB_MESSAGE(kTheNode, "{}, node `{}`")
OPENFAB_MESSAGE(kNoSuchFunction, "it refers to function {}, which does not exist")
OPENFAB_MESSAGE(kCalledWithPoint, "{} calls it with only a point, and it has the input `{}`")
OPENFAB_MESSAGE(kCalledWithPointHelp, "its only input can be the vector `pos`")
OPENFAB_MESSAGE(kOutputIsAndWants, "its output `{}` is {}, and {} wants {}")
OPENFAB_MESSAGE(kCallsNoFunction, "it calls function {}, which does not exist")
OPENFAB_MESSAGE(kCallsTooDeep, "calls are nested more than {} deep")
OPENFAB_MESSAGE(kCallsItself, "it calls itself: {}{}")
OPENFAB_MESSAGE(kCallsItselfHelp, "a function of 3MF cannot be recursive")
OPENFAB_MESSAGE(kNoSuchNode, "it refers to `{}`, and there is no node `{}`")
OPENFAB_MESSAGE(kDependsOnItself, "it depends on itself: {}{}")
OPENFAB_MESSAGE(kDependsOnItselfHelp, "nodes of 3MF have no cycles")
OPENFAB_MESSAGE(kOutputRefersToNothing, "its output `{}` refers to nothing")
OPENFAB_MESSAGE(kNodeWithoutIdentifier, "one of its nodes has no `identifier`")
OPENFAB_MESSAGE(kTwoNodesOfName, "two of its nodes are called `{}`")
OPENFAB_MESSAGE(kOutputIsGiven, "its output `{}` is {}, and is given {}")
OPENFAB_MESSAGE(kTextTooLong, "the text of its functions is longer than {} MB")
OPENFAB_MESSAGE(kNoInput, "it refers to `{}`, and the function has no input `{}`")
OPENFAB_MESSAGE(kNodeNeedsInput, "a node `{}` needs the input `{}`")
OPENFAB_MESSAGE(kInputANotVector, "input `A` is {} instead of a vector")
OPENFAB_MESSAGE(kVectorHasNo, "a vector has no `{}`")
OPENFAB_MESSAGE(kVectorOutputs, "its outputs are `x`, `y` and `z`")
OPENFAB_MESSAGE(kUnknownNode, "unknown kind of node `{}`")
OPENFAB_MESSAGE(kFunctionIdNoResource, "`functionID` is not a resource")
OPENFAB_MESSAGE(kInputIsAndWants, "input `{}` is {}, and {} wants {}")
OPENFAB_MESSAGE(kWantsVectorResource, "it needs a vector and a resource")
OPENFAB_MESSAGE(kObjectWithoutLattice, "it refers to object {}, which has no lattice of beams")
OPENFAB_MESSAGE(kObjectIsNoMesh, "it refers to object {}, which is not a mesh")

// node_text
OPENFAB_MESSAGE(kAScalar, "a scalar")
OPENFAB_MESSAGE(kAVector, "a vector")
OPENFAB_MESSAGE(kAMatrix, "a matrix")
OPENFAB_MESSAGE(kAResource, "a resource")
OPENFAB_MESSAGE(kInputIsResource, "input `{}` is a resource")
OPENFAB_MESSAGE(kInputAndAnother, "input `{}` is {}, and another is {}")
OPENFAB_MESSAGE(kInputInstead, "input `{}` is {} instead of {}")
OPENFAB_MESSAGE(kBeyondSinglePrecision, "{:g} is beyond the numbers of single precision")

}  // namespace openfab::tools::messages
