// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/pieces_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "base/near_miss.h"
#include "pieces/extent.h"
#include "world/messages.h"

namespace openfab::world {

namespace {

using Kind = JsonValue::Kind;
using pieces::Connector;
using pieces::Cut;
using pieces::Number;
using pieces::Tree;

constexpr size_t kMostCuts = 1000;
constexpr size_t kMostOnCut = 200;
constexpr size_t kLargestPieces = 16'000'000;
constexpr double kLargest_mm = 1e6;
constexpr double kUsualClearance_mm = 0.1, kUsualSkin_mm = 1;

class PiecesReader {
  public:
    PiecesReader(const World& world, JsonReader* json) : world_(world), json_(*json) {}

    void read(const JsonValue& value, const std::string& what, ObjectPieces* out) {
        out->location = json_.location(value);
        node(value, "`pieces` of " + what, "");
        if (!json_.ok()) return;
        out->tree = std::move(tree_);
        out->regions = pieces::regions(out->tree);
    }

  private:
    std::optional<Vec3d> vector(const JsonMember* m, const std::string& what) {
        if (m == nullptr) return std::nullopt;
        const std::vector<double> n =
            json_.numbers(m->value, fmt::format("`{}` of {}", m->key, what), 3, kLargest_mm);
        if (!json_.ok()) return std::nullopt;
        return Vec3d{n[0], n[1], n[2]};
    }

    std::optional<Vec3d> direction(const JsonMember* m, const std::string& what) {
        const std::optional<Vec3d> v = vector(m, what);
        if (v && !(length(*v) > 1e-9)) {
            json_.fail(m->value, fmt::format(messages::kNoDirection, m->key, what),
                       messages::kNoDirectionHelp);
            return std::nullopt;
        }
        return v;
    }

    double length_of(const JsonValue& value, const char* key, const std::string& what, double least,
                     double otherwise) {
        const JsonMember* m = value.find(key);
        if (m == nullptr) return otherwise;
        return json_.number(m->value, fmt::format("`{}` of {}", key, what), least, kLargest_mm);
    }

    double needed(const JsonValue& value, const char* key, const std::string& what) {
        if (value.find(key) == nullptr) {
            json_.fail(value, fmt::format(messages::kKeyMissing, what, key), messages::kIsRequired);
            return 1;
        }
        return length_of(value, key, what, 1e-3, 0);
    }

    /// Reads a cut and what is on its sides; `path` is the name of a piece there.
    int32_t node(const JsonValue& value, const std::string& what, const std::string& path) {
        if (!json_.object(value, world_keys("cut"), what)) return -1;
        if (tree_.cuts.size() == kMostCuts) {
            json_.fail(value, fmt::format(messages::kTooManyCuts, kMostCuts));
            return -1;
        }
        const size_t index = tree_.cuts.size();
        tree_.cuts.emplace_back();
        Cut cut;
        cut.location = json_.location(value);
        if (const auto normal = direction(value.find("normal"), what))
            cut.normal = *normal * (1 / length(*normal));
        const JsonValue& at = value.find("at_mm")->value;
        if (at.is(Kind::kNumber)) {
            cut.offset_mm = json_.number(at, "`at_mm` of " + what, 0 - kLargest_mm, kLargest_mm);
        } else if (const auto point = vector(value.find("at_mm"), what)) {
            cut.offset_mm = dot(cut.normal, *point);
        }
        connectors(value, what, &cut);
        numbers(value, what, &cut);
        tree_.cuts[index] = cut;
        const std::string dot = path.empty() ? "" : path + ".";
        const int32_t back = side(value.find("back"), what, dot + "1");
        const int32_t front = side(value.find("front"), what, dot + "2");
        tree_.cuts[index].back = back;
        tree_.cuts[index].front = front;
        return static_cast<int32_t>(index);
    }

