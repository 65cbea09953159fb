// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/split/place_connectors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "base/at.h"

#include "pieces/collide.h"

namespace openfab::pieces {

namespace {

constexpr double kDowelLength = 2.5;  // diameters
constexpr std::array<double, 9> kSame{1, 0, 0, 0, 1, 0, 0, 0, 1};

/// A cell of the section of a cut: which two pieces meet there, if both go on behind it.
struct Cell {
    const std::string* back = nullptr;
    const std::string* front = nullptr;
    bool operator==(const Cell&) const = default;
};

struct Section {
    Vec3d origin, u, v;
    int32_t width = 0, height = 0;
    double pitch = 1;
    std::vector<Cell> cells;

    const Cell& at(int32_t x, int32_t y) const {
        return cells[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)];
    }
    Vec3d point(int32_t x, int32_t y) const {
        return origin + u * ((x + 0.5) * pitch) + v * ((y + 0.5) * pitch);
    }
    /// Returns the distance of the nearest cell that is not alike, at most `most_mm`.
    double room(int32_t x, int32_t y, double most_mm) const {
        const auto r = static_cast<int32_t>(std::ceil(most_mm / pitch));
        double least = most_mm;
        for (int32_t dy = -r; dy <= r; ++dy) {
            for (int32_t dx = -r; dx <= r; ++dx) {
                const bool within = x + dx >= 0 && y + dy >= 0 && x + dx < width && y + dy < height;
                if (within && at(x + dx, y + dy) == at(x, y)) continue;
                least = std::min(least, std::hypot(dx, dy) * pitch);
            }
        }
        return least;
    }
    /// Returns whether all cells within a radius are alike.
    bool clear(int32_t x, int32_t y, double radius_mm) const {
        const auto r = static_cast<int32_t>(std::ceil(radius_mm / pitch));
        for (int32_t dy = -r; dy <= r; ++dy) {
            for (int32_t dx = -r; dx <= r; ++dx) {
                if (dx * dx + dy * dy > r * r) continue;
                if (x + dx < 0 || y + dy < 0 || x + dx >= width || y + dy >= height) return false;
                if (!(at(x + dx, y + dy) == at(x, y))) return false;
            }
        }
        return true;
    }
};

Section section_of(const Tree& tree, const Cut& cut, const CoarseSolid& solid, const Box3d& box,
                   double depth_mm) {
    Section s;
    s.pitch = solid.pitch_mm();
    s.v = upright(cut.normal);
    s.u = cross(s.v, cut.normal);
    double lo[2] = {1e300, 1e300}, hi[2] = {-1e300, -1e300};
    for (uint32_t i = 0; i < 8; ++i) {
        const Vec3d p{(i & 1) != 0 ? box.hi.x : box.lo.x, (i & 2) != 0 ? box.hi.y : box.lo.y,
                      (i & 4) != 0 ? box.hi.z : box.lo.z};
        lo[0] = std::min(lo[0], dot(p, s.u)), hi[0] = std::max(hi[0], dot(p, s.u));
        lo[1] = std::min(lo[1], dot(p, s.v)), hi[1] = std::max(hi[1], dot(p, s.v));
    }
    s.origin = cut.normal * cut.offset_mm + s.u * lo[0] + s.v * lo[1];
    s.width = static_cast<int32_t>((hi[0] - lo[0]) / s.pitch) + 1;
    s.height = static_cast<int32_t>((hi[1] - lo[1]) / s.pitch) + 1;
    s.cells.resize(static_cast<size_t>(s.width) * static_cast<size_t>(s.height));
    for (int32_t y = 0; y < s.height; ++y) {
        for (int32_t x = 0; x < s.width; ++x) {
            const Vec3d p = s.point(x, y);
            Cell cell;
            bool whole = true;
            for (const double side : {-1.0, 1.0}) {
                const std::string* piece = nullptr;
                for (const double part : {0.02, 0.5, 1.0}) {
                    const Vec3d q = p + cut.normal * (side * part * depth_mm);
                    const std::string* here = &piece_at(tree, q);
                    whole = whole && solid.solid(q) && (piece == nullptr || piece == here);
                    piece = here;
                }
                (side < 0 ? cell.back : cell.front) = piece;
            }
            if (whole)
                s.cells[static_cast<size_t>(y) * static_cast<size_t>(s.width) +
                        static_cast<size_t>(x)] = cell;
        }
    }
    return s;
}

/// Returns the pieces below a node.
void pieces_below(const Tree& tree, int32_t node, std::vector<const std::string*>* out) {
    if (node < 0) return out->push_back(&at(tree.pieces, ~node));
    pieces_below(tree, at(tree.cuts, node).front, out);
    pieces_below(tree, at(tree.cuts, node).back, out);
}

class Placer {
  public:
    Placer(const Body& body, const CoarseSolid& solid, const SearchOptions& options, Tree* tree)
        : body_(body), solid_(solid), options_(options), tree_(*tree) {
        for (const Vec3d& p : body.positions)
            box_.add(p);
    }

