// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The printed postcard against its two pictures, computed from first principles.

#include "tests/support/postcard/check.h"

#include <algorithm>

#include "tests/scenes/scene_fixture.h"

namespace openfab::testing {
namespace {

// The sanitizer build prints a coarser card: its pipeline code runs many times slower.
#ifdef OPENFAB_SANITIZED
const std::vector<std::string> kResolution{"--draft", "4"};
#else
const std::vector<std::string> kResolution{};
#endif

class Postcard : public PostcardScene {
  protected:
    static void SetUpTestSuite() {
        PostcardScene::SetUpTestSuite();
        std::vector<std::string> arguments{"-o", (scratch() / "card.ofr").string(), "--stats",
                                           (scratch() / "stats.json").string()};
        arguments.insert(arguments.end(), kResolution.begin(), kResolution.end());
        const Outcome printed = print(arguments);
        ASSERT_EQ(printed.exit_code, 0) << printed.err;
        card_ = new Voxels(read_ofr(scratch() / "card.ofr"));
        front_ = new postcard::Picture(
            postcard::read_picture((gallery_postcard() / "foreground.jpg").string()));
        hidden_ = new postcard::Picture(
            postcard::read_picture((gallery_postcard() / "hidden.jpg").string()));
        ASSERT_GT(front_->width, 0);
        ASSERT_GT(hidden_->width, 0);
    }
    static void TearDownTestSuite() {
        delete card_;
        delete front_;
        delete hidden_;
        PostcardScene::TearDownTestSuite();
    }
    static uint8_t code_of(const std::string& material) {
        const auto& names = card_->materials;
        return static_cast<uint8_t>(std::find(names.begin(), names.end(), material) -
                                    names.begin() + 1);
    }
    static postcard::Findings compare(bool mirrored = false, bool flipped = false) {
        const Voxels& card = *card_;
        postcard::Voxels view{card.size, card.pitch_mm,        card.origin_mm,
                              nullptr,   code_of("VeroWhite"), code_of("VeroBlack")};
        view.code = [&card, mirrored, flipped](int32_t x, int32_t y, int32_t z) {
            return card.at(mirrored ? card.size.x - 1 - x : x, flipped ? card.size.y - 1 - y : y,
                           z);
        };
        return postcard::compare(view, {}, *front_, *hidden_);
    }

    static Voxels* card_;
    static postcard::Picture* front_;
    static postcard::Picture* hidden_;
};

Voxels* Postcard::card_ = nullptr;
postcard::Picture* Postcard::front_ = nullptr;
postcard::Picture* Postcard::hidden_ = nullptr;

TEST_F(Postcard, FollowsBothPictures) {
    const postcard::Findings found = compare();
    EXPECT_EQ(found.first_fault, "");
    EXPECT_GT(found.windows, 100);
    EXPECT_LE(found.worst_window, 0.025);
    EXPECT_LE(std::abs(found.signed_mean), 0.001);
    EXPECT_EQ(found.not_white, 0);
    EXPECT_GT(found.columns, 100'000);
    EXPECT_EQ(found.missing_columns, 0);
    EXPECT_EQ(found.holes, 0);
    EXPECT_EQ(found.relief_misses, 0);
    printf("windows %ld, worst %.4f, signed mean %.5f\n", static_cast<long>(found.windows),
           found.worst_window, found.signed_mean);
}

// The same comparison must detect a mirrored and a flipped card, which shows that it is able to
// fail.
TEST_F(Postcard, AMirroredOrFlippedCardIsFound) {
    EXPECT_GT(compare(true, false).worst_window, 0.05);
    EXPECT_GT(compare(true, false).relief_misses, 1000);
    EXPECT_GT(compare(false, true).worst_window, 0.05);
    EXPECT_GT(compare(false, true).relief_misses, 1000);
}

TEST_F(Postcard, IsMostlySolid) {
    const double total = statistic(scratch() / "stats.json", "voxels_total");
    const double solid = statistic(scratch() / "stats.json", "voxels_solid");
    EXPECT_GE(solid, 0.6 * total);
    const auto counted = std::count_if(card_->codes.begin(), card_->codes.end(),
                                       [](uint8_t code) { return code != 0; });
    EXPECT_EQ(static_cast<double>(counted), solid);
}

}  // namespace
}  // namespace openfab::testing
