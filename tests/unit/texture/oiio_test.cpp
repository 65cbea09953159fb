// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Lookups against OpenImageIO's texture system, on a picture of 4096 x 4096: within 1/255 for
// isotropic footprints. The interpreter represents generated code, which gives the same bits
// (tests/exec).

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/texture.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "compiler/interp/sample.h"
#include "tests/support/meshes/temp_folder.h"
#include "tools/texture/convert.h"
#include "world/world.h"

namespace openfab::tools {
namespace {

#ifdef OPENFAB_SANITIZED
constexpr int kSide = 512;
#else
constexpr int kSide = 4096;
#endif

struct Wrapped {
    world::Wrap ours;
    OIIO::TextureOpt::Wrap theirs;
};
constexpr Wrapped kWraps[] = {{world::Wrap::kClamp, OIIO::TextureOpt::WrapClamp},
                              {world::Wrap::kRepeat, OIIO::TextureOpt::WrapPeriodic},
                              {world::Wrap::kMirror, OIIO::TextureOpt::WrapMirror},
                              {world::Wrap::kBlack, OIIO::TextureOpt::WrapBlack}};

class OiioTest : public ::testing::Test {
  protected:
    /// Texel (x, y), y down, as image files have it.
    void make_picture(const std::function<float(int, int)>& value) {
        std::vector<float> texels;
        texels.reserve(size_t{kSide} * kSide);
        for (int y = 0; y < kSide; ++y) {
            for (int x = 0; x < kSide; ++x)
                texels.push_back(value(x, y));
        }
        const OIIO::ImageBuf image(OIIO::ImageSpec(kSide, kSide, 1, OIIO::TypeDesc::FLOAT),
                                   texels.data());
        const std::string plain = (folder_.path() / "picture.tif").string();
        ASSERT_TRUE(image.write(plain));
        theirs_ = (folder_.path() / "picture.tx").string();
        OIIO::ImageSpec options;
        options.set_format(OIIO::TypeDesc::FLOAT);
        ASSERT_TRUE(OIIO::ImageBufAlgo::make_texture(OIIO::ImageBufAlgo::MakeTxTexture, image,
                                                     theirs_, options))
            << OIIO::geterror();
        ours_ = folder_.path() / "picture.oftx";
        ASSERT_TRUE(make_pyramid_file(plain, ours_, {"data", false}));
        // The shared one: OpenImageIO deletes a private one by the wrong type.
        system_ = OIIO::TextureSystem::create(true);
        system_->attribute("max_memory_MB", 512.0f);
    }
    ~OiioTest() override {
        if (system_ != nullptr) system_->close_all();
    }

    /// Returns the largest difference at coordinates in -1.5 … 2.5 with footprints of `width`
    /// texels.
    float largest_difference(const Wrapped& wrap, const std::function<float()>& width) {
        const auto pyramid =
            texture::Pyramid::open(ours_, static_cast<int32_t>(wrap.ours),
                                   static_cast<int32_t>(world::Filter::kTrilinear));
        EXPECT_TRUE(pyramid);
        if (!pyramid) return 1;
        const interp::TextureView view{(*pyramid)->texels(), (*pyramid)->info()};
        OIIO::TextureOpt options;
        options.swrap = options.twrap = wrap.theirs;
        options.mipmode = OIIO::TextureOpt::MipModeTrilinear;
        options.interpmode = OIIO::TextureOpt::InterpBilinear;
        std::mt19937 random(3);
        const auto coordinate = [&] {
            return static_cast<float>(random() >> 8) * 0x1p-24f * 4.0f - 1.5f;
        };
        float largest = 0;
        for (int i = 0; i < 20000; ++i) {
            const float u = coordinate(), v = coordinate(), step = width() / kSide;
            interp::SampleArgs args;
            args.u = u;
            args.v = v;
            args.du = {step, 0, 0};
            args.dv = {0, step, 0};
            float expected = -1;
            EXPECT_TRUE(system_->texture(OIIO::ustring(theirs_), options, u, 1 - v, step, 0, 0,
                                         step, 1, &expected))
                << system_->geterror();
            largest = std::max(largest, std::abs(interp::sample(view, 0, args) - expected));
        }
        return largest;
    }

    testing::TempFolder folder_;
    std::filesystem::path ours_;
    std::string theirs_;
    OIIO::TextureSystem* system_ = nullptr;
};

/// Every texel differs from its neighbours: at the finest level, and where a single level is read.
TEST_F(OiioTest, NoiseInOneLevel) {
    std::mt19937 random(5);
    make_picture([&](int, int) { return static_cast<float>(random() >> 24) / 255.0f; });
    for (const Wrapped& wrap : kWraps) {
        for (const float texels : {0.0f, 0.4f, 1.0f, 2.0f, 8.0f, 64.0f}) {
            EXPECT_LE(largest_difference(wrap, [&] { return texels; }), 1.0f / 255)
                << "wrap " << static_cast<int>(wrap.ours) << ", " << texels << " texels";
        }
    }
}

/// Between levels OpenImageIO interpolates by the width, we by its logarithm; both agree where
/// adjacent levels agree.
TEST_F(OiioTest, APictureBetweenLevels) {
    make_picture([](int x, int y) {
        const double turn = 2 * 3.14159265358979 / kSide;
        // It fades to 0, which is what is beyond the border where that is black.
        const double fade = (0.5 - 0.5 * std::cos(turn * x)) * (0.5 - 0.5 * std::cos(turn * y));
        return static_cast<float>(fade *
                                  (0.5 + 0.3 * std::sin(2 * turn * x) * std::cos(3 * turn * y) +
                                   0.2 * std::sin(5 * turn * (x + y))));
    });
    std::mt19937 random(9);
    // Up to a 128th of the picture, in which it is smooth.
    const float most = std::log2(kSide / 128.0f);
    const auto width = [&] {
        return std::exp2(static_cast<float>(random() >> 8) * 0x1p-24f * most);
    };
    for (const Wrapped& wrap : kWraps) {
        EXPECT_LE(largest_difference(wrap, width), 1.0f / 255)
            << "wrap " << static_cast<int>(wrap.ours);
    }
}

}  // namespace
}  // namespace openfab::tools
