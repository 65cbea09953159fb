// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/slice_totals.h"

#include <algorithm>
#include <cstring>
#include <vector>

#include "runtime/pipeline/print_hash.h"

namespace openfab::pipeline {

void SliceTotals::add(const SliceTotals& other) {
    for (size_t c = 0; c < by_code.size(); ++c)
        by_code[c] += other.by_code[c];
    hash += other.hash;
    tight.add(other.tight);
}

namespace {

uint64_t load_word(const uint8_t* data) {
    uint64_t word;
    std::memcpy(&word, data, 8);
    return word;
}

/// Loads bytes as words of 8, padded with zeros.
constexpr size_t words_of(size_t bytes) {
    return (bytes + 7) / 8;
}

// Counts bytes; a run of equal words, as in solid and empty regions, is counted at once.
class ByteHistogram {
  public:
    void add(const uint8_t* data, size_t bytes) {
        size_t i = 0;
        while (i + 8 <= bytes) {
            const uint64_t word = load_word(data + i);
            const size_t end = end_of_run(data, i + 8, bytes, word);
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
    static size_t end_of_run(const uint8_t* data, size_t i, size_t bytes, uint64_t word) {
        for (; i + 32 <= bytes; i += 32) {
            const uint64_t others =
                ((load_word(data + i) ^ word) | (load_word(data + i + 8) ^ word)) |
                ((load_word(data + i + 16) ^ word) | (load_word(data + i + 24) ^ word));
            if (others != 0) break;
        }
        while (i + 8 <= bytes && load_word(data + i) == word)
            i += 8;
        return i;
    }

    int64_t count_[4][256] = {};  // four, so that runs of equal bytes have no dependency chain
};

uint64_t or_of_four(const uint8_t* data) {
    return (load_word(data) | load_word(data + 8)) | (load_word(data + 16) | load_word(data + 24));
}

/// All bytes of the row outside [first, end) are 0; `first` is a multiple of 8.
struct RowSpan {
    size_t first, end;
};
RowSpan find_span(const uint8_t* row, size_t bytes) {
    RowSpan span{0, bytes};
    while (span.first + 32 <= bytes && or_of_four(row + span.first) == 0)
        span.first += 32;
    while (span.end >= span.first + 32 && or_of_four(row + span.end - 32) == 0)
        span.end -= 32;
    return span;
}

/// Merges the row's bits into those of all rows; returns whether there are any.
bool add_columns(const uint8_t* row, RowSpan span, std::vector<uint64_t>* columns) {
    uint64_t all = 0;
    size_t i = span.first;
    uint64_t* column = columns->data() + i / 8;
    for (; i + 8 <= span.end; i += 8) {
        const uint64_t word = load_word(row + i);
        *column++ |= word;
        all |= word;
    }
    if (i < span.end) {
        uint64_t word = 0;
        std::memcpy(&word, row + i, span.end - i);
        *column |= word;
        all |= word;
    }
    return all != 0;
}

}  // namespace

SliceTotals count_slice(const pipeline::SliceView& slice, int32_t bits) {
    SliceTotals totals;
    totals.hash = slice_hash(slice.z, slice.data, slice.row_bytes, slice.height);
    ByteHistogram histogram;
    std::vector<uint64_t> columns(words_of(slice.row_bytes), 0);
    int64_t empty_rows = 0, zeros = 0;
    int32_t first_y = slice.height, end_y = 0;
    for (int32_t y = 0; y < slice.height; ++y) {
        const uint8_t* row = slice.data + static_cast<size_t>(y) * slice.row_bytes;
        const RowSpan span = find_span(row, slice.row_bytes);
        if (!add_columns(row, span, &columns)) {
            ++empty_rows;
            continue;
        }
        histogram.add(row + span.first, span.end - span.first);
        zeros += static_cast<int64_t>(slice.row_bytes - (span.end - span.first));
        first_y = std::min(first_y, y);
        end_y = y + 1;
    }
    histogram.sum(bits, &totals.by_code);
    totals.by_code[0] += empty_rows * slice.width + zeros * (8 / bits);
    // The unused half byte of odd widths is 0 and was counted as a void voxel in rows that are not
    // empty.
    if (bits == 4) totals.by_code[0] -= (slice.width & 1) * (slice.height - empty_rows);
    if (end_y == 0) return totals;
    const auto set = [&](int32_t x) {
        const auto bit = static_cast<size_t>(x) * static_cast<size_t>(bits);
        return (columns[bit / 64] >> bit % 64 & ((1u << bits) - 1)) != 0;
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

}  // namespace openfab::pipeline
