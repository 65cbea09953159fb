// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
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

// Moduli of a resin at 20 and 30 C and at 0.01 and 1 /s: powers of the rate, and of two in between.
class MechanicsConditions : public ::testing::Test {
  protected:
    MechanicsConditions() {
        file_ = std::filesystem::path(::testing::TempDir()) / "conditions.mechanics.json";
    }
    ~MechanicsConditions() override { std::filesystem::remove(file_); }
    Result<Properties> read(const std::string& modulus, const Conditions& asked) const {
        std::ofstream(file_) << "{\"materials\": {\"soft\": {\"nu\": 0.48, " << modulus << "}}}";
        return read_properties(file_, asked);
    }
    double at(const Conditions& asked) const {
        const Result<Properties> out = read(
            R"("E_MPa": [{"T_C": 20, "rate_1_s": 0.01, "value": 2}, {"T_C": 20, "rate_1_s": 1, "value": 8},
                              {"T_C": 30, "rate_1_s": 1, "value": 4}, {"T_C": 30, "rate_1_s": 0.01, "value": 1}])",
            asked);
        EXPECT_TRUE(out) << out.error().text();
        return out ? out->materials[0].young_MPa : 0;
    }
    std::filesystem::path file_;
};

TEST_F(MechanicsConditions, LogarithmsAreLinear) {
    EXPECT_DOUBLE_EQ(at({20, 0.01}), 2);
    EXPECT_DOUBLE_EQ(at({30, 1}), 4);
    EXPECT_NEAR(at({20, 0.1}), 4, 1e-12);
    EXPECT_NEAR(at({25, 0.1}), std::sqrt(8.0), 1e-12);
    EXPECT_NEAR(at({22.5, 1}), 8 / std::pow(2, 0.25), 1e-12);
}

TEST_F(MechanicsConditions, NothingIsExtrapolatedOrGuessed) {
    const std::string two =
        R"("E_MPa": [{"T_C": 20, "rate_1_s": 1, "value": 8}, {"T_C": 30, "rate_1_s": 2, "value": 4}])";
    const std::string one = R"("E_MPa": 8, "T_C": 20, "rate_1_s": 1)";
    const auto refused = [&](const std::string& modulus, const Conditions& asked) {
        const Result<Properties> out = read(modulus, asked);
        return out ? std::string() : out.error().text();
    };
    EXPECT_THAT(refused(two, {}), ::testing::HasSubstr("--temperature 23C"));
    EXPECT_THAT(refused(two, {20, {}}), ::testing::HasSubstr("--rate 0.01/s"));
    EXPECT_THAT(refused(two, {20, 2}), ::testing::HasSubstr("not extrapolated"));
    EXPECT_THAT(refused(two, {31, 2}), ::testing::HasSubstr("from 20 to 30 C"));
    EXPECT_EQ(refused(two, {20, 1}), "");
    EXPECT_EQ(refused(one, {}), "");
    EXPECT_EQ(refused(one, {20, 1}), "");
    EXPECT_THAT(refused(one, {23, 1}), ::testing::HasSubstr(messages::kOtherConditionsHelp));
    EXPECT_THAT(refused(R"("E_MPa": 8, "T_C": 20)", {}),
                testing::Says(messages::kBothConditions, "soft"));
    EXPECT_THAT(refused(R"("E_MPa": [{"T_C": 20, "value": 8}])", {}),
                ::testing::HasSubstr("three numbers"));
    EXPECT_THAT(refused(R"("E_MPa": [])", {}), ::testing::HasSubstr("rows"));
    EXPECT_THAT(refused(R"("E_MPa": "8")", {}),
                ::testing::HasSubstr("must be a number, or a list"));
    EXPECT_THAT(
        refused(
            R"("E_MPa": [{"T_C": 2, "rate_1_s": 1, "value": 8}, {"T_C": 2, "rate_1_s": 1, "value": 4}])",
            {}),
        ::testing::HasSubstr("there twice"));
}

TEST_F(MechanicsConditions, OneNumberIsDoubted) {
    const auto doubts = [&](const std::string& modulus, const Conditions& asked) {
        const Result<Properties> out = read(modulus, asked);
        return condition_doubts(out->materials, *out);
    };
    EXPECT_THAT(doubts("\"E_MPa\": 2", {}),
                ::testing::ElementsAre(testing::Says(messages::kSoftUnconditioned, "soft")));
    EXPECT_THAT(doubts("\"E_MPa\": 2000", {}), ::testing::IsEmpty());
    EXPECT_THAT(doubts("\"E_MPa\": 2000", {23, {}}),
                ::testing::ElementsAre(testing::Says(messages::kUnconditioned, "soft")));
    EXPECT_THAT(doubts(R"("E_MPa": 2, "T_C": 20, "rate_1_s": 1)", {}), ::testing::IsEmpty());
}

TEST(Conditions, TextsHaveUnits) {
    EXPECT_DOUBLE_EQ(*parse_temperature("-5.5C"), -5.5);
    EXPECT_DOUBLE_EQ(*parse_rate("0.01/s"), 0.01);
    EXPECT_DOUBLE_EQ(*parse_rate("100s"), 0.01);
    EXPECT_NEAR(*parse_rate("1Hz"), 6.283185307, 1e-9);
    for (const char* text : {"23", "C", "-300C", "23F", ""})
        EXPECT_FALSE(parse_temperature(text)) << text;
    for (const char* text : {"1", "0/s", "-1/s", "0s", "fast", ""})
        EXPECT_FALSE(parse_rate(text)) << text;
}

}  // namespace
}  // namespace openfab::mechanics
