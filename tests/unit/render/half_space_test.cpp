// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/render/half_space.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "tools/render/random.h"

namespace openfab::testing {
namespace {

using render::albedo_of_look;
using render::look_of_albedo;
using render::Random;

/// Of light from inside at that cosine, the share that a surface sends back, from the sines and tangents of both angles.
double sent_back(double cosine, double index) {
    const double sine = std::sqrt(1 - cosine * cosine) * index;
    if (sine >= 1) return 1;
    const double in = std::acos(cosine);
    const double out = std::asin(sine);
    if (in < 1e-9) return std::pow((index - 1) / (index + 1), 2);
    return 0.5 * (std::pow(std::sin(in - out) / std::sin(in + out), 2) +
                  std::pow(std::tan(in - out) / std::tan(in + out), 2));
}

/// The looks of bodies with these albedos, by paths that begin at the viewer: those that leave after n collisions have
/// the albedo's power n.
std::vector<double> looks_by_paths(const std::vector<double>& albedos, double index, int paths) {
    const double at_surface = std::pow((index - 1) / (index + 1), 2);
    std::vector<double> looks(albedos.size(), at_surface);
    for (int path = 0; path < paths; ++path) {
        Random random(5, 0, static_cast<uint64_t>(path));
        double weight = 1 - at_surface;
        double depth = 0;
        double cosine = 1;
        for (int collisions = 0; collisions < 2000 && weight > 1e-4; ++collisions) {
            depth += cosine * -std::log(random.uniform());
            if (depth < 0) {
                const double back = index > 1 ? sent_back(-cosine, index) : 0;
                for (size_t i = 0; i < albedos.size(); ++i)
                    looks[i] += weight * (1 - back) * std::pow(albedos[i], collisions) / paths;
                weight *= back;
                depth = -depth;
            }
            cosine = 2 * random.uniform() - 1;
        }
    }
    return looks;
}

TEST(HalfSpace, LooksLikePathsThroughIt) {
    const std::vector<double> albedos{0, 0.2, 0.5, 0.64, 0.8, 0.9, 0.97};
    for (const double index : {1.0, 1.33, 1.51, 2.0}) {
        const std::vector<double> by_paths = looks_by_paths(albedos, index, 40000);
        for (size_t i = 0; i < albedos.size(); ++i)
            EXPECT_NEAR(look_of_albedo(albedos[i], index), by_paths[i], 0.006)
                << index << " " << albedos[i];
    }
}

TEST(HalfSpace, LosesNothingWithoutAbsorption) {
    for (const double index : {1.0, 1.3, 1.5, 2.5})
        EXPECT_NEAR(look_of_albedo(1, index), 1, 2e-3) << index;
}

TEST(HalfSpace, HasTheAlbedoOfALook) {
    for (const double index : {1.0, 1.5}) {
        for (const double look : {0.05, 0.216, 0.5, 0.9, 0.99})
            EXPECT_NEAR(look_of_albedo(albedo_of_look(look, index), index), look, 1e-3)
                << index << " " << look;
    }
    // Of a glossy body nothing is darker than what its surface reflects.
    EXPECT_EQ(albedo_of_look(0.02, 1.5), 0);
    EXPECT_EQ(albedo_of_look(1, 1.5), 1);
}

}  // namespace
}  // namespace openfab::testing
