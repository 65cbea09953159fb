// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "backends/common/output_file.h"
#include "base/json_text.h"
#include "base/own_folder.h"
#include "base/say.h"
#include "mechanics/command/commands.h"
#include "mechanics/command/part_source.h"
#include "mechanics/messages.h"
#include "mechanics/part/part_picture.h"
#include "mechanics/part/shown.h"
#include "mechanics/part/volume_files.h"
#include "mechanics/stand/contact.h"
#include "mechanics/stand/growing.h"
#include "mechanics/stand/modes.h"
#include "mechanics/stand/push.h"
#include "mechanics/stand/thickness.h"

namespace openfab::mechanics {

namespace {

namespace fs = std::filesystem;

/// While it is printed, up to a height.
struct GrowingResult {
    double height_mm = 0, margin_deg = 0, moved_mm = 0, von_mises_MPa = 0, safety = 0, residual = 0;
    int64_t loose = 0;  ///< elements that nothing but support carries yet
};

/// All that is found.
struct StandResult {
    PartProblem problem;
    Stand stand;
    std::vector<ThinPlace> thin;
    std::vector<ThinPlace> thin_of;  ///< of each material alone, where there are several
    std::vector<AirPlace> in_the_air;
    std::vector<GrowingResult> growing;
    std::vector<Push> pushes;  ///< of each mode
    bool weighs = false;       ///< all densities are known
    PartSolution solution;
    PartFields fields;
    PartSummary weight;  ///< under its own
    Modes modes;
};

/// Without what rounding leaves of a 0.
std::string stand_point(Vec3 p) {
    const double size = std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])});
    for (double& v : p)
        if (std::abs(v) < 1e-9 * size) v = 0;
    return fmt::format("({:.4g}, {:.4g}, {:.4g})", p[0], p[1], p[2]);
}

std::string direction(const std::array<double, 2>& d) {
    return fmt::format("({:.2f}, {:.2f})", d[0], d[1]);
}

const std::string& material_named(const PartProblem& p, int material) {
    return p.voxels.materials[static_cast<size_t>(std::max(1, material) - 1)];
}

std::string describe_growing(const StandResult& r) {
    std::string out;
    constexpr size_t kMost = 4;
    if (r.in_the_air.empty()) {
        out += "while printing      no layer begins in the air\n";
    } else {
        out +=
            fmt::format("while printing      {} place{} in the air, which support has to carry\n",
                        r.in_the_air.size(), r.in_the_air.size() == 1 ? " begins" : "s begin");
        out += "begins in the air, mm     x        y        z   area mm2\n";
    }
    for (size_t i = 0; i < std::min(kMost, r.in_the_air.size()); ++i) {
        const AirPlace& a = r.in_the_air[i];
        out += fmt::format("                    {:8.2f} {:8.2f} {:8.2f} {:10.3g}\n", a.at_mm[0],
                           a.at_mm[1], a.at_mm[2], a.area_mm2);
    }
    if (r.growing.empty()) return out;
    out += "up to, mm      may tilt by   moved by mm   von Mises      safety   still loose\n";
    for (const GrowingResult& one : r.growing)
        out += fmt::format("    {:10.2f} {:12.1f}  {:12.3g} {:11.3g} {:>11} {:11.3g} %\n",
                           one.height_mm, one.margin_deg, one.moved_mm, one.von_mises_MPa,
                           one.safety > 0 ? fmt::format("{:.4g}", one.safety) : "-",
                           100 * static_cast<double>(one.loose) /
                               static_cast<double>(std::max<int64_t>(1, r.problem.elements.solid)));
    return out;
}

std::string describe_pushes(const StandResult& r) {
    if (r.pushes.empty()) return {};
    std::string out =
        "worst pushes        at, mm                   along                MPa of 1 N  breaks by\n";
    for (size_t i = 0; i < r.pushes.size(); ++i) {
        const Push& push = r.pushes[i];
        out += fmt::format("         {:8.4g}   {:<24} ({:5.2f}, {:5.2f}, {:5.2f}) {:11.3g}  {}\n",
                           r.modes.all[i].frequency_Hz, stand_point(push.at_mm), push.along[0],
                           push.along[1], push.along[2], push.MPa_of_N,
                           push.breaks_at_N > 0 ? fmt::format("{:.4g} N", push.breaks_at_N) : "-");
    }
    return out;
}

