// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What is said of a damaged file by its reader, or by the jail that the reader was in.

#include <gmock/gmock.h>

#include "base/messages.h"
#include "tests/support/says/says.h"
#include "tools/texture/messages.h"

namespace openfab::tools {

inline ::testing::Matcher<std::string> SaysWhyNotRead() {
    using testing::Says;
    return ::testing::AnyOf(Says(messages::kCannotReadBefore),
                            Says(openfab::messages::kReaderCrashed, "*", "*", "*"),
                            Says(openfab::messages::kReaderTakesMemory, "*", "*"),
                            Says(openfab::messages::kReaderTakesLong, "*", "*"),
                            Says(openfab::messages::kReaderEnded, "*"));
}

}  // namespace openfab::tools
