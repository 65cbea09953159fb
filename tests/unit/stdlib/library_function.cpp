// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/stdlib/library_function.h"

#include <gtest/gtest.h>

#include <limits>
#include <sstream>

#include "compiler/diag/render.h"
#include "compiler/frontend/frontend.h"

namespace openfab::testing {

LibraryFunction::LibraryFunction(const std::string& modules, const std::string& body,
                                 const std::string& functions) {
    std::string text;
    std::istringstream names(modules);
    for (std::string name; names >> name;)
        text += "import " + name + ";\n";
    text += "fablet T { @uniform { float3 p; float t; Material m; }\n" + functions +
            "\nfloat f() { " + body +
            " }\n@Volume() { MaterialComposition mc; mc.Set(m, f()); return mc; } }\n";
    source::SourceManager sources;
    diag::Sink sink;
    const auto module = frontend::compile_to_ir(sources, sources.add("test.fl", text), sink);
    EXPECT_TRUE(module.has_value()) << body << '\n' << diag::render_text(sink, sources);
    if (module) stage_ = module->fablets[0].volume;
}

double LibraryFunction::operator()(const Vec& p, double t) const {
    if (!stage_) return std::numeric_limits<double>::quiet_NaN();
    PointEnvironment point;
    for (size_t a = 0; a < 3; ++a)
        point.values[a] = static_cast<float>(p[a]);
    point.values[3] = static_cast<float>(t);
    return static_cast<double>(std::bit_cast<float>(interp::evaluate(*stage_, point)[0]));
}

}  // namespace openfab::testing