std::string describe_foot(const Stand& s) {
    const Foot& f = s.foot;
    switch (f.kind) {
        case Foot::Kind::kStands:
            return fmt::format(
                "it stands           and may be tilted by {:.1f} degrees, towards {}\n",
                s.margin_deg, direction(f.towards));
        case Foot::Kind::kRocks:
            return fmt::format("it rocks, and stands on a round side with a radius of {:.4g} mm\n",
                               f.round_mm);
        case Foot::Kind::kRolls:
            return fmt::format(
                "it rolls or tips    towards {}: its foot is an edge, a tip or round, with "
                "a radius of {:.2g} mm\n",
                direction(f.towards), f.round_mm);
        case Foot::Kind::kFalls:
            return fmt::format(
                "it falls            towards {}: its centre of mass is {:.1f} degrees "
                "outside of what it stands on\n",
                direction(f.towards), -s.margin_deg);
        default:
            return fmt::format(
                "not resolved        whether it stands: its centre of mass is within {:.2g} "
                "mm of the edge of its foot, towards {}\n",
                f.error_mm, direction(f.towards));
    }
}

std::string describe_stand(const StandResult& r) {
    const Stand& s = r.stand;
    std::string out;
    for (const std::string& one : r.problem.notes)
        out += "note: " + one + "\n";
    out += r.weighs
               ? fmt::format("mass                {:.4g} g, {:.4g} mm3\n", s.mass_g, s.volume_mm3)
               : fmt::format(
                     "volume              {:.4g} mm3; the materials have no "
                     "`density_g_cm3`, so all weigh alike here\n",
                     s.volume_mm3);
    out += fmt::format("centre of mass      {} mm, {:.4g} mm above the ground\n",
                       stand_point(s.centre_mm), s.centre_mm[2] - s.floor_mm);
    out += fmt::format("contact             {:.4g} mm2, a hull of {} corners\n", s.contact_mm2,
                       s.hull_mm.size());
    out += describe_foot(s);
    out += "thinnest, mm              x        y        z  thickness\n";
    for (const ThinPlace& t : r.thin)
        out += fmt::format("                    {:8.2f} {:8.2f} {:8.2f} {:10.3g}  {}\n", t.at_mm[0],
                           t.at_mm[1], t.at_mm[2], t.thickness_mm,
                           material_named(r.problem, t.material));
    if (!r.thin_of.empty()) out += "thinnest of a material alone\n";
    for (const ThinPlace& t : r.thin_of)
        out += fmt::format("                    {:8.2f} {:8.2f} {:8.2f} {:10.3g}  {}\n", t.at_mm[0],
                           t.at_mm[1], t.at_mm[2], t.thickness_mm,
                           material_named(r.problem, t.material));
    out += describe_growing(r);
    if (r.weighs) {
        out += fmt::format("own weight          moves it by {:.3g} mm; von Mises {:.3g} MPa",
                           r.weight.most_moved_mm, r.weight.most_von_mises_MPa);
        out += r.weight.least_safety > 0
                   ? fmt::format(", safety factor {:.4g}\n", r.weight.least_safety)
                   : "\n";
    }
    if (!r.modes.all.empty()) {
        out +=
            "softest modes           Hz   moves most at, mm        along               breaks "
            "first at, mm\n";
        for (const Mode& m : r.modes.all)
            out += fmt::format(
                "                  {:8.4g}   {:<24} ({:5.2f}, {:5.2f}, {:5.2f})  {} {}\n",
                m.frequency_Hz, stand_point(m.moved_at_mm), m.moved[0], m.moved[1], m.moved[2],
                stand_point(m.strained_at_mm), material_named(r.problem, m.material));
        out += describe_pushes(r);
        if (!r.modes.converged)
            out += "note: the last of these modes are not to a thousandth yet\n";
    }
    const Grid& g = r.problem.grid;
    out += fmt::format("pitch {:.4g} x {:.4g} x {:.4g} mm, {} solid elements of {} x {} x {}",
                       g.pitch_mm[0], g.pitch_mm[1], g.pitch_mm[2], r.problem.elements.solid,
                       g.elements[0], g.elements[1], g.elements[2]);
    if (r.weighs)
        out += fmt::format(", residual {:.1e} in {} iterations", r.solution.report.residual,
                           r.solution.report.iterations);
    return out + "\n";
}

void write_vector_of(const char* key, const Vec3& v, JsonText* out) {
    out->key(key).begin_array();
    for (const double one : v)
        out->value(one);
    out->end_array();
}

