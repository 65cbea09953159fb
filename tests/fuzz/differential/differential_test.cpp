// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Random fablets: what the interpreter makes of the unoptimised stage, and what compiled code gives
// after all passes. 200 programs unless OPENFAB_PROGRAMS says otherwise; OPENFAB_SEED is the first
// seed. Fablets that found a fault once are in finds/.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <random>

#include "compiler/diag/render.h"
#include "compiler/driver/frontend.h"
#include "compiler/passes/pipeline.h"
#include "tests/exec/compiled_stage.h"
#include "tests/fuzz/differential/random_fablet.h"
#include "tests/support/process/process.h"

namespace openfab::testing {
namespace {

uint64_t from_environment(const char* name, uint64_t otherwise) {
    const char* text = std::getenv(name);
    return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

/// Values that programs stumble over, between plain ones.
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
    inputs.places = 1;
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

void check(const std::string& text, uint64_t seed) {
    source::SourceManager sources;
    diag::Sink sink;
    const uint32_t file = sources.add("random.fl", text);
    const std::optional<ir::Module> module = driver::compile_to_ir(sources, file, sink);
    ASSERT_TRUE(module.has_value()) << diag::render_text(sink, sources) << text;
    const ir::Fablet& fablet = module->fablets[0];
    ASSERT_EQ(ir::verify(fablet.volume), "") << text;
    const StageInputs inputs = inputs_for(fablet, seed);
    const StageResults expected = interpret(fablet.volume, inputs);
    const passes::PipelineResult made = passes::run_pipeline(fablet, {});
    ASSERT_EQ(made.fault, "") << text;
    // One instruction set for each: that both agree is what other tests are about.
    const openfab_isa isa = seed % 2 == 0 ? OPENFAB_ISA_SSE41 : OPENFAB_ISA_AVX2;
    lower::ProgramOptions options;
    options.isas = {isa};
    const std::unique_ptr<CompiledStage> compiled =
        CompiledStage::make(made.stages.volume, options);
    ASSERT_NE(compiled, nullptr) << text;
    expect_equal(made.stages.volume, expected, compiled->run(isa, inputs),
                 isa == OPENFAB_ISA_AVX2 ? "avx2" : "sse41");
    if (::testing::Test::HasFailure()) ADD_FAILURE() << text;
}

TEST(Differential, InterpreterAndCompiledCodeAgree) {
#ifdef OPENFAB_SANITIZED
    constexpr uint64_t kPrograms = 40;
#else
    constexpr uint64_t kPrograms = 200;
#endif
    const uint64_t programs = from_environment("OPENFAB_PROGRAMS", kPrograms);
    const uint64_t first = from_environment("OPENFAB_SEED", 1);
    const uint64_t fablets = (programs + kProgramsPerFablet - 1) / kProgramsPerFablet;
    for (uint64_t seed = first; seed < first + fablets; ++seed) {
        SCOPED_TRACE(::testing::Message() << "seed " << seed);
        check(random_fablet(seed), seed);
        if (HasFailure()) break;
    }
}

TEST(Differential, FindsStayMended) {
    const std::filesystem::path folder =
        std::filesystem::path(OPENFAB_SOURCE_DIR) / "tests/fuzz/differential/finds";
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
