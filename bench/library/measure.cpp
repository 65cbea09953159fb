// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "bench/library/measure.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <map>
#include <memory>
#include <numeric>
#include <random>
#include <span>

#include "abi/blue_noise.h"
#include "abi/kernel_call.h"
#include "abi/stages.h"
#include "base/clock.h"
#include "bench/micro/load_fablet.h"
#include "compiler/interp/evaluate.h"
#include "compiler/passes/pipeline.h"
#include "runtime/segments/driver.h"
#include "tools/tuner/stand.h"

namespace openfab::bench {

namespace {

constexpr int32_t kBlocks = 256, kBlockVoxels = 512, kColumns = 64;
constexpr int32_t kBatch = 16;  ///< blocks of a call, as in a print
constexpr size_t kVoxels = size_t{kBlocks} * kBlockVoxels;
constexpr openfab_isa kIsa = OPENFAB_ISA_AVX2;
/// Each measurement takes at least this.
constexpr double kLeastSeconds = 0.002;

/// Blocks at random places, and the frame that puts their region about the origin.
struct Places {
    Places() : frame(OPENFAB_FRAME_COUNT, 0.0F) {
        std::mt19937 random(7);
        const auto voxels = static_cast<uint32_t>(kRegionMm / kVoxelMm);
        for (int32_t k = 0; k < 3 * kBlocks; ++k)
            corners.push_back(static_cast<int32_t>(random() % (voxels - 8)));
        for (int32_t axis = 0; axis < 3; ++axis) {
            frame[static_cast<size_t>(OPENFAB_FRAME_STEP_I + 4 * axis)] = kVoxelMm;
            frame[static_cast<size_t>(OPENFAB_FRAME_ORIGIN + axis)] = -kRegionMm / 2;
            frame[static_cast<size_t>(OPENFAB_FRAME_VOXEL_SIZE + axis)] = kVoxelMm;
        }
    }
    std::vector<int32_t> corners;
    std::vector<float> frame;
};

const Places& places() {
    static const Places all;
    return all;
}

/// Fails loudly: a benchmark has no other way to go on.
template <typename T>
T loaded(std::variant<T, lower::Fault> result, const std::string& call) {
    if (const auto* fault = std::get_if<lower::Fault>(&result)) {
        fmt::print(stderr, "{}: {}\n", call, fault->trouble);
        std::exit(4);
    }
    return std::move(std::get<T>(result));
}

passes::PipelineResult passed(const ir::Module& module) {
    passes::PipelineOptions options;
    options.disabled = {"hoist_uniforms"};  // there are none, and no kernel that derives them
    return passes::run_pipeline(module.fablets[0], options);
}

class Kernel {
  public:
    virtual ~Kernel() = default;
    /// Evaluates all blocks.
    virtual void run() = 0;
};

/// The amounts of a volume stage. It runs as segments, of which it is one unless it has loops.
class Amounts : public Kernel, segments::Arguments, segments::Handler {
  public:
    explicit Amounts(const testing::LibraryCall& sample) {
        const ir::Module module = load_module(testing::fablet_of(sample));
        const passes::PipelineResult made = passed(module);
        passes::KernelStages stages;
        stages.volume = made.stages.volume;
        ir::drop_dead_values(&stages.volume);
        for (size_t k = 0; k < stages.volume.outputs.size(); ++k)
            stages.volume.outputs[k].a = static_cast<int32_t>(k);
        stages.volume_segments = passes::cut_segments(stages.volume, passes::kMaxSegmentOperations,
                                                      passes::Amounts::kStates);
        bounds_ = made.stages.volume_bounds;
        lower::ProgramOptions options;
        options.isas = {kIsa};
        program_ =
            loaded(lower::load_program({{&module.fablets[0], &stages, "sample.fl", 1}}, options),
                   sample.call);
        values_.assign(stages.volume.outputs.size(), std::vector<float>(kVoxels));
    }

