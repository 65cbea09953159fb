// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/say.h"
#include "compiler/driver/back_end.h"
#include "compiler/driver/commands.h"
#include "compiler/driver/derivatives.h"
#include "compiler/frontend/frontend.h"
#include "compiler/interp/measure_distance.h"

namespace openfab::driver {

namespace {

std::string point_text(const std::array<float, 3>& p) {
    return fmt::format("({:.4g}, {:.4g}, {:.4g})", p[0], p[1], p[2]);
}

/// Warns of shapes that claim to be distances, and are not where they are asked.
void measure_claims(const ir::Module& module, diag::Sink* sink) {
    for (const ir::Fablet& fablet : module.fablets) {
        if (!fablet.shape_is_distance) continue;
        const std::optional<interp::NoDistance> fault = interp::measure_distance(fablet);
        if (!fault) continue;
        const std::string at =
            fmt::format("at {} it is {:.4g}", point_text(fault->at), fault->value);
        if (fault->other) {
            sink->report(fablet.claim_span, diag::kNoDistance, fablet.name,
                         fmt::format("{} and at {} {:.4g}, which is more than these are apart", at,
                                     point_text(*fault->other), fault->then))
                .help(
                    "a distance changes by no more than the point moves: divide by how much faster "
                    "it changes, and leave `[[ distance ]]` out");
        } else {
            sink->report(
                    fablet.claim_span, diag::kNoDistance, fablet.name,
                    fmt::format("{}, but as far as that from there the value is {:.4g}, not 0; "
                                "so it is at {:.0f} % of the points {} within {:.4g} mm of the "
                                "origin",
                                at, fault->then, 100 * fault->share,
                                fault->value < 0 ? "inside" : "outside", fault->half))
                .help(
                    "without `[[ distance ]]` the surface is found where the value is 0, and "
                    "`distance` is to that");
        }
    }
}

/// Returns whether no stage is too long to be compiled, which the passes show.
bool are_short(const ir::Module& module, diag::Sink* sink, std::string* bug) {
    bool all = true;
    for (const ir::Fablet& fablet : module.fablets) {
        const passes::PipelineResult result = run_passes(fablet, {});
        if (bug->empty()) *bug = result.fault;
        all = result.fault.empty() && !refuse_long_stages(fablet, result, sink) && all;
    }
    return all;
}

}  // namespace

int check(const std::vector<std::string>& files, bool derivatives, const CommonOptions& common) {
    int exit_code = kExitDone;
    source::SourceManager sources;
    for (const std::string& file : files) {
        diag::Sink own;
        std::string fault;
        std::string bug;
        const std::optional<ir::Module> module =
            frontend::compile_to_ir(sources, file, own, &fault, {false});
        const bool ok = module && are_short(*module, &own, &bug);
        if (ok) measure_claims(*module, &own);
        for (size_t k = 0; ok && derivatives && k < module->fablets.size(); ++k)
            warn_of_jumps(module->fablets[k], &own);
        print_diagnostics(own, sources, common);
        if (!fault.empty()) {
            exit_code = std::max(exit_code, fail(fault, unread_exit_code(file)));
        } else if (!bug.empty()) {
            exit_code = std::max(exit_code, fail(bug, kExitBug));
        } else if (!ok) {
            exit_code = std::max(exit_code, kExitUserInput);
        }
    }
    return exit_code;
}

}  // namespace openfab::driver
