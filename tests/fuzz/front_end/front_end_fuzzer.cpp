// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// libFuzzer target (preset `fuzz`): for any bytes, the front end ends with diagnostics or with
// valid IR, and the renderers handle both. Start it on tests/lang: `front_end_fuzzer corpus/
// tests/lang/pass tests/lang/fail`.

#include <cstdlib>

#include "compiler/diag/render.h"
#include "compiler/frontend/frontend.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    openfab::source::SourceManager sources;
    openfab::diag::Sink sink;
    const uint32_t file =
        sources.add("fuzz.fl", std::string(reinterpret_cast<const char*>(data), size));
    const auto module = openfab::frontend::compile_to_ir(sources, file, sink);
    if (module) {
        for (const openfab::ir::Fablet& fablet : module->fablets) {
            if (!openfab::ir::verify(fablet.volume).empty()) std::abort();
            if (fablet.has_surface && !openfab::ir::verify(fablet.surface).empty()) std::abort();
        }
    }
    (void)openfab::diag::render_text(sink, sources);
    (void)openfab::diag::render_json(sink, sources);
    return 0;
}
