// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of objects, uniforms and textures where a world meets its fablets: OPENFAB_MESSAGE(name, "text"), by file,
// each remedy behind what it is for. Tests name rows, so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::part::messages {

// bind
OPENFAB_MESSAGE(kSetForm, "not of the form OBJECT.UNIFORM=VALUE")
OPENFAB_MESSAGE(kSetNeitherJsonNorName, "the value is neither JSON nor a name; a list is written [1, 2, 3], text with blanks \"so\"")
OPENFAB_MESSAGE(kUniform, "uniform `{}`")
OPENFAB_MESSAGE(kSetNotAValue, "the value is not a number, a name or an array of these")
OPENFAB_MESSAGE(kPartsTakeMemory, "the parts up to this one, `{}`, take more memory than the {} MB that are allowed")
OPENFAB_MESSAGE(kPartsTakeMemoryHelp, "allow more, as with `--memory 4GB`, or give placements the same scale and fewer uniforms of their own")
OPENFAB_MESSAGE(kNoSuchObject, "no object is called `{}`")
OPENFAB_MESSAGE(kFabletNotInPrint, "fablet `{}` of `{}` is not in this print")
OPENFAB_MESSAGE(kOtherRuntime, "fablet `{}` was compiled for version {} of the runtime, and this is {}; build it again")
OPENFAB_MESSAGE(kWithoutDitherRule, "fablet `{}` was compiled without the world's dither rule `{}`")
OPENFAB_MESSAGE(kWithoutDitherRuleHelp, "`openfab print` compiles it in, and so does `openflc build --dither-rule FILE.fl:NAME`")
OPENFAB_MESSAGE(kNoSuchFile, "there is no file `{}`")
OPENFAB_MESSAGE(kMeshNamesNoFablet, "this print has {} fablets and a mesh names none; write a world")
OPENFAB_MESSAGE(kNoSuchFablet, "no fablet is called `{}`; {}")
OPENFAB_MESSAGE(kMeshSize, "`{}` is {:.6g} x {:.6g} x {:.6g} mm; its unit is {:.4g} mm, {}")

// bind_beams
OPENFAB_MESSAGE(kBeamsNotDisplaced, "the fablet has a @Surface stage, and these are beams, which have no surface to displace")
OPENFAB_MESSAGE(kBeamsNotDisplacedHelp, "give the nodes other radii")
OPENFAB_MESSAGE(kBeamsUnevenScaleHelp, "scale the nodes instead")

// bind_piece
OPENFAB_MESSAGE(kPieceUnevenScale, "piece `{}` of `{}` has connectors or a number, and its placement, or the `scale` of the machine's process, scales it differently along different axes")
OPENFAB_MESSAGE(kPieceUnevenScaleHelp, "scale it alike along all axes, or take them out of its `pieces`")
OPENFAB_MESSAGE(kObjectBefore, "object `{}`: {}")
OPENFAB_MESSAGE(kMisfitHelp, "move the connector, make it smaller, or ask for less `skin_mm`")

// bind_shape
OPENFAB_MESSAGE(kGrownScaledHelp, "give it a uniform, or an argument, for its size")
OPENFAB_MESSAGE(kShapeScaled, "it is a shape, and its placement, or the `scale` of the machine's process, scales it along axes that are not its own, by factors that differ by more than a tenth, or below a @Surface stage")
OPENFAB_MESSAGE(kShapeScaledHelp, "scale it before it is turned, or give it a uniform for its size")
OPENFAB_MESSAGE(kNoShapeStage, "fablet `{}` has no @Shape or @Grow stage")
OPENFAB_MESSAGE(kNoShapeStageHelp, "name one that has, or give the mesh a `file`")
OPENFAB_MESSAGE(kProgramNotAllowed, "`{}` is made by a program, `{}`, and programs of a world do not run by themselves")
OPENFAB_MESSAGE(kProgramNotAllowedHelp, "if you know what it does, add `{}`; never for a stranger's world")
OPENFAB_MESSAGE(kAsksForItself, "the shape of `{}` asks for the distance to itself, or places itself")
OPENFAB_MESSAGE(kAsksForItselfHelp, "name another object")
OPENFAB_MESSAGE(kAskedIsDisplaced, "a shape asks for the distance to `{}`, or places it, and its @Surface stage displaces it")
OPENFAB_MESSAGE(kAskedIsDisplacedHelp, "shapes see meshes as their files have them: give the object `\"max_displacement_mm\": 0` if it stays as it is, or give the shape an object of the same mesh with a fablet that does not displace it; `build` need not place it")

// stretch
OPENFAB_MESSAGE(kUnevenStretch, "its placement, or the `scale` of the machine's process, scales it by {:.4g} along one direction and by {:.4g} along another; beams and what grows can be scaled by a tenth differently")

// bind_textures
OPENFAB_MESSAGE(kKeyOfVolume, "`{}` of texture `{}` is about a volume, and an ImageTexture2D takes it as a picture, where that has no effect")
OPENFAB_MESSAGE(kKeyOfVolumeHelp, "leave it out, or make another texture of the file for the volume")
OPENFAB_MESSAGE(kVolumeWrap, "texture `{}` is a volume, and its `wrap` has two modes")
OPENFAB_MESSAGE(kVolumeWrapHelp, "a volume has one mode for all directions")
OPENFAB_MESSAGE(kTextureBefore, "texture `{}`: ")
OPENFAB_MESSAGE(kTexturesTakeMemory, "the textures up to this one, `{}`, take {} of memory together, more than the {} of `--memory`")
OPENFAB_MESSAGE(kTexturesTakeMemoryHelp, "the largest is `{}` with {}: scale it down, or allow more")

