// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The tracer against closed forms: Beer and Lambert's law, Fresnel's equations in a plate, Chandrasekhar's
// half-space, and a white furnace.

#include "tools/render/tracer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <vector>

#include "tests/unit/render/render_fixture.h"

namespace openfab::testing {
namespace {

using render::MaterialOptics;
using render::Optics;
using render::Random;
using render::Rgb;
using render::Tracer;
using render::Volume;

constexpr double kErrors = 4.5;  ///< standard errors that a mean may be off: one in 10^5 is

const Vec3d kDown{0, 0, -1};

auto always(const Vec3d& direction) {
    return [direction](Random*) { return direction; };
}

Volume block(const Vec3i& size, double pitch_mm) {
    return make_volume(size, {pitch_mm, pitch_mm, pitch_mm},
                       [](int32_t, int32_t, int32_t) { return uint8_t{1}; });
}

TEST(Tracer, AbsorbsAsBeerAndLambertSay) {
    const Volume volume = block({40, 40, 20}, 0.1);
    const MaterialOptics dye{{0.2, 0.7, 1.5}, {0, 0, 0}, 0};
    const Tracer tracer(&volume, make_optics({dye}), white_room());
    for (const double slant : {0.0, 0.5}) {
        const Vec3d aim = render::normalized(Vec3d{slant, 0, -1});
        const Estimate got = estimate(tracer, 20000, {0.5, 2.03, 5}, always(aim));
        for (size_t c = 0; c < 3; ++c) {
            const double expected = std::exp(-dye.extinction[c] * 2 / -aim.z);
            EXPECT_NEAR(got.mean[c], expected, kErrors * got.error[c] + 1e-3) << c;
            EXPECT_LT(got.error[c], 0.01);
        }
    }
}

// Dots much smaller than a free path mix. Taken together, they must not become dots as large as a cell.
TEST(Tracer, SeesTheToneOfDotsInLargerCells) {
    const auto dots = [](int32_t x, int32_t y, int32_t z) {
        return static_cast<uint8_t>(1 + (x * 7 + y * 5 + z * 3) % 8 / 7);
    };
    const MaterialOptics white{{10, 10, 10}, {0.999, 0.99, 0.9}, 0};
    const MaterialOptics black{{10, 10, 10}, {0, 0, 0}, 0};
    const Optics optics = make_optics({white, black, {}, {}, {}}, 1.5);
    const Vec3i size{192, 192, 96};
    const double pitch = 0.01;
    const auto look = [&](const Volume& volume, const Optics& of) {
        const Tracer tracer(&volume, of, white_room());
        return estimate(tracer, 20000, {0.93, 0.97, 3}, always(kDown));
    };
    const Estimate own = look(make_volume(size, {pitch, pitch, pitch}, dots), optics);
    const render::Mixtures mixtures(5);
    const Estimate coarse =
        look(make_volume(size, {pitch, pitch, pitch}, dots, {12, 12, 12}),
             render::optics_of_mixtures(optics, {1, 2, 3, 4, 5}, mixtures.by_code()));
    for (size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(coarse.mean[c], own.mean[c], 0.04 * own.mean[c] + kErrors * coarse.error[c])
            << c;
}

TEST(Tracer, AddsUpWhatAMixedColumnAbsorbs) {
    const auto code = [](int32_t, int32_t, int32_t z) {
        return static_cast<uint8_t>(z % 3 == 0 ? 1 : 2);
    };
    const Volume volume = make_volume({40, 40, 21}, {0.1, 0.1, 0.1}, code);
    const MaterialOptics a{{2, 0.5, 0}, {0, 0, 0}, 0};
    const MaterialOptics b{{0.1, 0.9, 0.4}, {0, 0, 0}, 0};
    const Tracer tracer(&volume, make_optics({a, b}), white_room());
    const Estimate got = estimate(tracer, 20000, {2.01, 2.03, 5}, always(kDown));
    for (size_t c = 0; c < 3; ++c) {
        const double expected = std::exp(-0.7 * a.extinction[c] - 1.4 * b.extinction[c]);
        EXPECT_NEAR(got.mean[c], expected, kErrors * got.error[c] + 1e-3) << c;
    }
}

TEST(Tracer, LosesWhatAPlateReflects) {
    constexpr double kIndex = 1.5;
    const Volume volume = block({60, 60, 20}, 0.1);
    const MaterialOptics dye{{0, 0.3, 0.8}, {0, 0, 0}, 0};
    render::Scene scene = white_room();
    // Light from below alone: what is reflected is dark.
    scene.light.dome = {0, 0, 0};
    scene.light.lamps.push_back({kDown, std::cos(0.5), {1, 1, 1}});
    const Tracer tracer(&volume, make_optics({dye}, kIndex), scene);
    const Estimate got = estimate(tracer, 40000, {3.02, 3.03, 5}, always(kDown));
    const double r = std::pow((kIndex - 1) / (kIndex + 1), 2);
    for (size_t c = 0; c < 3; ++c) {
        const double a = std::exp(-2 * dye.extinction[c]);
        // All the ways to and fro in the plate.
        const double expected = (1 - r) * (1 - r) * a / (1 - r * r * a * a);
        EXPECT_NEAR(got.mean[c], expected, kErrors * got.error[c]) << c;
    }
}

TEST(Tracer, RefractsAsSnellSays) {
    constexpr double kIndex = 1.5;
    const Volume volume = block({80, 40, 20}, 0.1);
    render::Scene scene = white_room();
    const double angle = 0.7;
    const Vec3d aim{std::sin(angle), 0, -std::cos(angle)};
    // Through parallel faces a ray goes on as it came. The lamp is 0.4 degrees wide.
    scene.light.dome = {0, 0, 0};
    scene.light.lamps.push_back({aim, std::cos(0.0035), {1, 1, 1}});
    const Tracer tracer(&volume, make_optics({MaterialOptics{}}, kIndex), scene);
    const Estimate got = estimate(tracer, 20000, {3.0 - 3 * std::tan(angle), 2.03, 5}, always(aim));
    const double sine = std::sin(angle) / kIndex;
    const double ci = std::cos(angle);
    const double ct = std::sqrt(1 - sine * sine);
    const double s = (ci - kIndex * ct) / (ci + kIndex * ct);
    const double p = (kIndex * ci - ct) / (kIndex * ci + ct);
    const double r = 0.5 * (s * s + p * p);
    // Each way within is drawn by the same unpolarised share.
    EXPECT_NEAR(got.mean[0], (1 - r) / (1 + r), kErrors * got.error[0]);
    EXPECT_GT(got.mean[0], 0.8);
}

/// A ball, seen from all sides, of what absorbs nothing.
TEST(Tracer, LosesNothingInAWhiteFurnace) {
    const auto ball = [](int32_t x, int32_t y, int32_t z) {
        const Vec3d at{x - 15.5, y - 15.5, z - 15.5};
        return static_cast<uint8_t>(length(at) < 14 ? 1 : 0);
    };
    const Volume volume = make_volume({32, 32, 32}, {0.05, 0.05, 0.05}, ball);
    const auto aim = [](Random* random) {
        const Vec3d at{0.8 + 0.7 * (2 * random->uniform() - 1),
                       0.8 + 0.7 * (2 * random->uniform() - 1), 0.8};
        return render::normalized(at - Vec3d{0.8, 0.8, 5});
    };
    // Of one extinction every path brings 1 but for rounding, if it is not played for; colours do so on average.
    const MaterialOptics grey{{8, 8, 8}, {1, 1, 1}, 0.3};
    const MaterialOptics colored{{3, 8, 20}, {1, 1, 1}, 0};
    for (const double index : {1.0, 1.5}) {
        const Tracer plain(&volume, make_optics({grey}, index), white_room());
        const Estimate exact = estimate(plain, 3000, {0.8, 0.8, 5}, aim);
        for (size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(exact.mean[c], 1, 1e-4 + kErrors * exact.error[c]);
        EXPECT_LT(exact.error[0], 0.01);
        const Tracer spectral(&volume, make_optics({colored}, index), white_room());
        const Estimate got = estimate(spectral, 6000, {0.8, 0.8, 5}, aim);
        for (size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(got.mean[c], 1, kErrors * got.error[c]) << index << " " << c;
    }
    // Facets that hide each other take nothing away, either.
    const Tracer rough(&volume, make_optics({grey}, 1.5, 0.3), white_room());
    const Estimate got = estimate(rough, 3000, {0.8, 0.8, 5}, aim);
    EXPECT_NEAR(got.mean[0], 1, 1e-4 + kErrors * got.error[0]);
}

/// Chandrasekhar's H function of isotropic scattering, by iteration of its integral equation (Radiative
/// Transfer, 1950, chapter V): the reflectance of a half-space that is lit from everywhere, seen along
/// a direction of cosine mu, is 1 - H(mu) sqrt(1 - albedo).
double half_space_reflectance(double albedo, double mu) {
    constexpr int kNodes = 400;
    const auto node = [](int i) { return (i + 0.5) / kNodes; };
    std::vector<double> h(kNodes, 1.0);
    const double root = std::sqrt(1 - albedo);
    const auto integral = [&](double m) {
        double sum = 0;
        for (int i = 0; i < kNodes; ++i)
            sum += node(i) * h[static_cast<size_t>(i)] / (m + node(i)) / kNodes;
        return sum;
    };
    for (int pass = 0; pass < 100; ++pass) {
        std::vector<double> next;
        for (int i = 0; i < kNodes; ++i)
            next.push_back(1 / (root + 0.5 * albedo * integral(node(i))));
        h = next;
    }
    return 1 - root / (root + 0.5 * albedo * integral(mu));
}

TEST(Tracer, ReflectsAsChandrasekharsHalfSpace) {
    // 80 free paths wide or more, 40 deep. The reflectance depends on the albedo alone.
    const Volume volume = block({80, 80, 40}, 0.1);
    const MaterialOptics resin{{10, 14, 20}, {0.5, 0.97, 0.9}, 0};
    const Tracer tracer(&volume, make_optics({resin}), white_room());
    for (const double mu : {1.0, 0.5}) {
        const Vec3d aim{std::sqrt(1 - mu * mu), 0, -mu};
        const Vec3d from = Vec3d{4.02, 4.03, 4} - aim * 3.0;
        const Estimate got = estimate(tracer, 20000, from, always(aim));
        for (size_t c = 0; c < 3; ++c) {
            EXPECT_NEAR(got.mean[c], half_space_reflectance(resin.albedo[c], mu),
                        kErrors * got.error[c] + 1e-3)
                << mu << " " << c;
        }
        EXPECT_LT(got.error[1], 0.01);
    }
}

/// Van de Hulst's fit for the albedo of a half-space that is lit from everywhere, anisotropic too; he
/// states an error of 0.002 (Multiple Light Scattering, 1980).
TEST(Tracer, ReflectsAsVanDeHulstsFit) {
    const Volume volume = block({100, 100, 60}, 0.1);
    for (const double g : {0.0, 0.5}) {
        const double albedo = 0.9;
        const MaterialOptics resin{{20, 20, 20}, {albedo, albedo, albedo}, g};
        const Tracer tracer(&volume, make_optics({resin}), white_room());
        // The mean over the hemisphere, each direction by its cosine, all to one place.
        const Estimate got = estimate_from(
            tracer, 20000,
            [](const Vec3d& aim) {
                return Vec3d{5.02, 5.03, 6} - aim * 3.0;
            },
            [](Random* random) {
                return random->around(kDown, std::sqrt(0.0025 + 0.9975 * random->uniform()));
            },
            3);
        const double s = std::sqrt((1 - albedo) / (1 - g * albedo));
        const double expected = (1 - s) * (1 - 0.139 * s) / (1 + 1.17 * s);
        EXPECT_NEAR(got.mean[0], expected, kErrors * got.error[0] + 0.004) << g;
        EXPECT_LT(got.error[0], 0.004);
    }
}

TEST(Tracer, IsTheSameWithLargerMacrocells) {
    // Dense and thin materials, mixed voxel by voxel in a ball.
    const auto mixed = [](int32_t x, int32_t y, int32_t z) {
        const Vec3d at{x - 19.5, y - 19.5, z - 19.5};
        if (length(at) >= 18) return uint8_t{0};
        return static_cast<uint8_t>(1 + (x * 7 + y * 5 + z * 3) % 4 / 2 + (x > 20 ? 1 : 0));
    };
    const Volume volume = make_volume({40, 40, 40}, {0.05, 0.05, 0.05}, mixed);
    const Optics optics = make_optics({{{1, 2, 3}, {0.9, 0.5, 0.2}, 0},
                                       {{9, 6, 4}, {0.98, 0.99, 0.9}, 0},
                                       {{30, 30, 3}, {0.9, 0.4, 0.9}, 0.5}},
                                      1.4);
    std::vector<Estimate> all;
    for (const int32_t blocks : {1, 2, 4}) {
        const Tracer tracer(&volume, optics, white_room(), blocks);
        all.push_back(estimate(
            tracer, 20000, {1.03, 1.02, 5},
            [](Random* random) {
                return render::normalized(
                    Vec3d{0.2 * random->uniform() - 0.1, 0.2 * random->uniform() - 0.1, -1});
            },
            static_cast<uint64_t>(blocks)));
    }
    for (size_t i = 1; i < all.size(); ++i) {
        for (size_t c = 0; c < 3; ++c) {
            const double error = std::hypot(all[0].error[c], all[i].error[c]);
            EXPECT_NEAR(all[i].mean[c], all[0].mean[c], kErrors * error) << i << " " << c;
            EXPECT_LT(error, 0.01);
        }
    }
}

/// A ball of mixed materials, one of which scatters forwards.
struct MixedBall {
    Volume volume =
        make_volume({40, 40, 40}, {0.05, 0.05, 0.05}, [](int32_t x, int32_t y, int32_t z) {
            const Vec3d at{x - 19.5, y - 19.5, z - 19.5};
            return static_cast<uint8_t>(length(at) < 18 ? 1 + (x + 2 * y + 3 * z) % 3 : 0);
        });
    Optics optics = make_optics(
        {{{6, 9, 24}, {0.99, 0.98, 0.97}, 0}, {{9, 6, 4}, {0.9, 0.99, 0.9}, 0.6}, {}}, 1.4);

    /// The light of each path.
    std::vector<Rgb> trace(int32_t count, int instruction_set) const {
        const Tracer tracer(&volume, optics, white_room(), 1, instruction_set);
        std::vector<Rgb> out(static_cast<size_t>(count));
        const auto start = [](int32_t path) {
            Random random(4, 0, static_cast<uint64_t>(path));
            const Vec3d to{0.3 + 1.4 * random.uniform(), 0.3 + 1.4 * random.uniform(), 1};
            return render::PathStart{{1, 1, 5}, render::normalized(to - Vec3d{1, 1, 5}), random};
        };
        tracer.trace(
            count, std::atomic<bool>(false), start,
            [&](int32_t path, const Rgb& light, bool) { out[static_cast<size_t>(path)] = light; });
        return out;
    }
};

TEST(Tracer, IsTheSameForAllInstructionSets) {
    const MixedBall ball;
    const std::vector<Rgb> plain = ball.trace(500, 0);
    for (const int set : {1, 2})
        EXPECT_EQ(ball.trace(500, set), plain) << set;
}

TEST(Tracer, TracesAPathTheSameBesideAnyOthers) {
    const MixedBall ball;
    const std::vector<Rgb> all = ball.trace(100, 2);
    for (const int32_t count : {1, 7, 16, 17, 40}) {
        const std::vector<Rgb> some = ball.trace(count, 2);
        EXPECT_TRUE(std::equal(some.begin(), some.end(), all.begin())) << count;
    }
}

TEST(Tracer, StopsWhereItIsTold) {
    const Volume volume = block({40, 40, 20}, 0.1);
    const Tracer tracer(&volume, make_optics({{{6, 9, 24}, {1, 1, 1}, 0}}), white_room());
    std::atomic<bool> stop = false;
    int32_t traced = 0;
    const auto start = [&](int32_t path) {
        if (path == 50) stop = true;
        return render::PathStart{{2.03, 2.02, 5}, kDown, Random(1, 0, static_cast<uint64_t>(path))};
    };
    EXPECT_FALSE(tracer.trace(100000, stop, start, [&](int32_t, const Rgb&, bool) { ++traced; }));
    EXPECT_EQ(traced, 51);
}

TEST(Tracer, LightsTheBackdropByLampsAndDome) {
    const Volume volume = block({8, 8, 8}, 0.1);
    render::Scene scene;
    scene.light.dome = {0.2, 0.2, 0.2};
    const double half = 0.4;
    const double tilt = 0.6;
    scene.light.lamps.push_back({{std::sin(tilt), 0, std::cos(tilt)}, std::cos(half), {3, 2, 1}});
    scene.backdrop = {true, {0, 0, 0}, {0, 0, 1}, {0.5, 0.6, 0.7}, {}};
    const Tracer tracer(&volume, make_optics({MaterialOptics{}}), scene);
    // Far from the print.
    const Estimate got = estimate(tracer, 20000, {200, 0, 5}, always(kDown));
    for (size_t c = 0; c < 3; ++c) {
        // A round lamp, all of it above the plane: L sin^2(half) cos(tilt), over pi.
        const double lamp =
            scene.light.lamps[0].radiance[c] * std::sin(half) * std::sin(half) * std::cos(tilt);
        const double expected = scene.backdrop.albedo[c] * (scene.light.dome[c] + lamp);
        EXPECT_NEAR(got.mean[c], expected, kErrors * got.error[c]) << c;
        EXPECT_LT(got.error[c], 0.005);
    }
    // In the shadow of the print, which is index-matched and clear: it hides lamps from the backdrop's
    // own samples, but the light that goes through it counts.
    const Estimate under = estimate(tracer, 20000, {0.4, 0.4, 5}, always(kDown));
    EXPECT_NEAR(under.mean[0], got.mean[0], 0.02);
}

}  // namespace
}  // namespace openfab::testing