    void run() override {
        const openfab_segments& segments = program_->fablets().fablets[0]->volume_segments;
        const std::vector<uint8_t> wanted(static_cast<size_t>(kBatch * kColumns), 255);
        for (first_ = 0; first_ < kBlocks; first_ += kBatch) {
            buffers_.clear();
            if (!driver_.run(segments, kIsa, wanted, this, this).ok()) std::exit(4);
            // Of as many values from the kernel that is subtracted.
            for (size_t k = 0; k < values_.size(); ++k) {
                std::memcpy(&values_[k][static_cast<size_t>(first_) * kBlockVoxels],
                            driver_.states()[1 + static_cast<int32_t>(k)],
                            sizeof(float) * kBatch * kBlockVoxels);
            }
        }
    }

    const std::vector<std::vector<float>>& values() const { return values_; }
    const ir::Stage& bounds() const { return bounds_; }

  private:
    const void* input(const openfab_arg& arg) override {
        if (arg.kind == OPENFAB_ARG_FRAME) return &places().frame[static_cast<size_t>(arg.a)];
        abi::KernelBuffer& buffer = buffers_.emplace_back();
        buffer.set_dense(abi::halide_type(arg), &places().corners[static_cast<size_t>(3 * first_)],
                         {3, kBatch});
        return buffer.raw();
    }
    /// Amounts are states.
    segments::OutputView output(const openfab_arg& /*arg*/) override { return {}; }
    abi::KernelStatus query(const openfab_query& /*query*/, std::span<const int32_t> /*groups*/,
                            const segments::States& /*states*/) override {
        return {};
    }
    void printf(const openfab_printf& /*call*/, std::span<const int32_t> /*groups*/,
                const segments::States& /*states*/) override {}

    std::unique_ptr<lower::LoadedProgram> program_;
    ir::Stage bounds_;
    segments::Driver driver_;
    std::vector<std::vector<float>> values_;  ///< [output][voxel]
    std::deque<abi::KernelBuffer> buffers_;
    int32_t first_ = 0;
};

/// A slab kernel of three materials, all voxels mixed, with a dither rule.
class Rule : public Kernel {
  public:
    explicit Rule(const std::string& call) : channels_(std::vector<int32_t>{1, 2, 3}) {
        const ir::Module module = load_module(testing::fablet_of({"dither", "rule", call}));
        const passes::PipelineResult made = passed(module);
        lower::ProgramOptions options;
        options.isas = {kIsa};
        program_ = loaded(
            lower::load_program({{&module.fablets[0], &made.stages, "sample.fl", 1}}, options),
            call);
        std::iota(columns_.begin(), columns_.end(), 0);
        fractions_.assign(static_cast<size_t>(channels_.count()),
                          std::vector<uint16_t>(8 * columns_.size()));
        std::mt19937 random(3);
        for (uint16_t& rank : mask_)
            rank = static_cast<uint16_t>(random());
    }

    void run() override {
        const openfab_kernel& kernel = program_->fablets().fablets[0]->slab;
        for (int32_t first = 0; first < kBlocks; first += kBatch) {
            std::deque<abi::KernelBuffer> buffers;
            abi::KernelCall call(kernel, kIsa);
            for (int32_t k = 0; k < kernel.arg_count; ++k)
                call.set(k, argument(kernel.args[k], first, &buffers));
            if (!call.run().ok()) std::exit(4);
        }
    }

