// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/world_files.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/input_file.h"
#include "texture/volume.h"
#include "world/messages.h"

namespace openfab::world {
namespace {

namespace fs = std::filesystem;

}  // namespace

WorldFiles::WorldFiles(const fs::path& world, const FileRules& rules, JsonReader* json)
    : folder_(world.parent_path()), json_(*json) {
    roots_.push_back(reading_root(folder_));
    for (const fs::path& folder : rules.allowed)
        roots_.push_back(without_links(folder));
    files_.push_back(world);
}

bool WorldFiles::allowed(const fs::path& path) const {
    const fs::path resolved = without_links(path);
    return std::any_of(roots_.begin(), roots_.end(),
                       [&](const fs::path& root) { return is_below(resolved, root); });
}

void WorldFiles::check(const JsonValue& value, const std::string& what, const fs::path& path) {
    if (!json_.ok() || allowed(path)) return;
    json_.fail(
        value, fmt::format(messages::kNotBelowFolder, what, path.string()),
        fmt::format(messages::kNotBelowFolderHelp, without_links(path).parent_path().string()));
}

fs::path WorldFiles::path(const JsonValue& value, const std::string& what) {
    const std::string text = json_.string(value, what);
    if (json_.ok() && (text.empty() || text.find('\0') != std::string::npos))
        json_.fail(value, fmt::format(messages::kNotAFileName, what));
    fs::path path = folder_ / text;
    check(value, what, path);
    return path;
}

fs::path WorldFiles::existing(const JsonValue& value, const std::string& what, bool again) {
    fs::path path = this->path(value, what);
    std::error_code ignored;
    if (json_.ok() && !fs::is_regular_file(path, ignored)) {
        json_.fail(
            value,
            fmt::format("{} `{}` {}", what, path.string(),
                        fs::exists(path, ignored) ? messages::kNotAFile : messages::kDoesNotExist),
            messages::kPathsCountFromWorld);
    }
    if (again || known_.count(without_links(path)) == 0) add(value, path);
    return path;
}

/// Limits: a small world may name a large file many times, and folders of many files.
void WorldFiles::add(const JsonValue& value, const fs::path& file) {
    constexpr size_t kMostFiles = 200'000;
    constexpr double kMostAgain = 2e9;
    files_.push_back(file);
    if (files_.size() > kMostFiles)
        json_.fail(value, fmt::format(messages::kTooManyFiles, kMostFiles));
    if (!json_.ok() || known_.insert(without_links(file)).second) return;
    std::error_code unknown;
    const uintmax_t bytes = fs::file_size(file, unknown);
    read_again_bytes_ += unknown ? 0 : static_cast<double>(bytes);
    if (read_again_bytes_ > kMostAgain) {
        json_.fail(value, fmt::format(messages::kFilesReadAgain, file.filename().string()),
                   messages::kFilesReadAgainHelp);
    }
}

fs::path WorldFiles::images(const JsonValue& value, const std::string& what,
                            const texture::VolumeOptions& options) {
    fs::path path = this->path(value, what);
    std::error_code ignored;
    const bool listed = texture::is_medium_list(path);
    const bool many = listed || fs::is_directory(path, ignored) ||
                      path.filename().string().find_first_of("*#%") != std::string::npos;
    std::vector<fs::path> slices = {path};
    if (!json_.ok()) return path;
    if (!many || (!listed && fs::is_regular_file(path, ignored))) {
        existing(value, what);
    } else if (Result<std::vector<fs::path>> found = texture::volume_files(path)) {
        slices = std::move(*found);
        for (size_t i = 0; i < slices.size() && json_.ok(); ++i)
            also(value, slices[i]);
    } else {
        json_.fail(value, fmt::format(messages::kNoFileMatches, what, path.string()),
                   messages::kPathsCountFromWorld);
    }
    if (!json_.ok() || slices.size() > 1) return path;
    // A faulty header is reported when it is read.
    for (const fs::path& data : texture::detached_data(slices[0], options)) {
        if (json_.ok()) also(value, data);
    }
    return path;
}

void WorldFiles::words(const JsonValue& value, const std::vector<std::string>& command) {
    for (const std::string& word : command) {
        const fs::path path = folder_ / word;
        std::error_code ignored;
        if (json_.ok() && !word.empty() && fs::is_regular_file(path, ignored) && allowed(path))
            add(value, path);
    }
}

void WorldFiles::also(const JsonValue& value, const fs::path& file) {
    check(value, fmt::format("its file `{}`", file.filename().string()), file);
    add(value, file);
}

}  // namespace openfab::world
