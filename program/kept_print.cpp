// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/kept_print.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <utility>

#include "backends/common/tee_sink.h"
#include "runtime/part/bind.h"

namespace openfab::program {

namespace {

/// Fractions are whole numbers of these.
constexpr float kFractionSteps = 65535;

/// Sums of whole numbers, by region and material: the same in any order of threads.
class Counts {
  public:
    void begin(size_t regions, size_t materials) {
        materials_ = materials;
        counts_ = std::vector<std::atomic<int64_t>>(regions * materials);
    }
    void add(size_t region, std::span<const int64_t> counts) {
        for (size_t m = 0; m < materials_; ++m) {
            if (counts[m] != 0)
                counts_[region * materials_ + m].fetch_add(counts[m], std::memory_order_relaxed);
        }
    }
    std::vector<double> scaled(size_t region, double by) const {
        std::vector<double> out;
        for (size_t m = 0; m < materials_; ++m)
            out.push_back(static_cast<double>(counts_[region * materials_ + m].load()) * by);
        return out;
    }

  private:
    size_t materials_ = 0;
    std::vector<std::atomic<int64_t>> counts_;
};

/// Sums of a measure: the weight, and that times the measure in whole steps of its range.
class Means {
  public:
    void begin(size_t regions) { sums_.begin(regions, 2); }
    /// Returns the measure of amounts, all materials', in steps; and how much of its materials they hold.
    static std::array<int64_t, 2> steps_of(const SumMeasure& measure,
                                           std::span<const int64_t> amounts) {
        int64_t weight = 0;
        for (const size_t m : measure.materials)
            weight += amounts[m];
        if (weight == 0) return {0, 0};
        std::vector<double> shares;
        for (const size_t m : measure.materials)
            shares.push_back(static_cast<double>(amounts[m]) / static_cast<double>(weight));
        const double range = measure.highest - measure.lowest;
        const double part = range > 0 ? (measure.of(shares) - measure.lowest) / range : 0;
        return {weight, std::llround(std::clamp(part, 0.0, 1.0) * kMeasureSteps)};
    }
    void add(size_t region, const std::array<int64_t, 2>& weighted) { sums_.add(region, weighted); }
    double of(size_t region, const SumMeasure* measure) const {
        const std::vector<double> sums = sums_.scaled(region, 1);
        if (measure == nullptr || sums[0] == 0) return 0;
        return measure->lowest +
               (measure->highest - measure->lowest) * sums[1] / sums[0] / kMeasureSteps;
    }

