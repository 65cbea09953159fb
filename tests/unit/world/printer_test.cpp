// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Printer profiles: what is read, what is refused, and that each figure of a machine has a source.

#include "world/printer.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <set>

#include "base/json.h"
#include "base/messages.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/support/places/places.h"
#include "world/messages.h"
#include "world/printer_list.h"

namespace openfab::world {
namespace {

using ::testing::HasSubstr;

TEST(Printer, HasTheProfilesOfTheDesign) {
    const Result<Printer> j750 = load_printer("j750");
    ASSERT_TRUE(j750) << j750.error().text();
    EXPECT_EQ(j750->pitch_mm, (Vec3d{25.4 / 600, 25.4 / 300, 0.027}));
    EXPECT_EQ(j750->native_format, "png");
    EXPECT_EQ(load_printer("j750_hq")->pitch_mm.z, 0.014);
    EXPECT_EQ(load_printer("connex500")->pitch_mm, (Vec3d{25.4 / 600, 25.4 / 600, 0.03}));
    EXPECT_EQ(load_printer("generic")->pitch_mm, (Vec3d{0.1, 0.1, 0.1}));
    for (const std::string& name : printer_names()) {
        EXPECT_EQ(load_printer(name)->name, name);
        EXPECT_FALSE(load_printer(name)->handoff.empty());
    }
    EXPECT_EQ(load_printer("mimaki_55").error().text(),
              fmt::format(messages::kNoSuchPrinter, "mimaki_55", ".printer.json",
                          fmt::format(openfab::messages::kDidYouMean, "mimaki_553")));
}

TEST(Printer, IsReadFromAFile) {
    const testing::TempFolder folder;
    const std::string good =
        folder
            .write("a.printer.json",
                   R"({"name": "mine", "pitch_mm": [0.2, 0.2, 0.05], "max_materials": 3})")
            .string();
    const Result<Printer> mine = load_printer(good);
    ASSERT_TRUE(mine) << mine.error().text();
    EXPECT_EQ(mine->name, "mine");
    EXPECT_EQ(mine->max_materials, 3);
    const auto error_of = [&](const char* text) {
        const std::string file = folder.write("b.printer.json", text).string();
        const Result<Printer> printer = load_printer(file);
        return printer ? "no error" : printer.error().text().substr(file.size() + 1);
    };
    EXPECT_EQ(error_of(R"({"name": "x"})"), std::string("1:1: ") + messages::kPitchNotClear + "; " +
                                                messages::kPitchNotClearHelp);
    EXPECT_EQ(error_of(R"({"name": "x", "dpi": [600, 0], "layer_um": 27})"),
              std::string("1:22: ") + messages::kPitchOutside);
    EXPECT_EQ(
        error_of(R"({"name": "x", "pitch_mm": [1, 1, 1], "colour": 1})"),
        "1:38: " + fmt::format(messages::kUnknownKey, "colour", "the printer") + "; " +
            fmt::format(
                openfab::messages::kKnownNames,
                "`name`, `maker`, `model`, `dpi`, `layer_um`, `layers_um`, `pitch_mm`, "
                "`build_volume_mm`, `max_materials`, `native_format`, `formats`, `mesh_colors`" +
                    fmt::format(openfab::messages::kAndMore, 8)));
    EXPECT_EQ(
        error_of(R"({"name": "x", "pitch_mm": [1, 1, 1], "support_material": {"key": "red"}})"),
        "1:66: `key` of the support material is `red`; " +
            fmt::format(messages::kWriteItAs, messages::kOpaqueColourForm));
    EXPECT_TRUE(mine->makes_support);
    const Result<Printer> supporting =
        load_printer(folder
                         .write("c.printer.json",
                                R"({"name": "x", "pitch_mm": [1, 1, 1], "makes_support": false,
                       "support_material": {"name": "wax", "key": "#112233", "density_g_cm3": 0.9}})")
                         .string());
    ASSERT_TRUE(supporting) << supporting.error().text();
    EXPECT_FALSE(supporting->makes_support);
    EXPECT_EQ(supporting->support_material.name, "wax");
    EXPECT_EQ(supporting->support_material.key, (std::array<uint8_t, 4>{0x11, 0x22, 0x33, 0xff}));
    EXPECT_EQ(supporting->support_material.channel, "support");
    EXPECT_FALSE(load_printer((folder.path() / "none.printer.json").string()));
}

class PrinterFile : public ::testing::Test {
  protected:
    Result<Printer> load(const std::string& text) {
        return load_printer(folder_.write("p.printer.json", text).string());
    }
    std::string error_of(const std::string& text) {
        const Result<Printer> printer = load(text);
        if (printer) return "no error";
        const std::string found = printer.error().text();
        return found.substr(found.find(".printer.json:") + 14);
    }

