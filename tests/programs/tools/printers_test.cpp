// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab printers`, and that each printer prints in each format that its front end takes.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "backends/formats/formats.h"
#include "base/messages.h"
#include "mesh/load/load_mesh.h"
#include "mesh/read/threemf.h"
#include "mesh/read/zip_file.h"
#include "program/messages.h"
#include "tests/programs/tools/openfab_print.h"
#include "tests/support/places/places.h"
#include "tests/support/process/process.h"
#include "tests/support/says/says.h"
#include "world/printer.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

constexpr const char* kTinyWorld = R"({
  "openfab": 1,
  "fablets": {"plain": {"source": "plain.fl", "fablet": "Plain"}},
  "materials": {"resin": {"key": "#ffffff"}},
  "meshes": {"block": {"box": [0.8, 0.6, 0.5]}},
  "objects": {"thing": {"mesh": "block", "fablet": "plain", "uniforms": {"body": "resin"}}},
  "build": [{"object": "thing"}]
}
)";

class Printers : public ::testing::Test {
  protected:
    Printers() {
        scratch_.write("plain.fl", kFablet);
        scratch_.write("tiny.fab.json", kTinyWorld);
    }
    std::string path(const std::string& name) const { return (scratch_ / name).string(); }
    Outcome openfab(std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(), program("openfab"));
        return run(arguments, {{{"OPENFAB_CACHE", path("cache")}}, {}, {}});
    }
    Outcome print(std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(), {"print", path("tiny.fab.json")});
        return openfab(std::move(arguments));
    }

    ScratchFolder scratch_;
};

TEST_F(Printers, AreListedWithWhatIsKnown) {
    const Outcome table = openfab({"printers"});
    EXPECT_EQ(table.exit_code, 0) << table.err;
    for (const std::string& name : world::printer_names())
        EXPECT_THAT(table.out, HasSubstr("\n" + name + " "));
    const Outcome sheet = openfab({"printers", "j850"});
    EXPECT_THAT(sheet.out, HasSubstr("Stratasys J850 Prime"));
    EXPECT_THAT(sheet.out, HasSubstr("490 x 390 x 200 mm"));
    EXPECT_THAT(sheet.out, HasSubstr("600 x 300 dpi"));
    EXPECT_THAT(sheet.out, HasSubstr("Guide-to-Voxel-Printing"));
    EXPECT_THAT(sheet.out, HasSubstr("Not known:"));
    EXPECT_THAT(openfab({"printers", "--json"}).out, HasSubstr("\"name\": \"j850\""));
    const Outcome wrong = openfab({"printers", "j8500"});
    EXPECT_EQ(wrong.exit_code, 1);
    EXPECT_THAT(wrong.err, testing::Says(messages::kDidYouMean, "j850"));
}

TEST_F(Printers, PrintInEachFormatOfTheirFrontEnds) {
    for (const std::string& name : world::printer_names()) {
        const Result<world::Printer> printer = world::load_printer(name);
        ASSERT_TRUE(printer);
        std::vector<std::string> formats = printer->formats;
        if (formats.empty()) formats = {printer->native_format};
        for (const std::string& format : formats) {
            SCOPED_TRACE(fmt::format("{} {}", name, format));
            const fs::path out = path(fmt::format("{}_{}", name, format));
            std::vector<std::string> words = {
                "--printer",
                name,
                "--format",
                format,
                "-o",
                out.string() + (format == "png" || format == "bmp" ? ""
                                : format == "filament"             ? ".3mf"
                                                                   : "." + format)};
            if (!(printer->pitch_mm.x > 0)) words.insert(words.end(), {"--dpi", "300x300"});
            if (!(printer->pitch_mm.z > 0)) words.insert(words.end(), {"--layer", "50um"});
            const Outcome outcome = print(words);
            EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
            if (format != "png") continue;
            EXPECT_THAT(read_file(out / "HANDOFF.txt"), HasSubstr(printer->handoff));
            EXPECT_THAT(read_file(out / "HANDOFF.txt"), HasSubstr("printer             " + name));
        }
    }
}

/// Two parts of yellow and one of magenta, in quarters.
void expect_mixture(const std::string& file) {
    const Result<mesh::MeshSource> source = mesh::parse_threemf(read_file(file), file);
    ASSERT_TRUE(source) << source.error().text();
    std::map<std::string, double> shares;
    for (const mesh::Look& look : source->looks) {
        for (const auto& [part, share] : look.mixture)
            shares[source->looks[static_cast<size_t>(part)].name] = share;
    }
    EXPECT_EQ(shares, (std::map<std::string, double>{{"magenta", 0.25}, {"yellow", 0.75}}));
}

