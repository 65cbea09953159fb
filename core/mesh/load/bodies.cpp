// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/load/bodies.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <set>

#include "mesh/check/disjoint_sets.h"
#include "mesh/check/nesting.h"
#include "mesh/model/messages.h"

namespace openfab::mesh {
namespace {

/// What is summed up of a unit's triangles.
struct Unit {
    int32_t body = 0;  ///< of the reader
    int32_t look = -1;
    int64_t triangles = 0;
    uint64_t directed = 0;  ///< 0: each edge is used as often forwards as backwards
    uint64_t parity = 0;    ///< 0: each edge is used an even number of times
    double volume = 0;
    Box3d box;

    void add(const Unit& other) {
        triangles += other.triangles;
        directed += other.directed;
        parity ^= other.parity;
        volume += other.volume;
        box.add(other.box);
    }
    bool closed() const { return directed == 0 || parity == 0; }
    bool flat() const {
        const double diagonal = length(box.size());
        return !(std::abs(volume) > 1e-12 * diagonal * diagonal * diagonal);
    }
};

uint64_t mixed(uint64_t h) {
    h = (h ^ (h >> 32)) * 0xd6e8feb86659fd93u;
    h = (h ^ (h >> 32)) * 0xd6e8feb86659fd93u;
    return h ^ (h >> 32);
}

/// Edges by the places of their ends: which vertices a file has there does not matter.
class EdgeKeys {
  public:
    explicit EdgeKeys(const Mesh& mesh) : of_vertex_(mesh.positions.size()) {
        for (size_t v = 0; v < of_vertex_.size(); ++v) {
            uint64_t h = 0;
            // -0 and 0 are the same place.
            for (int a = 0; a < 3; ++a)
                h = mixed(h + std::bit_cast<uint64_t>(mesh.positions[v][a] + 0.0) + 1);
            of_vertex_[v] = h;
        }
    }

    struct Key {
        uint64_t edge = 0;  ///< 0: its ends are in one place
        bool forward = false;
    };
    Key key(int32_t from, int32_t to) const {
        const uint64_t a = of_vertex_[from], b = of_vertex_[to];
        if (a == b) return {};
        return {mixed(std::min(a, b) * 3 + std::max(a, b)), a < b};
    }

  private:
    std::vector<uint64_t> of_vertex_;
};

template <typename Visit>
void for_each_key(const EdgeKeys& keys, const std::array<int32_t, 3>& triangle,
                  const Visit& visit) {
    for (size_t c = 0; c < 3; ++c) {
        const EdgeKeys::Key key = keys.key(triangle[c], triangle[c == 2 ? 0 : c + 1]);
        if (key.edge != 0) visit(key);
    }
}

class BodyFinder {
  public:
    explicit BodyFinder(const MeshSource& source) : source_(source) {}

    FoundBodies find() {
        make_units();
        if (units_.size() < 2) return one_body();
        const EdgeKeys keys(source_.mesh);
        measure(keys);
        if (unite_looks() > 1) {
            DisjointSets sets(units_.size());
            join_open(keys, &sets);
            join_hollows(&sets);
            return named(&sets);
        }
        return one_body();
    }

  private:
    /// A unit for each body and look.
    void make_units() {
        unit_of_group_.resize(source_.groups.size());
        std::map<std::pair<int32_t, int32_t>, int32_t> numbers;
        for (size_t g = 0; g < source_.groups.size(); ++g) {
            const FaceGroup& group = source_.groups[g];
            const auto [it, fresh] = numbers.emplace(std::pair(group.body, group.look),
                                                     static_cast<int32_t>(units_.size()));
            if (fresh) {
                units_.push_back({});
                units_.back().body = group.body;
                units_.back().look = group.look;
            }
            unit_of_group_[g] = it->second;
        }
    }

    int32_t unit_of(size_t t) const { return unit_of_group_[source_.face_groups[t]]; }

    /// In blocks that depend on the file alone, as sums of volumes do.
    void measure(const EdgeKeys& keys) {
        const size_t count = source_.mesh.triangles.size();
        constexpr size_t kBlock = 1 << 16;
        constexpr size_t kFewUnits = 256;
        const size_t blocks = units_.size() > kFewUnits ? 1 : count / kBlock + 1;
        const size_t size = (count + blocks - 1) / blocks;
        std::vector<std::vector<Unit>> sums(blocks, units_);
        tbb::parallel_for(size_t{0}, blocks, [&](size_t i) {
            for (size_t t = i * size; t < std::min(count, (i + 1) * size); ++t)
                measure_triangle(keys, t, &sums[i]);
        });
        for (const std::vector<Unit>& block : sums) {
            for (size_t u = 0; u < units_.size(); ++u)
                units_[u].add(block[u]);
        }
    }

