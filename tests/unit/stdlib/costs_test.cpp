// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The table of costs (stdlib/costs.json) has each function of the standard library once, and
// nothing else, with figures that can be.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>

#include "base/json.h"
#include "base/json_text.h"
#include "compiler/diag/render.h"
#include "compiler/frontend/modules.h"
#include "compiler/syntax/parser.h"

namespace openfab {
namespace {

/// "lattice float gyroid(float3, float)" of each function that another file may call.
std::multiset<std::string> functions_of_the_library() {
    std::multiset<std::string> out;
    for (const std::string& module : frontend::library_modules()) {
        source::SourceManager sources;
        diag::Sink sink;
        const std::string text = frontend::library_text(module);
        const uint32_t file = sources.add(module + ".fl", text);
        const ast::File tree = syntax::parse(sources, syntax::lex(sources, file, &sink), &sink);
        EXPECT_EQ(sink.errors(), 0U) << diag::render_text(sink, sources);
        for (const ast::Function& function : tree.scope.functions) {
            if (function.name.starts_with('_')) continue;
            std::string types;
            for (const ast::Variable& parameter : function.parameters) {
                const source::Span& array = parameter.array_span;
                types += types.empty() ? "" : ", ";
                types += parameter.type.text;
                if (!parameter.extents.empty())
                    types += text.substr(array.begin, array.end - array.begin);
            }
            out.insert(fmt::format("{} {} {}({})", module, function.return_type.text, function.name,
                                   types));
        }
    }
    return out;
}

std::string text_of(const JsonValue& row, std::string_view key) {
    const JsonValue* found = member_of(row, key);
    return found == nullptr ? "" : found->text;
}

TEST(Costs, AreThereForEachFunctionAndNoOther) {
    const std::string file = OPENFAB_SOURCE_DIR "/stdlib/costs.json";
    const Result<std::string> text = read_text_file(file, 1'000'000);
    ASSERT_TRUE(text.has_value()) << file;
    const Result<JsonValue> table = parse_json(*text, file);
    ASSERT_TRUE(table.has_value()) << table.error().text();
    const JsonValue* rows = member_of(*table, "functions");
    ASSERT_NE(rows, nullptr);
    std::multiset<std::string> listed;
    for (const JsonValue& row : rows->items) {
        const std::string function = text_of(row, "module") + " " + text_of(row, "function");
        listed.insert(function);
        SCOPED_TRACE(function);
        // Measured, or with the reason why not.
        if (member_of(row, "call") == nullptr) {
            EXPECT_FALSE(text_of(row, "note").empty());
            continue;
        }
        const std::string name = function.substr(0, function.find('('));
        EXPECT_TRUE(text_of(row, "call").starts_with(name.substr(name.rfind(' ') + 1) + "("));
        for (const char* key : {"ns", "spread", "copies"}) {
            const JsonValue* figure = member_of(row, key);
            ASSERT_NE(figure, nullptr) << key;
            EXPECT_GE(figure->number, 0);
        }
        const JsonValue* decided = member_of(row, "decided");
        if (decided == nullptr) continue;
        EXPECT_LE(decided->number, member_of(row, "one_sided")->number);
    }
    const std::multiset<std::string> present = functions_of_the_library();
    EXPECT_GT(present.size(), 200U);
    std::vector<std::string> missing, gone;
    std::ranges::set_difference(present, listed, std::back_inserter(missing));
    std::ranges::set_difference(listed, present, std::back_inserter(gone));
    EXPECT_EQ(missing, std::vector<std::string>{}) << "run bench_library after adding rows";
    EXPECT_EQ(gone, std::vector<std::string>{}) << "or twice";
}

}  // namespace
}  // namespace openfab
