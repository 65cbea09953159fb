// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The page of `openflc passes` against what the pipeline tells: instructions of each step, in order, by ir::dump.

#include "compiler/driver/passes_page.h"

#include <gmock/gmock.h>

#include <map>
#include <regex>
#include <sstream>

#include "base/json.h"
#include "base/json_text.h"
#include "compiler/diag/sink.h"
#include "compiler/frontend/frontend.h"
#include "compiler/passes/pipeline.h"
#include "tests/support/meshes/temp_folder.h"
#include "tests/support/places/places.h"

namespace openfab::driver {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

/// The instructions of a dump, without numbers of values and names of uniforms.
std::vector<std::string> instructions(const std::string& dump) {
    std::vector<std::string> out;
    std::istringstream lines(dump);
    for (std::string line; std::getline(lines, line);) {
        const size_t is = line.find(" = ");
        if (line.starts_with("    %") && is != std::string::npos)
            out.push_back(line.substr(is + 3, line.find(" %", is + 3) - is - 3));
    }
    return out;
}

struct Made {
    std::string html;
    JsonValue data;
    std::map<std::string, std::vector<std::string>> last;  ///< dumps, by name of the stage
};

Made page_of(const std::filesystem::path& file, const std::string& name,
             passes::PipelineOptions options = {}) {
    source::SourceManager sources;
    diag::Sink sink;
    std::string fault;
    const auto module =
        frontend::compile_to_ir(sources, file, sink, &fault, {.enable_printf = true});
    EXPECT_TRUE(module) << fault;
    Made made;
    if (!module) return made;
    const ir::Fablet* fablet = &module->fablets.front();
    for (const ir::Fablet& one : module->fablets)
        if (one.name == name) fablet = &one;
    PassesPage page(*fablet, sources);
    std::map<const ir::Stage*, std::string> names;
    std::map<std::string, int> count;
    options.after = [&](const std::string& pass, const ir::Stage& stage,
                        const std::string& reason) {
        page.add(pass, stage, reason);
        const std::string dump = ir::dump(stage);
        const std::string kind = dump.substr(8, dump.find('\n') - 8);  // "  stage NAME"
        const auto [at, added] = names.try_emplace(&stage, kind);
        if (added && ++count[kind] > 1) at->second += " " + std::to_string(count[kind]);
        made.last[at->second] = instructions(dump);
    };
    (void)passes::run_pipeline(*fablet, options);
    made.html = page.html();
    const std::string open = "id=\"data\">";
    const size_t begin = made.html.find(open) + open.size();
    std::string json = made.html.substr(begin, made.html.find("</script>", begin) - begin);
    Result<JsonValue> data = parse_json(json, "data");
    EXPECT_TRUE(data) << data.error().text();
    if (data) made.data = std::move(*data);
    return made;
}

/// The instructions of a step of the page.
std::vector<std::string> shown(const JsonValue& data, const JsonValue& step) {
    std::vector<std::string> out;
    for (const JsonValue& value : member_of(step, "values")->items) {
        const auto number = static_cast<size_t>(value.number);
        std::string text = member_of(data, "values")->items[number].items[0].text;
        // A uniform has its name, too.
        out.push_back(
            std::regex_replace(text, std::regex("^(input \\S+ uniform \\S+ \\S+) .*"), "$1"));
    }
    return out;
}

TEST(PassesPage, HasTheInstructionsOfEachStageInOrder) {
    for (const auto& [file, name] :
         {std::pair("bracket/bracket.fl", "Bracket"), {"menger_sponge/menger_sponge.fl", ""}}) {
        const Made made = page_of(testing::source_dir() / "gallery" / file, name);
        size_t stages = 0;
        for (const JsonValue& stage : member_of(made.data, "stages")->items) {
            const auto dumped = made.last.find(member_of(stage, "name")->text);
            ASSERT_NE(dumped, made.last.end());
            EXPECT_EQ(shown(made.data, member_of(stage, "steps")->items.back()), dumped->second)
                << dumped->first;
            ++stages;
        }
        EXPECT_GE(stages, 2U);
    }
}

class PassesOfText : public ::testing::Test {
  protected:
    Made made(const std::string& text, passes::PipelineOptions options = {}) {
        return page_of(folder_.write("a.fl", text), "", std::move(options));
    }
    testing::TempFolder folder_;
};

constexpr const char* kLoop = R"(fablet Loop {
    @uniform { float skin = 1; Material m; }
    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        float x = attr.voxelCenter.x;
        @bound(20) while (abs(x) > skin) x = x / 2 - 0.1;  // </script>
        printf("x %f", x);
        mc.Set(m, x);
        return mc;
    }
})";

TEST_F(PassesOfText, SegmentsAndReasonsAreThere) {
    const Made page = made(kLoop);
    std::vector<std::string> names, reasons;
    for (const JsonValue& stage : member_of(page.data, "stages")->items) {
        names.push_back(member_of(stage, "name")->text);
        for (const JsonValue& step : member_of(stage, "steps")->items)
            reasons.push_back(member_of(step, "reason")->text);
    }
    EXPECT_THAT(names, Contains("volume"));
    EXPECT_THAT(names, Contains("volume_segment"));
    EXPECT_THAT(names, Contains("volume_segment 2"));
    EXPECT_THAT(names, Contains("volume 2"));  // the last segment, in the slab kernel
    EXPECT_THAT(reasons, Contains(HasSubstr("printfs")));
    // The value of a uniform has its name, and its line.
    bool named = false;
    for (const JsonValue& value : member_of(page.data, "values")->items)
        named = named || (value.items[0].text == "input float uniform 0 0 skin" &&
                          value.items[3].number == 7);
    EXPECT_TRUE(named);
    // A source cannot end the script's element.
    EXPECT_THAT(member_of(page.data, "sources")->items[0].members[1].value.text,
                HasSubstr("// </script>"));
    EXPECT_EQ(page.html.find("// </script>"), std::string::npos);
}

TEST_F(PassesOfText, APassThatIsLeftOutIsNoStep) {
    passes::PipelineOptions options;
    options.disabled = {"simplify"};
    const Made page = made(kLoop, options);
    for (const JsonValue& stage : member_of(page.data, "stages")->items)
        for (const JsonValue& step : member_of(stage, "steps")->items)
            EXPECT_NE(member_of(step, "pass")->text, "simplify");
}

}  // namespace
}  // namespace openfab::driver
