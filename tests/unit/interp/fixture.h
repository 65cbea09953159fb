// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// Fixture of the interpreter's tests: programs in a string, inputs in a map, pictures in a list.

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "compiler/diag/render.h"
#include "compiler/frontend/frontend.h"
#include "compiler/interp/evaluate.h"

namespace openfab::testing {

/// A pyramid in memory: level 0 given, bottom row first; the levels above are box-filtered as in
/// texture/pyramid.h.
struct Picture {
    std::vector<float> texels;
    std::vector<int32_t> info;

    Picture(int32_t width, int32_t height, int32_t channels, std::vector<float> level0,
            int32_t wrap, int32_t filter)
        : texels(std::move(level0)), info{channels, 0, wrap, filter, 0, wrap, 0, 0} {
        int32_t offset = 0;
        while (true) {
            info.insert(info.end(), {offset, width, height, 0});
            ++info[1];
            if (width == 1 && height == 1) return;
            const int32_t next = static_cast<int32_t>(texels.size());
            const int32_t w = (width + 1) / 2;
            const int32_t h = (height + 1) / 2;
            for (int32_t y = 0; y < h; ++y) {
                for (int32_t x = 0; x < w; ++x) {
                    for (int32_t c = 0; c < channels; ++c) {
                        const int32_t x1 = std::min(2 * x + 1, width - 1);
                        const int32_t y1 = std::min(2 * y + 1, height - 1);
                        const auto at = [&](int32_t i, int32_t j) {
                            return texels[static_cast<size_t>(offset + (j * width + i) * channels +
                                                              c)];
                        };
                        texels.push_back(
                            (at(2 * x, 2 * y) + at(x1, 2 * y) + at(2 * x, y1) + at(x1, y1)) / 4);
                    }
                }
            }
            offset = next;
            width = w;
            height = h;
        }
    }
    interp::TextureView view() const { return {texels, info}; }
};

class MapEnvironment : public interp::Environment {
  public:
    std::map<std::tuple<int32_t, int32_t, int32_t>, uint32_t> inputs;
    std::vector<Picture> pictures;
    mutable int sample_count = 0;

    void set(int32_t kind, int32_t a, int32_t b, float value) {
        inputs[{kind, a, b}] = std::bit_cast<uint32_t>(value);
    }
    void set(int32_t kind, int32_t a, int32_t b, int32_t value) {
        inputs[{kind, a, b}] = static_cast<uint32_t>(value);
    }
    uint32_t input(int32_t kind, int32_t a, int32_t b) const override {
        const auto found = inputs.find({kind, a, b});
        EXPECT_NE(found, inputs.end()) << "input " << kind << ' ' << a << ' ' << b;
        return found == inputs.end() ? 0 : found->second;
    }
    interp::TextureView texture(int32_t index) const override {
        ++sample_count;
        return pictures.at(static_cast<size_t>(index)).view();
    }
};

/// Returns the only fablet of a program that must compile.
inline ir::Fablet compile(const std::string& text) {
    source::SourceManager sources;
    diag::Sink sink;
    const uint32_t file = sources.add("test.fl", text);
    std::optional<ir::Module> module = frontend::compile_to_ir(sources, file, sink);
    EXPECT_TRUE(module.has_value()) << diag::render_text(sink, sources);
    if (!module || module->fablets.empty()) return {};
    EXPECT_EQ(ir::verify(module->fablets[0].surface), "");
    EXPECT_EQ(ir::verify(module->fablets[0].volume), "");
    return module->fablets[0];
}

inline float as_float(uint32_t bits) {
    return std::bit_cast<float>(bits);
}

/// Result of a function body that returns a float. x, y, z are float parameters, i, j ints, all
/// read from uniforms so that nothing is folded.
inline float evaluate(const std::string& body, float x = 0, float y = 0, float z = 0, int32_t i = 0,
                      int32_t j = 0) {
    const ir::Fablet fablet =
        compile("fablet A { @uniform { float x, y, z; int i, j; Material m; }\nfloat f() {" + body +
                "}\n@Volume() { MaterialComposition mc; mc.Set(m, f()); return mc; } }");
    MapEnvironment env;
    env.set(OPENFAB_ARG_UNIFORM, 0, 0, x);
    env.set(OPENFAB_ARG_UNIFORM, 1, 0, y);
    env.set(OPENFAB_ARG_UNIFORM, 2, 0, z);
    env.set(OPENFAB_ARG_UNIFORM, 3, 0, i);
    env.set(OPENFAB_ARG_UNIFORM, 4, 0, j);
    const std::vector<uint32_t> out = interp::evaluate(fablet.volume, env);
    EXPECT_EQ(out.size(), 1u);
    return out.empty() ? 0 : as_float(out[0]);
}

}  // namespace openfab::testing
