// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A print that is kept: its world is read once, and material is summed up for any values of its uniforms. Meshes, trees
// and textures stay; other values of what only the volume stage reads are written in place. Where a surface or a geometry
// depends on them, or they name another texture or material, the parts are bound and set up again.

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "abi/fablet_table.h"
#include "base/result.h"
#include "program/options.h"
#include "program/prepare.h"
#include "runtime/part/uniforms.h"
#include "runtime/pipeline/print_job.h"
#include "world/printer.h"
#include "world/world.h"

namespace openfab::program {

/// A number of mixtures, such as a measured property, whose mean is asked.
struct SumMeasure {
    std::vector<size_t>
        materials;  ///< it counts what is of these; indices among those of the print
    /// Of shares of these that sum up to 1; called from several threads.
    std::function<double(std::span<const double> shares)> of;
    double lowest = 0, highest = 1;  ///< of its values
};

/// Voxels that are summed up: those whose centres lie in the box, or all.
struct SumRegion {
    std::optional<Box3d> box_mm{};  ///< of build space
    std::shared_ptr<const SumMeasure> measure{};
};

/// Millilitres in a region by material of the print: without the void, with the support.
struct RegionSums {
    std::vector<double> mixed_ml;    ///< of mixtures, before the dither; support is not among them
    std::vector<double> printed_ml;  ///< of dithered voxels; empty where they were not asked for
    /// Means of the measure, of printed voxels by the mixture of 8 x 8 x 8 of them; 0 where there is nothing.
    double mixed_mean = 0, printed_mean = 0;
};

/// Millilitres of mixtures in a region by material, and their derivatives.
struct RegionRates {
    std::vector<double> mixed_ml;
    std::vector<double> change_ml;  ///< [column][material]
};

/// The voxels that sums are of.
enum class SumPitch {
    kCoarse,  ///< about kCoarseSumVoxels of the print's shape; the printer's own where it has no more
    kPrinter,  ///< those that are printed
};
constexpr double kCoarseSumVoxels = 1e6;

class KeptPrint {
  public:
    /// Reads the world and sets its print up. The fablets and the flag must outlive it.
    /// With `rates`, which names columns of derivatives (find_rates), the fablets have some.
    using RatesOf = std::function<Result<pipeline::Rates>(const Job& job)>;
    static Result<std::unique_ptr<KeptPrint>> create(const Options& options,
                                                     const openfab_fablet_list& fablets,
                                                     const std::atomic<bool>& interrupt,
                                                     const RatesOf& rates = {});
    ~KeptPrint();

    /// Sums up with other values of uniforms, `OBJECT.UNIFORM=VALUE`, for each region. The same values give the same
    /// bits, whatever was asked before, for any number of threads.
    Result<std::vector<RegionSums>> sums(const std::vector<std::string>& settings,
                                         std::span<const SumRegion> regions, SumPitch pitch,
                                         bool printed);

    /// Sums up mixtures, as `sums` does, and their derivatives, each times the scale of its column.
    Result<std::vector<RegionRates>> rates(const std::vector<std::string>& settings,
                                           std::span<const SumRegion> regions, SumPitch pitch,
                                           std::span<const double> scales);

    const world::World& world() const { return world_; }
    const world::Printer& printer() const { return printer_; }
    /// Returns the print with the values of the last sums of that pitch.
    const pipeline::PrintInfo& info(SumPitch pitch) const;
    /// Returns how often parts were bound and set up again.
    int64_t set_up_again() const { return set_up_again_; }

  private:
    class MixtureSums;
    /// A print at one pitch.
    struct Kept {
        pipeline::PrintInput input;
        pipeline::PrintOptions options;
        std::vector<part::BoundUniforms> bound;  ///< of its parts
        pipeline::PrintInfo info;
        std::unique_ptr<pipeline::PrintJob> job;  ///< null after its set-up failed
    };
    KeptPrint(const Options& options, const openfab_fablet_list& fablets,
              const std::atomic<bool>& interrupt);
    Result<void> bind(const std::vector<std::string>& settings, Kept* kept);
    Result<void> run(const std::vector<std::string>& settings, Kept* kept,
                     pipeline::SliceSink* sink);
    Kept& at(SumPitch pitch);

    const Options options_;
    const openfab_fablet_list& fablets_;
    const std::atomic<bool>& interrupt_;
    std::unique_ptr<MixtureSums> mixtures_;
    world::World world_;
    world::Printer printer_;
    std::vector<std::unique_ptr<process::Effect>> effects_;
    Kept printer_kept_;
    std::optional<Kept> coarse_;  ///< nothing where it is the printer's
    int64_t set_up_again_ = 0;
};

}  // namespace openfab::program
