// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace openfab::testing {

/// Makes a ZIP archive of names and contents; all entries but the first are deflated.
std::string zip_archive(const std::vector<std::pair<std::string, std::string>>& files);

}  // namespace openfab::testing
