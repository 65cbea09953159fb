// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What each pass makes of small stages: a folder for each pass, a file for each case.
//
//     # What the case shows.
//     longest 10               of cut_segments and split_kernel: operations of the longest kernel
//       stage volume           as ir::dump writes it; or a fablet
//         …
//     =>
//       stage volume           what the pass makes of it, without what it leaves dead; what
//         …                      computes bounds is cleaned, as in the pipeline
//
// OPENFAB_UPDATE=1 in the environment rewrites what is below the arrow; review what changed.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "compiler/passes/attach_footprints.h"
#include "compiler/passes/bound_displacement.h"
#include "compiler/passes/cut_segments.h"
#include "compiler/passes/eliminate_common_values.h"
#include "compiler/passes/eliminate_dead_values.h"
#include "compiler/passes/expand_functions.h"
#include "compiler/passes/expand_picks.h"
#include "compiler/passes/form_demand.h"
#include "compiler/passes/form_shape_bounds.h"
#include "compiler/passes/form_surface_bounds.h"
#include "compiler/passes/form_tables.h"
#include "compiler/passes/form_volume_bounds.h"
#include "compiler/passes/hoist_invariants.h"
#include "compiler/passes/hoist_uniforms.h"
#include "compiler/passes/pipeline.h"
#include "compiler/passes/simplify.h"
#include "compiler/passes/split_kernel.h"
#include "tests/support/ir/read.h"
#include "tests/support/places/places.h"

