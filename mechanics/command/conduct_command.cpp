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
#include "mechanics/part/conduct.h"
#include "mechanics/part/shown.h"
#include "mechanics/part/volume_files.h"

namespace openfab::mechanics {

namespace {

namespace fs = std::filesystem;

constexpr const char* kConductResults[] = {".vti", ".npy", ".json", ".ofr"};

/// Words and units of a kind of flow.
struct Words {
    const char *what, *level, *flow, *density, *resistance;
    const char *key_level, *key_density;
};
Words words_of(CaseKind kind) {
    if (kind == CaseKind::kHeat)
        return {"heat", "degrees C", "W", "W/mm2", "K/W", "celsius", "heat_W_mm2"};
    return {"current", "V", "A", "A/mm2", "ohm", "volt", "current_A_mm2"};
}

/// An element of the greatest density, far from those before it.
struct Dense {
    Vec3 at_mm{};
    double density = 0;
    int material = 0;
};

struct Conducted {
    ConductProblem problem;
    ConductSolution solution;
    double least = 0, most = 0;  ///< level of what conducts
    Vec3 least_at_mm{}, most_at_mm{};
    std::vector<Dense> densest;
    /// Of two holds and nothing else: the difference of levels over the flow.
    std::optional<double> resistance;
};

Vec3 middle_mm(const ConductProblem& p, int64_t element) {
    Vec3 out;
    const std::array<int32_t, 3> at = place_of(p.grid, element);
    for (size_t a = 0; a < 3; ++a)
        out[a] = p.voxels.origin_mm[a] + (at[a] + 0.5) * p.grid.pitch_mm[a];
    return out;
}

void summarise(const LoadCase& c, Conducted* r) {
    const ConductProblem& p = r->problem;
    const Grid& g = p.grid;
    const std::vector<float>& density = r->solution.density;
    std::vector<int64_t> order;
    bool first = true;
    for (int64_t e = 0; e < g.element_count(); ++e) {
        const auto at = static_cast<size_t>(e);
        if (p.elements.kind[at] != kSolid || !(p.voxels.conductivity[at] > 0)) continue;
        order.push_back(e);
        const std::array<int32_t, 3> q = place_of(g, e);
        for (int32_t k = 0; k < 8; ++k) {
            const double v =
                r->solution.level.row(0, q[1] + (k >> 1 & 1), q[2] + (k >> 2))[q[0] + (k & 1)];
            if (first || v < r->least) {
                r->least = v;
                r->least_at_mm = middle_mm(p, e);
            }
            if (first || v > r->most) {
                r->most = v;
                r->most_at_mm = middle_mm(p, e);
            }
            first = false;
        }
    }
    std::ranges::stable_sort(order, [&](int64_t a, int64_t b) {
        return density[static_cast<size_t>(a)] > density[static_cast<size_t>(b)];
    });
    double longest = 0;
    for (size_t a = 0; a < 3; ++a)
        longest = std::max(longest, g.elements[a] * g.pitch_mm[a]);
    const double apart = std::max(4 * *std::ranges::max_element(g.pitch_mm), 0.06 * longest);
    constexpr size_t kPlaces = 4;
    for (const int64_t e : order) {
        if (r->densest.size() == kPlaces) break;
        const auto at = static_cast<size_t>(e);
        const Dense one{middle_mm(p, e), static_cast<double>(density[at]), p.voxels.code[at]};
        if (std::ranges::all_of(r->densest, [&](const Dense& d) {
                return std::hypot(d.at_mm[0] - one.at_mm[0], d.at_mm[1] - one.at_mm[1],
                                  d.at_mm[2] - one.at_mm[2]) >= apart;
            }))
            r->densest.push_back(one);
    }
    if (c.held.size() == 2 && c.loads.empty() && r->solution.flow_in[0] != 0)
        r->resistance = std::abs((*c.held[1].level - *c.held[0].level) / r->solution.flow_in[1]);
}

std::string point(const Vec3& p) {
    return fmt::format("({:.4g}, {:.4g}, {:.4g})", p[0], p[1], p[2]);
}

/// The material of a place, by the largest share there.
const std::string& material_of(const Conducted& r, const Dense& d) {
    return r.problem.voxels.materials[static_cast<size_t>(std::max(1, d.material) - 1)];
}

std::string describe(const Conducted& r, const LoadCase& c, const std::string& law) {
    const Words w = words_of(c.kind);
    const Grid& g = r.problem.grid;
    std::string out;
    for (const std::string& one : r.problem.notes)
        out += "note: " + one + "\n";
    out += fmt::format("case {}: {}\n", c.name, w.what);
    for (size_t h = 0; h < c.held.size(); ++h)
        out += fmt::format("{:<19} {:.5g} {}, held at {:.5g} {}{}\n", h == 0 ? "flows in" : "",
                           r.solution.flow_in[h], w.flow, *c.held[h].level, w.level,
                           c.held[h].faces.text);
    for (const Load& load : c.loads)
        out += fmt::format("{:<19} {:.5g} {}{}\n", "", *load.inflow, w.flow, load.faces.text);
    if (r.resistance)
        out += fmt::format("{:<19} {:.5g} {}\n", "resistance", *r.resistance, w.resistance);
    if (c.kind == CaseKind::kCurrent)
        out += fmt::format("{:<19} {:.5g} W become heat\n", "power", r.solution.power_W);
    out += fmt::format("{:<19} {:.5g} {} at {} mm, to {:.5g} at {}\n", "from", r.least, w.level,
                       point(r.least_at_mm), r.most, point(r.most_at_mm));
    out +=
        fmt::format("{:<19} {:>8} {:>8} {:>8} {:>12}\n", "densest, mm", "x", "y", "z", w.density);
    for (const Dense& d : r.densest)
        out += fmt::format("{:<19} {:8.2f} {:8.2f} {:8.2f} {:12.4g}  {}\n", "", d.at_mm[0],
                           d.at_mm[1], d.at_mm[2], d.density, material_of(r, d));
    out += fmt::format(
        "pitch {:.4g} x {:.4g} x {:.4g} mm, {} solid elements of {} x {} x {}, {}, residual {:.1e} "
        "in "
        "{} iterations\n",
        g.pitch_mm[0], g.pitch_mm[1], g.pitch_mm[2], r.problem.elements.solid, g.elements[0],
        g.elements[1], g.elements[2], law, r.solution.report.residual,
        r.solution.report.iterations);
    return out;
}

std::string describe_halved(const Conducted& fine, const Conducted& coarse, const LoadCase& c) {
    const auto line = [](const std::string& what, double a, double b, const char* unit) {
        return fmt::format("  {:<26}{:>12.5g} {:>12.5g} {:<9} {:+8.2f} %\n", what, b, a, unit,
                           a != 0 ? 100 * (a - b) / a : 0);
    };
    const Words w = words_of(c.kind);
    std::string out = fmt::format("{:<28}{:>12} {:>12}\n", "at a pitch of",
                                  fmt::format("{:.4g} mm", coarse.problem.grid.pitch_mm[0]),
                                  fmt::format("{:.4g} mm", fine.problem.grid.pitch_mm[0]));
    if (fine.resistance && coarse.resistance)
        out += line("resistance", *fine.resistance, *coarse.resistance, w.resistance);
    for (size_t h = 0; h < c.held.size(); ++h)
        out += line(fmt::format("flow at hold {}", h + 1), fine.solution.flow_in[h],
                    coarse.solution.flow_in[h], w.flow);
    out += line("most", fine.most, coarse.most, w.level);
    out += line("least", fine.least, coarse.least, w.level);
    out += fmt::format("{} solid elements at half the pitch, residual {:.1e} in {} iterations\n",
                       fine.problem.elements.solid, fine.solution.report.residual,
                       fine.solution.report.iterations);
    return out;
}

void write_vector(const char* key, const std::array<double, 3>& v, JsonText* out) {
    out->key(key).begin_array();
    for (const double one : v)
        out->value(one);
    out->end_array();
}

std::string json_of(const Conducted& r, const LoadCase& c, const std::string& law) {
    const Words w = words_of(c.kind);
    JsonText out;
    out.begin_object().member("case", c.name).member("of", w.what).member("law", law);
    out.key("held").begin_array();
    for (size_t h = 0; h < c.held.size(); ++h) {
        out.begin_object().member(w.key_level, *c.held[h].level);
        out.member(c.kind == CaseKind::kHeat ? "watt" : "ampere", r.solution.flow_in[h]);
        out.end_object();
    }
    out.end_array();
    if (r.resistance)
        out.member(c.kind == CaseKind::kHeat ? "resistance_K_W" : "resistance_ohm", *r.resistance);
    if (c.kind == CaseKind::kCurrent) out.member("power_W", r.solution.power_W);
    out.member("least", r.least).member("most", r.most);
    write_vector("least_at_mm", r.least_at_mm, &out);
    write_vector("most_at_mm", r.most_at_mm, &out);
    out.key("densest").begin_array();
    for (const Dense& d : r.densest) {
        out.begin_object();
        write_vector("at_mm", d.at_mm, &out);
        out.member(w.key_density, d.density).member("material", material_of(r, d)).end_object();
    }
    out.end_array();
    write_vector("pitch_mm", r.problem.grid.pitch_mm, &out);
    out.key("elements").begin_array();
    for (const int32_t n : r.problem.grid.elements)
        out.value(n);
    out.end_array();
    out.member("solid_elements", r.problem.elements.solid)
        .member("residual", r.solution.report.residual)
        .member("iterations", static_cast<int32_t>(r.solution.report.iterations));
    out.key("notes").begin_array();
    for (const std::string& one : r.problem.notes)
        out.value(one);
    out.end_array().end_object();
    return out.take() + "\n";
}

/// Colours of densities; a few elements in a thousand are beyond the scale.
Shown shown_of(const Conducted& r, const Words& w) {
    Shown out;
    out.name = w.what;
    out.unit = w.density;
    out.values = r.solution.density;
    std::vector<float> all;
    for (const float v : out.values)
        if (v > 0) all.push_back(v);
    std::ranges::sort(all);
    if (!all.empty()) out.most = static_cast<double>(all[all.size() - 1 - all.size() / 500]);
    if (!(out.most > 0)) out.most = 1;
    return out;
}

Result<void> write_outputs(const ConductOptions& o, const Conducted& r, const LoadCase& c,
                           const std::string& law) {
    const Words w = words_of(c.kind);
    const Grid& g = r.problem.grid;
    const Voxels& v = r.problem.voxels;
    for (const std::string& name : o.outputs) {
        const fs::path file = name;
        const std::string type = file.extension().string();
        Result<void> done;
        if (type == ".vti") {
            done =
                write_vti(file, g, v.origin_mm,
                          {w.key_level,
                           kScalar,
                           [&](int, int32_t y, int32_t z) { return r.solution.level.row(0, y, z); },
                           {{w.key_density, &r.solution.density}, {"solid", &v.solid}},
                           &v.code});
        } else if (type == ".npy") {
            const char* const names[] = {w.key_level, w.key_density, "solid"};
            done = write_npy(file, g, v.origin_mm, v.materials, names,
                             [&](int32_t y, int32_t z, float* row) {
                                 for (int32_t x = 0; x < g.elements[0]; ++x, row += 3) {
                                     double sum = 0;
                                     for (int k = 0; k < 4; ++k) {
                                         const double* p =
                                             r.solution.level.row(0, y + (k & 1), z + (k >> 1)) + x;
                                         sum += p[0] + p[1];
                                     }
                                     const size_t e = g.element(x, y, z);
                                     row[0] = static_cast<float>(sum / 8);
                                     row[1] = r.solution.density[e];
                                     row[2] = v.solid[e];
                                 }
                             });
        } else if (type == ".ofr") {
            done = write_bands(file, g, v.origin_mm, r.problem.elements.kind, shown_of(r, w));
        } else {
            done = backends::write_whole_file(file, json_of(r, c, law));
        }
        if (!done) return done;
    }
    return {};
}

Result<Conducted> run_at(const ConductOptions& o, const PartSource& source, const LoadCase& c,
                         const Vec3& voxel_mm, bool half) {
    Result<PartInput> input = half ? source.read_halved(voxel_mm, c, conduct_bytes)
                                   : source.read(voxel_mm, c, conduct_bytes);
    if (!input) return input.error();
    Result<ConductProblem> problem = set_up_conduct(std::move(input->voxels), c, input->objects);
    if (!problem) return problem.error();
    Conducted out;
    out.problem = std::move(*problem);
    if (!half)
        out.problem.notes.insert(out.problem.notes.begin(), input->doubts.begin(),
                                 input->doubts.end());
    SolveProgress progress(o.common.quiet, 1, o.common.tolerance);
    out.solution = solve_conduct(&out.problem, c.held.size(), solve_options(o.common, &progress));
    if (Result<void> done = check_solved(out.solution.report, o.common); !done) return done.error();
    summarise(c, &out);
    return out;
}

}  // namespace

Result<void> run_conduct(const ConductOptions& o) {
    for (const std::string& file : o.outputs)
        if (std::ranges::find(kConductResults, fs::path(file).extension().string()) ==
            std::end(kConductResults))
            return usage_error(fmt::format(messages::kFlowResultKinds, file));
    const Result<LoadCase> load_case = read_load_case(o.common.input, o.load_case);
    if (!load_case) return load_case.error();
    if (Result<void> done = check_kind(*load_case, true); !done) return done;
    Result<std::unique_ptr<TemporaryFolder>> folder = TemporaryFolder::create();
    if (!folder) return folder.error();
    Result<PartSource> source = PartSource::open(o.common, (*folder)->path());
    if (!source) return source.error();
    source->conduct(load_case->kind);
    const Result<Vec3> voxel = source->pitch_mm();
    if (!voxel) return voxel.error();
    Result<Conducted> run = run_at(o, *source, *load_case, *voxel, false);
    if (!run) return run.error();
    show(describe(*run, *load_case, source->law()));
    if (Result<void> done = write_outputs(o, *run, *load_case, source->law()); !done) return done;
    if (!o.converge) return {};
    // The finer one needs the memory of what has been written.
    run->problem.voxels = {};
    run->problem.inflow = run->solution.level = Field<double, kScalar>();
    const Result<Conducted> fine = run_at(o, *source, *load_case, *voxel, true);
    if (!fine) return with_context(fine.error(), messages::kConvergeBefore);
    show(describe_halved(*fine, *run, *load_case));
    return {};
}

}  // namespace openfab::mechanics
