// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/render/scene.h"
#include "tests/support/says/says.h"
#include "tools/render/messages.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace openfab::testing {
namespace {

using render::make_scene;
using render::Scene;
using render::SceneOptions;

const Box3d kBox{{-10, 5, 0}, {30, 15, 4}};

/// Where a point lies in the picture, -1 … 1.
Vec2<double> seen(const render::Camera& camera, const Vec3d& point) {
    const Vec3d at = point - camera.eye_mm;
    const double far = dot(at, camera.forward);
    return {dot(at, camera.right) / far / camera.half_width,
            dot(at, camera.up) / far / camera.half_height};
}

TEST(Scene, HasAllOfThePrintInThePicture) {
    for (const char* view :
         {"top", "bottom", "front", "model", "model:0:5", "model:120:60", "model:-90:90"}) {
        for (const double aspect : {0.5, 1.0, 2.0}) {
            SceneOptions options;
            options.view = view;
            options.aspect = aspect;
            const Result<Scene> scene = make_scene(options, kBox);
            ASSERT_TRUE(scene) << scene.error().text();
            double widest = 0;
            for (int i = 0; i < 8; ++i) {
                const Vec2<double> at = seen(scene->camera, {(i & 1) != 0 ? kBox.lo.x : kBox.hi.x,
                                                             (i & 2) != 0 ? kBox.lo.y : kBox.hi.y,
                                                             (i & 4) != 0 ? kBox.lo.z : kBox.hi.z});
                widest = std::max({widest, std::abs(at.x), std::abs(at.y)});
            }
            EXPECT_NEAR(widest, 0.92, 1e-9) << view << " " << aspect;
            EXPECT_NEAR(scene->camera.half_width / scene->camera.half_height, aspect, 1e-12);
        }
    }
}

TEST(Scene, TurnsViewsAsPreviewsDo) {
    SceneOptions options;
    const Vec3d center = kBox.center();
    options.view = "top";
    Result<Scene> scene = make_scene(options, kBox);
    EXPECT_GT(seen(scene->camera, center + Vec3d{1, 0, 0}).x, 0);
    EXPECT_GT(seen(scene->camera, center + Vec3d{0, 1, 0}).y, 0);
    options.view = "bottom";
    scene = make_scene(options, kBox);
    EXPECT_LT(seen(scene->camera, center + Vec3d{1, 0, 0}).x, 0);
    EXPECT_GT(seen(scene->camera, center + Vec3d{0, 1, 0}).y, 0);
    options.view = "model:90:30";
    scene = make_scene(options, kBox);
    EXPECT_LT(scene->camera.forward.x, 0);
    EXPECT_GT(seen(scene->camera, center + Vec3d{0, 1, 0}).x, 0);
    EXPECT_GT(seen(scene->camera, center + Vec3d{0, 0, 1}).y, 0);
}

TEST(Scene, PutsNothingBeforeALampBehind) {
    SceneOptions options;
    options.light = "behind";
    const Result<Scene> scene = make_scene(options, kBox);
    ASSERT_TRUE(scene);
    EXPECT_FALSE(scene->backdrop.is_plane);
    ASSERT_EQ(scene->light.lamps.size(), 1u);
    EXPECT_NEAR(dot(scene->light.lamps[0].to_lamp, scene->camera.forward), 1, 1e-12);
}

TEST(Scene, GivesAWhiteThingOne) {
    SceneOptions options;
    options.backdrop = "#ffffff";
    options.view = "top";
    const Result<Scene> scene = make_scene(options, kBox);
    ASSERT_TRUE(scene);
    EXPECT_GT(scene->backdrop.seen[0], 0.6);
    EXPECT_LT(scene->backdrop.seen[0], 1.0);
}

TEST(Scene, RefusesWhatItDoesNotKnow) {
    const auto message = [](const std::function<void(SceneOptions*)>& change) {
        SceneOptions options;
        change(&options);
        const Result<Scene> scene = make_scene(options, kBox);
        if (scene) return std::string();
        EXPECT_EQ(scene.error().code, ErrorCode::kUsage);
        return scene.error().text();
    };
    for (const char* view : {"side", "section", "slice:3", "model:30:2", "front,cut=x", ""})
        EXPECT_THAT(message([&](SceneOptions* o) { o->view = view; }),
                    testing::Says(render::messages::kNoView));
    for (const char* light : {"sun", "30", "30:", "400:0", "0:91", "30:30:30"})
        EXPECT_THAT(message([&](SceneOptions* o) { o->light = light; }),
                    testing::Says(render::messages::kNoLight));
    for (const char* color : {"grey", "#12345", "#12345g", "#1234567"})
        EXPECT_THAT(message([&](SceneOptions* o) { o->backdrop = color; }),
                    testing::Says(render::messages::kNoColour));
    EXPECT_EQ(message([](SceneOptions* o) { o->light = "-40:35"; }), "");
}

}  // namespace
}  // namespace openfab::testing
