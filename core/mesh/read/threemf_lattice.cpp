// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/threemf_lattice.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "base/scan_number.h"
#include "mesh/read/messages.h"
#include "mesh/read/threemf_text.h"

namespace openfab::mesh {

namespace {

constexpr std::string_view kElements[] = {"beamlattice", "beams",   "beam", "balls",  "ball",
                                          "beamsets",    "beamset", "ref",  "ballref"};

Complaint read_number(const XmlAttributes& a, const char* key, double* out) {
    const char* text = a.find(key);
    if (text == nullptr) return {};
    const std::string wrong = scan_number(trim_threemf(text), out);
    if (!wrong.empty()) return fmt::format("`{}`: {}", key, wrong);
    if (*out < 0) return fmt::format(messages::kBelowZero, key, *out);
    return {};
}

Complaint read_index(const XmlAttributes& a, const char* key, int32_t* out) {
    const char* text = a.find(key);
    if (text == nullptr) return fmt::format(messages::kAttributeMissing, key);
    int64_t value = 0;
    const std::string wrong = scan_integer(trim_threemf(text), 0, INT32_MAX, &value);
    *out = static_cast<int32_t>(value);
    return wrong.empty() ? Complaint() : Complaint(fmt::format("`{}`: {}", key, wrong));
}

Complaint read_cap(const XmlAttributes& a, const char* key, ThreemfCap* out) {
    const char* text = a.find(key);
    if (text == nullptr) return {};
    const std::string_view cap = trim_threemf(text);
    if (cap == "sphere") {
        *out = ThreemfCap::kSphere;
    } else if (cap == "hemisphere") {
        *out = ThreemfCap::kHemisphere;
    } else if (cap == "butt") {
        *out = ThreemfCap::kButt;
    } else {
        return {fmt::format("`{}` is `{}`", key, cap.substr(0, 40)), messages::kCapHelp};
    }
    return {};
}

}  // namespace

bool ThreemfLatticeReader::takes(std::string_view name) {
    return std::ranges::find(kElements, name) != std::end(kElements);
}

Complaint ThreemfLatticeReader::read(std::string_view name, const XmlAttributes& a,
                                     ThreemfLattice* out, int64_t* memory_bytes) {
    // Lists double, and are copied then.
    const auto take = [&](size_t bytes) { *memory_bytes -= static_cast<int64_t>(3 * bytes); };
    if (name == "beamlattice") return begin(a, out);
    if (name == "beam") {
        take(sizeof(ThreemfBeam));
        return beam(a, out);
    }
    if (name == "ball") {
        take(sizeof out->balls[0]);
        return ball(a, out);
    }
    if (name == "beamset") {
        const char* text = a.find("name");
        if (text == nullptr) text = a.find("identifier");
        out->sets.emplace_back(std::string_view(text != nullptr ? text : "").substr(0, 1000));
        take(sizeof(std::string) + out->sets.back().size());
    }
    if (name == "ref") {
        if (out->sets.empty()) return {};
        int32_t index = 0;
        Complaint wrong = read_index(a, "index", &index);
        if (!wrong.empty()) return wrong;
        take(sizeof out->members[0]);
        out->members.emplace_back(index, static_cast<int32_t>(out->sets.size()));
    }
    return {};
}

Complaint ThreemfLatticeReader::begin(const XmlAttributes& a, ThreemfLattice* out) {
    *out = {};
    for (const auto& [key, to] :
         {std::pair{"radius", &out->radius}, std::pair{"minlength", &out->least_length},
          std::pair{"ballradius", &out->ball_radius}}) {
        if (Complaint wrong = read_number(a, key, to); !wrong.empty()) return wrong;
    }
    if (Complaint wrong = read_cap(a, "cap", &out->cap); !wrong.empty()) return wrong;
    const auto text = [&](const char* key) {
        const char* value = a.find(key);
        return std::string(value != nullptr ? trim_threemf(value) : "");
    };
    out->clipping = text("clippingmode");
    // As drafts of the extension called it.
    if (out->clipping.empty()) out->clipping = text("clipping");
    if (out->clipping == "none") out->clipping.clear();
    if (!out->clipping.empty() && out->clipping != "inside" && out->clipping != "outside")
        return {fmt::format(messages::kClippingMode, out->clipping.substr(0, 40)),
                messages::kClippingModeHelp};
    out->has_representation = a.find("representationmesh") != nullptr;
    out->has_properties = a.find("pid") != nullptr;
    const std::string balls = text("ballmode");
    if (balls == "mixed") out->all_balls = ThreemfLattice::Balls::kListed;
    if (balls == "all") out->all_balls = ThreemfLattice::Balls::kAll;
    if (!balls.empty() && balls != "mixed" && balls != "all" && balls != "none")
        return {fmt::format(messages::kBallMode, balls.substr(0, 40)), messages::kBallModeHelp};
    return {};
}

Complaint ThreemfLatticeReader::beam(const XmlAttributes& a, ThreemfLattice* out) {
    ThreemfBeam beam;
    Complaint wrong = read_index(a, "v1", &beam.vertices[0]);
    if (wrong.empty()) wrong = read_index(a, "v2", &beam.vertices[1]);
    double first = out->radius;
    if (wrong.empty()) wrong = read_number(a, "r1", &first);
    double second = first;
    if (wrong.empty()) wrong = read_number(a, "r2", &second);
    beam.radii = {static_cast<float>(first), static_cast<float>(second)};
    beam.caps = {out->cap, out->cap};
    if (wrong.empty()) wrong = read_cap(a, "cap1", &beam.caps[0]);
    if (wrong.empty()) wrong = read_cap(a, "cap2", &beam.caps[1]);
    if (wrong.empty() && !(first > 0 && second > 0))
        wrong = {messages::kBeamWithoutRadius, messages::kBeamWithoutRadiusHelp};
    if (wrong.empty() && beam.vertices[0] == beam.vertices[1])
        wrong = fmt::format(messages::kBeamJoinsItself, beam.vertices[0]);
    out->has_properties |= a.find("p1") != nullptr;
    if (wrong.empty()) out->beams.push_back(beam);
    return wrong;
}

Complaint ThreemfLatticeReader::ball(const XmlAttributes& a, ThreemfLattice* out) {
    int32_t vertex = 0;
    double radius = out->ball_radius;
    Complaint wrong = read_index(a, "vindex", &vertex);
    if (wrong.empty()) wrong = read_number(a, "r", &radius);
    if (wrong.empty() && !(radius > 0))
        wrong = {messages::kLatticeBallWithoutRadius, messages::kLatticeBallWithoutRadiusHelp};
    out->has_properties |= a.find("p") != nullptr;
    if (wrong.empty()) out->balls.emplace_back(vertex, static_cast<float>(radius));
    return wrong;
}

}  // namespace openfab::mesh
