// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Runs the program that converts images to pyramids.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"
#include "texture/cache.h"

namespace openfab::texture {

/// Returns the pyramid of this key from the cache, or made by `openfab texture IMAGE -o OUT --space
/// …` with `more` arguments. Errors: the helper's own message, or why it could not run.
Result<std::shared_ptr<const Pyramid>> find_or_make(uint64_t key,
                                                    const std::filesystem::path& image,
                                                    const ImageOptions& options, WrapModes wrap,
                                                    int32_t filter, const ReadLimits& limits,
                                                    const std::vector<std::string>& more = {});

}  // namespace openfab::texture