  private:
    static constexpr double kMeasureSteps = 65536;
    Counts sums_;
};

/// Returns the voxels of the grid whose centres lie in a region, hi exclusive.
Box3i voxels_of(const SumRegion& region, const pipeline::PrintInfo& info) {
    Box3i out{{0, 0, 0}, info.size};
    if (!region.box_mm) return out;
    for (int axis = 0; axis < 3; ++axis) {
        const auto first = [&](double mm) {
            const double voxel = (mm - info.origin_mm[axis]) / info.pitch_mm[axis] - 0.5;
            return static_cast<int32_t>(
                std::clamp(std::ceil(voxel), 0.0, static_cast<double>(info.size[axis])));
        };
        out.lo[axis] = first(region.box_mm->lo[axis]);
        out.hi[axis] = std::max(out.lo[axis], first(region.box_mm->hi[axis]));
    }
    return out;
}

std::vector<Box3i> voxels_of(std::span<const SumRegion> regions, const pipeline::PrintInfo& info) {
    std::vector<Box3i> out;
    for (const SumRegion& region : regions)
        out.push_back(voxels_of(region, info));
    return out;
}

bool has_row(const Box3i& box, int32_t y, int32_t z) {
    return z >= box.lo.z && z < box.hi.z && y >= box.lo.y && y < box.hi.y;
}

/// Counts the codes of printed voxels.
class PrintedSums final : public pipeline::SliceSink {
  public:
    explicit PrintedSums(std::span<const SumRegion> regions)
        : regions_(regions.begin(), regions.end()) {}
    Result<void> begin(const pipeline::PrintInfo& info) override {
        bits_ = info.bits;
        boxes_ = voxels_of(regions_, info);
        counts_.begin(boxes_.size(), info.materials.size() + 1);
        means_.begin(boxes_.size());
        info_ = info;
        return {};
    }
    std::vector<uint8_t> encode(const pipeline::SliceView& slice) const override {
        std::vector<uint8_t> codes(static_cast<size_t>(slice.width));
        std::vector<std::vector<int64_t>> sums(boxes_.size());
        for (std::vector<int64_t>& sum : sums)
            sum.assign(size_t{1} << bits_, 0);
        for (int32_t y = 0; y < slice.height; ++y) {
            backends::unpack_row(slice, y, bits_, codes.data());
            for (size_t r = 0; r < boxes_.size(); ++r) {
                if (!has_row(boxes_[r], y, slice.z)) continue;
                for (int32_t x = boxes_[r].lo.x; x < boxes_[r].hi.x; ++x)
                    ++sums[r][codes[static_cast<size_t>(x)]];
            }
        }
        for (size_t r = 0; r < boxes_.size(); ++r) {
            counts_.add(r, sums[r]);
            if (regions_[r].measure != nullptr) add_to_blocks(r, slice);
        }
        return {};
    }
    Result<void> commit(int32_t /*z*/, std::vector<uint8_t> /*bytes*/) override { return {}; }
    Result<void> finish(const pipeline::PrintTotals& /*totals*/) override { return {}; }

    /// By material, without the void.
    std::vector<double> ml(size_t region, double voxel_ml) const {
        std::vector<double> out = counts_.scaled(region, voxel_ml);
        out.erase(out.begin());
        return out;
    }
    double mean(size_t region) const { return means_.of(region, regions_[region].measure.get()); }

  private:
    /// What 8 x 8 x 8 voxels hold, of those of 8 slices, by row, column and material.
    struct Blocks {
        int32_t slices = 0;  ///< that it has
        std::vector<int64_t> amounts;
    };

    void add_to_blocks(size_t region, const pipeline::SliceView& slice) const {
        const auto columns = static_cast<size_t>((slice.width + 7) / 8);
        const size_t materials = info_.materials.size();
        std::vector<int64_t> amounts(columns * static_cast<size_t>((slice.height + 7) / 8) *
                                     materials);
        std::vector<uint8_t> codes(static_cast<size_t>(slice.width));
        const Box3i& box = boxes_[region];
        for (int32_t y = box.lo.y; y < box.hi.y && has_row(box, y, slice.z); ++y) {
            backends::unpack_row(slice, y, bits_, codes.data());
            for (int32_t x = box.lo.x; x < box.hi.x; ++x) {
                const uint8_t code = codes[static_cast<size_t>(x)];
                const size_t block =
                    static_cast<size_t>(y / 8) * columns + static_cast<size_t>(x / 8);
                if (code != 0 && code != info_.support_code)
                    ++amounts[block * materials + code - 1U];
            }
        }
        const int32_t slab = slice.z / 8;
        const std::lock_guard lock(mutex_);
        Blocks& blocks = blocks_[{region, slab}];
        blocks.amounts.resize(amounts.size());
        for (size_t k = 0; k < amounts.size(); ++k)
            blocks.amounts[k] += amounts[k];
        const int32_t all =
            std::min(8 * slab + 8, info_.slice_end) - std::max(8 * slab, info_.slice_begin);
        if (++blocks.slices < all) return;
        for (size_t at = 0; at < amounts.size(); at += materials) {
            const auto [weight, steps] =
                Means::steps_of(*regions_[region].measure,
                                std::span<const int64_t>(blocks.amounts).subspan(at, materials));
            means_.add(region, {weight, weight * steps});
        }
        blocks_.erase({region, slab});
    }

