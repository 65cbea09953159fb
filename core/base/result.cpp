// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/result.h"

#include <fmt/format.h>

namespace openfab {

std::string SourceLocation::str() const {
    return line > 0 ? fmt::format("{}:{}:{}", file, line, column) : file;
}

std::string Error::text() const {
    return fmt::format("{}{}{}{}{}", location.str(), location.file.empty() ? "" : ": ", message,
                       help.empty() ? "" : "; ", help);
}

Error error_at(SourceLocation location, std::string what, std::string help) {
    return {ErrorCode::kUserInput, std::move(what), std::move(help), std::move(location)};
}

Error Complaint::at(SourceLocation location) const {
    return error_at(std::move(location), what, help);
}

Error with_context(const Error& error, const std::string& before) {
    const std::string inner = Error{error.code, error.message, {}, error.location}.text();
    return {error.code, before + inner, error.help, {}};
}

}  // namespace openfab
