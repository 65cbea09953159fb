// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Derivatives of random fablets against central differences of the interpreter in double. 500 programs unless
// OPENFAB_PROGRAMS says otherwise; OPENFAB_SEED is the first seed.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <random>

#include "compiler/diag/render.h"
#include "compiler/frontend/frontend.h"
#include "compiler/passes/form_jacobian.h"
#include "tests/fuzz/differential/random_fablet.h"
#include "tests/support/derivatives/double_inputs.h"
#include "tests/support/places/places.h"

namespace openfab::testing {
namespace {

uint64_t from_environment(const char* name, uint64_t otherwise) {
    const char* text = std::getenv(name);
    return text == nullptr ? otherwise : std::strtoull(text, nullptr, 10);
}

ir::Fablet compile_text(const std::string& text) {
    source::SourceManager sources;
    diag::Sink sink;
    std::optional<ir::Module> module =
        frontend::compile_to_ir(sources, sources.add("random.fl", text), sink);
    EXPECT_TRUE(module.has_value()) << diag::render_text(sink, sources) << text;
    return module ? std::move(module->fablets[0]) : ir::Fablet{};
}

/// A program of the fablet and a constant: two materials, so that fractions differ.
ir::Fablet one_program(const ir::Fablet& fablet, int program) {
    ir::Fablet out = fablet;
    out.volume.outputs = {fablet.volume.outputs[static_cast<size_t>(program)]};
    out.volume.outputs[0].a = 0;
    ir::Builder builder(&out.volume);
    out.volume.outputs.push_back({"rest", OPENFAB_ARG_WEIGHT, 1, 0, builder.constant(2.5f)});
    out.slot_count = 2;
    ir::drop_dead_values(&out.volume);
    return out;
}

DoubleInputs random_inputs(const ir::Fablet& fablet, uint64_t seed) {
    std::mt19937_64 random(seed);
    const auto number = [&] { return static_cast<double>(random() >> 11) * 0x1p-52 * 3 - 3; };
    DoubleInputs out;
    out.set_defaults(fablet);
    // Away from whole numbers, where most of the language's functions have a kink.
    for (auto& [key, value] : out.numbers)
        value += 0.001 * number();
    out.numbers[{OPENFAB_ARG_UNIFORM, 8, 0}] = 7.3;  // 1e20 hides all else
    for (int32_t k = 0; k < OPENFAB_FRAME_COUNT; ++k)
        out.numbers[{OPENFAB_ARG_FRAME, k, 0}] = number();
    for (int32_t k = 0; k < 3; ++k)
        out.numbers[{ir::kVoxelCoord, k, 0}] = number();
    out.numbers[{OPENFAB_ARG_DISTANCE, 0, 0}] = number();
    for (int32_t n = 0; n < 2; ++n) {
        for (int32_t c = 0; c < 4; ++c)
            out.numbers[{OPENFAB_ARG_NEAREST, n, c}] = n == 0 ? number() : 5 + std::floor(number());
    }
    return out;
}

/// Beside a number like 3.4e38 no difference is left of a change, in double either.
bool has_vast_numbers(const ir::Stage& stage) {
    return std::any_of(stage.instrs.begin(), stage.instrs.end(), [](const ir::Instr& i) {
        return i.op == ir::Op::kConst && i.type == ir::Type::kFloat &&
               std::fabs(ir::as_float(i.bits)) > 1e9f;
    });
}

std::vector<int32_t> float_uniforms(const ir::Fablet& fablet) {
    std::vector<int32_t> out;
    for (const ir::Uniform& u : fablet.uniforms) {
        if (u.type != ir::Type::kFloat || u.kind != OPENFAB_UNIFORM_VALUE) continue;
        for (int32_t k = 0; k < u.components * u.array_length; ++k)
            out.push_back(u.first_index + k);
    }
    return out;
}

TEST(RandomDerivatives, AreCentralDifferences) {
    const uint64_t seed = from_environment("OPENFAB_SEED", 1);
    const uint64_t programs = from_environment("OPENFAB_PROGRAMS", 500);
    int compared = 0, moving = 0, bent = 0;
    for (uint64_t k = 0; k * kProgramsPerFablet < programs; ++k) {
        const ir::Fablet whole = compile_text(random_fablet(seed + k));
        const std::vector<int32_t> uniforms = float_uniforms(whole);
        for (int program = 0; program < kProgramsPerFablet; ++program) {
            const ir::Fablet fablet = one_program(whole, program);
            if (has_vast_numbers(fablet.volume)) continue;
            // Those that the program reads first.
            std::vector<int32_t> some = uniforms;
            const auto is_read = [&](int32_t u) {
                return std::any_of(fablet.volume.instrs.begin(), fablet.volume.instrs.end(),
                                   [&](const ir::Instr& i) {
                                       return i.op == ir::Op::kInput &&
                                              i.kind == OPENFAB_ARG_UNIFORM && i.a == u;
                                   });
            };
            std::stable_partition(some.begin(), some.end(), is_read);
            some.resize(passes::kMostDirections);
            std::vector<passes::Direction> directions;
            for (const int32_t u : some)
                directions.push_back({{{u, -1}}});
            const passes::Jacobian jacobian = passes::form_jacobian(fablet, directions);
            ASSERT_TRUE(jacobian.none.empty());
            ASSERT_EQ(ir::verify(jacobian.stage), "");
            for (uint64_t voxel = 0; voxel < 3; ++voxel) {
                const DoubleInputs inputs = random_inputs(fablet, 100 * (seed + k) + voxel);
                const std::vector<double> got = interp::evaluate_double(jacobian.stage, inputs);
                for (size_t d = 0; d < some.size(); ++d) {
                    if (!is_read(some[d])) continue;
                    const auto expected = differences(fablet.volume, inputs, some[d]);
                    if (!expected) {
                        ++bent;
                        continue;
                    }
                    for (size_t slot = 0; slot < 2; ++slot) {
                        const double mine = got[2 * (1 + d) + slot], other = (*expected)[slot];
                        ++compared;
                        moving += std::fabs(other) > 1e-9 ? 1 : 0;
                        EXPECT_NEAR(mine, other, 1e-4 * std::max(std::fabs(other), 1e-3))
                            << "seed " << seed + k << ", program " << program << ", uniform "
                            << some[d] << ", voxel " << voxel;
                        if (HasFailure()) return;
                    }
                }
            }
        }
    }
    EXPECT_GT(moving, compared / 50) << compared << " compared, " << bent << " bent";
    RecordProperty("compared", compared);
    RecordProperty("moving", moving);
    RecordProperty("bent", bent);
}

/// A ball about the part's centre, as the nearest-point engine would answer.
double ball(int32_t kind, int32_t axis, std::span<const double, 3> p) {
    const double radius = std::hypot(p[0], p[1], p[2]);
    if (kind == OPENFAB_QUERY_DISTANCE) return radius - 7;
    if (kind == OPENFAB_QUERY_ATTRIBUTE) return 0.5;
    const double unit = p[static_cast<size_t>(axis)] / radius;
    return kind == OPENFAB_QUERY_NORMAL ? unit : 7 * unit;
}

class GalleryDerivatives : public ::testing::TestWithParam<std::filesystem::path> {};

TEST_P(GalleryDerivatives, AreCentralDifferencesWhereSmooth) {
    source::SourceManager sources;
    diag::Sink sink;
    std::string fault;
    std::optional<ir::Module> module =
        frontend::compile_to_ir(sources, GetParam(), sink, &fault, {.need_fablet = false});
    ASSERT_TRUE(module.has_value()) << diag::render_text(sink, sources) << fault;
    if (module->fablets.empty()) GTEST_SKIP() << "a module of functions";
    int compared = 0, bent = 0;
    for (const ir::Fablet& fablet : module->fablets) {
        for (const int32_t uniform : float_uniforms(fablet)) {
            const std::vector<passes::Direction> direction = {{{{uniform, -1}}}};
            const passes::Jacobian jacobian = passes::form_jacobian(fablet, direction);
            if (!jacobian.none.empty()) continue;  // said by name: tests/unit/passes
            ASSERT_EQ(ir::verify(jacobian.stage), "");
            for (uint64_t voxel = 0; voxel < 12; ++voxel) {
                DoubleInputs inputs = random_inputs(fablet, voxel);
                inputs.set_defaults(fablet);
                inputs.surface = ball;
                for (int32_t k = 0; k < 3; ++k) {
                    for (int32_t axis = 0; axis < 3; ++axis)
                        inputs.numbers[{OPENFAB_ARG_FRAME, 3 * k + axis, 0}] = k == axis ? 1 : 0;
                    inputs.numbers[{ir::kVoxelCoord, k, 0}] *= 3;
                }
                const std::vector<double> got = interp::evaluate_double(jacobian.stage, inputs);
                const auto expected = differences(fablet.volume, inputs, uniform);
                if (!expected) {
                    ++bent;
                    continue;
                }
                const double range = 1 / std::max(1.0, std::fabs(inputs.uniform(uniform)));
                for (size_t slot = 0; slot < expected->size(); ++slot) {
                    const double other = (*expected)[slot];
                    ++compared;
                    ASSERT_NEAR(got[expected->size() + slot], other,
                                1e-4 * std::max(std::fabs(other), range))
                        << fablet.name << ", value " << uniform << ", voxel " << voxel;
                }
            }
        }
    }
    EXPECT_GE(compared, bent) << "most places are smooth";
}

std::vector<std::filesystem::path> gallery() {
    std::vector<std::filesystem::path> out;
    for (const auto& entry :
         std::filesystem::recursive_directory_iterator(source_dir() / "gallery")) {
        if (entry.path().extension() == ".fl") out.push_back(entry.path());
    }
    std::ranges::sort(out);
    return out;
}

INSTANTIATE_TEST_SUITE_P(All, GalleryDerivatives, ::testing::ValuesIn(gallery()),
                         [](const auto& info) {
                             const auto& path = info.param;
                             return path.parent_path().filename().string() + "_" +
                                    path.stem().string();
                         });

}  // namespace
}  // namespace openfab::testing