    testing::TempFolder folder_;
};

TEST_F(PrinterFile, SaysWhatIsNotKnown) {
    const Result<Printer> half =
        load(R"({"name": "x", "layer_um": 30, "unknown": {"dpi": "a secret", "colour": "none"}})");
    ASSERT_TRUE(half) << half.error().text();
    EXPECT_FALSE(half->knows_pitch());
    EXPECT_EQ(half->pitch_mm, (Vec3d{0, 0, 0.03}));
    EXPECT_TRUE(half->knows_build_volume());
    const std::string sheet = printer_sheet(*half);
    EXPECT_THAT(sheet, HasSubstr("? x ? x 30 um"));
    EXPECT_THAT(sheet, HasSubstr("dpi: a secret"));
    EXPECT_THAT(printers_json({*half}), HasSubstr("[null, null, 0.03]"));

    const Result<Printer> none =
        load(R"({"name": "x", "unknown": {"dpi": "a", "layer_um": "b", "build_volume_mm": "c"}})");
    ASSERT_TRUE(none) << none.error().text();
    EXPECT_FALSE(none->knows_pitch());
    EXPECT_FALSE(none->knows_build_volume());
}

TEST_F(PrinterFile, RefusesWhatContradictsItself) {
    EXPECT_EQ(error_of(R"({"name": "x", "dpi": [9, 9], "layer_um": 9, "unknown": {"dpi": "a"}})"),
              "1:57: " + fmt::format(messages::kGivenAndUnknown, "dpi"));
    EXPECT_EQ(
        error_of(R"({"name": "x", "dpi": [9, 9], "unknown": {"pitch_mm": "a"}})"),
        std::string("1:1: ") + messages::kPitchNotClear + "; " + messages::kPitchNotClearHelp);
    EXPECT_EQ(
        error_of(R"({"name": "x", "pitch_mm": [1, 1, 1], "unknown": {"dpi": "a"}})"),
        std::string("1:1: ") + messages::kPitchNotClear + "; " + messages::kPitchNotClearHelp);
    EXPECT_EQ(error_of(R"({"name": "x", "pitch_mm": [1, 1, 1], "unknown": ["dpi"]})"),
              "1:49: " + fmt::format(messages::kUnknownNoObject, openfab::messages::kKindArray) +
                  "; " + messages::kUnknownNoObjectHelp);
    EXPECT_EQ(
        error_of(R"({"name": "x", "pitch_mm": [1, 1, 1], "inks": {}})"),
        "1:46: " + fmt::format(messages::kNotAnArray, "inks", openfab::messages::kKindObject));
    EXPECT_THAT(error_of(R"({"name": "x", "pitch_mm": [1, 1, 1], "inks": [{"density_g_cm3": 1}]})"),
                HasSubstr(fmt::format(messages::kKeyMissing, "an ink of `inks`", "name")));
    EXPECT_EQ(error_of(R"({"name": "x", "pitch_mm": [1, 1, 1], )"
                       R"("sources": [{"document": "d", "gives": ["inks"]}]})"),
              "1:78: " + fmt::format(messages::kSourceGivesTooMuch, "inks"));
    EXPECT_THAT(error_of(R"({"name": "x", "pitch_mm": [1, 1, 1], )"
                         R"("sources": [{"document": "d", "gives": [], "seen": "maybe"}]})"),
                HasSubstr("`seen` of a source"));
}

/// Whoever adds a figure to a machine's profile says where it is from, or that it is unknown.
TEST(Machines, HaveASourceForEachFigure) {
    const std::set<std::string> words = {"name", "maker", "model", "handoff", "sources", "unknown"};
    int machines = 0;
    for (const std::string& name : printer_names()) {
        SCOPED_TRACE(name);
        const Result<Printer> printer = load_printer(name);
        ASSERT_TRUE(printer) << printer.error().text();
        EXPECT_EQ(printer->name, name);
        EXPECT_FALSE(printer->handoff.empty());
        if (printer->maker.empty()) continue;
        ++machines;
        std::set<std::string> covered;
        for (const PrinterSource& source : printer->sources) {
            EXPECT_FALSE(source.document.empty());
            EXPECT_TRUE(source.url.empty() || source.url.starts_with("https://") ||
                        source.url.starts_with("http://"))
                << source.url;
            covered.insert(source.gives.begin(), source.gives.end());
        }
        const std::filesystem::path file =
            testing::source_dir() / "world/printers" / (name + ".printer.json");
        const Result<JsonValue> root = parse_json(*read_text_file(file, 1'000'000), name);
        ASSERT_TRUE(root);
        for (const JsonMember& member : root->members) {
            if (words.count(member.key) != 0) continue;
            EXPECT_EQ(covered.count(member.key), 1u) << member.key;
        }
        // These are in a profile, or it says why not.
        for (const char* figure : {"dpi", "layer_um", "layer_time_s", "build_volume_mm", "inks"}) {
            const bool unknown =
                std::any_of(printer->unknown.begin(), printer->unknown.end(),
                            [&](const auto& entry) { return entry.first == figure; });
            EXPECT_TRUE(root->find(figure) != nullptr || unknown) << figure;
        }
        ASSERT_FALSE(printer->formats.empty());
        EXPECT_EQ(printer->formats.front(), printer->native_format);
        if (printer->pitch_mm.z > 0 && !printer->layers_um.empty()) {
            EXPECT_THAT(printer->layers_um, ::testing::Contains(::testing::DoubleNear(
                                                printer->pitch_mm.z * 1000, 1e-9)));
        }
        EXPECT_THAT(printer_sheet(*printer), HasSubstr(printer->model));
    }
    EXPECT_GE(machines, 15);
}

}  // namespace
}  // namespace openfab::world
