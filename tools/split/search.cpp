// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/split/search.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "base/at.h"

#include "tools/split/box_plan.h"
#include "tools/split/coarse_solid.h"
#include "tools/split/place_connectors.h"
#include "tools/split/slivers.h"

namespace openfab::pieces {

namespace {

constexpr double kSlack = 1e-6;  // of shares
constexpr int32_t kMostPieces = 500;

/// A part of the solid that one leaf of a tree holds.
struct Chunk {
    std::vector<int32_t> voxels;
    Box3d box;  ///< exact where it was cut along axes
    int32_t leaf = 0;
};

struct State {
    Tree tree;
    std::vector<std::shared_ptr<const Chunk>> open;
    int32_t closed = 0;
    int32_t estimate = 0;  ///< pieces in the end, at least
    double cost = 0;
};

struct Candidate {
    Vec3d normal;
    double offset = 0;
    int32_t estimate = 0;  ///< pieces of both sides, at least
    double cost = 0;
};

class Search {
  public:
    Search(const Body& body, const SearchOptions& options)
        : options_(options), solid_(body, options.voxels) {
        for (const Vec3d& p : body.positions)
            box_.add(p);
        weights_.resize(solid_.centers().size());
        for (size_t i = 0; i < weights_.size(); ++i) {
            if (solid_.skin()[i] == 0) continue;
            const Vec3d p = vec_cast<double>(solid_.centers()[i]);
            weights_[i] = static_cast<float>((options.seam ? options.seam(p) : 1) * crease(p));
            all_skin_ += 1;
        }
        if (options.stress) {
            stress_.resize(solid_.centers().size());
            for (size_t i = 0; i < stress_.size(); ++i) {
                stress_[i] = static_cast<float>(
                    std::max(options.stress(vec_cast<double>(solid_.centers()[i])), 0.0));
                all_stress_ += double{stress_[i]};
            }
        }
        normals_ = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        for (const double s : {1.0, -1.0}) {
            for (const Vec3d& n : {Vec3d{1, s, 0}, Vec3d{1, 0, s}, Vec3d{0, 1, s}})
                normals_.push_back(n * (1 / length(n)));
        }
    }

    Result<Found> run(const Body& body) {
        Found found;
        found.voxel_mm = solid_.pitch_mm();
        BoxPlan plan(options_.tray_mm);
        const int32_t box_least = plan.least(box_.size());
        found.least = box_least > 0 ? box_least : pieces_of_box(box_.size(), options_.tray_mm);
        if (solid_.centers().empty()) return user_error("the part holds no volume");
        auto whole = std::make_shared<Chunk>();
        whole->voxels.resize(solid_.centers().size());
        for (size_t i = 0; i < whole->voxels.size(); ++i)
            whole->voxels[i] = static_cast<int32_t>(i);
        whole->box = box_;
        State first;
        first.tree.pieces = {""};
        if (!fits(box_.size(), options_.tray_mm)) first.open.push_back(whole);
        first.estimate = found.least;
        std::vector<State> beam{first};
        while (!beam[0].open.empty()) {
            std::vector<State> next;
            for (const State& state : beam) {
                if (state.open.empty()) {
                    next.push_back(state);
                } else {
                    expand(state, &next);
                }
            }
            if (next.empty()) return user_error("no plane makes the part fit");
            std::stable_sort(next.begin(), next.end(), [](const State& a, const State& b) {
                return a.estimate != b.estimate ? a.estimate < b.estimate : a.cost < b.cost;
            });
            next.resize(std::min(next.size(), static_cast<size_t>(options_.beam)));
            beam = std::move(next);
            if (beam[0].estimate > kMostPieces)
                return user_error(fmt::format("the part needs more than {} pieces", kMostPieces));
        }
        State& best = beam[0];
        found.tree = std::move(best.tree);
        if (box_least > 0 && box_least < static_cast<int32_t>(found.tree.pieces.size()))
            take_if_whole(plan.tree(box_), &found.tree);
        name_pieces(&found.tree);
        found.pieces = static_cast<int32_t>(found.tree.pieces.size());
        found.seam_mm2 =
            best.cost * static_cast<double>(all_skin_) * found.voxel_mm * found.voxel_mm;
        found.looked_at = looked_at_;
        if (found.tree.cuts.empty()) return found;
        avoid_slivers(body, options_.tray_mm, &found.tree);
        found.slivers = find_slivers(body, found.tree);
        found.without_peg = place_connectors(body, solid_, options_, &found.tree);
        return found;
    }

