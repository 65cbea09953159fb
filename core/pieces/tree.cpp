// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "pieces/tree.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace openfab::pieces {

namespace {

constexpr double kDegree = 0.017453292519943295;

Vec3d unit(const Vec3d& v) {
    return v * (1 / length(v));
}

class RegionMaker {
  public:
    explicit RegionMaker(const Tree& tree) : tree_(tree) {}

    std::vector<Region> run() {
        out_.resize(tree_.pieces.size());
        for (size_t i = 0; i < tree_.pieces.size(); ++i)
            out_[i].name = tree_.pieces[i];
        if (!tree_.cuts.empty()) add_sides(0, {}, {});
        for (size_t i = 0; i < tree_.cuts.size(); ++i) {
            for (const Connector& connector : tree_.cuts[i].connectors)
                connect(static_cast<int32_t>(i), connector);
            for (const Number& number : tree_.cuts[i].numbers)
                engrave(tree_.cuts[i], number);
        }
        return std::move(out_);
    }

  private:
    void add_sides(int32_t cut, std::vector<Side> sides, std::vector<int32_t> cuts) {
        const Cut& c = tree_.cuts[static_cast<size_t>(cut)];
        cuts.push_back(cut);
        sides.push_back({c.normal, c.offset_mm, true});
        for (const int32_t child : {c.front, c.back}) {
            if (child >= 0) {
                add_sides(child, sides, cuts);
            } else {
                out_[static_cast<size_t>(~child)].sides = sides;
                out_[static_cast<size_t>(~child)].cuts = cuts;
            }
            sides.back().front = false;
        }
    }

    Region& region_at(int32_t node, const Vec3d& p) {
        while (node >= 0) {
            const Cut& c = tree_.cuts[static_cast<size_t>(node)];
            node = dot(c.normal, p) > c.offset_mm ? c.front : c.back;
        }
        return out_[static_cast<size_t>(~node)];
    }

    static Vec3d on_cut(const Cut& cut, const Vec3d& p) {
        return p + cut.normal * (cut.offset_mm - dot(cut.normal, p));
    }

    void connect(int32_t number, const Connector& c) {
        const Cut& cut = tree_.cuts[static_cast<size_t>(number)];
        const Vec3d at = on_cut(cut, c.at_mm);
        const bool front_gives = c.from_front;
        const int32_t own_side = front_gives ? cut.front : cut.back;
        const int32_t other_side = front_gives ? cut.back : cut.front;
        Shape shape;
        shape.at = at;
        shape.n = front_gives ? cut.normal * -1.0 : cut.normal;
        shape.v = upright(cut.normal);
        if (c.kind == Connector::Kind::kDovetail) {
            const Vec3d flat = c.along - cut.normal * dot(cut.normal, c.along);
            if (length(flat) > 1e-6 * length(c.along)) shape.v = unit(flat);
        }
        shape.u = cross(shape.v, shape.n);
        const bool half = c.kind == Connector::Kind::kDowel;
        shape.hi = half ? c.length_mm / 2 : c.length_mm;
        shape.lo = 0 - shape.hi;
        if (c.kind == Connector::Kind::kDovetail) {
            shape.kind = Shape::Kind::kDovetail;
            shape.half_width = c.diameter_mm / 2;
            shape.slope = std::tan(c.angle_deg * kDegree);
            shape.half_length = c.run_mm / 2;
        } else {
            shape.radius = c.diameter_mm / 2;
        }
        Shape hole = shape;
        hole.clearance = c.clearance_mm;
        // Seen from the other piece.
        Shape turned = hole;
        turned.n = shape.n * -1.0;
        turned.u = shape.u * -1.0;
        const char* kinds[] = {"peg", "dowel", "dovetail", "magnet"};
        const std::string name = kinds[static_cast<size_t>(c.kind)];
        const bool slides = c.kind == Connector::Kind::kDovetail;
        const auto fit = [&](Region* region, const Shape& of, const std::string& what) {
            region->fits.push_back({of, c.skin_mm, slides, number, what, c.location});
        };
        const bool given = c.kind == Connector::Kind::kPeg || slides;
        Region& other = region_at(other_side, at);
        other.removed.push_back(hole);
        fit(&other, hole, fmt::format("the hole of the {}", name));
        Region& own = region_at(own_side, at);
        if (given) {
            own.added.push_back(shape);
            if (!c.material.empty()) {
                own.filled.push_back({shape, c.material});
                Shape root = turned;
                root.clearance = 0;
                if (!slides) fit(&own, root, fmt::format("the {}", name));
            }
            return;
        }
        own.removed.push_back(hole);
        fit(&own, turned, fmt::format("the hole of the {}", name));
        if (c.kind != Connector::Kind::kDowel) return;
        Region dowel;
        dowel.name = fmt::format("dowel {}", ++dowels_);
        dowel.shapes_only = true;
        // It moves with both pieces, half as far with each.
        for (const Region* piece : {&own, &other}) {
            dowel.sides.insert(dowel.sides.end(), piece->sides.begin(), piece->sides.end());
            dowel.cuts.insert(dowel.cuts.end(), piece->cuts.begin(), piece->cuts.end());
        }
        dowel.added.push_back(shape);
        if (!c.material.empty()) dowel.filled.push_back({shape, c.material});
        out_.push_back(std::move(dowel));
    }

