// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Damages files as people, editors and disks do: bytes, numbers, texts, JSON values.

#include <random>
#include <string>

namespace openfab::testing {

/// Makes one to four random changes. `text` is false for binary files.
std::string mutate(std::string bytes, bool text, std::mt19937_64* random);

}  // namespace openfab::testing
