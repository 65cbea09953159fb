// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Whole prints of boxes against the plain reference, voxel for voxel, and the same output for all
// settings.

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <utility>

#include "runtime/process/bleed/bleed.h"
#include "tests/support/prints/box_print.h"
#include "tests/support/prints/test_fablets.h"

namespace openfab {
namespace {

using testing::BoxPart;
using testing::Printed;

// Corners are off the grid, so that no voxel centre is equally far from two sides or exactly at the
// skin's depth.
std::vector<BoxPart> one_skin() {
    return {{{0.513, -0.271, 0.019}, {5.03, 4.11, 2.37}, &testing::skin_fablet()}};
}
std::vector<BoxPart> one_picture() {
    return {{{-3.013, 1.071, 0.019}, {7.03, 4.11, 1.37}, &testing::picture_fablet()}};
}
std::vector<BoxPart> assembly() {
    return {
        {{0.013, 0.021, 0.019}, {6.03, 5.11, 2.37}, &testing::skin_fablet()},
        {{1.513, 1.271, 0.519}, {2.03, 2.11, 2.37}, &testing::tint_fablet()},      // later: wins
        {{2.113, 0.671, -0.419}, {0.93, 3.11, 1.37}, &testing::hole_fablet(), 5},  // cuts a hole
        {{3.013, 2.071, 1.019},
         {5.03, 4.11, 2.37},
         &testing::picture_fablet(),
         -1,
         {2, 1, 0}},  // gives way
        {{4.113, 0.371, 1.219}, {1.33, 1.11, 0.37}, &testing::solid_fablet(), 1, {2, 2, 0}},
    };
}

void expect_reference(const std::vector<BoxPart>& boxes, uint64_t seed) {
    pipeline::PrintOptions options;
    options.seed = seed;
    const Printed printed = testing::print_boxes(boxes, options);
    ASSERT_TRUE(printed.ok) << printed.error.text();
    const std::vector<uint8_t> codes = printed.sink.codes();
    const std::vector<uint8_t> expected = testing::reference_codes(boxes, printed.sink.info, seed);
    ASSERT_EQ(codes.size(), expected.size());
    const Vec3i size = printed.sink.info.size;
    int64_t different = 0;
    for (size_t i = 0; i < codes.size(); ++i) {
        if (codes[i] == expected[i]) continue;
        const auto n = static_cast<int64_t>(i);
        if (different++ < 5) {
            ADD_FAILURE() << "voxel " << n % size.x << " " << n / size.x % size.y << " "
                          << n / size.x / size.y << ": " << int{codes[i]} << ", should be "
                          << int{expected[i]};
        }
    }
    EXPECT_EQ(different, 0) << "of " << codes.size();
    for (uint8_t code : {0, 1, 2}) {
        EXPECT_GT(std::count(expected.begin(), expected.end(), code), 100)
            << "the scene shows too little";
    }
}

/// Prints a window of an assembly, in place of the box around it.
Printed print_window(const std::vector<BoxPart>& boxes, const Box3d& window_mm) {
    pipeline::PrintInput input = testing::make_input(boxes);
    input.window_mm = window_mm;
    Printed out;
    const Result<std::unique_ptr<pipeline::PrintJob>> job =
        pipeline::PrintJob::create(std::move(input), {});
    if (!job) {
        out.error = job.error();
        return out;
    }
    const std::atomic<bool> interrupt{false};
    const Result<void> done = (*job)->run(out.sink, {}, interrupt, &out.statistics);
    out.ok = bool(done);
    if (!done) out.error = done.error();
    return out;
}

// Through all parts, around them, at a corner, of one voxel, in the air: parts that reach beyond a
// window are cut off, whichever sides they leave it by.
TEST(BoxPrint, AWindowIsTheReferenceOfItsVoxels) {
    const Box3d windows[] = {
        {{1.7, 1.3, 0.31}, {4.2, 2.9, 1.62}},  {{-2, -1.5, -1}, {10, 8, 4}},
        {{4.4, -0.3, 1.1}, {9.1, 3.33, 2.8}},  {{2.21, 1.61, 0.61}, {2.29, 1.67, 0.64}},
        {{2.6, 2.1, 0.9}, {2.7, 6.5, 1.1}},    {{20, 20, 20}, {22, 21, 20.5}},
        {{-1.1, 0.4, -0.2}, {0.55, 5.5, 2.45}}};
    for (const Box3d& window : windows) {
        const std::vector<BoxPart> boxes = assembly();
        const Printed printed = print_window(boxes, window);
        ASSERT_TRUE(printed.ok) << printed.error.text();
        const pipeline::PrintInfo& info = printed.sink.info;
        for (int a = 0; a < 3; ++a) {
            const double lo = info.origin_mm[a], pitch = info.pitch_mm[a];
            EXPECT_NEAR(lo, pitch * std::floor(window.lo[a] / pitch), 1e-9);
            EXPECT_NEAR(lo + info.size[a] * pitch, pitch * std::ceil(window.hi[a] / pitch), 1e-9);
        }
        EXPECT_TRUE(printed.sink.codes() == testing::reference_codes(boxes, info, 0));
    }
}

TEST(BoxPrint, SkinIsTheReference) {
    expect_reference(one_skin(), 1);
}
TEST(BoxPrint, PictureIsTheReference) {
    expect_reference(one_picture(), 2);
}
TEST(BoxPrint, AssemblyIsTheReference) {
    expect_reference(assembly(), 3);
}

constexpr const char* kDithers[] = {"floyd_steinberg", "decorrelated", "blue_noise", "majority"};

TEST(BoxPrint, EveryDitherIsTheReference) {
    for (const char* dither : kDithers) {
        pipeline::PrintOptions options;
        options.seed = 4;
        options.dither = dither;
        const Printed printed = testing::print_boxes(assembly(), options);
        ASSERT_TRUE(printed.ok) << printed.error.text();
        EXPECT_EQ(printed.sink.codes(), testing::reference_codes(assembly(), printed.sink.info, 4,
                                                                 *dither::find_dither(dither)))
            << dither;
    }
}

// Codes 1 and 2 are mapped to any two of many: 8 bits a voxel from 16 materials on.
TEST(BoxPrint, ManyMaterialsAreTheReference) {
    for (size_t materials : {size_t{16}, size_t{254}}) {
        std::vector<BoxPart> boxes = assembly();
        for (BoxPart& box : boxes) {
            for (uint8_t& code : box.slot_material) {
                if (code > 0) code = static_cast<uint8_t>(materials + code - 2);
            }
        }
        for (const char* dither : kDithers) {
            pipeline::PrintOptions options;
            options.dither = dither;
            const Printed printed =
                testing::print_boxes(boxes, options, testing::kPitch, materials);
            ASSERT_TRUE(printed.ok) << printed.error.text();
            EXPECT_EQ(printed.sink.info.bits, 8);
            const std::vector<uint8_t> codes = printed.sink.codes();
            ASSERT_EQ(codes, testing::reference_codes(boxes, printed.sink.info, 0,
                                                      *dither::find_dither(dither)))
                << materials << " materials, " << dither;
            std::vector<int64_t> counts(materials + 1, 0);
            for (uint8_t code : codes)
                ++counts[code];
            EXPECT_GT(counts[materials], 100);
            EXPECT_EQ(printed.statistics.voxels_by_code, counts);
            EXPECT_EQ(printed.statistics.voxels_solid,
                      static_cast<int64_t>(codes.size()) - counts[0]);
            const Vec3i tight = printed.statistics.tight.size();
            EXPECT_EQ(printed.statistics.voxels_total, int64_t{tight.x} * tight.y * tight.z);
        }
    }
}

// A print of few materials is the same if the world has many.
TEST(BoxPrint, SpareMaterialsChangeNoVoxel) {
    for (const char* dither : kDithers) {
        pipeline::PrintOptions options;
        options.dither = dither;
        const Printed few = testing::print_boxes(assembly(), options);
        for (size_t materials : {size_t{5}, size_t{15}, size_t{20}}) {
            const Printed many =
                testing::print_boxes(assembly(), options, testing::kPitch, materials);
            EXPECT_EQ(many.sink.codes(), few.sink.codes()) << dither << ", " << materials;
        }
    }
}

/// The same bits for any threads, slabs, culling, instruction set and split of slices.
void expect_one_output(pipeline::PrintOptions options, size_t materials) {
    options.threads = 1;
    const Printed reference = testing::print_boxes(assembly(), options, testing::kPitch, materials);
    ASSERT_TRUE(reference.ok) << reference.error.text();
    for (int32_t threads : {2, 4}) {
        for (openfab_isa isa : {OPENFAB_ISA_SSE41, OPENFAB_ISA_AVX2}) {
            options.threads = threads;
            options.slabs_in_flight = threads - 1;
            options.isa = isa;
            options.culling = isa == OPENFAB_ISA_AVX2;
            const Printed printed =
                testing::print_boxes(assembly(), options, testing::kPitch, materials);
            ASSERT_TRUE(printed.ok) << printed.error.text();
            EXPECT_EQ(printed.statistics.hash, reference.statistics.hash)
                << options.dither << ", " << materials << " materials, " << threads
                << " threads, isa " << isa;
        }
    }
    const int32_t n = reference.sink.info.size.z;
    std::vector<std::vector<uint8_t>> slices;
    for (const Vec2<int32_t>& range : {Vec2<int32_t>{0, 5}, Vec2<int32_t>{5, n}}) {
        options.slices = range;
        const Printed part = testing::print_boxes(assembly(), options, testing::kPitch, materials);
        slices.insert(slices.end(), part.sink.slices.begin(), part.sink.slices.end());
    }
    EXPECT_EQ(slices, reference.sink.slices) << options.dither;
}

TEST(BoxPrint, OneOutputOfEveryDither) {
    for (const char* dither : kDithers) {
        pipeline::PrintOptions options;
        options.dither = dither;
        expect_one_output(options, 2);
        expect_one_output(options, 20);
    }
}

// A pipeline of five stages, where rows wait for those around them, and for other slabs.
TEST(BoxPrint, OneOutputWithBleed) {
    process::Bleed shown({{1, 2, {0.9, 1.1, 0.6}}, {0, 2, {0.5, 0.5, 0.5}}}, 0, true);
    process::Bleed undone({{1, 2, {0.9, 1.1, 0.6}}}, 2, false);
    const Printed none = testing::print_boxes(assembly());
    for (process::Bleed* bleed : {&shown, &undone}) {
        pipeline::PrintOptions options;
        options.effects = {bleed};
        const Printed printed = testing::print_boxes(assembly(), options);
        ASSERT_TRUE(printed.ok) << printed.error.text();
        EXPECT_NE(printed.statistics.hash, none.statistics.hash);
        expect_one_output(options, 2);
    }
}

/// Moves all that is printed, by voxels along x, y and z.
class Shift : public process::Effect {
  public:
    explicit Shift(const Vec3i& by) : by_(by) {}
    Result<void> begin(const process::EffectGrid& /*grid*/) override { return {}; }
    Vec3i reach() const override { return {std::abs(by_.x), std::abs(by_.y), std::abs(by_.z)}; }
    bool leaves_parts() const override { return true; }
    void note(const dither::RowBand& band, std::vector<uint64_t>* notes) const override {
        notes->assign(static_cast<size_t>(band.blocks), 7);
    }
    void spread(const process::NearBands& near, const Vec3i& size,
                dither::RowBand* out) const override {
        const dither::RowBand& own = *near.bands[near.bands.size() / 2].band;
        const Vec3i blocks = reach_blocks();
        out->reset(near.row, own.blocks, own.channels, 0, own.blocks);
        for (int32_t i = 0; i < 64 * size.x; ++i) {
            const Vec3i to{i / 64, 8 * near.row + i / 8 % 8, 8 * near.slab + i % 8};
            const Vec3i from = to - by_;
            if (from.x < 0 || from.x >= size.x || from.y < 0 || from.y >= size.y || from.z < 0 ||
                from.z >= size.z || to.y >= size.y || to.z >= size.z)
                continue;
            const int32_t slab = from.z / 8 - near.slab + blocks.z;
            const int32_t row = from.y / 8 - near.row + blocks.y;
            const auto& [band, notes] =
                near.bands[static_cast<size_t>(slab * (2 * blocks.y + 1) + row)];
            ASSERT_NE(band, nullptr);
            EXPECT_EQ(notes->size(), static_cast<size_t>(own.blocks));
            const auto column = static_cast<size_t>(from.y % 8 * own.width() + from.x);
            const int32_t z = from.z % 8;
            out->codes_at(to.x, to.y % 8)[to.z % 8] =
                band->codes[8 * column + static_cast<size_t>(z)];
            if ((band->mixed_row(from.y % 8)[from.x] >> z & 1) == 0) continue;
            const int32_t fresh = out->add_columns(1);  // of 8 voxels; one is used
            uint8_t& marks = out->mixed_row(to.y % 8)[to.x];
            int32_t& number = out->columns[static_cast<size_t>(to.y % 8 * own.width() + to.x)];
            if (marks == 0) number = fresh;
            for (int32_t m = 0; m < own.channels; ++m) {
                out->fractions_at(number)[8 * m + to.z % 8] = band->fractions[static_cast<size_t>(
                    8 * own.channels * band->columns[column] + 8 * m + z)];
            }
            marks = static_cast<uint8_t>(marks | 1 << to.z % 8);
            out->any_mixed = true;
            out->mixed_blocks[static_cast<size_t>(to.x / 8)] = 1;
        }
    }

