// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>

#include "backends/common/output_file.h"
#include "base/own_folder.h"
#include "base/say.h"
#include "base/units.h"
#include "mechanics/cell/polar.h"
#include "mechanics/command/cell_report.h"
#include "mechanics/command/commands.h"
#include "mechanics/messages.h"
#include "mechanics/model/print_world.h"
#include "mechanics/part/doubts.h"

namespace openfab::mechanics {

namespace {

namespace fs = std::filesystem;

struct Sweep {
    std::string uniform;
    std::vector<double> values;
};

Result<std::optional<Sweep>> parse_sweep(const std::string& text) {
    if (text.empty()) return std::optional<Sweep>();
    const auto wrong = [&] { return usage_error(fmt::format(messages::kNoSweep, text)); };
    const size_t equal = text.find('=');
    if (equal == std::string::npos || equal == 0) return wrong();
    double from = 0, to = 0;
    int count = 0;
    const char* end = text.data() + text.size();
    auto [a, bad] = std::from_chars(text.data() + equal + 1, end, from);
    if (bad != std::errc() || a == end || *a != ':') return wrong();
    auto [b, worse] = std::from_chars(a + 1, end, to);
    if (worse != std::errc() || b == end || *b != ':') return wrong();
    const auto [c, worst] = std::from_chars(b + 1, end, count);
    if (worst != std::errc() || c != end || count < 2 || count > 1000) return wrong();
    Sweep out{text.substr(0, equal), {}};
    for (int i = 0; i < count; ++i)
        out.values.push_back(from + (to - from) * i / (count - 1));
    return std::optional<Sweep>(std::move(out));
}

Result<std::array<double, 3>> parse_cell(const std::string& text) {
    std::array<double, 3> out{};
    size_t at = 0, count = 0;
    while (count < 3) {
        const size_t x = text.find('x', at);
        const Result<double> mm = parse_length_mm(text.substr(at, x - at));
        if (!mm) return usage_error(fmt::format(messages::kCellWrong, mm.error().text()));
        if (!(*mm > 0)) return usage_error(messages::kCellTooSmall);
        out[count++] = *mm;
        if (x == std::string::npos) break;
        at = x + 1;
    }
    if (count == 1)
        out = {out[0], out[0], out[0]};
    else if (count == 2)
        return usage_error(messages::kCellForm);
    return out;
}

class CellRun {
  public:
    CellRun(const CellOptions& options, Properties properties, std::array<double, 3> cell)
        : o_(options), properties_(std::move(properties)), cell_(cell) {}

    Result<CellResult> run(const CellWorld& world, const fs::path& folder, double voxel_mm,
                           const std::optional<std::pair<std::string, double>>& setting,
                           bool half = false) const;

  private:
    Result<void> check(const VoxelFile& file, bool half) const;
    Result<void> check_fits(std::array<int32_t, 3> size, bool half) const;
    Result<Homogenised<3>> conduct(const Grid& grid, std::vector<float> conductivity) const;
    Result<Homogenised<3>> current(const VoxelFile& file, const Mixture& mixture, const Grid& grid,
                                   bool half) const;

