// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// The pages of a TIFF, each as a file of its own. libtiff goes through all directories before the
// one that is asked for, and through all of these for each of them: 2,048 pages took half a minute.

#include <OpenImageIO/filesystem.h>

#include <array>
#include <cstdint>
#include <vector>

#include "base/input_file.h"

namespace openfab::tools {

/// Finds where the directories of the pages lie, in their order, `most` at most. They end where the
/// file does, or where one comes a second time.
std::vector<uint64_t> tiff_pages(const InputFile& file, size_t most);

/// The file, but for its header, which says that the directory at `place` is the first.
class TiffPage final : public OIIO::Filesystem::IOProxy {
  public:
    /// `file` outlives it.
    TiffPage(const InputFile& file, uint64_t place);

    const char* proxytype() const override { return "page"; }
    size_t read(void* to, size_t bytes) override;
    size_t pread(void* to, size_t bytes, int64_t at) override;
    size_t size() const override { return static_cast<size_t>(file_.bytes()); }

  private:
    const InputFile& file_;
    int64_t header_at_ = 0;           ///< where the header has the place of the first directory
    std::vector<char> header_place_;  ///< what it has there
};

}  // namespace openfab::tools
