// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/near_miss.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "base/messages.h"

namespace openfab {
namespace {

std::string nearest(const std::string& name, const std::vector<std::string>& names) {
    return near_miss(name, names);
}

TEST(NearMiss, IsTheOneNearName) {
    const std::vector<std::string> names = {"Set",       "Get",    "voxelCenter",
                                            "voxelSize", "length", "a"};
    EXPECT_EQ(nearest("set", names), "Set");
    EXPECT_EQ(nearest("voxelCentre", names), "voxelCenter");
    EXPECT_EQ(nearest("lenght", names), "length");
    EXPECT_EQ(nearest("Bet", names), "");  // Set and Get are as near
    EXPECT_EQ(nearest("q", names), "");
    EXPECT_EQ(nearest("A", names), "a");
    EXPECT_EQ(nearest("thickness", names), "");
    EXPECT_EQ(nearest("", names), "");
    EXPECT_EQ(nearest(std::string(100000, 'x'), names), "");
    EXPECT_EQ(nearest("lenth", {"length", "length"}), "length");
}

TEST(NearMiss, SwapsAreOneEditAndShortNamesMayHaveOne) {
    EXPECT_EQ(nearest("scael", {"scale", "matrix"}), "scale");
    EXPECT_EQ(nearest("materail", {"material", "materials"}), "material");
    EXPECT_EQ(nearest("ab", {"ac", "zz"}), "ac");
    EXPECT_EQ(nearest("ab", {"ac", "ad"}), "");
    EXPECT_EQ(nearest("zzz", {"scale", "matrix"}), "");
}

TEST(Suggest, NamesTheNearOneOrAll) {
    EXPECT_EQ(suggest("scael", std::vector<std::string>{"scale", "matrix"}),
              fmt::format(messages::kDidYouMean, "scale"));
    EXPECT_EQ(suggest("zzz", std::vector<std::string>{"a", "b"}),
              fmt::format(messages::kKnownNames, "`a`, `b`"));
    EXPECT_EQ(suggest("zzz", {}), messages::kThereAreNone);
}

}  // namespace
}  // namespace openfab
