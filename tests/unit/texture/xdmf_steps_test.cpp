// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Which grid of an XDMF file is read: of the steps of a series the first or that of a time, and no one of several.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/says/says.h"
#include "tests/unit/texture/xdmf_files.h"
#include "texture/messages.h"
#include "tools/texture/messages.h"

namespace openfab::tools {
namespace {

TEST_F(XdmfTest, TheFirstStepIsReadAndOneGridAlone) {
    const BlockMesh mesh = block(12);
    XdmfWriter writer(Form::kText, folder_);
    const std::string shape = points_of(mesh, &writer) + cells_of(mesh, &writer);
    const auto with = [&](const std::string& name, const std::string& values) {
        return grid(shape + attribute(name, "Node", values));
    };
    const std::string first = with("E", writer.item(kFloat64, "64", field_of(mesh)));
    const std::string later = with("E", writer.item(kFloat64, "64", std::vector<double>(64, 9)));
    const std::string steps = R"(GridType="Collection" CollectionType="Temporal")";
    const std::string parts = R"(GridType="Collection" CollectionType="Spatial")";
    const auto told = [&](const std::string& text) {
        ::testing::internal::CaptureStderr();
        expect_linear(text);
        return ::testing::internal::GetCapturedStderr();
    };
    EXPECT_THAT(told(file(grid("<Time Value=\"0\"/>" + first + later + later, steps))),
                ::testing::HasSubstr(fmt::format(messages::kFirstOfSteps, "m.xdmf", 3)));
    EXPECT_EQ(told(file(grid(first, steps))), "");
    expect_linear(file(grid(first, parts)));
    expect_linear(file(grid(grid(first, parts) + grid(later + later, parts), steps)));
    const std::string several =
        std::string(texture::messages::kSeveralGrids) + "; " + texture::messages::kSeveralGridsHelp;
    EXPECT_THAT(message(file(grid(first + later, parts))), ::testing::HasSubstr(several));
    EXPECT_THAT(message(file(grid(grid(first + later, parts), steps))),
                ::testing::HasSubstr(several));
    EXPECT_THAT(message(file(first + later)), ::testing::HasSubstr(several));
    EXPECT_EQ(message(file("")), texture::messages::kNoGrid);
    // As solvers write them: the mesh, and steps that include it.
    const auto include = [](const std::string& what, const std::string& more = "") {
        return "<xi:include " + more + " xpointer=\"xpointer(/Xdmf/Domain/Grid[1]/*[" + what +
               "])\"/>";
    };
    const std::string both = include("self::Topology or self::Geometry");
    const std::string values = attribute("E", "Node", writer.item(kFloat64, "64", field_of(mesh)));
    const std::string mesh_grid = grid(shape, R"(GridType="Uniform")");
    expect_linear(file(mesh_grid + grid(grid(both + values) + grid(both + values), steps)));
    expect_linear(file(grid(grid(both + values) + grid(both + values), steps) + mesh_grid));
    EXPECT_THAT(message(file(grid(both + values))),
                testing::Says(texture::messages::kIncludeElsewhere));
    EXPECT_THAT(message(file(grid(both + values) + grid(shape + values))),
                ::testing::HasSubstr(several));
    EXPECT_THAT(message(file(mesh_grid + grid(values))), ::testing::HasSubstr(several));
    EXPECT_THAT(message(file(mesh_grid + grid(shape + values))), ::testing::HasSubstr(several));
    EXPECT_THAT(message(file(mesh_grid + grid(both + values) + grid(both + values))),
                ::testing::HasSubstr(several));
    for (const std::string& other :
         {include("self::Topology"), include("self::Topology or self::Geometry", "href=\"a\"")}) {
        EXPECT_THAT(message(file(mesh_grid + grid(other + values))),
                    testing::Says(texture::messages::kIncludeElsewhere));
    }
}

TEST_F(XdmfTest, TheStepOfATimeIsRead) {
    const BlockMesh mesh = block(12);
    XdmfWriter writer(Form::kText, folder_);
    const std::string shape = points_of(mesh, &writer) + cells_of(mesh, &writer);
    const std::string steps = R"(GridType="Collection" CollectionType="Temporal")";
    // Step i has the value i throughout.
    const auto values = [&](double value) {
        return attribute("E", "Node", writer.item(kFloat64, "64", std::vector<double>(64, value)));
    };
    const auto value_at = [&](const std::string& text, double time) -> float {
        VolumeOptions options;
        options.time = time;
        const auto p = converted(folder_.write("m.xdmf", text), options);
        return p == nullptr ? -1 : p->texels()[0];
    };
    const auto at = [](const std::string& time) { return "<Time Value=\"" + time + "\"/>"; };
    const std::string own =
        file(grid(grid(at("0") + shape + values(0)) + grid(shape + values(1) + at("0.1")) +
                      grid(shape + values(2) + at(".30000000000000004")),
                  steps));
    EXPECT_EQ(value_at(own, 0), 0);
    EXPECT_EQ(value_at(own, 0.1), 1);
    EXPECT_EQ(value_at(own, 0.3), 2);
    // Cells and points of the first step, or of a mesh beside the series.
    const std::string both =
        "<xi:include xpointer=\"xpointer(//Grid[1]/*[self::Topology or self::Geometry])\"/>";
    const auto series = [&](const std::string& first, const std::string& times = "") {
        return grid(times + first + grid(both + values(1)) + grid(both + values(2)), steps);
    };
    EXPECT_EQ(value_at(file(series(grid(shape + values(0)))), 2), 2);
    EXPECT_EQ(value_at(file(series(grid(shape + values(0)))), 0), 0);
    EXPECT_EQ(value_at(file(grid(shape) + series(grid(both + values(0)))), 1), 1);
    EXPECT_EQ(value_at(file(series(grid(both + values(0))) + grid(shape)), 2), 2);
    const std::string parts = R"(GridType="Collection" CollectionType="Spatial")";
    EXPECT_EQ(value_at(file(series(grid(grid(shape + values(0)), parts))), 1), 1);
    // Times that the collection lists.
    const auto list = [](const std::string& type, const std::string& numbers) {
        return "<Time TimeType=\"" + type + "\"><DataItem Format=\"XML\" Dimensions=\"3\">" +
               numbers + "</DataItem></Time>";
    };
    EXPECT_EQ(value_at(file(series(grid(shape + values(0)), list("List", "5 7 11"))), 11), 2);
    EXPECT_EQ(value_at(file(series(grid(shape + values(0)), list("HyperSlab", "5 2 3"))), 7), 1);
    // What belongs to the world are the data of that step.
    XdmfWriter binary(Form::kLittle, folder_);
    std::string two;
    for (const double value : {3.0, 4.0})
        two += grid(
            points_of(mesh, &binary) + cells_of(mesh, &binary) +
            attribute("E", "Node", binary.item(kFloat64, "64", std::vector<double>(64, value))));
    const auto path = folder_.write("m.xdmf", file(grid(two, steps)));
    const auto names = [&](std::optional<double> time) {
        std::vector<std::string> out;
        for (const auto& data : texture::detached_data(path, {.time = time}))
            out.push_back(data.filename().string());
        return out;
    };
    EXPECT_THAT(names({}), ::testing::UnorderedElementsAre("data0.bin", "data1.bin", "data2.bin"));
    EXPECT_THAT(names(1), ::testing::UnorderedElementsAre("data3.bin", "data4.bin", "data5.bin"));

    VolumeOptions options;
    options.time = 0.2;
    EXPECT_EQ(message(own, options),
              fmt::format(texture::messages::kNoStepAtTime, 3, 0.2, "0, 0.1, 0.3"));
    EXPECT_EQ(message(file(grid(shape + values(0))), options),
              std::string(texture::messages::kNoSteps) + "; " + texture::messages::kNoStepsHelp);
    EXPECT_THAT(message(file(series(grid(shape + values(0))) + series("")), options),
                testing::Says(texture::messages::kSeveralSeries, "`E`"));
    EXPECT_THAT(message(file(grid(grid(at("late") + shape + values(0)), steps)), options),
                testing::Says(texture::messages::kTimeNotNumber, "late"));
    options.time = 2;
    EXPECT_THAT(message(file(series(grid(grid(shape) + grid(shape), parts))), options),
                testing::Says(texture::messages::kIncludeElsewhere));
    EXPECT_THAT(message(file(grid(shape) + series(grid(shape + values(0)))), options),
                testing::Says(texture::messages::kIncludeElsewhere))
        << "of which of the two is not known";
    EXPECT_EQ(trouble(folder_.write("a.nrrd", "NRRD0004\n"), options),
              std::string(messages::kNoStepsOfTime) + "; " + messages::kNoStepsOfTimeHelp);
}

TEST_F(XdmfTest, SolversWriteASeriesOfStepsForEachFunction) {
    const BlockMesh mesh = block(12);
    const std::string steps = R"(GridType="Collection" CollectionType="Temporal")";
    const std::string both =
        "<xi:include xpointer=\"xpointer(/Xdmf/Domain/Grid[1]/*[self::Topology or "
        "self::Geometry])\"/>";
    // Function `name` has the value `first` at time 0, one more at time 0.5; each has a mesh of its own, or all
    // include one. The numbers of each array are a file.
    for (const bool shared : {false, true}) {
        XdmfWriter writer(Form::kLittle, folder_);
        const auto shape = [&] { return points_of(mesh, &writer) + cells_of(mesh, &writer); };
        const auto step = [&](const std::string& name, double value, const std::string& time) {
            return grid("<Time Value=\"" + time + "\"/>" + (shared ? both : shape()) +
                        attribute(name, "Node",
                                  writer.item(kFloat64, "64", std::vector<double>(64, value))));
        };
        const auto series = [&](const std::string& name, double first) {
            return grid(step(name, first, "0") + step(name, first + 1, "0.5"), steps);
        };
        const std::string text = file((shared ? grid(shape()) : "") + series("u", 10) +
                                      series("p", 20) + series("T", 30));
        const auto path = folder_.write("m.xdmf", text);
        VolumeOptions options;
        const auto value = [&]() -> float {
            const auto p = converted(path, options);
            return p == nullptr ? -1 : p->texels()[0];
        };
        float wanted = 10;
        for (const char* name : {"u", "p", "T"}) {
            options.field = name;
            options.time.reset();
            EXPECT_EQ(value(), wanted) << name << shared;
            options.time = 0.5;
            EXPECT_EQ(value(), wanted + 1) << name << shared;
            EXPECT_EQ(texture::detached_data(path, {.field = name, .time = 0.5}).size(), 3U);
            wanted += 10;
        }
        options.field = "w";
        EXPECT_EQ(trouble(path, options),
                  fmt::format(texture::messages::kNoSeriesOfField, "w", "`u`, `p`, `T`"));
        options.field.clear();
        EXPECT_EQ(trouble(path, options),
                  fmt::format(texture::messages::kSeveralSeries, "`u`, `p`, `T`"));
    }
}

}  // namespace
}  // namespace openfab::tools
