// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The only place where input files are opened, whether named by the user, by a world, or by a file
// that a world names. Only regular files are opened: a pipe may block, a device never ends. Where
// the name does not come from the user, the file must also lie below allowed folders once links are
// resolved.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"

namespace openfab {

/// A file of this name makes its folder a project: files in it and below may name all of it.
constexpr const char* kProjectFile = "openfab.project";

/// Returns an absolute path without links and dots; its last parts need not exist.
std::filesystem::path without_links(const std::filesystem::path& path);

/// Returns whether a path is a folder or lies below it; both as returned by without_links.
bool is_below(const std::filesystem::path& path, const std::filesystem::path& folder);

/// Returns the folder below which a file in `folder` may name others: the nearest enclosing
/// project, else `folder` itself; without links. Empty means the working folder.
std::filesystem::path reading_root(const std::filesystem::path& folder);

/// Returns the name in a form that no program takes for an option or a response file.
std::string as_argument(const std::filesystem::path& path);

class InputFile {
  public:
    /// Opens a file below one of `roots`, folders as returned by without_links; no roots: anywhere.
    /// Errors hold the reason alone, without the file's name: kUserInput where the file does not
    /// exist, is not a regular file or lies elsewhere, kOutside where the system refuses.
    static Result<InputFile> open(const std::filesystem::path& file,
                                  const std::vector<std::filesystem::path>& roots = {});
    ~InputFile();
    InputFile(InputFile&& other) noexcept;
    InputFile& operator=(InputFile&& other) noexcept;
    InputFile(const InputFile&) = delete;
    InputFile& operator=(const InputFile&) = delete;

    int descriptor() const { return descriptor_; }
    /// Returns the size when it was opened.
    int64_t bytes() const { return bytes_; }
    /// Returns a path by which libraries open this very file, even if it is renamed.
    std::string name() const;

    /// Reads up to `bytes` at offset `at`; fewer only where the file ends.
    Result<size_t> read(int64_t at, void* to, size_t bytes) const;
    /// Reads the whole file; more than `most` bytes are a user error.
    Result<std::string> read_all(int64_t most) const;

  private:
    InputFile(int descriptor, int64_t bytes) : descriptor_(descriptor), bytes_(bytes) {}

    int descriptor_ = -1;
    int64_t bytes_ = 0;
};

}  // namespace openfab
