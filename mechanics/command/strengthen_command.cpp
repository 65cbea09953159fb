// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "backends/common/output_file.h"
#include "base/own_folder.h"
#include "base/say.h"
#include "mechanics/command/commands.h"
#include "mechanics/command/part_source.h"
#include "mechanics/correct/need_field.h"
#include "mechanics/messages.h"
#include "mechanics/model/field_world.h"

namespace openfab::mechanics {

namespace {

namespace fs = std::filesystem;

/// A world, solved.
struct Round {
    PartProblem problem;
    PartFields fields;
    PartSummary summary;
    SolveReport report;
    double material_mm3 = 0;

    double safety() const {
        return summary.least_safety_away > 0 ? summary.least_safety_away : summary.least_safety;
    }
};

Result<Round> solve_round(const StrengthenOptions& o, const PartSource& source,
                          const LoadCase& load_case, const Vec3& voxel_mm, bool first) {
    Result<PartInput> input = source.read(voxel_mm, load_case, [](const Grid& g) {
        constexpr int64_t kField = 12;
        return part_bytes(g) + kField * g.element_count();
    });
    if (!input) return input.error();
    for (const Material& m : input->materials)
        if (!m.strength_MPa && m.used)
            return user_error(
                fmt::format(messages::kNoMaterialStrength, source.properties().file, m.name),
                messages::kNoMaterialStrengthHelp);
    if (Result<void> done = source.check_gravity(*input, load_case); !done) return done.error();
    Result<PartProblem> problem = set_up_part(std::move(input->voxels), load_case, input->objects,
                                              {o.loose, o.thin, o.common.codes});
    if (!problem) return problem.error();
    Round out;
    out.problem = std::move(*problem);
    if (first) {
        for (const std::vector<std::string>* all : {&input->doubts, &out.problem.notes})
            for (const std::string& one : *all)
                note(one);
    }
    SolveProgress progress(o.common.quiet, 1, o.common.tolerance);
    PartSolution solution =
        solve_part(&out.problem, load_case.held.size(), solve_options(o.common, &progress));
    if (Result<void> done = check_solved(solution.report, o.common); !done) return done.error();
    out.report = solution.report;
    out.fields = fields_of(out.problem, &solution.moved_mm);
    out.summary = summary_of(out.problem, out.fields, solution.moved_mm, 1);
    const Vec3& h = out.problem.grid.pitch_mm;
    out.material_mm3 = out.problem.elements.volume * h[0] * h[1] * h[2];
    return out;
}

}  // namespace

Result<void> run_strengthen(const StrengthenOptions& o) {
    const fs::path output = o.output;
    std::string stem = output.filename().string();
    if (!stem.ends_with(".fab.json")) return usage_error(messages::kResultIsWorld);
    stem.resize(stem.size() - std::string_view(".fab.json").size());
    std::error_code ignored;
    if (fs::equivalent(output, o.common.input, ignored))
        return usage_error(messages::kWouldOverwrite);
    const fs::path folder = output.parent_path().empty() ? fs::path(".") : output.parent_path();
    const fs::path field_file = output.parent_path() / (stem + "." + o.field + ".npy");
    const Result<FieldWorld> world = FieldWorld::open(o.common.input, o.field, folder);
    if (!world) return world.error();
    const Result<LoadCase> load_case = read_load_case(o.common.input, o.load_case);
    if (!load_case) return load_case.error();
    if (Result<void> done = check_kind(*load_case, false); !done) return done;
    Result<std::unique_ptr<TemporaryFolder>> temporary = TemporaryFolder::create();
    if (!temporary) return temporary.error();
    const fs::path scratch = (*temporary)->path();

    CommonOptions common = o.common;
    common.allow.push_back(scratch.string());
    Result<PartSource> source = PartSource::open(common, scratch);
    if (!source) return source.error();
    const Result<Vec3> voxel = source->pitch_mm();
    if (!voxel) return voxel.error();
    Result<Round> round = solve_round(o, *source, *load_case, *voxel, true);
    if (!round) return round.error();
    NeedField field{round->problem.grid, round->problem.voxels.origin_mm, {}};
    field.value.resize(round->problem.voxels.solid.size());
    NeedRule rule;
    rule.safety = o.safety;
    rule.limit = o.limit;
    rule.reach_mm = o.reach_mm > 0 ? o.reach_mm : 4 * *std::ranges::max_element(*voxel);
    const double begun = round->material_mm3;
    show("  round    safety  weak elements  material mm3\n");
    std::string reason;
    int number = 0;
    for (;; ++number) {
        const double safety = round->safety();
        NeedField grown = field;
        const NeedStep step = grow(round->problem, round->fields, rule, &grown);
        show(fmt::format("{:7} {:9.4g} {:14} {:13.6g}\n", number, safety, step.weak,
                         round->material_mm3));
        if (safety >= o.safety) break;
        const Vec3& at = round->summary.weakest.front().at_mm;
        if (step.most_grown < 1e-3 * o.limit)
            reason = fmt::format(messages::kFieldEverywhere, o.limit);
        else if (number == o.rounds)
            reason = fmt::format(messages::kAfterRounds, o.rounds);
        if (!reason.empty()) {
            reason = fmt::format(messages::kFactorNotReached, o.safety, reason, safety, at[0],
                                 at[1], at[2]);
            break;
        }
        field = std::move(grown);
        const fs::path file = scratch / "field.npy";
        if (Result<void> done = write_field(file, field); !done) return done;
        FieldTexture texture{o.field, file, field.origin_mm, field.grid.pitch_mm};
        for (size_t a = 0; a < 3; ++a)
            texture.origin_mm[a] -= world->moved_mm()[a];
        source->set_field(std::move(texture));
        round = solve_round(o, *source, *load_case, *voxel, false);
        if (!round) return round.error();
        if (round->problem.grid.elements != field.grid.elements)
            return user_error(messages::kBoxChanged, messages::kBoxChangedHelp);
    }
    if (Result<void> done = write_field(field_file, field); !done) return done;
    const Result<std::string> strong =
        world->text(field_file, field.origin_mm, field.grid.pitch_mm);
    if (!strong) return strong.error();
    if (Result<void> done = backends::write_whole_file(output, *strong); !done) return done;
    const Grid& g = round->problem.grid;
    show(fmt::format(
        "pitch {:.4g} x {:.4g} x {:.4g} mm, {} solid elements of {} x {} x {}, {}, residual "
        "{:.1e} in {} iterations\n",
        g.pitch_mm[0], g.pitch_mm[1], g.pitch_mm[2], round->problem.elements.solid, g.elements[0],
        g.elements[1], g.elements[2], source->law(), round->report.residual,
        round->report.iterations));
    show(fmt::format("{}: {:+.2f} % material, the field in {}\n", output.string(),
                     100 * (round->material_mm3 / begun - 1), field_file.string()));
    if (world->names_others()) {
        const std::string stay = fs::absolute(o.common.input).parent_path().string();
        note(fmt::format(messages::kNamesOthers, output.string(), stay, stay));
    }
    if (!reason.empty()) return user_error(reason, messages::kFactorNotReachedHelp);
    return {};
}

}  // namespace openfab::mechanics
