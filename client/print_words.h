// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What `openfab print --progress json` writes: reports, and words for people.

#include <optional>
#include <string>
#include <vector>

#include "base/json.h"
#include "base/result.h"

namespace openfab::client {

/// An error about a `--set`.
struct SettingError {
    std::string setting;  ///< `OBJECT.UNIFORM=VALUE`
    std::string text;
};

/// What a print has written for people.
struct PrintWords {
    std::string
        text;  ///< errors, warnings, notes and lines that are no JSON; ends with a line feed
    std::vector<SettingError> settings;  ///< errors that `text` does not have
    /// Returns all as text.
    std::string all() const;
};

/// Reads what a print has written; of one that went well, warnings and notes.
PrintWords words_of(const std::string& err, bool went_well);

/// Returns why a print with --progress json ended with `code`: the last error of what it has written. Before it prints,
/// `openfab print` compiles, and says what is wrong as text, which is relayed.
Error print_error(const std::string& err, int code);

/// The last report of --progress json that is whole.
std::optional<JsonValue> last_progress(const std::string& err);

}  // namespace openfab::client
