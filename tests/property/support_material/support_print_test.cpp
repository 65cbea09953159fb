// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Prints with support against the same prints without, whose columns are scanned plainly.

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "tests/support/prints/box_print.h"
#include "tests/support/prints/test_fablets.h"
#include "tests/support/reference/column_scan.h"
#include "tests/support/surface/worlds.h"

namespace openfab {
namespace {

using testing::BoxPart;

struct Printed {
    testing::MemorySink sink;
    pipeline::PrintStatistics statistics;
    std::vector<uint8_t> codes;
};

Printed print(pipeline::PrintInput input, pipeline::PrintOptions options) {
    Printed out;
    options.memory_bytes += testing::kSanitizerBytes;
    auto made = pipeline::PrintJob::create(std::move(input), options);
    if (!made) {
        ADD_FAILURE() << made.error().text();
        return out;
    }
    const std::atomic<bool> interrupt{false};
    const Result<void> ran = (*made)->run(out.sink, {}, interrupt, &out.statistics);
    EXPECT_TRUE(ran);
    out.codes = out.sink.codes();
    return out;
}

/// The same with a support material, which is added as the last.
pipeline::PrintInput with_support(pipeline::PrintInput input) {
    input.materials.emplace_back();
    input.materials.back().name = "support";
    input.support_code = static_cast<int32_t>(input.materials.size());
    return input;
}

/// The support that the columns of a print without support require.
std::vector<uint8_t> scanned(const Printed& without, const pipeline::PrintInput& input) {
    return reference::add_support(without.codes, without.codes, without.sink.info.size,
                                  static_cast<uint8_t>(input.materials.size() + 1));
}

void expect_equal(const pipeline::PrintInput& input, const pipeline::PrintOptions& options = {}) {
    const Printed without = print(input, options), with = print(with_support(input), options);
    const std::vector<uint8_t> expected = scanned(without, input);
    ASSERT_EQ(with.codes.size(), expected.size());
    EXPECT_TRUE(with.codes == expected);
    const auto code = static_cast<uint8_t>(input.materials.size() + 1);
    const int64_t supported = std::count(expected.begin(), expected.end(), code);
    EXPECT_GT(supported, 100) << "the scene shows too little";
    EXPECT_EQ(with.statistics.voxels_support, supported);
    EXPECT_EQ(with.statistics.voxels_solid, without.statistics.voxels_solid);
    EXPECT_EQ(with.statistics.voxels_by_code.back(), supported);
    EXPECT_EQ(with.sink.info.support_code, code);
}

/// At least the scanned support; nothing but void becomes support.
void expect_no_less(const pipeline::PrintInput& input, const pipeline::PrintOptions& options = {}) {
    const Printed without = print(input, options), with = print(with_support(input), options);
    const std::vector<uint8_t> expected = scanned(without, input);
    ASSERT_EQ(with.codes.size(), expected.size());
    const auto code = static_cast<uint8_t>(input.materials.size() + 1);
    int64_t missing = 0, changed = 0, supported = 0;
    for (size_t v = 0; v < expected.size(); ++v) {
        if (with.codes[v] == expected[v]) continue;
        missing += expected[v] == code ? 1 : 0;
        changed += expected[v] != 0 ? 1 : 0;
        changed += with.codes[v] != code ? 1 : 0;
    }
    for (const uint8_t c : expected)
        supported += c == code ? 1 : 0;
    EXPECT_EQ(missing, 0);
    EXPECT_EQ(changed, 0);
    EXPECT_GT(supported, 100) << "the scene shows too little";
}

/// A table with a shelf, a lid that floats over both, and a block embedded in another.
std::vector<BoxPart> overhangs(const openfab_fablet& fablet) {
    return {
        {{0.013, 0.021, 0.019}, {1.03, 1.11, 2.37}, &fablet},
        {{0.513, -1.271, 2.119}, {4.03, 3.11, 0.37}, &fablet, 1},
        {{-0.613, 1.671, 3.119}, {6.93, 2.11, 0.47}, &fablet, 0, {2, 1, 0}},
        {{3.013, 2.071, 1.019}, {2.03, 2.11, 0.77}, &fablet, -1, {2, 1, 0}},
    };
}

TEST(SupportPrint, IsWhatTheColumnsOfUndisplacedPartsCallFor) {
    expect_equal(testing::make_input(overhangs(testing::solid_fablet())));
    expect_equal(testing::make_input(overhangs(testing::tint_fablet())));
    expect_equal(testing::make_input(overhangs(testing::picture_fablet())));
}

TEST(SupportPrint, PacksWhatItNeeds) {
    for (const size_t materials : {size_t{14}, size_t{15}, size_t{20}}) {
        const pipeline::PrintInput input =
            testing::make_input(overhangs(testing::tint_fablet()), testing::kPitch, materials);
        expect_equal(input);
        EXPECT_EQ(print(with_support(input), {}).sink.info.bits, materials < 15 ? 4 : 8);
    }
}

TEST(SupportPrint, IsNeverLessWhereFabletsReturnVoid) {
    std::vector<BoxPart> boxes = overhangs(testing::skin_fablet());
    expect_no_less(testing::make_input(boxes));
    boxes.push_back({{0.813, -0.571, 2.019}, {1.03, 1.11, 0.97}, &testing::hole_fablet(), 5});
    expect_no_less(testing::make_input(boxes));
}

TEST(SupportPrint, MayBeOfAMaterialThatPartsHaveToo) {
    pipeline::PrintInput input = testing::make_input(overhangs(testing::tint_fablet()));
    const Printed without = print(input, {});
    input.support_code = 2;
    const Printed with = print(input, {});
    EXPECT_TRUE(with.codes ==
                reference::add_support(without.codes, without.codes, without.sink.info.size, 2));
}

TEST(SupportPrint, IsNotPutBelowPartsThatAskForNone) {
    const std::vector<BoxPart> boxes = overhangs(testing::solid_fablet());
    pipeline::PrintInput input = testing::make_input(boxes);
    const Printed without = print(input, {});
    input.parts[2].support = false;
    const Printed with = print(with_support(input), {});
    const std::vector<uint8_t> asking =
        testing::reference_codes({boxes[0], boxes[1], boxes[3]}, without.sink.info, 0);
    EXPECT_TRUE(with.codes ==
                reference::add_support(without.codes, asking, without.sink.info.size, 3));
    for (part::Part& part : input.parts)
        part.support = false;
    EXPECT_TRUE(print(with_support(input), {}).codes == without.codes);
}

TEST(SupportPrint, IsTheSameForAnySettingsAndSlices) {
    const pipeline::PrintInput input =
        with_support(testing::make_input(overhangs(testing::skin_fablet())));
    const Printed whole = print(input, {});
    for (const int32_t threads : {1, 2, 4}) {
        for (const bool culling : {true, false}) {
            pipeline::PrintOptions options;
            options.threads = threads;
            options.culling = culling;
            options.slabs_in_flight = 1 + threads;
            options.isa = threads == 2 ? OPENFAB_ISA_SSE41 : OPENFAB_ISA_AVX2;
            const Printed other = print(input, options);
            EXPECT_TRUE(other.codes == whole.codes);
            EXPECT_EQ(other.statistics.hash, whole.statistics.hash);
        }
    }
    const int32_t height = whole.sink.info.size.z;
    for (const int32_t cut : {1, 8, 13, height / 2, height - 1}) {
        std::vector<uint8_t> joined;
        uint64_t hash = 0;
        for (const Vec2<int32_t> part : {Vec2<int32_t>{0, cut}, Vec2<int32_t>{cut, height}}) {
            pipeline::PrintOptions options;
            options.slices = part;
            const Printed half = print(input, options);
            joined.insert(joined.end(), half.codes.begin(), half.codes.end());
            hash += half.statistics.hash;
        }
        EXPECT_TRUE(joined == whole.codes) << cut;
        EXPECT_EQ(hash, whole.statistics.hash);
    }
}

// A wider grid moves no voxel; slices of the bed below floating parts are support.
TEST(SupportPrint, ReachesTheBottomOfTheGrid) {
    pipeline::PrintInput input = testing::make_input(overhangs(testing::solid_fablet()));
    input.crop_mm = Box3d{{-4, -3, -2}, {9, 7, -2}};
    expect_equal(input);
}

// Many small parts in rows and over each other: rows and blocks that hold support alone.
TEST(SupportPrint, OfRandomBoxesIsWhatTheColumnsCallFor) {
    for (uint32_t seed = 1; seed <= 6; ++seed) {
        std::mt19937 random(seed);
        const auto number = [&](double lo, double hi) {
            return lo + (hi - lo) * static_cast<double>(random() % 10007) / 10007;
        };
        std::vector<BoxPart> boxes;
        for (int k = 0; k < 25; ++k) {
            BoxPart box{{number(0, 12), number(0, 9), number(0, 3)},
                        {number(0.05, 3), number(0.05, 2), number(0.02, 0.8)},
                        k % 2 == 0 ? &testing::solid_fablet() : &testing::tint_fablet(),
                        static_cast<int32_t>(random() % 3)};
            boxes.push_back(box);
        }
        expect_equal(testing::make_input(boxes));
    }
}

pipeline::PrintInput part_input(const std::vector<part::Part>& parts, const Vec3d& pitch_mm) {
    pipeline::PrintInput input;
    input.parts = parts;
    input.pitch_mm = pitch_mm;
    input.materials.resize(2);
    input.materials[0].name = "white";
    input.materials[1].name = "black";
    return input;
}

TEST(SupportPrint, OfMirroredAndShearedMeshesIsWhatTheColumnsCallFor) {
    std::vector<part::Part> parts;
    const std::vector<std::array<double, 9>> turns{
        {1, 0, 0, 0, 1, 0, 0, 0, 1},
        {-1, 0, 0, 0, 1, 0, 0, 0, 1},
        {1, 0.4, 0.3, 0, 1.2, -0.5, 0.2, 0, -0.9},
        {0.36, 0.48, -0.8, -0.8, 0.6, 0, 0.48, 0.64, 0.6}};
    for (size_t k = 0; k < 2 * turns.size(); ++k) {
        testing::PartOptions options;
        options.transform.m = turns[k % turns.size()];
        options.transform.t = {1.7 * static_cast<double>(k % 3), 1.1 * static_cast<double>(k / 3),
                               0.9 * static_cast<double>(k)};
        options.instance = static_cast<int32_t>(k);
        options.priority = static_cast<int32_t>(k % 2);
        options.slot_material = {1, 2, 0};
        const mesh::Mesh mesh =
            k % 2 == 0 ? testing::torus(1, 0.35, 19, 9)
                       : testing::shaken(testing::sphere(0.9, 9, 7), static_cast<uint32_t>(k), 0.2);
        parts.push_back(testing::make_part(testing::tint_fablet(), mesh, options));
    }
    expect_equal(part_input(parts, {0.11, 0.13, 0.07}));
    expect_equal(part_input(parts, {0.05, 0.04, 0.2}));
}

}  // namespace
}  // namespace openfab
