// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Fablets as the compiler sees them: their diagnostics and their uniforms, by `openflc`.

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "base/json.h"
#include "base/result.h"

namespace openfab::client {

/// The largest source that is read or written.
constexpr int64_t kLargestSource = 2 << 20;

struct Diagnostic {
    std::filesystem::path file;
    std::string severity, message;
    int32_t line = 0, column = 0, end_line = 0, end_column = 0;  ///< one-based, in code points
    std::vector<std::string> help;
};

/// Runs `openflc`, from one thread at a time.
class FabletCompiler {
  public:
    /// `programs` is its folder; `scratch` one for its output.
    FabletCompiler(std::filesystem::path programs, std::filesystem::path scratch)
        : programs_(std::move(programs)), scratch_(std::move(scratch)) {}

    /// Checks a source.
    Result<std::vector<Diagnostic>> check(const std::filesystem::path& source) const;
    /// Checks a text that is not in `source`, but would be, with the modules beside it.
    Result<std::vector<Diagnostic>> check_text(const std::filesystem::path& source,
                                               const std::string& text) const;
    /// Returns what `openflc describe` says of each fablet of a source, by its name.
    Result<std::map<std::string, JsonValue>> describe(const std::filesystem::path& source) const;

  private:
    Result<JsonValue> run(const std::vector<std::string>& words, int* exit_code) const;

    std::filesystem::path programs_, scratch_;
};

/// Writes a text that would be in `source` to a folder, with the modules beside that. Returns its file.
Result<std::filesystem::path> put_source(const std::filesystem::path& folder,
                                         const std::filesystem::path& source,
                                         const std::string& text);

/// Whether any is an error.
bool has_errors(const std::vector<Diagnostic>& diagnostics);

}  // namespace openfab::client
