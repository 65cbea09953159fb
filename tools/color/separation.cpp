// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/color/separation.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace openfab::color {

namespace {

constexpr size_t kInks = 4;

/// How much a difference counts along each direction, where a colour cannot be reached.
constexpr double kOfLightness = 1, kOfChroma = 0.75, kOfHue = 1.5;

/// Weights that hold black near what is wanted, per unit of its root.
constexpr double kFirm = 30, kLight = 1, kUnseen = 0.05;

Lab blend(const Lab& a, const Lab& b, double t) {
    return {a.l + (b.l - a.l) * t, a.a + (b.a - a.a) * t, a.b + (b.b - a.b) * t};
}

/// Differences of lightness, chroma and hue about `target`; those of chroma and hue as projections,
/// so that they are smooth.
std::array<double, 3> differences(const Lab& target, const Lab& is) {
    const double chroma = std::hypot(target.a, target.b);
    // Grey has no hue: both directions count alike, and the weights fade in.
    constexpr double kGrey = 10;
    const double share = chroma / (chroma + kGrey);
    const double u = chroma > 0 ? target.a / chroma : 1, v = chroma > 0 ? target.b / chroma : 0;
    const double da = is.a - target.a, db = is.b - target.b;
    const double of_chroma = 1 + (kOfChroma - 1) * share, of_hue = 1 + (kOfHue - 1) * share;
    return {kOfLightness * (is.l - target.l), of_chroma * (da * u + db * v),
            of_hue * (db * u - da * v)};
}

double square(const std::array<double, 3>& d) {
    return d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
}

/// Solves a small system in place; a variable without effect gets 0.
void solve(std::array<std::array<double, kInks + 1>, kInks>* system, std::array<double, kInks>* x) {
    auto& m = *system;
    for (size_t i = 0; i < kInks; ++i) {
        size_t pivot = i;
        for (size_t k = i + 1; k < kInks; ++k) {
            if (std::abs(m[k][i]) > std::abs(m[pivot][i])) pivot = k;
        }
        std::swap(m[i], m[pivot]);
        if (m[i][i] == 0) continue;
        for (size_t k = i + 1; k < kInks; ++k) {
            const double f = m[k][i] / m[i][i];
            for (size_t j = i; j <= kInks; ++j)
                m[k][j] -= f * m[i][j];
        }
    }
    for (size_t i = kInks; i-- > 0;) {
        double value = m[i][kInks];
        for (size_t j = i + 1; j < kInks; ++j)
            value -= m[i][j] * (*x)[j];
        (*x)[i] = m[i][i] == 0 ? 0 : value / m[i][i];
    }
}

}  // namespace

InkGrid::InkGrid(const PrinterModel& model, int nodes) : nodes_(nodes) {
    const Xyz white = to_xyz(model.white());
    const double last = nodes - 1;
    // The colour of roots, shortened or stretched.
    const auto of_roots = [&](Inks roots, double scale) {
        for (double& root : roots)
            root *= root * scale * scale;
        return to_lab(to_xyz(model.predict(roots)), white);
    };
    std::array<int, kInks> at{};
    for (at[0] = 0; at[0] < nodes; ++at[0]) {
        for (at[1] = 0; at[1] < nodes; ++at[1]) {
            for (at[2] = 0; at[2] < nodes; ++at[2]) {
                for (at[3] = 0; at[3] < nodes; ++at[3]) {
                    Inks roots, before;
                    double sum = 0, sum_before = 0;
                    for (size_t i = 0; i < kInks; ++i) {
                        roots[i] = at[i] / last;
                        sum += roots[i] * roots[i];
                        before[i] = std::max(at[i] - 1, 0) / last;
                        sum_before += before[i] * before[i];
                    }
                    if (sum <= 1) {
                        colours_.push_back(of_roots(roots, 1));
                        continue;
                    }
                    const double scale = 1 / std::sqrt(sum);
                    Lab lab = of_roots(roots, scale);
                    // Mixtures without white lie within cells that reach beyond them: what these
                    // cells' corners there hold continues what is within, or white would show.
                    if (sum_before < 1) lab = blend(of_roots(roots, 2 * scale - 1), lab, 2);
                    colours_.push_back(lab);
                }
            }
        }
    }
}

Lab InkGrid::at(const Inks& inks) const {
    Inks roots;
    for (size_t i = 0; i < kInks; ++i)
        roots[i] = std::sqrt(std::max(inks[i], 0.0));
    return at_roots(roots);
}

Lab InkGrid::at_roots(const Inks& roots) const {
    std::array<int, kInks> cell{};
    Inks f{};
    for (size_t i = 0; i < kInks; ++i) {
        const double place = std::clamp(roots[i], 0.0, 1.0) * (nodes_ - 1);
        cell[i] = std::min(static_cast<int>(place), nodes_ - 2);
        f[i] = place - cell[i];
    }
    // The path from the cell's lowest corner to its highest takes the axes from the largest
    // fraction to the smallest.
    std::array<size_t, 3> axes = {1, 2, 3};
    std::stable_sort(axes.begin(), axes.end(), [&](size_t a, size_t b) { return f[a] > f[b]; });
    const auto tetrahedron = [&](std::array<int, kInks> corner) {
        Lab sum = node(corner);
        Lab before = sum;
        for (const size_t axis : axes) {
            ++corner[axis];
            const Lab& next = node(corner);
            sum.l += (next.l - before.l) * f[axis];
            sum.a += (next.a - before.a) * f[axis];
            sum.b += (next.b - before.b) * f[axis];
            before = next;
        }
        return sum;
    };
    std::array<int, kInks> beyond = cell;
    ++beyond[0];
    return blend(tetrahedron(cell), tetrahedron(beyond), f[0]);
}

