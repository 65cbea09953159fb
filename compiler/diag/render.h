// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Renders diagnostics as text with a caret under the source, or as JSON.

#include <string>

#include "compiler/diag/sink.h"
#include "compiler/source/source_manager.h"

namespace openfab::diag {

/// The numbers of errors and of warnings that are shown; the rest is only counted.
constexpr size_t kMaxShown = 20;

/// Renders all diagnostics, sorted by position:
///   postcard.fl:27:25: error: `distance` called in a surface stage [stage-mismatch]
///    27 |         return attr.n * distance(attr.p);
///       |                         ^~~~~~~~
///   postcard.fl:19:5: note: stage declared `@Surface` here
///   help: pass the value in as a varying
std::string render_text(const Sink& sink, const source::SourceManager& sources);

/// Renders `{"diagnostics":[{"id","severity","message","file","line","column","end_line","end_column","notes":[{"message","file",
/// "line","column"}],"help":[…],"fix":[{"file","line","column","end_line","end_column","text"}…]}…],
/// "errors":N,"warnings":N}` and a newline. Lines and columns as in the text form; an end is just
/// past the last character. The edits of a fix are applied together; there are none if it is not
/// clear what was meant.
std::string render_json(const Sink& sink, const source::SourceManager& sources);

}  // namespace openfab::diag