/// What the reader of a file sees is what the fablet asks for, or it is told. A body of two parts of yellow and one
/// of magenta is orange: slices have both inks, a coloured mesh has the colour, and other meshes say what is lost.
TEST_F(Printers, HaveTheMixtureOrTellInEachFormat) {
    scratch_.write("orange.fl", R"(fablet Orange {
    @uniform { Material yellow, magenta; }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        mc.Set(yellow, 2);
        mc.Set(magenta, 1);
        return mc;
    }
}
)");
    scratch_.write("orange.fab.json", R"({"openfab": 1,
        "fablets": {"orange": {"source": "orange.fl", "fablet": "Orange"}},
        "materials": {"yellow": {"key": "#ffe700"}, "magenta": {"key": "#e1007c"}},
        "meshes": {"block": {"box": [0.8, 0.6, 0.5]}},
        "objects": {"thing": {"mesh": "block", "fablet": "orange", "uniforms": {"yellow": "yellow", "magenta": "magenta"}}},
        "build": [{"object": "thing"}]})");
    int colored = 0;
    for (const std::string& name : world::printer_names()) {
        const Result<world::Printer> printer = world::load_printer(name);
        ASSERT_TRUE(printer);
        if (printer->max_materials < 2) continue;
        for (const backends::Format* format : backends::formats()) {
            SCOPED_TRACE(fmt::format("{} {}", name, format->name));
            const bool is_mesh = format->kind == backends::FormatKind::kMesh;
            const std::string out =
                path(fmt::format("{}_{}", name, format->name)) +
                (format->kind == backends::FormatKind::kFolder ? std::string()
                                                               : std::string(format->extension));
            std::vector<std::string> words{"print",    path("orange.fab.json"),   "--printer", name,
                                           "--format", std::string(format->name), "-o",        out};
            // What is lost is said where little is to be said of the progress, too.
            if (is_mesh || format->of_fractions) words.insert(words.end(), {"--progress", "none"});
            if (!is_mesh) words.insert(words.end(), {"--dpi", "300x300", "--layer", "50um"});
            const Outcome outcome = openfab(words);
            ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
            if (format->of_fractions) {  // one material's
                EXPECT_THAT(outcome.err,
                            Says(program::messages::kLeftOutOfGrey, "yellow", "`magenta`"));
                continue;
            }
            const bool told =
                outcome.err.find(" % of the voxels are mixtures") != std::string::npos;
            if (!is_mesh) {
                EXPECT_FALSE(told) << outcome.err;
                // Both inks have their share of the block's 0.24 mm3.
                EXPECT_THAT(outcome.err, ::testing::Not(HasSubstr("magenta 0 ml")));
                continue;
            }
            if (format->needs_mixtures) {
                EXPECT_FALSE(told) << outcome.err;
                expect_mixture(out);
                continue;
            }
            if (!printer->mesh_colors || format->name != "3mf") {
                EXPECT_TRUE(told) << outcome.err;
                continue;
            }
            ++colored;
            EXPECT_FALSE(told) << outcome.err;
            EXPECT_THAT(outcome.err, Says(program::messages::kColorsOfMixtures, name));
            const Result<mesh::LoadedMesh> loaded = mesh::load_mesh(out, {});
            ASSERT_TRUE(loaded) << loaded.error().text();
            const auto color =
                std::find_if(loaded->mesh.attributes.begin(), loaded->mesh.attributes.end(),
                             [](const auto& a) { return a.name == "color"; });
            ASSERT_NE(color, loaded->mesh.attributes.end());
            // Two parts of #ffe700 (linear 1, 0.80, 0.063 at least) and one of #e1007c (0.75, 0.063, 0.20), by
            // their powers: 0.909, 0.343, 0.093, in sRGB #f49e56, give and take a rounding.
            const std::vector<float>& values = color->values;
            ASSERT_EQ(values.size(), 3u);
            EXPECT_NEAR(values[0], 0.909, 0.005);
            EXPECT_NEAR(values[1], 0.343, 0.005);
            EXPECT_NEAR(values[2], 0.093, 0.003);
        }
    }
    EXPECT_EQ(colored, 2);
}

/// The colours of a file's faces, as it writes them.
std::set<std::string> colors_of(const std::string& file) {
    const std::string bytes = read_file(file);
    const Result<mesh::ZipFile> zip = mesh::ZipFile::open(bytes, file);
    if (!zip) return {zip.error().text()};
    const Result<std::string> model = zip->read("3D/3dmodel.model");
    if (!model) return {model.error().text()};
    constexpr std::string_view kColor = "<m:color color=\"";
    std::set<std::string> out;
    for (size_t at = 0; (at = model->find(kColor, at)) != std::string::npos; at += kColor.size())
        out.insert(model->substr(at + kColor.size(), 9));
    return out;
}

