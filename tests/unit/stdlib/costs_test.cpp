// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The table of costs (stdlib/costs.json) has each function of the standard library once, and
// nothing else, with figures that can be; and the interval of each of its calls holds what the call
// gives, so that culling changes nothing.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "base/json.h"
#include "base/json_text.h"
#include "compiler/diag/render.h"
#include "compiler/frontend/frontend.h"
#include "compiler/frontend/modules.h"
#include "compiler/interp/evaluate.h"
#include "compiler/passes/eliminate_common_values.h"
#include "compiler/passes/form_volume_bounds.h"
#include "compiler/syntax/parser.h"
#include "tests/support/library_call.h"
#include "tests/support/places/places.h"

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

std::vector<JsonValue> rows() {
    const std::string file = testing::source_dir() / "stdlib/costs.json";
    const Result<std::string> text = read_text_file(file, 1'000'000);
    if (!text) return {};
    const Result<JsonValue> table = parse_json(*text, file);
    const JsonValue* found = table ? member_of(*table, "functions") : nullptr;
    return found == nullptr ? std::vector<JsonValue>{} : found->items;
}

TEST(Costs, AreThereForEachFunctionAndNoOther) {
    std::multiset<std::string> listed;
    for (const JsonValue& row : rows()) {
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

/// A box of points, or one of them where both ends are.
class Box : public interp::Environment {
  public:
    std::array<float, 3> lo{}, hi{};
    uint32_t input(int32_t kind, int32_t a, int32_t /*b*/) const override {
        const auto index = static_cast<size_t>(a);
        switch (kind) {
            case ir::kVoxelCoord:
            case ir::kVoxelCoordLo:
                return std::bit_cast<uint32_t>(lo.at(index));
            case ir::kVoxelCoordHi:
                return std::bit_cast<uint32_t>(hi.at(index));
            default:
                // Coordinates are millimetres.
                return std::bit_cast<uint32_t>(index < 9 && index % 4 == 0 ? 1.0F : 0.0F);
        }
    }
    interp::TextureView texture(int32_t /*index*/) const override { return {}; }
};

/// Boxes of 0.1 to 3 mm, at random places and at those where periods begin.
TEST(Costs, IntervalsOfCallsHoldWhatTheyGive) {
    constexpr int kBoxes = 40, kPoints = 12;
    size_t calls = 0, known = 0;
    for (const JsonValue& row : rows()) {
        const std::string function = text_of(row, "function"), module = text_of(row, "module");
        if (member_of(row, "call") == nullptr || module == "dither") continue;
        SCOPED_TRACE(text_of(row, "call"));
        source::SourceManager sources;
        diag::Sink sink;
        const std::string fablet = testing::fablet_of(
            {module, function.substr(0, function.find(' ')), text_of(row, "call")});
        const auto compiled =
            frontend::compile_to_ir(sources, sources.add("call.fl", fablet), sink);
        ASSERT_TRUE(compiled.has_value()) << diag::render_text(sink, sources);
        ir::Stage stage = compiled->fablets[0].volume;
        passes::eliminate_common_values(&stage);
        const ir::Stage bounds = passes::form_volume_bounds(stage);
        std::mt19937 random(static_cast<uint32_t>(++calls));
        const auto unit = [&] { return static_cast<float>(random() >> 8) * 0x1p-24F; };
        bool any = false;
        for (int k = 0; k < kBoxes; ++k) {
            Box box;
            const float size = 0.1F * std::pow(30.0F, unit());
            for (size_t axis = 0; axis < 3; ++axis) {
                const float place = 30 * unit() - 15;
                box.lo[axis] = k % 4 == 0 ? std::round(place) : place;
                box.hi[axis] = box.lo[axis] + (k % 8 == 0 ? 0 : size * unit());
            }
            const std::vector<uint32_t> ends = interp::evaluate(bounds, box);
            const bool unknown = std::isnan(std::bit_cast<float>(ends[0]));
            any = any || !unknown;
            // Voronoi's loops have no interval, and are slow.
            for (int point = 0; point < (unknown && ends.size() == 2 ? 0 : kPoints); ++point) {
                Box at;
                for (size_t axis = 0; axis < 3; ++axis) {
                    const float t = point < 2 ? static_cast<float>(point) : unit();
                    const float x = box.lo[axis] + (box.hi[axis] - box.lo[axis]) * t;
                    at.lo[axis] = at.hi[axis] = std::clamp(x, box.lo[axis], box.hi[axis]);
                }
                const std::vector<uint32_t> values = interp::evaluate(stage, at);
                for (size_t slot = 0; slot < values.size(); ++slot) {
                    const auto lo = std::bit_cast<float>(ends[2 * slot]);
                    const auto hi = std::bit_cast<float>(ends[2 * slot + 1]);
                    const auto value = std::bit_cast<float>(values[slot]);
                    if (std::isnan(lo)) continue;
                    ASSERT_TRUE(lo <= value && value <= hi)
                        << stage.outputs[slot].name << " at " << at.lo[0] << ", " << at.lo[1]
                        << ", " << at.lo[2] << ": " << value << " outside " << lo << " .. " << hi;
                }
            }
        }
        known += any ? 1 : 0;
        // A print drops an interval form that is too long.
        const bool long_form = bounds.instrs.size() > 700;
        const bool bounded = member_of(row, "bounded")->boolean;
        EXPECT_TRUE(any == bounded || (long_form && !bounded)) << bounds.instrs.size();
    }
    EXPECT_GT(calls, 190U);
    EXPECT_GT(known + 10, calls);
}

}  // namespace
}  // namespace openfab