  private:
    Vec3i by_;
};

// Each effect on neighbours takes what those before it made, in the rows and slabs around.
TEST(BoxPrint, EffectsOnNeighboursFollowEachOther) {
    Shift whole({5, -20, 14}), first({2, -3, 9}), second({1, -15, 2}), third({2, -2, 3});
    pipeline::PrintOptions options;
    options.effects = {&whole};
    const Printed once = testing::print_boxes(assembly(), options);
    ASSERT_TRUE(once.ok) << once.error.text();
    options.effects = {&first, &second, &third};
    const Printed thrice = testing::print_boxes(assembly(), options);
    ASSERT_TRUE(thrice.ok) << thrice.error.text();
    EXPECT_GT(once.statistics.voxels_solid, 1000);
    EXPECT_EQ(thrice.sink.codes(), once.sink.codes());
    expect_one_output(options, 2);

    const std::vector<BoxPart> pure{
        {{0.013, 0.021, 0.019}, {2.03, 3.11, 2.37}, &testing::solid_fablet(), 0, {1, 1, 0}}};
    const Printed moved = testing::print_boxes(pure, options);
    const std::vector<uint8_t> here = testing::print_boxes(pure).sink.codes();
    const Vec3i size = moved.sink.info.size, by{5, -20, 14};
    std::vector<uint8_t> expected(here.size(), 0);
    for (size_t i = 0; i < here.size(); ++i) {
        const auto n = static_cast<int32_t>(i);
        const Vec3i from = Vec3i{n % size.x, n / size.x % size.y, n / size.x / size.y} - by;
        if (from.x < 0 || from.y < 0 || from.z < 0 || from.x >= size.x || from.y >= size.y ||
            from.z >= size.z)
            continue;
        expected[i] = here[static_cast<size_t>((from.z * size.y + from.y) * size.x + from.x)];
    }
    EXPECT_EQ(moved.sink.codes(), expected);
}

TEST(BoxPrint, OneOutputWhateverTheSettings) {
    pipeline::PrintOptions plain;
    plain.threads = 1;
    const Printed reference = testing::print_boxes(assembly(), plain);
    ASSERT_TRUE(reference.ok) << reference.error.text();
    struct Case {
        int32_t threads, slabs;
        bool culling;
        openfab_isa isa;
        int64_t memory;
    };
    for (const Case& c : {Case{2, 0, true, OPENFAB_ISA_AVX2, 1'500'000'000},
                          Case{2, 1, true, OPENFAB_ISA_AVX2, 1'500'000'000},
                          Case{4, 7, true, OPENFAB_ISA_AVX2, 1'500'000'000},
                          Case{1, 1, false, OPENFAB_ISA_AVX2, 1'500'000'000},
                          Case{2, 2, false, OPENFAB_ISA_SSE41, 1'500'000'000},
                          Case{3, 3, true, OPENFAB_ISA_SSE41, 300'000'000}}) {
        pipeline::PrintOptions options;
        options.threads = c.threads;
        options.slabs_in_flight = c.slabs;
        options.culling = c.culling;
        options.isa = c.isa;
        options.memory_bytes = c.memory + testing::kSanitizerBytes;
        const Printed printed = testing::print_boxes(assembly(), options);
        ASSERT_TRUE(printed.ok) << printed.error.text();
        EXPECT_EQ(printed.statistics.hash, reference.statistics.hash)
            << c.threads << " threads, " << c.slabs << " slabs, culling " << c.culling << ", isa "
            << c.isa;
        EXPECT_EQ(printed.sink.slices, reference.sink.slices);
        EXPECT_EQ(printed.statistics.voxels_by_code, reference.statistics.voxels_by_code);
    }
}

// A large first slab is printed in two steps, for an early first slice.
void expect_first_slice_changes_nothing(size_t materials) {
    const auto print = [&](const pipeline::PrintOptions& options) {
        return testing::print_boxes(assembly(), options, testing::kPitch, materials);
    };
    const Printed whole = print({});
    ASSERT_TRUE(whole.ok) << whole.error.text();
    const int32_t n = whole.sink.info.size.z;
    ASSERT_GT(whole.statistics.blocks_evaluated, 0);
    for (const Vec2<int32_t>& range : {Vec2<int32_t>{11, n}, Vec2<int32_t>{12, n},
                                       Vec2<int32_t>{15, 20}, Vec2<int32_t>{13, 14}}) {
        pipeline::PrintOptions options;
        options.slices = range;
        const Printed one_step = print(options);
        options.most_blocks_at_first = 0;
        for (int32_t threads : {1, 2}) {
            options.threads = threads;
            const Printed two_steps = print(options);
            ASSERT_TRUE(two_steps.ok) << two_steps.error.text();
            EXPECT_EQ(two_steps.sink.z, one_step.sink.z);
            EXPECT_EQ(two_steps.sink.slices, one_step.sink.slices);
            EXPECT_EQ(two_steps.statistics.hash, one_step.statistics.hash);
            EXPECT_EQ(two_steps.statistics.voxels_by_code, one_step.statistics.voxels_by_code);
            EXPECT_EQ(two_steps.statistics.late_warnings, one_step.statistics.late_warnings);
            EXPECT_EQ(two_steps.statistics.blocks_total, one_step.statistics.blocks_total);
            // Blocks of several slices were evaluated for the first slice, and again for the
            // others.
            const bool alone = range.x % 8 == 7 || range.y - range.x == 1;
            EXPECT_EQ(two_steps.statistics.blocks_evaluated > one_step.statistics.blocks_evaluated,
                      !alone)
                << range.x << " to " << range.y;
        }
    }
}

TEST(BoxPrint, AFirstSliceByItselfChangesNothing) {
    expect_first_slice_changes_nothing(2);
}

TEST(BoxPrint, AFirstSliceOfEightBitsByItselfChangesNothing) {
    expect_first_slice_changes_nothing(20);
}

TEST(BoxPrint, PartsOfTheSlicesAddUpToTheWhole) {
    const Printed whole = testing::print_boxes(assembly());
    ASSERT_TRUE(whole.ok) << whole.error.text();
    const int32_t n = whole.sink.info.size.z;
    uint64_t hash = 0;
    std::vector<std::vector<uint8_t>> slices;
    for (const Vec2<int32_t>& range :
         {Vec2<int32_t>{0, 3}, Vec2<int32_t>{3, 16}, Vec2<int32_t>{16, 17}, Vec2<int32_t>{17, n}}) {
        pipeline::PrintOptions options;
        options.slices = range;
        const Printed part = testing::print_boxes(assembly(), options);
        ASSERT_TRUE(part.ok) << part.error.text();
        EXPECT_EQ(part.sink.info.slice_begin, range.x);
        EXPECT_EQ(part.sink.info.slice_end, range.y);
        EXPECT_EQ(part.sink.z.front(), range.x);
        hash += part.statistics.hash;
        slices.insert(slices.end(), part.sink.slices.begin(), part.sink.slices.end());
    }
    EXPECT_EQ(hash, whole.statistics.hash);
    EXPECT_EQ(slices, whole.sink.slices);
}

}  // namespace
}  // namespace openfab
