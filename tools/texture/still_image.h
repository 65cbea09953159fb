// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Reads pictures row by row, by OpenImageIO, most TIFFs by libtiff, and JPEGs of inks by libjpeg. The reader is chosen by the file's signature, not by
// its name, and only among formats of still images: other readers of OpenImageIO open files that a
// playlist names. Those that are not hardened against untrusted files are read in a process of their own.

#include <OpenImageIO/imageio.h>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/input_file.h"
#include "base/result.h"
#include "tools/texture/file_color.h"
#include "tools/texture/jpeg_inks.h"
#include "tools/texture/tiff_image.h"
#include "tools/texture/tiff_pages.h"

namespace openfab::tools {

class StillImage {
  public:
    static constexpr int kMostPages = 2048;

    /// Reads the header of the first page; errors do not name the file. Fails for images that take
    /// more than half of the memory to decode; the other half is for libraries and for the result.
    /// `guarded`: this process may crash (guarded.h), so that formats with fragile readers are read,
    /// too.
    static Result<std::unique_ptr<StillImage>> open(const std::filesystem::path& file,
                                                    int64_t memory_bytes, bool guarded = false);

    /// Of an OpenEXR picture: of its display window, which is the picture's frame, and of the channels that are
    /// read of it. Of inks with a profile that says how they look, four channels; of others, what OpenImageIO
    /// makes of them.
    const OIIO::ImageSpec& spec() const { return spec_; }
    /// The names of its channels that are left out.
    const std::vector<std::string>& left_out() const { return left_out_; }
    /// Says what the numbers of the current page mean.
    FileColor color() const;
    /// Returns the number of pictures in the file; kMostPages + 1 where there are more.
    int pages();
    /// Whether there are more pictures than the first. Of a format whose pictures are not numbered there
    /// is no current page after it.
    bool has_more();
    /// After an error there is no current page.
    Result<void> go_to(int page);

    /// Calls use(y, row) for each row of the page from the top: interleaved floats, integers scaled
    /// to 0..1. Around the data of an OpenEXR picture there is 0. Stops at the first error of `use`.
    Result<void> each_row(const std::function<Result<void>(int y, const float* row)>& use);

  private:
    StillImage(InputFile file, int64_t memory_bytes)
        : file_(std::move(file)), memory_bytes_(memory_bytes) {}
    Result<void> open_input();
    Result<void> open_tiff();
    Result<void> open_jpeg();
    void read_inks();
    bool knows_inks() const;  ///< by their profile
    Result<void> fits() const;
    Result<void> frame();
    Result<void> each_stored_row(const std::function<Result<void>(int y, const float* row)>& use);
    int band_rows() const;
    Error not_opened() const;
    Error trouble(std::string reason) const;

    InputFile file_;
    int64_t memory_bytes_ = 0;
    std::string format_;
    bool bare_alpha_ = false;
    std::string shown_;                   ///< the file's name for people
    std::vector<uint64_t> page_offsets_;  ///< of the pages of a TIFF, once they were counted
    uint64_t page_directory_ = 0;  ///< of the page of a TIFF behind the first that is current
    std::unique_ptr<TiffPage> page_file_;  ///< of a page of a TIFF behind the first
    std::unique_ptr<TiffImage> tiff_;      ///< reads the pixels of a TIFF, where they are numbers
    std::unique_ptr<JpegInks> jpeg_;       ///< reads the pixels of a JPEG of inks, by its profile
    bool stores_inks_ = false;             ///< cyan, magenta, yellow and black
    bool reads_inks_ = false;              ///< as such, since their profile says how they look
    std::vector<char> bits_;               ///< of a PBM in digits
    std::unique_ptr<OIIO::Filesystem::IOMemReader> bits_file_;
    std::unique_ptr<OIIO::ImageInput> input_;
    OIIO::ImageSpec spec_;               ///< what is read of that of input_
    std::vector<int> picked_;            ///< its channels, where others are left out
    std::vector<std::string> left_out_;  ///< their names
    int subimage_ = 0;                   ///< of input_
};

}  // namespace openfab::tools
