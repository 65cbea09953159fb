// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Arrays that loops write element by element, as steps of the runtime: random fablets, in the
// interpreter before any pass, as segments, and compiled.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "compiler/frontend/frontend.h"
#include "compiler/passes/pipeline.h"
#include "tests/exec/compiled_stage.h"

namespace openfab::testing {

namespace {

std::optional<ir::Fablet> translated(const std::string& text) {
    source::SourceManager sources;
    diag::Sink sink;
    const std::optional<ir::Module> module =
        frontend::compile_to_ir(sources, sources.add("elements.fl", text), sink);
    EXPECT_TRUE(module.has_value()) << text;
    if (!module) return std::nullopt;
    return module->fablets[0];
}

/// `top`: beside the fablet; `body`: of the volume, which has `level`, about the numbers of elements,
/// and `t`, and gives `sum`.
std::string fablet_of(const std::string& body, const std::string& top = "") {
    return fmt::format(R"({}
fablet Elements {{
    @uniform {{ Material m, other; }}
    @Volume(@varying {{ VolumeAttributes attr, @nearest int level, @nearest float t }})
    {{
        float sum = 0;
        int found = 0;
        {}
        MaterialComposition mc;
        mc.Set(m, sum);
        mc.Set(other, found);
        return mc;
    }}
}})",
                       top, body);
}

StageInputs inputs_of(uint32_t seed) {
    constexpr size_t kVoxels = 512;
    std::mt19937 random(seed);
    StageInputs inputs;
    inputs.elements = 1;
    std::vector<uint32_t> levels(kVoxels), floats(kVoxels);
    for (size_t k = 0; k < kVoxels; ++k) {
        levels[k] = k % 16 == 3 ? 0x80000001u : k % 16 == 7 ? 0x7fffffffu : random() % 160 - 10;
        floats[k] = std::bit_cast<uint32_t>(static_cast<float>(random() % 4096) * 0.01f - 5.0f);
    }
    inputs.set(OPENFAB_ARG_NEAREST, 0, 0, levels);
    inputs.set(OPENFAB_ARG_NEAREST, 1, 0, floats);
    return inputs;
}

constexpr size_t kAnyKernels = 10000;

/// Expects that a fablet has the interpreter's values on every way, by at most so many kernels.
void expect_same(const std::string& text, size_t most_kernels, uint32_t seed, bool compile,
                 size_t voxels = 24) {
    const std::optional<ir::Fablet> fablet = translated(text);
    if (!fablet) return;
    // The object's values of this test are the inputs alone.
    const passes::PipelineResult made =
        passes::run_pipeline(*fablet, {.disabled = {"hoist_uniforms"}});
    ASSERT_EQ(made.fault, "") << text;
    const passes::SegmentedStage& segments = made.stages.volume_segments;
    EXPECT_TRUE(most_kernels == kAnyKernels || !segments.elements.empty()) << text;
    EXPECT_LE(segments.kernels.size(), most_kernels) << text;
    for (const ir::Stage& kernel : segments.kernels)
        ASSERT_EQ(ir::verify(kernel), "") << ir::dump(kernel);
    StageInputs inputs = inputs_of(seed);
    if (!compile) inputs.only = voxels;
    int32_t number = fablet->uniform_value_count;
    for (const openfab_table_value& value : made.stages.table_values)
        inputs.set(OPENFAB_ARG_UNIFORM, number++, 0, {value.bits});
    const StageResults expected = interpret(fablet->volume, inputs);
    expect_equal(fablet->volume, expected, interpret(made.stages.volume, inputs), "after passes");
    if (compile) {
        const auto compiled = CompiledStage::make(made.stages.volume);
        ASSERT_NE(compiled, nullptr);
        expect_equal(made.stages.volume, expected, *compiled, inputs);
    } else if (!segments.steps.empty()) {
        expect_equal(made.stages.volume, expected,
                     interpret_segments(made.stages.volume, segments, inputs), "as segments");
    }
    if (::testing::Test::HasFailure()) ADD_FAILURE() << text;
}

/// Statements on two arrays of floats, one of ints and one of structs, of 110 elements each.
class Program {
  public:
    explicit Program(uint32_t seed) : random_(seed) {}

