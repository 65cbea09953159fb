// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/split/box_plan.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "tools/split/search.h"

namespace openfab::pieces {

namespace {

constexpr double kSlack_mm = 1e-6;

}  // namespace

/// Returns the sums of trays' sides below a length, rising.
std::vector<double> BoxPlan::sums(double most_mm) const {
    std::set<double> all{0};
    for (auto at = all.begin(); at != all.end(); ++at) {
        for (int a = 0; a < 3; ++a) {
            const double sum = *at + tray_[a];
            if (sum >= most_mm - kSlack_mm) continue;
            // Sums in another order differ in their last bits.
            const auto next = all.lower_bound(sum - kSlack_mm);
            if (next == all.end() || *next > sum + kSlack_mm) all.insert(sum);
        }
    }
    all.erase(0);
    return {all.begin(), all.end()};
}

int32_t BoxPlan::least(const Vec3d& size_mm) {
    constexpr double kMostStates = 20'000;
    double states = 1;
    for (int a = 0; a < 3; ++a) {
        const double shortest = std::min({tray_.x, tray_.y, tray_.z});
        if (!(size_mm[a] / shortest < 100)) return 0;
        // What is left of a side is the side less a sum, or a sum less a sum.
        states *= 2 * static_cast<double>(sums(size_mm[a]).size()) + 1;
    }
    return states > kMostStates ? 0 : best(size_mm).pieces;
}

const BoxPlan::Best& BoxPlan::best(const Vec3d& size_mm) {
    constexpr double kPerMm = 1e5;
    const Key key{std::llround(size_mm.x * kPerMm), std::llround(size_mm.y * kPerMm),
                  std::llround(size_mm.z * kPerMm)};
    const auto [known, fresh] = known_.try_emplace(key);
    if (!fresh) return known->second;
    Best found;
    found.pieces = fits(size_mm, tray_) ? 1 : 0;
    for (int a = 0; a < 3 && found.pieces != 1; ++a) {
        for (const double at : sums(size_mm[a])) {
            Vec3d back = size_mm, front = size_mm;
            back[a] = at;
            front[a] = size_mm[a] - at;
            const int32_t pieces = best(back).pieces + best(front).pieces;
            if (found.pieces == 0 || pieces < found.pieces) found = {pieces, a, at};
        }
    }
    return known_[key] = found;
}

Tree BoxPlan::tree(const Box3d& box) {
    Tree out;
    out.pieces = {""};
    cut(box, 0, &out);
    return out;
}

/// Cuts the piece `leaf`, which is that box.
void BoxPlan::cut(const Box3d& box, int32_t leaf, Tree* tree) {
    const Best choice = best(box.size());
    if (choice.pieces <= 1) return;
    const auto number = static_cast<int32_t>(tree->cuts.size());
    for (Cut& other : tree->cuts) {
        if (other.front == ~leaf) other.front = number;
        if (other.back == ~leaf) other.back = number;
    }
    const auto added = static_cast<int32_t>(tree->pieces.size());
    tree->pieces.emplace_back();
    Cut cut_here;
    cut_here.normal = {0, 0, 0};
    cut_here.normal[choice.axis] = 1;
    cut_here.offset_mm = box.lo[choice.axis] + choice.at_mm;
    cut_here.back = ~leaf;
    cut_here.front = ~added;
    tree->cuts.push_back(cut_here);
    Box3d back = box, front = box;
    back.hi[choice.axis] = front.lo[choice.axis] = cut_here.offset_mm;
    cut(back, leaf, tree);
    cut(front, added, tree);
}

}  // namespace openfab::pieces
