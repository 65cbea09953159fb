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
#include "mechanics/part/load_case.h"

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

class CellRun {
  public:
    CellRun(const CellOptions& options, Properties properties, const Vec3& cell,
            const Vec3& printer_pitch_mm)
        : o_(options),
          properties_(std::move(properties)),
          cell_(cell),
          printer_pitch_mm_(printer_pitch_mm) {}

    /// The cell in whole elements: of codes it is cut to as many, else it has to be.
    Result<void> fit(const Vec3& voxel_mm);
    Result<CellResult> run(const CellWorld& world, const fs::path& folder,
                           const std::optional<std::pair<std::string, double>>& setting,
                           bool half = false) const;

  private:
    std::string fitting_pitch(const Vec3& voxel_mm) const;
    Result<void> check_fits(std::array<int32_t, 3> size, bool half) const;
    Result<Homogenised<3>> conduct(const Grid& grid, std::vector<float> conductivity) const;
    Result<Homogenised<3>> current(const VoxelFile& file, const Mixture& mixture, const Grid& grid,
                                   bool half) const;

    const CellOptions& o_;
    Properties properties_;
    mutable bool told_ = false;  ///< what is doubted of the materials
    Vec3 cell_, voxel_mm_{}, printer_pitch_mm_;
    std::array<int32_t, 3> size_{};
};

Result<void> CellRun::fit(const Vec3& voxel_mm) {
    voxel_mm_ = voxel_mm;
    bool whole = true;
    Vec3 cut{};
    for (size_t a = 0; a < 3; ++a) {
        constexpr double kMost = 5e4, kSlack = 1e-3;
        const double n = std::clamp(std::round(cell_[a] / voxel_mm[a]), 1.0, kMost);
        size_[a] = static_cast<int32_t>(n);
        cut[a] = n * voxel_mm[a];
        if (std::abs(cut[a] - cell_[a]) <= kSlack * voxel_mm[a]) continue;
        if (!o_.common.codes)
            return user_error(fmt::format(messages::kCellNotWhole, cell_[a], voxel_mm[a], "xyz"[a]),
                              fmt::format(messages::kCellNotWholeHelp, fitting_pitch(voxel_mm)));
        whole = false;
    }
    if (!o_.common.codes && !o_.common.quiet && (size_[0] % 2 == 1 || size_[1] % 2 == 1))
        note(fmt::format(messages::kOddCell, size_[0] % 2 == 0   ? "y"
                                             : size_[1] % 2 == 0 ? "x"
                                                                 : "x and y"));
    // No period of a dither, anyway.
    cell_ = cut;
    if (!whole && !o_.common.quiet)
        note(fmt::format(messages::kCellOfWholeVoxels, size_[0], size_[1], size_[2],
                         sides_text(voxel_mm), cut[0], cut[1], cut[2]));
    return {};
}

/// The pitch near the wanted one that divides the cell.
std::string CellRun::fitting_pitch(const Vec3& voxel_mm) const {
    Vec3 out{};
    for (size_t a = 0; a < 3; ++a)
        out[a] = cell_[a] / std::max(1.0, std::round(cell_[a] / voxel_mm[a]));
    return sides_text(out);
}

Result<void> CellRun::check_fits(std::array<int32_t, 3> size, bool half) const {
    for (int32_t& n : size)
        n *= half ? 2 : 1;
    const Grid grid = Grid::make(size, {1, 1, 1}, true);
    return check_memory(solver_bytes<kElastic>(grid) +
                            grid.element_count() * Voxels::bytes_per_voxel() + (40 << 20),
                        o_.common.memory_bytes, size);
}

