// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/check/nesting.h"

#include <algorithm>
#include <map>
#include <set>

#include "mesh/check/triangle_tree.h"
#include "mesh/check/winding.h"

namespace openfab::mesh {
namespace {

/// Limit of the triangles that all rays meet: seconds.
constexpr int64_t kMostMet = 300'000'000;
constexpr int64_t kMostSamples = 400'000;

/// What is known of a piece.
struct Piece {
    std::vector<int32_t> samples;  ///< triangles
    Box3d box;
    double volume = 0;
    int64_t triangles = 0;
};

std::vector<Piece> measure(const Mesh& mesh, std::span<const int32_t> pieces, int32_t count) {
    std::vector<Piece> out(static_cast<size_t>(count));
    for (size_t t = 0; t < pieces.size(); ++t) {
        if (pieces[t] < 0) continue;
        Piece& piece = out[pieces[t]];
        ++piece.triangles;
        const auto& v = mesh.triangles[t];
        for (int32_t corner : v)
            piece.box.add(mesh.positions[corner]);
        piece.volume +=
            dot(mesh.positions[v[0]], cross(mesh.positions[v[1]], mesh.positions[v[2]]));
    }
    return out;
}

/// Chooses triangles that are spread over each piece.
void choose_samples(std::span<const int32_t> pieces, std::vector<Piece>* all) {
    const auto count = static_cast<int64_t>(all->size());
    const int64_t each = std::clamp<int64_t>(kMostSamples / std::max<int64_t>(count, 1), 2, 24);
    std::vector<int64_t> seen(all->size());
    for (size_t t = 0; t < pieces.size(); ++t) {
        if (pieces[t] < 0) continue;
        Piece& piece = (*all)[pieces[t]];
        const int64_t nth = seen[pieces[t]]++;
        // The i-th sample is the first triangle from i / each of the piece on.
        const auto taken = static_cast<int64_t>(piece.samples.size());
        if (taken < each && nth * each >= taken * piece.triangles)
            piece.samples.push_back(static_cast<int32_t>(t));
    }
}

bool any_boxes_meet(const std::vector<Piece>& pieces) {
    std::vector<const Box3d*> boxes;
    for (const Piece& piece : pieces) {
        if (!piece.box.empty()) boxes.push_back(&piece.box);
    }
    std::sort(boxes.begin(), boxes.end(),
              [](const Box3d* a, const Box3d* b) { return a->lo.x < b->lo.x; });
    int64_t effort = 1'000'000;
    for (size_t i = 0; i < boxes.size(); ++i) {
        for (size_t j = i + 1; j < boxes.size() && boxes[j]->lo.x < boxes[i]->hi.x; ++j) {
            if (--effort < 0) return true;
            const Box3d &a = *boxes[i], &b = *boxes[j];
            // Those that only touch share no volume.
            if (a.lo.y < b.hi.y && b.lo.y < a.hi.y && a.lo.z < b.hi.z && b.lo.z < a.hi.z)
                return true;
        }
    }
    return false;
}

}  // namespace

std::optional<Nesting> find_nesting(const Mesh& mesh, std::span<const int32_t> pieces,
                                    int32_t count) {
    Nesting out;
    out.inside.resize(static_cast<size_t>(count));
    std::vector<Piece> all = measure(mesh, pieces, count);
    if (count < 2 || !any_boxes_meet(all)) return out;
    choose_samples(pieces, &all);
    const TriangleTree tree(mesh);
    int64_t effort = kMostMet;
    std::set<std::pair<int32_t, int32_t>> overlaps;
    for (int32_t p = 0; p < count; ++p) {
        const Piece& piece = all[p];
        if (piece.samples.empty()) continue;
        const Vec3d size = piece.box.size();
        // More than the rounding of faces that should coincide, less than any wall.
        const double step = 1e-4 * std::min({size.x, size.y, size.z});
        int64_t valid = 0;
        std::map<int32_t, int64_t> within;
        for (int32_t t : piece.samples) {
            const auto& v = mesh.triangles[t];
            const Vec3d &a = mesh.positions[v[0]], &b = mesh.positions[v[1]],
                        &c = mesh.positions[v[2]];
            const Vec3d n = cross(b - a, c - a);
            const double area = length(n);
            if (!(area > 0)) continue;
            const double inwards = (piece.volume < 0 ? step : 0 - step) / area;
            const Vec3d point = (a + b + c) * (1.0 / 3) + n * inwards;
            std::map<int32_t, int> winding;
            for_each_crossing(
                mesh, tree, point, &effort, [&](int32_t other) { return pieces[other] < 0; },
                [&](int32_t other, int sign) { winding[pieces[other]] += sign; });
            if (effort < 0) return std::nullopt;
            if (const auto own = winding.find(p); own == winding.end() || own->second == 0)
                continue;
            ++valid;
            for (const auto& [other, turns] : winding) {
                if (other != p && turns != 0) ++within[other];
            }
        }
        for (const auto& [other, samples] : within) {
            if (samples == valid && std::abs(piece.volume) < std::abs(all[other].volume)) {
                out.inside[p].push_back(other);
            } else {
                overlaps.emplace(std::min(p, other), std::max(p, other));
            }
        }
    }
    for (const auto& pair : overlaps) {
        const auto lies_in = [&](int32_t a, int32_t b) {
            return std::find(out.inside[a].begin(), out.inside[a].end(), b) != out.inside[a].end();
        };
        if (!lies_in(pair.first, pair.second) && !lies_in(pair.second, pair.first))
            out.overlaps.push_back(pair);
    }
    return out;
}

}  // namespace openfab::mesh
