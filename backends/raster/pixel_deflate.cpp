// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/raster/pixel_deflate.h"

#include <libdeflate.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "backends/raster/deflate_block.h"

namespace openfab::raster {

namespace {

constexpr int32_t kMaxDistance = 32768;  // bytes, of deflate
constexpr int32_t kMaxPixels = 64;       // 256 bytes; deflate's longest match is 258
constexpr size_t kBlockTokens = 1U << 15;
constexpr int kHashBits = 13;
constexpr int32_t kLongContext = 8;  // pixels
constexpr int32_t kShortContext = 4;

/// What stands in the stream: the filter byte of a row, a pixel in full, or a copy of earlier
/// pixels.
struct Token {
    uint8_t pixels = 0;  ///< 0: filter byte or one literal pixel
    uint8_t code = 0;    ///< of a literal pixel
    bool filter = false;
    uint16_t distance = 0;  ///< bytes, less 1
};

struct Place {
    int64_t pixel = -1;  ///< counted through the picture
    int32_t row = 0;
};

/// Turns tokens into blocks.
class TokenWriter {
  public:
    TokenWriter(const std::vector<PixelColor>& colors, std::vector<uint8_t>* out)
        : colors_(colors), bits_(out) {
        for (int32_t n = 1; n <= kMaxPixels; ++n)
            lengths_[static_cast<size_t>(n)] = code_length(4 * n);
        tokens_.reserve(kBlockTokens);
    }
    void add(const Token& token) {
        tokens_.push_back(token);
        if (tokens_.size() == kBlockTokens) flush(false);
    }
    void finish() {
        flush(true);
        bits_.align();
    }

  private:
    struct Bits {
        uint64_t bits = 0;
        int count = 0;
        void append(uint64_t more, int n) {
            bits |= more << count;
            count += n;
        }
    };

    void flush(bool last) {
        count();
        const PrefixCode literals = make_prefix_code(literal_counts_, 15);
        const PrefixCode distances = make_prefix_code(distance_counts_, 15);
        write_block_head(&bits_, last, literals, distances);
        std::array<Bits, kMaxPixels + 1> lengths;
        for (size_t n = 1; n < lengths.size(); ++n) {
            lengths[n].append(literals.bits[lengths_[n].symbol],
                              literals.length[lengths_[n].symbol]);
            lengths[n].append(lengths_[n].extra, lengths_[n].extra_count);
        }
        for (const Token& token : tokens_) {
            if (token.pixels == 0) {
                write_literal(token, literals);
                continue;
            }
            Bits all = lengths[token.pixels];
            const Coded distance = code_distance(token.distance + 1);
            all.append(distances.bits[distance.symbol], distances.length[distance.symbol]);
            all.append(distance.extra, distance.extra_count);
            bits_.put(all.bits, all.count);  // 15 + 5 + 15 + 13 at most
        }
        bits_.put(literals.bits[kEndOfBlock], literals.length[kEndOfBlock]);
        tokens_.clear();
    }
    void write_literal(const Token& token, const PrefixCode& literals) {
        if (token.filter) {
            bits_.put(literals.bits[0], literals.length[0]);
            return;
        }
        for (uint8_t byte : colors_[token.code])
            bits_.put(literals.bits[byte], literals.length[byte]);
    }
    void count() {
        literal_counts_.fill(0);
        distance_counts_.fill(0);
        for (const Token& token : tokens_) {
            if (token.pixels > 0) {
                ++literal_counts_[lengths_[token.pixels].symbol];
                ++distance_counts_[code_distance(token.distance + 1).symbol];
            } else if (token.filter) {
                ++literal_counts_[0];
            } else {
                for (uint8_t byte : colors_[token.code])
                    ++literal_counts_[byte];
            }
        }
        ++literal_counts_[kEndOfBlock];
    }

    const std::vector<PixelColor>& colors_;
    BitWriter bits_;
    std::vector<Token> tokens_;
    std::array<Coded, kMaxPixels + 1> lengths_;
    std::array<uint32_t, kLiteralSymbols> literal_counts_{};
    std::array<uint32_t, kDistanceSymbols> distance_counts_{};
};

template <typename T>
T load(const uint8_t* p) {
    T value;
    std::memcpy(&value, p, sizeof(T));
    return value;
}

/// How many of `most` pixels are the same at a and b; reads at most 7 beyond.
int32_t equal_pixels(const uint8_t* a, const uint8_t* b, int32_t most) {
    for (int32_t n = 0; n < most; n += 8) {
        const uint64_t differ = load<uint64_t>(a + n) ^ load<uint64_t>(b + n);
        if (differ != 0) return std::min(most, n + std::countr_zero(differ) / 8);
    }
    return most;
}

/// Finds copies in a window of rows.
class Matcher {
  public:
    Matcher(int32_t width, TokenWriter* out)
        : width_(width),
          row_bytes_(4 * static_cast<int64_t>(width) + 1),
          rows_back_(std::min<int64_t>(kMaxDistance / row_bytes_, 1 << 20)),
          rows_held_(2 * rows_back_ + 8),
          codes_(static_cast<size_t>(rows_held_ * width) + kSlack),
          long_(size_t{1} << kHashBits),
          short_(size_t{1} << kHashBits),
          out_(out) {}

