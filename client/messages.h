// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of programs that others run: OPENFAB_MESSAGE(name, "text"), by file, each remedy behind what it is for. Tests
// name rows, so wording is changed here alone.

#include "base/message.h"

// clang-format off
namespace openfab::client::messages {

// child
OPENFAB_MESSAGE(kNoRoomForWords, "`{}` cannot be written: {}; free some of it, or set TMPDIR")
OPENFAB_MESSAGE(kCannotStart, "cannot start `{}`: {}")
OPENFAB_MESSAGE(kProgramEndedWith, "it ended with {}, without a word")

// fablet_compiler
OPENFAB_MESSAGE(kCompilerEnded, "openflc ended with {}")
OPENFAB_MESSAGE(kCannotWrite, "cannot write `{}`")

}  // namespace openfab::client::messages