    int32_t run() {
        int32_t without = 0;
        for (size_t i = 0; i < tree_.cuts.size(); ++i) {
            const double depth = options_.peg_mm > 0 ? options_.peg_mm * kDowelLength / 2 +
                                                           options_.clearance_mm + options_.skin_mm
                                                     : 2 * solid_.pitch_mm();
            const Section section = section_of(tree_, tree_.cuts[i], solid_, box_, depth);
            std::vector<const std::string*> front;
            pieces_below(tree_, tree_.cuts[i].front, &front);
            std::map<std::pair<std::string, std::string>, std::vector<std::pair<int32_t, int32_t>>>
                pairs;
            for (int32_t y = 0; y < section.height; ++y) {
                for (int32_t x = 0; x < section.width; ++x) {
                    const Cell& cell = section.at(x, y);
                    if (cell.front == nullptr || cell.back == cell.front) continue;
                    // Where another cut keeps them apart this one has no face.
                    if (std::find(front.begin(), front.end(), cell.front) == front.end()) continue;
                    if (std::find(front.begin(), front.end(), cell.back) != front.end()) continue;
                    pairs[{*cell.back, *cell.front}].emplace_back(x, y);
                }
            }
            for (const auto& [names, cells] : pairs) {
                if (!join(i, section, cells)) ++without;
            }
        }
        return without;
    }

  private:
    using Cells = std::vector<std::pair<int32_t, int32_t>>;

    /// Returns whether a dowel was placed.
    bool join(size_t cut, const Section& section, const Cells& cells) {
        std::vector<Vec3d> used;
        bool any = options_.peg_mm <= 0;
        if (options_.peg_mm > 0) {
            const double radius =
                options_.peg_mm / 2 + options_.clearance_mm + options_.skin_mm + solid_.pitch_mm();
            Cells clear;
            for (const auto& [x, y] : cells) {
                if (section.clear(x, y, radius)) clear.emplace_back(x, y);
            }
            constexpr int kTries = 12;
            const Vec3d center = clear.empty() ? Vec3d{} : middle(section, clear);
            for (int n = 0; n < kTries && used.size() < 2 && !clear.empty(); ++n) {
                // The first near a corner of what is possible, the second far from it.
                const Vec3d from = used.empty() ? center : used[0];
                const auto best =
                    std::max_element(clear.begin(), clear.end(), [&](const auto& a, const auto& b) {
                        return length(section.point(a.first, a.second) - from) <
                               length(section.point(b.first, b.second) - from);
                    });
                const Vec3d at = section.point(best->first, best->second);
                if (!used.empty() && length(at - used[0]) < 2.5 * options_.peg_mm) break;
                if (add_dowel(cut, at)) used.push_back(at), any = true;
                std::erase_if(clear, [&](const auto& cell) {
                    return length(section.point(cell.first, cell.second) - at) <
                           options_.peg_mm / 2;
                });
            }
        }
        if (!any) any = place_tight(cut, section, cells, &used);
        if (options_.number_mm > 0) number(cut, section, cells, used);
        return any;
    }

    /// Puts a dowel where voxels do not tell whether there is room for it: tries where they see most, and moves it away
    /// from the mesh.
    bool place_tight(size_t cut, const Section& section, const Cells& cells,
                     std::vector<Vec3d>* used) {
        const double radius = options_.peg_mm / 2 + options_.clearance_mm + options_.skin_mm;
        std::vector<std::pair<double, Vec3d>> places;
        for (const auto& [x, y] : cells) {
            // Cells at both ends of the room are up to a voxel off.
            const double room = section.room(x, y, radius + section.pitch);
            if (room + 2 * section.pitch > radius) places.emplace_back(room, section.point(x, y));
        }
        std::stable_sort(places.begin(), places.end(),
                         [](const auto& a, const auto& b) { return a.first > b.first; });
        constexpr int kStarts = 4;
        for (int start = 0; start < kStarts && !places.empty(); ++start) {
            const Vec3d from = places[0].second;
            const Vec3d at = roomiest(cut, section, from);
            if (add_dowel(cut, at)) {
                used->push_back(at);
                return true;
            }
            std::erase_if(places, [&](const auto& place) {
                return length(place.second - from) < options_.peg_mm;
            });
        }
        return false;
    }

    /// Moves a dowel in its cut to where it is farthest from what it must keep away from, near a place.
    Vec3d roomiest(size_t cut, const Section& section, const Vec3d& from) const {
        Vec3d best = from;
        double most = spare(cut, from);
        constexpr int kHalvings = 4;
        double step = section.pitch;
        for (int halving = 0; halving < kHalvings;) {
            const Vec3d before = best;
            for (const Vec3d& way : {section.u, section.v, section.u * -1.0, section.v * -1.0}) {
                const Vec3d at = before + way * step;
                const double here = spare(cut, at);
                if (here > most) most = here, best = at;
            }
            if (best == before || length(best - from) > 3 * section.pitch) step /= 2, ++halving;
        }
        return best;
    }

