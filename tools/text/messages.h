// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What texts and fonts say: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for. Tests name rows, so
// wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::text::messages {

// font
OPENFAB_MESSAGE(kNoStyle, "`{}` is not a style of a font")
OPENFAB_MESSAGE(kNoStyleHelp, "styles are words such as `bold`, `italic`, `light`, `condensed`")
OPENFAB_MESSAGE(kNoFontFamily, "this system has no font family `{}`")
OPENFAB_MESSAGE(kNoFontFamilyHelp, "`{}` is the nearest; `fc-list : family` lists all, and a font file will do, too")
OPENFAB_MESSAGE(kNoFontFile, "there is no font file `{}`")
OPENFAB_MESSAGE(kNotAFontName, "`{}` is not a font's name")
OPENFAB_MESSAGE(kNotAFontNameHelp, "write a name, for example `DejaVu Sans:bold`, or a file")
OPENFAB_MESSAGE(kNoFontFor, "this system has no font for `{}`; give a font file")
OPENFAB_MESSAGE(kVariableFont, "`{}` is a variable font, drawn at {}; `--font FILE:{}=VALUE` sets it")
OPENFAB_MESSAGE(kNoSetting, "`{}` is not a setting of the font `{}`")
OPENFAB_MESSAGE(kNotVariable, "it is not a variable font")
OPENFAB_MESSAGE(kFontSettings, "it has ")
OPENFAB_MESSAGE(kFontHasNo, "the font `{}` has no `{}`")
OPENFAB_MESSAGE(kChooseAnotherFont, "choose another with `--font FILE.ttf`")
OPENFAB_MESSAGE(kCannotReadFont, "cannot read the font `{}`")
OPENFAB_MESSAGE(kNotAFont, "`{}` is not a font")
OPENFAB_MESSAGE(kNotAFontHelp, "OpenType, TrueType and collections of them are read")
OPENFAB_MESSAGE(kNoOutlines, "the font `{}` has no outlines")

// main
OPENFAB_MESSAGE(kNotBetween, "`{} {}` is not between {} and 1000 mm")
OPENFAB_MESSAGE(kNoOutput, "write `-o FILE.obj` for a mesh, or `-o FILE.png` for a picture")

// text_shapes
OPENFAB_MESSAGE(kNotUtf8, "the text is not UTF-8")
OPENFAB_MESSAGE(kNoLetters, "the text has no letters")
OPENFAB_MESSAGE(kTooManyCorners, "the text has {} corners; a mesh of at most {} is made")
OPENFAB_MESSAGE(kTooManyCornersHelp, "write it in parts, or as a picture (`-o FILE.png`)")
OPENFAB_MESSAGE(kCannotBeDrawnOut, "a letter of this font cannot be extruded: ")
OPENFAB_MESSAGE(kChooseAnotherFontWith, "choose another with `--font FILE.ttf`")
OPENFAB_MESSAGE(kPictureTooLarge, "the picture has {:.0f} x {:.0f} pixels; at most {} along a side are drawn")
OPENFAB_MESSAGE(kPictureTooLargeHelp, "choose a lower one, as `--dpi 150`")
OPENFAB_MESSAGE(kCannotBeDrawn, "a letter of this font cannot be drawn")
OPENFAB_MESSAGE(kOutOfMemory, "out of memory")

}  // namespace openfab::text::messages
