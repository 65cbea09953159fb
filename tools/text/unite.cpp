// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/text/unite.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <polyclipping/clipper.hpp>
#include <utility>

namespace openfab::text {

namespace {

// Its whole numbers may have 62 bits, which is 2^38 line pitches of a text.
using ClipperLib::IntPoint;
using ClipperLib::Path;

mesh::Outline outline_of(const Path& path, double finest) {
    mesh::Outline outline;
    for (const IntPoint& p : path)
        outline.push_back({static_cast<double>(p.X) * finest, static_cast<double>(p.Y) * finest});
    return outline;
}

/// Adds the areas below a node: each outline with its holes, in which others may be.
void add_areas(const ClipperLib::PolyNode& node, double finest, std::vector<Area>* areas) {
    for (const ClipperLib::PolyNode* outer : node.Childs) {
        Area area{outline_of(outer->Contour, finest)};
        for (const ClipperLib::PolyNode* hole : outer->Childs) {
            area.push_back(outline_of(hole->Contour, finest));
            add_areas(*hole, finest, areas);
        }
        areas->push_back(std::move(area));
    }
}

/// Takes what a frame holds beside the outlines: the surroundings of letters, or the letters of their surroundings.
template <typename Solution>
void take_rest(const ClipperLib::Paths& paths, const Path& frame, Solution* out) {
    ClipperLib::Clipper clipper;
    clipper.AddPath(frame, ClipperLib::ptSubject, true);
    clipper.AddPaths(paths, ClipperLib::ptClip, true);
    clipper.Execute(ClipperLib::ctDifference, *out, ClipperLib::pftNonZero, ClipperLib::pftNonZero);
}

/// Moves outlines outwards, or inwards by a negative number.
void grow(ClipperLib::Paths* paths, double units) {
    constexpr double kLongestMiter = 4;  // of a corner, in units that it moves
    ClipperLib::ClipperOffset offset(kLongestMiter);
    offset.AddPaths(*paths, ClipperLib::jtMiter, ClipperLib::etClosedPolygon);
    offset.Execute(*paths, units);
}

struct Box {
    double left = std::numeric_limits<double>::infinity(), right = -left, low = left, high = -left;
};

Box box_of(const Glyph& glyph) {
    Box box;
    for (const mesh::Outline& outline : glyph) {
        for (const mesh::Point2& p : outline) {
            box.left = std::min(box.left, p.x);
            box.right = std::max(box.right, p.x);
            box.low = std::min(box.low, p.y);
            box.high = std::max(box.high, p.y);
        }
    }
    return box;
}

/// Groups of glyphs whose boxes meet, in order of their first.
std::vector<std::vector<size_t>> groups_of(const std::vector<Box>& boxes) {
    std::vector<size_t> order(boxes.size()), root(boxes.size());
    std::iota(order.begin(), order.end(), 0U);
    std::iota(root.begin(), root.end(), 0U);
    std::stable_sort(order.begin(), order.end(),
                     [&](size_t a, size_t b) { return boxes[a].left < boxes[b].left; });
    const auto find = [&](size_t i) {
        while (root[i] != i)
            i = root[i] = root[root[i]];
        return i;
    };
    std::vector<size_t> open;
    for (const size_t i : order) {
        std::erase_if(open, [&](size_t j) { return boxes[j].right < boxes[i].left; });
        for (const size_t j : open) {
            if (boxes[j].low <= boxes[i].high && boxes[j].high >= boxes[i].low)
                root[find(i)] = find(j);
        }
        open.push_back(i);
    }
    std::map<size_t, size_t> of_root;
    std::vector<std::vector<size_t>> out;
    for (size_t i = 0; i < boxes.size(); ++i) {
        const auto [at, is_new] = of_root.try_emplace(find(i), out.size());
        if (is_new) out.emplace_back();
        out[at->second].push_back(i);
    }
    return out;
}

/// Appends the areas of glyphs that may overlap.
void unite_group(const std::vector<Glyph>& glyphs, const std::vector<size_t>& group, double finest,
                 double least, std::vector<Area>* areas) {
    ClipperLib::Paths paths;
    ClipperLib::cInt furthest = 0;
    for (const size_t i : group) {
        for (const mesh::Outline& outline : glyphs[i]) {
            Path& path = paths.emplace_back();
            for (const mesh::Point2& p : outline) {
                path.emplace_back(std::llround(p.x / finest), std::llround(p.y / finest));
                furthest = std::max({furthest, std::abs(path.back().X), std::abs(path.back().Y)});
            }
        }
    }
    const double units = least / finest;
    const ClipperLib::cInt edge = furthest + 8 * std::llround(units);
    const Path frame{{-edge, -edge}, {edge, -edge}, {edge, edge}, {-edge, edge}};
    // The outermost outline of what surrounds the letters is the frame: by that outline the library tells which side
    // of all of them is inside, and of letters it could be that of a hole which touches their border.
    take_rest(paths, frame, &paths);
    // Slits close where the surroundings shrink, and letters that touch are parted where they grow. In all they gain an
    // eighth of `least`, so that what was parted does not touch again.
    for (const double part : {-0.125, 0.625, -0.375})
        grow(&paths, units * part);
    ClipperLib::CleanPolygons(paths, units / 16);
    ClipperLib::PolyTree tree;
    take_rest(paths, frame, &tree);
    add_areas(tree, finest, areas);
}

}  // namespace

std::vector<Area> unite(const std::vector<Glyph>& glyphs, double finest, double least) {
    std::vector<Box> boxes;
    boxes.reserve(glyphs.size());
    for (const Glyph& glyph : glyphs)
        boxes.push_back(box_of(glyph));
    std::vector<Area> areas;
    // Not all at once: the time of the library is that of its lines times what each of them crosses.
    for (const std::vector<size_t>& group : groups_of(boxes))
        unite_group(glyphs, group, finest, least, &areas);
    return areas;
}

}  // namespace openfab::text
