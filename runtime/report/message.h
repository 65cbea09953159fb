// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Errors as people read them:
//
//     card.fab.json:12:5: error: unknown key `meshs`
//      12 |     "meshs": {
//         |     ^

#include <string>

#include "runtime/base/result.h"

namespace openfab::report {

/// The text of an error, with its line and a caret where the message starts with
/// `file:line:column:` and the file can be read. Ends with a line break.
std::string format_error(const Error& error);
/// `warning: …`, likewise.
std::string format_warning(const std::string& message);

}  // namespace openfab::report
