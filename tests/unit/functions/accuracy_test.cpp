// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Errors of the functions in units in the last place of the exact result, against MPFR, over
// floats of every size. The bounds are what compiler/functions/README.md states; over all floats
// they were measured with OPENFAB_SWEEP=1 in the environment, which takes about an
// hour a function.

#include <gtest/gtest.h>
#include <mpfr.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>

#include "compiler/functions/exponential.h"
#include "compiler/functions/trigonometry.h"

namespace openfab::functions {

namespace {

#ifdef OPENFAB_SANITIZED
constexpr uint64_t kStride = 1000003;
constexpr int kPairs = 20000;
#else
constexpr uint64_t kStride = 40009;
constexpr int kPairs = 150000;
#endif
constexpr double kWrong = 1e30;  // a NaN or an infinity where there should be none, or the reverse

class Exact {
  public:
    explicit Exact(mpfr_prec_t bits) { mpfr_init2(value, bits); }
    ~Exact() { mpfr_clear(value); }
    Exact(const Exact&) = delete;
    Exact& operator=(const Exact&) = delete;
    mpfr_t value;
};

/// For a result that rounds to a denormal, an ulp is the smallest denormal.
double error_in_ulp(float got, const Exact& exact) {
    const float nearest = mpfr_get_flt(exact.value, MPFR_RNDN);
    if (std::isnan(got) || std::isnan(nearest)) {
        return std::isnan(got) == std::isnan(nearest) ? 0.0 : kWrong;
    }
    if (std::isinf(got) || std::isinf(nearest)) return got == nearest ? 0.0 : kWrong;
    int exponent = -149;
    if (nearest != 0.0f) exponent = std::max(std::ilogb(nearest) - 23, -149);
    Exact difference(120);
    mpfr_set_flt(difference.value, got, MPFR_RNDN);
    mpfr_sub(difference.value, difference.value, exact.value, MPFR_RNDN);
    mpfr_mul_2si(difference.value, difference.value, -exponent, MPFR_RNDN);
    return std::abs(mpfr_get_d(difference.value, MPFR_RNDN));
}

struct OneArgument {
    const char* name;
    float (*ours)(float);
    int (*theirs)(mpfr_ptr, mpfr_srcptr, mpfr_rnd_t);
    double bound;
    float limit;  ///< up to here
};

class AccuracyTest : public ::testing::TestWithParam<OneArgument> {};

TEST_P(AccuracyTest, IsWithinItsBound) {
    const OneArgument& f = GetParam();
    const bool sweep = std::getenv("OPENFAB_SWEEP") != nullptr;
    Exact x(24);
    Exact exact(80);
    double worst = 0;
    float at = 0;
    for (uint64_t bits = 0; bits < (uint64_t{1} << 32); bits += sweep ? 1 : kStride) {
        const float argument = ir::as_float(static_cast<uint32_t>(bits));
        if (std::isnan(argument) || std::abs(argument) > f.limit) continue;
        mpfr_set_flt(x.value, argument, MPFR_RNDN);
        f.theirs(exact.value, x.value, MPFR_RNDN);
        const double error = error_in_ulp(f.ours(argument), exact);
        if (error <= worst) continue;
        worst = error;
        at = argument;
    }
    RecordProperty("worst", std::to_string(worst));
    EXPECT_LE(worst, f.bound) << f.name << " of " << at;
    // A loose bound was not measured.
    if (sweep) {
        std::printf("%s: %.3f ulp at %a\n", f.name, worst, static_cast<double>(at));
    }
}

constexpr float kAll = std::numeric_limits<float>::infinity();
constexpr float kAngles = 32768.0f;

INSTANTIATE_TEST_SUITE_P(All, AccuracyTest,
                         ::testing::Values(OneArgument{"sin", sin<Plain>, mpfr_sin, 1.6, kAngles},
                                           OneArgument{"cos", cos<Plain>, mpfr_cos, 1.6, kAngles},
                                           OneArgument{"tan", tan<Plain>, mpfr_tan, 3.3, kAngles},
                                           OneArgument{"asin", asin<Plain>, mpfr_asin, 1.2, kAll},
                                           OneArgument{"acos", acos<Plain>, mpfr_acos, 1.2, kAll},
                                           OneArgument{"atan", atan<Plain>, mpfr_atan, 2.0, kAll},
                                           OneArgument{"sinh", sinh<Plain>, mpfr_sinh, 1.7, kAll},
                                           OneArgument{"cosh", cosh<Plain>, mpfr_cosh, 1.6, kAll},
                                           OneArgument{"tanh", tanh<Plain>, mpfr_tanh, 1.6, kAll},
                                           OneArgument{"exp", exp<Plain>, mpfr_exp, 1.1, kAll},
                                           OneArgument{"exp2", exp2<Plain>, mpfr_exp2, 1.1, kAll},
                                           OneArgument{"log", log<Plain>, mpfr_log, 1.0, kAll},
                                           OneArgument{"log2", log2<Plain>, mpfr_log2, 1.0, kAll},
                                           OneArgument{"log10", log10<Plain>, mpfr_log10, 1.0,
                                                       kAll},
                                           OneArgument{"cbrt", cbrt<Plain>, mpfr_cbrt, 1.0, kAll}),
                         [](const auto& info) { return std::string(info.param.name); });

float any_float(std::mt19937* random) {
    return ir::as_float(static_cast<uint32_t>((*random)()));
}

/// Pairs of every kind; pairs whose power is of moderate size; bases near 1.
TEST(Accuracy, Pow) {
    std::mt19937 random(5);
    Exact x(24);
    Exact y(24);
    Exact exact(80);
    double worst = 0;
    float at_x = 0;
    float at_y = 0;
    for (int k = 0; k < kPairs; ++k) {
        float a = any_float(&random);
        float b = any_float(&random);
        const float exponent = static_cast<float>(random() >> 8) * (300.0f * 0x1p-24f) - 150.0f;
        if (k % 3 == 1) b = exponent / log2<Plain>(std::abs(a));
        if (k % 3 == 2) {
            a = 1.0f +
                static_cast<float>(static_cast<int>(random() % 8000001) - 4000000) * 0x1p-23f;
            b = exponent / log2<Plain>(a);
        }
        if (k % 30 == 0) b = std::round(b);
        mpfr_set_flt(x.value, a, MPFR_RNDN);
        mpfr_set_flt(y.value, b, MPFR_RNDN);
        mpfr_pow(exact.value, x.value, y.value, MPFR_RNDN);
        const double error = error_in_ulp(pow<Plain>(a, b), exact);
        if (error <= worst) continue;
        worst = error;
        at_x = a;
        at_y = b;
    }
    EXPECT_LE(worst, 2.5) << at_x << ", " << at_y;
}

TEST(Accuracy, Atan2) {
    std::mt19937 random(6);
    Exact x(24);
    Exact y(24);
    Exact exact(80);
    double worst = 0;
    for (int k = 0; k < kPairs; ++k) {
        const float a = any_float(&random);
        float b = any_float(&random);
        if (k % 2 == 0) {
            b = a * std::ldexp(static_cast<float>(random() >> 8) * 0x1p-24f - 0.5f, k % 12);
        }
        mpfr_set_flt(y.value, a, MPFR_RNDN);
        mpfr_set_flt(x.value, b, MPFR_RNDN);
        mpfr_atan2(exact.value, y.value, x.value, MPFR_RNDN);
        worst = std::max(worst, error_in_ulp(atan2<Plain>(a, b), exact));
    }
    EXPECT_LE(worst, 2.0);
}

TEST(Accuracy, LargeAnglesStayInRange) {
    std::mt19937 random(8);
    for (int k = 0; k < kPairs; ++k) {
        const float x = any_float(&random);
        if (!std::isfinite(x)) continue;
        EXPECT_LE(std::abs(sin<Plain>(x)), 1.0f) << x;
        EXPECT_LE(std::abs(cos<Plain>(x)), 1.0f) << x;
    }
}

/// cmath follows IEEE 754 here; compared including the sign of 0, with all NaNs equal.
void expect_same(float got, float right, const char* name, float x, float y = 0) {
    const bool same = std::isnan(right) ? std::isnan(got) : ir::as_bits(got) == ir::as_bits(right);
    EXPECT_TRUE(same) << name << '(' << x << ", " << y << ") = " << got << ", not " << right;
}

const std::vector<float>& special() {
    static const std::vector<float> values = {0.0f, -0.0f, kInfinity, -kInfinity, kNan};
    return values;
}

TEST(SpecialValues, OneArgument) {
    struct Pair {
        const char* name;
        float (*ours)(float);
        float (*theirs)(float);
    };
    const Pair pairs[] = {
        {"sin", sin<Plain>, std::sin},    {"tan", tan<Plain>, std::tan},
        {"asin", asin<Plain>, std::asin}, {"sinh", sinh<Plain>, std::sinh},
        {"tanh", tanh<Plain>, std::tanh}, {"exp", exp<Plain>, std::exp},
        {"exp2", exp2<Plain>, std::exp2}, {"log", log<Plain>, std::log},
        {"log2", log2<Plain>, std::log2}, {"log10", log10<Plain>, std::log10},
        {"cbrt", cbrt<Plain>, std::cbrt}, {"cos", cos<Plain>, std::cos},
        {"cosh", cosh<Plain>, std::cosh},
    };
    for (const Pair& pair : pairs) {
        for (const float x : special())
            expect_same(pair.ours(x), pair.theirs(x), pair.name, x);
        for (const float x : {-1.5f, 1.5f}) {
            EXPECT_EQ(std::isnan(pair.ours(x)), std::isnan(pair.theirs(x))) << pair.name;
        }
    }
    EXPECT_EQ(exp<Plain>(0.0f), 1.0f);
    EXPECT_EQ(exp2<Plain>(-149.0f), 0x1p-149f);
    EXPECT_EQ(exp2<Plain>(10.0f), 1024.0f);
    EXPECT_EQ(log2<Plain>(0x1p-149f), -149.0f);
    EXPECT_EQ(log10<Plain>(1000.0f), 3.0f);
    EXPECT_EQ(log<Plain>(1.0f), 0.0f);
    EXPECT_EQ(acos<Plain>(1.0f), 0.0f);
    EXPECT_TRUE(std::isnan(acos<Plain>(1.0001f)));
    EXPECT_EQ(cbrt<Plain>(-27.0f), -3.0f);
}

TEST(SpecialValues, Pow) {
    std::vector<float> values = special();
    for (const float x : {1.0f, -1.0f, 2.0f, -2.0f, 0.5f, -0.5f, 3.0f, -3.0f, 2.5f, -2.5f, 1e38f,
                          -1e38f, 1e-40f, -1e-40f, 16777215.0f, -16777217.0f}) {
        values.push_back(x);
    }
    for (const float x : values) {
        for (const float y : values) {
            const float right = std::pow(x, y);
            const float got = pow<Plain>(x, y);
            if (std::isfinite(right) && right != 0.0f) {
                EXPECT_NEAR(got / right, 1.0, 4e-7) << x << ", " << y;
            } else {
                expect_same(got, right, "pow", x, y);
            }
        }
    }
    EXPECT_EQ(pow<Plain>(10.0f, 3.0f), 1000.0f);
    EXPECT_EQ(pow<Plain>(-3.0f, 3.0f), -27.0f);
}

TEST(SpecialValues, Atan2) {
    std::vector<float> values = special();
    for (const float x : {1.0f, -1.0f, 1e38f, -1e38f, 1e-40f, -1e-40f})
        values.push_back(x);
    for (const float y : values) {
        for (const float x : values) {
            const float right = std::atan2(y, x);
            if (std::isnan(right) || right == 0.0f) {
                expect_same(atan2<Plain>(y, x), right, "atan2", y, x);
            } else {
                EXPECT_NEAR(atan2<Plain>(y, x) / right, 1.0, 4e-7) << y << ", " << x;
            }
        }
    }
}

}  // namespace

}  // namespace openfab::functions