std::string json_of(const StandResult& r) {
    const Stand& s = r.stand;
    JsonText out;
    out.begin_object();
    if (r.weighs) out.member("mass_g", s.mass_g);
    out.member("volume_mm3", s.volume_mm3);
    write_vector_of("centre_mm", s.centre_mm, &out);
    out.member("contact_mm2", s.contact_mm2).member("margin_deg", s.margin_deg);
    out.member("stands", s.stands())
        .member("resolved", s.foot.kind != Foot::Kind::kNotResolved)
        .member("round_mm", s.foot.round_mm);
    out.key("hull_mm").begin_array();
    for (const std::array<double, 2>& p : s.hull_mm)
        out.begin_array().value(p[0]).value(p[1]).end_array();
    out.end_array().key("thinnest").begin_array();
    for (const ThinPlace& t : r.thin) {
        out.begin_object();
        write_vector_of("at_mm", t.at_mm, &out);
        out.member("thickness_mm", t.thickness_mm)
            .member("material", material_named(r.problem, t.material))
            .end_object();
    }
    out.end_array().key("thinnest_of_a_material").begin_array();
    for (const ThinPlace& t : r.thin_of) {
        out.begin_object();
        write_vector_of("at_mm", t.at_mm, &out);
        out.member("thickness_mm", t.thickness_mm)
            .member("material", material_named(r.problem, t.material))
            .end_object();
    }
    out.end_array().key("begins_in_the_air").begin_array();
    for (const AirPlace& a : r.in_the_air) {
        out.begin_object();
        write_vector_of("at_mm", a.at_mm, &out);
        out.member("area_mm2", a.area_mm2).end_object();
    }
    out.end_array().key("while_printing").begin_array();
    for (const GrowingResult& one : r.growing) {
        out.begin_object()
            .member("height_mm", one.height_mm)
            .member("margin_deg", one.margin_deg)
            .member("most_moved_mm", one.moved_mm)
            .member("most_von_mises_MPa", one.von_mises_MPa)
            .member("loose_elements", one.loose)
            .member("residual", one.residual);
        if (one.safety > 0) out.member("safety", one.safety);
        out.end_object();
    }
    out.end_array();
    if (r.weighs) {
        out.key("own_weight").begin_object();
        out.member("most_moved_mm", r.weight.most_moved_mm)
            .member("most_von_mises_MPa", r.weight.most_von_mises_MPa);
        if (r.weight.least_safety > 0) out.member("safety", r.weight.least_safety);
        out.member("residual", r.solution.report.residual).end_object();
    }
    out.key("modes").begin_array();
    for (size_t i = 0; i < r.modes.all.size(); ++i) {
        const Mode& m = r.modes.all[i];
        out.begin_object().member("frequency_Hz", m.frequency_Hz).member("residual", m.residual);
        write_vector_of("moves_most_at_mm", m.moved_at_mm, &out);
        write_vector_of("along", m.moved, &out);
        write_vector_of("strained_at_mm", m.strained_at_mm, &out);
        out.member("material", material_named(r.problem, m.material));
        if (i < r.pushes.size()) {
            const Push& push = r.pushes[i];
            out.key("worst_push").begin_object();
            write_vector_of("at_mm", push.at_mm, &out);
            write_vector_of("along", push.along, &out);
            out.member("MPa_of_N", push.MPa_of_N);
            if (push.breaks_at_N > 0) out.member("breaks_at_N", push.breaks_at_N);
            out.end_object();
        }
        out.end_object();
    }
    out.end_array();
    write_vector_of("pitch_mm", r.problem.grid.pitch_mm, &out);
    out.end_object();
    return out.take() + "\n";
}

LoadCase weight_case(bool weighs) {
    LoadCase weight;
    weight.name = "own weight";
    weight.held.emplace_back();
    constexpr int kBelow = 4;
    weight.held[0].faces.side = kBelow;
    weight.held[0].faces.text = " below";
    if (weighs) weight.gravity_m_s2 = Vec3{0, 0, -9.81};
    return weight;
}