    const std::vector<SumRegion> regions_;
    std::vector<Box3i> boxes_;
    int32_t bits_ = 8;
    pipeline::PrintInfo info_;
    mutable Counts counts_;
    mutable Means means_;
    mutable std::mutex mutex_;
    mutable std::map<std::pair<size_t, int32_t>, Blocks> blocks_;
};

double voxel_ml(const pipeline::PrintInfo& info) {
    return info.pitch_mm.x * info.pitch_mm.y * info.pitch_mm.z * 1e-3;
}

/// Whether values of uniforms are all that may differ.
bool differ_in_values(const part::BoundUniforms& a, const part::BoundUniforms& b) {
    return a.textures == b.textures && a.texture_is_volume == b.texture_is_volume &&
           a.objects == b.objects && a.slot_material == b.slot_material;
}

}  // namespace

class KeptPrint::MixtureSums final : public pipeline::FractionSink {
  public:
    /// `scales` are those of columns of derivatives; none: there are none.
    void ask(std::span<const SumRegion> regions, std::span<const double> scales = {}) {
        regions_.assign(regions.begin(), regions.end());
        scales_.assign(scales.begin(), scales.end());
    }
    Result<void> begin(const pipeline::PrintInfo& info, int32_t materials) override {
        boxes_ = voxels_of(regions_, info);
        fractions_ = static_cast<size_t>(materials);
        materials_ = info.materials.size();
        counts_.begin(boxes_.size(), materials_);
        rates_.begin(boxes_.size(), fractions_ * scales_.size());
        means_.begin(boxes_.size());
        return {};
    }
    void write_rates(int32_t z, int32_t y, int32_t first_x, std::span<const float> rates) override {
        const size_t numbers = fractions_ * scales_.size();
        const auto end = first_x + static_cast<int32_t>(rates.size() / numbers);
        std::vector<double> sums(numbers);
        std::vector<int64_t> steps(numbers);
        for (size_t r = 0; r < boxes_.size(); ++r) {
            if (!has_row(boxes_[r], y, z)) continue;
            std::ranges::fill(sums, 0.0);
            const int32_t last = std::min(end, boxes_[r].hi.x);
            for (int32_t x = std::max(first_x, boxes_[r].lo.x); x < last; ++x) {
                const float* of = &rates[static_cast<size_t>(x - first_x) * numbers];
                for (size_t k = 0; k < numbers; ++k)
                    sums[k] += double{of[k]};
            }
            for (size_t k = 0; k < numbers; ++k) {
                const double sum = sums[k] * scales_[k / fractions_];
                steps[k] = std::llround(std::clamp(sum, -kMostOfRow, kMostOfRow) * kRateSteps);
            }
            rates_.add(r, steps);
        }
    }
    void write(int32_t z, int32_t y, int32_t first_x, std::span<const float> fractions) override {
        const auto end = first_x + static_cast<int32_t>(fractions.size() / fractions_);
        for (size_t r = 0; r < boxes_.size(); ++r) {
            if (!has_row(boxes_[r], y, z)) continue;
            const SumMeasure* measure = regions_[r].measure.get();
            std::array<int64_t, 256> sums{}, one{}, before{};
            std::array<int64_t, 2> mean{}, measured{};
            const int32_t last = std::min(end, boxes_[r].hi.x);
            for (int32_t x = std::max(first_x, boxes_[r].lo.x); x < last; ++x) {
                const float* of = &fractions[static_cast<size_t>(x - first_x) * fractions_];
                for (size_t m = 0; m < fractions_; ++m) {
                    one[m] = static_cast<int64_t>(of[m] * kFractionSteps + 0.5f);
                    sums[m] += one[m];
                }
                if (measure == nullptr) continue;
                if (one != before) measured = Means::steps_of(*measure, one);
                before = one;
                mean[0] += measured[0];
                mean[1] += measured[0] * measured[1];
            }
            counts_.add(r, std::span(sums).first(materials_));
            if (measure != nullptr) means_.add(r, mean);
        }
    }
    Result<void> status() const override { return {}; }
    Result<void> finish(const pipeline::PrintTotals& /*totals*/) override { return {}; }

