// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Schedule files: what is accepted, what it is bound to, and where and why what is wrong is
// reported.

#include "compiler/schedule/schedule.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <map>

#include "base/messages.h"

namespace openfab::schedule {

namespace {

/// A mistake as it is shown: the place, what is marked there, the message and the help.
std::string shown(const Fault& fault, const std::string& text) {
    const std::string marked = text.substr(fault.offset, static_cast<size_t>(fault.length));
    return std::to_string(fault.line) + ":" + std::to_string(fault.column) + " |" + marked + "| " +
           fault.message + (fault.help.empty() ? "" : "; " + fault.help);
}

std::string fault_of(const std::string& text, const Binding& binding = {}) {
    auto made = read({"slab.sched", text}, binding);
    if (const auto* fault = std::get_if<Fault>(&made)) return shown(*fault, text);
    return "accepted";
}

std::string bound(const std::string& text, const Binding& binding = {}) {
    auto made = read({"slab.sched", text}, binding);
    if (const auto* fault = std::get_if<Fault>(&made)) return shown(*fault, text);
    return text_of(std::get<Schedule>(made));
}

TEST(Schedule, ParsesChainsCommentsAndBlankLines) {
    EXPECT_EQ(
        bound("# comment\n\n  weights.vectorize( z ) . parallel(n)  # more\na_*.compute_root()"),
        "weights.vectorize(z).parallel(n)\na_*.compute_root()\n");
    EXPECT_EQ(
        bound("weights.split(y, yo, yi, 4)  # rows\n       .vectorize(z)\n\n    .unroll(yi)\n"),
        "weights.split(y, yo, yi, 4).vectorize(z).unroll(yi)\n");
    EXPECT_EQ(bound(""), "");
}

TEST(Schedule, CanonicalTextBindsToItself) {
    const std::string text =
        "param rows = 4 in {2, 4, 8}\n"
        "when avx2 {\n  weights . split(y, yo,yi, rows)\n} else { weights.vectorize(z) }\n"
        "weights.specialize(n%rows==0).parallel(n)\n";
    for (const char* target : {"sse41", "avx2"}) {
        const std::string canonical = bound(text, {.target = target, .params = {}});
        EXPECT_EQ(bound(canonical, {.target = "avx512", .params = {}}), canonical);
    }
    EXPECT_EQ(bound(text, {.target = "avx2", .params = {{"rows", 8}}}),
              "weights.split(y, yo, yi, 8)\nweights.specialize(n % 8 == 0).parallel(n)\n");
}

TEST(Schedule, ATargetHasAllBeforeIt) {
    const std::string text =
        "when avx512 { a.vectorize(x, vector_lanes) } else when avx2 { b.vectorize(x, "
        "vector_lanes) }"
        " else { c.vectorize(x, vector_lanes) }\n"
        "when avx2 and not avx512 or sse41 and vector_lanes == 4 { d.parallel(n) }\n";
    const auto for_target = [&](const char* t) { return bound(text, {.target = t, .params = {}}); };
    EXPECT_EQ(for_target("sse41"), "c.vectorize(x, 4)\nd.parallel(n)\n");
    EXPECT_EQ(for_target("avx2"), "b.vectorize(x, 8)\nd.parallel(n)\n");
    EXPECT_EQ(for_target("avx512"), "a.vectorize(x, 16)\n");
}

TEST(Schedule, ParametersDecideNumbersAndBranches) {
    const std::string text =
        "param batch = 16 in [4, 64]\nwhen batch >= 32 { a.parallel(n) }\n"
        "a.split(n, no, ni, batch)\n";
    EXPECT_EQ(bound(text), "a.split(n, no, ni, 16)\n");
    EXPECT_EQ(bound(text, {.target = "avx2", .params = {{"batch", 32}}}),
              "a.parallel(n)\na.split(n, no, ni, 32)\n");
    EXPECT_EQ(fault_of(text, {.target = "avx2", .params = {{"batch", 65}}}),
              "1:7 |batch| `batch` is set to 65, which is not in [4, 64]");
    auto file = parse({"slab.sched", text});
    EXPECT_TRUE(has_param(std::get<File>(file), "batch"));
    EXPECT_FALSE(has_param(std::get<File>(file), "a"));
}

/// Mistakes that the file alone shows.
TEST(Schedule, MarksMistakesOfForm) {
    const std::map<std::string, std::string> cases = {
        {"weights.vectorize(z)\nweights.vektorize(x)\n",
         "2:9 |vektorize| no directive is called `vektorize`; " +
             fmt::format(openfab::messages::kDidYouMean, "vectorize")},
        {"weights.split(z, zo, zi)",
         "1:9 |split| `split` with 3 arguments; its form is `split(var, outer, inner, factor)`"},
        {"weights.parallel(z, 2)",
         "1:9 |parallel| `parallel` with 2 arguments; its form is `parallel(var)`"},
        {"weights.vectorize z", "1:19 |z| expected `(` after a directive's name"},
        {"weights.vectorize(z", "1:20 || expected `,` or `)` after an argument"},
        {"weights.vectorize(z x)", "1:21 |x| expected `,` or `)` after an argument"},
        {"weights.vectorize(, x)", "1:19 |,| expected a name or a number"},
        {"weights",
         "1:1 |weights| `weights` has no directive; write one after a dot, as in "
         "`weights.vectorize(z)`"},
        {"weights.", "1:9 || expected a directive after `.`"},
        {"weights.parallel(n) x", "1:21 |x| expected `.` or the end of the line"},
        {"\n\n.vectorize(z)", "3:1 |.| expected the name of a func"},
        {"va*s.parallel(n)", "1:1 |va*s| `*` stands at the end of a name, for all that begin so"},
        {"weights.parallel(n);", "1:20 |;| no word or sign of a schedule begins so"},
        {"weights.specialize(n)",
         "1:21 |)| expected a comparison; its form is "
         "`specialize(var >= number)`"},
        // Numbers and parameters.
        {"weights.split(z, a, b, batch)",
         "1:24 |batch| `batch` is not a number, nor a parameter from a line before; there are "
         "vector_lanes"},
        {"param batch = 4 in [1, 8]\nweights.split(z, a, b, bacth)",
         "2:24 |bacth| `bacth` is not a number, nor a parameter from a line before; " +
             fmt::format(openfab::messages::kDidYouMean, "batch")},
        {"weights.split(z, a, b, 70000)", "1:24 |70000| expected a whole number up to 65536"},
        {"param batch = 3 in [4, 64]", "1:15 |3| 3 is not in [4, 64]"},
        {"param batch = 4 in [8, 4]", "1:20 |[| a range is `[least, most]`"},
        {"param batch = 4",
         "1:16 || expected `in` and the values that the parameter may have, as "
         "in `in [4, 64]`"},
        {"param batch = x in [1, 2]", "1:15 |x| expected a whole number from 1 to 65536"},
        {"param vector_lanes = 4 in [1, 8]",
         "1:7 |vector_lanes| `vector_lanes` cannot name a parameter"},
        {"param b = 4 in [1, 8]\nparam b = 4 in [1, 8]",
         "2:7 |b| there is a parameter `b` already, of line 1"},
        // Branches.
        {"when avx { a.parallel(n) }", "1:6 |avx| no target is called `avx`; " +
                                           fmt::format(openfab::messages::kDidYouMean, "avx2")},
        {"when avx2 a.parallel(n)", "1:11 |a| expected `{` before the lines that depend on it"},
        {"when avx2 { a.parallel(n)", "1:26 || expected `}` after the lines that depend on `when`"},
        {"}", "1:1 |}| no `{` belongs to this `}`"},
        {"else { }", "1:1 |else| `else` follows the `}` of a `when`"},
        // Files.
        {"include common.sched",
         "1:9 |common| expected the name of a file in quotes; write `include \"common.sched\"`"},
        {"include \"x", "1:9 |\"| this name has no closing `\"`"},
        {"pipeline slab\npipeline surface",
         "2:1 |pipeline| a file is for one pipeline, whatever the target"},
    };
    for (const auto& [text, expected] : cases)
        EXPECT_EQ(fault_of(text), expected) << text;
}

TEST(Schedule, SaysWhyHalidesOthersAreNotAllowed) {
    EXPECT_EQ(fault_of("weights.rfactor(z)"),
              "1:9 |rfactor| `rfactor` is not allowed in a schedule; floats are added up in one "
              "order in every schedule, or their last bits would differ");
    for (const char* text :
         {"weights.atomic()", "weights.memoize()", "weights.allow_race_conditions()",
          "weights.async()", "weights.bound(z, 0, 8)", "weights.compute_with(a, x)",
          "weights.gpu_blocks(x)"}) {
        EXPECT_NE(fault_of(text).find("is not allowed"), std::string::npos) << text;
    }
}

TEST(Schedule, ReadsFilesThatItIncludes) {
    const std::map<std::string, std::string> files = {
        {"a.sched", "param rows = 2 in [1, 8]\ninclude \"b.sched\"\n"},
        {"b.sched", "w.split(y, yo, yi, rows)\n"},
        {"self.sched", "include \"self.sched\""},
        {"bad.sched", "w.parallel(n)\nw.vektorize(z)\n"},
        {"named.sched", "pipeline slab\ninclude \"b.sched\"\n"}};
    uint32_t last = 0;
    const OpenFile open = [&](const std::string& name,
                              const Source&) -> std::variant<Source, std::string> {
        const auto file = files.find(name);
        if (file == files.end()) return "there is none";
        return Source{name, file->second, ++last};
    };
    const auto parse_main = [&](const std::string& text) {
        last = 1;
        return parse({"main.sched", text, 1}, open);
    };
    auto made = parse_main("include \"a.sched\"\nw.unroll(yi, rows)");
    auto schedule = bind(std::get<File>(made));
    EXPECT_EQ(text_of(std::get<Schedule>(schedule)), "w.split(y, yo, yi, 2)\nw.unroll(yi, 2)\n");
    const auto fault = [&](const std::string& text) {
        auto result = parse_main(text);
        const auto& found = std::get<Fault>(result);
        return std::to_string(found.file) + ":" + std::to_string(found.line) + " " + found.message;
    };
    EXPECT_EQ(fault("\ninclude \"c.sched\""), "1:2 `c.sched` cannot be included");
    EXPECT_EQ(fault("include \"self.sched\""), "2:1 `self.sched` includes itself");
    EXPECT_EQ(fault("include \"bad.sched\""), "2:2 no directive is called `vektorize`");
    // Whether they are the includer's is not known here: its file's name may say so.
    made = parse_main("param rows = 1 in [1, 2]\ninclude \"named.sched\"");
    ASSERT_EQ(std::get<File>(made).included_pipelines.size(), 1u);
    EXPECT_EQ(std::get<File>(made).included_pipelines[0].text, "slab");
    EXPECT_EQ(std::get<File>(made).included_pipelines[0].file, 2u);
    EXPECT_FALSE(std::get<File>(made).pipeline);
    made = parse_main("include \"a.sched\"\n\nparam rows = 1 in [1, 2]");
    EXPECT_EQ(std::get<Fault>(bind(std::get<File>(made))).message,
              "there is a parameter `rows` already, of line 1 of a.sched");
    std::string many;
    for (int k = 0; k < 65; ++k)
        many += "include \"b.sched\"\n";
    EXPECT_EQ(fault(many), "1:65 a schedule includes at most 64 files");
}

TEST(Schedule, AByteOrderMarkIsNoText) {
    EXPECT_EQ(bound("\xEF\xBB\xBF# mine\na.parallel(n)"), "a.parallel(n)\n");
    EXPECT_EQ(fault_of("\xEF\xBB\xBF"
                       "a.vektor(n)")
                  .substr(0, 12),
              "1:6 |vektor|");
}

TEST(Schedule, EndsDeepNestsAndLongFiles) {
    std::string deep = "a.parallel(n)";
    for (int k = 0; k < 5000; ++k)
        deep = "when avx2 {\n" + deep + "\n}";
    EXPECT_NE(fault_of(deep).find("`when` stands in `when` 8 deep"), std::string::npos);
    std::string nots = "when";
    for (int k = 0; k < 100000; ++k)
        nots += " not";
    EXPECT_EQ(bound(nots + " avx2 { a.parallel(n) }"), "");
    std::string lines;
    for (int k = 0; k < 5000; ++k)
        lines += "a.parallel(n)\n";
    EXPECT_NE(fault_of(lines).find("at most 4096 lines"), std::string::npos);
}

}  // namespace

}  // namespace openfab::schedule
