// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/diag/diagnostic.h"

#include <fmt/format.h>

#include "base/messages.h"
#include "base/near_miss.h"

namespace openfab::diag {

Diagnostic& Diagnostic::suggest(const source::Span& at, std::string_view word,
                                std::span<const std::string> names, std::string otherwise) {
    const std::string near = near_miss(word, names);
    if (!near.empty())
        return help(fmt::format(openfab::messages::kDidYouMean, near)).replace(at, near);
    return otherwise.empty() ? *this : help(std::move(otherwise));
}

}  // namespace openfab::diag