  private:
    /// Takes other cuts if each of their pieces holds something.
    void take_if_whole(Tree made, Tree* tree) const {
        std::vector<bool> holds(made.pieces.size());
        for (const Vec3f& center : solid_.centers()) {
            const Vec3d p = vec_cast<double>(center);
            int32_t node = 0;
            while (node >= 0) {
                const Cut& cut = at(made.cuts, node);
                node = dot(cut.normal, p) > cut.offset_mm ? cut.front : cut.back;
            }
            at(holds, ~node) = true;
        }
        if (std::find(holds.begin(), holds.end(), false) == holds.end()) *tree = std::move(made);
    }

    /// Cuts the largest piece that does not fit.
    void expand(const State& state, std::vector<State>* out) {
        size_t largest = 0;
        for (size_t i = 1; i < state.open.size(); ++i) {
            if (state.open[i]->voxels.size() > state.open[largest]->voxels.size()) largest = i;
        }
        const Chunk& chunk = *state.open[largest];
        const int32_t before = std::max(pieces_of_box(chunk.box.size(), options_.tray_mm), 2);
        for (const Candidate& c : candidates(chunk)) {
            State made = state;
            made.open.erase(made.open.begin() + static_cast<std::ptrdiff_t>(largest));
            made.cost += c.cost;
            made.estimate += c.estimate - before;
            apply(chunk, c, &made);
            out->push_back(std::move(made));
        }
    }

    void apply(const Chunk& chunk, const Candidate& c, State* state) {
        auto back = std::make_shared<Chunk>(), front = std::make_shared<Chunk>();
        for (const int32_t v : chunk.voxels) {
            const Vec3d p = vec_cast<double>(solid_.centers()[static_cast<size_t>(v)]);
            (dot(c.normal, p) > c.offset ? front : back)->voxels.push_back(v);
        }
        Tree& tree = state->tree;
        const auto cut = static_cast<int32_t>(tree.cuts.size());
        for (Cut& other : tree.cuts) {
            if (other.front == ~chunk.leaf) other.front = cut;
            if (other.back == ~chunk.leaf) other.back = cut;
        }
        tree.pieces.emplace_back();
        const auto added = static_cast<int32_t>(tree.pieces.size()) - 1;
        Cut made;
        made.normal = c.normal;
        made.offset_mm = c.offset;
        made.back = ~chunk.leaf;
        made.front = ~added;
        tree.cuts.push_back(made);
        back->leaf = chunk.leaf;
        front->leaf = added;
        for (const bool is_front : {false, true}) {
            const std::shared_ptr<Chunk>& part = is_front ? front : back;
            Box3d box;
            for (const int32_t v : part->voxels)
                box.add(vec_cast<double>(solid_.centers()[static_cast<size_t>(v)]));
            part->box = side_box(chunk.box, box, c.normal, c.offset, is_front);
            if (!fits(part->box.size(), options_.tray_mm)) state->open.push_back(part);
        }
    }

    /// Returns a box that holds a side of a cut: around its voxels, and exact where the cut is along an
    /// axis.
    Box3d side_box(const Box3d& parent, const Box3d& centers, const Vec3d& normal, double offset,
                   bool front) const {
        Box3d out;
        for (int a = 0; a < 3; ++a) {
            out.lo[a] = std::max(centers.lo[a] - solid_.pitch_mm(), parent.lo[a]);
            out.hi[a] = std::min(centers.hi[a] + solid_.pitch_mm(), parent.hi[a]);
            if (normal[a] != 1) continue;
            if (front) out.lo[a] = std::max(out.lo[a], offset);
            if (!front) out.hi[a] = std::min(out.hi[a], offset);
        }
        return out;
    }