    const CellOptions& o_;
    Properties properties_;
    std::array<double, 3> cell_;
    mutable bool told_ = false;  ///< what is doubted of the materials
};

Result<void> CellRun::check(const VoxelFile& file, bool half) const {
    for (size_t a = 0; a < 3; ++a) {
        const double mm = file.size[a] * file.pitch_mm[a];
        if (std::abs(mm - cell_[a]) > 1e-3 * file.pitch_mm[a])
            return user_error(
                fmt::format(messages::kCellNotWhole, cell_[a], file.pitch_mm[a], "xyz"[a]),
                fmt::format(messages::kCellNotWholeHelp,
                            cell_[a] / std::max(1.0, std::round(cell_[a] / file.pitch_mm[a]))));
    }
    return check_fits(file.size, half);
}

Result<void> CellRun::check_fits(std::array<int32_t, 3> size, bool half) const {
    for (int32_t& n : size)
        n *= half ? 2 : 1;
    const Grid grid = Grid::make(size, {1, 1, 1}, true);
    return check_memory(solver_bytes<kElastic>(grid) +
                            grid.element_count() * Voxels::bytes_per_voxel() + (40 << 20),
                        o_.common.memory_bytes, size);
}

Result<CellResult> CellRun::run(const CellWorld& world, const fs::path& folder, double voxel_mm,
                                const std::optional<std::pair<std::string, double>>& setting,
                                bool half) const {
    // What is dithered is another print at another pitch: there elements are halved, else voxels are.
    const bool split = half && o_.common.codes;
    if (half && !split) voxel_mm /= 2;
    // Before a print that may be as large.
    std::array<int32_t, 3> size;
    for (size_t a = 0; a < 3; ++a) {
        constexpr double kMost = 5e4;
        size[a] = static_cast<int32_t>(std::clamp(std::round(cell_[a] / voxel_mm), 1.0, kMost));
    }
    if (Result<void> fits = check_fits(size, split); !fits) return fits.error();
    const fs::path file = folder / "cell.fab.json";
    if (Result<void> done = backends::write_whole_file(file, world.text); !done)
        return done.error();
    PrintRequest request{file,
                         o_.common.programs,
                         voxel_mm,
                         o_.common.supersample,
                         o_.common.codes,
                         o_.common.dither,
                         o_.common.settings,
                         o_.common.allow,
                         o_.common.threads,
                         o_.common.memory_bytes};
    for (const fs::path& one : world.folders)
        request.allow.push_back(one.string());
    for (std::string& one : request.settings)
        if (one.find('.') > one.find('=')) one = world.object + "." + one;
    if (setting)
        request.settings.push_back(
            fmt::format("{}.{}={}", world.object, setting->first, setting->second));
    const Result<fs::path> printed = print_voxels(request, folder, "cell");
    if (!printed) return printed.error();
    const Result<VoxelFile> opened = open_voxels(*printed);
    if (!opened) return opened.error();
    if (Result<void> fits = check(*opened, split); !fits) return fits.error();
    Result<std::vector<Material>> materials = properties_.of(opened->materials);
    if (!materials) return materials.error();
    if (!told_)
        for (const std::string& one : unit_doubts(*materials))
            note(one);
    told_ = true;
    const Mixture mixture(std::move(*materials), properties_);
    if (const std::string bad = mixture.complaint(); !bad.empty()) return user_error(bad);
    Result<Voxels> voxels = read_voxels(*opened, mixture);
    if (!voxels) return voxels.error();
    if (split) voxels = halved(*voxels);
    CellResult out;
    const Grid grid = Grid::make(voxels->size, voxels->pitch_mm, true);
    HomogeniseOptions options;
    options.solve.tolerance = o_.common.tolerance;
    options.solve.most_iterations = o_.common.most_iterations;
    SolveProgress progress(o_.common.quiet, 6, o_.common.tolerance);
    options.progress = [&](int which, int iteration, double residual) {
        return progress.update(which, iteration, residual);
    };
    ElementValues values{std::move(voxels->lambda), std::move(voxels->mu), 1};
    values.normalise();
    out.stiffness = homogenise_stiffness(grid, values, options);
    if (out.stiffness.stopped) return interrupted_error();
    if (!out.stiffness.converged())
        return not_converged_error(out.stiffness.worst_residual(), o_.common.tolerance,
                                   out.stiffness.most_iterations());
    if (o_.conductivity) {
        const auto all_have = [&](auto property) {
            return std::ranges::all_of(mixture.materials(), property);
        };
        const bool heat = all_have([](const Material& m) { return m.conductivity.has_value(); });
        const bool current =
            all_have([](const Material& m) { return m.conductivity_S_m.has_value(); });
        if (!heat && !current)
            return user_error(fmt::format(messages::kConductivityMixed, properties_.file),
                              messages::kConductivityMixedHelp);
        if (heat) {
            Result<Homogenised<3>> got = conduct(grid, std::move(voxels->conductivity));
            if (!got) return got.error();
            out.heat = *got;
        }
        if (current) {
            Result<Homogenised<3>> got = this->current(*opened, mixture, grid, split);
            if (!got) return got.error();
            out.current = *got;
        }
    }
    out.compliance = compliance_of(out.stiffness.tensor);
    if (out.compliance) out.engineering = engineering_of(out.stiffness.tensor, *out.compliance);
    for (std::vector<float>* all :
         {&voxels->strength, &voxels->density, &voxels->conductivity, &voxels->solid})
        *all = {};
    voxels->code = {};
    out.voxels = std::move(*voxels);
    return out;
}

Result<Homogenised<3>> CellRun::conduct(const Grid& grid, std::vector<float> conductivity) const {
    HomogeniseOptions options;
    options.solve.tolerance = o_.common.tolerance;
    options.solve.most_iterations = o_.common.most_iterations;
    ElementValues values{std::move(conductivity), {}, 1};
    values.normalise();
    Homogenised<3> out = homogenise_conductivity(grid, values, options);
    if (!out.converged())
        return not_converged_error(out.worst_residual(), o_.common.tolerance,
                                   out.most_iterations());
    return out;
}

/// Of current: the voxels once more, with that as what is conducted.
Result<Homogenised<3>> CellRun::current(const VoxelFile& file, const Mixture& mixture,
                                        const Grid& grid, bool half) const {
    std::vector<Material> materials = mixture.materials();
    for (Material& m : materials)
        m.conductivity = m.conductivity_S_m;
    Result<Voxels> voxels = read_voxels(file, Mixture(std::move(materials), properties_));
    if (!voxels) return voxels.error();
    if (half) voxels = halved(*voxels);
    return conduct(grid, std::move(voxels->conductivity));
}

}  // namespace

Result<void> run_cell(const CellOptions& o) {
    const Result<std::array<double, 3>> cell = parse_cell(o.cell);
    if (!cell) return cell.error();
    const Result<std::optional<Sweep>> sweep = parse_sweep(o.sweep);
    if (!sweep) return sweep.error();
    if (*sweep && o.converge) return usage_error(messages::kConvergeWithSweep);
    const fs::path file = o.common.materials.empty() ? properties_beside(o.common.input)
                                                     : fs::path(o.common.materials);
    Result<Properties> properties = read_properties(file);
    if (!properties) return properties.error();
    if (!o.common.law.empty()) properties->law = *law_of(o.common.law);
    if (properties->law == Law::kTable && !properties->table)
        return user_error(fmt::format(messages::kLawWithoutTable, file.string()));
    Result<std::unique_ptr<TemporaryFolder>> folder = TemporaryFolder::create();
    if (!folder) return folder.error();
    const fs::path scratch = (*folder)->path();
    const Result<CellWorld> world =
        cell_world(o.common.input, o.object, *cell, o.common.programs, scratch);
    if (!world) return world.error();
    double voxel = o.common.voxel_mm;
    if (!(voxel > 0)) voxel = std::min({(*cell)[0], (*cell)[1], (*cell)[2]}) / 64;
    const CellRun run(o, *properties, *cell);
    const std::string law =
        o.common.codes
            ? std::string(messages::kAsDithered)
            : fmt::format(messages::kMixturesBy, kLawNames[static_cast<size_t>(properties->law)]);
    JsonText json;
    json.begin_object().member(
        "law", o.common.codes ? "codes" : kLawNames[static_cast<size_t>(properties->law)]);
    if (!*sweep) {
        Result<CellResult> r = run.run(*world, scratch, voxel, std::nullopt);
        if (!r) return r.error();
        show(describe(*r, law));
        write_result(*r, &json);
        json.end_object();
        if (!o.polar.empty()) {
            if (!r->compliance) return user_error(messages::kNoPolarPlot);
            const std::vector<uint8_t> png =
                polar_picture(*r->compliance, r->engineering->young_most);
            if (Result<void> done = backends::write_whole_file(fs::path(o.polar), png); !done)
                return done;
        }
        if (o.converge) {
            const Result<CellResult> fine = run.run(*world, scratch, voxel, std::nullopt, true);
            if (!fine) return with_context(fine.error(), messages::kConvergeBefore);
            show(describe_convergence(*fine, *r));
        }
    } else {
        const Sweep& s = **sweep;
        json.member("property", "Young's modulus along x")
            .member("unit", "MPa")
            .member("parameter", s.uniform);
        json.key("rows").begin_array();
        show(fmt::format("{:>12} {:>10} {:>12} {:>12} {:>12} {:>9} {:>10} {:>9}\n", s.uniform,
                         "solid", "E_x MPa", "E_y MPa", "E_z MPa", "Zener", "residual",
                         "elements"));
        for (const double value : s.values) {
            Result<CellResult> r = run.run(*world, scratch, voxel, std::pair(s.uniform, value));
            if (!r) return r.error();
            double solid = 0;
            for (const double share : r->voxels.share)
                solid += share;
            const std::array<double, 3> young =
                r->engineering ? r->engineering->young : std::array<double, 3>{};
            show(fmt::format("{:12.5g} {:10.4f} {:12.5g} {:12.5g} {:12.5g} {:9.4g} {:10.1e} {:9}\n",
                             value, solid, young[0], young[1], young[2],
                             r->engineering ? r->engineering->zener : 0.0,
                             r->stiffness.worst_residual(),
                             int64_t{r->voxels.size[0]} * r->voxels.size[1] * r->voxels.size[2]));
            json.begin_object().member("at", value).member("value", young[0]);
            write_result(*r, &json);
            json.end_object();
        }
        json.end_array().end_object();
        show(fmt::format("pitch {:.4g} mm, {}\n", voxel, law));
    }
    if (!o.output.empty())
        return backends::write_whole_file(fs::path(o.output), json.take() + "\n");
    return {};
}

}  // namespace openfab::mechanics
