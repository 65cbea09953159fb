// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Damage done to files, as people, editors and disks do it: bytes, numbers, texts, values of JSON.

#include <random>
#include <string>

namespace openfab::testing {

/// One to four changes, by what `random` gives. `text` is false where only bytes mean anything.
std::string mutate(std::string bytes, bool text, std::mt19937_64* random);

}  // namespace openfab::testing
