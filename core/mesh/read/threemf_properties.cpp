// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/threemf_properties.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

#include "base/scan_number.h"
#include "mesh/read/messages.h"
#include "mesh/read/threemf_text.h"

namespace openfab::mesh {

namespace {

constexpr std::string_view kPropertyElements[] = {
    "tex2coord",      "base",       "color",     "composite",      "multi",
    "basematerials",  "colorgroup", "texture2d", "texture2dgroup", "compositematerials",
    "multiproperties"};

}  // namespace

bool ThreemfPropertiesReader::takes(std::string_view name) {
    return std::ranges::find(kPropertyElements, name) != std::end(kPropertyElements);
}

Complaint ThreemfPropertiesReader::start(std::string_view name, const XmlAttributes& a) {
    using Kind = ThreemfGroup::Kind;
    wrong_.clear();
    if (name == "tex2coord") return coordinate(a);
    if (name == "basematerials") return begin_group(a, Kind::kMaterials);
    if (name == "colorgroup") return begin_group(a, Kind::kColors);
    if (name == "texture2d") return texture(a);
    if (name == "texture2dgroup") return begin_coordinates(a);
    if (name == "compositematerials") return begin_composites(a);
    if (name == "multiproperties") return begin_multi(a);
    if (name == "base") return base(a);
    if (name == "color") return color(a);
    if (name == "composite") return composite(a);
    return multi(a);
}

void ThreemfPropertiesReader::end(std::string_view name) {
    if (name == "basematerials" || name == "colorgroup" || name == "texture2dgroup" ||
        name == "compositematerials" || name == "multiproperties")
        group_ = nullptr;
}

Complaint ThreemfPropertiesReader::begin_group(const XmlAttributes& a, ThreemfGroup::Kind kind) {
    const int64_t id = needed_integer(a, "id");
    if (!wrong_.empty()) return wrong_;
    const auto [it, fresh] = model_.groups.try_emplace(id);
    if (!fresh) return fmt::format(messages::kSecondResource, id);
    take<ThreemfGroup>({});
    group_ = &it->second;
    group_->kind = kind;
    return {};
}

Complaint ThreemfPropertiesReader::begin_coordinates(const XmlAttributes& a) {
    Complaint wrong = begin_group(a, ThreemfGroup::Kind::kCoordinates);
    if (wrong.empty()) group_->source = integer(a, "texid", -1);
    return wrong.empty() ? Complaint(wrong_) : wrong;
}

Complaint ThreemfPropertiesReader::begin_composites(const XmlAttributes& a) {
    Complaint wrong = begin_group(a, ThreemfGroup::Kind::kComposites);
    if (wrong.empty()) wrong = integers(attribute(a, "matindices"), &group_->layers);
    if (wrong.empty()) group_->source = integer(a, "matid", -1);
    // Each composite searches all of them.
    constexpr size_t kMaxMaterials = 256;
    if (wrong.empty() && group_->layers.size() > kMaxMaterials)
        return {fmt::format(messages::kTooManyComposites, group_->layers.size()),
                fmt::format(messages::kAtMost, kMaxMaterials)};
    return wrong.empty() ? Complaint(wrong_) : wrong;
}

Complaint ThreemfPropertiesReader::begin_multi(const XmlAttributes& a) {
    Complaint wrong = begin_group(a, ThreemfGroup::Kind::kMulti);
    if (wrong.empty()) wrong = integers(attribute(a, "pids"), &group_->layers);
    // Each triangle searches all of them.
    constexpr size_t kMaxLayers = 16;
    if (wrong.empty() && group_->layers.size() > kMaxLayers)
        return {fmt::format(messages::kTooManyMultiproperties, group_->layers.size()),
                fmt::format(messages::kAtMost, kMaxLayers)};
    if (!wrong.empty()) return wrong;
    const std::string methods = attribute(a, "blendmethods");
    for (const std::string_view method : threemf_words(methods)) {
        if (group_->multiplied.size() == kMaxLayers) break;
        if (method != "mix" && method != "multiply")
            return {fmt::format(messages::kUnknownBlendMethod, method.substr(0, 40)),
                    messages::kUnknownBlendMethodHelp};
        group_->multiplied.push_back(method == "multiply");
    }
    return {};
}

std::string ThreemfPropertiesReader::integers(std::string_view list, std::vector<int64_t>* out) {
    for (std::string_view word : threemf_words(list)) {
        int64_t value = 0;
        if (std::string wrong = scan_integer(word, 0, kMaxId, &value); !wrong.empty()) return wrong;
        add(out, value);
    }
    return {};
}

Complaint ThreemfPropertiesReader::base(const XmlAttributes& a) {
    if (!in(ThreemfGroup::Kind::kMaterials)) return {};
    std::string name = attribute(a, "name");
    if (name.empty()) name = fmt::format("material {}", group_->names.size());
    const std::optional<ThreemfColor> color = parse_threemf_color(attribute(a, "displaycolor"));
    const size_t length = name.size();
    add(&group_->values, color.value_or(ThreemfColor{}), 1);
    group_->colored.push_back(color.has_value());
    return too_long(add(&group_->names, std::move(name), length));
}

Complaint ThreemfPropertiesReader::color(const XmlAttributes& a) {
    if (!in(ThreemfGroup::Kind::kColors)) return {};
    const std::string written = attribute(a, "color");
    const std::optional<ThreemfColor> value = parse_threemf_color(written);
    if (!value)
        return {fmt::format(messages::kNotAColour, written.substr(0, 40)),
                messages::kNotAColourHelp};
    add(&group_->values, *value);
    return {};
}

Complaint ThreemfPropertiesReader::texture(const XmlAttributes& a) {
    const int64_t id = needed_integer(a, "id");
    if (!wrong_.empty()) return wrong_;
    const auto [it, fresh] = model_.textures.try_emplace(id);
    if (!fresh) return fmt::format(messages::kSecondTexture, id);
    ThreemfTexture& texture = it->second;
    texture.path = attribute(a, "path");
    take<ThreemfTexture>(texture.path);
    texture.nearest = attribute(a, "filter") == "nearest";
    const char* const keys[] = {"tilestyleu", "tilestylev"};
    for (size_t axis = 0; axis < texture.wrap.size(); ++axis) {
        const std::string style = attribute(a, keys[axis]);
        if (style.empty() || style == "wrap") continue;
        if (style == "mirror") {
            texture.wrap[axis] = PictureWrap::kMirror;
        } else if (style == "clamp") {
            texture.wrap[axis] = PictureWrap::kClamp;
        } else if (style == "none") {
            texture.wrap[axis] = PictureWrap::kNone;
        } else {
            return {fmt::format(messages::kUnknownTileStyle, style.substr(0, 40)),
                    messages::kTileStyles};
        }
    }
    return {};
}

Complaint ThreemfPropertiesReader::coordinate(const XmlAttributes& a) {
    if (!in(ThreemfGroup::Kind::kCoordinates)) return {};
    const double u = number(a, "u");
    const double v = number(a, "v");
    add(&group_->values, {static_cast<float>(u), static_cast<float>(v), 0, 0});
    return wrong_;
}

Complaint ThreemfPropertiesReader::composite(const XmlAttributes& a) {
    if (!in(ThreemfGroup::Kind::kComposites)) return {};
    std::vector<double>& shares = add(&group_->shares, {});
    const std::string values = attribute(a, "values");
    double sum = 0;
    for (const std::string_view word : threemf_words(values)) {
        if (shares.size() == group_->layers.size()) break;
        double value = 0;
        if (std::string wrong = scan_number(word, &value); !wrong.empty()) return wrong;
        if (value < 0) return fmt::format(messages::kNotAShare, word.substr(0, 40));
        sum += add(&shares, value);
    }
    while (shares.size() < group_->layers.size())
        add(&shares, 0.0);
    for (double& share : shares)
        share = sum > 0 ? share / sum : 1 / static_cast<double>(shares.size());
    return {};
}

Complaint ThreemfPropertiesReader::multi(const XmlAttributes& a) {
    if (!in(ThreemfGroup::Kind::kMulti)) return {};
    return integers(attribute(a, "pindices"), &add(&group_->picks, {}));
}

}  // namespace openfab::mesh