Result<CellResult> CellRun::run(const CellWorld& world, const fs::path& folder,
                                const std::optional<std::pair<std::string, double>>& setting,
                                bool half) const {
    // What is dithered is another print at another pitch: there elements are halved, else voxels are.
    const bool split = half && o_.common.codes;
    Vec3 pitch = voxel_mm_;
    std::array<int32_t, 3> size = size_;
    for (size_t a = 0; a < 3 && half && !split; ++a) {
        pitch[a] /= 2;
        size[a] *= 2;
    }
    // Before a print that may be as large.
    if (Result<void> fits = check_fits(size, split); !fits) return fits.error();
    PrintRequest request{world.world,
                         o_.common.programs,
                         pitch,
                         parts_of_elements(o_.common, pitch, printer_pitch_mm_),
                         o_.common.codes,
                         o_.common.dither,
                         o_.common.settings,
                         o_.common.allow,
                         {},
                         o_.common.threads,
                         o_.common.memory_bytes};
    for (const fs::path& one : world.allow)
        request.allow.push_back(one.string());
    for (std::string& one : request.settings)
        if (one.find('.') > one.find('=')) one.insert(0, world.object + ".");
    if (setting)
        request.settings.push_back(
            fmt::format("{}.{}={}", world.object, setting->first, setting->second));
    CellBox box{world.object, cell_, {}};
    // A box stands in the middle of x and y, where an odd number of voxels has no face.
    for (size_t a = 0; a < 2; ++a)
        box.at_mm[a] = size[a] % 2 == 1 ? pitch[a] / 2 : 0;
    const Result<fs::path> printed = print_cell(request, box, folder);
    if (!printed) return printed.error();
    const Result<VoxelFile> opened = open_voxels(*printed);
    if (!opened) return opened.error();
    if (opened->size != size)
        return user_error(fmt::format(messages::kCellMoves, opened->size[0], opened->size[1],
                                      opened->size[2], size[0], size[1], size[2]),
                          messages::kCellMovesHelp);
    const Result<std::vector<uint8_t>> used = used_materials(*opened);
    if (!used) return used.error();
    Result<std::vector<Material>> materials = properties_.of(opened->materials, *used);
    if (!materials) return materials.error();
    if (!told_) {
        for (const std::string& one : unit_doubts(*materials))
            note(one);
        for (const std::string& one : condition_doubts(*materials, properties_))
            note(one);
        for (const std::string& one : table_doubts(properties_))
            note(one);
    }
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
        const bool heat = all_have([](const Material& m) { return m.conductivity || !m.used; });
        const bool current =
            all_have([](const Material& m) { return m.conductivity_S_m || !m.used; });
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
    const Result<Vec3> cell = parse_sizes(o.cell);
    if (!cell) return usage_error(fmt::format(messages::kCellWrong, cell.error().text()));
    const Result<std::optional<Sweep>> sweep = parse_sweep(o.sweep);
    if (!sweep) return sweep.error();
    if (*sweep && o.converge) return usage_error(messages::kConvergeWithSweep);
    Result<Properties> properties = properties_of(o.common);
    if (!properties) return properties.error();
    Result<std::unique_ptr<TemporaryFolder>> folder = TemporaryFolder::create();
    if (!folder) return folder.error();
    const fs::path scratch = (*folder)->path();
    const Result<CellWorld> world =
        cell_world(o.common.input, o.object, o.common.programs, scratch);
    if (!world) return world.error();
    Vec3 printer{};
    if (world->own_printer) {
        PrintRequest request;
        request.world = world->world;
        request.programs = o.common.programs;
        request.allow = o.common.allow;
        const Result<BuildSize> size = build_size(request, scratch);
        if (!size) return size.error();
        printer = size->printer_pitch_mm;
    }
    CellRun run(o, *properties, *cell, printer);
    note_other_codes(o.common, printer);
    Vec3 voxel = o.common.voxel_mm;
    if (!(voxel[0] > 0)) {
        const bool dithered = o.common.codes && printer[0] > 0 && printer[1] > 0 && printer[2] > 0;
        const double side = *std::ranges::min_element(*cell) / 64;
        voxel = dithered ? printer : Vec3{side, side, side};
    }
    if (Result<void> done = run.fit(voxel); !done) return done;
    const std::string law =
        o.common.codes
            ? std::string(messages::kAsDithered)
            : fmt::format(messages::kMixturesBy, kLawNames[static_cast<size_t>(properties->law)]);
    JsonText json;
    json.begin_object().member(
        "law", o.common.codes ? "codes" : kLawNames[static_cast<size_t>(properties->law)]);
    if (!*sweep) {
        Result<CellResult> r = run.run(*world, scratch, std::nullopt);
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
            const Result<CellResult> fine = run.run(*world, scratch, std::nullopt, true);
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
            Result<CellResult> r = run.run(*world, scratch, std::pair(s.uniform, value));
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
        show(fmt::format("pitch {}, {}\n", sides_text(voxel), law));
    }
    if (!o.output.empty())
        return backends::write_whole_file(fs::path(o.output), json.take() + "\n");
    return {};
}

}  // namespace openfab::mechanics
