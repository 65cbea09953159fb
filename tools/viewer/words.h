// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What `openfab print --progress json` writes: reports, and words for people.

#include <optional>
#include <string>

#include "base/json.h"

namespace openfab::viewer {

/// What a print has written for people: all lines but those of --progress json, or of one that went
/// well the warnings alone.
std::string words_of(const std::string& err, bool went_well);

/// The last report of --progress json that is whole.
std::optional<JsonValue> last_progress(const std::string& err);

}  // namespace openfab::viewer
