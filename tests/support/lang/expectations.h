// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Expected diagnostics, written in the OpenFL file itself, under the line they are about:
//
//           float x = y;
//   //                ^ error: `y` is not declared here [unknown-name]
//   // help: did you mean `z`?
//
// The caret and its tail stand under the span; notes (`// note 3:7: text`) and help follow in
// order. A message whose span starts in column 1 or 2, where the `//` is, stands anywhere as
// `//@ 7:1+3 error: …`: line, column, width. The list is exhaustive: an extra message is a fault.

#include <string>
#include <vector>

#include "compiler/diag/sink.h"
#include "compiler/source/source_manager.h"

namespace openfab::testing {

/// Return the file's expected diagnostics and those in the sink in one form: `3:15+1 error: …
/// [id]`, `note 3:7: …`, `help: …`. Sorted by position; notes and help behind their message.
std::vector<std::string> expected_diagnostics(std::string_view text);
std::vector<std::string> actual_diagnostics(const diag::Sink& sink,
                                            const source::SourceManager& sources);

/// Returns an empty text if both lists are equal, else the lines that only one has.
std::string difference(const std::vector<std::string>& expected,
                       const std::vector<std::string>& actual);

/// Returns the text with its expectations replaced by the diagnostics in the sink. Line numbers in
/// notes converge in a second run.
std::string with_expectations(std::string_view text, const diag::Sink& sink,
                              const source::SourceManager& sources);

}  // namespace openfab::testing
