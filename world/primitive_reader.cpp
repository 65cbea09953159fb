// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/primitive_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "mesh/model/primitives.h"
#include "mesh/model/sweeps.h"
#include "world/messages.h"
#include "world/world_keys.h"

namespace openfab::world {
namespace {

constexpr double kLargestPrimitive_mm = 1e5;

using Sizes = std::vector<double>;

/// What is wrong with sizes that are all in range, and what to do; no text: nothing.
struct Fault {
    const char* what = nullptr;
    const char* help = "";
};

/// A primitive that a list of sizes makes, in mm; one size stands alone.
struct SizedPrimitive {
    const char* key;
    size_t count;                  ///< of sizes
    size_t may_be_zero;            ///< so many of the first ones
    Fault (*fault)(const Sizes&);  ///< null: none is possible
    mesh::Mesh (*make)(const Sizes&);
};

const SizedPrimitive kSized[] = {
    {"box", 3, 0, nullptr,
     [](const Sizes& s) {
         return mesh::make_box({s[0], s[1], s[2]});
     }},
    {"sphere", 1, 0, nullptr, [](const Sizes& s) { return mesh::make_sphere(s[0]); }},
    {"cylinder", 2, 0, nullptr, [](const Sizes& s) { return mesh::make_cylinder(s[0], s[1]); }},
    {"plane", 2, 0, nullptr, [](const Sizes& s) { return mesh::make_plane(s[0], s[1]); }},
    {"cone", 3, 2,
     [](const Sizes& s) { return s[0] == 0 && s[1] == 0 ? Fault{messages::kNoDiameter} : Fault{}; },
     [](const Sizes& s) { return mesh::make_cone(s[0], s[1], s[2]); }},
    {"torus", 2, 0,
     [](const Sizes& s) { return s[1] < s[0] ? Fault{} : Fault{messages::kSectionTooWide}; },
     [](const Sizes& s) { return mesh::make_torus(s[0], s[1]); }},
    {"capsule", 2, 0,
     [](const Sizes& s) {
         return s[1] < s[0]
                    ? Fault{messages::kShorterThanDiameter, messages::kShorterThanDiameterHelp}
                    : Fault{};
     },
     [](const Sizes& s) { return mesh::make_capsule(s[0], s[1]); }},
};

class PrimitiveReader {
  public:
    explicit PrimitiveReader(JsonReader* json) : json_(*json) {}

    std::optional<mesh::Mesh> make(const JsonMember& source, const std::string& name) {
        if (source.key == "extrusion") return extrusion(source.value, name);
        if (source.key == "revolution") return revolution(source.value, name);
        const auto row = std::ranges::find(kSized, source.key, &SizedPrimitive::key);
        const Sizes read = sizes(*row, source.value, name);
        if (!json_.ok()) return {};
        const Fault fault = row->fault == nullptr ? Fault{} : row->fault(read);
        if (fault.what != nullptr) json_.fail(source.value, name + fault.what, fault.help);
        return json_.ok() ? std::optional(row->make(read)) : std::nullopt;
    }

  private:
    Sizes sizes(const SizedPrimitive& row, const JsonValue& value, const std::string& name) {
        if (row.count == 1) return {json_.number(value, name, 1e-6, kLargestPrimitive_mm)};
        Sizes out = json_.numbers(value, name, row.count, kLargestPrimitive_mm);
        for (size_t i = 0; i < row.count && json_.ok(); ++i) {
            if (!(out[i] > 0 || (i < row.may_be_zero && out[i] == 0)))
                json_.fail(value.items[i], name + messages::kSizeNotAboveZero);
        }
        return out;
    }

    mesh::Outline outline(const JsonValue& value, const std::string& name) {
        mesh::Outline out;
        if (value.kind != JsonValue::Kind::kArray)
            json_.fail(value, name + messages::kNotAPolygon, messages::kNotAPolygonHelp);
        for (const JsonValue& corner : value.items) {
            if (!json_.ok()) break;
            const std::vector<double> p =
                json_.numbers(corner, "a corner of " + name, 2, kLargestPrimitive_mm);
            out.push_back({p[0], p[1]});
        }
        return out;
    }

    std::optional<mesh::Mesh> extrusion(const JsonValue& value, const std::string& name) {
        if (!json_.object(value, world_keys("extrusion"), name)) return {};
        const JsonValue& polygons = value.find("polygons")->value;
        if (polygons.kind != JsonValue::Kind::kArray || polygons.items.empty()) {
            json_.fail(polygons, "`polygons` of " + name + messages::kNotPolygons,
                       messages::kNotPolygonsHelp);
            return {};
        }
        std::vector<mesh::Outline> outlines;
        for (const JsonValue& polygon : polygons.items)
            outlines.push_back(outline(polygon, name));
        const double height = json_.number(value.find("height")->value, "`height` of " + name, 1e-6,
                                           kLargestPrimitive_mm);
        if (!check(outlines, polygons, name)) return {};
        return mesh::make_extrusion(std::move(outlines), height);
    }

    std::optional<mesh::Mesh> revolution(const JsonValue& value, const std::string& name) {
        mesh::Outline polygon = outline(value, name);
        for (size_t i = 0; i < polygon.size() && json_.ok(); ++i) {
            if (polygon[i].x < 0) {
                json_.fail(value.items[i], name + messages::kCornerBeyondAxis,
                           messages::kCornerBeyondAxisHelp);
            }
        }
        if (!check({polygon}, value, name)) return {};
        return mesh::make_revolution(std::move(polygon));
    }

    bool check(const std::vector<mesh::Outline>& outlines, const JsonValue& value,
               const std::string& name) {
        if (!json_.ok()) return false;
        const Result<void> fine = mesh::check_outlines(outlines);
        if (!fine)
            json_.fail(value, fmt::format("{}: {}", name, fine.error().message), fine.error().help);
        return json_.ok();
    }

    JsonReader& json_;
};

}  // namespace

const std::vector<std::string>& primitive_keys() {
    static const std::vector<std::string> keys = [] {
        std::vector<std::string> all;
        for (const SizedPrimitive& row : kSized)
            all.emplace_back(row.key);
        all.insert(all.end(), {"extrusion", "revolution"});
        return all;
    }();
    return keys;
}

std::optional<mesh::Mesh> read_primitive(const JsonMember& source, const std::string& name,
                                         JsonReader* json) {
    std::optional<mesh::Mesh> mesh = PrimitiveReader(json).make(source, name);
    if (!json->ok()) mesh.reset();
    return mesh;
}

}  // namespace openfab::world
