// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Means of the fractions over parts of each voxel, from a second print without slices at the pitch of
// the parts: the printer's own where the print's is coarser, or an N-th of it with
// `--fractions-supersample N`.

#include <atomic>
#include <string>

#include "abi/fablet_table.h"
#include "backends/common/format.h"
#include "backends/job/record.h"
#include "program/options.h"
#include "program/progress.h"
#include "runtime/pipeline/fraction_sink.h"
#include "world/printer.h"

namespace openfab::program {

/// What the second print takes from the first: its grid and, at the end, its totals.
class CoarsePrint : public pipeline::FractionSink {
  public:
    Result<void> begin(const pipeline::PrintInfo& info, int32_t materials) override {
        info_ = info;
        materials_ = materials;
        return {};
    }
    void write(int32_t, int32_t, int32_t, std::span<const float>) override {}
    Result<void> status() const override { return {}; }
    Result<void> finish(const pipeline::PrintTotals& totals) override {
        totals_ = totals;
        return {};
    }

    const pipeline::PrintInfo& info() const { return info_; }
    const pipeline::PrintTotals& totals() const { return totals_; }
    /// Returns the number of the parts' materials, which are the first.
    int32_t materials() const { return materials_; }

  private:
    pipeline::PrintInfo info_;
    int32_t materials_ = 0;
    pipeline::PrintTotals totals_;
};

/// Returns how many parts along each axis the fractions of a voxel of `pitch_mm` are the means of: 1 where it
/// is its centre's mixture.
Vec3i fraction_parts(const Options& options, const Vec3d& pitch_mm, const Vec3d& printer_pitch_mm);

/// Returns a note where these are fewer than the printer's voxels; else nothing.
std::string describe_parts(const Vec3i& parts, const Options& options, const Vec3d& pitch_mm,
                           const Vec3d& printer_pitch_mm);

/// Returns the options of a print of nothing but fractions, of so many parts a voxel of `coarse`.
Options options_of_parts(const Options& options, const pipeline::PrintInfo& coarse,
                         const Vec3i& parts);

/// Returns the box of the slices of a print.
Box3d box_of_slices(const pipeline::PrintInfo& info);

/// Returns the memory that the means take for each column of the finer print and each material.
int64_t bytes_of_means(const Options& options, const Vec3i& parts);

/// Returns how many parts along each axis the grey pictures are the means of.
Vec3i grey_parts(const Options& options);

/// Writes the grey pictures of `options.output`, in the format `format`, as write_supersampled does an array; `record`, which may
/// be null, tells the story.
Result<void> write_grey(const CoarsePrint& coarse, const backends::Format& format,
                        const world::Printer& printer, const Options& options,
                        const openfab_fablet_list& fablets, const std::atomic<bool>& interrupt,
                        Progress* progress, job::Record* record);

/// Writes `options.fractions_file`, as the print `coarse`, with the same options, has left it to do.
Result<void> write_supersampled(const CoarsePrint& coarse, const Vec3i& parts,
                                const Options& options, const openfab_fablet_list& fablets,
                                const std::atomic<bool>& interrupt, Progress* progress);

}  // namespace openfab::program
