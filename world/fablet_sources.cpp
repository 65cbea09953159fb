// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/fablet_sources.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

namespace openfab::world {

Result<std::vector<std::filesystem::path>> fablet_sources(const World& world,
                                                          const std::string& input) {
    std::vector<std::filesystem::path> files;
    for (const auto& [name, ref] : world.fablets) {
        std::error_code ignored;
        if (!std::filesystem::exists(ref.source, ignored)) {
            return error_at(ref.source_location,
                            fmt::format("the source `{}` of fablet `{}` does not exist",
                                        ref.source.string(), name),
                            "paths count from the world's folder");
        }
        if (std::find(files.begin(), files.end(), ref.source) == files.end())
            files.push_back(ref.source);
    }
    if (files.empty()) return user_error(fmt::format("{}: the world has no fablets", input));
    return files;
}

}  // namespace openfab::world