    std::vector<double> ml(size_t region, double voxel_ml) const {
        return counts_.scaled(region, voxel_ml / double{kFractionSteps});
    }
    double mean(size_t region) const { return means_.of(region, regions_[region].measure.get()); }
    /// By column and material of the print.
    std::vector<double> change_ml(size_t region, double voxel_ml) const {
        const std::vector<double> of = rates_.scaled(region, voxel_ml / kRateSteps);
        std::vector<double> out(scales_.size() * materials_);
        for (size_t k = 0; k < of.size(); ++k)
            out[k / fractions_ * materials_ + k % fractions_] = of[k];
        return out;
    }

  private:
    /// Sums of rows are whole numbers of these, so that all sums of theirs are the same in any order of threads.
    static constexpr double kRateSteps = 0x1p24, kMostOfRow = 0x1p20;
    std::vector<SumRegion> regions_;
    std::vector<double> scales_;
    std::vector<Box3i> boxes_;
    size_t materials_ = 0;
    size_t fractions_ = 1;  ///< of these: those but a support of its own
    Counts counts_, rates_;
    Means means_;
};

KeptPrint::KeptPrint(const Options& options, const openfab_fablet_list& fablets,
                     const std::atomic<bool>& interrupt)
    : options_(options),
      fablets_(fablets),
      interrupt_(interrupt),
      mixtures_(std::make_unique<MixtureSums>()) {}

KeptPrint::~KeptPrint() = default;

Result<std::unique_ptr<KeptPrint>> KeptPrint::create(const Options& options,
                                                     const openfab_fablet_list& fablets,
                                                     const std::atomic<bool>& interrupt,
                                                     const RatesOf& rates) {
    std::unique_ptr<KeptPrint> out(new KeptPrint(options, fablets, interrupt));
    Result<PreparedPrint> ready = prepare_print(options, fablets,
                                                {.interrupt = interrupt,
                                                 .fractions = out->mixtures_.get(),
                                                 .rates = rates,
                                                 .world = &out->world_});
    if (!ready) return ready.error();
    Result<std::vector<part::BoundUniforms>> bound =
        part::bind_values(out->world_, fablets, {options.settings, options.memory_bytes});
    if (!bound) return bound.error();
    out->printer_ = std::move(ready->job.printer);
    out->effects_ = std::move(ready->job.effects);
    out->printer_kept_ = {std::move(ready->job.input), std::move(ready->options), std::move(*bound),
                          ready->print->info(), std::move(ready->print)};
    const pipeline::PrintJob& job = *out->printer_kept_.job;
    const double coarser =
        std::cbrt(static_cast<double>(job.estimate().voxels_total) / kCoarseSumVoxels);
    if (coarser <= 1) return out;
    Kept& coarse = out->coarse_.emplace();
    const pipeline::PrintInfo& info = job.info();
    coarse.input = out->printer_kept_.input;
    coarse.options = out->printer_kept_.options;
    coarse.input.pitch_mm = coarse.input.pitch_mm * coarser;
    if (info.slice_end - info.slice_begin < info.size.z) {
        coarse.options.slices.reset();
        coarse.options.z_range_mm =
            Vec2<double>{info.slice_begin * info.pitch_mm.z, info.slice_end * info.pitch_mm.z};
    }
    coarse.bound = out->printer_kept_.bound;
    Result<std::unique_ptr<pipeline::PrintJob>> made =
        pipeline::PrintJob::create(coarse.input, coarse.options);
    if (!made) return made.error();
    coarse.job = std::move(*made);
    coarse.info = coarse.job->info();
    return out;
}

KeptPrint::Kept& KeptPrint::at(SumPitch pitch) {
    return pitch == SumPitch::kCoarse && coarse_ ? *coarse_ : printer_kept_;
}

const pipeline::PrintInfo& KeptPrint::info(SumPitch pitch) const {
    return (pitch == SumPitch::kCoarse && coarse_ ? *coarse_ : printer_kept_).info;
}

Result<void> KeptPrint::bind(const std::vector<std::string>& settings, Kept* kept) {
    // The last setting of a uniform counts.
    part::BindOptions options{options_.settings, options_.memory_bytes};
    options.sets.insert(options.sets.end(), settings.begin(), settings.end());
    Result<std::vector<part::BoundUniforms>> bound = part::bind_values(world_, fablets_, options);
    if (!bound) return bound.error();
    bool in_place =
        kept->job != nullptr && std::ranges::equal(*bound, kept->bound, differ_in_values);
    for (size_t i = 0; in_place && i < bound->size(); ++i)
        in_place = kept->job->set_uniforms(i, (*bound)[i].values);
    if (!in_place) {
        ++set_up_again_;
        Result<std::vector<part::Part>> parts = part::bind(world_, fablets_, options);
        if (!parts) return parts.error();
        kept->input.parts = std::move(*parts);
        kept->job.reset();  // its memory counts otherwise
        Result<std::unique_ptr<pipeline::PrintJob>> made =
            pipeline::PrintJob::create(kept->input, kept->options);
        kept->bound.clear();
        if (!made) return made.error();
        kept->job = std::move(*made);
        kept->info = kept->job->info();
    }
    kept->bound = std::move(*bound);
    return {};
}

Result<std::vector<RegionSums>> KeptPrint::sums(const std::vector<std::string>& settings,
                                                std::span<const SumRegion> regions, SumPitch pitch,
                                                bool printed) {
    Kept& kept = at(pitch);
    mixtures_->ask(regions);
    PrintedSums counted(regions);
    backends::NullSink nowhere;
    pipeline::SliceSink* sink = &nowhere;
    if (printed) sink = &counted;
    if (const Result<void> done = run(settings, &kept, sink); !done) return done.error();
    const double ml = voxel_ml(kept.info);
    std::vector<RegionSums> out;
    for (size_t r = 0; r < regions.size(); ++r) {
        out.push_back({mixtures_->ml(r, ml), {}, mixtures_->mean(r), 0});
        if (!printed) continue;
        out.back().printed_ml = counted.ml(r, ml);
        out.back().printed_mean = counted.mean(r);
    }
    return out;
}

Result<std::vector<RegionRates>> KeptPrint::rates(const std::vector<std::string>& settings,
                                                  std::span<const SumRegion> regions,
                                                  SumPitch pitch, std::span<const double> scales) {
    Kept& kept = at(pitch);
    mixtures_->ask(regions, scales);
    backends::NullSink nowhere;
    if (const Result<void> done = run(settings, &kept, &nowhere); !done) return done.error();
    const double ml = voxel_ml(kept.info);
    std::vector<RegionRates> out;
    for (size_t r = 0; r < regions.size(); ++r)
        out.push_back({mixtures_->ml(r, ml), mixtures_->change_ml(r, ml)});
    return out;
}

/// Evaluates all slabs with other values of uniforms.
Result<void> KeptPrint::run(const std::vector<std::string>& settings, Kept* kept,
                            pipeline::SliceSink* sink) {
    if (Result<void> bound = bind(settings, kept); !bound) return bound;
    std::vector<int32_t> slabs;
    for (int32_t slab = kept->job->slabs().x; slab < kept->job->slabs().y; ++slab)
        slabs.push_back(slab);
    const Result<pipeline::SlabsRun> done = kept->job->run_slabs(slabs, *sink, interrupt_, nullptr);
    if (!done) return done.error();
    return {};
}

}  // namespace openfab::program