/// What is printed up to some heights, under its own weight.
Result<void> grow_up(const StandOptions& o, StandResult* r) {
    const Grid& g = r->problem.grid;
    const LoadCase weight = weight_case(r->weighs);
    for (int k = 1; k <= o.while_printing; ++k) {
        const int32_t layers =
            std::max(1, static_cast<int32_t>(int64_t{g.elements[2]} * k / o.while_printing));
        // All of it is what was solved.
        Voxels some = lowest_layers(r->problem.voxels, layers);
        const Grid lower = Grid::make(some.size, some.pitch_mm, false);
        PartElements elements = classify(lower, &some);
        if (elements.solid == 0) continue;
        GrowingResult one;
        one.height_mm = layers * g.pitch_mm[2];
        Result<PartProblem> problem =
            set_up_part(std::move(some), weight, {}, {true, true, o.common.codes});
        if (!problem) return problem.error();
        one.loose = elements.solid - problem->elements.solid;
        one.margin_deg =
            stand_of(problem->grid, problem->voxels, problem->elements, r->weighs).margin_deg;
        if (r->weighs) {
            SolveProgress progress(o.common.quiet, 1, o.common.tolerance);
            const PartSolution solution =
                solve_part(&*problem, weight.held.size(), solve_options(o.common, &progress));
            if (Result<void> done = check_solved(solution.report, o.common); !done)
                return done.error();
            Field<double, kElastic> moved = solution.moved_mm;
            const PartFields fields = fields_of(*problem, &moved);
            const PartSummary s = summary_of(*problem, fields, moved, 1);
            one.moved_mm = s.most_moved_mm;
            one.von_mises_MPa = s.most_von_mises_MPa;
            one.safety = s.least_safety;
            one.residual = solution.report.residual;
        }
        r->growing.push_back(one);
    }
    return {};
}

Result<void> find_pushes(const StandOptions& o, StandResult* r) {
    for (const Mode& mode : r->modes.all) {
        SolveProgress progress(o.common.quiet, 1, o.common.tolerance);
        const Push push = worst_push(&r->problem, mode, solve_options(o.common, &progress));
        if (push.stopped) return interrupted_error();
        if (!push.converged) return not_converged_error(1, o.common.tolerance, 0);
        r->pushes.push_back(push);
    }
    return {};
}

/// The thinnest wall or neck of each material.
std::vector<ThinPlace> thinnest_of_each(const PartProblem& p) {
    std::vector<ThinPlace> out;
    for (size_t k = 1; k <= p.voxels.materials.size(); ++k) {
        std::vector<uint8_t> kind = p.elements.kind;
        for (size_t e = 0; e < kind.size(); ++e)
            if (p.voxels.code[e] != k) kind[e] = kNothing;
        const std::vector<ThinPlace> thin = thinnest(p.grid, p.voxels, kind, 1);
        out.insert(out.end(), thin.begin(), thin.end());
    }
    return out;
}

Result<void> solve_weight(const StandOptions& o, size_t holds, StandResult* r) {
    SolveProgress progress(o.common.quiet, 1, o.common.tolerance);
    r->solution = solve_part(&r->problem, holds, solve_options(o.common, &progress));
    if (Result<void> done = check_solved(r->solution.report, o.common); !done) return done.error();
    r->fields = fields_of(r->problem, &r->solution.moved_mm);
    r->weight = summary_of(r->problem, r->fields, r->solution.moved_mm, 1);
    return {};
}

Result<void> check_stands(const Stand& s) {
    const std::array<double, 2>& to = s.foot.towards;
    if (s.stands()) return {};
    if (s.foot.kind == Foot::Kind::kNotResolved)
        return user_error(fmt::format(messages::kStandNotResolved, s.foot.error_mm),
                          messages::kStandNotResolvedHelp);
    return user_error(
        s.foot.kind == Foot::Kind::kRolls
            ? fmt::format(messages::kRolls, s.foot.round_mm,
                          (s.pieces > 1 ? s.of_piece_mm : s.centre_mm)[2] - s.floor_mm, to[0],
                          to[1])
            : fmt::format(messages::kFalls, to[0], to[1]));
}

}  // namespace

