// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/slab/slice_totals.h"

#include <algorithm>
#include <cstring>
#include <vector>

#include "runtime/slab/print_hash.h"

namespace openfab::slab {

void SliceTotals::add(const SliceTotals& other) {
    for (size_t c = 0; c < by_code.size(); ++c)
        by_code[c] += other.by_code[c];
    hash += other.hash;
    tight.add(other.tight);
}

namespace {

// Counts bytes; words that repeat, as in solid and empty regions, are counted once for the whole
// run.
class ByteHistogram {
  public:
    void add(const uint8_t* data, size_t bytes) {
        size_t i = 0;
        while (i + 8 <= bytes) {
            uint64_t word;
            std::memcpy(&word, data + i, 8);
            size_t end = i + 8;
            uint64_t next = word;
            while (end + 8 <= bytes && (std::memcpy(&next, data + end, 8), next == word))
                end += 8;
            const auto times = static_cast<int64_t>((end - i) / 8);
            for (int b = 0; b < 8; ++b)
                count_[b % 4][word >> (8 * b) & 255] += times;
            i = end;
        }
        for (; i < bytes; ++i)
            ++count_[0][data[i]];
    }
    /// Adds the one or two codes of each byte.
    void sum(int32_t bits, std::array<int64_t, 256>* by_code) const {
        for (size_t byte = 0; byte < 256; ++byte) {
            const int64_t n = count_[0][byte] + count_[1][byte] + count_[2][byte] + count_[3][byte];
            if (bits == 8) {
                (*by_code)[byte] += n;
                continue;
            }
            (*by_code)[byte & 15] += n;
            (*by_code)[byte >> 4] += n;
        }
    }

  private:
    int64_t count_[4][256] = {};  // four, so that equal bytes in a row do not wait for each other
};

bool any_set(const uint8_t* data, size_t bytes) {
    uint64_t all = 0, word;
    size_t i = 0;
    for (; i + 8 <= bytes; i += 8) {
        std::memcpy(&word, data + i, 8);
        all |= word;
    }
    for (; i < bytes; ++i)
        all |= data[i];
    return all != 0;
}

}  // namespace

SliceTotals count_slice(const backends::SliceView& slice, int32_t bits) {
    SliceTotals totals;
    totals.hash = slice_hash(slice.z, slice.data, slice.row_bytes, slice.height);
    ByteHistogram histogram;
    std::vector<uint8_t> columns(slice.row_bytes, 0);
    int64_t empty_rows = 0;
    int32_t first_y = slice.height, end_y = 0;
    for (int32_t y = 0; y < slice.height; ++y) {
        const uint8_t* row = slice.data + static_cast<size_t>(y) * slice.row_bytes;
        if (!any_set(row, slice.row_bytes)) {
            ++empty_rows;
            continue;
        }
        histogram.add(row, slice.row_bytes);
        for (size_t i = 0; i < slice.row_bytes; ++i)
            columns[i] |= row[i];
        first_y = std::min(first_y, y);
        end_y = y + 1;
    }
    histogram.sum(bits, &totals.by_code);
    totals.by_code[0] += empty_rows * slice.width;
    // The unused half byte of odd widths is 0 and was counted as a void voxel in rows that are not
    // empty.
    if (bits == 4) totals.by_code[0] -= (slice.width & 1) * (slice.height - empty_rows);
    if (end_y == 0) return totals;
    const auto set = [&](int32_t x) {
        if (bits == 8) return columns[static_cast<size_t>(x)] != 0;
        return (columns[static_cast<size_t>(x / 2)] >> (x % 2 * 4) & 15) != 0;
    };
    int32_t first_x = 0, end_x = slice.width;
    while (!set(first_x))
        ++first_x;
    while (!set(end_x - 1))
        --end_x;
    totals.tight.lo = {first_x, first_y, slice.z};
    totals.tight.hi = {end_x, end_y, slice.z + 1};
    return totals;
}

}  // namespace openfab::slab
