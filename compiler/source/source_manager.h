// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Owns the text of every source file of a compilation and turns byte offsets into lines and
// columns.

#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "compiler/source/span.h"

namespace openfab::source {

/// A position as shown to users: both count from 1, a column is a code point (a byte that is not
/// UTF-8 counts as one).
struct Location {
    uint32_t line = 1;
    uint32_t column = 1;
};

class SourceManager {
  public:
    /// The largest file: spans are 32-bit.
    static constexpr size_t kMaxFileBytes = 16u << 20;

    /// Adds a file's text under a name for messages; the number is for Span::file and is never 0.
    /// `folder` is the file's folder, for files beside it; empty if the text is not from a file.
    uint32_t add(std::string name, std::string text, std::filesystem::path folder = {});
    /// Makes `load` take a text in place of what the file of this absolute path holds: an editor's, not saved yet.
    void replace(const std::filesystem::path& path, std::string text);
    /// Reads a file. Returns nothing, with a message in `fault`, if it cannot be read, is too
    /// large, or is not below one of the `roots` (base/input_file.h).
    std::optional<uint32_t> load(const std::filesystem::path& path, std::string* fault,
                                 const std::vector<std::filesystem::path>& roots = {});

    /// Views live as long as the manager.
    std::string_view text(uint32_t file) const;
    std::string_view text(const Span& span) const;
    std::string_view name(uint32_t file) const;
    /// Returns every file that was read, in order.
    std::vector<std::filesystem::path> files() const;
    /// Returns the file's folder; empty if the text did not come from a file.
    std::filesystem::path folder(uint32_t file) const;
    Location locate(uint32_t file, uint32_t offset) const;
    /// Returns the text of a line (from 1) without its end.
    std::string_view line_text(uint32_t file, uint32_t line) const;

  private:
    struct File {
        std::string name;
        std::string text;
        std::filesystem::path folder;
        std::vector<uint32_t> line_starts;
    };
    const File* file(uint32_t number) const;
    uint32_t line_of(const File& file, uint32_t offset) const;

    std::vector<std::unique_ptr<File>> files_;
    std::map<std::filesystem::path, std::string> replaced_;
};

/// Returns the bytes of the code point at text[at]: 1 to 4; 1 for a byte that is not valid UTF-8.
size_t code_point_bytes(std::string_view text, size_t at);

/// Returns the number of code points in `text`.
uint32_t count_code_points(std::string_view text);

}  // namespace openfab::source
