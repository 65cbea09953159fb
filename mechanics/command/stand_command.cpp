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
#include "mechanics/part/part_picture.h"
#include "mechanics/part/volume_files.h"
#include "mechanics/stand/contact.h"
#include "mechanics/stand/modes.h"
#include "mechanics/stand/thickness.h"

namespace openfab::mechanics {

namespace {

namespace fs = std::filesystem;

/// All that is found.
struct StandResult {
    PartProblem problem;
    Stand stand;
    std::vector<ThinPlace> thin;
    bool weighs = false;  ///< all densities are known
    PartSolution solution;
    PartFields fields;
    PartSummary weight;  ///< under its own
    Modes modes;
};

std::string stand_point(const Vec3& p) {
    return fmt::format("({:.4g}, {:.4g}, {:.4g})", p[0], p[1], p[2]);
}

std::string direction(const std::array<double, 2>& d) {
    return fmt::format("({:.2f}, {:.2f})", d[0], d[1]);
}

const std::string& material_named(const PartProblem& p, int material) {
    return p.voxels.materials[static_cast<size_t>(std::max(1, material) - 1)];
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
    out +=
        s.margin_deg > 0
            ? fmt::format("it stands           and may be tilted by {:.1f} degrees, towards {}\n",
                          s.margin_deg, direction(s.falls_towards))
            : fmt::format(
                  "it falls            towards {}: its centre of mass is {:.1f} degrees "
                  "outside of what it stands on\n",
                  direction(s.falls_towards), -s.margin_deg);
    out += "thinnest, mm              x        y        z  thickness\n";
    for (const ThinPlace& t : r.thin)
        out += fmt::format("                    {:8.2f} {:8.2f} {:8.2f} {:10.3g}  {}\n", t.at_mm[0],
                           t.at_mm[1], t.at_mm[2], t.thickness_mm,
                           material_named(r.problem, t.material));
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
    out.member("stands", s.margin_deg > 0);
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
    out.end_array();
    if (r.weighs) {
        out.key("own_weight").begin_object();
        out.member("most_moved_mm", r.weight.most_moved_mm)
            .member("most_von_mises_MPa", r.weight.most_von_mises_MPa);
        if (r.weight.least_safety > 0) out.member("safety", r.weight.least_safety);
        out.member("residual", r.solution.report.residual).end_object();
    }
    out.key("modes").begin_array();
    for (const Mode& m : r.modes.all) {
        out.begin_object().member("frequency_Hz", m.frequency_Hz).member("residual", m.residual);
        write_vector_of("moves_most_at_mm", m.moved_at_mm, &out);
        write_vector_of("along", m.moved, &out);
        write_vector_of("strained_at_mm", m.strained_at_mm, &out);
        out.member("material", material_named(r.problem, m.material)).end_object();
    }
    out.end_array();
    write_vector_of("pitch_mm", r.problem.grid.pitch_mm, &out);
    out.end_object();
    return out.take() + "\n";
}

Result<void> solve_weight(const StandOptions& o, size_t holds, StandResult* r) {
    SolveOptions options;
    options.tolerance = o.common.tolerance;
    options.most_iterations = o.common.most_iterations;
    SolveProgress progress(o.common.quiet, 1, o.common.tolerance);
    options.progress = [&](int iteration, double residual) {
        return progress.update(0, iteration, residual);
    };
    r->solution = solve_part(&r->problem, holds, options);
    if (r->solution.report.stopped) return interrupted_error();
    if (!r->solution.report.converged)
        return not_converged_error(r->solution.report.residual, o.common.tolerance,
                                   r->solution.report.iterations);
    r->fields = fields_of(r->problem, &r->solution.moved_mm);
    r->weight = summary_of(r->problem, r->fields, r->solution.moved_mm, 1);
    return {};
}

}  // namespace

Result<void> run_stand(const StandOptions& o) {
    for (const std::string& file : o.outputs)
        if (const std::string type = fs::path(file).extension().string();
            type != ".json" && type != ".vti")
            return usage_error(fmt::format("`-o {}`: results are .json or .vti", file));
    Result<std::unique_ptr<TemporaryFolder>> folder = TemporaryFolder::create();
    if (!folder) return folder.error();
    const Result<PartSource> source = PartSource::open(o.common, (*folder)->path());
    if (!source) return source.error();
    const Result<double> voxel = source->pitch_mm();
    if (!voxel) return voxel.error();
    const auto modes = static_cast<size_t>(o.modes);
    Result<PartInput> input = source->read(*voxel, std::vector<std::string>(), [&](const Grid& g) {
        return modes > 0 ? modes_bytes(g, modes) : part_bytes(g);
    });
    if (!input) return input.error();
    StandResult r;
    r.weighs = std::ranges::all_of(input->materials,
                                   [](const Material& m) { return m.density_g_cm3.has_value(); });
    LoadCase weight;
    weight.name = "own weight";
    weight.held.emplace_back();
    constexpr int kBelow = 4;
    weight.held[0].faces.side = kBelow;
    weight.held[0].faces.text = " below";
    if (r.weighs) weight.gravity_m_s2 = Vec3{0, 0, -9.81};
    Result<PartProblem> problem =
        set_up_part(std::move(input->voxels), weight, {}, {o.loose, o.thin});
    if (!problem) return problem.error();
    r.problem = std::move(*problem);
    r.stand = stand_of(r.problem.grid, r.problem.voxels, r.problem.elements, r.weighs);
    constexpr size_t kPlaces = 6;
    r.thin = thinnest(r.problem.grid, r.problem.voxels, r.problem.elements.kind, kPlaces);
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
    }
    show(describe_stand(r));
    for (const std::string& name : o.outputs) {
        const fs::path file = name;
        const Result<void> done =
            file.extension() == ".json"
                ? backends::write_whole_file(file, json_of(r))
                : write_vti(file, r.problem, r.fields, r.solution.moved_mm, r.modes.weakness);
        if (!done) return done;
    }
    if (o.preview.empty()) return {};
    if (r.modes.weakness.empty()) return usage_error("`--preview` shows modes, and there are none");
    PartFields shown = std::move(r.fields);
    shown.von_mises_MPa = r.modes.weakness;
    PictureOptions picture;
    picture.title = "weakness";
    return backends::write_whole_file(fs::path(o.preview),
                                      part_picture(r.problem, shown, r.solution.moved_mm, picture));
}

}  // namespace openfab::mechanics
