// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace openfab::testing {

/// All numbers and truths of a JSON file, by the keys and places that lead to them, such as `findings/0/measure`; none where
/// it is not one.
std::map<std::string, double> numbers_of(const std::filesystem::path& json);

}  // namespace openfab::testing
