// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of stiffness, loads and flows: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for.
// Tests name rows, so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::mechanics::messages {

// command/cell_command
OPENFAB_MESSAGE(kNoSweep, "`--sweep`: `{}` is not a sweep; write UNIFORM=FROM:TO:COUNT, as in thickness=0.4:1.6:5")
OPENFAB_MESSAGE(kCellWrong, "`--cell`: {}")
OPENFAB_MESSAGE(kCellNotWhole, "a cell of {} mm is not a whole number of voxels of {} mm along {}")
OPENFAB_MESSAGE(kCellNotWholeHelp, "choose `--voxel {}`")
OPENFAB_MESSAGE(kCellMoves, "the print of the cell has {} x {} x {} voxels, not {} x {} x {}: a stage of its fablet moves the surface of the cell")
OPENFAB_MESSAGE(kCellMovesHelp, "leave the `@Surface` stage out: a cell goes on beyond its faces")
OPENFAB_MESSAGE(kCellOfWholeVoxels, "the cell is of whole voxels: {} x {} x {} of {}, {:.6g} x {:.6g} x {:.6g} mm")
OPENFAB_MESSAGE(kPitchOfCodes, "the printer's voxels are not known here, which elements of `--codes` are")
OPENFAB_MESSAGE(kGivePitchOfCodes, "give their sides, as `--voxel 42x85x27um`")
OPENFAB_MESSAGE(kConductivityMixed, "{}: either all materials need a `conductivity_W_mK`, of heat, or all a `conductivity_S_m`, of current")
OPENFAB_MESSAGE(kConductivityMixedHelp, "`--conductivity` needs the same one of every material")
OPENFAB_MESSAGE(kConvergeWithSweep, "`--converge` is for a single cell: leave out `--sweep`, or sweep again at half the pitch")
OPENFAB_MESSAGE(kLawWithoutTable, "{}: the law `table` needs a `table`")
OPENFAB_MESSAGE(kAsDithered, "as dithered")
OPENFAB_MESSAGE(kMixturesBy, "mixtures by {}")
OPENFAB_MESSAGE(kNoPolarPlot, "a cell without stiffness in some direction has no polar plot")
OPENFAB_MESSAGE(kConvergeBefore, "--converge, at half the pitch of the above: ")

// command/cell_report
OPENFAB_MESSAGE(kNoStiffness, "the cell has no stiffness in some direction: it is not connected across its faces\n")

// command/conduct_command
OPENFAB_MESSAGE(kFlowResultKinds, "`-o {}`: results are .vti, .npy, .json or .ofr")

// command/export_command
OPENFAB_MESSAGE(kMeshKinds, "`-o {}`: meshes are .inp, .vtu, .msh or .xdmf")
OPENFAB_MESSAGE(kNothingToMesh, "there is nothing to export: the print is void")
OPENFAB_MESSAGE(kCaseLeftOut, "{}: the case `{}` is left out, since this format has only elements; .inp has both")

// command/main
OPENFAB_MESSAGE(kVoxelWrong, "`--voxel`: {}")
OPENFAB_MESSAGE(kReachWrong, "`--reach`: {}")

// command/options
OPENFAB_MESSAGE(kSizesForm, "write one length, or three separated by `x`, as 1mm or 42x85x27um")
OPENFAB_MESSAGE(kSizesTooSmall, "a length must be above 0")
OPENFAB_MESSAGE(kNotPrintersVoxels, "elements of {} are dithered as if they were voxels; the printer's voxels are {}: without `--voxel` these are the elements")
OPENFAB_MESSAGE(kInputIsPrint, "`{}` is a print, and mechanics takes what it was made of")
OPENFAB_MESSAGE(kInputIsNoWorld, "`{}` is no world")
OPENFAB_MESSAGE(kGiveWorld, "give the world (.fab.json); `openfab import` makes one of a mesh")
OPENFAB_MESSAGE(kGiveWorldOrFablet, "give the world (.fab.json), or a fablet (.fl); `openfab import` makes a world of a mesh")
OPENFAB_MESSAGE(kInterrupted, "interrupted; nothing was written")
OPENFAB_MESSAGE(kNotConverged, "the solution did not converge: the residual is {:.1e}, not {:.1e}, after {} iterations")
OPENFAB_MESSAGE(kNotConvergedHelp, "a piece may hang only on a corner or an edge, or materials may differ by more than a factor of 10^5: choose finer elements, as `--voxel 0.1mm`, more steps, as `--iterations 2000`, or a larger residual, as `--tolerance 1e-5`")
OPENFAB_MESSAGE(kTooMuchMemory, "{} x {} x {} elements take {}, and `--memory` allows {}")
OPENFAB_MESSAGE(kTooMuchMemoryHelp, "allow more, or choose a pitch {:.4g} times as coarse")

