// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The pages of a TIFF, each as a file of its own. For each page libtiff scans all directories
// before it, in quadratic time: 2,048 pages took half a minute.

#include <OpenImageIO/filesystem.h>

#include <array>
#include <cstdint>
#include <vector>

#include "base/input_file.h"

namespace openfab::tools {

/// Finds the offsets of the pages' directories in order, at most `most`. Ends at the first repeated one,
/// or, and then it sets `cut`, at one that lies outside of the file.
std::vector<uint64_t> tiff_pages(const InputFile& file, size_t most, bool* cut = nullptr);

/// Returns whether the page at this directory is a smaller copy of another, or its mask (NewSubfileType).
bool is_reduced_page(const InputFile& file, uint64_t directory);

/// What the file's header reads as, where the directory at `directory` is its first.
class TiffHeader {
  public:
    TiffHeader(const InputFile& file, uint64_t directory);
    /// Puts it into `bytes` bytes that were read at `at`.
    void put(int64_t at, size_t bytes, char* to) const;

  private:
    int64_t begin_ = 0;         ///< position of the first directory's offset
    std::vector<char> offset_;  ///< in place of it
};

/// Presents the file with the directory at `directory` as its first.
class TiffPage final : public OIIO::Filesystem::IOProxy {
  public:
    /// `file` outlives it.
    TiffPage(const InputFile& file, uint64_t directory)
        : IOProxy("", Read), file_(file), header_(file, directory) {}

    const char* proxytype() const override { return "page"; }
    size_t read(void* to, size_t bytes) override;
    size_t pread(void* to, size_t bytes, int64_t at) override;
    size_t size() const override { return static_cast<size_t>(file_.bytes()); }

  private:
    const InputFile& file_;
    TiffHeader header_;
};

}  // namespace openfab::tools
