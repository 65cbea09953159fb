// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/fablet_sources.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "world/messages.h"

namespace openfab::world {

Result<std::vector<std::filesystem::path>> fablet_sources(const World& world,
                                                          const std::string& input) {
    std::vector<std::filesystem::path> files;
    for (const auto& [name, ref] : world.fablets) {
        std::error_code ignored;
        if (!std::filesystem::exists(ref.source, ignored)) {
            return error_at(ref.source_location,
                            fmt::format(messages::kNoSuchSource, ref.source.string(), name),
                            messages::kPathsCountFromWorld);
        }
        if (std::find(files.begin(), files.end(), ref.source) == files.end())
            files.push_back(ref.source);
    }
    if (files.empty()) return user_error(fmt::format(messages::kNoFablets, input));
    return files;
}

}  // namespace openfab::world
