// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "backends/common/output_file.h"
#include "base/input_file.h"
#include "base/own_folder.h"
#include "base/say.h"
#include "mechanics/command/commands.h"
#include "mechanics/command/part_report.h"
#include "mechanics/command/part_source.h"
#include "mechanics/messages.h"
#include "mechanics/part/part_picture.h"
#include "mechanics/part/shown.h"
#include "mechanics/part/volume_files.h"

namespace openfab::mechanics {

namespace {

namespace fs = std::filesystem;

/// At the pitch, or at half of it.
Result<PartRun> run_at(const PartCommandOptions& o, const PartSource& source,
                       const LoadCase& load_case, double voxel_mm, bool half) {
    Result<PartInput> input = half ? source.read_halved(voxel_mm, load_case, part_bytes)
                                   : source.read(voxel_mm, load_case, part_bytes);
    if (!input) return input.error();
    if (Result<void> done = source.check_gravity(*input, load_case); !done) return done.error();
    Result<PartProblem> problem =
        set_up_part(std::move(input->voxels), load_case, input->objects, {o.loose, o.thin || half});
    if (!problem) return problem.error();
    PartRun out;
    out.problem = std::move(*problem);
    SolveProgress progress(o.common.quiet, 1, o.common.tolerance);
    out.solution =
        solve_part(&out.problem, load_case.held.size(), solve_options(o.common, &progress), o.full);
    if (Result<void> done = check_solved(out.solution.report, o.common); !done) return done.error();
    out.fields = fields_of(out.problem, &out.solution.moved_mm);
    constexpr size_t kPlaces = 8;
    out.summary = summary_of(out.problem, out.fields, out.solution.moved_mm, kPlaces);
    return out;
}

Result<PictureOptions> picture_options(const PartCommandOptions& o) {
    PictureOptions out;
    out.show = o.show;
    if (o.view.empty()) return out;
    const char* end = o.view.data() + o.view.size();
    const auto [a, bad] = std::from_chars(o.view.data(), end, out.turn_deg);
    if (bad == std::errc() && a != end && *a == ':') {
        const auto [b, worse] = std::from_chars(a + 1, end, out.tilt_deg);
        if (worse == std::errc() && b == end) return out;
    }
    return usage_error(fmt::format(messages::kViewWrong, o.view));
}

constexpr const char* kResults[] = {".vti", ".npy", ".json", ".ofr"};

Result<void> check_outputs(const PartCommandOptions& o) {
    for (const std::string& file : o.outputs)
        if (std::ranges::find(kResults, fs::path(file).extension().string()) == std::end(kResults))
            return usage_error(fmt::format(messages::kResultKinds, file));
    return {};
}

Result<void> write_outputs(const PartCommandOptions& o, const PartRun& run,
                           const LoadCase& load_case, const PictureOptions& picture) {
    for (const std::string& name : o.outputs) {
        const fs::path file = name;
        const std::string type = file.extension().string();
        Result<void> done;
        if (type == ".vti") {
            done = write_vti(file, run.problem, run.fields, run.solution.moved_mm);
        } else if (type == ".npy") {
            done = write_npy(file, run.problem, run.fields, run.solution.moved_mm);
        } else if (type == ".ofr") {
            done = write_bands(file, run.problem.grid, run.problem.voxels.origin_mm,
                               run.problem.elements.kind,
                               shown_of(run.problem, run.fields, run.solution.moved_mm, o.show));
        } else {
            JsonText json;
            json.begin_object();
            write_result(run, load_case, &json);
            json.end_object();
            done = backends::write_whole_file(file, json.take() + "\n");
        }
        if (!done) return done;
    }
    if (o.preview.empty()) return {};
    return backends::write_whole_file(
        fs::path(o.preview), part_picture(run.problem, run.fields, run.solution.moved_mm, picture));
}

}  // namespace

Result<void> run_part(const PartCommandOptions& o) {
    if (Result<void> done = check_outputs(o); !done) return done;
    const Result<PictureOptions> picture = picture_options(o);
    if (!picture) return picture.error();
    const Result<LoadCase> load_case = read_load_case(o.common.input, o.load_case);
    if (!load_case) return load_case.error();
    if (Result<void> done = check_kind(*load_case, false); !done) return done;
    Result<std::unique_ptr<TemporaryFolder>> folder = TemporaryFolder::create();
    if (!folder) return folder.error();
    Result<PartSource> source = PartSource::open(o.common, (*folder)->path());
    if (!source) return source.error();
    const Result<double> voxel = source->pitch_mm();
    if (!voxel) return voxel.error();
    Result<PartRun> run = run_at(o, *source, *load_case, *voxel, false);
    if (!run) return run.error();
    show(describe(*run, *load_case, source->law()));
    if (Result<void> done = write_outputs(o, *run, *load_case, *picture); !done) return done;
    if (o.converge) {
        // The finer one needs the memory of what has been written.
        run->problem.voxels = {};
        run->problem.elements = {};
        run->problem.forces_N = run->solution.moved_mm = Field<double, kElastic>();
        run->fields = {};
        const Result<PartRun> fine = run_at(o, *source, *load_case, *voxel, true);
        if (!fine) return with_context(fine.error(), messages::kConvergeBefore);
        show(describe_convergence(*fine, *run));
    }
    const double safety = run->summary.least_safety;
    if (o.require > 0 && !(safety >= o.require))
        return user_error(safety > 0 ? fmt::format(messages::kFactorTooSmall, safety, o.require)
                                     : messages::kNoStrength);
    return {};
}

}  // namespace openfab::mechanics
