// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Whole prints of boxes against the plain reference, voxel for voxel, and one output whatever the
// settings.

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/slab/box_print.h"
#include "tests/support/slab/test_fablets.h"

namespace openfab {
namespace {

using tests::BoxPart;
using tests::Printed;

// Corners are off the grid, so that no voxel centre is equally far from two sides or exactly at the
// skin's depth.
std::vector<BoxPart> one_skin() {
    return {{{0.513, -0.271, 0.019}, {5.03, 4.11, 2.37}, &tests::skin_fablet()}};
}
std::vector<BoxPart> one_picture() {
    return {{{-3.013, 1.071, 0.019}, {7.03, 4.11, 1.37}, &tests::picture_fablet()}};
}
std::vector<BoxPart> assembly() {
    return {
        {{0.013, 0.021, 0.019}, {6.03, 5.11, 2.37}, &tests::skin_fablet()},
        {{1.513, 1.271, 0.519}, {2.03, 2.11, 2.37}, &tests::tint_fablet()},      // later: wins
        {{2.113, 0.671, -0.419}, {0.93, 3.11, 1.37}, &tests::hole_fablet(), 5},  // cuts a hole
        {{3.013, 2.071, 1.019},
         {5.03, 4.11, 2.37},
         &tests::picture_fablet(),
         -1,
         {2, 1, 0}},  // gives way
        {{4.113, 0.371, 1.219}, {1.33, 1.11, 0.37}, &tests::solid_fablet(), 1, {2, 2, 0}},
    };
}

void expect_reference(const std::vector<BoxPart>& boxes, uint64_t seed) {
    slab::PrintOptions options;
    options.seed = seed;
    const Printed printed = tests::print_boxes(boxes, options);
    ASSERT_TRUE(printed.ok) << printed.error.message;
    const std::vector<uint8_t> codes = printed.sink.codes();
    const std::vector<uint8_t> expected = tests::reference_codes(boxes, printed.sink.info, seed);
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

TEST(BoxPrint, SkinIsTheReference) {
    expect_reference(one_skin(), 1);
}
TEST(BoxPrint, PictureIsTheReference) {
    expect_reference(one_picture(), 2);
}
TEST(BoxPrint, AssemblyIsTheReference) {
    expect_reference(assembly(), 3);
}

TEST(BoxPrint, OneOutputWhateverTheSettings) {
    slab::PrintOptions plain;
    plain.threads = 1;
    const Printed reference = tests::print_boxes(assembly(), plain);
    ASSERT_TRUE(reference.ok) << reference.error.message;
    struct Case {
        int32_t threads, groups;
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
        slab::PrintOptions options;
        options.threads = c.threads;
        options.groups_in_flight = c.groups;
        options.culling = c.culling;
        options.isa = c.isa;
        options.memory_bytes = c.memory;
        const Printed printed = tests::print_boxes(assembly(), options);
        ASSERT_TRUE(printed.ok) << printed.error.message;
        EXPECT_EQ(printed.statistics.hash, reference.statistics.hash)
            << c.threads << " threads, " << c.groups << " groups, culling " << c.culling << ", isa "
            << c.isa;
        EXPECT_EQ(printed.sink.slices, reference.sink.slices);
        EXPECT_EQ(printed.statistics.voxels_by_code, reference.statistics.voxels_by_code);
    }
}

TEST(BoxPrint, PartsOfTheSlicesAddUpToTheWhole) {
    const Printed whole = tests::print_boxes(assembly());
    ASSERT_TRUE(whole.ok) << whole.error.message;
    const int32_t n = whole.sink.info.size.z;
    uint64_t hash = 0;
    std::vector<std::vector<uint8_t>> slices;
    for (const Vec2<int32_t>& range :
         {Vec2<int32_t>{0, 3}, Vec2<int32_t>{3, 16}, Vec2<int32_t>{16, 17}, Vec2<int32_t>{17, n}}) {
        slab::PrintOptions options;
        options.slices = range;
        const Printed part = tests::print_boxes(assembly(), options);
        ASSERT_TRUE(part.ok) << part.error.message;
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
