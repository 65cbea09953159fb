// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace openfab::testing {

/// A ZIP archive of names and contents; entries are deflated, but for the first.
std::string zip_archive(const std::vector<std::pair<std::string, std::string>>& files);

}  // namespace openfab::testing
