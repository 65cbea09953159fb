// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A folder of one PNG per slice, as front ends of PolyJet printers take them, with `manifest.json`
// and `HANDOFF.txt`.
//
// `slice_0001.png` is slice z = 0, the lowest; the numbers have as many digits as the whole grid
// needs, four at least. In a picture +x points right and +y up, so the top row is the largest y.
// Void has alpha 0, a material its key colour.

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "backends/common/output_lock.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::raster {

struct PngOptions {
    bool indexed = false;  ///< a palette of the key colours instead of RGBA
    bool flip_x = false;   ///< +x points left, for front ends that mirror
    bool front_end_makes_support = true;
    std::string handoff;  ///< the printer's own lines for HANDOFF.txt
};

/// Level of libdeflate. Measured on slices of 2362 x 827 voxels, CPU time of one core of a 2-core
/// AVX2 machine: 63 to 74 M voxels/s. A compressor of our own that looks for matches between pixels
/// instead of bytes reached 137 to 604 M voxels/s; it was left out, since compression is a
/// library's work and the rest of a print takes longer.
constexpr int kDeflateLevel = 1;

/// `slice_0001.png`; `slices` is the height of the whole grid.
std::string slice_file_name(int32_t z, int32_t slices);

/// Whether PngSink writes files of this name, or removes them from a folder that it fills.
bool is_folder_file(const std::string& name);

/// Texts of the two files beside the slices; `totals.complete` false marks a print that is not
/// whole.
std::string manifest_json(const backends::PrintInfo& info, const backends::PrintTotals& totals,
                          int32_t slices_written, const PngOptions& options);
std::string handoff_text(const backends::PrintInfo& info, const backends::PrintTotals& totals,
                         int32_t slices_written, const PngOptions& options);

/// The file of one slice, as PngSink writes it.
std::vector<uint8_t> encode_slice(const backends::SliceView& slice, const backends::PrintInfo& info,
                                  const PngOptions& options);

/// The packed rows of a slice from its file; empty where that is not one that encode_slice writes
/// of this print, or not whole.
std::vector<uint8_t> decode_slice(std::span<const uint8_t> file, const backends::PrintInfo& info,
                                  const PngOptions& options);

/// Why the print whose manifest is `text` cannot be resumed; empty where it can.
std::string manifest_difference(const std::string& text, const backends::PrintInfo& info,
                                const PngOptions& options);

class PngSink : public backends::SliceSink {
  public:
    /// Makes the folder, and the folders above it. Slices of an earlier print in it are replaced; a
    /// folder that holds something else is refused, so that nobody's files are lost or mixed with
    /// slices.
    static Result<std::unique_ptr<backends::SliceSink>> create(const std::filesystem::path& folder,
                                                               PngOptions options);
    /// Goes on with the slices that an earlier print has left in the folder; one without any is
    /// begun.
    static Result<std::unique_ptr<backends::SliceSink>> resume(const std::filesystem::path& folder,
                                                               PngOptions options);

    /// Of a folder that is resumed, the manifest is compared, and refused where it is not that
    /// of the same print.
    Result<void> begin(const backends::PrintInfo& info) override;
    Result<int32_t> take_up(const std::function<bool(const backends::SliceView&)>& show) override;
    std::vector<uint8_t> encode(const backends::SliceView& slice) const override;
    Result<void> commit(int32_t z, const std::vector<uint8_t>& bytes) override;
    Result<void> finish(const backends::PrintTotals& totals) override;

  private:
    PngSink(std::filesystem::path folder, PngOptions options, backends::FolderLock lock)
        : folder_(std::move(folder)), options_(std::move(options)), lock_(std::move(lock)) {}
    static Result<std::unique_ptr<backends::SliceSink>> open(const std::filesystem::path& folder,
                                                             PngOptions options, bool go_on);
    Result<std::vector<std::filesystem::path>> files() const;
    Result<void> remove(const std::vector<std::filesystem::path>& files) const;
    /// The error, with how much of the folder is of use, and how much room the rest takes.
    Error with_slices_kept(const Error& error, size_t slice_bytes) const;
    Result<void> write_notes(const backends::PrintTotals& totals);

    std::filesystem::path folder_;
    PngOptions options_;
    backends::PrintInfo info_;
    backends::FolderLock lock_;
    std::vector<std::filesystem::path> written_;
    bool earlier_ = false;  ///< an earlier print's slices are still to be looked at
    bool broken_ = false;
};

}  // namespace openfab::raster
