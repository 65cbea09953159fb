// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/split/slivers.h"

#include <algorithm>
#include <cstddef>

#include "base/at.h"

#include "tools/split/search.h"

namespace openfab::pieces {

namespace {

constexpr double kSame_mm = 1e-6;

/// The triangles around each vertex.
class Fans {
  public:
    explicit Fans(const Body& body) : body_(body), begins_(body.positions.size() + 1) {
        for (const auto& triangle : body.triangles) {
            for (const int32_t v : triangle)
                ++begins_[static_cast<size_t>(v) + 1];
        }
        for (size_t i = 1; i < begins_.size(); ++i)
            begins_[i] += begins_[i - 1];
        std::vector<size_t> next(begins_.begin(), begins_.end() - 1);
        triangles_.resize(3 * body.triangles.size());
        for (size_t t = 0; t < body.triangles.size(); ++t) {
            for (const int32_t v : body.triangles[t])
                triangles_[at(next, v)++] = t;
        }
    }

    template <typename With>
    void for_triangles(size_t vertex, const With& with) const {
        for (size_t i = begins_[vertex]; i < begins_[vertex + 1]; ++i)
            with(triangles_[i]);
    }
    /// Whether the solid lies below a vertex that is the highest around, along a direction.
    bool is_solid_below(size_t vertex, const Vec3d& up) const {
        double sum = 0;
        for_triangles(vertex, [&](size_t t) {
            const auto [a, b, c] = body_.triangle(t);
            sum += dot(cross(b - a, c - a), up);
        });
        return sum > 0;
    }

  private:
    const Body& body_;
    std::vector<size_t> begins_, triangles_;
};

/// Whether a point is on the way through the tree to one of its cuts.
bool reaches(const Tree& tree, const Vec3d& p, int32_t cut) {
    int32_t node = 0;
    while (node >= 0 && node != cut) {
        const Cut& at = openfab::at(tree.cuts, node);
        node = dot(at.normal, p) > at.offset_mm ? at.front : at.back;
    }
    return node == cut;
}

/// Appends what lies beyond one side of a cut, each connected part of the surface once.
void find_beyond(const Body& body, const Fans& fans, const Tree& tree, int32_t cut, bool front,
                 std::vector<Sliver>* out) {
    const Cut& of = at(tree.cuts, cut);
    const Vec3d up = front ? of.normal : of.normal * -1.0;
    const double offset = front ? of.offset_mm : 0 - of.offset_mm;
    const auto height = [&](size_t v) { return dot(up, body.positions[v]) - offset; };
    std::vector<bool> seen(body.positions.size());
    std::vector<size_t> open;
    for (size_t first = 0; first < seen.size(); ++first) {
        if (seen[first] || !(height(first) > kSame_mm)) continue;
        size_t highest = first;
        seen[first] = true;
        open.assign(1, first);
        while (!open.empty()) {
            const size_t v = open.back();
            open.pop_back();
            if (height(v) > height(highest)) highest = v;
            fans.for_triangles(v, [&](size_t t) {
                for (const int32_t corner : body.triangles[t]) {
                    const auto other = static_cast<size_t>(corner);
                    if (seen[other] || !(height(other) > kSame_mm)) continue;
                    seen[other] = true;
                    open.push_back(other);
                }
            });
        }
        const Vec3d& at = body.positions[highest];
        if (height(highest) < kSliver_mm && reaches(tree, at, cut) &&
            fans.is_solid_below(highest, up))
            out->push_back({cut, height(highest), at, front});
    }
}

std::vector<Sliver> slivers_of(const Body& body, const Fans& fans, const Tree& tree, int32_t cut) {
    std::vector<Sliver> out;
    for (const bool front : {false, true})
        find_beyond(body, fans, tree, cut, front, &out);
    return out;
}

bool all_fit(const Body& body, const Vec3d& tray_mm, const Tree& tree) {
    const std::vector<Region> all = regions(tree);
    return std::all_of(all.begin(), all.end(), [&](const Region& region) {
        return region.shapes_only || fits(piece_box(body, region, {}).size(), tray_mm);
    });
}

}  // namespace

std::vector<Sliver> find_slivers(const Body& body, const Tree& tree) {
    const Fans fans(body);
    std::vector<Sliver> out;
    for (size_t i = 0; i < tree.cuts.size(); ++i) {
        const std::vector<Sliver> here = slivers_of(body, fans, tree, static_cast<int32_t>(i));
        out.insert(out.end(), here.begin(), here.end());
    }
    return out;
}

void avoid_slivers(const Body& body, const Vec3d& tray_mm, Tree* tree) {
    const Fans fans(body);
    for (size_t i = 0; i < tree->cuts.size(); ++i) {
        const auto cut = static_cast<int32_t>(i);
        std::vector<Sliver> least = slivers_of(body, fans, *tree, cut);
        constexpr int kTries = 4;
        for (int n = 0; n < kTries && !least.empty(); ++n) {
            // All of one goes to the other side; or it becomes thick enough.
            const Sliver sliver = least[0];
            const double whole = sliver.thickness_mm, thick = whole - kSliver_mm - kSame_mm;
            bool better = false;
            for (const double by : {whole, thick}) {
                Tree moved = *tree;
                moved.cuts[i].offset_mm += sliver.front ? by : 0 - by;
                std::vector<Sliver> here = slivers_of(body, fans, moved, cut);
                if (here.size() >= least.size() || !all_fit(body, tray_mm, moved)) continue;
                *tree = std::move(moved);
                least = std::move(here);
                better = true;
                break;
            }
            if (!better) break;
        }
    }
}

}  // namespace openfab::pieces