// command/part_command
OPENFAB_MESSAGE(kViewWrong, "`--view`: `{}` is not TURN:TILT, as in 30:25")
OPENFAB_MESSAGE(kResultKinds, "`-o {}`: results are .vti, .npy, .json or .ofr; `openfab mechanics export` writes meshes for other programs")
OPENFAB_MESSAGE(kFactorTooSmall, "the safety factor is {:.4g}, below {:.4g}")
OPENFAB_MESSAGE(kBucklesBelow, "the part buckles at {:.4g} times its loads, below {:.4g}")
OPENFAB_MESSAGE(kBucklingTooLarge, "buckling was not looked at, though the part may buckle at {:.2g} times its loads: that takes {} of `--memory`")
OPENFAB_MESSAGE(kBucklingGivenUp, "buckling was not looked at, though the part may buckle at {:.2g} times its loads: the search was given up, and `--buckling always` goes on")
OPENFAB_MESSAGE(kBucklingRough, "the search for the shape in which the part buckles did not settle: the factor may be lower")
OPENFAB_MESSAGE(kFactorUnresolved, "the safety factor is not resolved: it may be {:.4g} where less than two elements lie across a wall or strut")
OPENFAB_MESSAGE(kFactorUnresolvedHelp, "choose finer elements, of a quarter of the thinnest wall or less, as `--voxel 0.1mm`")
OPENFAB_MESSAGE(kFactorCut, "the safety factor is not resolved: it may be {:.4g} where elements are long, or the surface goes through them, and few lie across")
OPENFAB_MESSAGE(kFactorCutHelp, "choose finer elements, as `--voxel 0.1mm`")
OPENFAB_MESSAGE(kCoarseThere, "{:.2g} elements lie across the part at its weakest place, and its stress there may be {:.2g} times as much: a `--voxel` of {:.2g}mm or less has four")
OPENFAB_MESSAGE(kMovedFar, "its places move by {:.4g} mm against each other, which is much for a part of {:.4g} to {:.4g} mm: all is computed as if it moved little, and what is bent far or held at its edges is stiffer or softer than that")
OPENFAB_MESSAGE(kNoStrength, "the safety factor is unknown: the materials have no `strength_MPa`")

// command/part_report
OPENFAB_MESSAGE(kUnresolvedThin, ": not resolved, for less than two elements lie across where it is weak\n")
OPENFAB_MESSAGE(kUnresolvedCoarse, ": not resolved, for less than four elements lie across where it is weak, and its stress may be 1.6 times as much, or twice below two and a half\n")
OPENFAB_MESSAGE(kUnresolvedCut, ": not resolved, for its surface goes through elements, as that of what is round or slanted does, or these are long, and few lie across where it is weak: what is computed may be too high\n")
OPENFAB_MESSAGE(kThinConverge, "less than two elements lie across much of the part: what the numbers tend to is unknown\n")
OPENFAB_MESSAGE(kCellNotSettled, "not settled: {}. They change by more than a tenth, so that finer elements, as `--voxel 0.05mm`, have to tell what they tend to\n")
OPENFAB_MESSAGE(kOddCell, "an odd number of voxels along {}, so their faces lie half a voxel off the cell's middle: what changes at whole voxels from there falls within elements, which mix it; an even number has it on their faces")
OPENFAB_MESSAGE(kMovedNotHeld, "`move_mm` moves along {}, which `along` does not hold")
OPENFAB_MESSAGE(kMovedNotHeldHelp, "name the axis in `along` too, or let it be 0 in `move_mm`")
OPENFAB_MESSAGE(kNotSettled, "not settled: {}. These do not tend to a number yet, as a stress at a sharp edge, or where a hold ends, never does\n")

