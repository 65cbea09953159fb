// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/property/pipeline/reference_check.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <map>
#include <mutex>

#include "abi/kernel_call.h"
#include "compiler/diag/render.h"
#include "compiler/frontend/frontend.h"
#include "runtime/pipeline/print_job.h"
#include "tests/support/load_module.h"
#include "tests/support/prints/box_print.h"
#include "tests/support/reference/column_scan.h"
#include "tests/support/reference/pipeline.h"

namespace openfab::testing {

size_t Compiled::find(const std::string& name) const {
    for (size_t k = 0; k < module.fablets.size(); ++k) {
        if (module.fablets[k].name == name) return k;
    }
    ADD_FAILURE() << "no fablet " << name;
    return 0;
}

Compiled compile(const std::filesystem::path& file) {
    Compiled compiled;
    source::SourceManager sources;
    diag::Sink sink;
    std::string fault;
    std::optional<ir::Module> module = frontend::compile_to_ir(sources, file, sink, &fault);
    if (!module) {
        ADD_FAILURE() << file << " does not compile: " << fault;
        return compiled;
    }
    compiled.module = std::move(*module);
    auto loaded = load_module(compiled.module, {.isas = {abi::best_isa()}});
    if (std::holds_alternative<lower::Fault>(loaded)) {
        ADD_FAILURE() << std::get<lower::Fault>(loaded).trouble;
        return compiled;
    }
    compiled.program = std::move(std::get<0>(loaded));
    return compiled;
}

namespace {

constexpr int32_t kMaterials = 4;

/// Keeps all rows in order of place.
class KeptFractions : public pipeline::FractionSink {
  public:
    Result<void> begin(const pipeline::PrintInfo& /*info*/, int32_t /*materials*/) override {
        return {};
    }
    Result<void> status() const override { return {}; }
    Result<void> finish(const pipeline::PrintTotals& /*totals*/) override { return {}; }
    void write(int32_t z, int32_t y, int32_t x, std::span<const float> row) override {
        const std::lock_guard lock(mutex_);
        rows[{z, y, x}].assign(row.begin(), row.end());
    }
    std::map<std::array<int32_t, 3>, std::vector<float>> rows;

  private:
    std::mutex mutex_;
};

/// Sets a flag with the first slice that it takes.
class InterruptingSink : public testing::MemorySink {
  public:
    explicit InterruptingSink(std::atomic<bool>* interrupt) : interrupt_(interrupt) {}
    Result<void> commit(int32_t z, std::vector<uint8_t> bytes) override {
        interrupt_->store(true);
        return MemorySink::commit(z, std::move(bytes));
    }

