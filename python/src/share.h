// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A print that several processes make: each prints ranges of slabs, and encodes their slices for
// the output; one writes them, in order, without encoding them again.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "base/result.h"
#include "program/options.h"
#include "program/prepare.h"
#include "python/src/program.h"
#include "runtime/pipeline/print_job.h"
#include "world/printer.h"

namespace openfab::python {

/// Neighbouring slabs, printed.
struct Share {
    std::vector<uint8_t> bytes;    ///< of its slices, encoded, one after the other
    std::vector<int64_t> lengths;  ///< of each slice
    pipeline::PrintTotals totals;
    double seconds = 0;
    double processor_seconds = 0;  ///< of the whole process meanwhile
    /// The JSON of `--stats`; times and counters of work are those of all shares so far.
    std::string statistics;
};

/// A print that is set up once, for any number of shares. Not for several threads at once.
class SharePrinter {
  public:
    /// The options have no output; slices are encoded for one of `format`.
    static Result<std::shared_ptr<SharePrinter>> create(std::shared_ptr<const Program> program,
                                                        const program::Options& options,
                                                        const std::string& format);

    const pipeline::PrintInfo& info() const { return ready_.print->info(); }
    /// Returns the slabs of the print: [x, y).
    Vec2<int32_t> slabs() const { return ready_.print->slabs(); }
    int64_t memory_bytes() const { return ready_.print->estimate().memory_bytes; }
    /// Return what a print says before its first slice.
    const std::vector<std::string>& warnings() const { return warnings_; }
    const std::string& part_sizes() const { return sizes_; }
    /// Prints the slabs [first, end).
    Result<Share> print(int32_t first, int32_t end);

  private:
    SharePrinter(std::shared_ptr<const Program> program) : program_(std::move(program)) {}

    const std::shared_ptr<const Program> program_;
    const std::atomic<bool> interrupt_{false};
    program::PreparedPrint ready_;
    std::unique_ptr<pipeline::SliceSink> encoder_;
    std::vector<std::string> warnings_;
    std::string sizes_;
};

/// Writes the slices of shares, in order, to the output of a print.
class ShareWriter {
  public:
    struct Settings {
        program::Options options;                   ///< of the print, with its output
        std::string output;                         ///< if not empty, written in place of it
        std::string printer;                        ///< name or file; empty: what the header says
        std::vector<uint8_t> header;                ///< of an .ofr file of the whole print
        int32_t support_code = 0;                   ///< see PrintInfo; headers lack it
        std::vector<std::filesystem::path> inputs;  ///< files that it must not overwrite
    };
    static Result<std::shared_ptr<ShareWriter>> create(const Settings& settings);
    /// Closes the output as one of a print that ended early, unless it was finished.
    ~ShareWriter();
    ShareWriter(const ShareWriter&) = delete;
    ShareWriter& operator=(const ShareWriter&) = delete;

    const pipeline::PrintInfo& info() const { return info_; }
    /// Returns the first slice that was not written.
    int32_t next_slice() const { return next_; }
    /// Writes the slices from next_slice() on. Waits while the output does.
    Result<void> write(std::span<const uint8_t> bytes, std::span<const int64_t> lengths,
                       const pipeline::PrintTotals& totals);
    /// Completes the output, if all slices are there.
    Result<void> finish();
    /// Returns the JSON of `--stats`, without what the processes did that printed the shares.
    std::string statistics() const;

  private:
    ShareWriter() = default;
    bool is_complete() const { return next_ == info_.slice_end; }

    pipeline::PrintInfo info_;
    std::unique_ptr<pipeline::SliceSink> sink_;
    pipeline::PrintTotals totals_;
    int32_t next_ = 0;
    int64_t bytes_ = 0;
    world::Printer printer_;
    bool finished_ = false;
};

/// Returns the format that a print with this output has, whose printer is given by name or file.
Result<std::string> output_format(const program::Options& options, const std::string& printer);

/// Returns the files that a print with these options reads, fablets aside, the world first. Reads
/// the world with its meshes.
Result<std::vector<std::filesystem::path>> world_files(const program::Options& options);

/// Returns the file and the name of the dither rule that the world of a print names.
Result<std::optional<std::pair<std::string, std::string>>> world_dither(
    const program::Options& options);

/// Returns the header of an .ofr file of a print.
std::vector<uint8_t> header_of(const pipeline::PrintInfo& info);

}  // namespace openfab::python
