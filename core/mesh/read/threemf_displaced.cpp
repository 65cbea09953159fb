// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/threemf_displaced.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "base/scan_number.h"
#include "mesh/read/messages.h"
#include "mesh/read/threemf_text.h"

namespace openfab::mesh {

namespace {

constexpr std::string_view kElements[] = {"displacement2d", "normvectorgroup", "normvector",
                                          "disp2dgroup",    "disp2dcoord",     "disp2dcoords"};

Complaint read_number(const XmlAttributes& a, const char* key, bool needed, double* out) {
    const char* text = a.find(key);
    if (text == nullptr)
        return needed ? Complaint(fmt::format(messages::kAttributeMissing, key)) : Complaint();
    const std::string wrong = scan_number(trim_threemf(text), out);
    return wrong.empty() ? Complaint() : Complaint(fmt::format("`{}`: {}", key, wrong));
}

Complaint read_index(const XmlAttributes& a, const char* key, bool needed, int64_t* out) {
    const char* text = a.find(key);
    if (text == nullptr)
        return needed ? Complaint(fmt::format(messages::kAttributeMissing, key)) : Complaint();
    const std::string wrong = scan_integer(trim_threemf(text), 0, INT32_MAX, out);
    return wrong.empty() ? Complaint() : Complaint(fmt::format("`{}`: {}", key, wrong));
}

Complaint read_map(const XmlAttributes& a, ThreemfDisplacementMap* out) {
    const char* path = a.find("path");
    if (path == nullptr) return messages::kPathMissing;
    out->path = std::string_view(path).substr(0, 1000);
    const char* channel = a.find("channel");
    constexpr std::string_view kChannels = "RGBA";
    const std::string_view letter = trim_threemf(channel != nullptr ? channel : "G");
    const size_t at = letter.size() == 1 ? kChannels.find(letter) : std::string_view::npos;
    if (at == std::string_view::npos)
        return {fmt::format(messages::kUnknownChannel, letter.substr(0, 40)),
                messages::kUnknownChannelHelp};
    out->channel = static_cast<int>(at);
    const char* filter = a.find("filter");
    out->nearest = filter != nullptr && trim_threemf(filter) == "nearest";
    const char* const keys[] = {"tilestyleu", "tilestylev"};
    for (size_t axis = 0; axis < out->wrap.size(); ++axis) {
        const char* written = a.find(keys[axis]);
        const std::string_view style = trim_threemf(written != nullptr ? written : "wrap");
        if (style == "wrap") {
            out->wrap[axis] = PictureWrap::kRepeat;
        } else if (style == "mirror") {
            out->wrap[axis] = PictureWrap::kMirror;
        } else if (style == "clamp") {
            out->wrap[axis] = PictureWrap::kClamp;
        } else if (style == "none") {
            out->wrap[axis] = PictureWrap::kNone;
        } else {
            return {fmt::format(messages::kUnknownTileStyle, style.substr(0, 40)),
                    messages::kTileStyles};
        }
    }
    return {};
}

Complaint read_group(const XmlAttributes& a, ThreemfDisplacementGroup* out) {
    Complaint wrong = read_index(a, "dispid", true, &out->map);
    if (wrong.empty()) wrong = read_index(a, "nid", true, &out->directions);
    if (wrong.empty()) wrong = read_number(a, "height", true, &out->height);
    if (wrong.empty()) wrong = read_number(a, "offset", false, &out->offset);
    return wrong;
}

Complaint read_point(const XmlAttributes& a, ThreemfDisplacementPoint* out) {
    Complaint wrong = read_number(a, "u", true, &out->u);
    if (wrong.empty()) wrong = read_number(a, "v", true, &out->v);
    if (wrong.empty()) wrong = read_number(a, "f", false, &out->factor);
    if (wrong.empty()) wrong = read_index(a, "n", true, &out->direction);
    if (wrong.empty() && out->factor < 0)
        return fmt::format(messages::kFactorBelowZero, out->factor);
    return wrong;
}

}  // namespace

int64_t ThreemfDisplacements::group_of(int64_t named) const {
    if (groups.contains(named)) return named;
    int64_t found = 0;
    for (const auto& [id, group] : groups) {
        if (group.directions != named) continue;
        if (found != 0) return 0;
        found = id;
    }
    return found;
}

bool ThreemfDisplacementReader::takes(std::string_view name) {
    return std::ranges::find(kElements, name) != std::end(kElements);
}

Complaint ThreemfDisplacementReader::read(std::string_view name, const XmlAttributes& a,
                                          ThreemfDisplacements* out, int64_t* memory_bytes) {
    constexpr size_t kNode = 64;
    // Lists double, and are copied then.
    const auto take = [&](size_t bytes) { *memory_bytes -= static_cast<int64_t>(3 * bytes); };
    if (name == "normvector") {
        if (directions_ == nullptr) return {};
        take(sizeof(Vec3d));
        Vec3d n;
        Complaint wrong = read_number(a, "x", true, &n.x);
        if (wrong.empty()) wrong = read_number(a, "y", true, &n.y);
        if (wrong.empty()) wrong = read_number(a, "z", true, &n.z);
        if (!wrong.empty()) return wrong;
        if (!(length(n) > 0)) return messages::kDirectionWithoutLength;
        directions_->push_back(n * (1 / length(n)));
        return {};
    }
    if (name.starts_with("disp2dcoord")) {
        if (group_ == nullptr) return {};
        take(sizeof(ThreemfDisplacementPoint));
        return read_point(a, &group_->points.emplace_back());
    }
    int64_t id = 0;
    if (Complaint wrong = read_index(a, "id", true, &id); !wrong.empty()) return wrong;
    if (out->maps.contains(id) || out->directions.contains(id) || out->groups.contains(id))
        return fmt::format(messages::kSecondDisplacement, id);
    take(sizeof(ThreemfDisplacementGroup) + kNode);
    if (name == "normvectorgroup") {
        directions_ = &out->directions[id];
        return {};
    }
    if (name == "disp2dgroup") {
        group_ = &out->groups[id];
        return read_group(a, group_);
    }
    return read_map(a, &out->maps[id]);
}

Complaint ThreemfDisplacementReader::read_triangle(const XmlAttributes& a, ThreemfDisplaced* out) {
    ThreemfDisplaced::Triangle& t = out->triangles.emplace_back();
    const char* const keys[] = {"d1", "d2", "d3"};
    Complaint wrong = read_index(a, "did", false, &t.group);
    for (size_t c = 0; c < t.points.size(); ++c) {
        if (wrong.empty()) wrong = read_index(a, keys[c], false, &t.points[c]);
        // One for all corners unless the others have their own.
        if (t.points[c] < 0) t.points[c] = t.points[0];
    }
    return wrong;
}

}  // namespace openfab::mesh