    void measure_triangle(const EdgeKeys& keys, size_t t, std::vector<Unit>* units) const {
        const Mesh& mesh = source_.mesh;
        Unit& unit = (*units)[unit_of(t)];
        const auto& v = mesh.triangles[t];
        ++unit.triangles;
        for_each_key(keys, v, [&](const EdgeKeys::Key& key) {
            unit.directed += key.forward ? key.edge : 0 - key.edge;
            unit.parity ^= key.edge;
        });
        unit.volume +=
            dot(mesh.positions[v[0]], cross(mesh.positions[v[1]], mesh.positions[v[2]])) / 6;
        for (int32_t corner : v)
            unit.box.add(mesh.positions[corner]);
    }

    /// Unites the looks of bodies unless those of each are closed; returns how many units have
    /// triangles.
    int64_t unite_looks() {
        std::map<int32_t, bool> apart;  // by body
        for (const Unit& unit : units_) {
            if (unit.triangles == 0) continue;
            bool& all = apart.try_emplace(unit.body, true).first->second;
            all = all && unit.closed() && !unit.flat();
        }
        std::map<int32_t, int32_t> first;  // unit of a body
        std::vector<int32_t> number(units_.size());
        std::vector<Unit> kept;
        for (size_t u = 0; u < units_.size(); ++u) {
            const Unit& unit = units_[u];
            if (unit.triangles == 0) continue;
            const auto next = static_cast<int32_t>(kept.size());
            const auto [it, fresh] = first.emplace(unit.body, next);
            if (fresh || apart[unit.body]) {
                number[u] = next;
                kept.push_back(unit);
                continue;
            }
            number[u] = it->second;
            Unit& whole = kept[it->second];
            whole.look = -1;
            whole.add(unit);
        }
        for (int32_t& u : unit_of_group_)
            u = number[u];
        units_ = std::move(kept);
        return static_cast<int64_t>(units_.size());
    }

    const Body& body_of(const Unit& unit) const {
        static const Body kUnnamed;
        return static_cast<size_t>(unit.body) < source_.bodies.size() ? source_.bodies[unit.body]
                                                                      : kUnnamed;
    }

    /// Joins open units at edges where each is open.
    void join_open(const EdgeKeys& keys, DisjointSets* sets) {
        struct Use {
            uint64_t edge = 0;
            int32_t unit = 0;
            int32_t turns = 0;
            auto key() const { return std::pair(edge, unit); }
        };
        std::vector<Use> uses;
        const auto is_open = [](const Unit& unit) { return !unit.closed(); };
        if (std::count_if(units_.begin(), units_.end(), is_open) < 2) return;
        for (size_t t = 0; t < source_.mesh.triangles.size(); ++t) {
            const int32_t u = unit_of(t);
            if (!is_open(units_[u])) continue;
            for_each_key(keys, source_.mesh.triangles[t], [&](const EdgeKeys::Key& key) {
                uses.push_back({key.edge, u, key.forward ? 1 : -1});
            });
        }
        std::sort(uses.begin(), uses.end(),
                  [](const Use& a, const Use& b) { return a.key() < b.key(); });
        for (size_t i = 0; i < uses.size();) {
            const uint64_t edge = uses[i].edge;
            int32_t before = -1;
            while (i < uses.size() && uses[i].edge == edge) {
                const int32_t u = uses[i].unit;
                int32_t turns = 0;
                for (; i < uses.size() && uses[i].edge == edge && uses[i].unit == u; ++i)
                    turns += uses[i].turns;
                if (turns == 0) continue;
                if (before >= 0 && body_of(units_[before]).role == body_of(units_[u]).role)
                    sets->join(before, u);
                before = u;
            }
        }
    }

