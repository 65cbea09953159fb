// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Slices of codes and bits at lattice points, with scans over them for changes.

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <vector>

#include "runtime/pipeline/slice_sink.h"

namespace openfab::boundary {

/// The codes of one slice with a border of void around it: rows -1 to height, in a row x from -1 to
/// width, and 7 more that scans by eight may read.
class Layer {
  public:
    Layer(int32_t width, int32_t height);
    void fill(const pipeline::SliceView& slice, int32_t bits);
    void clear();
    const uint8_t* row(int32_t y) const {
        return codes_.data() + (static_cast<size_t>(y) + 1) * stride_ + 1;
    }

  private:
    size_t stride_;
    std::vector<uint8_t> codes_;
};

/// A bit for each lattice point (x, y) of a plane, or for each edge that begins there.
class BitPlane {
  public:
    BitPlane(int32_t width, int32_t height)
        : words_((static_cast<size_t>(width) + 64) / 64),
          height_(height),
          bits_(words_ * (static_cast<size_t>(height) + 1)) {}

    void clear() { std::fill(bits_.begin(), bits_.end(), 0); }
    void set(int32_t x, int32_t y) { bits_[index(x, y)] |= uint64_t{1} << (x & 63); }
    bool get(int32_t x, int32_t y) const { return (bits_[index(x, y)] >> (x & 63) & 1) != 0; }
    size_t words() const { return words_; }     ///< of a row
    int32_t height() const { return height_; }  ///< the last row
    uint64_t word(size_t w, int32_t y) const { return bits_[static_cast<size_t>(y) * words_ + w]; }

  private:
    size_t index(int32_t x, int32_t y) const {
        return static_cast<size_t>(y) * words_ + static_cast<size_t>(x >> 6);
    }

    size_t words_;
    int32_t height_;
    std::vector<uint64_t> bits_;
};

/// Returns the codes of the 8 voxels around lattice point (x, y) between two layers, by octant.
inline std::array<uint8_t, 8> octants(const Layer& below, const Layer& above, int32_t x,
                                      int32_t y) {
    std::array<uint8_t, 8> codes{};
    for (int32_t dy = 0; dy < 2; ++dy) {
        const auto low = static_cast<size_t>(dy) * 2;
        std::memcpy(&codes[low], below.row(y - 1 + dy) + x - 1, 2);
        std::memcpy(&codes[low + 4], above.row(y - 1 + dy) + x - 1, 2);
    }
    return codes;
}

inline uint64_t eight_codes(const uint8_t* at) {
    uint64_t codes = 0;
    std::memcpy(&codes, at, sizeof codes);
    return codes;
}

/// Calls visit(x0, x1, low, high) for each longest run in which two rows differ and neither
/// changes.
template <typename Visit>
void for_each_run(const uint8_t* low, const uint8_t* high, int32_t count, Visit visit) {
    constexpr uint64_t kEach = 0x0101010101010101;
    for (int32_t x = 0; x < count;) {
        if (low[x] == high[x]) {
            // Beyond the row both are void, so the scan does not overrun the end by much.
            ++x;
            while (x < count && eight_codes(low + x) == eight_codes(high + x))
                x += 8;
            while (x < count && low[x] == high[x])
                ++x;
            continue;
        }
        int32_t end = x + 1;
        while (end + 8 <= count && eight_codes(low + end) == kEach * low[x] &&
               eight_codes(high + end) == kEach * high[x])
            end += 8;
        while (end < count && low[end] == low[x] && high[end] == high[x])
            ++end;
        visit(x, end, low[x], high[x]);
        x = end;
    }
}

/// Returns whether a material has two of the four voxels around an edge that touch only there; the
/// voxels are given in order around it.
inline bool is_crossing(uint8_t a, uint8_t b, uint8_t c, uint8_t d) {
    return (a == c && a != 0 && a != b && a != d) || (b == d && b != 0 && b != a && b != c);
}

/// Calls visit(x) where the voxels a[x], b[x], c[x], d[x] around an edge are a crossing.
template <typename Visit>
void for_each_crossing(const uint8_t* a, const uint8_t* b, const uint8_t* c, const uint8_t* d,
                       int32_t count, Visit visit) {
    for (int32_t x = 0; x < count; x += 8) {
        const uint64_t wa = eight_codes(a + x), wb = eight_codes(b + x), wc = eight_codes(c + x),
                       wd = eight_codes(d + x);
        // In a crossing no two neighbours are equal.
        if (wa == wb || wb == wc || wc == wd || wd == wa) continue;
        for (int32_t i = x; i < x + 8 && i < count; ++i) {
            if (is_crossing(a[i], b[i], c[i], d[i])) visit(i);
        }
    }
}

}  // namespace openfab::boundary