// command/part_source
OPENFAB_MESSAGE(kMaterialLacks, "{}: `{}` has no `{}`")
OPENFAB_MESSAGE(kGiveConductivity, "give its conductivity in S/m; that of an insulator is 1e-12 or so")
OPENFAB_MESSAGE(kGiveHeatConductivity, "give its conductivity in W/(m K)")
OPENFAB_MESSAGE(kGravityWithoutDensity, "{}: `{}` has no `density_g_cm3`, and the case `{}` has gravity")

// command/stand_command
OPENFAB_MESSAGE(kStandResultKinds, "`-o {}`: results are .json, .vti or .ofr")
OPENFAB_MESSAGE(kFalls, "it does not stand: it falls towards ({:.2f}, {:.2f})")
OPENFAB_MESSAGE(kRolls, "it does not stand: what it stands on is an edge, a tip or round, with a radius of {:.2g} mm, and its centre of mass is {:.4g} mm high: it rolls or tips towards ({:.2f}, {:.2f})")
OPENFAB_MESSAGE(kPiecesStandAlone, "the part is in {} pieces, each of which has to stand by itself: what is said is of the one whose centre of mass is at {} mm, which stands least")
OPENFAB_MESSAGE(kStandNotResolved, "whether it stands is not resolved: its centre of mass is within {:.2g} mm of the edge of its foot, or that is lower than voxels tell")
OPENFAB_MESSAGE(kStandNotResolvedHelp, "choose finer elements, as `--voxel 0.1mm`, or make the foot wider")
OPENFAB_MESSAGE(kOfrShowsModes, "`-o FILE.ofr` shows modes, and there are none")
OPENFAB_MESSAGE(kPreviewShowsModes, "`--preview` shows modes, and there are none")

// command/strengthen_command
OPENFAB_MESSAGE(kNoMaterialStrength, "{}: `{}` has no `strength_MPa`")
OPENFAB_MESSAGE(kNoMaterialStrengthHelp, "give it: without it nothing tells what is strong enough")
OPENFAB_MESSAGE(kResultIsWorld, "`-o`: the result is a world; name it NAME.fab.json")
OPENFAB_MESSAGE(kNamesOthers, "`{}` names files that stay in `{}`: print it with `--allow {}`")
OPENFAB_MESSAGE(kWouldOverwrite, "`-o` would overwrite the world that is being strengthened")
OPENFAB_MESSAGE(kFieldEverywhere, "the field is {} wherever it counts")
OPENFAB_MESSAGE(kAfterRounds, "after {} rounds")
OPENFAB_MESSAGE(kFactorNotReached, "a safety factor of {:.4g} is not reached, {}: it is {:.4g}, and the weakest place is at ({:.4g}, {:.4g}, {:.4g}) mm")
OPENFAB_MESSAGE(kBoxChanged, "the part's box changed with the field: its displacement or shape reads it")
OPENFAB_MESSAGE(kBoxChangedHelp, "let the field act inside a mesh that stays as it is")
OPENFAB_MESSAGE(kFactorNotReachedHelp, "allow more, as `--limit 2`, `--reach 8mm` or `--rounds 40`, or let the fablet do more with the field")

// model/field_world
OPENFAB_MESSAGE(kFieldForOneObject, "{}: a field is for a single object that is placed once and not turned")
OPENFAB_MESSAGE(kFieldForOneObjectHelp, "make a world whose `build` is one object with a `translate_mm` of three numbers, or none")
OPENFAB_MESSAGE(kNoTexture, "{}: there is no texture `{}`")
OPENFAB_MESSAGE(kNoTextureHelp, "a fablet that can be made stronger reads an ImageTexture3D; name a volume of zeros for it in the world's `textures`, see docs/mechanics.md")