  private:
    const void* argument(const openfab_arg& arg, int32_t first,
                         std::deque<abi::KernelBuffer>* buffers) {
        if (arg.kind == OPENFAB_ARG_FRAME) return &places().frame[static_cast<size_t>(arg.a)];
        if (arg.kind == OPENFAB_ARG_GRID) return &grid_[static_cast<size_t>(arg.a)];
        abi::KernelBuffer& buffer = buffers->emplace_back();
        const halide_type_t type = abi::halide_type(arg);
        const auto count = static_cast<int32_t>(columns_.size());
        if (arg.kind == OPENFAB_ARG_BLOCKS)
            buffer.set_dense(type, &places().corners[static_cast<size_t>(3 * first)], {3, kBatch});
        if (arg.kind == OPENFAB_ARG_GROUPS) buffer.set_dense(type, columns_.data(), {count});
        if (arg.kind == OPENFAB_ARG_CHANNELS)
            buffer.set_dense(type, channels_.table(), {OPENFAB_CHANNEL_ROWS, channels_.count()});
        if (arg.kind == OPENFAB_ARG_BLUE_NOISE)
            buffer.set_dense(type, mask_.data(), {8, abi::kBlueNoisePixels});
        if (arg.kind == OPENFAB_ARG_CODE) buffer.set_columns(type, codes_.data(), count);
        if (arg.kind == OPENFAB_ARG_CHOICE) buffer.set_columns(type, choices_.data(), count);
        if (arg.kind == OPENFAB_ARG_UNUSABLE) buffer.set_columns(type, unusable_.data(), count);
        if (arg.kind == OPENFAB_ARG_FRACTION)
            buffer.set_columns(type, fractions_[static_cast<size_t>(arg.a)].data(), count);
        return buffer.raw();
    }

    static constexpr size_t kLanes = size_t{8} * kBatch * kColumns;
    std::unique_ptr<lower::LoadedProgram> program_;
    abi::Channels channels_;
    std::array<int32_t, static_cast<size_t>(kBatch) * kColumns> columns_{};
    std::array<int32_t, 4> grid_{};
    std::array<uint16_t, 8 * abi::kBlueNoisePixels> mask_{};
    std::array<uint8_t, kLanes> codes_{}, choices_{};
    std::array<uint16_t, kLanes> unusable_{};
    std::vector<std::vector<uint16_t>> fractions_;
};

/// Half of the range of the middle two quarters.
double half_of_middle(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    const size_t quarter = values.size() / 4;
    return (values[values.size() - 1 - quarter] - values[quarter]) / 2;
}

double seconds_of(Kernel* kernel, int repeats) {
    const double begin = thread_processor_seconds();
    for (int k = 0; k < repeats; ++k)
        kernel->run();
    return (thread_processor_seconds() - begin) / repeats;
}

int repeats_of(Kernel* kernel) {
    kernel->run();
    return std::max(1, static_cast<int>(std::ceil(kLeastSeconds / seconds_of(kernel, 1))));
}

/// Rounds of both in turn.
Cost compare(Kernel* kernel, Kernel* copy) {
    const int repeats = repeats_of(kernel), copies = repeats_of(copy);
    std::vector<double> beyond, ratios;
    for (int round = 0; round < kRounds; ++round) {
        const double base = seconds_of(copy, copies);
        const double time = seconds_of(kernel, repeats);
        beyond.push_back((time - base) / double{kVoxels} * 1e9);
        ratios.push_back(time / base);
    }
    return {tuner::median(beyond), half_of_middle(beyond), tuner::median(ratios)};
}

/// A copy of the position into so many amounts.
Kernel* copy_of(size_t outputs) {
    static std::map<size_t, std::unique_ptr<Amounts>> known;
    auto& copy = known[outputs];
    if (copy) return copy.get();
    static const std::array<testing::LibraryCall, 6> kCopies = {
        {{"grade", "float", "p.x"},
         {"grade", "float2", "p.xy"},
         {"grade", "float3", "p"},
         {"grade", "float4", "float4(p, p.x)"},
         {"voronoi", "Voronoi", "{p, p.x, p.y}"},
         {"conformal", "Cells", "{p, p}"}}};
    copy = std::make_unique<Amounts>(kCopies.at(outputs - 1));
    return copy.get();
}

/// One block: the box of its voxels' centres.
class Box : public interp::Environment {
  public:
    explicit Box(int32_t block) : corner_(&places().corners[static_cast<size_t>(3 * block)]) {}
    uint32_t input(int32_t kind, int32_t a, int32_t /*b*/) const override {
        if (kind == OPENFAB_ARG_FRAME)
            return std::bit_cast<uint32_t>(places().frame[static_cast<size_t>(a)]);
        if (kind == OPENFAB_ARG_BLOCK_SIZE) return 8;
        const int32_t index = corner_[a] + (kind == ir::kVoxelCoordHi ? 7 : 0);
        return std::bit_cast<uint32_t>(static_cast<float>(index) + 0.5F);
    }
    interp::TextureView texture(int32_t /*index*/) const override { return {}; }

