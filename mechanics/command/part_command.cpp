// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "backends/common/output_file.h"
#include "base/input_file.h"
#include "base/own_folder.h"
#include "base/say.h"
#include "base/units.h"
#include "mechanics/command/commands.h"
#include "mechanics/command/part_report.h"
#include "mechanics/command/part_source.h"
#include "mechanics/messages.h"
#include "mechanics/part/across.h"
#include "mechanics/part/part_picture.h"
#include "mechanics/part/shown.h"
#include "mechanics/part/volume_files.h"

namespace openfab::mechanics {

namespace {

namespace fs = std::filesystem;

/// Says where the weakest place is resolved, but not well.
void note_coarse(PartRun* r) {
    if (r->summary.weakest.empty()) return;
    const double across = r->summary.weakest.front().across;
    if (across * kAcrossStep < kUnresolved || across * kAcrossStep >= kCoarse) return;
    const double pitch = *std::ranges::min_element(r->problem.grid.pitch_mm);
    r->problem.notes.push_back(
        fmt::format(messages::kCoarseThere, across,
                    coarse_excess(static_cast<uint8_t>(std::lround(across * kAcrossStep))),
                    pitch * across / 4));
}

/// Says where displacements are too large for a linear theory: against the part's least side, as those of a
/// plate that is held at its edges, or as turns of a tenth.
void note_large(PartRun* r) {
    const Grid& g = r->problem.grid;
    constexpr double kFar = std::numeric_limits<double>::infinity();
    Vec3 low{kFar, kFar, kFar}, high{-kFar, -kFar, -kFar};
    std::array<int32_t, 3> first{INT32_MAX, INT32_MAX, INT32_MAX}, last{};
    for (int64_t e = 0; e < g.element_count(); ++e) {
        if (r->problem.elements.kind[static_cast<size_t>(e)] != kSolid) continue;
        const std::array<int32_t, 3> p = place_of(g, e);
        for (size_t a = 0; a < 3; ++a) {
            first[a] = std::min(first[a], p[a]);
            last[a] = std::max(last[a], p[a] + 1);
        }
        for (const uint8_t d : {uint8_t{4}, uint8_t{5}})
            for (const int64_t node : nodes_of(g, {e, d})) {
                const Vec3 u = moved_at(r->solution.moved_mm, node);
                for (size_t a = 0; a < 3; ++a) {
                    low[a] = std::min(low[a], u[a]);
                    high[a] = std::max(high[a], u[a]);
                }
            }
    }
    double moved = 0, longest = 0, least = kFar;
    for (size_t a = 0; a < 3; ++a) {
        const double side = (last[a] - first[a]) * g.pitch_mm[a];
        moved = std::max(moved, high[a] - low[a]);
        longest = std::max(longest, side);
        least = std::min(least, side);
    }
    constexpr double kTurn = 0.1;
    if (moved > std::min(least, kTurn * longest))
        r->problem.notes.push_back(fmt::format(messages::kMovedFar, moved, least, longest));
}

/// How far it is from buckling: computed where it is slender enough, or always.
Result<void> look_at_buckling(const PartCommandOptions& o, PartRun* r) {
    if (o.buckling == "never" || !(r->summary.most_von_mises_MPa > 0)) return {};
    const bool always = o.buckling == "always";
    size_t where = 0;
    const double about =
        least_buckling_factor(r->problem, r->fields, &r->solution.moved_mm, o.common.codes, &where);
    constexpr double kClear = 4, kFar = 1000;
    if (!always && about > kClear * std::max(1.0, o.require)) {
        r->summary.buckling = Buckling();
        r->summary.buckling->at_least = about;
        return {};
    }
    const Grid& g = r->problem.grid;
    const int64_t needed = buckling_bytes(g);
    if (always) {
        if (Result<void> fits = check_memory(needed, o.common.memory_bytes, g.elements); !fits)
            return fits;
    } else if (needed > o.common.memory_bytes) {
        r->problem.notes.push_back(
            fmt::format(messages::kBucklingTooLarge, about, format_bytes(needed)));
        return {};
    }
    SolveProgress progress(o.common.quiet, 1, kBucklingTolerance);
    // Of a slender part a search takes some hundred iterations; of one that is hard to solve it ends some times later
    // than its solution.
    constexpr int kMostWork = 300, kTimes = 6;
    const int most_work = std::max(kMostWork, kTimes * r->solution.report.iterations);
    Buckling found = buckling_of(&r->problem, &r->solution.moved_mm, kFar,
                                 solve_options(o.common, &progress), always ? INT_MAX : most_work);
    if (found.stopped) return interrupted_error();
    if (found.given_up) {
        r->problem.notes.push_back(fmt::format(messages::kBucklingGivenUp, about));
        return {};
    }
    if (!found.converged) r->problem.notes.emplace_back(messages::kBucklingRough);
    if (!o.common.codes)
        found.excess =
            cut_excess(r->problem.grid, r->problem.voxels, r->problem.elements.kind, where);
    r->summary.buckling = found;
    return {};
}

enum class Pitch { kOwn, kHalf, kDouble };

/// At the pitch, at half of it, or at twice.
Result<PartRun> run_at(const PartCommandOptions& o, const PartSource& source,
                       const LoadCase& load_case, const Vec3& voxel_mm, Pitch step) {
    const double times = step == Pitch::kDouble ? 2 : 1;
    const Vec3 pitch{times * voxel_mm[0], times * voxel_mm[1], times * voxel_mm[2]};
    Result<PartInput> input = step == Pitch::kHalf
                                  ? source.read_halved(voxel_mm, load_case, part_bytes)
                                  : source.read(pitch, load_case, part_bytes);
    if (!input) return input.error();
    if (Result<void> done = source.check_gravity(*input, load_case); !done) return done.error();
    Result<PartProblem> problem =
        set_up_part(std::move(input->voxels), load_case, input->objects,
                    {o.loose, o.thin || step != Pitch::kOwn, o.common.codes});
    if (!problem) return problem.error();
    PartRun out;
    out.problem = std::move(*problem);
    if (step != Pitch::kHalf)
        out.problem.notes.insert(out.problem.notes.begin(), input->doubts.begin(),
                                 input->doubts.end());
    SolveProgress progress(o.common.quiet, 1, o.common.tolerance);
    out.solution =
        solve_part(&out.problem, load_case.held.size(), solve_options(o.common, &progress), o.full);
    if (Result<void> done = check_solved(out.solution.report, o.common); !done) return done.error();
    out.fields = fields_of(out.problem, &out.solution.moved_mm);
    constexpr size_t kPlaces = 8;
    out.summary = summary_of(out.problem, out.fields, out.solution.moved_mm, kPlaces);
    note_coarse(&out);
    if (step == Pitch::kOwn) note_large(&out);
    if (step == Pitch::kOwn)
        if (Result<void> done = look_at_buckling(o, &out); !done) return done.error();
    return out;
}

/// Whether what `--require` asks for is there.
Result<void> check_required(double required, const PartSummary& s) {
    if (!(required > 0)) return {};
    if (!(s.least_safety > 0)) return user_error(messages::kNoStrength);
    if (!(s.least_safety >= required))
        return user_error(fmt::format(messages::kFactorTooSmall, s.least_safety, required));
    if (s.buckling && s.buckling->factor > 0 && s.buckling->factor / s.buckling->excess < required)
        return user_error(fmt::format(messages::kBucklesBelow,
                                      s.buckling->factor / s.buckling->excess, required));
    if (s.least_safety_cut > 0 && s.least_safety_cut < required)
        return user_error(fmt::format(messages::kFactorCut, s.least_safety_cut),
                          messages::kFactorCutHelp);
    if (verdict_of(s) == Verdict::kUnresolved ||
        (s.least_safety_unresolved > 0 && s.least_safety_unresolved < required))
        return user_error(fmt::format(messages::kFactorUnresolved, s.least_safety_unresolved),
                          messages::kFactorUnresolvedHelp);
    return {};
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
    const Result<Vec3> voxel = source->pitch_mm();
    if (!voxel) return voxel.error();
    Result<PartRun> run = run_at(o, *source, *load_case, *voxel, Pitch::kOwn);
    if (!run) return run.error();
    show(describe(*run, *load_case, source->law()));
    if (Result<void> done = write_outputs(o, *run, *load_case, *picture); !done) return done;
    if (o.converge) {
        // The finer one needs the memory of what has been written.
        run->problem.voxels = {};
        run->problem.elements = {};
        run->problem.forces_N = run->solution.moved_mm = Field<double, kElastic>();
        run->fields = {};
        const Result<PartRun> fine = run_at(o, *source, *load_case, *voxel, Pitch::kHalf);
        if (!fine) return with_context(fine.error(), messages::kConvergeBefore);
        // A third pitch tells whether they settle; as dithered, a coarser print is another one, and where the
        // case does not work at it, it tells nothing.
        std::optional<PartRun> coarser;
        if (!o.common.codes) {
            Result<PartRun> there = run_at(o, *source, *load_case, *voxel, Pitch::kDouble);
            if (there)
                coarser = std::move(*there);
            else if (there.error().code == ErrorCode::kInterrupted)
                return there.error();
        }
        show(describe_convergence(*fine, *run, coarser ? &*coarser : nullptr));
    }
    return check_required(o.require, run->summary);
}

}  // namespace openfab::mechanics
