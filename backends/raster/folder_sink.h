// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Writes a folder of slices with `manifest.json` and `HANDOFF.txt`: one PNG each, as front ends of
// PolyJet printers take them, or a bitmap for each material, as print heads do. Beside them their digests
// (slice_digests.h).
//
// `slice_0001.png` is slice z = 0, the lowest. In a picture +x points right and +y up, so the top row
// is the largest y.

#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "backends/common/output_folder.h"
#include "backends/raster/slice_digests.h"
#include "backends/raster/slice_files.h"
#include "runtime/pipeline/slice_sink.h"

namespace openfab::raster {

/// Returns whether FolderSink writes files of this name, or removes them from its folder.
bool is_folder_file(const std::string& name);

/// Return the texts of the two files beside the slices; `totals.complete` false marks an incomplete
/// print. `digests`: of all files of the slices written, slice by slice.
std::string manifest_json(const pipeline::PrintInfo& info, const pipeline::PrintTotals& totals,
                          int32_t slices_written, const FolderOptions& options,
                          std::span<const Sha256Digest> digests = {});
std::string handoff_text(const pipeline::PrintInfo& info, const pipeline::PrintTotals& totals,
                         int32_t slices_written, const FolderOptions& options);

/// Returns why the print whose manifest is `text` cannot be resumed; empty where it can.
std::string manifest_difference(const std::string& text, const pipeline::PrintInfo& info,
                                const FolderOptions& options);

/// Returns whether the manifest `text` says that all of a print is there.
bool manifest_is_complete(const std::string& text);

/// Returns the hash of all slices that the manifest `text` gives; empty where it gives none.
std::string manifest_hash(const std::string& text);

class FolderSink : public pipeline::SliceSink {
  public:
    /// Creates the folder and those above it. Slices of an earlier print in it are replaced, all of
    /// them in `begin`; fails where the folder holds anything else, so that no files are lost or mixed
    /// with slices.
    static Result<std::unique_ptr<pipeline::SliceSink>> create(const std::filesystem::path& folder,
                                                               FolderOptions options);
    /// Reopens the folder of an interrupted print, to be resumed; starts one without slices. Kept are the
    /// first slices whose files have the seals that the print recorded of them.
    static Result<std::unique_ptr<pipeline::SliceSink>> reopen(const std::filesystem::path& folder,
                                                               FolderOptions options);

    /// For a folder that is resumed, fails where its manifest is not that of the same print.
    Result<void> begin(const pipeline::PrintInfo& info) override;
    /// Keeps no grey pictures, which do not tell the codes: `keep` does.
    Result<int32_t> resume(const std::function<bool(const pipeline::SliceView&)>& show) override;
    /// As `resume`, but shows no slices.
    Result<int32_t> keep();
    std::vector<uint8_t> encode(const pipeline::SliceView& slice) const override;
    Result<void> commit(int32_t z, std::vector<uint8_t> bytes) override;
    Result<void> finish(const pipeline::PrintTotals& totals) override;

  private:
    FolderSink(backends::OutputFolder folder, FolderOptions options)
        : folder_(std::move(folder)), options_(std::move(options)) {}
    static Result<std::unique_ptr<pipeline::SliceSink>> open(const std::filesystem::path& folder,
                                                             FolderOptions options, bool reopened);
    /// Returns the names of all files in the folder.
    Result<std::vector<std::string>> files() const;
    /// Clears the folder: what this print will write again is set aside (OutputFolder), all else is
    /// removed.
    Result<void> clear();
    /// Adds to an error how many slices are usable, and how much space the rest needs.
    Error with_resume_state(const Error& error, size_t slice_bytes) const;
    /// Writes the manifest and the hand-off; `end` with the digests of what was written.
    Result<void> write_notes(const pipeline::PrintTotals& totals, bool end);
    /// Fails where all slices of a complete print were kept and have another hash than it had; then none
    /// is kept the next time.
    Result<void> check_hash(const pipeline::PrintTotals& totals);
    Result<void> begin_digests();
    /// Reads what is recorded of an earlier run, whose manifest is given.
    Result<void> read_digests(const std::string& manifest);
    /// Reads the files of slice z of an earlier run, with their names and digests; false where one is missing
    /// or not what was recorded.
    struct KeptSlice {
        std::vector<std::string> names;
        std::vector<Sha256Digest> digests;
        std::vector<uint8_t> bytes;  ///< of all files
    };
    Result<bool> read_slice(int32_t z, KeptSlice* slice) const;
    Result<int32_t> keep_slices(
        const std::function<Result<bool>(int32_t z, const std::vector<uint8_t>& bytes)>& take);

    backends::OutputFolder folder_;
    FolderOptions options_;
    pipeline::PrintInfo info_;
    std::set<std::string> set_aside_;            ///< their names, without `.part`
    Sha256Digest identity_{};                    ///< of the print
    Digests earlier_seals_;                      ///< of its earlier run
    std::string earlier_hash_;                   ///< of all slices, if that came to its end
    std::optional<backends::GrowingFile> list_;  ///< SHA256SUMS.part, from `begin_digests` on
    std::vector<Sha256Digest> digests_;          ///< of the files of the slices written
    int32_t written_ = 0;                        ///< whole slices in the folder, from the first
    bool resumed_ = false;
    bool earlier_ = false;  ///< an earlier print's slices are still to be read
    bool broken_ = false;
    bool all_kept_ = false;
};

}  // namespace openfab::raster