    std::string text() {
        std::string body = R"(float a[110] = (float[110])0;
        float b[110] = (float[110])0;
        int c[110] = (int[110])0;
        Cell s[110] = (Cell[110])0;
        for (int i = 0; i < 110; ++i) { a[i] = t * i; b[109 - i] = i; c[i] = (i * 7) % 113 - 2; }
        )";
        body += loop("i", 4 + pick(3), true);
        if (pick(2) == 0) body += loop("i", 3, false);
        body += fmt::format("sum = {} + {};\n", number("3"), number("level"));
        body += fmt::format("found = {};\n", integer("1"));
        return fablet_of(body, "struct Cell { float2 at; int n; };");
    }

  private:
    uint32_t pick(uint32_t n) { return static_cast<uint32_t>(random_()) % n; }

    std::string index(const std::string& counter) {
        const std::vector<std::string> all = {counter,
                                              "level",
                                              "(int)t",
                                              "c[" + counter + "]",
                                              "109 - " + counter,
                                              counter + " / 2",
                                              "c[c[level]]",
                                              "s[" + counter + "].n",
                                              "5",
                                              "level * 3 - " + counter};
        return all[pick(static_cast<uint32_t>(all.size()))];
    }
    std::string number(const std::string& counter) {
        const std::string at = index(counter);
        switch (pick(7)) {
            case 0:
                return "a[" + at + "]";
            case 1:
                return "b[" + at + "]";
            case 2:
                return "s[" + at + "].at.y";
            case 3:
                return "(a[" + at + "] + 0.5 * b[" + index(counter) + "])";
            case 4:
                return "(t + " + counter + ")";
            case 5:
                return "sum";
            default:
                return "float(c[" + at + "])";
        }
    }
    std::string integer(const std::string& counter) {
        return pick(2) == 0 ? "c[" + index(counter) + "]" : "s[" + index(counter) + "].n + 1";
    }
    std::string statement(const std::string& counter) {
        const std::string at = index(counter);
        switch (pick(11)) {
            case 0:
                return fmt::format("a[{}] = {};\n", at, number(counter));
            case 1:
                return fmt::format("b[{}] += {};\n", at, number(counter));
            case 2:
                return fmt::format("c[{}] = {};\n", at, integer(counter));
            case 3:
                return fmt::format("s[{}].at.{} = {};\n", at, pick(2) == 0 ? "x" : "y",
                                   number(counter));
            case 4:
                return fmt::format("s[{}].n = {};\n", at, integer(counter));
            case 5:
                return fmt::format("if ({} > t) a[{}] = {}; else b[{}] = {};\n", number(counter),
                                   at, number(counter), index(counter), number(counter));
            case 6:
                return "b = a;\n";
            case 7:
                return fmt::format("if (({} & 3) == 1) a = b;\n", integer(counter));
            case 8:
                return fmt::format("{{ float x = a[{0}]; a[{0}] = a[{1}]; a[{1}] = x; }}\n", at,
                                   index(counter));
            case 9:
                return fmt::format("{{ float x[110] = a; a = b; b = x; }}\n");
            default:
                return fmt::format("sum += {};\n", number(counter));
        }
    }
    std::string loop(const std::string& counter, uint32_t statements, bool nested) {
        std::string out =
            fmt::format("for (int {0} = 0; {0} < clamp(level, 0, 9); ++{0}) {{\n", counter);
        for (uint32_t k = 0; k < statements; ++k)
            out += statement(counter);
        if (nested && pick(2) == 0) out += loop("j", 2, false);
        if (pick(3) == 0) out += fmt::format("if ({} > 40) break;\n", number(counter));
        return out + "}\n";
    }

    std::mt19937 random_;
};

TEST(ArrayElements, RandomFabletsGiveTheSameAsSegments) {
    for (uint32_t seed = 1; seed <= 40; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        expect_same(Program(seed).text(), kAnyKernels, seed, false);
        if (HasFailure()) return;
    }
}