    /// Joins closed units that are inside out to the unit that they are in.
    void join_hollows(DisjointSets* sets) {
        const auto inside_out = [](const Unit& unit) {
            return unit.closed() && unit.volume < 0 && !unit.flat();
        };
        if (std::none_of(units_.begin(), units_.end(), inside_out)) return;
        std::vector<int32_t> pieces(source_.mesh.triangles.size());
        for (size_t t = 0; t < pieces.size(); ++t)
            pieces[t] = unit_of(t);
        const std::optional<Nesting> nesting =
            find_nesting(source_.mesh, pieces, static_cast<int32_t>(units_.size()));
        if (!nesting) return;
        // A file may be inside out as a whole.
        bool all = true;
        for (size_t u = 0; u < units_.size(); ++u)
            all = all && (!nesting->inside[u].empty() || inside_out(units_[u]));
        for (size_t u = 0; u < units_.size(); ++u) {
            if (units_[u].flat() || inside_out(units_[u]) == all) continue;
            int32_t around = -1;
            for (const int32_t other : nesting->inside[u]) {
                const bool solid = inside_out(units_[other]) == all;
                if (solid && (around < 0 ||
                              std::abs(units_[other].volume) < std::abs(units_[around].volume)))
                    around = other;
            }
            if (around >= 0) sets->join(around, static_cast<int32_t>(u));
        }
    }

    std::string name_of(const Unit& unit, bool look_tells) const {
        std::string name = body_of(unit).name;
        if (look_tells && unit.look >= 0 && !source_.looks[unit.look].name.empty())
            name += (name.empty() ? "" : " ") + source_.looks[unit.look].name;
        return name.empty() ? "body" : name;
    }

    FoundBodies named(DisjointSets* sets) {
        FoundBodies out;
        std::map<int32_t, int32_t> units_of_body;
        for (const Unit& unit : units_)
            ++units_of_body[unit.body];
        std::vector<int32_t> number(units_.size(), -1);
        std::set<std::string> taken;
        std::map<std::string, int> next;
        for (size_t u = 0; u < units_.size(); ++u) {
            const int32_t root = sets->find(static_cast<int32_t>(u));
            if (number[root] >= 0) {
                FoundBody& whole = out.bodies[number[root]];
                whole.joined = true;
                whole.flat = false;
                number[u] = number[root];
                continue;
            }
            number[u] = number[root] = static_cast<int32_t>(out.bodies.size());
            const Unit& unit = units_[u];
            const Body& body = body_of(unit);
            const std::string wanted = name_of(unit, units_of_body[unit.body] > 1);
            std::string name = wanted;
            for (int& i = next.try_emplace(wanted, 2).first->second; !taken.insert(name).second;
                 ++i)
                name = fmt::format("{} {}", wanted, i);
            out.bodies.push_back(
                {name, body.role, body.assembly, false, unit.closed() && unit.flat()});
        }
        for (const int32_t u : unit_of_group_)
            out.of_group.push_back(number[u]);
        return out;
    }

    FoundBodies one_body() const {
        FoundBodies out;
        const bool one = units_.size() == 1;
        const Body body = one                       ? body_of(units_[0])
                          : !source_.bodies.empty() ? source_.bodies[0]
                                                    : Body{};
        out.bodies.push_back({body.name.empty() ? "body" : body.name, body.role, body.assembly});
        return out;
    }

    const MeshSource& source_;
    std::vector<Unit> units_;
    std::vector<int32_t> unit_of_group_;
};

/// Numbers what a body uses of a list, in the order of its first uses.
class Renumbering {
  public:
    explicit Renumbering(size_t size) : stamp_(size, -1), number_(size) {}
    /// Returns the number of `index` in `body`, and appends it to `used` if it is new.
    int32_t operator()(int32_t body, int32_t index, std::vector<int32_t>* used) {
        if (stamp_[index] != body) {
            stamp_[index] = body;
            number_[index] = static_cast<int32_t>(used->size());
            used->push_back(index);
        }
        return number_[index];
    }

