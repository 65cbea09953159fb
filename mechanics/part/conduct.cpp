// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/part/conduct.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mechanics/messages.h"
#include "mechanics/solver/parallel.h"
#include "mechanics/solver/strain.h"

namespace openfab::mechanics {

namespace {

/// S/m, and W/(m K), of elements in mm.
constexpr double kPerMetre = 1e-3;
/// Less than such a share of the best conductor is taken for an insulator.
constexpr float kInsulates = 1e-7F;

double* at_node(const Grid& g, Field<double, kScalar>* field, int64_t node) {
    const int64_t row = node / g.nodes[0];
    return field->row(0, static_cast<int32_t>(row % g.nodes[1]),
                      static_cast<int32_t>(row / g.nodes[1])) +
           node % g.nodes[0];
}

/// Without the elements that conduct nothing, or nothing to speak of.
Result<void> leave_out_insulators(ConductProblem* p) {
    std::vector<float>& k = p->voxels.conductivity;
    float most = 0;
    for (size_t e = 0; e < k.size(); ++e) {
        if (p->elements.kind[e] == kNothing) k[e] = 0;
        most = std::max(most, k[e]);
    }
    if (!(most > 0)) return user_error(messages::kNothingConducts);
    int64_t insulators = 0;
    for (float& one : k)
        if (one > 0 && one < kInsulates * most) {
            one = 0;
            ++insulators;
        }
    if (insulators > 0)
        p->notes.push_back(
            fmt::format(messages::kTakenForInsulators,
                        100.0 * static_cast<double>(insulators) /
                            static_cast<double>(std::max<int64_t>(1, p->elements.solid)),
                        kInsulates));
    return {};
}

/// Elements that are less than half full belong to the piece that they touch. Those between two pieces carry nothing: they are
/// a gap that ends within elements, and would join what does not touch. What touches none is a wall that the elements do not
/// resolve, as `part` has it.
void cut_gaps(ConductProblem* p) {
    std::vector<float>& k = p->voxels.conductivity;
    std::vector<uint8_t> full(k.size());
    for (size_t e = 0; e < k.size(); ++e)
        full[e] = k[e] > 0 && p->elements.kind[e] == kSolid ? kSolid : kNothing;
    std::vector<int32_t> owner = pieces_of(p->grid, full).of;
    const auto for_neighbours = [&](int64_t e, const auto& with) {
        const std::array<int32_t, 3> at = place_of(p->grid, e);
        const std::array<int32_t, 3>& n = p->grid.elements;
        for (int32_t i = 0; i < 27; ++i) {
            const int32_t x = at[0] + i % 3 - 1, y = at[1] + i / 3 % 3 - 1, z = at[2] + i / 9 - 1;
            if (x >= 0 && y >= 0 && z >= 0 && x < n[0] && y < n[1] && z < n[2])
                with(p->grid.element(x, y, z));
        }
    };
    std::vector<int64_t> thin;
    std::vector<int32_t> touched;  // the piece that each of them touches
    int64_t gaps = 0, lost = 0;
    for (int64_t e = 0; e < p->grid.element_count(); ++e) {
        const auto at = static_cast<size_t>(e);
        if (!(k[at] > 0) || full[at] == kSolid) continue;
        int32_t piece = -1;
        bool several = false;
        for_neighbours(e, [&](size_t other) {
            if (full[other] != kSolid) return;
            several = several || (piece >= 0 && owner[other] != piece);
            piece = owner[other];
        });
        if (piece >= 0 && !several) {
            thin.push_back(e);
            touched.push_back(piece);
        } else {
            k[at] = 0;
            ++(several ? gaps : lost);
        }
    }
    for (size_t i = 0; i < thin.size(); ++i)
        owner[static_cast<size_t>(thin[i])] = touched[i];
    std::vector<size_t> meet;  // those next to one of another piece
    for (size_t i = 0; i < thin.size(); ++i) {
        bool other_piece = false;
        for_neighbours(thin[i], [&](size_t other) {
            other_piece =
                other_piece || (k[other] > 0 && owner[other] >= 0 && owner[other] != touched[i]);
        });
        if (other_piece) meet.push_back(static_cast<size_t>(thin[i]));
    }
    for (const size_t e : meet)
        k[e] = 0;
    gaps += static_cast<int64_t>(meet.size());
    if (gaps > 0) p->notes.push_back(fmt::format(messages::kGapsCarryNothing, gaps));
    if (lost > 0) p->notes.push_back(fmt::format(messages::kThinCarriesNothing, lost));
}

/// Of two levels at one node: whether the holds have a face in common, or only elements that touch.
Error holds_meet(const LoadCase& load_case, const FaceChooser& chooser, const ConductProblem& p,
                 const ConductProblem::Kept& one, const ConductProblem::Kept& other) {
    const auto faces_of = [&](const ConductProblem::Kept& k) {
        Result<std::vector<Face>> faces =
            chooser.choose(load_case.held[static_cast<size_t>(k.hold)].faces);
        return faces ? std::move(*faces) : std::vector<Face>();
    };
    const std::vector<Face> a = faces_of(one), b = faces_of(other);
    const bool common =
        std::ranges::any_of(a, [&](const Face& f) { return std::ranges::find(b, f) != b.end(); });
    const Grid& g = p.grid;
    const int64_t row = one.node / g.nodes[0];
    const int64_t at[3] = {one.node % g.nodes[0], row % g.nodes[1], row / g.nodes[1]};
    Vec3 place;
    for (size_t c = 0; c < 3; ++c)
        place[c] = p.voxels.origin_mm[c] + static_cast<double>(at[c]) * g.pitch_mm[c];
    Error error = user_error(
        common ? fmt::format(messages::kTwoHoldsOfFlow, load_case.name, one.level, other.level)
               : fmt::format(messages::kTwoHoldsTouch, load_case.name, one.level, other.level,
                             place[0], place[1], place[2]),
        messages::kFacesApart);
    error.location = load_case.held[static_cast<size_t>(other.hold)].faces.location;
    return error;
}

Result<void> keep(const LoadCase& load_case, const FaceChooser& chooser, ConductProblem* p) {
    for (size_t h = 0; h < load_case.held.size(); ++h) {
        const Holding& holding = load_case.held[h];
        const Result<std::vector<Face>> faces = chooser.choose(holding.faces);
        if (!faces) {
            Error error = faces.error();
            error.message = messages::kNothingHeldHere + error.message;
            return error;
        }
        bool conducts = false;
        for (const Face& f : *faces) {
            conducts = conducts || p->voxels.conductivity[static_cast<size_t>(f.element)] > 0;
            for (const int64_t node : nodes_of(p->grid, f))
                p->kept.push_back({node, *holding.level, static_cast<int32_t>(h)});
        }
        if (!conducts) {
            Error error = user_error(messages::kHeldInsulates, messages::kHeldInsulatesHelp);
            error.location = holding.faces.location;
            return error;
        }
    }
    std::ranges::stable_sort(p->kept, {}, &ConductProblem::Kept::node);
    for (size_t i = 1; i < p->kept.size(); ++i)
        if (p->kept[i].node == p->kept[i - 1].node && p->kept[i].level != p->kept[i - 1].level)
            return holds_meet(load_case, chooser, *p, p->kept[i - 1], p->kept[i]);
    const auto same = [](const ConductProblem::Kept& one, const ConductProblem::Kept& other) {
        return one.node == other.node;
    };
    p->kept.erase(std::unique(p->kept.begin(), p->kept.end(), same), p->kept.end());
    return {};
}

/// Flows into faces, by their area; each has to find a way to what is kept at a level.
Result<void> feed(const LoadCase& load_case, const FaceChooser& chooser, const Pieces& pieces,
                  std::span<const uint8_t> reached, ConductProblem* p) {
    const auto piece_of = [&](const Face& f) { return pieces.of[static_cast<size_t>(f.element)]; };
    for (const Load& load : load_case.loads) {
        Result<std::vector<Face>> faces = chooser.choose(load.faces);
        if (!faces) {
            Error error = faces.error();
            error.message = messages::kFlowEntersNothing + error.message;
            return error;
        }
        std::erase_if(*faces, [&](const Face& f) { return piece_of(f) < 0; });
        bool lost = faces->empty();
        for (const Face& f : *faces)
            lost = lost || reached[static_cast<size_t>(piece_of(f))] == 0;
        if (lost) {
            Error error =
                user_error(faces->empty() ? messages::kEntersInsulator : messages::kFlowNotJoined,
                           messages::kFlowNotJoinedHelp);
            error.location = load.faces.location;
            return error;
        }
        const std::vector<LoadedFace> loaded =
            loaded_faces(p->grid, p->voxels, p->elements.kind, *faces);
        double area = 0, free = 0;
        for (const LoadedFace& f : loaded) {
            area += f.area;
            for (const int64_t node : nodes_of(p->grid, f.face))
                if (!std::ranges::binary_search(p->kept, node, {}, &ConductProblem::Kept::node))
                    free += f.area / 4;
        }
        constexpr double kNone = 1e-9, kHalf = 0.5;
        if (free < kNone * area)
            p->notes.push_back(fmt::format(messages::kLoadOnHeld, load.faces.text));
        else if (free < kHalf * area)
            p->notes.push_back(
                fmt::format(messages::kLoadPartlyOnHeld, 100 * (1 - free / area), load.faces.text));
        for (const auto& [f, own] : loaded)
            for (const int64_t node : nodes_of(p->grid, f))
                *at_node(p->grid, &p->inflow, node) += *load.inflow * own / area / 4;
    }
    return {};
}

/// What a piece is kept at.
struct PieceLevels {
    bool reached = false, differ = false;
    double level = 0;
    std::vector<int32_t> holds;  ///< of the case, that keep it
};

/// A piece is kept where it has a node that is.
std::vector<PieceLevels> levels_of(const ConductProblem& p, const Pieces& pieces) {
    std::vector<PieceLevels> out(pieces.all.size());
    for (int64_t e = 0; e < p.grid.element_count(); ++e) {
        const int32_t piece = pieces.of[static_cast<size_t>(e)];
        if (piece < 0) continue;
        PieceLevels& one = out[static_cast<size_t>(piece)];
        for (const uint8_t d : {uint8_t{4}, uint8_t{5}})
            for (const int64_t node : nodes_of(p.grid, {e, d})) {
                const auto at =
                    std::ranges::lower_bound(p.kept, node, {}, &ConductProblem::Kept::node);
                if (at == p.kept.end() || at->node != node) continue;
                one.differ = one.differ || (one.reached && one.level != at->level);
                one.reached = true;
                one.level = at->level;
                if (std::ranges::find(one.holds, at->hold) == one.holds.end())
                    one.holds.push_back(at->hold);
            }
    }
    return out;
}

/// Something has to flow; a hold at which nothing can, and what carries nothing, is told.
Result<void> check_paths(const LoadCase& load_case, const FaceChooser& chooser,
                         const Pieces& pieces, const std::vector<PieceLevels>& levels,
                         ConductProblem* p) {
    std::vector<uint8_t> carries(levels.size()), flows(load_case.held.size());
    for (size_t i = 0; i < levels.size(); ++i)
        carries[i] = levels[i].differ ? 1 : 0;
    for (const Load& load : load_case.loads)
        if (const Result<std::vector<Face>> faces = chooser.choose(load.faces); faces)
            for (const Face& f : *faces)
                if (const int32_t piece = pieces.of[static_cast<size_t>(f.element)]; piece >= 0)
                    carries[static_cast<size_t>(piece)] = 1;
    int64_t idle = 0;
    for (size_t i = 0; i < levels.size(); ++i) {
        if (levels[i].reached && !carries[i]) idle += pieces.all[i].elements;
        for (const int32_t h : levels[i].holds)
            flows[static_cast<size_t>(h)] |= carries[i];
    }
    if (std::ranges::find(carries, 1) == carries.end()) {
        Error error =
            user_error(fmt::format(messages::kNoPath, load_case.name), messages::kNoPathHelp);
        error.location = load_case.location;
        return error;
    }
    for (size_t h = 0; h < flows.size(); ++h)
        if (!flows[h])
            p->notes.push_back(fmt::format(messages::kHoldApart, load_case.held[h].faces.text));
    if (idle > 0) p->notes.push_back(fmt::format(messages::kCarriesNothing, idle));
    return {};
}

}  // namespace

Result<ConductProblem> set_up_conduct(Voxels voxels, const LoadCase& load_case,
                                      std::span<const ObjectVoxels> objects) {
    ConductProblem p;
    p.voxels = std::move(voxels);
    p.grid = Grid::make(p.voxels.size, p.voxels.pitch_mm, false);
    p.elements = classify(p.grid, &p.voxels);
    if (p.elements.solid == 0) return user_error(messages::kNoneHalfFull, messages::kFinerVoxel);
    if (Result<void> done = leave_out_insulators(&p); !done) return done.error();
    cut_gaps(&p);
    std::vector<uint8_t> conducts(p.voxels.conductivity.size());
    for (size_t e = 0; e < conducts.size(); ++e)
        conducts[e] = p.voxels.conductivity[e] > 0 ? kSolid : kNothing;
    const Pieces pieces = pieces_of(p.grid, conducts);
    const std::vector<Face> surface = surface_of(p.grid, p.elements.kind);
    const FaceChooser chooser(p.grid, p.voxels.origin_mm, surface, objects);
    if (Result<void> done = keep(load_case, chooser, &p); !done) return done.error();
    std::vector<PieceLevels> levels = levels_of(p, pieces);
    std::vector<uint8_t> reached(pieces.all.size());
    for (size_t i = 0; i < reached.size(); ++i)
        reached[i] = levels[i].reached ? 1 : 0;
    p.inflow = Field<double, kScalar>(p.grid);
    if (Result<void> done = feed(load_case, chooser, pieces, reached, &p); !done)
        return done.error();
    if (Result<void> done = check_paths(load_case, chooser, pieces, levels, &p); !done)
        return done.error();
    int64_t alone = 0;
    // What nothing reaches has no level, so that it is left out.
    for (size_t e = 0; e < pieces.of.size(); ++e)
        if (pieces.of[e] >= 0 && reached[static_cast<size_t>(pieces.of[e])] == 0) {
            p.voxels.conductivity[e] = 0;
            ++alone;
        }
    if (alone > 0) p.notes.push_back(fmt::format(messages::kConductorsLeftOut, alone));
    return p;
}

int64_t conduct_bytes(const Grid& grid) {
    const int64_t field = int64_t{grid.nodes[0] + 2} * grid.nodes[1] * grid.nodes[2] * 8;
    return solver_bytes<kScalar>(grid) + 2 * field +
           grid.element_count() * (Voxels::bytes_per_voxel() + 1 + 4 + 4);
}

ConductSolution solve_conduct(ConductProblem* problem, size_t holds, const SolveOptions& options) {
    ConductProblem& p = *problem;
    const Grid& g = p.grid;
    ConductSolution out;
    ElementValues values{p.voxels.conductivity, {}, 1};
    values.normalise();
    const double unit = values.unit * kPerMetre;
    FixedNodes fixed, none;
    for (const ConductProblem::Kept& one : p.kept)
        fixed.push_back(one.node);
    out.level = Field<double, kScalar>(g);
    const ElementOperator<kScalar> whole(g, &values, &none), inner(g, &values, &fixed);
    Field<double, kScalar> b(g);
    const auto set_kept = [&](bool to_level) {
        for (const ConductProblem::Kept& one : p.kept)
            *at_node(g, &out.level, one.node) = to_level ? one.level : 0;
    };
    set_kept(true);
    whole.apply(&out.level, &b);
    set_kept(false);
    for_rows<kScalar>(g, [&](int c, int32_t y, int32_t z, int32_t n) {
        double* to = b.row(c, y, z);
        const double* f = p.inflow.row(c, y, z);
        for (int32_t i = 0; i < n; ++i)
            to[i] = f[i] / unit - to[i];
    });
    {
        Multigrid<kScalar> multigrid(inner, options.multigrid);
        out.report = solve(inner, &multigrid, &b, &out.level, options);
    }
    set_kept(true);
    whole.apply(&out.level, &b);
    out.flow_in.resize(holds);
    for (const ConductProblem::Kept& one : p.kept)
        out.flow_in[static_cast<size_t>(one.hold)] +=
            unit * *at_node(g, &b, one.node) - *at_node(g, &p.inflow, one.node);
    out.power_W = unit * dot(out.level, b);
    for_each_index(g.nodes[2], [&](int32_t z) { out.level.fill_ghosts(z); });
    out.density.resize(static_cast<size_t>(g.element_count()));
    for_each_index(g.elements[2], [&](int32_t z) {
        for (int32_t y = 0; y < g.elements[1]; ++y)
            for (int32_t x = 0; x < g.elements[0]; ++x) {
                const size_t e = g.element(x, y, z);
                if (p.elements.kind[e] != kSolid || !(p.voxels.conductivity[e] > 0)) continue;
                const auto d = centre_gradient(out.level, g, x, y, z)[0];
                out.density[e] = static_cast<float>(
                    kPerMetre * static_cast<double>(p.voxels.conductivity[e]) /
                    static_cast<double>(p.voxels.solid[e]) * std::hypot(d[0], d[1], d[2]));
            }
    });
    return out;
}

}  // namespace openfab::mechanics
