// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Limits of uniforms that are expressions: what is kept is their value.

#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <string>

#include "compiler/frontend/frontend.h"

namespace openfab::testing {
namespace {

TEST(Limits, AreConstantExpressions) {
    source::SourceManager sources;
    diag::Sink sink;
    const std::optional<ir::Module> module =
        frontend::compile_to_ir(sources, sources.add("t.fl", R"(
            const float LOWEST[2] = {0.6, 7};
            float twice(float x) { return 2 * x; }
            fablet F {
                @uniform {
                    float a = 1 [[ float min = LOWEST[0], float max = twice(LOWEST[1]), string help = "LOWEST" ]];
                    float b = 1 [[ float min = -1.5, float max = 2 + 1 ]];
                }
                @Volume(@varying { VolumeAttributes attr }) { MaterialComposition mc; return mc; }
            }
        )"),
                                sink);
    ASSERT_TRUE(module);
    const auto annotations = [&](size_t i) {
        const auto& all = module->fablets[0].uniforms[i].annotations;
        return std::map<std::string, std::string>(all.begin(), all.end());
    };
    EXPECT_EQ(annotations(0), (std::map<std::string, std::string>{
                                  {"min", "0.6"}, {"max", "14"}, {"help", "LOWEST"}}));
    EXPECT_EQ(annotations(1), (std::map<std::string, std::string>{{"min", "-1.5"}, {"max", "3"}}));
}

}  // namespace
}  // namespace openfab::testing
