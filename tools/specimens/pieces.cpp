// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/specimens/pieces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace openfab::specimens {

namespace {

// Bars: C. Cox, TensileTestSpecimenGroup.scad, 2018 (thing 2960213), has all rows, and which radius lies where. Those of
// D638 agree with kcafrp.com/sub06/01_01_2.php, those of ISO 527-2 with the specimens in ZwickRoell's catalogue of
// cutting devices (no radii there). Of D638's type IV the free length between grips is 65 mm, less than its arcs reach.
// Discs: D395-16, 5.2.1, as cited by lectromec.com/test/compression-test (the first) and in a preview (both).
constexpr std::array kPieces{
    Piece{"iso527-1a", "ISO 527-2 type 1A", 170, 20, 80, 10, 24, 0, 4, 75, 115},
    Piece{"iso527-1b", "ISO 527-2 type 1B", 150, 20, 60, 10, 60, 0, 4, 50, 115},
    Piece{"iso527-1ba", "ISO 527-2 type 1BA", 75, 10, 30, 5, 30, 0, 2, 25, 60},
    Piece{"iso527-1bb", "ISO 527-2 type 1BB", 30, 4, 12, 2, 12, 0, 2, 10, 24},
    Piece{"iso527-5a", "ISO 527-2 type 5A, ISO 37 type 2", 75, 12.5, 25, 4, 8, 12.5, 2, 20, 50},
    Piece{"iso527-5b", "ISO 527-2 type 5B, ISO 37 type 4", 35, 6, 12, 2, 3, 3, 1, 10, 20},
    Piece{"d638-i", "ASTM D638 type I", 165, 19, 57, 13, 76, 0, 3.2, 50, 115},
    Piece{"d638-ii", "ASTM D638 type II", 183, 19, 57, 6, 76, 0, 3.2, 50, 135},
    Piece{"d638-iii", "ASTM D638 type III", 246, 29, 57, 19, 76, 0, 3.2, 50, 115},
    Piece{"d638-iv", "ASTM D638 type IV", 115, 19, 33, 6, 14, 25, 3.2, 25, 65},
    Piece{"d638-v", "ASTM D638 type V", 63.5, 9.53, 9.53, 3.18, 12.7, 0, 3.2, 7.62, 25.4},
    Piece{.name = "d395-1", .standard = "ASTM D395 type 1", .overall_mm = 29, .thickness_mm = 12.5},
    Piece{.name = "d395-2", .standard = "ASTM D395 type 2", .overall_mm = 13, .thickness_mm = 6},
};

constexpr double kChordMm = 0.005;

/// Appends points of an arc after its first one.
void add_arc(Corner centre, double radius, double from, double to, std::vector<Corner>* out) {
    const double step = 2 * std::acos(1 - std::min(kChordMm / radius, 1.0));
    const int n = std::max(1, static_cast<int>(std::ceil(std::abs(to - from) / step)));
    for (int i = 1; i <= n; ++i) {
        const double at = from + (to - from) * i / n;
        out->push_back({centre.x + radius * std::cos(at), centre.y + radius * std::sin(at)});
    }
}

/// Returns the upper right quarter of an outline, from the middle of the narrow part outwards.
std::vector<Corner> quarter(const Piece& bar) {
    const double rise = (bar.ends_mm - bar.narrow_mm) / 2, low = bar.narrow_mm / 2;
    const double reach = bar.fillet_mm + bar.shoulder_mm;
    const double turn = std::acos(1 - rise / reach);
    constexpr double kDown = -std::numbers::pi / 2;
    std::vector<Corner> out{{bar.parallel_mm / 2, low}};
    add_arc({bar.parallel_mm / 2, low + bar.fillet_mm}, bar.fillet_mm, kDown, kDown + turn, &out);
    if (bar.shoulder_mm > 0) {
        const double end = bar.parallel_mm / 2 + reach * std::sin(turn);
        add_arc({end, bar.ends_mm / 2 - bar.shoulder_mm}, bar.shoulder_mm, -kDown + turn, -kDown,
                &out);
    }
    out.push_back({bar.overall_mm / 2, bar.ends_mm / 2});
    return out;
}

using Polygon = std::vector<Corner>;
const std::array<std::vector<Polygon>, 10>& digit_outlines() {
    static const std::array<std::vector<Polygon>, 10> outlines{{
        {{{0, 0}, {3, 0}, {3, 5}, {0, 5}}, {{1, 1}, {2, 1}, {2, 4}, {1, 4}}},
        {{{0, 0},
          {3, 0},
          {3, 1},
          {2, 1},
          {2, 5},
          {1, 5},
          {1, 4},
          {0, 4},
          {0, 3},
          {1, 3},
          {1, 1},
          {0, 1}}},
        {{{0, 0},
          {3, 0},
          {3, 1},
          {1, 1},
          {1, 2},
          {3, 2},
          {3, 5},
          {0, 5},
          {0, 4},
          {2, 4},
          {2, 3},
          {0, 3}}},
        {{{0, 0},
          {3, 0},
          {3, 5},
          {0, 5},
          {0, 4},
          {2, 4},
          {2, 3},
          {0, 3},
          {0, 2},
          {2, 2},
          {2, 1},
          {0, 1}}},
        {{{2, 0}, {3, 0}, {3, 5}, {2, 5}, {2, 3}, {1, 3}, {1, 5}, {0, 5}, {0, 2}, {2, 2}}},
        {{{0, 0},
          {3, 0},
          {3, 3},
          {1, 3},
          {1, 4},
          {3, 4},
          {3, 5},
          {0, 5},
          {0, 2},
          {2, 2},
          {2, 1},
          {0, 1}}},
        {{{0, 0}, {3, 0}, {3, 3}, {1, 3}, {1, 4}, {3, 4}, {3, 5}, {0, 5}},
         {{1, 1}, {2, 1}, {2, 2}, {1, 2}}},
        {{{2, 0}, {3, 0}, {3, 5}, {0, 5}, {0, 4}, {2, 4}}},
        {{{0, 0}, {3, 0}, {3, 5}, {0, 5}},
         {{1, 1}, {2, 1}, {2, 2}, {1, 2}},
         {{1, 3}, {2, 3}, {2, 4}, {1, 4}}},
        {{{0, 0}, {3, 0}, {3, 5}, {0, 5}, {0, 2}, {2, 2}, {2, 1}, {0, 1}},
         {{1, 3}, {2, 3}, {2, 4}, {1, 4}}},
    }};
    return outlines;
}

}  // namespace

