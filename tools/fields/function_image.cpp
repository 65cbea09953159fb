// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Functions of 3MF that look up images.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "tools/fields/function_text.h"
#include "tools/fields/messages.h"

namespace openfab::tools {

using mesh::ThreemfFunction;
using mesh::ThreemfType;

Result<FunctionTexts::Made> FunctionTexts::make_image(const Key& key,
                                                      const ThreemfFunction& function) {
    const auto image = model_.fields.images.find(function.image);
    if (image == model_.fields.images.end())
        return error(place(key.function), fmt::format(messages::kNoSuchImage, function.image));
    const mesh::ThreemfImage& of = image->second;
    const std::string where = fmt::format(messages::kTheImage, function.image);
    if (of.rows <= 0 || of.columns <= 0 || of.count <= 0)
        return error(where, messages::kNoRowsColumnsSheets);
    if (static_cast<int64_t>(of.sheets.size()) != of.count)
        return error(where, fmt::format(messages::kSheetCount, of.count, of.sheets.size()));
    static constexpr std::pair<std::string_view, int> kChannels[] = {
        {"color", -1}, {"red", 0}, {"green", 1}, {"blue", 2}, {"alpha", 3}};
    const auto channel = std::ranges::find(kChannels, std::string_view(key.output),
                                           &std::pair<std::string_view, int>::first);
    if (channel == std::end(kChannels))
        return error(place(key.function), fmt::format(messages::kNoOutput, shown(key.output)),
                     messages::kImageOutputs);
    images_.insert(key.function);
    // Of an image that repeats along any axis the others stay half a texel from its ends, where it clamps.
    const bool repeats =
        std::ranges::find(function.wrap, mesh::PictureWrap::kRepeat) != function.wrap.end();
    const std::array<int64_t, 3> counts{of.columns, of.rows, of.count};
    std::array<std::string, 3> uvw;
    for (size_t a = 0; a < 3; ++a) {
        std::string s = fmt::format("pos.{}", "xyz"[a]);
        const mesh::PictureWrap wrap = function.wrap[a];
        if (wrap == mesh::PictureWrap::kMirror)
            s = fmt::format("(1 - abs({0} - 2 * floor({0} / 2) - 1))", s);
        if (repeats && wrap != mesh::PictureWrap::kRepeat) {
            const double half = 0.5 / static_cast<double>(counts[a]);
            s = fmt::format("clamp({}, {}, {})", s, float_text(half), float_text(1 - half));
        }
        uvw[a] = s;
    }
    // The first row of a sheet is at the highest v there, at the lowest y here.
    const std::string point = fmt::format("float3({}, 1 - {}, {})", uvw[0], uvw[1], uvw[2]);
    const std::string sample =
        channel->second < 0
            ? fmt::format("image_{}.Sample3({}, 0, 0)", key.function, point)
            : fmt::format("image_{}.Sample1({}, {}, 0)", key.function, point, channel->second);
    std::string text = sample;
    if (function.scale != 1) text += fmt::format(" * {}", float_text(function.scale));
    if (function.offset != 0) text += fmt::format(" + {}", float_text(function.offset));
    const ThreemfType type = channel->second < 0 ? ThreemfType::kVector : ThreemfType::kScalar;
    const Made made{
        unique(fmt::format("{}_{}_{}", openfl_name(function.name.empty() ? "image" : function.name),
                           key.function, key.output)),
        type};
    texts_.push_back(
        fmt::format("    // The {} of image {}.\n    {} {}(float3 pos)\n    {{\n        "
                    "return {};\n    }}\n",
                    key.output == "color" ? "colour" : key.output, function.image,
                    openfl_type(type), made.name, text));
    return made;
}

}  // namespace openfab::tools
