// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/diag/suggest.h"

#include <algorithm>
#include <cctype>
#include <vector>

namespace openfab::diag {

namespace {

constexpr size_t kMaxWord = 64;  // longer words get no suggestion: the cost is their product

std::string lower(std::string_view word) {
    std::string out(word);
    for (char& c : out)
        c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return out;
}

/// Insertions, deletions, changes and swaps of neighbours that turn one into the other.
size_t edits(std::string_view a, std::string_view b) {
    std::vector<std::vector<size_t>> d(a.size() + 1, std::vector<size_t>(b.size() + 1));
    for (size_t i = 0; i <= a.size(); ++i) {
        for (size_t j = 0; j <= b.size(); ++j) {
            if (i == 0 || j == 0) {
                d[i][j] = i + j;
                continue;
            }
            const size_t change = a[i - 1] == b[j - 1] ? 0 : 1;
            d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + change});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
                d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
            }
        }
    }
    return d[a.size()][b.size()];
}

}  // namespace

std::string suggest(std::string_view word, std::span<const std::string> candidates) {
    if (word.empty() || word.size() > kMaxWord) return "";
    std::string best;
    size_t best_edits = word.size() / 3 + 1;
    bool unique = false;
    for (const std::string& candidate : candidates) {
        if (candidate.size() > kMaxWord || candidate == best) continue;
        const std::string a = lower(word);
        const std::string b = lower(candidate);
        const size_t count = a == b ? 0 : edits(a, b);
        if (count > best_edits || (best.empty() && count == best_edits)) continue;
        unique = count < best_edits;
        best_edits = count;
        best = candidate;
    }
    return unique ? best : "";
}

}  // namespace openfab::diag