/// A coloured mesh has a colour for each material, not one for each ink; slices have inks.
TEST_F(Printers, ThatTakeColouredMeshesPrintMoreColoursThanInks) {
    constexpr std::array kColors{"e04040", "40a050", "3050c0", "e0c040",
                                 "a050a0", "30b0b0", "808080", "502010"};
    std::string text;
    std::set<std::string> asked;
    for (size_t i = 0; i < kColors.size(); ++i) {
        const double x = static_cast<double>(i) * 2;
        text += fmt::format("o part{}\nusemtl m{}\n", i, i);
        for (int corner = 0; corner < 8; ++corner) {
            text += fmt::format("v {} {} {}\n", x + (corner & 1), corner >> 1 & 1, corner >> 2);
        }
        constexpr std::array<std::array<int, 3>, 12> kFaces{{{0, 2, 3},
                                                             {0, 3, 1},
                                                             {4, 5, 7},
                                                             {4, 7, 6},
                                                             {0, 1, 5},
                                                             {0, 5, 4},
                                                             {2, 6, 7},
                                                             {2, 7, 3},
                                                             {0, 4, 6},
                                                             {0, 6, 2},
                                                             {1, 3, 7},
                                                             {1, 7, 5}}};
        for (const auto& [a, b, c] : kFaces) {
            const int first = static_cast<int>(i) * 8 + 1;
            text += fmt::format("f {} {} {}\n", first + a, first + b, first + c);
        }
    }
    scratch_.write("plain.obj", text);
    std::string looks;
    for (size_t i = 0; i < kColors.size(); ++i) {
        const auto value = std::stoul(kColors[i], nullptr, 16);
        looks += fmt::format("newmtl m{}\nKd {} {} {}\n", i, (value >> 16) / 255.0,
                             (value >> 8 & 255) / 255.0, (value & 255) / 255.0);
        std::string upper = kColors[i];
        std::transform(upper.begin(), upper.end(), upper.begin(), ::toupper);
        asked.insert("#" + upper + "FF");
    }
    scratch_.write("looks.mtl", looks);
    scratch_.write("many.obj", "mtllib looks.mtl\n" + text);
    for (const std::string name : {"mimaki_553", "mimaki_2207"}) {
        SCOPED_TRACE(name);
        const auto made = [&](const std::string& stem) { return path(name + "_" + stem); };
        for (const std::string stem : {"many", "plain"}) {
            const Outcome import = openfab({"import", path(stem + ".obj"), "-o", made(stem),
                                            "--printer", name, "--unit", "mm"});
            ASSERT_EQ(import.exit_code, 0) << import.err;
            EXPECT_THAT(import.err, HasSubstr("-o " + stem + ".3mf"));
            const Outcome outcome =
                openfab({"print", made(stem) + "/" + stem + ".fab.json", "--format", "3mf",
                         "--mesh-pitch", "0.5mm", "-o", made(stem + ".3mf")});
            ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
            EXPECT_THAT(outcome.err, Says(program::messages::kColorsOfPreviews, name));
            EXPECT_THAT(outcome.err, ::testing::Not(HasSubstr("warning: ")));
        }
        EXPECT_EQ(colors_of(made("many.3mf")), asked);
        // Import's shades of grey tell parts apart in slices; nobody asked for them.
        EXPECT_EQ(colors_of(made("plain.3mf")), std::set<std::string>{"#F4F2ECFF"});
        const Outcome slices = openfab({"print", made("many") + "/many.fab.json", "--format", "ofr",
                                        "--voxel", "0.5mm", "-o", made("many.ofr")});
        EXPECT_EQ(slices.exit_code, 1);
        EXPECT_THAT(slices.err, Says(program::messages::kTooManyMaterials, 8, name));
        const Outcome estimate =
            openfab({"print", made("many") + "/many.fab.json", "--estimate", "--voxel", "0.5mm"});
        EXPECT_EQ(estimate.exit_code, 0) << estimate.err;
    }
}

TEST_F(Printers, AskForWhatTheirMakersDoNotPublish) {
    const Outcome plane = print({"--printer", "j55", "-o", path("a.ofr")});
    EXPECT_EQ(plane.exit_code, 1);
    EXPECT_THAT(plane.err,
                Says(program::messages::kPitchNotKnown, program::messages::kResolutionAcross, "j55",
                     "is", "j55", program::messages::kGiveDpi));
    const Outcome both = print({"--printer", "inkjet_kit", "-o", path("bitmaps")});
    EXPECT_EQ(both.exit_code, 1);
    EXPECT_THAT(both.err, Says(program::messages::kPitchNotKnown,
                               program::messages::kResolutionAndThickness, "inkjet_kit", "are"));
    const Outcome thickness =
        print({"--printer", "inkjet_kit", "--dpi", "360x720", "-o", path("bitmaps")});
    EXPECT_THAT(thickness.err, Says(program::messages::kGiveLayer));
    EXPECT_FALSE(fs::exists(path("bitmaps")));
    const Outcome tray = print({"--printer", "inkjet_kit", "--dpi", "360x720", "--layer", "30um",
                                "--crop", "tray", "-o", path("bitmaps")});
    EXPECT_EQ(tray.exit_code, 1);
    EXPECT_THAT(tray.err, Says(program::messages::kTrayNotKnown));
    // Meshes have a pitch of their own.
    EXPECT_EQ(print({"--printer", "mjp_5600", "-o", path("m.stl")}).exit_code, 0);
}

}  // namespace
}  // namespace openfab::testing
