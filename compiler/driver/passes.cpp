// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <string>

#include "backends/common/output_file.h"
#include "base/say.h"
#include "compiler/driver/commands.h"
#include "compiler/driver/one_fablet.h"
#include "compiler/driver/passes_page.h"
#include "compiler/passes/pipeline.h"

namespace openfab::driver {

int show_passes(const PassesOptions& options, const CommonOptions& common) {
    source::SourceManager sources;
    OneFablet one;
    if (const int code = read_fablet(options.file, options.fablet, options.enable_printf, common,
                                     &sources, &one);
        code != kExitDone)
        return code;
    const ir::Fablet* const fablet = one.fablet;
    PassesPage page(*fablet, sources);
    passes::PipelineOptions pipeline;
    pipeline.disabled.insert(options.disabled.begin(), options.disabled.end());
    pipeline.after = [&](const std::string& pass, const ir::Stage& stage,
                         const std::string& reason) { page.add(pass, stage, reason); };
    const passes::PipelineResult result = passes::run_pipeline(*fablet, pipeline);
    if (!result.fault.empty()) return fail(result.fault, kExitBug);
    if (const Result<void> written = backends::write_whole_file(options.output, page.html());
        !written)
        return fail(written.error().text(), exit_code(written.error().code));
    show(fmt::format("{}\n", options.output));
    return kExitDone;
}

}  // namespace openfab::driver
