// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/command/part_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "mechanics/messages.h"
#include "mechanics/part/across.h"

namespace openfab::mechanics {

namespace {

/// Without what a part of the whole as small as the residual leaves.
std::string point(Vec3 p) {
    const double size = std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])});
    for (double& v : p)
        if (std::abs(v) < 1e-5 * size) v = 0;
    return fmt::format("({:.4g}, {:.4g}, {:.4g})", p[0], p[1], p[2]);
}

void write_vector(const char* key, const Vec3& v, JsonText* out) {
    out->key(key).begin_array();
    for (const double one : v)
        out->value(one);
    out->end_array();
}

/// What is told apart.
constexpr double kMostAcross = double{kAcrossMost} / kAcrossStep;

const char* verdict_text(const PartSummary& s) {
    switch (verdict_of(s)) {
        case Verdict::kHolds:
            return s.buckling ? ": it holds\n"
                              : ": it holds unless it buckles, which was not looked at\n";
        case Verdict::kBuckles:
            return ": it buckles\n";
        case Verdict::kBreaks:
            return ": it breaks\n";
        case Verdict::kNotStrained:
            return ": nothing strains it\n";
        case Verdict::kCoarse:
            return messages::kUnresolvedCoarse;
        case Verdict::kCut:
            return messages::kUnresolvedCut;
        default:
            return messages::kUnresolvedThin;
    }
}

std::string buckling_text(const Buckling& b) {
    if (b.factor > 0)
        return fmt::format("buckles             at {:.4g} times the loads{}, {} at {} mm\n",
                           b.factor,
                           b.excess > 1 ? fmt::format(" or {:.3g}", b.factor / b.excess) : "",
                           point(b.moves), point(b.moves_at_mm));
    return fmt::format("buckles             above {:.3g} times the loads, if at all\n", b.at_least);
}

const std::string& material_of(const PartRun& r, const WeakPlace& w) {
    return r.problem.voxels.materials[static_cast<size_t>(std::max(1, w.material) - 1)];
}

/// Of a part that is mostly thinner than two elements, no pitch tells of the next.
constexpr double kThinShare = 0.2;

}  // namespace

bool settling(double fine, double coarse, std::optional<double> coarser) {
    const double size = std::abs(fine), change = fine - coarse;
    constexpr double kStill = 0.005, kLarge = 0.1, kShrinks = 0.5;
    if (std::abs(change) <= kStill * size) return true;
    if (!coarser) return std::abs(change) <= kLarge * size;
    const double before = coarse - *coarser;
    return change * before > 0 && std::abs(change) <= kShrinks * std::abs(before);
}

std::string describe(const PartRun& r, const LoadCase& load_case, const std::string& law) {
    const PartSummary& s = r.summary;
    const Grid& g = r.problem.grid;
    std::string out;
    for (const std::string& one : r.problem.notes)
        out += "note: " + one + "\n";
    out += fmt::format("case {}: forces {} N", load_case.name, point(r.problem.total_force_N));
    for (size_t h = 0; h < r.solution.reactions_N.size(); ++h)
        out += fmt::format("{} {}{}", h == 0 ? "; held by" : ",", point(r.solution.reactions_N[h]),
                           h + 1 == r.solution.reactions_N.size() ? " N" : "");
    out += fmt::format("\nmoved by at most    {:.4g} mm, {} at {}\n", s.most_moved_mm,
                       point(s.moved_there_mm), point(s.moved_at_mm));
    out += fmt::format(
        "von Mises stress    at most {:.4g} MPa; one element in a hundred has more than {:.4g}\n",
        s.most_von_mises_MPa, s.typical_MPa);
    if (s.least_safety > 0) {
        out += fmt::format("safety factor       at least {:.4g}", s.least_safety);
        if (s.least_safety_away > 0)
            out += fmt::format(", {:.4g} away from what is held and loaded", s.least_safety_away);
        out += verdict_text(s);
    } else {
        out += "safety factor       not known: the materials have no `strength_MPa`\n";
    }
    if (s.buckling) out += buckling_text(*s.buckling);
    out += fmt::format("weakest places, mm  {:>8} {:>8} {:>8} {:>8} {:>10} {:>10} {:>11} {:>7}\n",
                       "x", "y", "z", "safety", "von Mises", "tension", "compression", "across");
    for (const WeakPlace& w : s.weakest)
        out += fmt::format(
            "                    {:8.2f} {:8.2f} {:8.2f} {:>8} {:10.4g} {:10.4g} "
            "{:11.4g} {:>7}  {}{}\n",
            w.at_mm[0], w.at_mm[1], w.at_mm[2],
            w.safety > 0 ? fmt::format("{:.3g}", w.safety) : "-", w.von_mises_MPa, w.tension_MPa,
            w.compression_MPa,
            w.across < kMostAcross ? fmt::format("{:.2g}", w.across)
                                   : fmt::format("{:.0f}+", kMostAcross),
            material_of(r, w),
            w.at_hold   ? ", where it is held"
            : w.at_load ? ", where it is loaded"
                        : "");
    out += fmt::format(
        "pitch {:.4g} x {:.4g} x {:.4g} mm, {} solid elements of {} x {} x {}, {}, residual {:.1e} "
        "in {} iterations\n",
        g.pitch_mm[0], g.pitch_mm[1], g.pitch_mm[2], r.problem.elements.solid, g.elements[0],
        g.elements[1], g.elements[2], law, r.solution.report.residual,
        r.solution.report.iterations);
    return out;
}

