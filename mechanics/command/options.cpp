// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/command/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "backends/formats/formats.h"
#include "base/clock.h"
#include "base/say.h"
#include "base/units.h"
#include "mechanics/messages.h"

namespace openfab::mechanics {

Result<Properties> properties_of(const CommonOptions& common) {
    const std::filesystem::path file = common.materials.empty()
                                           ? properties_beside(common.input)
                                           : std::filesystem::path(common.materials);
    Result<Properties> out = read_properties(file, common.conditions);
    if (!out) return out.error();
    if (!common.law.empty()) out->law = *law_of(common.law);
    if (out->law == Law::kTable && !out->table)
        return user_error(fmt::format(messages::kLawWithoutTable, file.string()));
    return out;
}

Result<std::array<double, 3>> parse_sizes(const std::string& text) {
    std::vector<std::string> parts{""};
    for (const char c : text)
        if (c == 'x')
            parts.emplace_back();
        else
            parts.back() += c;
    // The last one's unit is that of those without.
    const std::string unit = parts.back().substr(parts.back().find_last_of("0123456789.") + 1);
    std::array<double, 3> out{};
    if (parts.size() != 1 && parts.size() != 3) return usage_error(messages::kSizesForm);
    for (size_t i = 0; i < parts.size(); ++i) {
        std::string& part = parts[i];
        if (!part.empty() && (std::isdigit(static_cast<unsigned char>(part.back())) != 0))
            part += unit;
        const Result<double> mm = parse_length_mm(part);
        if (!mm) return mm.error();
        if (!(*mm > 0)) return usage_error(messages::kSizesTooSmall);
        out[i] = *mm;
    }
    if (parts.size() == 1) out = {out[0], out[0], out[0]};
    return out;
}

std::string sides_text(const std::array<double, 3>& mm) {
    if (mm[0] == mm[1] && mm[0] == mm[2]) return fmt::format("{:.6g}mm", mm[0]);
    return fmt::format("{:.6g}x{:.6g}x{:.6g}mm", mm[0], mm[1], mm[2]);
}

namespace {

constexpr double kAlike = 1e-4;  // of a side

/// Whether all sides are known.
bool is_known(const std::array<double, 3>& pitch_mm) {
    return pitch_mm[0] > 0 && pitch_mm[1] > 0 && pitch_mm[2] > 0;
}

}  // namespace

int parts_of_elements(const CommonOptions& o, const std::array<double, 3>& pitch_mm,
                      const std::array<double, 3>& printer_pitch_mm) {
    constexpr int kFiner = 2;
    if (o.supersample > 0) return o.supersample;
    if (!is_known(printer_pitch_mm)) return kFiner;
    for (size_t a = 0; a < 3; ++a)
        if (pitch_mm[a] < (1 - kAlike) * printer_pitch_mm[a]) return kFiner;
    return 0;
}

void note_other_codes(const CommonOptions& o, const std::array<double, 3>& printer_pitch_mm) {
    if (!o.codes || o.quiet || !is_known(o.voxel_mm) || !is_known(printer_pitch_mm)) return;
    bool alike = true;
    for (size_t a = 0; a < 3; ++a)
        alike = alike && std::abs(o.voxel_mm[a] / printer_pitch_mm[a] - 1) < kAlike;
    if (!alike)
        note(fmt::format(messages::kNotPrintersVoxels, sides_text(o.voxel_mm),
                         sides_text(printer_pitch_mm)));
}

Result<void> check_is_world(const std::string& input, bool fablets) {
    if (input.ends_with(".json") || (fablets && input.ends_with(".fl"))) return {};
    const std::filesystem::path path(input);
    std::error_code ignored;
    if (!std::filesystem::exists(path, ignored)) return {};  // said when it is opened
    const std::string type = path.extension().string();
    const bool print =
        std::filesystem::is_directory(path, ignored) || type == ".vdb" ||
        std::ranges::any_of(backends::formats(), [&](const backends::Format* format) {
            return format->extension == type;
        });
    return user_error(print ? fmt::format(messages::kInputIsPrint, input)
                            : fmt::format(messages::kInputIsNoWorld, input),
                      fablets ? messages::kGiveWorldOrFablet : messages::kGiveWorld);
}

SolveProgress::SolveProgress(bool quiet, int cases, double tolerance)
    : quiet_(quiet), cases_(cases), tolerance_(tolerance), start_(seconds_now()), said_(start_) {}

bool SolveProgress::update(int which, int iteration, double residual) {
    const double now = seconds_now();
    constexpr double kSaySeconds = 2;
    if (quiet_ || now - said_ < kSaySeconds) return true;
    said_ = now;
    // Residuals fall by about the same factor each time, but of hard problems not at first: then thirty more
    // iterations are a fair guess.
    constexpr double kMore = 30;
    const double fallen =
        std::clamp(std::log(std::min(residual, 1.0)) / std::log(tolerance_), 0.0, 1.0);
    const double part = std::max(fallen, iteration / (iteration + kMore));
    const double done = (which + part) / cases_;
    say(fmt::format("case {} of {}  iteration {}  residual {:.1e}  {} left\n", which + 1, cases_,
                    iteration, residual, format_seconds((now - start_) * (1 - done) / done)));
    return true;
}

SolveOptions solve_options(const CommonOptions& common, SolveProgress* progress) {
    SolveOptions out;
    out.tolerance = common.tolerance;
    out.most_iterations = common.most_iterations;
    out.progress = [progress](int iteration, double residual) {
        return progress->update(0, iteration, residual);
    };
    return out;
}

Result<void> check_solved(const SolveReport& report, const CommonOptions& common) {
    if (report.stopped) return interrupted_error();
    if (!report.converged)
        return not_converged_error(report.residual, common.tolerance, report.iterations);
    return {};
}

Error interrupted_error() {
    return Error{ErrorCode::kInterrupted, messages::kInterrupted, "", {}};
}

Error not_converged_error(double residual, double tolerance, int iterations) {
    return user_error(fmt::format(messages::kNotConverged, residual, tolerance, iterations),
                      messages::kNotConvergedHelp);
}

Result<void> check_memory(int64_t needed, int64_t allowed, const std::array<int32_t, 3>& elements) {
    if (needed <= allowed) return {};
    // A little more than it needs, so that what it says is enough: coarser grids have relatively more
    // nodes, and the program itself is as large.
    constexpr double kProgram = 64 << 20;
    const double own = static_cast<double>(allowed) > 2 * kProgram ? kProgram : 0;
    const double coarser = 0.01 * std::ceil(102 * std::cbrt((static_cast<double>(needed) - own) /
                                                            (static_cast<double>(allowed) - own)));
    return user_error(fmt::format(messages::kTooMuchMemory, elements[0], elements[1], elements[2],
                                  format_bytes(needed), format_bytes(allowed)),
                      fmt::format(messages::kTooMuchMemoryHelp, coarser));
}

}  // namespace openfab::mechanics
