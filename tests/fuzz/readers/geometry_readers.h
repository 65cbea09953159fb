// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Readers of geometry that is no mesh (readers.h).

#include <cstdlib>
#include <string_view>

#include "base/result.h"

namespace openfab::testing {

/// Results are values or user errors.
template <typename T>
bool answered(const Result<T>& result) {
    if (result) return true;
    if (result.error().code == ErrorCode::kInternal || result.error().text().empty()) std::abort();
    return false;
}

bool beams(std::string_view bytes);
bool beams_npz(std::string_view bytes);
bool lattices(std::string_view bytes);
bool answer(std::string_view bytes);
bool fields(std::string_view bytes);

}  // namespace openfab::testing
