// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads pictures row by row, by OpenImageIO. The reader is chosen by the file's signature, not by
// its name, and only among formats of still images: other readers of OpenImageIO open files that a
// playlist names, or are not hardened against untrusted files.

#include <OpenImageIO/imageio.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/input_file.h"
#include "base/result.h"
#include "tools/texture/tiff_pages.h"

namespace openfab::tools {

class StillImage {
  public:
    static constexpr int kMostPages = 2048;

    /// Reads the header of the first page; errors do not name the file. Fails for images that take
    /// more than half of the memory to decode; the other half is for libraries and for the result.
    static Result<std::unique_ptr<StillImage>> open(const std::filesystem::path& file,
                                                    int64_t memory_bytes);

    const OIIO::ImageSpec& spec() const { return input_->spec(); }
    /// Returns the number of pictures in the file; kMostPages + 1 where there are more.
    int pages();
    /// After an error there is no current page.
    Result<void> go_to(int page);

    /// Calls use(y, row) for each row of the page from the top: interleaved floats, integers scaled
    /// to 0..1. Stops at the first error of `use`.
    Result<void> each_row(const std::function<Result<void>(int y, const float* row)>& use);

  private:
    StillImage(InputFile file, int64_t memory_bytes)
        : file_(std::move(file)), memory_bytes_(memory_bytes) {}
    Result<void> open_input();
    Result<void> fits() const;
    int band_rows() const;
    Error trouble(std::string reason) const;

    InputFile file_;
    int64_t memory_bytes_ = 0;
    std::string format_;
    std::string shown_;                    ///< the file's name for people
    std::vector<uint64_t> page_offsets_;   ///< of the pages of a TIFF, once they were counted
    std::unique_ptr<TiffPage> page_file_;  ///< of a page of a TIFF behind the first
    std::unique_ptr<OIIO::ImageInput> input_;
    int subimage_ = 0;  ///< of input_
};

}  // namespace openfab::tools