    /// Reads another cut, or the name of a piece, which it has by its path otherwise.
    int32_t side(const JsonMember* m, const std::string& what, const std::string& path) {
        if (m != nullptr && !m->value.is(Kind::kString))
            return node(m->value, fmt::format("`{}` of {}", m->key, what), path);
        const std::string name =
            m == nullptr ? path : json_.string(m->value, fmt::format("`{}` of {}", m->key, what));
        if (m != nullptr && (name.empty() || name == "all" || name.starts_with("dowel "))) {
            json_.fail(m->value, fmt::format(messages::kPieceCannotBeCalled, name),
                       messages::kPieceCannotBeCalledHelp);
        }
        if (!names_.insert(name).second && m != nullptr)
            json_.fail(m->value, fmt::format(messages::kTwoPiecesOfName, name),
                       messages::kTwoPiecesOfNameHelp);
        tree_.pieces.push_back(name);
        return ~static_cast<int32_t>(tree_.pieces.size() - 1);
    }

    const std::vector<JsonValue>* list(const JsonValue& value, const char* key,
                                       const std::string& what) {
        const JsonMember* m = value.find(key);
        if (m == nullptr || !json_.ok()) return nullptr;
        if (!m->value.is(Kind::kArray)) {
            json_.fail(m->value, fmt::format("`{}` of {} is {}", key, what, m->value.kind_name()),
                       messages::kMustArray);
            return nullptr;
        }
        if (m->value.items.size() > kMostOnCut) {
            json_.fail(m->value, fmt::format(messages::kMoreThanInList, kMostOnCut, key));
            return nullptr;
        }
        return &m->value.items;
    }

    void connectors(const JsonValue& value, const std::string& what, Cut* cut) {
        const std::vector<JsonValue>* all = list(value, "connectors", what);
        for (size_t i = 0; all != nullptr && i < all->size() && json_.ok(); ++i)
            connector((*all)[i], fmt::format("`connectors[{}]` of {}", i, what), cut);
    }

    void connector(const JsonValue& value, const std::string& what, Cut* cut) {
        static constexpr const char* kKinds[] = {"peg", "dowel", "dovetail", "magnet"};
        if (!json_.object(value, world_keys("connector"), what)) return;
        Connector c;
        c.location = json_.location(value);
        const JsonMember* kind = nullptr;
        for (size_t i = 0; i < std::size(kKinds); ++i) {
            const JsonMember* m = value.find(kKinds[i]);
            if (m == nullptr) continue;
            if (kind != nullptr) {
                return json_.fail_at(
                    m->line, m->column,
                    fmt::format(messages::kTwoConnectorsInOne, what, kind->key, m->key),
                    messages::kTwoConnectorsInOneHelp);
            }
            kind = m;
            c.kind = static_cast<Connector::Kind>(i);
        }
        if (kind == nullptr) {
            return json_.fail(value, fmt::format(messages::kNoConnector, what),
                              messages::kNoConnectorHelp);
        }
        const bool dovetail = c.kind == Connector::Kind::kDovetail;
        const bool given = dovetail || c.kind == Connector::Kind::kPeg;
        if (const auto at = vector(kind, what)) c.at_mm = *at;
        unused(value, what, kind->key,
               dovetail ? std::vector<const char*>{"diameter_mm"}
                        : std::vector<const char*>{"width_mm", "along", "run_mm", "angle_deg"});
        if (!given) unused(value, what, kind->key, {"from"});
        if (c.kind == Connector::Kind::kMagnet) unused(value, what, kind->key, {"material"});
        c.diameter_mm = needed(value, dovetail ? "width_mm" : "diameter_mm", what);
        c.length_mm = needed(value, "length_mm", what);
        c.clearance_mm = length_of(value, "clearance_mm", what, 0, kUsualClearance_mm);
        c.skin_mm = length_of(value, "skin_mm", what, 0, kUsualSkin_mm);
        if (const JsonMember* m = value.find("from"))
            c.from_front = json_.choice(m->value, "`from` of " + what, {"back", "front"}) == 1;
        if (const auto along = direction(value.find("along"), what)) {
            c.along = *along;
            if (length(cross(c.along, cut->normal)) < 1e-6 * length(c.along)) {
                json_.fail(value.find("along")->value,
                           fmt::format(messages::kAlongAtRightAngle, what),
                           messages::kAlongAtRightAngleHelp);
            }
        }
        c.run_mm = length_of(value, "run_mm", what, 1e-3, c.run_mm);
        if (const JsonMember* m = value.find("angle_deg"))
            c.angle_deg = json_.number(m->value, "`angle_deg` of " + what, 0, 60);
        if (const JsonMember* m = value.find("material")) {
            c.material = json_.string(m->value, "`material` of " + what);
            std::vector<std::string> names;
            for (const Material& material : world_.materials)
                names.push_back(material.name);
            if (json_.ok() && std::find(names.begin(), names.end(), c.material) == names.end())
                json_.fail(m->value, fmt::format(messages::kNoSuchMaterial, c.material),
                           suggest(c.material, names));
        }
        cut->connectors.push_back(std::move(c));
    }