std::span<const Piece> pieces() {
    return kPieces;
}

const Piece* find_piece(std::string_view name) {
    const auto piece = std::ranges::find(kPieces, name, &Piece::name);
    return piece == kPieces.end() ? nullptr : &*piece;
}

std::vector<std::string> piece_names() {
    std::vector<std::string> out;
    for (const Piece& piece : kPieces)
        out.emplace_back(piece.name);
    return out;
}

std::vector<Corner> outline(const Piece& bar) {
    const std::vector<Corner> one = quarter(bar);
    std::vector<Corner> out;
    for (const Corner& p : one)
        out.push_back({p.x, -p.y});
    for (auto p = one.rbegin(); p != one.rend(); ++p)
        out.push_back(*p);
    for (const Corner& p : one)
        out.push_back({-p.x, p.y});
    for (auto p = one.rbegin(); p != one.rend(); ++p)
        out.push_back({-p->x, -p->y});
    return out;
}

std::vector<std::vector<Corner>> digits(int number) {
    const std::string text = std::to_string(number);
    const double right = digits_size(number).x;
    std::vector<Polygon> out{{{0, 0}, {right, 0}, {right, 1}, {0, 1}}};
    for (size_t i = 0; i < text.size(); ++i) {
        for (Polygon polygon : digit_outlines()[static_cast<size_t>(text[i] - '0')]) {
            for (Corner& p : polygon)
                p = {p.x + 4 * static_cast<double>(i), p.y + 2};
            out.push_back(std::move(polygon));
        }
    }
    return out;
}

Corner digits_size(int number) {
    return {4 * static_cast<double>(std::to_string(number).size()) - 1, 7};
}

}  // namespace openfab::specimens