Separation::Separation(const InkGrid& grid, const SeparationOptions& options)
    : grid_(grid), options_(options) {
    // Equal steps of roots, and what lies beyond the limit brought back to it.
    constexpr int kSteps = 6;
    const double reach = std::sqrt(options.limit);
    std::array<int, kInks> n{};
    for (n[0] = 0; n[0] <= kSteps; ++n[0]) {
        for (n[1] = 0; n[1] <= kSteps; ++n[1]) {
            for (n[2] = 0; n[2] <= kSteps; ++n[2]) {
                for (n[3] = 0; n[3] <= kSteps; ++n[3]) {
                    constexpr int kBeyond = (kSteps + 1) * (kSteps + 1);
                    if (n[0] * n[0] + n[1] * n[1] + n[2] * n[2] + n[3] * n[3] > kBeyond) continue;
                    Start start;
                    for (size_t i = 0; i < kInks; ++i)
                        start.roots[i] = reach * n[i] / kSteps;
                    bring_to_limit(&start.roots);
                    start.lab = grid.at_roots(start.roots);
                    starts_.push_back(start);
                }
            }
        }
    }
    constexpr int kWedge = 64;
    for (int i = 0; i <= kWedge; ++i)
        black_wedge_.push_back(grid.at_roots({0, 0, 0, reach * i / kWedge}).l);
    darkest_ = grid_.at({0, 0, 0, options.limit}).l;
    constexpr double kGreyish = 6;
    for (const Start& start : starts_) {
        if (std::hypot(start.lab.a, start.lab.b) < kGreyish)
            darkest_ = std::min(darkest_, start.lab.l);
    }
    darkest_ = std::clamp(darkest_, 0.0, 99.0);
}

Lab Separation::perceptual(const Lab& colour, double black) const {
    const double scale = (100 - darkest_) / (100 - black);
    return {darkest_ + std::max(colour.l - black, 0.0) * scale, colour.a * scale, colour.b * scale};
}

double Separation::wanted_black(const Lab& colour) const {
    // The first step of the wedge that is as dark.
    size_t i = 0;
    while (i + 1 < black_wedge_.size() && black_wedge_[i + 1] > colour.l)
        ++i;
    double place = static_cast<double>(i);
    if (i + 1 < black_wedge_.size() && black_wedge_[i] > colour.l) {
        const double step = black_wedge_[i] - black_wedge_[i + 1];
        if (step > 0) place += (black_wedge_[i] - colour.l) / step;
    }
    const double root =
        std::sqrt(options_.limit) * place / static_cast<double>(black_wedge_.size() - 1);
    constexpr double kStrong = 40;  // chroma at which a third is left
    return options_.black * root * root * std::exp(-std::hypot(colour.a, colour.b) / kStrong);
}

double Separation::settle(const Lab& colour, double black, double weight, Inks* roots) const {
    // The nearest of all starts may lie in another valley than the least cost: a few are followed.
    constexpr size_t kFollowed = 3;
    std::array<std::pair<double, const Start*>, kFollowed> nearest{};
    nearest.fill({std::numeric_limits<double>::infinity(), nullptr});
    for (const Start& start : starts_) {
        const double off = weight * (start.roots[3] - black);
        const double cost = square(differences(colour, start.lab)) + off * off;
        if (cost >= nearest.back().first) continue;
        nearest.back() = {cost, &start};
        for (size_t i = kFollowed - 1; i > 0 && nearest[i].first < nearest[i - 1].first; --i)
            std::swap(nearest[i], nearest[i - 1]);
    }
    double least = std::numeric_limits<double>::infinity();
    for (const auto& [unused, start] : nearest) {
        Inks found = start->roots;
        double cost = refine(colour, black, weight, &found);
        if (weight < kLight && cost > kUnseen) cost = polish(colour, black, weight, &found);
        if (cost >= least) continue;
        least = cost;
        *roots = found;
    }
    return std::sqrt(square(differences(colour, grid_.at_roots(*roots))));
}