    void unused(const JsonValue& value, const std::string& what, const std::string& kind,
                const std::vector<const char*>& keys) {
        for (const char* key : keys) {
            const JsonMember* m = value.find(key);
            if (m != nullptr) {
                json_.fail_at(m->line, m->column,
                              fmt::format(messages::kConnectorWithoutKey, what, kind, key),
                              messages::kLeaveItOut);
            }
        }
    }

    void numbers(const JsonValue& value, const std::string& what, Cut* cut) {
        const std::vector<JsonValue>* all = list(value, "numbers", what);
        for (size_t i = 0; all != nullptr && i < all->size() && json_.ok(); ++i) {
            const JsonValue& one = (*all)[i];
            const std::string name = fmt::format("`numbers[{}]` of {}", i, what);
            if (!json_.object(one, world_keys("number"), name)) return;
            Number number;
            number.location = json_.location(one);
            if (const auto at = vector(one.find("at_mm"), name)) number.at_mm = *at;
            number.height_mm = length_of(one, "height_mm", name, 1e-3, 5);
            number.depth_mm = length_of(one, "depth_mm", name, 1e-3, 0.5);
            number.up = direction(one.find("up"), name);
            if (const JsonMember* m = one.find("side"))
                number.front = json_.choice(m->value, "`side` of " + name, {"back", "front"}) == 1;
            cut->numbers.push_back(std::move(number));
        }
    }

    const World& world_;
    JsonReader& json_;
    Tree tree_;
    std::set<std::string> names_;
};

}  // namespace

std::shared_ptr<const ObjectPieces> read_pieces(const JsonValue& value, const std::string& what,
                                                const World& world, JsonReader* json,
                                                WorldFiles* files) {
    auto out = std::make_shared<ObjectPieces>();
    if (!value.is(Kind::kString)) {
        PiecesReader(world, json).read(value, what, out.get());
        return json->ok() ? out : nullptr;
    }
    const std::filesystem::path file = files->existing(value, "the file of `pieces` of " + what);
    if (!json->ok()) return nullptr;
    const Result<std::string> text = read_text_file(file, kLargestPieces, files->roots());
    Result<JsonValue> root = text ? parse_json(*text, file.string()) : text.error();
    if (!root) {
        json->fail_with(root.error());
        return nullptr;
    }
    JsonReader own(file.string());
    PiecesReader(world, &own).read(*root, what, out.get());
    if (own.ok()) return out;
    json->fail_with(own.error());
    return nullptr;
}

void check_pieces_hold_something(const mesh::Mesh& mesh, const ObjectPieces& pieces,
                                 const std::string& what, JsonReader* json) {
    if (mesh.triangles.empty()) return;
    const pieces::Body body{mesh.positions, mesh.triangles};
    for (size_t i = 0; i < pieces.tree.pieces.size(); ++i) {
        const pieces::Region& region = pieces.regions[i];
        // A cut that only touches the mesh leaves nothing on one side.
        constexpr double kThinnest_mm = 1e-6;
        const Box3d of = pieces::piece_box(body, region, {});
        const Vec3d size = of.empty() ? Vec3d{} : of.size();
        if (std::min({size.x, size.y, size.z}) > kThinnest_mm) continue;
        const Cut& last = pieces.tree.cuts[static_cast<size_t>(region.cuts.back())];
        Box3d box;
        for (const Vec3d& p : mesh.positions)
            box.add(p);
        double lo = 1e300, hi = -1e300;
        for (const Vec3d& p : mesh.positions) {
            const double at = dot(last.normal, p);
            lo = std::min(lo, at), hi = std::max(hi, at);
        }
        json->fail_with(error_at(
            last.location, fmt::format(messages::kPieceEmpty, region.name, what, last.offset_mm),
            fmt::format(messages::kPieceEmptyHelp, lo, hi)));
        return;
    }
}

}  // namespace openfab::world
