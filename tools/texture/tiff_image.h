// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// One page of a TIFF, read by libtiff. OpenImageIO reads TIFFs by libtiff, too, but reports neither a
// strip that is damaged or missing nor a compression that is not built in, and leaves out some layouts of
// 64-bit floats; here each strip and each tile is a number of bytes or an error.

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/input_file.h"
#include "base/result.h"

namespace openfab::tools {

/// What a page's directory says of it.
struct TiffDirectory {
    int32_t width = 0, height = 0, depth = 1;
    int samples = 1;
    int bits = 8;  ///< of a sample
    enum class Kind { kUnsigned, kSigned, kFloat } kind = Kind::kUnsigned;
    int photometric = 1, compression = 1, orientation = 1;
    bool separate = false;  ///< samples are planes
    int64_t rows = 0;       ///< of a strip or a tile
    bool reduced = false;   ///< a smaller copy of another page, or a mask of it
    std::string description;
    std::array<double, 2> resolution{};  ///< pixels per unit along x and y; 0: none
    int resolution_unit = 2;             ///< 1: none, 2: inch, 3: centimetre
    int64_t stk_planes = 0;              ///< MetaMorph's count of planes behind each other
    /// What makers of microscopes say of the whole file: Zeiss, Olympus, and of each page: Micro-Manager.
    std::string lsm, fluoview, micro_manager;
    std::string software;
    std::string no_data, scaling;  ///< what GDAL says of its numbers

    /// Returns whether samples are numbers, or light that is not stored as anything else.
    bool is_plain() const;
    /// Returns whether samples are red, green and blue.
    bool is_colour() const;
    /// Returns whether samples are indices into a table of colours.
    bool is_palette() const;
};

class TiffImage {
  public:
    /// What numbers of integer types become.
    enum class Scale {
        kVolume,   ///< unsigned ones of up to 16 bits 0 to 1, others as they are
        kPicture,  ///< -1 to 1, or 0 to 1
    };

    /// Opens the page whose directory is at `directory`. `file` outlives it; errors do not name it. Fails for
    /// what libtiff does not read, and for what takes more than half of the memory to decode.
    static Result<std::unique_ptr<TiffImage>> open(const InputFile& file, uint64_t directory,
                                                   int64_t memory_bytes);
    ~TiffImage();
    TiffImage(const TiffImage&) = delete;
    TiffImage& operator=(const TiffImage&) = delete;

    const TiffDirectory& directory() const { return about_; }
    /// Fails where a strip or a tile is missing, or lies outside of the file.
    Result<void> check_places() const;
    /// Decodes all strips or tiles. Fails where one is damaged.
    Result<void> check_chunks();

    /// Calls use(y, row) for each row of layer `z` from the top: interleaved samples. `shift`: bytes by which
    /// all strips lie farther back in the file than the directory says. Stops at the first error of `use`.
    using UseRow = std::function<Result<void>(int32_t y, const float* row)>;
    Result<void> each_row(int32_t z, Scale scale, int64_t shift, const UseRow& use);
    /// Returns where the only strip begins, or all strips that follow each other without a gap; negative
    /// where they do not.
    int64_t contiguous_begin() const;

    /// Returns whether an integer was read that a float does not hold.
    bool has_rounded() const { return rounded_; }

    struct Handle;  ///< the library's

  private:
    TiffImage(const InputFile& file, uint64_t directory);
    Result<void> read_directory(int64_t memory_bytes);
    Result<void> check_kind();
    /// Reads what microscopes write in tags of their own.
    void read_private();
    Result<void> read_chunk(uint32_t chunk, int64_t bytes);
    /// Whether the check sum behind the chunk that was read is right, where there is one.
    bool has_right_end(uint32_t chunk);
    Result<void> read_strips(int64_t y, Scale scale, float* band);
    Result<void> read_tiles(int32_t z, int64_t y, Scale scale, float* band);
    void convert(const uint8_t* row, int64_t pixels, Scale scale, int sample, float* out);
    Error trouble(const std::string& what, const char* help = "") const;

    std::unique_ptr<Handle> handle_;
    TiffDirectory about_;
    std::vector<uint8_t> bytes_;  ///< of a strip or a tile
    bool rounded_ = false;
};

}  // namespace openfab::tools
