// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Tables of inks as files, and the library's lookup against the one of this side.

#include "tools/color/ink_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/meshes/temp_folder.h"
#include "tests/support/says/says.h"
#include "tests/unit/color/synthetic_printer.h"
#include "tools/color/messages.h"

namespace openfab::color {
namespace {

using openfab::testing::SyntheticPrinter;

PrinterProfile profile() {
    SampleTable table = SyntheticPrinter(0.1).measured(0);
    table.samples.resize(100);  // fitting takes the third power of it
    const Result<PrinterModel> model = PrinterModel::fit(table);
    EXPECT_TRUE(model);
    ProfileOptions options;
    options.ink_nodes = options.color_nodes = 5;
    const Result<std::string> made = make_profile(*model, options);
    EXPECT_TRUE(made);
    Result<PrinterProfile> read = PrinterProfile::parse({made->begin(), made->end()});
    EXPECT_TRUE(read);
    return std::move(*read);
}

TEST(InkTable, NodesAreTheProfilesOwnWithinTheLimit) {
    const PrinterProfile known = profile();
    BakeOptions options;
    options.limit = 0.7;
    const Result<InkTable> table = InkTable::bake(known, options);
    ASSERT_TRUE(table) << table.error().text();
    std::vector<Rgb> nodes;
    for (const int r : {0, 7, 32}) {
        for (const int g : {0, 19, 32}) {
            for (const int b : {0, 1, 32})
                nodes.push_back({r / 32.0, g / 32.0, b / 32.0});
        }
    }
    const Result<std::vector<Inks>> exact = known.to_inks(nodes, options.intent, false);
    ASSERT_TRUE(exact);
    for (size_t i = 0; i < nodes.size(); ++i) {
        const Inks found = table->at(nodes[i]), wanted = limited((*exact)[i], options.limit);
        double sum = 0;
        for (size_t k = 0; k < 4; ++k) {
            EXPECT_NEAR(found[k], wanted[k], 1.01 / 65535);  // of 16 bits
            sum += found[k];
        }
        EXPECT_LE(sum, options.limit + 1e-9);
    }
}

TEST(InkTable, IsReadBackFromItsFile) {
    const Result<InkTable> table = InkTable::bake(profile(), {});
    ASSERT_TRUE(table);
    const openfab::testing::TempFolder folder;
    const std::filesystem::path file = folder.path() / "inks.nrrd";
    std::ofstream(file, std::ios::binary) << table->format("two\nlines");
    const Result<InkTable> back = InkTable::read(file);
    ASSERT_TRUE(back) << back.error().text();
    for (const Rgb& colour : {Rgb{0.1, 0.5, 0.9}, Rgb{1, 1, 1}, Rgb{0.333, 0.333, 0.333}}) {
        for (size_t k = 0; k < 4; ++k)
            EXPECT_NEAR(back->at(colour)[k], table->at(colour)[k], 1e-7);
    }
    std::ofstream(file, std::ios::binary)
        << "NRRD0004\ntype: float\ndimension: 3\nsizes: 1 1 1\nencoding: raw\nendian: "
           "little\n\n0000";
    EXPECT_THAT(InkTable::read(file).error().text(),
                testing::Says(messages::kInkTableSides, "1", "1", "1", "1"));
}

TEST(InkTable, TetrahedraAreExactOnTheirEdgesAndLinearOnGreys) {
    const Result<InkTable> table = InkTable::bake(profile(), {});
    ASSERT_TRUE(table);
    const auto node = [&](int r, int g, int b) {
        return table->at({r / 32.0, g / 32.0, b / 32.0});
    };
    for (int i = 0; i < 32; ++i) {
        const Inks a = node(i, i, i), b = node(i + 1, i + 1, i + 1);
        const double v = (i + 0.25) / 32;
        const Inks between = table->at({v, v, v});
        for (size_t k = 0; k < 4; ++k)
            EXPECT_NEAR(between[k], a[k] * 0.75 + b[k] * 0.25, 1e-12);
    }
}

}  // namespace
}  // namespace openfab::color