    std::vector<Candidate> candidates(const Chunk& chunk) {
        std::vector<Candidate> all;
        for (const Vec3d& normal : normals_)
            along(chunk, normal, &all);
        std::stable_sort(all.begin(), all.end(), [](const Candidate& a, const Candidate& b) {
            return a.estimate != b.estimate ? a.estimate < b.estimate : a.cost < b.cost;
        });
        // Neighbours say the same: the best of each neighbourhood.
        std::vector<Candidate> out;
        for (const Candidate& c : all) {
            const bool near = std::any_of(out.begin(), out.end(), [&](const Candidate& o) {
                return o.normal == c.normal &&
                       std::fabs(o.offset - c.offset) < 4 * solid_.pitch_mm();
            });
            if (!near) out.push_back(c);
            if (out.size() == 2 * static_cast<size_t>(options_.beam)) break;
        }
        return out;
    }

    /// Appends the planes of a normal, with what they cost: all are looked at in one pass over voxels.
    void along(const Chunk& chunk, const Vec3d& normal, std::vector<Candidate>* out) {
        const double pitch = solid_.pitch_mm();
        double lo = 1e300, hi = -1e300;
        std::vector<double> at(chunk.voxels.size());
        for (size_t i = 0; i < at.size(); ++i) {
            at[i] = dot(normal,
                        vec_cast<double>(solid_.centers()[static_cast<size_t>(chunk.voxels[i])]));
            lo = std::min(lo, at[i]), hi = std::max(hi, at[i]);
        }
        const auto bins = static_cast<size_t>((hi - lo) / pitch) + 1;
        struct Bin {
            Box3d box;
            double skin = 0, stress = 0;
            int64_t voxels = 0;
        };
        std::vector<Bin> bin(bins);
        for (size_t i = 0; i < at.size(); ++i) {
            Bin& b = bin[std::min(static_cast<size_t>((at[i] - lo) / pitch), bins - 1)];
            const auto v = static_cast<size_t>(chunk.voxels[i]);
            b.box.add(vec_cast<double>(solid_.centers()[v]));
            b.skin += double{weights_[v]};
            if (!stress_.empty()) b.stress += double{stress_[v]};
            ++b.voxels;
        }
        std::vector<Box3d> below(bins + 1), above(bins + 1);
        for (size_t i = 0; i < bins; ++i)
            below[i + 1] = below[i], below[i + 1].add(bin[i].box);
        for (size_t i = bins; i-- > 0;)
            above[i] = above[i + 1], above[i].add(bin[i].box);
        std::vector<double> offsets;
        for (size_t i = 1; i < bins; ++i)
            offsets.push_back(lo + static_cast<double>(i) * pitch - pitch / 2);
        for (int a = 0; a < 3; ++a) {
            if (normal[a] != 1) continue;
            // As much as the tray holds from either end, and equal shares.
            for (int t = 0; t < 3; ++t) {
                const double size = chunk.box.size()[a], tray = options_.tray_mm[t];
                const double shares = std::ceil(size / tray - kSlack);
                for (double k = 1; k < std::min(shares, 100.0); ++k) {
                    offsets.push_back(chunk.box.lo[a] + k * tray);
                    offsets.push_back(chunk.box.hi[a] - k * tray);
                    offsets.push_back(chunk.box.lo[a] + k * size / shares);
                }
            }
        }
        const double thin =
            std::max(4 * pitch,
                     0.05 * std::min({options_.tray_mm.x, options_.tray_mm.y, options_.tray_mm.z}));
        for (const double offset : offsets) {
            const double place = (offset - lo) / pitch;
            if (!(place > 0 && place < static_cast<double>(bins))) continue;
            ++looked_at_;
            const auto b = static_cast<size_t>(place);
            Candidate c{normal, offset, 0, 0};
            const Box3d back = side_box(chunk.box, below[b + 1], normal, offset, false);
            const Box3d front = side_box(chunk.box, above[b], normal, offset, true);
            c.estimate = pieces_of_box(back.size(), options_.tray_mm) +
                         pieces_of_box(front.size(), options_.tray_mm);
            // The seam, as a share of the surface; thin ends; cuts far from where two halves are.
            c.cost = bin[b].skin / static_cast<double>(std::max<int64_t>(all_skin_, 1));
            if (all_stress_ > 0) c.cost += bin[b].stress / all_stress_;
            const double end = std::min(offset - lo, hi - offset) + pitch / 2;
            if (end < thin) c.cost += 0.2 * (1 - end / thin);
            const double radius = options_.peg_mm / 2 + options_.skin_mm;
            const double area = static_cast<double>(bin[b].voxels) * pitch * pitch;
            if (area < 4 * radius * radius) c.cost += 0.05;
            out->push_back(c);
        }
    }

