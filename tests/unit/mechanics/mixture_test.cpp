// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <functional>

#include "mechanics/messages.h"
#include "mechanics/model/mixture.h"
#include "mechanics/part/doubts.h"
#include "tests/support/says/says.h"

namespace openfab::mechanics {
namespace {

Properties properties(Law law) {
    Properties p;
    p.law = law;
    Material soft, rigid;
    soft.name = "soft";
    soft.young_MPa = 0.6;
    soft.poisson = 0.48;
    soft.strength_MPa = 1;
    rigid.name = "rigid";
    rigid.young_MPa = 2000;
    rigid.poisson = 0.35;
    rigid.strength_MPa = 50;
    p.materials = {soft, rigid};
    p.table = PropertyTable{{"soft", "rigid"}, {{{1, 0}, 0.6}, {{0.5, 0.5}, 60}, {{0, 1}, 2000}}};
    return p;
}

double bulk(const ElementProperties& e) {
    return e.lambda + 2.0 / 3 * e.mu;
}

TEST(MechanicsMixture, LawsAreInOrder) {
    const float half[] = {0.5F, 0.5F};
    double last = 0;
    for (const Law law : {Law::kReuss, Law::kHsLower, Law::kHsMean, Law::kHsUpper, Law::kVoigt}) {
        const Properties p = properties(law);
        const ElementProperties e = Mixture(p.materials, p).of(half);
        EXPECT_GT(bulk(e), last);
        last = bulk(e);
        EXPECT_DOUBLE_EQ(e.strength, 25.5);
    }
}

TEST(MechanicsMixture, PureMaterialsAreThemselvesByEachLaw) {
    const float rigid[] = {0, 1};
    for (const Law law : {Law::kTable, Law::kReuss, Law::kHsLower, Law::kHsUpper, Law::kVoigt}) {
        const Properties p = properties(law);
        const ElementProperties e = Mixture(p.materials, p).of(rigid);
        EXPECT_NEAR(e.mu, 2000 / (2 * 1.35), 1e-9);
    }
}

TEST(MechanicsMixture, TableIsLinearBetweenRows) {
    const Properties p = properties(Law::kTable);
    const float shares[] = {0.25F, 0.75F};
    const ElementProperties e = Mixture(p.materials, p).of(shares);
    const double young = e.mu * (3 * e.lambda + 2 * e.mu) / (e.lambda + e.mu);
    EXPECT_NEAR(young, 1030, 1e-9);
}

TEST(MechanicsMixture, VoidTakesItsShare) {
    const Properties p = properties(Law::kHsLower);
    const float all[] = {0.5F, 0.5F}, some[] = {0.25F, 0.25F}, none[] = {0, 0};
    const Mixture m(p.materials, p);
    EXPECT_NEAR(m.of(some).mu, 0.5 * m.of(all).mu, 1e-9);
    EXPECT_EQ(m.of(none).mu, 0);
}

std::string error_of(const std::string& text) {
    const std::string file = ::testing::TempDir() + "/materials.json";
    std::ofstream(file) << text;
    const Result<Properties> read = read_properties(file);
    return read ? "" : read.error().text();
}

TEST(MechanicsMaterials, ErrorsSayWhatToDo) {
    EXPECT_THAT(error_of(R"({"materials": {"a": {"nu": 0.3}}})"),
                ::testing::AllOf(testing::Says(messages::kNoModulus, "a"),
                                 testing::Says(messages::kGiveModulus)));
    EXPECT_THAT(error_of(R"({"materials": {"a": {"E_MPa": 3}}})"),
                testing::Says(messages::kNoPoisson));
    for (const char* nu : {"0.49999999", "0.49999", "-0.9999"})
        EXPECT_THAT(
            error_of(fmt::format(R"({{"materials": {{"a": {{"E_MPa": 3, "nu": {}}}}}}})", nu)),
            testing::Says(messages::kPoissonOutside));
    EXPECT_THAT(error_of(R"({"materials": {"a": {"E_MPa": 3, "nu": 0.5}}})"),
                testing::Says(messages::kPoissonOutsideHelp));
    EXPECT_THAT(error_of(R"({"materials": {"a": {"E_MPa": 3, "nu": 0.3, "E": 1}}})"),
                testing::Says(messages::kMaterialWithout, "E"));
    EXPECT_THAT(error_of(R"({"law": "voigt"})"), testing::Says(messages::kNoMaterials));
    const Properties p = properties(Law::kVoigt);
    const std::vector<uint8_t> all{1, 1}, first{1, 0};
    const Result<std::vector<Material>> found = p.of({"soft", "clear"}, all);
    ASSERT_FALSE(found);
    EXPECT_THAT(found.error().text(), testing::Says(messages::kMaterialUnknownHelp, "clear"));
    // Of one that nothing is made of, nothing needs to be known.
    const Result<std::vector<Material>> known = p.of({"soft", "clear"}, first);
    ASSERT_TRUE(known);
    EXPECT_TRUE((*known)[0].used);
    EXPECT_FALSE((*known)[1].used);
}

TEST(MechanicsMaterials, AnotherUnitIsDoubted) {
    Material m;
    m.name = "a";
    m.young_MPa = 2000;
    m.strength_MPa = 50;
    m.density_g_cm3 = 1.18;
    m.conductivity = 0.2;
    m.conductivity_S_m = 1e-12;
    const auto said = [](const Material& one) { return unit_doubts(std::span(&one, 1)); };
    EXPECT_TRUE(said(m).empty());
    // Rubber is stronger than it is stiff.
    Material rubber = m;
    rubber.young_MPa = 0.6;
    rubber.strength_MPa = 5;
    EXPECT_TRUE(said(rubber).empty());
    Material wrong = m;
    wrong.young_MPa = 2e9;
    EXPECT_THAT(said(wrong),
                ::testing::ElementsAre(testing::Says(messages::kMoreThanAnySolid, "a")));
    wrong.strength_MPa = 5e7;
    wrong.density_g_cm3 = 1180;
    EXPECT_EQ(said(wrong).size(), 3U);
    for (const auto& change : std::vector<std::function<void(Material*)>>{
             [](Material* one) { one->young_MPa = 2e-5; },
             [](Material* one) { one->strength_MPa = 5e7; },
             [](Material* one) { one->strength_MPa = 5e3; },
             [](Material* one) { one->strength_MPa = 0.05; },
             [](Material* one) { one->density_g_cm3 = 1180; },
             [](Material* one) { one->density_g_cm3 = 1.18e-9; },
             [](Material* one) { one->conductivity = 2e5; },
             [](Material* one) { one->conductivity = 2e-4; },
             [](Material* one) { one->conductivity_S_m = 6e9; }}) {
        Material one = m;
        change(&one);
        EXPECT_EQ(said(one).size(), 1U);
    }
}

TEST(MechanicsMaterials, ScatterOfATableIsTold) {
    Properties p;
    p.law = Law::kTable;
    p.table = PropertyTable{{"soft", "stiff"}, {{{1, 0}, 10, 0.5}, {{0, 1}, 2000, 20}}};
    EXPECT_THAT(table_doubts(p),
                ::testing::ElementsAre(testing::Says(messages::kTableScatters, "5")));
    p.law = Law::kHsLower;
    EXPECT_TRUE(table_doubts(p).empty());
    p.law = Law::kTable;
    for (PropertyTable::Row& row : p.table->rows)
        row.deviation = 0;
    EXPECT_TRUE(table_doubts(p).empty());
}

}  // namespace
}  // namespace openfab::mechanics