    /// Where the codes of the next row go.
    uint8_t* next_row() {
        if (row_ - first_row_ == rows_held_) drop_rows();
        return at(row_, 0);
    }

    void add_row() {
        out_->add({0, 0, true, 0});
        for (int32_t x = 0; x < width_;) {
            const Token token = choose(x);
            out_->add(token);
            x += std::max<int32_t>(token.pixels, 1);
        }
        ++row_;
    }

  private:
    // equal_pixels and the hashes read whole words.
    static constexpr size_t kSlack = 16;

    uint8_t* at(int64_t row, int32_t x) { return codes_.data() + (row - first_row_) * width_ + x; }

    /// Keeps what matches can still reach.
    void drop_rows() {
        const int64_t kept = rows_back_;
        std::memmove(codes_.data(), at(row_ - kept, 0), static_cast<size_t>(kept * width_));
        first_row_ = row_ - kept;
    }

    /// The longest copy that can be had cheaply: of the pixel before, of the row above, of where
    /// the next few pixels were seen last; else the pixel itself.
    Token choose(int32_t x) {
        const uint8_t* here = at(row_, x);
        const int32_t most = std::min(width_ - x, kMaxPixels);
        Token best{0, *here, false, 0};
        if (x > 0) try_copy(here, row_, x - 1, x, most, &best);
        if (rows_back_ > 0 && row_ > first_row_ && best.pixels < most)
            try_copy(here, row_ - 1, x, x, most, &best);
        // A long run has cost little so far; looking further gains nothing on it.
        if (best.pixels >= 2 * kLongContext || best.pixels == most) return best;
        if (most >= kShortContext) {
            // Both are looked up, since the place of a longer context is the better bet but may lie
            // beyond the window.
            if (most >= kLongContext) {
                try_place(here, &long_[hash(load<uint64_t>(here))], x, most, &best);
            }
            try_place(here, &short_[hash(load<uint32_t>(here))], x, most, &best);
        }
        return best;
    }

    static size_t hash(uint64_t pixels) {
        return (pixels * 0x9E3779B97F4A7C15ULL) >> (64 - kHashBits);
    }

    void try_place(const uint8_t* here, Place* place, int32_t x, int32_t most, Token* best) {
        const int64_t self = row_ * width_ + x;
        if (place->pixel >= first_row_ * width_) {
            const auto from =
                static_cast<int32_t>(place->pixel - static_cast<int64_t>(place->row) * width_);
            try_copy(here, place->row, from, x, most, best);
        }
        *place = {self, static_cast<int32_t>(row_)};
    }

    /// Takes the copy of pixels at (row, from) where it is longer than the best and within reach.
    void try_copy(const uint8_t* here, int64_t row, int32_t from, int32_t x, int32_t most,
                  Token* best) {
        const int64_t distance = (row_ - row) * row_bytes_ + 4 * (static_cast<int64_t>(x) - from);
        if (distance > kMaxDistance) return;
        const int32_t n =
            equal_pixels(here, at(row, from), std::min(most, row == row_ ? most : width_ - from));
        // Farther copies cost more bits: one must be longer to be better.
        if (n <= best->pixels) return;
        best->pixels = static_cast<uint8_t>(n);
        best->distance = static_cast<uint16_t>(distance - 1);
    }

    int32_t width_;
    int64_t row_bytes_;
    int64_t rows_back_;
    int64_t rows_held_;
    std::vector<uint8_t> codes_;
    std::vector<Place> long_;
    std::vector<Place> short_;
    TokenWriter* out_;
    int64_t row_ = 0;
    int64_t first_row_ = 0;  ///< row at the start of codes_
};

}  // namespace

void deflate_pixels(int32_t width, int32_t height, const std::vector<PixelColor>& colors,
                    const std::function<void(int32_t row, uint8_t* codes)>& row_codes,
                    std::vector<uint8_t>* out) {
    out->insert(out->end(), {0x78, 0x01});  // deflate with a 32 kB window, fast
    TokenWriter writer(colors, out);
    Matcher matcher(width, &writer);
    std::vector<uint8_t> pixels(4 * static_cast<size_t>(width) + 1);
    uint32_t checksum = 1;
    for (int32_t row = 0; row < height; ++row) {
        uint8_t* codes = matcher.next_row();
        row_codes(row, codes);
        for (int32_t x = 0; x < width; ++x)
            std::memcpy(&pixels[4 * static_cast<size_t>(x) + 1], &colors[codes[x]], 4);
        checksum = libdeflate_adler32(checksum, pixels.data(), pixels.size());
        matcher.add_row();
    }
    writer.finish();
    for (int shift = 24; shift >= 0; shift -= 8)
        out->push_back(static_cast<uint8_t>(checksum >> shift));
}

}  // namespace openfab::raster
