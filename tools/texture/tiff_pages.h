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

/// Finds the offsets of the pages' directories in order, at most `most`. Ends at the end of the
/// file, or at the first repeated one.
std::vector<uint64_t> tiff_pages(const InputFile& file, size_t most);

/// Presents the file with the directory at `directory` as its first.
class TiffPage final : public OIIO::Filesystem::IOProxy {
  public:
    /// `file` outlives it.
    TiffPage(const InputFile& file, uint64_t directory);

    const char* proxytype() const override { return "page"; }
    size_t read(void* to, size_t bytes) override;
    size_t pread(void* to, size_t bytes, int64_t at) override;
    size_t size() const override { return static_cast<size_t>(file_.bytes()); }

  private:
    const InputFile& file_;
    int64_t header_at_ = 0;            ///< position of the first directory's offset in the header
    std::vector<char> header_offset_;  ///< the replaced offset
};

}  // namespace openfab::tools