  private:
    const int32_t* corner_;
};

struct Range {
    float low, high;
};

/// What is known of each block and what is true of it, by output and block.
struct Ranges {
    std::vector<std::vector<Range>> known, real;
};

Ranges ranges_of(const Amounts& amounts) {
    Ranges out;
    out.known.resize(amounts.values().size());
    for (const std::vector<float>& values : amounts.values()) {
        std::vector<Range>& real = out.real.emplace_back();
        for (size_t block = 0; block < kBlocks; ++block) {
            const auto first = values.begin() + static_cast<std::ptrdiff_t>(block * kBlockVoxels);
            const auto [low, high] = std::minmax_element(first, first + kBlockVoxels);
            real.push_back({*low, *high});
        }
    }
    for (int32_t block = 0; block < kBlocks && !amounts.bounds().outputs.empty(); ++block) {
        const std::vector<uint32_t> ends = interp::evaluate(amounts.bounds(), Box(block));
        for (size_t k = 0; k < out.known.size(); ++k)
            out.known[k].push_back(
                {std::bit_cast<float>(ends[2 * k]), std::bit_cast<float>(ends[2 * k + 1])});
    }
    return out;
}

/// The value at which a fablet would change its material.
float level_of(const std::vector<Range>& real) {
    Range all = real[0];
    for (const Range& range : real)
        all = {std::min(all.low, range.low), std::max(all.high, range.high)};
    return all.low < 0 && all.high > 0 ? 0 : (all.low + all.high) / 2;
}

Bounds bounds_of(const Amounts& amounts, bool mixture) {
    Bounds out;
    const Ranges ranges = ranges_of(amounts);
    if (ranges.known[0].empty()) return out;
    std::vector<double> widths;
    for (size_t k = 0; k < ranges.known.size(); ++k) {
        for (size_t block = 0; block < kBlocks; ++block) {
            const Range known = ranges.known[k][block], real = ranges.real[k][block];
            out.known = out.known || !std::isnan(known.low);
            if (!(real.high > real.low)) continue;
            widths.push_back(std::isnan(known.low) ? HUGE_VAL
                                                   : (double{known.high} - known.low) /
                                                         (double{real.high} - real.low));
        }
    }
    // Nothing varies: exact where the interval says so.
    const double width = widths.empty() ? 1 : tuner::median(widths);
    if (out.known && std::isfinite(width)) out.width = width;
    if (!mixture && ranges.known.size() > 1) return out;
    const float level = level_of(ranges.real[0]);
    const auto one_side = [&](const Range& range) {
        return mixture ? range.low == range.high : range.high < level || range.low >= level;
    };
    std::array<double, 2> shares{};
    for (size_t block = 0; block < kBlocks; ++block) {
        std::array<bool, 2> all = {true, true};
        for (size_t k = 0; k < ranges.known.size(); ++k) {
            all[0] = all[0] && one_side(ranges.real[k][block]);
            all[1] = all[1] && one_side(ranges.known[k][block]);
        }
        for (size_t i = 0; i < 2; ++i)
            shares[i] += (all[i] ? 1.0 : 0.0) / kBlocks;
    }
    out.one_sided = shares[0];
    out.decided = shares[1];
    return out;
}

}  // namespace

Figures measure(const testing::LibraryCall& sample) {
    if (sample.type == "rule") {
        static Rule none("0");
        Rule rule(sample.call);
        return {compare(&rule, &none), {}};
    }
    Amounts amounts(sample);
    const Cost cost = compare(&amounts, copy_of(amounts.values().size()));
    return {cost, bounds_of(amounts, sample.type == "MaterialComposition")};
}

}  // namespace openfab::bench