namespace openfab::passes {

namespace {

namespace fs = std::filesystem;

const fs::path kCases = testing::source_dir() / "tests/golden/passes";
constexpr const char* kArrow = "=>\n";

std::string read_file(const fs::path& path) {
    std::ifstream in(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// `simplify/loops` and so on.
std::vector<std::string> case_names() {
    std::vector<std::string> out;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(kCases)) {
        if (entry.path().extension() != ".ir") continue;
        out.push_back(fs::relative(entry.path(), kCases).replace_extension().generic_string());
    }
    std::sort(out.begin(), out.end());
    return out;
}

struct Input {
    ir::Fablet fablet;
    size_t longest = kMaxKernelOperations;
};

std::string text_of(const ir::Stage& stage) {
    EXPECT_EQ(ir::verify(stage), "");
    return ir::dump(stage);
}

std::string without_dead(ir::Stage stage) {
    EXPECT_EQ(ir::verify(stage), "");
    ir::drop_dead_values(&stage);
    return ir::dump(stage);
}

std::string cleaned(ir::Stage stage) {
    EXPECT_EQ(ir::verify(stage), "");
    simplify(&stage);
    eliminate_common_values(&stage);
    return without_dead(std::move(stage));
}

std::string step_text(const openfab_step& step) {
    constexpr const char* kNames[] = {"kernel", "loop", "loop_end", "query", "printf", "elements"};
    const bool loop = step.kind == OPENFAB_STEP_LOOP || step.kind == OPENFAB_STEP_LOOP_END;
    return loop ? fmt::format("{} while state {}, to {}", kNames[step.kind], step.a, step.b)
                : fmt::format("{} {}", kNames[step.kind], step.a);
}

std::string elements_text(const openfab_elements& elements) {
    constexpr const char* kNames[] = {"load", "store", "fill", "copy"};
    return fmt::format("{} of {} states from {}, {} apart; index {}, value {} + {} k, guard {}",
                       kNames[elements.kind], elements.count, elements.first, elements.apart,
                       elements.index, elements.value, elements.value_apart, elements.guard);
}

std::string segments_text(const SegmentedStage& segments) {
    std::string out;
    for (const ir::Stage& kernel : segments.kernels)
        out += text_of(kernel);
    out += text_of(segments.last);
    for (size_t k = 0; k < segments.queries.size(); ++k) {
        const SegmentQuery& query = segments.queries[k];
        out += fmt::format("  query {} of object {}: guard {}, point {}; gives", k, query.object,
                           query.guard, fmt::join(query.point, " "));
        if (query.stop >= 0) out += fmt::format(" {} {}", query.stop, query.seed);
        for (const openfab_query_output& output : query.outputs)
            out += fmt::format(" {}", output.state);
        out += '\n';
    }
    for (size_t k = 0; k < segments.printfs.size(); ++k) {
        const SegmentPrintf& printf = segments.printfs[k];
        out += fmt::format("  printf {} \"{}\": guard {}, values {}\n", k, printf.call.format,
                           printf.guard, fmt::join(printf.values, " "));
    }
    for (size_t k = 0; k < segments.elements.size(); ++k)
        out += fmt::format("  elements {}: {}\n", k, elements_text(segments.elements[k]));
    for (size_t k = 0; k < segments.steps.size(); ++k)
        out += fmt::format("  step {}: {}\n", k, step_text(segments.steps[k]));
    out += "  states";
    for (const ir::Type type : segments.states)
        out += std::string(" ") + ir::spelling(type);
    return out + '\n';
}

using Run = std::function<std::string(Input)>;

Run rewrites(void (*pass)(ir::Stage*)) {
    return [pass](Input in) {
        ir::Stage& stage = in.fablet.has_surface ? in.fablet.surface : in.fablet.volume;
        pass(&stage);
        return without_dead(stage);
    };
}

std::string hoisted(Input in) {
    UniformHoister hoister(in.fablet.uniform_value_count);
    std::string out;
    if (in.fablet.has_surface) {
        hoister.hoist(&in.fablet.surface);
        out += without_dead(in.fablet.surface);
    }
    hoister.hoist(&in.fablet.volume);
    return out + without_dead(in.fablet.volume) + text_of(hoister.derived());
}

/// Values in the order of the object, behind its uniforms.
std::string tabled(Input in) {
    TableFormer former(in.fablet.uniform_value_count);
    former.form(&in.fablet.volume);
    std::string out = text_of(in.fablet.volume);
    for (const openfab_table_value& value : former.values())
        out += fmt::format("  value from {} bits {}\n", value.from, value.bits);
    return out;
}

/// States beyond those of the kernel are appended.
std::string split(const Input& in) {
    std::vector<ir::Type> states(8, ir::Type::kFloat);
    std::string out;
    for (const ir::Stage& piece : split_kernel(in.fablet.volume, &states, in.longest))
        out += text_of(piece);
    return out;
}

const std::map<std::string, Run>& runs() {
    static const std::map<std::string, Run> runs = {
        {"simplify", rewrites(simplify)},
        {"eliminate_common_values", rewrites(eliminate_common_values)},
        {"eliminate_dead_values", rewrites(eliminate_dead_values)},
        {"attach_footprints", rewrites(attach_footprints)},
        {"form_volume_bounds",
         [](const Input& in) { return cleaned(form_volume_bounds(in.fablet.volume)); }},
        {"form_surface_bounds",
         [](const Input& in) { return cleaned(form_surface_bounds(in.fablet.surface)); }},
        {"form_shape_bounds",
         [](const Input& in) { return cleaned(form_shape_bounds(in.fablet.volume)); }},
        {"form_demand", [](const Input& in) { return text_of(form_demand(in.fablet.volume)); }},
        {"bound_displacement",
         [](Input in) {
             bound_displacement(&in.fablet.surface);
             return cleaned(in.fablet.surface);
         }},
        {"hoist_invariants", rewrites(hoist_invariants)},
        {"expand_functions", rewrites(expand_functions)},
        {"expand_picks", rewrites(expand_picks)},
        {"hoist_uniforms", hoisted},
        {"form_tables", tabled},
        {"cut_segments",
         [](const Input& in) { return segments_text(cut_segments(in.fablet.volume, in.longest)); }},
        {"split_kernel", split},
    };
    return runs;
}

/// `text` without the line `longest N`, whose number goes to `longest`.
std::string take_longest(std::string text, size_t* longest) {
    const std::string key = "\nlongest ";
    const size_t at = text.find(key);
    if (at == std::string::npos) return text;
    *longest = std::strtoul(text.c_str() + at + key.size(), nullptr, 10);
    return text.erase(at + 1, text.find('\n', at + 1) - at);
}

class PassGolden : public ::testing::TestWithParam<std::string> {};

TEST_P(PassGolden, MakesOfItsInputWhatIsBelowTheArrow) {
    const fs::path path = kCases / (GetParam() + ".ir");
    const std::string text = read_file(path);
    ASSERT_EQ(text.substr(0, 2), "# ") << "the first line says what the case shows";
    const size_t arrow = text.find(kArrow);
    ASSERT_NE(arrow, std::string::npos);
    const std::string head = text.substr(0, arrow);

    Input input;
    std::string fault;
    const std::optional<ir::Fablet> fablet = ir::read(take_longest(head, &input.longest), &fault);
    ASSERT_TRUE(fablet.has_value()) << fault;
    ASSERT_EQ(ir::verify(fablet->surface), "");
    ASSERT_EQ(ir::verify(fablet->volume), "");
    input.fablet = *fablet;
    const auto run = runs().find(path.parent_path().filename().string());
    ASSERT_NE(run, runs().end()) << "a folder is named after its pass";

    const std::string output = head + kArrow + run->second(input);
    if (std::getenv("OPENFAB_UPDATE") != nullptr) std::ofstream(path, std::ios::binary) << output;
    EXPECT_EQ(output, text);
}

INSTANTIATE_TEST_SUITE_P(Passes, PassGolden, ::testing::ValuesIn(case_names()),
                         [](const auto& info) {
                             std::string name = info.param;
                             std::replace(name.begin(), name.end(), '/', '_');
                             return name;
                         });

TEST(PassGoldenCases, EachPassHasTwo) {
    std::map<std::string, int> cases;
    for (const std::string& name : case_names())
        ++cases[name.substr(0, name.find('/'))];
    for (const auto& [pass, run] : runs())
        EXPECT_GE(cases[pass], 2) << pass;
    // They measure and drop, and rewrite nothing.
    const std::set<std::string> limits = {"drop_long_bounds", "measure_stages"};
    for (const PassName& pass : pass_names())
        EXPECT_TRUE(runs().contains(pass.name) || limits.contains(pass.name)) << pass.name;
}

}  // namespace

}  // namespace openfab::passes
