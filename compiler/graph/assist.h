// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What somebody who types wants to know of a text that no editor has opened: the language server's answers about it.

#include <filesystem>
#include <string>

#include "base/json.h"
#include "base/json_text.h"
#include "base/result.h"
#include "compiler/server/analysis.h"

namespace openfab::graph {

/// Writes the answer to `action`: {"ask": "complete", "hover", "signature" or "format", "line", "character"}, from 0, in
/// UTF-16; what the answer is, the protocol of language servers says.
Result<void> assist(const server::Analysis& analysis, const std::filesystem::path& path,
                    const std::string& text, const JsonValue& action, JsonText* out);

}  // namespace openfab::graph