  private:
    std::vector<int32_t> stamp_, number_;
};

/// Copies the attributes of a body's triangles.
void take_attributes(const MeshAttribute& from, const std::vector<int32_t>& triangles, int32_t body,
                     Renumbering* renumber, MeshAttribute* to) {
    to->name = from.name;
    to->is_int = from.is_int;
    to->components = from.components;
    const auto n = static_cast<size_t>(from.components);
    if (from.is_int) {
        for (const int32_t t : triangles) {
            for (size_t c = 0; c < n; ++c)
                to->faces.push_back(from.faces[static_cast<size_t>(t) * n + c]);
        }
        return;
    }
    std::vector<int32_t> used;
    to->corners.reserve(triangles.size());
    for (const int32_t t : triangles) {
        std::array<int32_t, 3> corners = from.corners[t];
        for (int32_t& c : corners)
            c = c < 0 ? -1 : (*renumber)(body, c, &used);
        to->corners.push_back(corners);
    }
    to->values.reserve(used.size() * n);
    for (const int32_t v : used) {
        for (size_t c = 0; c < n; ++c)
            to->values.push_back(from.values[static_cast<size_t>(v) * n + c]);
    }
}

}  // namespace

FoundBodies find_bodies(const MeshSource& source) {
    return BodyFinder(source).find();
}

std::vector<MeshSource> split_bodies(const MeshSource& source, const FoundBodies& found,
                                     const std::vector<int32_t>& wanted) {
    const Mesh& mesh = source.mesh;
    std::vector<int32_t> place(found.bodies.size(), -1);
    for (size_t i = 0; i < wanted.size(); ++i)
        place[wanted[i]] = static_cast<int32_t>(i);
    std::vector<std::vector<int32_t>> triangles(wanted.size());
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
        const int32_t at = place[found.of_triangle(source, t)];
        if (at >= 0) triangles[at].push_back(static_cast<int32_t>(t));
    }
    Renumbering vertices(mesh.positions.size()), groups(source.groups.size());
    std::vector<Renumbering> values;
    for (const MeshAttribute& a : mesh.attributes)
        values.emplace_back(a.is_int ? 0 : a.values.size() / static_cast<size_t>(a.components));
    std::vector<MeshSource> out(wanted.size());
    for (size_t i = 0; i < wanted.size(); ++i) {
        const auto number = static_cast<int32_t>(i);
        MeshSource& body = out[i];
        body.unit_mm = source.unit_mm;
        body.origin.file = source.origin.file;
        body.corners_joined = source.corners_joined;
        std::vector<int32_t> used, groups_used;
        body.mesh.triangles.reserve(triangles[i].size());
        for (const int32_t t : triangles[i]) {
            std::array<int32_t, 3> corners = mesh.triangles[t];
            for (int32_t& v : corners)
                v = vertices(number, v, &used);
            body.mesh.triangles.push_back(corners);
            if (!source.origin.lines.empty()) body.origin.lines.push_back(source.origin.lines[t]);
            if (source.face_groups.empty()) continue;
            const int32_t group = source.face_groups[t];
            const size_t known = groups_used.size();
            const int32_t g = groups(number, group, &groups_used);
            if (groups_used.size() > known) body.group_index(source.groups[group]);
            body.face_groups.push_back(g);
        }
        const bool parts = !source.part_of_vertex.empty() && !found.bodies[wanted[i]].joined;
        for (const int32_t v : used) {
            body.mesh.positions.push_back(mesh.positions[v]);
            if (parts) body.part_of_vertex.push_back(source.part_of_vertex[v]);
        }
        body.mesh.attributes.resize(mesh.attributes.size());
        for (size_t a = 0; a < mesh.attributes.size(); ++a)
            take_attributes(mesh.attributes[a], triangles[i], number, &values[a],
                            &body.mesh.attributes[a]);
    }
    return out;
}

void keep_parts(const FoundBodies& found, MeshSource* source) {
    FoundBodies parts;
    parts.bodies.resize(2);
    std::string others;
    for (const FoundBody& body : found.bodies) {
        if (body.role != BodyRole::kPart)
            others += fmt::format("{}`{}`", others.empty() ? "" : ", ", body.name);
    }
    if (others.empty()) return;
    for (const int32_t body : found.of_group)
        parts.of_group.push_back(found.bodies[body].role == BodyRole::kPart ? 0 : 1);
    std::vector<MeshSource> kept = split_bodies(*source, parts, {0});
    source->mesh = std::move(kept[0].mesh);
    source->origin = std::move(kept[0].origin);
    source->groups = std::move(kept[0].groups);
    source->face_groups = std::move(kept[0].face_groups);
    source->part_of_vertex = std::move(kept[0].part_of_vertex);
    source->warnings.push_back(fmt::format(messages::kBodiesThatCut, source->origin.file, others));
}

}  // namespace openfab::mesh
