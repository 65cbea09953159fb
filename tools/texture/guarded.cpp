// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/guarded.h"

#include <system_error>

#include "base/input_file.h"
#include "base/jail.h"
#include "base/say.h"

namespace openfab::tools {

Result<void> guarded(int64_t memory_bytes, const std::filesystem::path& file,
                     const std::function<Result<void>()>& make,
                     const std::filesystem::path& output) {
    if (inside_jail()) return make();
    JailLimits limits;
    limits.memory_bytes = memory_bytes;
    // Grids are made into voxels at any pitch, which takes what it takes.
    constexpr int64_t kMore = 60;
    limits.seconds = kMore * reading_seconds(file);
    limits.converts = true;
    std::error_code none;
    limits.writes = {std::filesystem::temp_directory_path(none)};
    if (!output.empty()) {
        // The deepest folder that is there: those below it are made.
        std::filesystem::path folder = without_links(output).parent_path();
        while (folder.has_relative_path() && !std::filesystem::is_directory(folder, none))
            folder = folder.parent_path();
        limits.writes.push_back(folder);
    }
    // What the child shows is written before it ends, and nothing twice.
    (void)written_out();
    const auto whole = [&]() -> Result<void> {
        Result<void> made = make();
        return made ? written_out() : made;
    };
    return run_in_jail(
        file, limits, whole, [](JailLine*) {}, [](JailLine*) { return true; });
}

void tell(const std::string& message) {
    note(message);
}

}  // namespace openfab::tools