Inks Separation::find(const Lab& colour) const {
    const double black = std::sqrt(wanted_black(colour));
    constexpr double kAsNear = 0.25;
    Inks nearest{};
    const double least = settle(colour, black, kUnseen, &nearest);
    Inks roots = nearest;
    if (least < kAsNear) {
        const auto off = [&](const Inks& r) {
            return std::sqrt(square(differences(colour, grid_.at_roots(r))));
        };
        settle(colour, black, kFirm, &roots);
        // With black held near what is wanted until now; then for the colour.
        refine(colour, roots[3], kLight, &roots);
        // Where only another amount of black comes nearer, it gives way: just as far as it must.
        for (double weight = kFirm / 2; off(roots) > least + kAsNear; weight /= 4) {
            if (weight < kUnseen) {
                roots = nearest;
                break;
            }
            Inks other = nearest;
            refine(colour, black, weight, &other);
            if (off(other) < off(roots)) roots = other;
        }
    }
    Inks inks;
    for (size_t i = 0; i < kInks; ++i)
        inks[i] = roots[i] * roots[i];
    return inks;
}

double Separation::refine(const Lab& colour, double black, double weight, Inks* roots) const {
    constexpr int kMostSteps = 40;
    constexpr size_t kRows = 4;
    constexpr double kNudge = 1e-3, kSmall = 1e-4, kMostDamping = 1e5;
    using Rows = std::array<double, kRows>;
    const auto rows_of = [&](const Inks& r) {
        const std::array<double, 3> d = differences(colour, grid_.at_roots(r));
        return Rows{d[0], d[1], d[2], weight * (r[3] - black)};
    };
    const auto cost_of = [](const Rows& rows) {
        double sum = 0;
        for (const double row : rows)
            sum += row * row;
        return sum;
    };
    Rows here = rows_of(*roots);
    double cost = cost_of(here);
    double damping = 1e-2;
    // Where the inks are at their limit, slopes are taken inwards first, then along it: a step is
    // brought back to the limit in any case.
    bool inwards = true;
    for (int step = 0; step < kMostSteps; ++step) {
        std::array<Rows, kInks> slopes;
        std::array<double, kInks> gradient{};
        for (size_t i = 0; i < kInks; ++i) {
            Inks moved = *roots;
            moved[i] += inwards && moved[i] > kNudge ? -kNudge : kNudge;
            bring_to_limit(&moved);
            const double nudge = inwards && (*roots)[i] > kNudge ? -kNudge : kNudge;
            slopes[i] = rows_of(moved);
            for (size_t k = 0; k < kRows; ++k) {
                slopes[i][k] = (slopes[i][k] - here[k]) / nudge;
                gradient[i] += slopes[i][k] * here[k];
            }
        }
        bool better = false;
        double gain = 0;
        while (!better && damping < kMostDamping) {
            std::array<std::array<double, kInks + 1>, kInks> system{};
            for (size_t i = 0; i < kInks; ++i) {
                // At 0 and pushed beyond: it stays.
                if ((*roots)[i] <= 0 && gradient[i] > 0) {
                    system[i][i] = 1;
                    continue;
                }
                for (size_t j = 0; j < kInks; ++j) {
                    for (size_t k = 0; k < kRows; ++k)
                        system[i][j] += slopes[i][k] * slopes[j][k];
                }
                system[i][i] += damping * (system[i][i] + 1);
                system[i][kInks] = -gradient[i];
            }
            std::array<double, kInks> change{};
            solve(&system, &change);
            Inks moved = *roots;
            for (size_t i = 0; i < kInks; ++i)
                moved[i] = std::clamp(moved[i] + change[i], 0.0, 1.0);
            bring_to_limit(&moved);
            const Rows there = rows_of(moved);
            const double now = cost_of(there);
            better = now < cost;
            if (better) {
                gain = cost - now;
                cost = now;
                here = there;
                *roots = moved;
            }
            damping *= better ? 0.2 : 8;
        }
        if (better && gain > kSmall) continue;
        if (!inwards) break;
        inwards = false;
        damping = 1e-2;
    }
    return cost;
}

double Separation::polish(const Lab& colour, double black, double weight, Inks* roots) const {
    const auto cost_of = [&](const Inks& r) {
        const double off = weight * (r[3] - black);
        return square(differences(colour, grid_.at_roots(r))) + off * off;
    };
    constexpr double kFirst = 0.032, kLast = 0.0005;
    double cost = cost_of(*roots);
    bool better = false;
    for (double step = kFirst; step > kLast; step /= better ? 1 : 2) {
        better = false;
        for (size_t i = 0; i < kInks; ++i) {
            for (size_t j = 0; j < kInks; ++j) {
                for (const double way : {-step, step}) {
                    // One ink alone, or one for another.
                    Inks moved = *roots;
                    moved[i] = std::clamp(moved[i] + way, 0.0, 1.0);
                    const double rest =
                        (*roots)[j] * (*roots)[j] + (*roots)[i] * (*roots)[i] - moved[i] * moved[i];
                    if (rest < 0) continue;
                    if (j != i) moved[j] = std::sqrt(rest);
                    bring_to_limit(&moved);
                    const double now = cost_of(moved);
                    if (now >= cost) continue;
                    better = true;
                    cost = now;
                    *roots = moved;
                }
            }
        }
    }
    return cost;
}

void Separation::bring_to_limit(Inks* roots) const {
    double sum = 0;
    for (const double root : *roots)
        sum += root * root;
    if (sum <= options_.limit) return;
    for (double& root : *roots)
        root *= std::sqrt(options_.limit / sum);
}

}  // namespace openfab::color