// model/materials
OPENFAB_MESSAGE(kGiveModulus, "give its Young's modulus in MPa, measured at the rate of use, and the source")
OPENFAB_MESSAGE(kNotAnObject, "`{}` is {}, not an object")
OPENFAB_MESSAGE(kMaterialWithout, "a material has no `{}`")
OPENFAB_MESSAGE(kChooseFrom, "choose from {}")
OPENFAB_MESSAGE(kMustBeText, "`{}` must be a text")
OPENFAB_MESSAGE(kMustBeNumber, "`{}` must be a number")
OPENFAB_MESSAGE(kPoissonOutside, "a Poisson's ratio of {}")
OPENFAB_MESSAGE(kPoissonOutsideHelp, "it must be from -0.999 to 0.4999; write 0.499 for what keeps its volume")
OPENFAB_MESSAGE(kNotAboveZero, "`{}` is {}, not above 0")
OPENFAB_MESSAGE(kNoModulus, "`{}` has no `E_MPa`")
OPENFAB_MESSAGE(kNoPoisson, "`{}` has no `nu`")
OPENFAB_MESSAGE(kNoPoissonHelp, "give its Poisson's ratio: 0.35 for most rigid resins, 0.48 for rubbery ones")
OPENFAB_MESSAGE(kMaterialUnknown, "{}: the material `{}` is missing; there are {}")
OPENFAB_MESSAGE(kMaterialUnknownHelp, "add \"{}\": {{\"E_MPa\": ..., \"nu\": ...}}")
OPENFAB_MESSAGE(kNoModulusIn, "{}: `{}` has no `E_MPa`")
OPENFAB_MESSAGE(kTableIncomplete, "a table of mixtures needs `materials` and `rows`")
OPENFAB_MESSAGE(kTableIncompleteHelp, "see docs/how-to/fields.md")
OPENFAB_MESSAGE(kTableUnit, "a table of moduli needs `\"unit\": \"MPa\"`")
OPENFAB_MESSAGE(kRowIncomplete, "a row needs a `mixture` of {} shares and a `value` above 0")
OPENFAB_MESSAGE(kDeviationNegative, "a standard deviation is 0 or more")
OPENFAB_MESSAGE(kTableScatters, "the specimens of the table scatter by up to {:.2g} % of their modulus (a standard deviation): what is computed from it is no surer")
OPENFAB_MESSAGE(kBothConditions, "`{}` has one `E_MPa` with both `T_C` and `rate_1_s`, or neither, or a list of rows that have them")
OPENFAB_MESSAGE(kOtherConditions, "{} was measured at {:g} C and {:.3g}/s, not at what is asked")
OPENFAB_MESSAGE(kOtherConditionsHelp, "give a list of rows with `T_C`, `rate_1_s` and `value` that reaches there, or ask for what was measured")
OPENFAB_MESSAGE(kSoftUnconditioned, "`E_MPa` of `{}` says neither temperature nor rate: soft resins are several times as stiff when cold or loaded quickly; `T_C` and `rate_1_s`, or a list of rows, say it")
OPENFAB_MESSAGE(kUnconditioned, "`E_MPa` of `{}` is one number, whatever temperature and rate are asked for")
OPENFAB_MESSAGE(kSharesNotOne, "the shares of a row do not add up to 1")
OPENFAB_MESSAGE(kTooFewRows, "a table needs two rows or more")
OPENFAB_MESSAGE(kNoMaterialsFile, "say what the materials are like with `--materials FILE.json`, see docs/mechanics.md")
OPENFAB_MESSAGE(kNoObject, "this is not an object")
OPENFAB_MESSAGE(kNoSuchLaw, "there is no law `{}`")
OPENFAB_MESSAGE(kKeyUnknown, "`{}` is unknown here, or of the wrong kind")
OPENFAB_MESSAGE(kKeyUnknownHelp, "there are `materials` (an object), `law` and `table` (texts)")
OPENFAB_MESSAGE(kNoMaterials, "there are no `materials`")
OPENFAB_MESSAGE(kLawTableMissing, "the law is `table`, but there is no `table`")

// model/mixture
OPENFAB_MESSAGE(kTableLacksMaterial, "the table of mixtures does not have the material `{}`; give its name there with `\"in_table\": \"{}\"`")

// model/print_world
OPENFAB_MESSAGE(kNoFablet, "{}: it has no fablet")
OPENFAB_MESSAGE(kNoMaterialUniform, "{}: the fablet `{}` takes no `Material`, so nothing tells what its cell is made of")
OPENFAB_MESSAGE(kNoMaterialUniformHelp, "give a world whose object uses it")
OPENFAB_MESSAGE(kNoObjectsIn, "{}: this world has no objects")
OPENFAB_MESSAGE(kNoObjectIn, "{}: there is no object `{}`")