void write_result(const PartRun& r, const LoadCase& load_case, JsonText* out) {
    const PartSummary& s = r.summary;
    out->member("case", load_case.name);
    write_vector("force_N", r.problem.total_force_N, out);
    out->key("reactions_N").begin_array();
    for (const Vec3& one : r.solution.reactions_N) {
        out->begin_array();
        for (const double v : one)
            out->value(v);
        out->end_array();
    }
    out->end_array();
    out->member("work_Nmm", r.solution.work_Nmm).member("most_moved_mm", s.most_moved_mm);
    write_vector("moved_mm", s.moved_there_mm, out);
    write_vector("moved_at_mm", s.moved_at_mm, out);
    out->member("most_von_mises_MPa", s.most_von_mises_MPa)
        .member("von_mises_of_one_in_100_MPa", s.typical_MPa);
    out->key("safety");
    if (s.least_safety > 0)
        out->value(s.least_safety);
    else
        out->null();
    out->key("safety_away_from_holds_and_loads");
    if (s.least_safety_away > 0)
        out->value(s.least_safety_away);
    else
        out->null();
    constexpr const char* kVerdicts[] = {"unknown",      "not strained", "not resolved",
                                         "not resolved", "not resolved", "breaks",
                                         "buckles",      "holds"};
    out->member("verdict", kVerdicts[static_cast<size_t>(verdict_of(s))]);
    out->key("buckling");
    if (s.buckling) {
        out->begin_object();
        if (s.buckling->factor > 0) {
            out->member("factor", s.buckling->factor)
                .member("factor_at_least", s.buckling->factor / s.buckling->excess);
            write_vector("moves_most_at_mm", s.buckling->moves_at_mm, out);
            write_vector("along", s.buckling->moves, out);
        } else {
            out->member("above", s.buckling->at_least);
        }
        out->end_object();
    } else {
        out->null();
    }
    out->key("weakest").begin_array();
    for (const WeakPlace& w : s.weakest) {
        out->begin_object();
        write_vector("at_mm", w.at_mm, out);
        if (w.safety > 0) out->member("safety", w.safety);
        out->member("von_mises_MPa", w.von_mises_MPa)
            .member("tension_MPa", w.tension_MPa)
            .member("compression_MPa", w.compression_MPa)
            .member("material", material_of(r, w))
            .member("elements_across", w.across)
            .member("at_hold", w.at_hold)
            .member("at_load", w.at_load);
        out->end_object();
    }
    out->end_array();
    write_vector("pitch_mm", r.problem.grid.pitch_mm, out);
    out->key("elements").begin_array();
    for (const int32_t n : r.problem.grid.elements)
        out->value(n);
    out->end_array();
    out->member("solid_elements", r.problem.elements.solid)
        .member("residual", r.solution.report.residual)
        .member("iterations", static_cast<int32_t>(r.solution.report.iterations));
    out->key("notes").begin_array();
    for (const std::string& one : r.problem.notes)
        out->value(one);
    out->end_array();
}

std::string describe_convergence(const PartRun& fine, const PartRun& coarse,
                                 const PartRun* coarser) {
    std::string unsettled;
    const bool thin = coarse.problem.thin_share > kThinShare;
    const auto line = [&](const char* what, const char* unit, const auto& of) {
        const double a = of(fine), b = of(coarse);
        const double change = a != 0 ? 100 * (a - b) / a : 0;
        const bool settles = settling(a, b, coarser ? std::optional(of(*coarser)) : std::nullopt);
        if (!settles) unsettled += fmt::format("{}{}", unsettled.empty() ? "" : ", ", what);
        return fmt::format("  {:<20}{:>12.4g} {:>12.4g} {:>12} {:<4} {:+8.2f} %\n", what, b, a,
                           settles && !thin ? fmt::format("{:.4g}", a + (a - b) / 3) : "-", unit,
                           change);
    };
    std::string out = fmt::format("{:<22}{:>12} {:>12} {:>12}\n", "at a pitch of",
                                  fmt::format("{:.4g} mm", coarse.problem.grid.pitch_mm[0]),
                                  fmt::format("{:.4g} mm", fine.problem.grid.pitch_mm[0]), "0");
    out += line("moved by", "mm", [](const PartRun& r) { return r.summary.most_moved_mm; });
    out += line("work", "Nmm", [](const PartRun& r) { return r.solution.work_Nmm; });
    out +=
        line("stress of 1 in 100", "MPa", [](const PartRun& r) { return r.summary.typical_MPa; });
    out += line("stress at most", "MPa",
                [](const PartRun& r) { return r.summary.most_von_mises_MPa; });
    out += "at 0 where errors fall with the square of the pitch\n";
    if (thin) out += messages::kThinConverge;
    if (!unsettled.empty()) out += fmt::format(messages::kNotSettled, unsettled);
    out += fmt::format("{} solid elements at half the pitch, residual {:.1e} in {} iterations\n",
                       fine.problem.elements.solid, fine.solution.report.residual,
                       fine.solution.report.iterations);
    return out;
}

}  // namespace openfab::mechanics
