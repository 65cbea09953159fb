// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The interpreter in double against the one on bits.

#include <cmath>

#include "tests/support/derivatives/double_inputs.h"
#include "tests/unit/interp/fixture.h"

namespace openfab::testing {
namespace {

class Expression : public ::testing::TestWithParam<const char*> {};

TEST_P(Expression, IsTheSameInDouble) {
    const ir::Fablet fablet = compile(
        "fablet A { @uniform { float x = 0.7, y = 2.3, z = -1.4; int i = 7; uint n = 3000000000u; "
        "Material m; }\n"
        "float f() { return " +
        std::string(GetParam()) +
        "; }\n"
        "@Volume() { MaterialComposition mc; mc.Set(m, f()); return mc; } }");
    MapEnvironment bits;
    DoubleInputs doubles;
    doubles.set_defaults(fablet);
    for (const ir::Uniform& u : fablet.uniforms) {
        if (!u.default_bits.empty())
            bits.inputs[{OPENFAB_ARG_UNIFORM, u.first_index, 0}] = u.default_bits[0];
    }
    const float expected = as_float(interp::evaluate(fablet.volume, bits)[0]);
    const double got = interp::evaluate_double(fablet.volume, doubles)[0];
    EXPECT_NEAR(got, expected, 3e-6 * std::fabs(expected));
    // And not by rounding to float on the way.
    doubles.uniform(0) += 1e-10;
    const double moved = interp::evaluate_double(fablet.volume, doubles)[0];
    const bool has_x = std::string(GetParam()).find('x') != std::string::npos;
    EXPECT_EQ(moved != got, has_x);
}

INSTANTIATE_TEST_SUITE_P(
    All, Expression,
    ::testing::Values(
        "x * y - z / (x + 3)", "fmod(y, x) + min(x, z) + max(x, y) + abs(x * z)",
        "sin(x) + cos(x) * tan(x)", "asin(x) + acos(x) + atan(x) + atan2(x, y)",
        "sinh(x) + cosh(x) + tanh(x) + exp(x) + exp2(x)", "log(x) + log2(x) + log10(x)",
        "pow(x, y) + cbrt(x) + sqrt(x)",
        "noise(x * 9) + noise(float2(x, y)) + noise(float3(x, y, z))",
        "noise(float4(x, y, z, 0.4)) + pnoise(float2(x, y), int2(2, 3))",
        "simplex(float2(x, y)) + simplex(float3(x, y, z)) + simplex(float4(x, y, z, 1))",
        "cellular(float2(x, y)).x + cellular(float3(x, y, z)).y",
        "noise_gradient(float3(x, y, z)).x",
        "floor(y) + ceil(z) + round(y) + trunc(z) + float(int(y)) + x",
        "float(i / 2 - 5) + float(n >> 3) + float(n)", "hash(i) + float(int(n)) + (n > 5u ? 1 : 2)",
        "x < y ? x : z"));

}  // namespace
}  // namespace openfab::testing