// model/voxels
OPENFAB_MESSAGE(kNotThreeNumbersIn, "{}: `{}` is not there, or not three numbers")
OPENFAB_MESSAGE(kNotThreeNumbers, "{}: `{}` is not three numbers")
OPENFAB_MESSAGE(kBadPitch, "{}: a pitch of {} mm")
OPENFAB_MESSAGE(kNoMaterialsIn, "{}: there are no `materials`")
OPENFAB_MESSAGE(kNotOurArray, "{}: this is not an array of `openfab print`")
OPENFAB_MESSAGE(kArrayAxes, "{}: the array has {} axes")
OPENFAB_MESSAGE(kTooManyVoxels, "{}: {} voxels along an axis")
OPENFAB_MESSAGE(kTooManyVoxelsHelp, "choose coarser elements, as `--voxel 0.4mm`, of which there are fewer than {}")
OPENFAB_MESSAGE(kFractionsOfOthers, "{}: the array has fractions of {} materials, but {} names {}")
OPENFAB_MESSAGE(kFileBytes, "{}: the file has {} bytes, but its array takes {}")
OPENFAB_MESSAGE(kArrayEnds, "{}: the array ends at slice {}")
OPENFAB_MESSAGE(kCodeBeyond, "{}: a voxel has the material {} of {}")

// part/conduct
OPENFAB_MESSAGE(kNothingConducts, "there is nothing that conducts: the print is void")
OPENFAB_MESSAGE(kTakenForInsulators, "{:.3g} % of the elements conduct less than {:.0e} of what the best do, and count as insulators")
OPENFAB_MESSAGE(kNothingHeldHere, "nothing is held here: ")
OPENFAB_MESSAGE(kHeldInsulates, "what is held here conducts nothing")
OPENFAB_MESSAGE(kHeldInsulatesHelp, "choose faces where the conductor comes to the surface")
OPENFAB_MESSAGE(kTwoHoldsOfFlow, "two holds of the case `{}` keep the same face at {} and at {}")
OPENFAB_MESSAGE(kTwoHoldsTouch, "two holds of the case `{}`, at {} and at {}, touch at ({:.4g}, {:.4g}, {:.4g}) mm: elements there share an edge or a corner")
OPENFAB_MESSAGE(kFacesApart, "choose faces that do not touch")
OPENFAB_MESSAGE(kFlowEntersNothing, "the flow enters nothing: ")
OPENFAB_MESSAGE(kEntersInsulator, "the faces that the flow enters conduct nothing")
OPENFAB_MESSAGE(kFlowNotJoined, "what the flow enters is not joined to anything that is held")
OPENFAB_MESSAGE(kFlowNotJoinedHelp, "choose faces of the conductor that is held (elements are joined by faces, not by edges and corners), or finer elements, as `--voxel 0.1mm`")
OPENFAB_MESSAGE(kNoneHalfFull, "no element of that pitch is half full")
OPENFAB_MESSAGE(kFinerVoxel, "choose finer elements, as `--voxel 0.1mm`")
OPENFAB_MESSAGE(kNoPath, "nothing flows in the case `{}`: what conducts joins no two holds of different levels, so the resistance between them is infinite")
OPENFAB_MESSAGE(kNoPathHelp, "choose faces of one conductor (elements are joined by faces, not by edges and corners), or finer elements, as `--voxel 0.1mm`")
OPENFAB_MESSAGE(kHoldApart, "nothing flows at what is held{}: what conducts does not join it to another level, nor to a load")
OPENFAB_MESSAGE(kGapsCarryNothing, "{} elements between pieces that do not touch are less than half full and carry nothing: finer elements, as `--voxel 0.1mm`, show the gap")
OPENFAB_MESSAGE(kThinCarriesNothing, "{} elements that are less than half full touch no fuller one and carry nothing: finer elements, as `--voxel 0.1mm`, resolve what is so thin")
OPENFAB_MESSAGE(kCarriesNothing, "{} elements carry nothing, for they are joined to one level alone")
OPENFAB_MESSAGE(kConductorsLeftOut, "{} elements that conduct are not joined to anything that is held, and are left out")

// part/doubts
OPENFAB_MESSAGE(kMoreThanAnySolid, "`{}`: `{}` is {:.6g}, more than that of {}, {:.4g} {}: is it in another unit?")
OPENFAB_MESSAGE(kLessThanAnySolid, "`{}`: `{}` is {:.6g}, less than that of {}, {:.4g} {}: is it in another unit?")
OPENFAB_MESSAGE(kStrengthAsStiffness, "`{}`: a `strength_MPa` of {:.6g} is near its stiffness of {:.6g} MPa or above, and what is rigid breaks at a few hundredths of that: is it in another unit?")
OPENFAB_MESSAGE(kStrengthTiny, "`{}`: a `strength_MPa` of {:.6g} is very little for a stiffness of {:.6g} MPa: is one of them in another unit?")