    /// Returns how well a seam shows at a point of the surface: least in a crease, most on an edge, by how much of
    /// a ball is solid.
    double crease(const Vec3d& p) const {
        constexpr int kRadius = 4;  // voxels
        constexpr double kFlat = 0.7, kSlope = 2, kLeast = 0.4, kMost = 1.3;
        int all = 0, inside = 0;
        for (int z = -kRadius; z <= kRadius; z += 2) {
            for (int y = -kRadius; y <= kRadius; y += 2) {
                for (int x = -kRadius; x <= kRadius; x += 2) {
                    if (x * x + y * y + z * z > kRadius * kRadius) continue;
                    ++all;
                    inside +=
                        solid_.solid(p + Vec3d{double(x), double(y), double(z)} * solid_.pitch_mm())
                            ? 1
                            : 0;
                }
            }
        }
        const double share = static_cast<double>(inside) / all;
        return std::clamp(1 - kSlope * (share - kFlat), kLeast, kMost);
    }

    static void name_side(Tree* tree, int32_t node, const std::string& path) {
        if (node < 0) {
            at(tree->pieces, ~node) = path;
            return;
        }
        const std::string dot = path.empty() ? "" : path + ".";
        name_side(tree, at(tree->cuts, node).back, dot + "1");
        name_side(tree, at(tree->cuts, node).front, dot + "2");
    }
    static void name_pieces(Tree* tree) {
        if (!tree->cuts.empty()) name_side(tree, 0, "");
    }

    const SearchOptions& options_;
    const CoarseSolid solid_;
    Box3d box_;
    std::vector<float> weights_;
    std::vector<float> stress_;
    int64_t all_skin_ = 0;
    double all_stress_ = 0;
    std::vector<Vec3d> normals_;
    int32_t looked_at_ = 0;
};

}  // namespace

bool fits(const Vec3d& size_mm, const Vec3d& tray_mm) {
    return pieces_of_box(size_mm, tray_mm) == 1;
}

int32_t pieces_of_box(const Vec3d& size_mm, const Vec3d& tray_mm) {
    double least = 1e9;
    const int orders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    for (const auto& order : orders) {
        double count = 1;
        for (int a = 0; a < 3; ++a)
            count *= std::max(std::ceil(size_mm[order[a]] / tray_mm[a] - kSlack), 1.0);
        least = std::min(least, count);
    }
    return static_cast<int32_t>(least);
}

Result<Found> find_cuts(const Body& body, const SearchOptions& options) {
    // Voxels miss what is thinner than they are. Where a piece turns out to be too large, the search
    // is repeated for a tray that is smaller by one voxel, so that a box still gets the least number.
    constexpr int kTries = 5;
    SearchOptions asked = options;
    Result<Found> plan = user_error("");
    for (int i = 0; i < kTries; ++i) {
        plan = Search(body, asked).run(body);
        if (!plan || plan->tree.cuts.empty()) break;
        const std::vector<Region> all = regions(plan->tree);
        const bool fit = std::all_of(all.begin(), all.end(), [&](const Region& region) {
            return region.shapes_only || fits(piece_box(body, region, {}).size(), options.tray_mm);
        });
        if (fit) break;
        for (int a = 0; a < 3; ++a)
            asked.tray_mm[a] = std::max(asked.tray_mm[a] - plan->voxel_mm, options.tray_mm[a] / 2);
    }
    return plan;
}

}  // namespace openfab::pieces
