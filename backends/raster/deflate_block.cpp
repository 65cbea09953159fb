// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "backends/raster/deflate_block.h"

#include <algorithm>
#include <bit>

namespace openfab::raster {

namespace {

struct Node {
    uint64_t weight = 0;
    int32_t parent = -1;
    int32_t symbol = -1;
};

/// How many codes there are of each length, for the sorted symbols' optimal tree; depths beyond
/// max_length count there.
std::vector<int32_t> optimal_lengths(std::span<const Node> sorted, int max_length) {
    const auto leaves = static_cast<int32_t>(sorted.size());
    std::vector<Node> nodes(sorted.begin(), sorted.end());
    // Leaves by weight, then inner nodes, which come out by weight too: the two lightest are at the
    // two fronts.
    int32_t leaf = 0;
    int32_t inner = leaves;
    const auto take = [&] {
        const auto made = static_cast<int32_t>(nodes.size());
        if (leaf < leaves && (inner == made || nodes[static_cast<size_t>(leaf)].weight <=
                                                   nodes[static_cast<size_t>(inner)].weight)) {
            return leaf++;
        }
        return inner++;
    };
    for (int32_t i = 1; i < leaves; ++i) {
        const int32_t a = take();
        const int32_t b = take();
        const auto made = static_cast<int32_t>(nodes.size());
        nodes.push_back(
            {nodes[static_cast<size_t>(a)].weight + nodes[static_cast<size_t>(b)].weight});
        nodes[static_cast<size_t>(a)].parent = made;
        nodes[static_cast<size_t>(b)].parent = made;
    }
    std::vector<int32_t> depth(nodes.size(), 0);
    std::vector<int32_t> counts(static_cast<size_t>(max_length) + 1, 0);
    for (size_t i = nodes.size(); i-- > 0;) {
        if (nodes[i].parent >= 0) depth[i] = depth[static_cast<size_t>(nodes[i].parent)] + 1;
        if (nodes[i].symbol >= 0)
            ++counts[static_cast<size_t>(std::clamp(depth[i], 1, max_length))];
    }
    return counts;
}

/// Makes counts that were cut off at max_length a complete code again: the sum of 2^-length comes
/// back to 1 by making longest codes of shorter ones.
void restore_kraft(std::vector<int32_t>* counts) {
    const size_t longest = counts->size() - 1;
    int64_t sum = 0;
    for (size_t n = 1; n <= longest; ++n)
        sum += static_cast<int64_t>((*counts)[n]) << (longest - n);
    for (; sum > int64_t{1} << longest; --sum) {
        --(*counts)[longest];
        for (size_t n = longest - 1; n > 0; --n) {
            if ((*counts)[n] == 0) continue;
            --(*counts)[n];
            (*counts)[n + 1] += 2;
            break;
        }
    }
}

uint16_t reversed(uint32_t code, int length) {
    uint32_t bits = 0;
    for (int i = 0; i < length; ++i)
        bits |= ((code >> i) & 1U) << (length - 1 - i);
    return static_cast<uint16_t>(bits);
}

/// A code length as the block's head writes it: 0 … 15, or a repeat.
struct LengthSymbol {
    uint8_t symbol = 0;
    uint8_t extra = 0;
    uint8_t extra_count = 0;
};

std::vector<LengthSymbol> run_lengths(const std::vector<uint8_t>& lengths) {
    std::vector<LengthSymbol> symbols;
    for (size_t i = 0; i < lengths.size();) {
        size_t run = 1;
        while (i + run < lengths.size() && lengths[i + run] == lengths[i])
            ++run;
        const uint8_t length = lengths[i];
        i += run;
        if (length != 0) {
            symbols.push_back({length});
            --run;
        }
        while (run >= 3) {
            const size_t most = length != 0 ? 6 : 138;
            const size_t n = std::min(run, most);
            if (length != 0) {
                symbols.push_back({16, static_cast<uint8_t>(n - 3), 2});
            } else if (n <= 10) {
                symbols.push_back({17, static_cast<uint8_t>(n - 3), 3});
            } else {
                symbols.push_back({18, static_cast<uint8_t>(n - 11), 7});
            }
            run -= n;
        }
        symbols.insert(symbols.end(), run, LengthSymbol{length});
    }
    return symbols;
}

size_t used_symbols(const PrefixCode& code, size_t least) {
    size_t n = code.length.size();
    while (n > least && code.length[n - 1] == 0)
        --n;
    return n;
}

}  // namespace

PrefixCode make_prefix_code(std::span<const uint32_t> frequencies, int max_length) {
    PrefixCode code;
    code.length.assign(frequencies.size(), 0);
    code.bits.assign(frequencies.size(), 0);
    std::vector<Node> sorted;
    for (size_t s = 0; s < frequencies.size(); ++s) {
        if (frequencies[s] > 0) sorted.push_back({frequencies[s], -1, static_cast<int32_t>(s)});
    }
    // Some readers want two codes at least, so that the code is complete.
    for (int32_t s = 0; sorted.size() < 2; ++s) {
        const bool there = !sorted.empty() && sorted.front().symbol == s;
        if (!there) sorted.push_back({1, -1, s});
    }
    std::stable_sort(sorted.begin(), sorted.end(),
                     [](const Node& a, const Node& b) { return a.weight < b.weight; });
    std::vector<int32_t> counts = optimal_lengths(sorted, max_length);
    restore_kraft(&counts);
    // Rare symbols take the long codes.
    size_t next = 0;
    for (int n = max_length; n > 0; --n) {
        for (int32_t i = 0; i < counts[static_cast<size_t>(n)]; ++i) {
            code.length[static_cast<size_t>(sorted[next++].symbol)] = static_cast<uint8_t>(n);
        }
    }
    uint32_t value = 0;
    for (int n = 1; n <= max_length; ++n) {
        value <<= 1;
        for (size_t s = 0; s < code.length.size(); ++s) {
            if (code.length[s] == n) code.bits[s] = reversed(value++, n);
        }
    }
    return code;
}

Coded code_length(int32_t length) {
    if (length == 258) return {285, 0, 0};
    const int32_t value = length - 3;
    if (value < 8) return {static_cast<uint16_t>(257 + value), 0, 0};
    const int extra = std::bit_width(static_cast<uint32_t>(value)) - 3;
    return {static_cast<uint16_t>(257 + 4 * extra + (value >> extra)), static_cast<uint8_t>(extra),
            static_cast<uint16_t>(value & ((1 << extra) - 1))};
}

Coded code_distance(int32_t distance) {
    const int32_t value = distance - 1;
    if (value < 4) return {static_cast<uint16_t>(value), 0, 0};
    const int extra = std::bit_width(static_cast<uint32_t>(value)) - 2;
    return {static_cast<uint16_t>(2 * extra + (value >> extra)), static_cast<uint8_t>(extra),
            static_cast<uint16_t>(value & ((1 << extra) - 1))};
}

void write_block_head(BitWriter* out, bool last, const PrefixCode& literals,
                      const PrefixCode& distances) {
    const size_t literal_count = used_symbols(literals, 257);
    const size_t distance_count = used_symbols(distances, 1);
    std::vector<uint8_t> lengths(
        literals.length.begin(),
        literals.length.begin() + static_cast<std::ptrdiff_t>(literal_count));
    lengths.insert(lengths.end(), distances.length.begin(),
                   distances.length.begin() + static_cast<std::ptrdiff_t>(distance_count));
    const std::vector<LengthSymbol> symbols = run_lengths(lengths);
    std::array<uint32_t, 19> frequencies{};
    for (const LengthSymbol& symbol : symbols)
        ++frequencies[symbol.symbol];
    const PrefixCode code = make_prefix_code(frequencies, 7);
    // The order in which RFC 1951 gives the lengths of the lengths' code.
    constexpr std::array<uint8_t, 19> kOrder{16, 17, 18, 0, 8,  7, 9,  6, 10, 5,
                                             11, 4,  12, 3, 13, 2, 14, 1, 15};
    size_t order_count = kOrder.size();
    while (order_count > 4 && code.length[kOrder[order_count - 1]] == 0)
        --order_count;
    out->put(last ? 1 : 0, 1);
    out->put(2, 2);
    out->put(literal_count - 257, 5);
    out->put(distance_count - 1, 5);
    out->put(order_count - 4, 4);
    for (size_t i = 0; i < order_count; ++i)
        out->put(code.length[kOrder[i]], 3);
    for (const LengthSymbol& symbol : symbols) {
        out->put(code.bits[symbol.symbol], code.length[symbol.symbol]);
        out->put(symbol.extra, symbol.extra_count);
    }
}

}  // namespace openfab::raster