TEST(ArrayElements, RandomFabletsGiveTheSameCompiled) {
    for (uint32_t seed = 101; seed <= 103; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        expect_same(Program(seed).text(), kAnyKernels, seed, true);
        if (HasFailure()) return;
    }
}

/// What people write: a table that is filled and read, a histogram, a sort, points, distances.
const std::array kPrograms = {
    R"(float a[{0}];
       for (int i = 0; i < {0}; ++i) a[i] = t * i;
       sum = a[level];)",
    R"(int bins[{0}] = (int[{0}])0;
       for (int i = 0; i < 500; ++i) bins[(i * level) % {0}] += 1;
       found = bins[3]; sum = bins[(int)t];)",
    R"(float a[{0}];
       for (int i = 0; i < {0}; ++i) a[i] = frac(t * i);
       for (int i = 1; i < 5; ++i) {{
           float x = a[i];
           int j = i - 1;
           @bound(100) while (j >= 0 && a[j] > x) {{ a[j + 1] = a[j]; --j; }}
           a[j + 1] = x;
       }}
       sum = a[0] + 2 * a[{0} - 1] + a[level];)",
    R"(float3 p[{0}];
       for (int i = 0; i < {0}; ++i) p[i] = float3(i, t, i * t);
       float least = 1e9;
       for (int i = 0; i < {0}; ++i) {{
           float d = length(p[i] - float3(level, 1, t));
           if (d < least) {{ least = d; found = i; }}
       }}
       sum = least;)",
    R"(float now[{0}], next[{0}];
       for (int i = 0; i < {0}; ++i) {{ now[i] = i; next[i] = 0; }}
       for (int step = 0; step < clamp(level, 0, 3); ++step) {{
           for (int i = 1; i < {0} - 1; ++i) next[i] = 0.25 * now[i - 1] + 0.5 * now[i] + t * now[i + 1];
           now = next;
       }}
       sum = now[level] + now[7];)",
    R"(float g[{0} / 10][10] = (float[{0} / 10][10])0;
       for (int y = 0; y < clamp(level, 0, {0} / 10); ++y)
           for (int x = 0; x < 10; ++x) g[y][(x + level) % 10] += x + t * y;
       sum = g[level][found] + g[2][level / 9];)",
};

TEST(ArrayElements, KernelsOfAnArrayAreFewWhateverItsSize) {
    for (const char* text : kPrograms) {
        for (const int size : {300, 1000}) {
            SCOPED_TRACE(::testing::Message() << size << ": " << text);
            expect_same(fablet_of(fmt::format(fmt::runtime(text), size)), 24, 5, false, 3);
        }
    }
}

TEST(ArrayElements, OfLargeArraysKernelsAreMeasuredNotAccesses) {
    for (const char* text : std::span(kPrograms).first(3)) {
        SCOPED_TRACE(text);
        const auto fablet = translated(fablet_of(fmt::format(fmt::runtime(text), 4096)));
        ASSERT_TRUE(fablet.has_value());
        const passes::PipelineResult made = passes::run_pipeline(*fablet);
        ASSERT_EQ(made.fault, "");
        EXPECT_FALSE(made.too_long.has_value());
        EXPECT_LE(made.stages.volume_segments.kernels.size(), 24u);
        EXPECT_FALSE(made.stages.volume_segments.elements.empty());
    }
    // Few trips, which the interpreter makes in a short time.
    expect_same(fablet_of(R"(float a[4096] = (float[4096])0;
        int n[4096] = (int[4096])0;
        for (int i = 0; i < 12; ++i) {
            int k = abs(i * 1031 + level * 17) % 4096;
            a[k] += t;
            n[(k + 4090) % 4096] = n[k] + i;
            n[4095 - k] += n[i];
        }
        for (int i = 0; i < 9; ++i) { sum += a[abs(i * 1031 + level * 17) % 4096]; found += n[i * 511]; })"),
                24, 5, false, 3);
}

TEST(ArrayElements, WhatPeopleWriteIsCompiledToTheSameBits) {
    for (const char* text : kPrograms)
        expect_same(fablet_of(fmt::format(fmt::runtime(text), 300)), 24, 5, true);
}

}  // namespace

}  // namespace openfab::testing
