// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace openfab::job {

/// An option of a command line: its long name and its values, none for a flag.
struct OptionWords {
    std::string name;
    std::vector<std::string> values;
};

}  // namespace openfab::job
