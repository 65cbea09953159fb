// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The one door through which files are opened that a user, a world, or a file that a world names
// asks for. What comes through is a regular file: a pipe would keep us waiting, a device never
// ends. Where the name was written by somebody else than the user, the file must also lie below
// folders that are allowed, once links are resolved.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "base/result.h"

namespace openfab {

/// A file of this name makes its folder a project: files in it and below may name all of it.
constexpr const char* kProjectFile = "openfab.project";

/// Absolute, without links and dots, also where its end does not exist.
std::filesystem::path without_links(const std::filesystem::path& path);

/// Whether a path is a folder or something below it; both as of without_links.
bool is_below(const std::filesystem::path& path, const std::filesystem::path& folder);

/// The folder below which a file in `folder` may name others: the nearest one upwards that is a
/// project, else `folder` itself; without links. Empty names the working folder.
std::filesystem::path reading_root(const std::filesystem::path& folder);

/// A name for the command line of a program, which no program takes for an option or for a list
/// of more arguments.
std::string as_argument(const std::filesystem::path& path);

class InputFile {
  public:
    /// `roots` are folders as of without_links, one of which the opened file must be below; none:
    /// it may be anywhere. Errors hold the reason alone, without the file's name: kUserInput for
    /// what is not there, no regular file, or elsewhere, kOutside for what the system refuses.
    static Result<InputFile> open(const std::filesystem::path& file,
                                  const std::vector<std::filesystem::path>& roots = {});
    ~InputFile();
    InputFile(InputFile&& other) noexcept;
    InputFile& operator=(InputFile&& other) noexcept;
    InputFile(const InputFile&) = delete;
    InputFile& operator=(const InputFile&) = delete;

    int descriptor() const { return descriptor_; }
    /// Its size when it was opened.
    int64_t bytes() const { return bytes_; }
    /// A name under which libraries open this very file, whatever becomes of its own name.
    std::string name() const;

    /// Reads up to `bytes` from place `at`; fewer only where the file ends.
    Result<size_t> read(int64_t at, void* to, size_t bytes) const;
    /// The whole file. A larger one than `most` bytes is a user's error.
    Result<std::string> read_all(int64_t most) const;

  private:
    InputFile(int descriptor, int64_t bytes) : descriptor_(descriptor), bytes_(bytes) {}

    int descriptor_ = -1;
    int64_t bytes_ = 0;
};

}  // namespace openfab