// part/load_case
OPENFAB_MESSAGE(kKindsMixed, "`{}` and `{}` in one case")
OPENFAB_MESSAGE(kKindsMixedHelp, "a case is of forces, or of current (`volt`, `ampere`), or of heat (`celsius`, `watt`)")
OPENFAB_MESSAGE(kMustThreeNumbers, "`{}` must be three numbers, as in [0, 0, -10]")
OPENFAB_MESSAGE(kMustOneOf, "`{}` must be one of {}")
OPENFAB_MESSAGE(kUnknownHere, "`{}` is unknown here")
OPENFAB_MESSAGE(kMustObjectName, "`object` must be the name of an object")
OPENFAB_MESSAGE(kMustTwoCorners, "`box_mm` must be two corners, as in [[0, 0, 0], [10, 10, 2]]")
OPENFAB_MESSAGE(kLowerCornerFirst, "the first corner of a box must be its lower one")
OPENFAB_MESSAGE(kNoSuchObject, "there is no object `{}` in this world")
OPENFAB_MESSAGE(kBelowAbsoluteZero, "`celsius` is {:.6g}, below the absolute zero of -273.15")
OPENFAB_MESSAGE(kNoFacesChosen, "nothing says which faces these are")
OPENFAB_MESSAGE(kNoFacesChosenHelp, "choose them by {}")
OPENFAB_MESSAGE(kPlaneIncomplete, "a plane needs a `point_mm` and a `normal`")
OPENFAB_MESSAGE(kNormalWithoutLength, "the `normal` has no length")
OPENFAB_MESSAGE(kAtObject, " at object `{}`")
OPENFAB_MESSAGE(kOnSide, " on side {}")
OPENFAB_MESSAGE(kInBox, " in the box ({}) to ({}) mm")
OPENFAB_MESSAGE(kOnPlane, " on the plane through ({}) mm")
OPENFAB_MESSAGE(kFacing, " facing {}")
OPENFAB_MESSAGE(kHeldNoObject, "what is held must be an object, not {}")
OPENFAB_MESSAGE(kAlongAxes, "`along` must be letters of xyz: the axes that are held")
OPENFAB_MESSAGE(kLoadNoObject, "a load must be an object, not {}")
OPENFAB_MESSAGE(kLoadWithoutForce, "a load without a force")
OPENFAB_MESSAGE(kLoadWithoutForceHelp, "give `force_N`, `torque_Nmm` or `pressure_MPa`, or of current `ampere`, of heat `watt`; `move_mm` stands in `held`")
OPENFAB_MESSAGE(kHoldLacks, "what is held in a case of `{}` has no `{}`")
OPENFAB_MESSAGE(kNothingFlows, "nothing flows in the case `{}`")
OPENFAB_MESSAGE(kNothingFlowsHelp, "hold faces at another `{}`, too, or give `loads` of `{}`")
OPENFAB_MESSAGE(kCaseNoObject, "the case `{}` is {}, not an object")
OPENFAB_MESSAGE(kMustList, "`{}` must be a list")
OPENFAB_MESSAGE(kCaseLacks, "a case has no `{}`")
OPENFAB_MESSAGE(kCaseLacksHelp, "choose from held, loads, gravity_m_s2")
OPENFAB_MESSAGE(kNothingHeld, "nothing is held in the case `{}`")
OPENFAB_MESSAGE(kNothingHeldHelp, "a part that is not held flies away: name faces in `held`")
OPENFAB_MESSAGE(kNothingLoads, "nothing loads the part in the case `{}`")
OPENFAB_MESSAGE(kNothingLoadsHelp, "give `loads`, `gravity_m_s2`, or a `move_mm` of what is held")
OPENFAB_MESSAGE(kNoCases, "{}: there are no `cases` in it")
OPENFAB_MESSAGE(kNoCasesHelp, "say what is held and what loads the part, see docs/mechanics.md")
OPENFAB_MESSAGE(kChooseCase, "choose one by `--case NAME`: there are {}")
OPENFAB_MESSAGE(kNoSuchCase, "there is no case `{}`; there are {}")
OPENFAB_MESSAGE(kCaseOfOther, "the case `{}` is of {}")
OPENFAB_MESSAGE(kPartTakesIt, "`openfab mechanics part` takes it; a case of flows has `volt` or `celsius` in `held`")
OPENFAB_MESSAGE(kConductTakesIt, "`openfab mechanics conduct` takes it")

