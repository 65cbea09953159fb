// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Random fablets: the interpreter on the unoptimised stage against compiled code after all passes.
// 40 programs unless OPENFAB_PROGRAMS says otherwise; OPENFAB_SEED is the first seed. Fablets that
// have found a bug are in finds/.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <random>

#include "compiler/diag/render.h"
#include "compiler/frontend/frontend.h"
#include "compiler/passes/eliminate_common_values.h"
#include "compiler/passes/expand_functions.h"
#include "compiler/passes/expand_picks.h"
#include "compiler/passes/form_demand.h"
#include "compiler/passes/form_tables.h"
#include "compiler/passes/pipeline.h"
#include "compiler/passes/simplify.h"
#include "tests/exec/compiled_stage.h"
#include "tests/fuzz/differential/random_fablet.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"

namespace openfab::testing {
namespace {

uint64_t from_environment(const char* name, uint64_t otherwise) {
    const char* text = std::getenv(name);
    return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

/// Edge-case values among ordinary ones.
uint32_t float_bits(std::mt19937_64* random) {
    static constexpr std::array<float, 12> special = {0.0f,
                                                      -0.0f,
                                                      1.0f,
                                                      -1.0f,
                                                      std::numeric_limits<float>::quiet_NaN(),
                                                      std::numeric_limits<float>::infinity(),
                                                      -std::numeric_limits<float>::infinity(),
                                                      std::numeric_limits<float>::denorm_min(),
                                                      std::numeric_limits<float>::max(),
                                                      std::numeric_limits<float>::lowest(),
                                                      2147483648.0f,
                                                      16777217.0f};
    const uint64_t bits = (*random)();
    if (bits % 4 == 0) return std::bit_cast<uint32_t>(special[(bits >> 8) % special.size()]);
    const float unit = static_cast<float>((bits >> 8) % 65536) / 32768.0f - 1.0f;
    return std::bit_cast<uint32_t>(bits % 4 == 1 ? unit : unit * 50.0f);
}

uint32_t int_bits(std::mt19937_64* random) {
    static constexpr std::array<int32_t, 8> special = {0,
                                                       1,
                                                       -1,
                                                       31,
                                                       32,
                                                       65536,
                                                       std::numeric_limits<int32_t>::max(),
                                                       std::numeric_limits<int32_t>::min()};
    const uint64_t bits = (*random)();
    if (bits % 3 == 0) return static_cast<uint32_t>(special[(bits >> 8) % special.size()]);
    return static_cast<uint32_t>(static_cast<int32_t>((bits >> 8) % 21) - 10);
}

/// One block of voxels with every input at its own value.
StageInputs inputs_for(const ir::Fablet& fablet, uint64_t seed) {
    std::mt19937_64 random(seed);
    StageInputs inputs;
    inputs.elements = 1;
    const auto many = [&](uint32_t (*make)(std::mt19937_64*)) {
        std::vector<uint32_t> bits(512);
        std::generate(bits.begin(), bits.end(), [&] { return make(&random); });
        return bits;
    };
    for (size_t n = 0; n < fablet.nearest.size(); ++n) {
        for (int32_t c = 0; c < fablet.nearest[n].components; ++c) {
            inputs.set(OPENFAB_ARG_NEAREST, static_cast<int32_t>(n), c,
                       many(fablet.nearest[n].type == ir::Type::kFloat ? float_bits : int_bits));
        }
    }
    inputs.set(OPENFAB_ARG_DISTANCE, 0, 0, many(float_bits));
    for (const ir::Uniform& u : fablet.uniforms) {
        for (size_t k = 0; k < u.default_bits.size(); ++k) {
            inputs.set(OPENFAB_ARG_UNIFORM, u.first_index + static_cast<int32_t>(k), 0,
                       {u.default_bits[k]});
        }
    }
    for (int32_t k = 0; k < OPENFAB_FRAME_COUNT; ++k) {
        const float value = k % 4 == 0 ? 0.03f : 0.25f * static_cast<float>(k);
        inputs.set(OPENFAB_ARG_FRAME, k, 0, {std::bit_cast<uint32_t>(value)});
    }
    inputs.set(OPENFAB_ARG_BLOCKS, 0, 0, {16, static_cast<uint32_t>(-8), 800});
    return inputs;
}

/// Appends the values of tables.
void add_tables(const ir::Fablet& fablet, const passes::KernelStages& stages, StageInputs* inputs) {
    const auto first =
        fablet.uniform_value_count + static_cast<int32_t>(stages.derived.outputs.size());
    for (size_t k = 0; k < stages.table_values.size(); ++k) {
        const openfab_table_value& value = stages.table_values[k];
        const auto from = inputs->values.find({OPENFAB_ARG_UNIFORM, value.from, 0});
        const bool known = value.from >= 0 && from != inputs->values.end();
        inputs->set(OPENFAB_ARG_UNIFORM, first + static_cast<int32_t>(k), 0,
                    {known ? from->second[0] : value.bits});
    }
}

/// Appends the derived uniforms, and tables, from which they may be derived and which may hold them.
void add_derived(const ir::Fablet& fablet, const passes::KernelStages& stages,
                 StageInputs* inputs) {
    add_tables(fablet, stages, inputs);
    const ir::Stage& derived = stages.derived;
    const StageResults values = interpret(derived, *inputs);
    for (size_t k = 0; k < values.size(); ++k) {
        inputs->set(OPENFAB_ARG_UNIFORM, fablet.uniform_value_count + derived.outputs[k].a, 0,
                    {values[k][0]});
    }
    add_tables(fablet, stages, inputs);
}

/// Fails the test if the fablet has an error.
std::optional<ir::Module> compile_text(const std::string& text) {
    source::SourceManager sources;
    diag::Sink sink;
    std::optional<ir::Module> module =
        frontend::compile_to_ir(sources, sources.add("random.fl", text), sink);
    if (!module) ADD_FAILURE() << diag::render_text(sink, sources) << text;
    return module;
}

void check(const std::string& text, uint64_t seed) {
    const std::optional<ir::Module> module = compile_text(text);
    ASSERT_TRUE(module.has_value());
    const ir::Fablet& fablet = module->fablets[0];
    ASSERT_EQ(ir::verify(fablet.volume), "") << text;
    StageInputs inputs = inputs_for(fablet, seed);
    const StageResults expected = interpret(fablet.volume, inputs);
    const passes::PipelineResult made = passes::run_pipeline(fablet, {});
    ASSERT_EQ(made.fault, "") << text;
    add_derived(fablet, made.stages, &inputs);
    // One instruction set for each; other tests check that both agree.
    const openfab_isa isa = seed % 2 == 0 ? OPENFAB_ISA_SSE41 : OPENFAB_ISA_AVX2;
    lower::ProgramOptions options;
    options.isas = {isa};
    const std::unique_ptr<CompiledStage> compiled =
        CompiledStage::make(made.stages.volume, options);
    ASSERT_NE(compiled, nullptr) << text;
    expect_equal(made.stages.volume, expected, compiled->run(isa, inputs), abi::isa_name(isa));
    expect_equal_slab(made.stages.volume, expected, inputs, options, &made.stages.volume_demand);
    if (::testing::Test::HasFailure()) ADD_FAILURE() << text;
}

TEST(Differential, InterpreterAndCompiledCodeAgree) {
    const uint64_t programs = from_environment("OPENFAB_PROGRAMS", 40);
    const uint64_t first = from_environment("OPENFAB_SEED", 1);
    const uint64_t fablets = (programs + kProgramsPerFablet - 1) / kProgramsPerFablet;
    for (uint64_t seed = first; seed < first + fablets; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        check(random_fablet(seed), seed);
        if (HasFailure()) break;
    }
}

/// A range of finite values and 512 values in it, for a box of voxels.
template <typename T>
struct Range {
    T lo{}, hi{};
    std::vector<uint32_t> samples;
};

Range<float> float_range(std::mt19937_64* random) {
    static constexpr std::array<float, 6> widths = {0.0f, 1e-3f, 0.1f, 1.0f, 20.0f, 1e6f};
    const auto unit = [&] { return static_cast<float>((*random)() >> 40) * 0x1p-24f; };
    Range<float> r;
    r.lo = (unit() - 0.5f) * ((*random)() % 2 == 0 ? 2.0f : 60.0f);
    r.hi = r.lo + widths[(*random)() % widths.size()];
    for (int k = 0; k < 512; ++k) {
        const float x = k == 0 ? r.lo : k == 1 ? r.hi : r.lo + (r.hi - r.lo) * unit();
        r.samples.push_back(std::bit_cast<uint32_t>(std::clamp(x, r.lo, r.hi)));
    }
    return r;
}

Range<int32_t> int_range(std::mt19937_64* random) {
    Range<int32_t> r;
    r.lo = static_cast<int32_t>((*random)() % 21) - 10;
    const auto width = static_cast<int32_t>((*random)() % 4);
    r.hi = r.lo + width;
    for (int k = 0; k < 512; ++k) {
        const auto step = static_cast<int32_t>((*random)() % static_cast<uint64_t>(width + 1));
        r.samples.push_back(static_cast<uint32_t>(r.lo + step));
    }
    return r;
}

/// Inputs of one block, and of the interval form of the stage on that block.
struct BoxInputs {
    StageInputs voxels, box;
};

BoxInputs box_inputs(const ir::Fablet& fablet, uint64_t seed) {
    std::mt19937_64 random(seed);
    BoxInputs out;
    out.voxels = inputs_for(fablet, seed);
    out.box = out.voxels;
    const auto set = [&](int32_t kind, int32_t lo, int32_t hi, int32_t a, int32_t b,
                         bool is_float) {
        if (is_float) {
            const Range<float> r = float_range(&random);
            out.voxels.set(kind, a, b, r.samples);
            out.box.set(lo, a, b, {std::bit_cast<uint32_t>(r.lo)});
            out.box.set(hi, a, b, {std::bit_cast<uint32_t>(r.hi)});
        } else {
            const Range<int32_t> r = int_range(&random);
            out.voxels.set(kind, a, b, r.samples);
            out.box.set(lo, a, b, {static_cast<uint32_t>(r.lo)});
            out.box.set(hi, a, b, {static_cast<uint32_t>(r.hi)});
        }
    };
    for (size_t n = 0; n < fablet.nearest.size(); ++n) {
        for (int32_t c = 0; c < fablet.nearest[n].components; ++c) {
            set(OPENFAB_ARG_NEAREST, OPENFAB_ARG_NEAREST_LO, OPENFAB_ARG_NEAREST_HI,
                static_cast<int32_t>(n), c, fablet.nearest[n].type == ir::Type::kFloat);
        }
    }
    set(OPENFAB_ARG_DISTANCE, OPENFAB_ARG_DISTANCE_LO, OPENFAB_ARG_DISTANCE_HI, 0, 0, true);
    out.box.set(OPENFAB_ARG_BLOCK_SIZE, 0, 0, {8});
    return out;
}

TEST(Differential, IntervalsHoldEverySample) {
    const uint64_t fablets = from_environment("OPENFAB_PROGRAMS", 300) / kProgramsPerFablet;
    const uint64_t first = from_environment("OPENFAB_SEED", 1);
    size_t known = 0, all = 0;
    for (uint64_t seed = first; seed < first + fablets; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        const std::string text = random_fablet(seed);
        const std::optional<ir::Module> module = compile_text(text);
        ASSERT_TRUE(module.has_value());
        const ir::Fablet& fablet = module->fablets[0];
        passes::PipelineOptions options;
        options.longest_bounds = std::numeric_limits<size_t>::max();
        const passes::PipelineResult made = passes::run_pipeline(fablet, options);
        ASSERT_EQ(made.fault, "") << text;
        BoxInputs inputs = box_inputs(fablet, seed);
        add_derived(fablet, made.stages, &inputs.box);
        const StageResults samples = interpret(fablet.volume, inputs.voxels);
        const StageResults ends = interpret(made.stages.volume_bounds, inputs.box);
        ASSERT_GE(ends.size(), 2 * samples.size());
        for (size_t k = 0; k < samples.size(); ++k) {
            const float lo = std::bit_cast<float>(ends[2 * k][0]);
            const float hi = std::bit_cast<float>(ends[2 * k + 1][0]);
            ++all;
            if (std::isnan(lo) || std::isnan(hi)) continue;
            ++known;
            for (const uint32_t bits : samples[k]) {
                const float x = std::bit_cast<float>(bits);
                ASSERT_TRUE(lo <= x && x <= hi)
                    << "program " << k << ": " << x << " is outside " << lo << " to " << hi << "\n"
                    << text;
            }
        }
    }
    // A trivial bound is sound but useless.
    EXPECT_GT(known * 5, all) << known << " of " << all << " bounds say something";
}

TEST(Differential, NoPassChangesAResult) {
    const uint64_t fablets = from_environment("OPENFAB_PROGRAMS", 200) / kProgramsPerFablet;
    const uint64_t first = from_environment("OPENFAB_SEED", 1);
    for (uint64_t seed = first; seed < first + fablets; ++seed) {
        const std::string text = random_fablet(seed);
        const std::optional<ir::Module> module = compile_text(text);
        ASSERT_TRUE(module.has_value());
        const ir::Fablet& fablet = module->fablets[0];
        StageInputs plain = inputs_for(fablet, seed);
        plain.only = 64;
        const StageResults expected = interpret(fablet.volume, plain);
        for (const passes::PassName& pass : passes::pass_names()) {
            if (!pass.optional) continue;
            SCOPED_TRACE(::testing::Message() << "seed " << seed << " without " << pass.name);
            passes::PipelineOptions options;
            options.disabled = {pass.name};
            const passes::PipelineResult made = passes::run_pipeline(fablet, options);
            ASSERT_EQ(made.fault, "") << text;
            StageInputs inputs = plain;
            add_derived(fablet, made.stages, &inputs);
            expect_equal(fablet.volume, expected, interpret(made.stages.volume, inputs), pass.name);
            if (HasFailure()) FAIL() << text;
        }
    }
}

/// The stage of one program of a fablet.
ir::Stage program_of(const ir::Fablet& fablet, size_t k) {
    ir::Stage stage = fablet.volume;
    stage.outputs = {stage.outputs[k]};
    passes::expand_picks(&stage);
    passes::simplify(&stage);
    passes::eliminate_common_values(&stage);
    ir::drop_dead_values(&stage);
    return stage;
}

/// If a voxel does not need its nearest surface point, replacing the inputs that derive from it
/// changes no bit; and the demand kernel agrees with the interpreter.
TEST(Differential, WhatIsNotAskedForChangesNothing) {
    const uint64_t fablets = from_environment("OPENFAB_PROGRAMS", 300) / kProgramsPerFablet;
    const uint64_t first = from_environment("OPENFAB_SEED", 1);
    constexpr int kMostCompiled = 6;
    size_t stages = 0, spared = 0;
    for (uint64_t seed = first; seed < first + fablets; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        const std::string text = random_fablet(seed);
        const std::optional<ir::Module> module = compile_text(text);
        ASSERT_TRUE(module.has_value());
        const ir::Fablet& fablet = module->fablets[0];
        const StageInputs inputs = inputs_for(fablet, seed), others = inputs_for(fablet, ~seed);
        for (size_t k = 0; k < fablet.volume.outputs.size(); ++k) {
            SCOPED_TRACE(::testing::Message() << "program " << k);
            const ir::Stage stage = program_of(fablet, k);
            ir::Stage demand = passes::form_demand(stage);
            ASSERT_EQ(ir::verify(demand), "") << ir::dump(demand);
            if (demand.outputs.empty()) continue;
            const StageResults asked = interpret(demand, inputs);
            StageInputs replaced = inputs;
            for (auto& [key, bits] : replaced.values) {
                if (key[0] != OPENFAB_ARG_NEAREST && key[0] != OPENFAB_ARG_DISTANCE) continue;
                for (size_t v = 0; v < bits.size(); ++v) {
                    if (asked[0][v] == 0) bits[v] = others.values.at(key)[v];
                }
            }
            ASSERT_EQ(interpret(stage, inputs), interpret(stage, replaced))
                << text << ir::dump(stage) << ir::dump(demand);
            spared += static_cast<size_t>(std::count(asked[0].begin(), asked[0].end(), 0u));
            if (++stages > kMostCompiled) continue;
            passes::expand_functions(&demand);
            passes::TableFormer tables(fablet.uniform_value_count);
            tables.form(&demand);
            passes::KernelStages with_tables;
            with_tables.table_values = tables.values();
            StageInputs with_values = inputs;
            add_tables(fablet, with_tables, &with_values);
            for (const openfab_isa isa : {OPENFAB_ISA_SSE41, OPENFAB_ISA_AVX2}) {
                lower::ProgramOptions options;
                options.isas = {isa};
                const std::unique_ptr<CompiledStage> compiled =
                    CompiledStage::make(demand, options);
                ASSERT_NE(compiled, nullptr);
                expect_equal(demand, asked, compiled->run(isa, with_values), "compiled");
            }
        }
    }
    // A demand that always holds is sound but useless.
    EXPECT_GT(stages * 5, fablets);
    EXPECT_GT(spared, 512u * fablets / 10);
}

TEST(Differential, FindsStayMended) {
    const std::filesystem::path folder = source_dir() / "tests/fuzz/differential/finds";
    size_t count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        if (entry.path().extension() != ".fl") continue;
        SCOPED_TRACE(entry.path().filename());
        check(read_file(entry.path()), 1);
        ++count;
    }
    EXPECT_GT(count, 0u);
}

}  // namespace
}  // namespace openfab::testing
