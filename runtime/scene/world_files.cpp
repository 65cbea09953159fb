// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/scene/world_files.h"

#include <fmt/format.h>

#include <algorithm>

#include "runtime/texture/volume.h"

namespace openfab::scene {
namespace {

namespace fs = std::filesystem;

/// Without links and dots, also where its end does not exist.
fs::path plain(const fs::path& path) {
    std::error_code status;
    const fs::path absolute = fs::absolute(path, status);
    fs::path out = fs::weakly_canonical(absolute, status);
    return status ? absolute.lexically_normal() : out;
}

/// The world's folder, or the nearest one above that is a project.
fs::path root_of(const fs::path& folder) {
    const fs::path own = plain(folder.empty() ? "." : folder);
    std::error_code ignored;
    for (fs::path at = own;; at = at.parent_path()) {
        if (fs::is_regular_file(at / kProjectFile, ignored)) return at;
        if (at == at.parent_path()) return own;
    }
}

bool is_below(const fs::path& path, const fs::path& root) {
    return std::mismatch(root.begin(), root.end(), path.begin(), path.end()).first == root.end();
}

}  // namespace

WorldFiles::WorldFiles(const fs::path& world, const FileRules& rules, JsonReader* json)
    : folder_(world.parent_path()), json_(*json) {
    roots_.push_back(root_of(folder_));
    for (const fs::path& folder : rules.allowed)
        roots_.push_back(plain(folder));
    files_.push_back(world);
}

bool WorldFiles::allowed(const fs::path& path) const {
    const fs::path place = plain(path);
    return std::any_of(roots_.begin(), roots_.end(),
                       [&](const fs::path& root) { return is_below(place, root); });
}

void WorldFiles::check(const JsonValue& value, const std::string& what, const fs::path& path) {
    if (!json_.ok() || allowed(path)) return;
    json_.fail(value, fmt::format("{} is `{}`, which is not below the world's folder; put it "
                                  "there, or allow it with `--allow {}`",
                                  what, path.string(), plain(path).parent_path().string()));
}

fs::path WorldFiles::path(const JsonValue& value, const std::string& what) {
    const std::string text = json_.string(value, what);
    if (json_.ok() && (text.empty() || text.find('\0') != std::string::npos))
        json_.fail(value, fmt::format("{} is no file name", what));
    const fs::path path = folder_ / text;
    check(value, what, path);
    return path;
}

fs::path WorldFiles::existing(const JsonValue& value, const std::string& what) {
    fs::path path = this->path(value, what);
    std::error_code ignored;
    if (json_.ok() && !fs::is_regular_file(path, ignored)) {
        json_.fail(
            value,
            fmt::format("{} `{}` {}; paths count from the world's folder", what, path.string(),
                        fs::exists(path, ignored) ? "is not a file" : "does not exist"));
    }
    files_.push_back(path);
    return path;
}

fs::path WorldFiles::images(const JsonValue& value, const std::string& what) {
    const fs::path path = this->path(value, what);
    std::error_code ignored;
    const bool many = fs::is_directory(path, ignored) ||
                      path.filename().string().find_first_of("*#%") != std::string::npos;
    if (!json_.ok() || !many || fs::is_regular_file(path, ignored)) return existing(value, what);
    const Result<std::vector<fs::path>> slices = texture::volume_files(path);
    if (!slices) {
        json_.fail(value, fmt::format("{} `{}` names no file; paths count from the world's folder",
                                      what, path.string()));
        return path;
    }
    for (const fs::path& slice : *slices)
        also(value, slice);
    return path;
}

void WorldFiles::also(const JsonValue& value, const fs::path& file) {
    check(value, fmt::format("`{}`, which it reads,", file.filename().string()), file);
    files_.push_back(file);
}

}  // namespace openfab::scene
