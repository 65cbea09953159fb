// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Changes the text of a world, and leaves all else of it as somebody has written it: the only way in which tools make a
// world of another one.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/json.h"
#include "base/result.h"

namespace openfab::world {

class WorldEdit {
  public:
    /// `name` is for errors, here and of all changes. Fails where the text is no object of JSON.
    static Result<WorldEdit> of_text(std::string text, std::string name,
                                     int64_t memory_bytes = std::numeric_limits<int64_t>::max());
    static Result<WorldEdit> of_file(const std::filesystem::path& world,
                                     int64_t memory_bytes = std::numeric_limits<int64_t>::max());

    const std::string& text() const { return text_; }
    const JsonValue& tree() const { return tree_; }

    // Values are JSON. A failure changes nothing.

    /// Sets a uniform of an object.
    Result<void> set_uniform(std::string_view object, std::string_view uniform,
                             std::string_view value);
    /// Sets a member of an object, such as its `mesh`.
    Result<void> set_of_object(std::string_view object, std::string_view key,
                               std::string_view value);
    /// Sets a member of the world, such as `build`; a new one comes first.
    Result<void> set(std::string_view key, std::string_view value);
    /// Leaves out a member of the world, where it has it.
    Result<void> remove(std::string_view key);
    /// Sets what a path leads to, such as `build`, `0`, `scale`: names of members, numbers of items. What is missing of the
    /// members on the way is made.
    Result<void> set_at(std::span<const std::string> path, std::string_view value);
    /// Leaves out the member that a path leads to, where it is there.
    Result<void> remove_at(std::span<const std::string> path);
    /// Sets an entry of a section such as `meshes`, which is made where it is not there.
    Result<void> set_entry(std::string_view section, std::string_view key, std::string_view value);
    /// Gives another name to a uniform that an entry of `objects` or `fablets` binds; nothing changes where it binds none
    /// of this name.
    Result<void> rename_uniform(std::string_view section, std::string_view entry,
                                std::string_view from, std::string_view to);
    /// Lets paths, which count from the folder `from`, count from `to`: those that world_paths() names. Fails where a
    /// program is run in the world's folder.
    Result<void> relocate(const std::filesystem::path& from, const std::filesystem::path& to);
    /// Makes those paths absolute that count from the folder `from`.
    Result<void> make_absolute(const std::filesystem::path& from);
    /// Returns the files and folders that world_paths() names, as they are written.
    std::vector<std::filesystem::path> paths() const;

  private:
    /// What stands in the text from `begin` to `end` becomes `text`.
    struct Change {
        size_t begin = 0, end = 0;
        std::string text;
    };
    WorldEdit(std::string text, std::string name, int64_t memory_bytes)
        : name_(std::move(name)), memory_bytes_(memory_bytes), text_(std::move(text)) {}
    Result<void> parse();
    Result<void> apply(std::vector<Change> changes);
    size_t offset_of(int32_t line, int32_t column) const;
    Change first_member(const JsonValue& object, const std::string& member) const;
    Change value_of_member(const JsonValue& object, std::string_view key,
                           std::string_view value) const;
    Change without_member(const JsonValue& object, std::string_view key) const;
    Result<const JsonValue*> object_named(std::string_view object) const;
    std::vector<const JsonValue*> path_values() const;
    Result<void> rewrite_paths(
        const std::function<std::filesystem::path(const std::filesystem::path&)>& rewrite);

    std::string name_;
    int64_t memory_bytes_;
    std::string text_;
    JsonValue tree_;
    std::vector<size_t> lines_;  ///< where each begins
};

}  // namespace openfab::world