// part/loads
OPENFAB_MESSAGE(kTorqueOnLine, "a torque on faces that lie on one line")
OPENFAB_MESSAGE(kTorqueOnLineHelp, "choose more faces, or finer elements, as `--voxel 0.1mm`")

// part/part_problem
OPENFAB_MESSAGE(kPieceFromTo, "{} elements from ({:.5g}, {:.5g}, {:.5g}) to ({:.5g}, {:.5g}, {:.5g}) mm")
OPENFAB_MESSAGE(kThinWalls, "{:.3g} % of the material is in walls or struts thinner than about two elements of {:.4g} mm")
OPENFAB_MESSAGE(kGapsJoined, "{} elements of {:.4g} mm have a gap within them, the first at ({:.4g}, {:.4g}, {:.4g}) mm: what lies on its two sides counts as joined; a `--voxel` of half the gap shows it")
OPENFAB_MESSAGE(kNoneHalfFullBefore, "no element of that pitch is half full: ")
OPENFAB_MESSAGE(kThinWallsHelp, "choose finer elements, of a quarter of the thinnest wall or less, as `--voxel 0.1mm`; `--thin` takes them as they come")
OPENFAB_MESSAGE(kThinnestAt, ", the thinnest of {:.2g} at ({:.4g}, {:.4g}, {:.4g}) mm")
OPENFAB_MESSAGE(kRoughStiffness, ": their stiffness is rough, and their stresses are not resolved")
OPENFAB_MESSAGE(kPieceNotHeld, "the part is in {} pieces, and nothing holds the one of {}")
OPENFAB_MESSAGE(kPieceNotHeldHelp, "join them (faces count, edges and corners do not), hold it too, or leave it out by `--loose`")
OPENFAB_MESSAGE(kPiecesLeftOut, "{} that nothing holds {} left out, {:.2g} % of the part, the largest of {}")
OPENFAB_MESSAGE(kAPiece, "a piece")
OPENFAB_MESSAGE(kPiecesCount, "{} pieces")
OPENFAB_MESSAGE(kCaseLetsMove, "the case `{}` lets the part {}{}")
OPENFAB_MESSAGE(kThatIsPiece, ", that is its piece of ")
OPENFAB_MESSAGE(kHoldMoreFaces, "hold more faces, or along more axes")
OPENFAB_MESSAGE(kTwoHolds, "two holds of the case `{}` move the same face by {} mm and by {} mm along {}")
OPENFAB_MESSAGE(kHeldByTip, "what is held{} is the tip of what is round or pointed, {:.3g} mm2 here and less with finer elements: it gives way like a hinge, so that none are fine enough to settle what moves and when it buckles; hold more of it, as by `\"box_mm\"`")
OPENFAB_MESSAGE(kLoadOnNothing, "the load acts on nothing: ")
OPENFAB_MESSAGE(kLoadOnHeld, "the load{} acts only on what is held, and does nothing: load other faces")
OPENFAB_MESSAGE(kLoadPartlyOnHeld, "{:.0f} % of the load{} acts on what is held, and does nothing")
OPENFAB_MESSAGE(kLoadAboveStiffness, "the load{} presses with {:.4g} MPa, more than the part is stiff: is it in another unit? Pressures are in MPa, lengths in mm")
OPENFAB_MESSAGE(kGravityIsMm, "a `gravity_m_s2` of {:.6g} is a thousand times that of the earth: is it in mm/s2?")
OPENFAB_MESSAGE(kPrintVoid, "there is nothing to load: the print is void")

// part/pieces
OPENFAB_MESSAGE(kMoveFreely, "move freely: nothing holds it")
OPENFAB_MESSAGE(kSlideAlong, "slide along")
OPENFAB_MESSAGE(kTurnAbout, "turn about")

// part/surface
OPENFAB_MESSAGE(kNoFaceOf, "no face of the part is{}")
OPENFAB_MESSAGE(kNoFaceOfHelp, "the part reaches from ({:.6g}, {:.6g}, {:.6g}) to ({:.6g}, {:.6g}, {:.6g}) mm in the build; its faces are up to a voxel from where the mesh is")

}  // namespace openfab::mechanics::messages
