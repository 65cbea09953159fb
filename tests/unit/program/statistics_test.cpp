// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/statistics.h"

#include <gtest/gtest.h>
#include <rapidjson/document.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <string>

namespace openfab::program {
namespace {

pipeline::PrintInfo info() {
    pipeline::PrintInfo info;
    info.size = {10, 20, 30};
    info.pitch_mm = {0.1, 0.2, 0.05};
    info.title = "card \"one\"";
    info.materials.resize(2);
    info.materials[0].name = "white";
    info.materials[0].density_g_cm3 = 1.5;
    info.materials[1].name = "black";
    return info;
}

TEST(StatisticsJson, HasTheNamesOfTheDesign) {
    pipeline::PrintStatistics s;
    s.voxels_total = 6'000'000;
    s.voxels_solid = 3'000'000;
    s.voxels_by_code = {3'000'000, 2'000'000, 1'000'000};
    s.slices = 30;
    s.print_seconds = 300;
    s.cost =
        pipeline::PrintCost{"EUR", {{"white", 2, 0.5, 1.25}, {"black", 1, 0, {}}}, 1.25, 300, 60};
    s.seconds_total = 2;
    s.seconds_first_slice = 0.5;
    s.seconds_by_stage = {{"volume", 1.25}};
    s.blocks_total = 7;
    s.hash = 0xfedcba9876543210u;
    s.warnings = {"thin"};
    s.complete = true;
    rapidjson::Document d;
    d.Parse(statistics_json(s, info()).c_str());
    ASSERT_FALSE(d.HasParseError());
    for (const char* key : {"voxels_total", "voxels_solid", "voxels_by_material", "ml_by_material",
                            "slices", "seconds_total", "seconds_first_slice", "seconds_by_phase",
                            "mvoxels_per_second", "msolid_per_second", "peak_rss_bytes", "threads",
                            "blocks", "queries", "cache", "warnings"}) {
        EXPECT_TRUE(d.HasMember(key)) << key;
    }
    EXPECT_STREQ(d["title"].GetString(), "card \"one\"");
    EXPECT_STREQ(d["hash"].GetString(), "fedcba9876543210");
    EXPECT_EQ(d["voxels_by_material"]["black"].GetInt64(), 1'000'000);
    EXPECT_NEAR(d["ml_by_material"]["white"].GetDouble(), 2e6 * 0.001 * 1e-3, 1e-9);
    EXPECT_NEAR(d["g_by_material"]["white"].GetDouble(), 2e6 * 0.001 * 1e-3 * 1.5, 1e-9);
    EXPECT_DOUBLE_EQ(d["print_seconds"].GetDouble(), 300);
    EXPECT_STREQ(d["cost"]["currency"].GetString(), "EUR");
    EXPECT_DOUBLE_EQ(d["cost"]["money"].GetDouble(), 1.25);
    EXPECT_EQ(d["cost"]["passes"].GetInt64(), 60);
    EXPECT_DOUBLE_EQ(d["cost"]["by_material"]["white"]["waste_ml"].GetDouble(), 0.5);
    EXPECT_FALSE(d["cost"]["by_material"]["black"].HasMember("money"));
    EXPECT_DOUBLE_EQ(d["mvoxels_per_second"].GetDouble(), 3.0);
    EXPECT_DOUBLE_EQ(d["msolid_per_second"].GetDouble(), 1.5);
    EXPECT_DOUBLE_EQ(d["seconds_by_phase"]["volume"].GetDouble(), 1.25);
    EXPECT_EQ(d["blocks"]["total"].GetInt64(), 7);
    EXPECT_TRUE(d["queries"].HasMember("asked") && d["queries"].HasMember("skipped"));
    EXPECT_EQ(d["warnings"].Size(), 1u);
    EXPECT_TRUE(d["complete"].GetBool());
}

TEST(StatisticsJson, NothingPrintedHasNoRate) {
    rapidjson::Document d;
    d.Parse(statistics_json({}, info()).c_str());
    ASSERT_FALSE(d.HasParseError());
    EXPECT_EQ(d["mvoxels_per_second"].GetDouble(), 0);
    EXPECT_FALSE(d["complete"].GetBool());
}

TEST(StatisticsFile, AnUnwritablePlaceIsNamed) {
    const Result<void> r = write_statistics("/nowhere/at/all/stats.json", {}, info());
    ASSERT_FALSE(r.has_value());
    EXPECT_EQ(r.error().code, ErrorCode::kOutside);
    EXPECT_NE(r.error().text().find("/nowhere/at/all/stats.json"), std::string::npos);
    EXPECT_FALSE(write_statistics("/dev/full", {}, info()).has_value());
}

TEST(StatisticsFile, APipeThatNobodyReadsIsRefused) {
    const std::string pipe =
        std::filesystem::temp_directory_path() / ("stats." + std::to_string(::getpid()));
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    const Result<void> r = write_statistics(pipe, {}, info());
    std::filesystem::remove(pipe);
    ASSERT_FALSE(r.has_value());
    EXPECT_NE(r.error().text().find("is a pipe that nobody reads"), std::string::npos);
}

}  // namespace
}  // namespace openfab::program
