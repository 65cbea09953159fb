// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <random>

#include "abi/stages.h"
#include "tests/support/reference/pack.h"
#include "tests/support/stages/field_printer.h"

namespace openfab {
namespace {

TEST(Pack, SameBytesAsTheTwinForEveryWidth) {
    std::mt19937 random(3);
    for (openfab_isa isa : testing::runnable_isas()) {
        for (int32_t bytes : {1, 2, 3, 4, 7, 8, 15, 16, 17, 33, 64}) {
            const int32_t rows = 3, width = 2 * bytes;
            std::vector<uint8_t> codes(static_cast<size_t>(width) * rows * 8);
            for (uint8_t& c : codes)
                c = static_cast<uint8_t>(random() % 16);
            // A byte more a row than is written, to see that nothing is written beyond.
            std::vector<uint8_t> planes(static_cast<size_t>(bytes + 1) * rows * 8, 0xee);
            ASSERT_TRUE(abi::pack(isa, 4, codes.data(), width * 8, bytes, rows, planes.data(),
                                  bytes + 1, (bytes + 1) * rows)
                            .ok());
            for (int32_t z = 0; z < 8; ++z) {
                for (int32_t y = 0; y < rows; ++y) {
                    std::vector<uint8_t> row_codes;
                    for (int32_t x = 0; x < width; ++x)
                        row_codes.push_back(codes[(y * width + x) * 8 + z]);
                    std::vector<uint8_t> expected = reference::pack_row(row_codes);
                    expected.push_back(0xee);
                    const uint8_t* row = &planes[static_cast<size_t>((z * rows + y) * (bytes + 1))];
                    EXPECT_EQ(std::vector<uint8_t>(row, row + bytes + 1), expected);
                }
            }
        }
    }
}

TEST(Pack, EightBitsAreTheCodes) {
    std::mt19937 random(3);
    for (openfab_isa isa : testing::runnable_isas()) {
        for (int32_t width : {1, 7, 8, 17, 64}) {
            const int32_t rows = 3;
            std::vector<uint8_t> codes(static_cast<size_t>(width) * rows * 8);
            for (uint8_t& c : codes)
                c = static_cast<uint8_t>(random() % 65);
            std::vector<uint8_t> planes(static_cast<size_t>(width + 1) * rows * 8, 0xee);
            ASSERT_TRUE(abi::pack(isa, 8, codes.data(), width * 8, width, rows, planes.data(),
                                  width + 1, (width + 1) * rows)
                            .ok());
            size_t i = 0;
            for (int32_t z = 0; z < 8; ++z) {
                for (int32_t y = 0; y < rows; ++y) {
                    for (int32_t x = 0; x < width; ++x)
                        ASSERT_EQ(planes[i++], codes[static_cast<size_t>((y * width + x) * 8 + z)]);
                    ASSERT_EQ(planes[i++], 0xee);
                }
            }
        }
    }
}

}  // namespace
}  // namespace openfab