Result<void> run_stand(const StandOptions& o) {
    for (const std::string& file : o.outputs)
        if (const std::string type = fs::path(file).extension().string();
            type != ".json" && type != ".vti" && type != ".ofr")
            return usage_error(fmt::format(messages::kStandResultKinds, file));
    Result<std::unique_ptr<TemporaryFolder>> folder = TemporaryFolder::create();
    if (!folder) return folder.error();
    const Result<PartSource> source = PartSource::open(o.common, (*folder)->path());
    if (!source) return source.error();
    const Result<Vec3> voxel = source->pitch_mm();
    if (!voxel) return voxel.error();
    const auto modes = static_cast<size_t>(o.modes);
    Result<PartInput> input = source->read(*voxel, std::vector<std::string>(), [&](const Grid& g) {
        return modes > 0 ? modes_bytes(g, modes) : part_bytes(g);
    });
    if (!input) return input.error();
    StandResult r;
    r.weighs = std::ranges::all_of(input->materials,
                                   [](const Material& m) { return m.density_g_cm3 || !m.used; });
    const LoadCase weight = weight_case(r.weighs);
    Result<PartProblem> problem =
        set_up_part(std::move(input->voxels), weight, {}, {o.loose, o.thin, o.common.codes});
    if (!problem) return problem.error();
    r.problem = std::move(*problem);
    r.problem.notes.insert(r.problem.notes.begin(), input->doubts.begin(), input->doubts.end());
    r.stand = stand_of(r.problem.grid, r.problem.voxels, r.problem.elements, r.weighs);
    const Result<FootLayers> foot = source->read_foot(
        r.problem.grid.pitch_mm, r.stand.floor_mm - r.problem.voxels.origin_mm[2]);
    if (!foot) return foot.error();
    r.stand.look_at_pieces(r.problem.grid, r.problem.voxels, r.problem.elements, r.weighs, *foot);
    if (r.stand.pieces > 1)
        r.problem.notes.push_back(fmt::format(messages::kPiecesStandAlone, r.stand.pieces,
                                              stand_point(r.stand.of_piece_mm)));
    constexpr size_t kPlaces = 6;
    r.thin = thinnest(r.problem.grid, r.problem.voxels, r.problem.elements.kind, kPlaces);
    // As dithered each voxel is alone.
    if (input->materials.size() > 1 && !o.common.codes) r.thin_of = thinnest_of_each(r.problem);
    r.in_the_air =
        begins_in_the_air(r.problem.grid, r.problem.voxels.origin_mm, r.problem.elements.kind);
    if (Result<void> done = grow_up(o, &r); !done) return done;
    r.solution.moved_mm = Field<double, kElastic>(r.problem.grid);
    if (r.weighs)
        if (Result<void> done = solve_weight(o, weight.held.size(), &r); !done) return done;
    if (!r.weighs) r.fields = fields_of(r.problem, &r.solution.moved_mm);
    if (modes > 0) {
        if (!r.weighs)
            // Shapes of modes need masses, if not their unit.
            r.problem.voxels.density = r.problem.voxels.solid;
        ModeOptions options;
        options.count = modes;
        options.solve.most_iterations = o.common.most_iterations;
        SolveProgress progress(o.common.quiet, options.most_sweeps, 1e-3);
        options.progress = [&](int sweep, double residual) {
            return progress.update(sweep - 1, sweep, residual);
        };
        r.modes = softest_modes(&r.problem, options);
        if (r.modes.stopped) return interrupted_error();
        if (Result<void> done = find_pushes(o, &r); !done) return done;
    }
    show(describe_stand(r));
    PartFields weak = r.fields;
    if (!r.modes.weakness.empty()) weak.von_mises_MPa = r.modes.weakness;
    for (const std::string& name : o.outputs) {
        const fs::path file = name;
        const std::string type = file.extension().string();
        if (type == ".ofr" && r.modes.weakness.empty())
            return usage_error(messages::kOfrShowsModes);
        Result<void> done;
        if (type == ".json") {
            done = backends::write_whole_file(file, json_of(r));
        } else if (type == ".vti") {
            done = write_vti(file, r.problem, r.fields, r.solution.moved_mm, r.modes.weakness);
        } else {
            Shown shown = shown_of(r.problem, weak, r.solution.moved_mm, "von-mises");
            shown.name = "weakness";
            shown.unit = "";
            done = write_bands(file, r.problem.grid, r.problem.voxels.origin_mm,
                               r.problem.elements.kind, shown);
        }
        if (!done) return done;
    }
    if (!o.preview.empty()) {
        if (r.modes.weakness.empty()) return usage_error(messages::kPreviewShowsModes);
        PictureOptions picture;
        picture.title = "weakness";
        if (Result<void> done = backends::write_whole_file(
                fs::path(o.preview), part_picture(r.problem, weak, r.solution.moved_mm, picture));
            !done)
            return done;
    }
    return check_stands(r.stand);
}

}  // namespace openfab::mechanics
