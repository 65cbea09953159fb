// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of previews: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for. Tests name rows, so
// wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::preview::messages {

// preview
OPENFAB_MESSAGE(kNoSuchSlice, "`--preview {},view=slice:{}`: the print has the slices {} to {}")
OPENFAB_MESSAGE(kNoMemory, "no memory for the preview ")

// preview_spec
OPENFAB_MESSAGE(kNotAModelView, "`--preview`: `{}` is not a view; write `view=model:30:25` with a turn of -360 to 360 and a tilt of 5 to 90 degrees")
OPENFAB_MESSAGE(kNotASliceNumber, "`--preview`: `{}` is not a slice number; write `view=slice:12`")
OPENFAB_MESSAGE(kNoSuchView, "`--preview`: there is no view `{}`; choose from top, bottom, front, right, back, left, section, slice:N, model:TURN:TILT")
OPENFAB_MESSAGE(kNeedsName, "`--preview`: `{}` needs its name; write `--preview {}{}={}`")
OPENFAB_MESSAGE(kNotPng, "`--preview`: `{}` does not name a .png file; write `--preview card.png,view=bottom`")
OPENFAB_MESSAGE(kNoSuchCut, "`--preview`: there is no cut `{}`; choose from x, y, xy")
OPENFAB_MESSAGE(kNoSuchLight, "`--preview`: there is no light `{}`; choose from reflected, transmitted")
OPENFAB_MESSAGE(kNoSuchSetting, "`--preview`: there is no setting `{}`; choose from view, light, cut")
OPENFAB_MESSAGE(kCutWithoutModel, "`--preview`: a cut is of a view at an angle; write `view=model:30:30,cut=x`")
OPENFAB_MESSAGE(kLightWithoutSide, "`--preview`: light=transmitted goes with `view=top` or `view=bottom`")

}  // namespace openfab::preview::messages
