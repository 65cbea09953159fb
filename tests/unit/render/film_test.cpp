// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/render/film.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstring>

#include "tests/unit/render/render_fixture.h"

namespace openfab::testing {
namespace {

using render::Film;
using render::FilmOptions;
using render::MaterialOptics;
using render::Tracer;

class FilmTest : public ::testing::Test {
  protected:
    FilmTest() {
        volume_ = make_volume({24, 24, 24}, {0.1, 0.1, 0.1}, [](int32_t x, int32_t y, int32_t z) {
            return static_cast<uint8_t>(1 + (x + y + z) % 2);
        });
    }
    Tracer tracer(const MaterialOptics& one, const MaterialOptics& other, double aspect) {
        render::SceneOptions options;
        options.aspect = aspect;
        Result<render::Scene> scene = make_scene(options, volume_.solid_mm());
        return {&volume_, make_optics({one, other}, 1.5, 0.1), *scene};
    }
    static std::vector<uint8_t> trace(const Tracer& tracer, const FilmOptions& options) {
        Film film(options);
        film.trace(tracer, std::atomic<bool>(false), [](int32_t) { return true; });
        EXPECT_EQ(film.fewest(), options.samples);
        return film.to_pfm();
    }

    render::Volume volume_;
};

constexpr MaterialOptics kWhite{{6, 9, 24}, {0.99, 0.99, 0.99}, 0};
constexpr MaterialOptics kRed{{6, 5, 5}, {0.98, 0.2, 0.1}, 0.4};

TEST_F(FilmTest, IsTheSameForAnyNumberOfThreads) {
    const Tracer tracer = this->tracer(kWhite, kRed, 2);
    FilmOptions options{50, 25, 5, 0, 1, 9};
    const std::vector<uint8_t> one = trace(tracer, options);
    for (const int32_t threads : {2, 5}) {
        options.threads = threads;
        EXPECT_EQ(trace(tracer, options), one) << threads;
    }
    options.seed = 10;
    EXPECT_NE(trace(tracer, options), one);
}

TEST_F(FilmTest, HasTheMeanOfEachPixelsOwnSamples) {
    const Tracer tracer = this->tracer(kWhite, kRed, 1);
    constexpr int32_t kSide = 18;  // more than a tile
    constexpr int32_t kSamples = 7;
    Film film({kSide, kSide, kSamples, 0, 2, 3});
    film.trace(tracer, std::atomic<bool>(false), [](int32_t) { return true; });
    for (const int32_t pixel : {0, 17, 160, 323}) {
        std::array<render::Rgb, kSamples> lights{};
        const auto start = [&](int32_t sample) {
            render::Random random(3, static_cast<uint64_t>(pixel), static_cast<uint64_t>(sample));
            const double x = (pixel % kSide + random.uniform()) / kSide;
            const double y = (pixel / kSide + random.uniform()) / kSide;
            return tracer.start_in_picture(x, y, random);
        };
        tracer.trace(kSamples, std::atomic<bool>(false), start,
                     [&](int32_t sample, const render::Rgb& light, bool) {
                         lights[static_cast<size_t>(sample)] = light;
                     });
        for (size_t c = 0; c < 3; ++c) {
            double sum = 0;
            for (const render::Rgb& light : lights)
                sum += light[c];
            EXPECT_DOUBLE_EQ(film.mean(pixel % kSide, pixel / kSide)[c], sum / kSamples) << pixel;
        }
    }
}

TEST_F(FilmTest, EndsWhereItIsTold) {
    const Tracer tracer = this->tracer(kWhite, kRed, 1);
    Film film({16, 16, 1000, 0, 2, 0});
    film.trace(tracer, std::atomic<bool>(false), [](int32_t samples) { return samples < 4; });
    EXPECT_EQ(film.fewest(), 4);
    EXPECT_EQ(film.paths(), 16 * 16 * 4);
    Film stopped({16, 16, 1000, 0, 2, 0});
    stopped.trace(tracer, std::atomic<bool>(true), [](int32_t) { return true; });
    EXPECT_EQ(stopped.paths(), 0);
    Film timed({16, 16, 1'000'000, 1e-3, 1, 0});
    timed.trace(tracer, std::atomic<bool>(false), [](int32_t) { return true; });
    EXPECT_GE(timed.fewest(), 1);
    EXPECT_LT(timed.fewest(), 1'000'000);
}

TEST_F(FilmTest, WritesTheLowestRowFirstAsPfm) {
    const Tracer tracer = this->tracer(kWhite, kRed, 1);
    const FilmOptions options{8, 4, 2, 0, 1, 0};
    Film film(options);
    film.trace(tracer, std::atomic<bool>(false), [](int32_t) { return true; });
    const std::vector<uint8_t> bytes = film.to_pfm();
    const std::string head = "PF\n8 4\n-1.0\n";
    ASSERT_EQ(bytes.size(), head.size() + 8 * 4 * 12);
    EXPECT_EQ(std::memcmp(bytes.data(), head.data(), head.size()), 0);
    float first = 0;
    std::memcpy(&first, bytes.data() + head.size(), sizeof first);
    EXPECT_EQ(first, static_cast<float>(film.mean(0, 3)[0]));
}

}  // namespace
}  // namespace openfab::testing
