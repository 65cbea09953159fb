// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab import` of prints: what is imported prints the same voxels again, from each kind of output.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/programs/tools/openfab_print.h"
#include "tests/support/says/says.h"
#include "tools/openfab/messages.h"
#include "tools/texture/messages.h"

namespace openfab::testing {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

// Without a plane of symmetry, so that what is turned or mirrored is another print.
constexpr const char* kMixture = R"(fablet Mixture {
    @uniform { Material a, b, c; }
    @Volume(@varying { VolumeAttributes attr }) {
        float3 p = attr.voxelCenter;
        MaterialComposition mc;
        if (p.x > 1.2 && p.y > 0.7 && p.z > 0.4) return mc;
        if (p.x + 2 * p.y > 1) {
            mc.Set(a, 1);
        } else {
            mc.Set(b, 0.7);
            mc.Set(c, 0.3);
        }
        return mc;
    }
}
)";

constexpr const char* kMixed = R"({
  "openfab": 1,
  "printer": "generic",
  "fablets": {"mixture": {"source": "mixture.fl", "fablet": "Mixture"}},
  "materials": {"red": {"key": "#ff0000", "density_g_cm3": 1.2}, "soft \"b\"": {"key": "#00ff00"},
                "clear": {"key": "#0000ff"}},
  "meshes": {"block": {"box": [4, 3, 2]}},
  "objects": {"thing": {"mesh": "block", "fablet": "mixture",
              "uniforms": {"a": "red", "b": "soft \"b\"", "c": "clear"}}},
  "build": [{"object": "thing", "translate_mm": [7, -3, 1]}]
}
)";

class ImportOfPrints : public OpenfabPrint {
  protected:
    ImportOfPrints() {
        scratch_.write("mixture.fl", kMixture);
        scratch_.write("mixed.fab.json", kMixed);
    }
    Outcome openfab(std::vector<std::string> arguments) const {
        arguments.insert(arguments.begin(), program("openfab"));
        return run(arguments, {{{"OPENFAB_CACHE", path("cache")}}, {}, {}});
    }
    /// A line of `openfab info`, without its label.
    std::string info(const std::string& file, const std::string& label) const {
        const std::string text = openfab({"info", path(file)}).out;
        const size_t at = text.find(label);
        if (at == std::string::npos) return "none in: " + text;
        const size_t from = text.find_first_not_of(' ', at + label.size());
        return text.substr(from, text.find('\n', from) - from);
    }
    void print_mixed(const std::string& output, std::vector<std::string> more = {}) const {
        more.insert(more.begin(), {path("mixed.fab.json"), "--dpi", "150x100", "--layer", "0.3mm",
                                   "-o", path(output)});
        const Outcome outcome = print(more);
        ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    }
    void import(const std::string& output, const std::string& folder) const {
        const Outcome outcome = openfab({"import", path(output), "-o", path(folder)});
        ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    }
    void print_again(const std::string& world, const std::string& output) const {
        const Outcome outcome = print({path(world), "-o", path(output)});
        ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    }
};

TEST_F(ImportOfPrints, PrintsTheSameVoxelsAgain) {
    print_mixed("first.ofr");
    const std::string hash = info("first.ofr", "hash ");
    struct {
        const char* output;
        std::vector<std::string> options;
    } const forms[] = {{"a.ofr", {}},
                       {"b.gcvf", {}},
                       {"c", {"--format", "png"}},
                       {"d", {"--format", "png", "--png", "indexed", "--flip-x"}},
                       {"e", {"--format", "bmp"}}};
    for (const auto& [output, options] : forms) {
        SCOPED_TRACE(output);
        print_mixed(output, options);
        const std::string stem = fs::path(output).stem();
        ASSERT_NO_FATAL_FAILURE(import(output, "of_" + stem));
        // Nothing but the folder is needed.
        fs::remove_all(path(output));
        ASSERT_NO_FATAL_FAILURE(
            print_again(fmt::format("of_{0}/{0}.fab.json", stem), stem + "_again.ofr"));
        EXPECT_EQ(info(stem + "_again.ofr", "hash "), hash);
        EXPECT_EQ(info(stem + "_again.ofr", "pitch "), info("first.ofr", "pitch "));
        EXPECT_EQ(info(stem + "_again.ofr", "material    1 "), info("first.ofr", "material    1 "));
        // A GCVF does not say where it lies.
        EXPECT_EQ(info(stem + "_again.ofr", "origin "),
                  stem == "b" ? "0.000 0.000 0.000 mm" : info("first.ofr", "origin "));
    }
}

