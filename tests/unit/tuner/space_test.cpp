// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The schedules that a search can try, and the statistics it judges them by.

#include "tools/tuner/space.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <map>

#include "tools/tuner/stand.h"

namespace openfab::tuner {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr const char* kText = R"(pipeline slab
param columns = 16 in {4, 16, 64}
param depth = 6 in [3, 9]
slab.split(column, batch, member, columns).vectorize(z)
values_*.compute_at(weights, column).vectorize(z).unroll(column, depth)
)";

const std::vector<lower::FuncSites> kSites = {
    {"slab", true, {}, std::nullopt, {"member", "batch"}},
    {"values_early_0", false, {"compute_root()", "compute_at(slab, batch)"}, 1, {}},
    {"values_0", false, {"compute_root()", "compute_at(weights, column)"}, 1, {}},
    {"values_1", false, {"compute_root()"}, 0, {}},
};

Space make_space(const std::map<std::string, int64_t>& params = {}) {
    auto file = schedule::parse({"test.sched", kText});
    auto bound = schedule::bind(std::get<schedule::File>(file), {"avx2", params});
    return Space(std::get<schedule::File>(file), "avx2", params,
                 std::get<schedule::Schedule>(bound), kSites);
}

/// Returns the setting that has this change alone.
Setting setting_of(const Space& space, const std::string& text) {
    for (size_t k = 0; k < space.knobs().size(); ++k) {
        for (size_t c = 0; c < space.knobs()[k].changes.size(); ++c) {
            if (space.knobs()[k].changes[c].text == text) return {{k, c}};
        }
    }
    ADD_FAILURE() << "no change is called " << text;
    return {};
}

std::string text_of(const Space& space, const Setting& setting) {
    const auto text = space.text(setting);
    const auto* lines = std::get_if<std::string>(&text);
    return lines != nullptr ? *lines : "";
}

std::vector<std::string> all_changes(const Space& space) {
    std::vector<std::string> out;
    for (const Knob& knob : space.knobs()) {
        for (const Change& change : knob.changes)
            out.push_back(change.text);
    }
    return out;
}

TEST(Space, HasTheValuesOfParametersAndThePlacesOfFuncs) {
    EXPECT_THAT(all_changes(make_space()),
                ElementsAre("columns = 4", "columns = 64", "depth = 3", "depth = 4", "depth = 8",
                            "depth = 9", "slab.unroll(member, 2)", "slab.unroll(member, 4)",
                            "slab.parallel(batch)", "vectors of 4", "vectors of 2",
                            "values_*.compute_root()", "values_early_*.compute_root()",
                            "values_*.store_root()", "values_early_*.store_root()"));
}

TEST(Space, BeginsWithTheScheduleItself) {
    EXPECT_EQ(text_of(make_space(), {}),
              "slab.split(column, batch, member, 16).vectorize(z)\n"
              "values_*.compute_at(weights, column).vectorize(z).unroll(column, 6)\n");
    EXPECT_THAT(text_of(make_space({{"columns", 4}}), {}), HasSubstr("member, 4)"));
}

TEST(Space, WritesLinesThatAreASchedule) {
    const Space space = make_space();
    EXPECT_THAT(text_of(space, setting_of(space, "columns = 64")), HasSubstr("member, 64)"));
    const std::string narrow = text_of(space, setting_of(space, "vectors of 4"));
    EXPECT_THAT(narrow, HasSubstr("slab.split(column, batch, member, 16).vectorize(z, 4)\n"));
    EXPECT_THAT(narrow, HasSubstr(".vectorize(z, 4).unroll(column, 6)\n"));
    // The pattern would move values_early_0, too.
    const std::string moved = text_of(space, setting_of(space, "values_*.compute_root()"));
    EXPECT_THAT(moved, HasSubstr("\nvalues_0.compute_root()\nvalues_1.compute_root()\n"));
    EXPECT_THAT(moved, Not(HasSubstr("values_*.compute_root()")));
    Setting both = setting_of(space, "columns = 4");
    both.merge(setting_of(space, "slab.parallel(batch)"));
    EXPECT_THAT(space.changes(both), ElementsAre("columns = 4", "slab.parallel(batch)"));
    EXPECT_THAT(text_of(space, both), HasSubstr("member, 4)"));
    for (const Knob& knob : space.knobs()) {
        for (const Change& change : knob.changes) {
            const std::string lines = text_of(space, setting_of(space, change.text));
            EXPECT_TRUE(
                std::holds_alternative<schedule::Schedule>(schedule::read({"test.sched", lines})))
                << lines;
        }
    }
}

TEST(Space, NamesFuncsAsSchedulesDo) {
    EXPECT_EQ(pattern_of("slab$1"), "slab");
    EXPECT_EQ(pattern_of("values_12"), "values_*");
    EXPECT_EQ(pattern_of("values_early_3$2"), "values_early_*");
    EXPECT_EQ(pattern_of("x2"), "x2");
}

TEST(SpreadSlabs, AreRunsOverTheWholeHeight) {
    EXPECT_THAT(spread_slabs({10, 30}, 6, 2, 0.25), ElementsAre(11, 12, 18, 19, 25, 26));
    EXPECT_THAT(spread_slabs({3, 7}, 9, 2, 0.5), ElementsAre(3, 4, 5, 6));
    EXPECT_THAT(spread_slabs({0, 5}, 1, 4, 0.5), ElementsAre(2));
    EXPECT_THAT(spread_slabs({0, 4}, 2, 2, 0.9), ElementsAre(3));
}

TEST(Statistics, StandOutliers) {
    EXPECT_EQ(median({3, 1, 2}), 2);
    EXPECT_EQ(median({100, 1, 2, 3}), 2.5);
}

}  // namespace
}  // namespace openfab::tuner
