// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/part/part_problem.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "mechanics/messages.h"
#include "mechanics/part/across.h"
#include "mechanics/part/loads.h"
#include "mechanics/solver/parallel.h"

namespace openfab::mechanics {

namespace {

/// With a text before it, its place in the file kept.
Error before(Error error, const char* text) {
    error.message = text + error.message;
    return error;
}

class SetUp {
  public:
    SetUp(PartProblem* problem, const LoadCase& load_case, std::span<const ObjectVoxels> objects,
          const PartOptions& options)
        : p_(*problem), case_(load_case), objects_(objects), options_(options) {}

    Result<void> run();

  private:
    Vec3 middle_of(size_t element) const;
    void note_gaps();
    Result<void> check_walls();
    void note_tip(std::span<const Face> faces, const std::string& choice);
    Result<void> hold(const FaceChooser& chooser);
    Result<void> sort_held();
    Result<void> leave_out_loose();
    Result<void> check_motions() const;
    Result<void> load();
    std::string box_of(const Piece& piece) const;

    PartProblem& p_;
    const LoadCase& case_;
    std::span<const ObjectVoxels> objects_;
    const PartOptions& options_;
    std::vector<Face> surface_;
    Pieces pieces_;
    std::vector<uint8_t> piece_held_;
    /// Dofs that are held, with the piece and the hold: of the whole case.
    struct Entry {
        Held held;
        int32_t hold, piece;
    };
    std::vector<Entry> entries_;
};

std::string SetUp::box_of(const Piece& piece) const {
    Vec3 low, high;
    for (size_t a = 0; a < 3; ++a) {
        low[a] = p_.voxels.origin_mm[a] + p_.grid.pitch_mm[a] * piece.low[a];
        high[a] = p_.voxels.origin_mm[a] + p_.grid.pitch_mm[a] * (piece.high[a] + 1);
    }
    return fmt::format(messages::kPieceFromTo, piece.elements, low[0], low[1], low[2], high[0],
                       high[1], high[2]);
}

Vec3 SetUp::middle_of(size_t element) const {
    const std::array<int32_t, 3> at = place_of(p_.grid, static_cast<int64_t>(element));
    Vec3 place;
    for (size_t a = 0; a < 3; ++a)
        place[a] = p_.voxels.origin_mm[a] + (at[a] + 0.5) * p_.grid.pitch_mm[a];
    return place;
}

void SetUp::note_gaps() {
    const BlurredGaps gaps = blurred_gaps(p_.grid, p_.voxels);
    if (gaps.elements == 0) return;
    const Vec3 place = middle_of(gaps.first);
    p_.notes.push_back(fmt::format(messages::kGapsJoined, gaps.elements,
                                   *std::ranges::max_element(p_.grid.pitch_mm), place[0], place[1],
                                   place[2]));
}

Result<void> SetUp::check_walls() {
    if (p_.elements.solid == 0)
        return user_error(messages::kNoneHalfFullBefore +
                              fmt::format(messages::kThinWalls, 100.0,
                                          *std::ranges::max_element(p_.grid.pitch_mm)),
                          messages::kThinWallsHelp);
    if (!options_.dithered) note_gaps();
    p_.across = elements_across(p_.grid, p_.voxels, p_.elements.kind, options_.dithered);
    // Below one and a half, stiffness is as rough as stress.
    constexpr int kRough = 3 * kAcrossStep / 2 + 2;
    double thin = 0, rough = 0, all = 0;
    size_t thinnest = 0;
    for (size_t e = 0; e < p_.across.size(); ++e) {
        if (p_.elements.kind[e] != kSolid) continue;
        const double share = static_cast<double>(p_.voxels.solid[e]);
        all += share;
        thin += p_.across[e] < kUnresolved ? share : 0;
        rough += p_.across[e] < kRough ? share : 0;
        if (p_.across[thinnest] == 0 || p_.across[e] < p_.across[thinnest]) thinnest = e;
    }
    p_.thin_share = thin / all;
    constexpr double kTooMuch = 0.2, kTold = 0.002;
    if (!(thin > kTold * all)) return {};
    const Vec3 place = middle_of(thinnest);
    const std::string what =
        fmt::format(messages::kThinWalls, 100 * thin / all,
                    *std::ranges::max_element(p_.grid.pitch_mm)) +
        fmt::format(messages::kThinnestAt, static_cast<double>(p_.across[thinnest]) / kAcrossStep,
                    place[0], place[1], place[2]);
    if (rough > kTooMuch * all && !options_.thin) return user_error(what, messages::kThinWallsHelp);
    p_.notes.push_back(what + messages::kRoughStiffness);
    return {};
}

void SetUp::note_tip(std::span<const Face> faces, const std::string& choice) {
    double area = 1;
    for (size_t a = 0; a < 3; ++a)
        area *= a == faces[0].direction / 2 ? 1 : p_.grid.pitch_mm[a];
    p_.notes.push_back(
        fmt::format(messages::kHeldByTip, choice, area * static_cast<double>(faces.size())));
}

Result<void> SetUp::hold(const FaceChooser& chooser) {
    piece_held_.assign(pieces_.all.size(), 0);
    for (size_t h = 0; h < case_.held.size(); ++h) {
        const Holding& holding = case_.held[h];
        const Result<std::vector<Face>> faces = chooser.choose(holding.faces);
        if (!faces) return before(faces.error(), messages::kNothingHeldHere);
        if (std::ranges::count(holding.along, true) == 3 && is_tip(p_.grid, surface_, *faces))
            note_tip(*faces, holding.faces.text);
        for (const Face& f : *faces) {
            const int32_t piece = pieces_.of[static_cast<size_t>(f.element)];
            piece_held_[static_cast<size_t>(piece)] = 1;
            for (const int64_t node : nodes_of(p_.grid, f))
                for (size_t c = 0; c < 3; ++c)
                    if (holding.along[c])
                        entries_.push_back(
                            {{node * 3 + static_cast<int64_t>(c), holding.move_mm[c]},
                             static_cast<int32_t>(h),
                             piece});
        }
    }
    return {};
}

Result<void> SetUp::leave_out_loose() {
    constexpr double kSmall = 0.01;
    std::vector<uint8_t> out(pieces_.all.size());
    int64_t dropped = 0, number = 0;
    const Piece* largest = nullptr;
    for (size_t i = 0; i < pieces_.all.size(); ++i) {
        const Piece& piece = pieces_.all[i];
        if (piece_held_[i]) continue;
        const double share =
            static_cast<double>(piece.elements) / static_cast<double>(p_.elements.solid);
        if (share > kSmall && !options_.loose)
            return user_error(
                fmt::format(messages::kPieceNotHeld, pieces_.all.size(), box_of(piece)),
                messages::kPieceNotHeldHelp);
        out[i] = 1;
        dropped += piece.elements;
        ++number;
        if (!largest) largest = &piece;
    }
    if (number == 0) return {};
    p_.notes.push_back(
        fmt::format(messages::kPiecesLeftOut,
                    number == 1 ? messages::kAPiece : fmt::format(messages::kPiecesCount, number),
                    number == 1 ? "is" : "are",
                    100 * static_cast<double>(dropped) / static_cast<double>(p_.elements.solid),
                    box_of(*largest)));
    for (size_t e = 0; e < pieces_.of.size(); ++e)
        if (pieces_.of[e] >= 0 && out[static_cast<size_t>(pieces_.of[e])])
            p_.voxels.solid[e] = p_.voxels.lambda[e] = p_.voxels.mu[e] = 0;
    p_.elements = classify(p_.grid, &p_.voxels);
    return {};
}

Result<void> SetUp::check_motions() const {
    for (size_t i = 0; i < pieces_.all.size(); ++i) {
        if (!piece_held_[i]) continue;
        std::vector<Held> held;
        for (const Entry& e : entries_)
            if (e.piece == static_cast<int32_t>(i)) held.push_back(e.held);
        const std::string motion = free_motion(p_.grid, p_.voxels.origin_mm, held);
        if (motion.empty()) continue;
        Error error = user_error(
            fmt::format(
                messages::kCaseLetsMove, case_.name, motion,
                pieces_.all.size() > 1 ? messages::kThatIsPiece + box_of(pieces_.all[i]) : ""),
            messages::kHoldMoreFaces);
        error.location = case_.location;
        return error;
    }
    return {};
}

Result<void> SetUp::sort_held() {
    std::ranges::stable_sort(entries_, {}, [](const Entry& e) { return e.held.dof; });
    for (const Entry& e : entries_) {
        if (!p_.held.empty() && p_.held.back().dof == e.held.dof) {
            if (p_.held.back().move_mm == e.held.move_mm) continue;
            Error error =
                user_error(fmt::format(messages::kTwoHolds, case_.name, p_.held.back().move_mm,
                                       e.held.move_mm, "xyz"[e.held.dof % 3]),
                           messages::kFacesApart);
            error.location = case_.held[static_cast<size_t>(e.hold)].faces.location;
            return error;
        }
        p_.held.push_back(e.held);
        p_.hold.push_back(e.hold);
    }
    return {};
}

Result<void> SetUp::load() {
    const FaceChooser chooser(p_.grid, p_.voxels.origin_mm, surface_, objects_);
    LoadAssembler assembler(p_.grid, &p_.forces_N, p_.held);
    double stiffest = 0;
    for (size_t e = 0; e < p_.elements.kind.size(); ++e)
        if (p_.elements.kind[e] == kSolid)
            stiffest = std::max(stiffest, static_cast<double>(p_.voxels.mu[e]));
    for (const Load& one : case_.loads) {
        const Result<std::vector<Face>> faces = chooser.choose(one.faces);
        if (!faces) return before(faces.error(), messages::kLoadOnNothing);
        const std::vector<LoadedFace> loaded =
            loaded_faces(p_.grid, p_.voxels, p_.elements.kind, *faces);
        if (Result<void> done = assembler.add(one, loaded); !done) {
            Error error = done.error();
            error.location = one.faces.location;
            return error;
        }
        constexpr double kNone = 1e-9, kHalf = 0.5;
        if (assembler.free_share() < kNone)
            p_.notes.push_back(fmt::format(messages::kLoadOnHeld, one.faces.text));
        else if (assembler.free_share() < kHalf)
            p_.notes.push_back(fmt::format(messages::kLoadPartlyOnHeld,
                                           100 * (1 - assembler.free_share()), one.faces.text));
        if (assembler.most_MPa() > stiffest)
            p_.notes.push_back(
                fmt::format(messages::kLoadAboveStiffness, one.faces.text, assembler.most_MPa()));
    }
    // 9.81 m/s2 in mm/s2.
    if (case_.gravity_m_s2) {
        const Vec3& a = *case_.gravity_m_s2;
        const double size = std::hypot(a[0], a[1], a[2]);
        if (size > 9700 && size < 9900)
            p_.notes.push_back(fmt::format(messages::kGravityIsMm, size));
    }
    p_.load_nodes = assembler.nodes();
    if (case_.gravity_m_s2) assembler.add_gravity(*case_.gravity_m_s2, p_.voxels);
    p_.total_force_N = assembler.total();
    return {};
}

Result<void> SetUp::run() {
    p_.grid = Grid::make(p_.voxels.size, p_.voxels.pitch_mm, false);
    p_.elements = classify(p_.grid, &p_.voxels);
    if (!(p_.elements.volume > 0)) return user_error(messages::kPrintVoid);
    if (Result<void> done = check_walls(); !done) return done;
    pieces_ = pieces_of(p_.grid, p_.elements.kind);
    surface_ = surface_of(p_.grid, p_.elements.kind);
    {
        const FaceChooser chooser(p_.grid, p_.voxels.origin_mm, surface_, objects_);
        if (Result<void> done = hold(chooser); !done) return done;
    }
    if (Result<void> done = leave_out_loose(); !done) return done;
    if (Result<void> done = check_motions(); !done) return done;
    if (Result<void> done = sort_held(); !done) return done;
    pieces_ = {};
    surface_ = surface_of(p_.grid, p_.elements.kind);
    p_.forces_N = Field<double, kElastic>(p_.grid);
    return load();
}

template <typename F>
void for_held(const Grid& g, std::span<const Held> held, const F& f) {
    for (size_t i = 0; i < held.size(); ++i) {
        const int64_t node = held[i].dof / 3, row = node / g.nodes[0];
        f(i, static_cast<int>(held[i].dof % 3), static_cast<int32_t>(node % g.nodes[0]),
          static_cast<int32_t>(row % g.nodes[1]), static_cast<int32_t>(row / g.nodes[1]));
    }
}

}  // namespace

Result<PartProblem> set_up_part(Voxels voxels, const LoadCase& load_case,
                                std::span<const ObjectVoxels> objects, const PartOptions& options) {
    PartProblem out;
    out.voxels = std::move(voxels);
    if (Result<void> done = SetUp(&out, load_case, objects, options).run(); !done)
        return done.error();
    return out;
}

int64_t part_bytes(const Grid& grid) {
    // The forces are the right side, and two fields are added: what is moved, and its forces.
    const int64_t field = int64_t{grid.nodes[0] + 2} * grid.nodes[1] * grid.nodes[2] * kElastic * 8;
    return solver_bytes<kElastic>(grid) + field +
           grid.element_count() * (Voxels::bytes_per_voxel() + 1 + 4);
}

PartSolution solve_part(PartProblem* problem, size_t holds, const SolveOptions& options,
                        bool full) {
    PartProblem& p = *problem;
    const Grid& g = p.grid;
    PartSolution out;
    ElementValues values{std::move(p.voxels.lambda), std::move(p.voxels.mu), 1, full};
    values.normalise();
    FixedNodes fixed, none;
    for (const Held& h : p.held)
        fixed.push_back(h.dof);
    out.moved_mm = Field<double, kElastic>(g);
    {
        const ElementOperator<kElastic> whole(g, &values, &none), inner(g, &values, &fixed);
        Field<double, kElastic> b(g);
        const bool moves =
            std::ranges::any_of(p.held, [](const Held& h) { return h.move_mm != 0; });
        if (moves) {
            for_held(g, p.held, [&](size_t i, int c, int32_t x, int32_t y, int32_t z) {
                out.moved_mm.row(c, y, z)[x] = p.held[i].move_mm;
            });
            whole.apply(&out.moved_mm, &b);
            for_held(g, p.held, [&](size_t, int c, int32_t x, int32_t y, int32_t z) {
                out.moved_mm.row(c, y, z)[x] = 0;
            });
        }
        for_rows<kElastic>(g, [&](int c, int32_t y, int32_t z, int32_t n) {
            double* to = b.row(c, y, z);
            const double* f = p.forces_N.row(c, y, z);
            for (int32_t i = 0; i < n; ++i)
                to[i] = f[i] / values.unit - to[i];
        });
        Multigrid<kElastic> multigrid(inner, options.multigrid);
        out.report = solve(inner, &multigrid, &b, &out.moved_mm, options);
        for_held(g, p.held, [&](size_t i, int c, int32_t x, int32_t y, int32_t z) {
            out.moved_mm.row(c, y, z)[x] = p.held[i].move_mm;
        });
        whole.apply(&out.moved_mm, &b);
        out.work_Nmm = 0.5 * values.unit * dot(out.moved_mm, b);
        out.reactions_N.resize(holds);
        for_held(g, p.held, [&](size_t i, int c, int32_t x, int32_t y, int32_t z) {
            out.reactions_N[static_cast<size_t>(p.hold[i])][static_cast<size_t>(c)] +=
                values.unit * b.row(c, y, z)[x] - p.forces_N.row(c, y, z)[x];
        });
    }
    values.restore();
    p.voxels.lambda = std::move(values.first);
    p.voxels.mu = std::move(values.second);
    return out;
}

}  // namespace openfab::mechanics
