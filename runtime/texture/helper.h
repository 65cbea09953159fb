// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Runs the program that turns images into pyramids.

#include <filesystem>
#include <string>
#include <vector>

#include "runtime/base/result.h"
#include "runtime/texture/cache.h"

namespace openfab::texture {

/// `openfab texture IMAGE -o OUT --space …` with `more` arguments; makes OUT's folder. Errors: the
/// helper's own words, or why it could not run.
Result<void> make_with_helper(const std::filesystem::path& image, const ImageOptions& options,
                              const std::filesystem::path& out,
                              const std::vector<std::string>& more = {});

}  // namespace openfab::texture