  private:
    std::atomic<bool>* interrupt_;
};

struct PrintedGrid {
    part::Grid grid;
    std::vector<uint8_t> codes;
    pipeline::PrintStatistics statistics;
};

/// Fails the test, and returns null, where it cannot be set up.
std::unique_ptr<pipeline::PrintJob> set_up(const std::vector<part::Part>& parts,
                                           const Vec3d& pitch_mm, uint64_t seed, bool support,
                                           pipeline::PrintOptions options) {
    pipeline::PrintInput input;
    input.parts = parts;
    for (int k = 0; k < kMaterials + (support ? 1 : 0); ++k)
        input.materials.push_back({fmt::format("m{}", k), {}, {}, 1, ""});
    if (support) input.support_code = kMaterials + 1;
    input.pitch_mm = pitch_mm;

    options.seed = seed;
    if (options.threads == 0) options.threads = 2;
    options.memory_bytes += testing::kSanitizerBytes;
    auto made = pipeline::PrintJob::create(std::move(input), options);
    if (made) return std::move(*made);
    ADD_FAILURE() << made.error().text();
    return nullptr;
}

PrintedGrid print(const std::vector<part::Part>& parts, const Vec3d& pitch_mm, uint64_t seed,
                  bool support, const pipeline::PrintOptions& options = {}) {
    PrintedGrid out;
    const auto job = set_up(parts, pitch_mm, seed, support, options);
    if (job == nullptr) return out;
    testing::MemorySink sink;
    const std::atomic<bool> interrupt{false};
    const Result<void> ran = job->run(sink, nullptr, interrupt, &out.statistics);
    if (!ran) ADD_FAILURE() << ran.error().text();
    out.grid = {sink.info.origin_mm, sink.info.pitch_mm, sink.info.size};
    out.codes = sink.codes();
    return out;
}

std::vector<uint8_t> reference_of(const std::vector<part::Part>& parts,
                                  const std::vector<const ir::Fablet*>& sources,
                                  const part::Grid& grid, uint64_t seed) {
    std::vector<reference::ReferencePart> references;
    for (size_t k = 0; k < parts.size(); ++k)
        references.push_back({&parts[k], sources[k]});
    return reference::print(references, grid, kMaterials, seed);
}

/// The print's voxels without support.
void expect_same_parts(const PrintedGrid& printed, const std::vector<uint8_t>& expected) {
    const std::vector<uint8_t>& codes = printed.codes;
    ASSERT_EQ(codes.size(), expected.size());
    int64_t different = 0, solid = 0;
    std::string first;
    for (size_t v = 0; v < codes.size(); ++v) {
        const uint8_t code = codes[v] > kMaterials ? 0 : codes[v];
        solid += expected[v] != 0 ? 1 : 0;
        if (code == expected[v]) continue;
        if (different++ == 0) {
            const auto w = static_cast<size_t>(printed.grid.size.x),
                       h = static_cast<size_t>(printed.grid.size.y);
            first = fmt::format("voxel ({}, {}, {}): printed {}, asked {}", v % w, v / w % h,
                                v / (w * h), code, expected[v]);
        }
    }
    EXPECT_EQ(different, 0) << first << " of " << codes.size();
    EXPECT_GT(solid, static_cast<int64_t>(codes.size()) / 20);
    printf("%zu voxels, %ld solid, blocks %ld filled, %ld evaluated\n", codes.size(),
           static_cast<long>(solid), static_cast<long>(printed.statistics.blocks_filled),
           static_cast<long>(printed.statistics.blocks_evaluated));
}

/// For each column, the slices [0, top) below voxels of columns at most `reach` voxels away along
/// each axis, extended by `reach` voxels.
std::vector<int32_t> highest_around(const std::vector<uint8_t>& codes, const Vec3i& size,
                                    const Vec3i& reach) {
    const auto at = [&](int32_t x, int32_t y) {
        return static_cast<size_t>(y) * static_cast<size_t>(size.x) + static_cast<size_t>(x);
    };
    const size_t slice = at(0, size.y);
    std::vector<int32_t> tops(slice, 0), out(slice, 0);
    for (size_t v = 0; v < codes.size(); ++v) {
        if (codes[v] != 0) tops[v % slice] = static_cast<int32_t>(v / slice) + 1;
    }
    for (int32_t y = 0; y < size.y; ++y) {
        for (int32_t x = 0; x < size.x; ++x) {
            for (int32_t v = std::max(y - reach.y, 0); v <= std::min(y + reach.y, size.y - 1);
                 ++v) {
                for (int32_t u = std::max(x - reach.x, 0); u <= std::min(x + reach.x, size.x - 1);
                     ++u) {
                    const int32_t top = tops[at(u, v)];
                    if (top > 0) out[at(x, y)] = std::max(out[at(x, y)], top + reach.z);
                }
            }
        }
    }
    return out;
}

}  // namespace

void expect_reference(const std::vector<part::Part>& parts,
                      const std::vector<const ir::Fablet*>& sources, const Vec3d& pitch_mm,
                      uint64_t seed) {
    const PrintedGrid printed = print(parts, pitch_mm, seed, false);
    expect_same_parts(printed, reference_of(parts, sources, printed.grid, seed));
}

void expect_same_dithers(const std::vector<part::Part>& parts, const Vec3d& pitch_mm, uint64_t seed,
                         const std::vector<std::string>& dithers, bool same_voxels) {
    std::vector<uint8_t> codes;
    std::map<std::array<int32_t, 3>, std::vector<float>> rows;
    for (const std::string& dither : dithers) {
        KeptFractions fractions;
        pipeline::PrintOptions options;
        options.dither = dither;
        const PrintedGrid without = print(parts, pitch_mm, seed, false, options);
        options.fractions = &fractions;
        const PrintedGrid with = print(parts, pitch_mm, seed, false, options);
        EXPECT_EQ(with.codes, without.codes) << dither << ": taking fractions changes voxels";
        EXPECT_GT(fractions.rows.size(), 100u);
        const bool first = rows.empty();
        if (first) {
            codes = with.codes;
            rows = fractions.rows;
        }
        EXPECT_TRUE(fractions.rows == rows) << dither << ": other mixtures";
        if (first) continue;
        EXPECT_EQ(with.codes == codes, same_voxels) << dither;
    }
}

void expect_reference_and_support(const std::vector<part::Part>& parts,
                                  const std::vector<const ir::Fablet*>& sources,
                                  const Vec3d& pitch_mm, uint64_t seed, double reach_mm) {
    const PrintedGrid printed = print(parts, pitch_mm, seed, true);
    const std::vector<uint8_t> plain = reference_of(parts, sources, printed.grid, seed);
    expect_same_parts(printed, plain);
    const Vec3i size = printed.grid.size;
    constexpr uint8_t kSupport = kMaterials + 1;
    const std::vector<uint8_t> scanned = reference::add_support(plain, plain, size, kSupport);
    Vec3i reach;
    for (int a = 0; a < 3; ++a)
        reach[a] = static_cast<int32_t>(std::ceil(reach_mm / pitch_mm[a])) + 1;
    const std::vector<int32_t> highest = highest_around(plain, size, reach);
    int64_t called_for = 0, missing = 0, more = 0, too_high = 0;
    for (size_t v = 0; v < scanned.size(); ++v) {
        const bool asked = scanned[v] == kSupport, there = printed.codes[v] == kSupport;
        called_for += asked ? 1 : 0;
        missing += asked && !there ? 1 : 0;
        more += there && !asked ? 1 : 0;
        const auto z = static_cast<int32_t>(v / highest.size());
        too_high += there && z >= highest[v % highest.size()] ? 1 : 0;
    }
    EXPECT_EQ(missing, 0) << "of " << called_for;
    EXPECT_EQ(too_high, 0) << "of " << more;
    EXPECT_GT(called_for, static_cast<int64_t>(scanned.size()) / 50)
        << "the world shows too little";
    EXPECT_EQ(printed.statistics.voxels_support, called_for + more);
    printf("support %ld, %ld more than called for\n", static_cast<long>(called_for + more),
           static_cast<long>(more));
}

void expect_slabs_outlive_an_interrupt(const std::vector<part::Part>& parts,
                                       const Vec3d& pitch_mm) {
    std::atomic<bool> interrupt{false};
    const std::atomic<bool> never{false};
    pipeline::PrintOptions options;
    options.interrupt = &interrupt;
    const auto plain = set_up(parts, pitch_mm, 0, false, {});
    const auto job = set_up(parts, pitch_mm, 0, false, options);
    if (plain == nullptr || job == nullptr) return;
    std::vector<int32_t> slabs;
    for (int32_t slab = job->slabs().x; slab < job->slabs().y; ++slab)
        slabs.push_back(slab);
    ASSERT_GE(slabs.size(), 6u) << "more than are in flight at once";
    MemorySink whole;
    const Result<pipeline::SlabsRun> expected = plain->run_slabs(slabs, whole, never, nullptr);
    ASSERT_TRUE(expected) << expected.error().text();

    InterruptingSink cut(&interrupt);
    const Result<pipeline::SlabsRun> ended = job->run_slabs(slabs, cut, interrupt, nullptr);
    ASSERT_FALSE(ended);
    EXPECT_EQ(ended.error().code, ErrorCode::kInterrupted) << ended.error().text();
    ASSERT_LT(cut.slices.size(), whole.slices.size());

    MemorySink again;
    const Result<pipeline::SlabsRun> rerun = job->run_slabs(slabs, again, never, nullptr);
    ASSERT_TRUE(rerun) << rerun.error().text();
    EXPECT_EQ(rerun->hash, expected->hash);
    EXPECT_TRUE(again.slices == whole.slices);
}

void expect_repeated_slabs_are_equal_work(const std::vector<part::Part>& parts,
                                          const Vec3d& pitch_mm) {
    const std::atomic<bool> never{false};
    pipeline::PrintOptions options;
    options.threads = 1;  // else patches are looked up as threads happen to share them
    const auto job = set_up(parts, pitch_mm, 0, false, options);
    if (job == nullptr) return;
    int64_t all = 0;
    for (int32_t slab = job->slabs().x; slab < job->slabs().y; ++slab) {
        std::vector<int64_t> lookups;
        for (int time = 0; time < 4; ++time) {
            MemorySink sink;
            pipeline::PrintStatistics statistics;
            const Result<pipeline::SlabsRun> run =
                job->run_slabs(std::array{slab}, sink, never, &statistics);
            ASSERT_TRUE(run) << run.error().text();
            lookups.push_back(statistics.cache_hits + statistics.cache_misses);
        }
        EXPECT_EQ(lookups[2] - lookups[1], lookups[3] - lookups[2]) << "slab " << slab;
        all += lookups[3] - lookups[2];
    }
    EXPECT_GT(all, 100);
}

}  // namespace openfab::testing
