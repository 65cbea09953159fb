// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mechanics/command/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/clock.h"
#include "base/say.h"
#include "base/units.h"
#include "mechanics/messages.h"

namespace openfab::mechanics {

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