    void engrave(const Cut& cut, const Number& number) {
        const Vec3d at = on_cut(cut, number.at_mm);
        for (const bool front : {true, false}) {
            if (number.front && *number.front != front) continue;
            Region& region = region_at(front ? cut.front : cut.back, at);
            Shape text;
            text.kind = Shape::Kind::kStrokes;
            text.at = at;
            // Read from outside the piece: u to the right, v up, and n into it.
            const Vec3d outwards = front ? cut.normal * -1.0 : cut.normal;
            text.v = upright(cut.normal);
            if (number.up) {
                const Vec3d flat = *number.up - cut.normal * dot(cut.normal, *number.up);
                if (length(flat) > 1e-6 * length(*number.up)) text.v = unit(flat);
            }
            text.u = cross(text.v, outwards);
            text.n = outwards * -1.0;
            text.hi = number.depth_mm;
            text.lo = 0 - text.hi;
            double thickness = 0;
            text.strokes = strokes_of(region.name, number.height_mm, &thickness);
            text.radius = thickness / 2;
            region.removed.push_back(std::move(text));
        }
    }

    const Tree& tree_;
    std::vector<Region> out_;
    int32_t dowels_ = 0;
};

// Strokes on a grid of 3 columns and 5 rows, from the lower left: pairs of digits are a column and a
// row, blanks lift the pen.
const char* glyph(char c) {
    static const char* const kDigits[10] = {
        "00 20 24 04 00",       "03 14 10",          "04 24 22 02 00 20", "04 24 20 00 02!02 22",
        "04 02 22 24!24 20",    "24 04 02 22 20 00", "24 04 00 20 22 02", "04 24 10",
        "00 20 24 04 00!02 22", "00 20 24 04 02 22"};
    static const char* const kLetters[26] = {"00 03 14 23 20!02 22",
                                             "00 04 14 23 12 02!12 21 10 00",
                                             "24 04 00 20",
                                             "00 04 14 23 21 10 00",
                                             "24 04 00 20!02 12",
                                             "24 04 00!02 12",
                                             "24 04 00 20 22 12",
                                             "00 04!20 24!02 22",
                                             "10 14",
                                             "24 20 10 01",
                                             "00 04!24 02 20",
                                             "04 00 20",
                                             "00 04 12 24 20",
                                             "00 04 20 24",
                                             "00 20 24 04 00",
                                             "00 04 24 22 02",
                                             "00 20 24 04 00!11 20",
                                             "00 04 24 22 02 20",
                                             "24 04 02 22 20 00",
                                             "04 24!14 10",
                                             "04 00 20 24",
                                             "04 10 24",
                                             "04 00 12 20 24",
                                             "00 24!04 20",
                                             "04 12 24!12 10",
                                             "04 24 00 20"};
    if (c >= '0' && c <= '9') return kDigits[c - '0'];
    if (c >= 'A' && c <= 'Z') return kLetters[c - 'A'];
    if (c >= 'a' && c <= 'z') return kLetters[c - 'a'];
    if (c == '.') return "10 10";
    if (c == ' ') return "";
    return "02 22";
}

}  // namespace

const std::string& piece_at(const Tree& tree, const Vec3d& p) {
    int32_t node = 0;
    while (node >= 0) {
        const Cut& c = tree.cuts[static_cast<size_t>(node)];
        node = dot(c.normal, p) > c.offset_mm ? c.front : c.back;
    }
    return tree.pieces[static_cast<size_t>(~node)];
}

std::vector<Region> regions(const Tree& tree) {
    return RegionMaker(tree).run();
}

Vec3d upright(const Vec3d& normal) {
    for (const Vec3d& up : {Vec3d{0, 0, 1}, Vec3d{0, 1, 0}}) {
        const Vec3d flat = up - normal * dot(normal, up);
        if (length(flat) > 0.1) return unit(flat);
    }
    return {1, 0, 0};
}

std::vector<std::array<double, 4>> strokes_of(const std::string& text, double height,
                                              double* thickness) {
    // Letters are 2 wide and 4 high between the middles of their strokes, which are 0.8 thick.
    constexpr double kThick = 0.8, kAdvance = 3.4, kNarrow = 2.0;
    const double unit_mm = height / (4 + kThick);
    *thickness = kThick * unit_mm;
    std::vector<std::array<double, 4>> out;
    double x = 0;
    for (const char c : text) {
        const double shift = c == '.' ? -1 : 0;
        const char* last = nullptr;
        for (const char* at = glyph(c); *at != 0; ++at) {
            if (*at == ' ') continue;
            if (*at == '!') {
                last = nullptr;
                continue;
            }
            if (last != nullptr) {
                out.push_back({(x + shift + last[0] - '0') * unit_mm, (last[1] - '0' - 2) * unit_mm,
                               (x + shift + at[0] - '0') * unit_mm, (at[1] - '0' - 2) * unit_mm});
            }
            last = at++;
        }
        x += c == '.' ? kNarrow : kAdvance;
    }
    double lo = 1e30, hi = -1e30;
    for (const auto& s : out)
        lo = std::min({lo, s[0], s[2]}), hi = std::max({hi, s[0], s[2]});
    for (auto& s : out)
        s[0] -= (lo + hi) / 2, s[2] -= (lo + hi) / 2;
    return out;
}

}  // namespace openfab::pieces
