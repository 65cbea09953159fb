// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/primitive_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "mesh/model/primitives.h"
#include "mesh/model/sweeps.h"
#include "world/world_keys.h"

namespace openfab::world {
namespace {

constexpr double kLargestPrimitive_mm = 1e5;

class PrimitiveReader {
  public:
    explicit PrimitiveReader(JsonReader* json) : json_(*json) {}

    std::optional<mesh::Mesh> make(const JsonMember& source, const std::string& name) {
        const JsonValue& value = source.value;
        if (source.key == "extrusion") return extrusion(value, name);
        if (source.key == "revolution") return revolution(value, name);
        if (source.key == "box") {
            const std::vector<double> s = sizes(value, name, 3);
            return mesh::make_box({s[0], s[1], s[2]});
        }
        if (source.key == "sphere")
            return mesh::make_sphere(json_.number(value, name, 1e-6, kLargestPrimitive_mm));
        if (source.key == "cone") {
            const std::vector<double> s = sizes(value, name, 3, {0, 1});
            if (json_.ok() && s[0] == 0 && s[1] == 0)
                json_.fail(value, name + " has no diameter above 0 mm");
            if (!json_.ok()) return {};
            return mesh::make_cone(s[0], s[1], s[2]);
        }
        const std::vector<double> s = sizes(value, name, 2);
        if (source.key == "torus") {
            if (json_.ok() && !(s[1] < s[0]))
                json_.fail(value, name + " has a section as wide as its ring, or wider");
            if (!json_.ok()) return {};
            return mesh::make_torus(s[0], s[1]);
        }
        if (source.key == "capsule") {
            if (json_.ok() && s[1] < s[0])
                json_.fail(value, name + " is shorter than its diameter",
                           "give the diameter, then the length with both ends");
            if (!json_.ok()) return {};
            return mesh::make_capsule(s[0], s[1]);
        }
        return source.key == "cylinder" ? mesh::make_cylinder(s[0], s[1])
                                        : mesh::make_plane(s[0], s[1]);
    }

  private:
    /// Reads `count` numbers of 0 ... kLargestPrimitive_mm; only those at `may_be_zero` may be 0.
    std::vector<double> sizes(const JsonValue& value, const std::string& name, size_t count,
                              const std::vector<size_t>& may_be_zero = {}) {
        std::vector<double> out = json_.numbers(value, name, count, kLargestPrimitive_mm);
        for (size_t i = 0; i < count && json_.ok(); ++i) {
            const bool zero = std::ranges::find(may_be_zero, i) != may_be_zero.end();
            if (!(out[i] > 0 || (zero && out[i] == 0)))
                json_.fail(value.items[i], name + " has a size that is not above 0 mm");
        }
        return out;
    }

    mesh::Outline outline(const JsonValue& value, const std::string& name) {
        mesh::Outline out;
        if (value.kind != JsonValue::Kind::kArray)
            json_.fail(value, name + " is not a polygon", "write [[x, y], [x, y], [x, y]] in mm");
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
            json_.fail(polygons, "`polygons` of " + name + " is not an array of polygons",
                       "write [[[x, y], [x, y], [x, y]]] in mm; one within another is a hole");
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
                json_.fail(value.items[i], name + " has a corner beyond the axis",
                           "give [distance from the axis, z], the distance 0 or more");
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
    static const std::vector<std::string> keys = {"box",     "sphere",    "cylinder",
                                                  "plane",   "cone",      "torus",
                                                  "capsule", "extrusion", "revolution"};
    return keys;
}

std::optional<mesh::Mesh> read_primitive(const JsonMember& source, const std::string& name,
                                         JsonReader* json) {
    std::optional<mesh::Mesh> mesh = PrimitiveReader(json).make(source, name);
    if (!json->ok()) mesh.reset();
    return mesh;
}

}  // namespace openfab::world