// curve
OPENFAB_MESSAGE(kCurveKeys, "has {} keys, not 1 to {}")
OPENFAB_MESSAGE(kCurveHasNoKey, "`{}` has {} keys, and none of the number {}")
OPENFAB_MESSAGE(kCurveHasNoKeyHelp, "keys have the numbers 0 to {}")
OPENFAB_MESSAGE(kCurveNumbers, "has {} numbers in key {}, not {}: {}")
OPENFAB_MESSAGE(kCurveKeyValue, "a place and a value")
OPENFAB_MESSAGE(kCurveKeyColor, "a place and the three values of a colour")
OPENFAB_MESSAGE(kCurveBeyond, "has {:.9g} in key {}, beyond a billion")
OPENFAB_MESSAGE(kCurveOrder, "has key {} at {:.9g}, which is not beyond the one before, at {:.9g}")

// part_mesh
OPENFAB_MESSAGE(kNoAttributes, "it has none")
OPENFAB_MESSAGE(kAttributes, "it has ")
OPENFAB_MESSAGE(kNoSuchAttribute, "mesh `{}` has no attribute `{}`, which fablet `{}` reads as `{} {}`")
OPENFAB_MESSAGE(kAttributeType, "attribute `{}` of mesh `{}` is {}, but fablet `{}` reads `{} {}`")
OPENFAB_MESSAGE(kAttributeTypeHelp, "give both the same type")

// uniforms
OPENFAB_MESSAGE(kTrueOrFalse, "true or false")
OPENFAB_MESSAGE(kAnInt, "a whole number from -2147483648 to 2147483647")
OPENFAB_MESSAGE(kAUint, "a whole number from 0 to 4294967295")
OPENFAB_MESSAGE(kANumber, "a number")
OPENFAB_MESSAGE(kNoSuchUniform, "fablet `{}` has no uniform `{}`")
OPENFAB_MESSAGE(kNotBound, "object `{}` does not bind `{}` of fablet `{}`")
OPENFAB_MESSAGE(kGiveIt, "give it {}")
OPENFAB_MESSAGE(kOfShapesFablet, ", by the `uniforms` of `{}` in `fablets`: that is the shape's, and those of the object are for `{}`")
OPENFAB_MESSAGE(kBooleans, "{} booleans")
OPENFAB_MESSAGE(kNumbers, "{} numbers")
OPENFAB_MESSAGE(kNameOfObject, "the name of an object")
OPENFAB_MESSAGE(kNamesOfObjects, "the names of {} objects")
OPENFAB_MESSAGE(kNameOfTexture, "the name of a texture")
OPENFAB_MESSAGE(kNamesOfTextures, "the names of {} textures")
OPENFAB_MESSAGE(kNameOfMaterial, "the name of a material")
OPENFAB_MESSAGE(kNamesOfMaterials, "the names of {} materials")
OPENFAB_MESSAGE(kAnArrayEach, "an array of {}, each {}")
OPENFAB_MESSAGE(kACurveOfColors, "a curve of colours, as `{\"keys\": [[0, 1, 0, 0], [1, 0, 0, 1]]}`")
OPENFAB_MESSAGE(kACurveAs, "a curve, as `{\"keys\": [[0, 1], [5, 2]]}`")
OPENFAB_MESSAGE(kAnArray, "an array of {}")
OPENFAB_MESSAGE(kTheString, "the string `{}`")
OPENFAB_MESSAGE(kStrings, "{} strings")
OPENFAB_MESSAGE(kACurve, "a curve")
OPENFAB_MESSAGE(kTheNumber, "the number {:.9g}")
OPENFAB_MESSAGE(kIsGiven, "`{}` of fablet `{}` is given {}")
OPENFAB_MESSAGE(kItTakes, "it takes {}")
OPENFAB_MESSAGE(kIsGivenNumber, "`{}` of fablet `{}` is given {:.9g}")
OPENFAB_MESSAGE(kLimit, "its `{}` is {:.9g}")
OPENFAB_MESSAGE(kIsGivenAsValue, "`{}` of fablet `{}` is given {:.9g} as value {}")
OPENFAB_MESSAGE(kEachMustBe, "each must be {}")
OPENFAB_MESSAGE(kUniformBefore, "`{}` of fablet `{}` {}")
OPENFAB_MESSAGE(kATexture, "a texture")
OPENFAB_MESSAGE(kAMaterial, "a material")
OPENFAB_MESSAGE(kAnObject, "an object")
OPENFAB_MESSAGE(kOtherKind, "`{}` is {}, but `{}` of fablet `{}` takes {}")
OPENFAB_MESSAGE(kForUniform, "{}, for `{}` of fablet `{}`")
OPENFAB_MESSAGE(kNoSuchMaterial, "no material is called `{}`")
OPENFAB_MESSAGE(kNoSuchTexture, "no texture is called `{}`")
OPENFAB_MESSAGE(kNotPlaced, "object `{}` is given to `{}` of fablet `{}`, but is not placed")
OPENFAB_MESSAGE(kNotPlacedHelp, "add it to `build`")

}  // namespace openfab::part::messages