    /// Returns by how much a dowel keeps farther away from the surface and from other cuts than it must.
    double spare(size_t cut, const Vec3d& at) const {
        double least = 1e300;
        for (const Region& plain : regions(alone_with(cut, dowel_at(at)))) {
            const Region region = mapped(plain, kSame, {});
            for (const Fit& fit : region.fits) {
                const Shape shape = fit.shape.upper();
                for (size_t s = 0; s < region.sides.size(); ++s) {
                    const Side& side = region.sides[s];
                    if (region.cuts[s] == fit.cut) continue;
                    const Vec3d outwards = side.front ? side.normal * -1.0 : side.normal;
                    least = std::min(least, side.depth(shape.farthest(outwards)));
                }
                // What is farther away matters to no dowel.
                const double reach = fit.skin_mm + options_.peg_mm;
                const Vec3d grow{reach, reach, reach};
                const Box3d box = shape.box(), around{box.lo - grow, box.hi + grow};
                least = std::min(least, reach - fit.skin_mm);
                for (size_t t = 0; t < body_.triangles.size(); ++t) {
                    const std::array<Vec3d, 3> triangle = body_.triangle(t);
                    Box3d of;
                    for (const Vec3d& p : triangle)
                        of.add(p);
                    if (!of.overlaps(around)) continue;
                    least = std::min(least, distance(shape, triangle) - fit.skin_mm);
                }
            }
        }
        return least;
    }

    static Vec3d middle(const Section& section, const Cells& cells) {
        Vec3d sum;
        for (const auto& [x, y] : cells)
            sum = sum + section.point(x, y);
        return sum * (1 / static_cast<double>(cells.size()));
    }

    Connector dowel_at(const Vec3d& at) const {
        Connector dowel;
        dowel.kind = Connector::Kind::kDowel;
        dowel.at_mm = at;
        dowel.diameter_mm = options_.peg_mm;
        dowel.length_mm = kDowelLength * options_.peg_mm;
        dowel.clearance_mm = options_.clearance_mm;
        dowel.skin_mm = options_.skin_mm;
        return dowel;
    }

    /// Returns the tree with a connector, and without the others.
    Tree alone_with(size_t cut, const Connector& connector) const {
        Tree alone = tree_;
        for (Cut& c : alone.cuts)
            c.connectors.clear(), c.numbers.clear();
        alone.cuts[cut].connectors.push_back(connector);
        return alone;
    }

    bool add_dowel(size_t cut, const Vec3d& at) {
        const Connector dowel = dowel_at(at);
        // Judged by the mesh itself.
        SourceLocation unused;
        for (const Region& region : regions(alone_with(cut, dowel))) {
            if (!region.fits.empty() &&
                !misfit(body_, mapped(region, kSame, {}), 0, &unused).empty())
                return false;
        }
        tree_.cuts[cut].connectors.push_back(dowel);
        if (nothing_collides()) return true;
        tree_.cuts[cut].connectors.pop_back();
        return false;
    }

    /// Whether what the cuts around a piece have leaves each other room.
    bool nothing_collides() const {
        const std::vector<Region> all = regions(tree_);
        return std::all_of(all.begin(), all.end(), [](const Region& region) {
            SourceLocation unused;
            return collision(mapped(region, kSame, {}), &unused).empty();
        });
    }

    void number(size_t cut, const Section& section, const Cells& cells,
                const std::vector<Vec3d>& used) {
        const Cell& pair = section.at(cells[0].first, cells[0].second);
        const auto letters = static_cast<double>(std::max(pair.back->size(), pair.front->size()));
        const double radius = options_.number_mm * std::max(0.6, 0.28 * letters);
        const Vec3d center = middle(section, cells);
        const std::pair<int32_t, int32_t>* best = nullptr;
        double least = 1e300;
        for (const auto& cell : cells) {
            const Vec3d p = section.point(cell.first, cell.second);
            const bool free = std::all_of(used.begin(), used.end(), [&](const Vec3d& d) {
                return length(d - p) > radius + options_.peg_mm;
            });
            if (!free || length(p - center) >= least ||
                !section.clear(cell.first, cell.second, radius))
                continue;
            least = length(p - center);
            best = &cell;
        }
        if (best == nullptr) return;
        Number made;
        made.at_mm = section.point(best->first, best->second);
        made.height_mm = options_.number_mm;
        made.depth_mm = 0.6;
        tree_.cuts[cut].numbers.push_back(made);
        if (!nothing_collides()) tree_.cuts[cut].numbers.pop_back();
    }

    const Body& body_;
    const CoarseSolid& solid_;
    const SearchOptions& options_;
    Tree& tree_;
    Box3d box_;
};

}  // namespace

int32_t place_connectors(const Body& body, const CoarseSolid& solid, const SearchOptions& options,
                         Tree* tree) {
    return Placer(body, solid, options, tree).run();
}

}  // namespace openfab::pieces