TEST_F(ImportOfPrints, SlicesOfAPrintStayAtTheirPlace) {
    print_mixed("whole.ofr");
    print_mixed("some.ofr", {"--slices", "2:5"});
    ASSERT_NO_FATAL_FAILURE(import("some.ofr", "some"));
    ASSERT_NO_FATAL_FAILURE(print_again("some/some.fab.json", "again.ofr"));
    EXPECT_EQ(info("again.ofr", "material    1 "), info("some.ofr", "material    1 "));
    EXPECT_EQ(info("again.ofr", "slices "), "0 to 2");
    // The whole print begins at 0.9 mm; two layers of 0.3 mm are below.
    EXPECT_THAT(info("again.ofr", "origin "), HasSubstr(" 1.500 mm"));
}

TEST_F(ImportOfPrints, AnUnfinishedPrintIsRefused) {
    print_mixed("folder", {"--format", "png"});
    fs::remove(path("folder/slice_0003.png"));
    EXPECT_THAT(openfab({"import", path("folder"), "-o", path("x")}).err,
                Says(tools::messages::kSlicesMissing, path("folder"), "2", "*"));
    EXPECT_FALSE(fs::exists(path("x")));
    print_mixed("part.ofr");
    EXPECT_THAT(openfab({"import", path("part.ofr"), "-o", path("x"), "--size", "60mm"}).err,
                Says(tools::messages::kMeansNothingForPrints, "--size"));
}

// A package becomes any other form of the same print.
TEST_F(ImportOfPrints, ExportsOfPackagesAndFoldersAreTheSamePrint) {
    print_mixed("first.ofr");
    print_mixed("b.gcvf");
    print_mixed("c", {"--format", "png"});
    for (const char* from : {"b.gcvf", "c"}) {
        const Outcome outcome = openfab({"export", path(from), "-o", path("out.ofr")});
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        EXPECT_EQ(info("out.ofr", "hash "), info("first.ofr", "hash "));
        EXPECT_EQ(openfab({"verify", path("out.ofr")}).exit_code, 0);
    }
    EXPECT_EQ(info("b.gcvf", "voxels "), info("first.ofr", "voxels "));
    EXPECT_EQ(info("b.gcvf", "complete "), "yes");
    // Without densities, which it does not have.
    EXPECT_THAT(info("first.ofr", "material    3 "), HasSubstr(info("b.gcvf", "material    3 ")));
}

// The fractions of a material, at their place and right way up.
TEST_F(ImportOfPrints, GreySlicesAreAVolume) {
    scratch_.write("sampled.fl", R"(fablet Sampled {
    @uniform { ImageTexture3D share; Material a; }
    @Volume(@varying { VolumeAttributes attr }) {
        MaterialComposition mc;
        if (share.Sample1(attr.voxelCenter + float3(7, -3, 1), 0) > 0.5) mc.Set(a, 1);
        return mc;
    }
}
)");
    scratch_.write("sampled.fab.json", R"({
  "openfab": 1, "printer": "generic",
  "fablets": {"sampled": {"source": "sampled.fl", "fablet": "Sampled"}},
  "materials": {"red": {"key": "#ff0000"}},
  "textures": {"share": {"file": "grey", "filter": "nearest", "wrap": "black"}},
  "meshes": {"block": {"box": [4, 3, 2]}},
  "objects": {"thing": {"mesh": "block", "fablet": "sampled", "uniforms": {"share": "share", "a": "red"}}},
  "build": [{"object": "thing", "translate_mm": [7, -3, 1]}]
})");
    print_mixed("first.ofr");
    for (const std::vector<std::string>& form : {std::vector<std::string>{"--format", "grey"},
                                                 {"--format", "grey", "--flip-x"},
                                                 {"--format", "tiff"}}) {
        SCOPED_TRACE(form.back());
        std::vector<std::string> options = form;
        options.insert(options.end(), {"--grey-material", "red"});
        fs::remove_all(path("grey"));
        ASSERT_NO_FATAL_FAILURE(print_mixed("grey", options));
        const Outcome outcome = print({path("sampled.fab.json"), "--dpi", "150x100", "--layer",
                                       "0.3mm", "-o", path("again.ofr")});
        ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
        EXPECT_EQ(info("again.ofr", "material    1 ").substr(0, 20),
                  info("first.ofr", "material    1 ").substr(0, 20));
    }
    fs::remove(path("grey/slice_0003.tif"));
    EXPECT_THAT(print({path("sampled.fab.json"), "-o", path("x.ofr")}).err,
                HasSubstr(fmt::format(tools::messages::kPrintLacksSlices, 2, 7)));
}

}  // namespace
}  // namespace openfab::testing
