// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/threemf_beams.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <unordered_map>

#include "base/near_miss.h"
#include "base/similarity.h"
#include "mesh/read/threemf_build.h"
#include "mesh/read/threemf_model.h"
#include "mesh/read/zip_file.h"

namespace openfab::mesh {

namespace {

constexpr double kFarthest = 1e6;

BeamEnd end_of(ThreemfCap cap) {
    return cap == ThreemfCap::kButt ? BeamEnd::kFlat : BeamEnd::kDome;
}

class LatticeReader {
  public:
    LatticeReader(ZipFile zip, std::string file, int64_t memory_bytes)
        : zip_(std::move(zip)), file_(std::move(file)), memory_bytes_(memory_bytes) {}

    Result<ReadThreemfBeams> read() {
        ThreemfBuild build(zip_, file_, &memory_bytes_, &told_);
        const Result<const ThreemfModel*> root = build.root();
        if (!root) return root.error();
        out_.unit_mm = (*root)->unit_mm;
        const Result<void> placed =
            build.each([&](const ThreemfPlaced& one) -> Result<void> { return take(one); });
        if (!placed) return placed.error();
        out_.left_out = std::move(told_.list());
        return std::move(out_);
    }

  private:
    void fail(const std::string& what, const std::string& help = {}) {
        if (!error_) error_ = user_error(fmt::format("{}: {}", file_, what), help);
    }

    Result<void> take(const ThreemfPlaced& one) {
        const ThreemfObject& object = *one.object;
        out_.has_meshes |= !object.triangles.empty() && object.type == "model";
        if (object.lattice != nullptr && object.type == "model") add(object, one.map, one.name);
        if (object.lattice != nullptr && object.type != "model")
            told_.add(fmt::format("lattices of type `{}`", object.type.substr(0, 40)),
                      place_of(one.name),
                      "objects of type `model` are printed; change the type if this is a part");
        if (error_) return *error_;
        return {};
    }

    static std::string place_of(const std::string& name) {
        return name.empty() ? "an object without a name" : fmt::format("object `{}`", name);
    }

    std::string unique(const std::string& name) {
        const std::string first = name.empty() ? "lattice" : name;
        std::string made = first;
        for (int k = 2; !names_.insert(made).second; ++k)
            made = fmt::format("{} {}", first, k);
        return made;
    }

    void add(const ThreemfObject& object, const Affine3d& map, const std::string& name) {
        const ThreemfLattice& lattice = *object.lattice;
        const double scale = even_scale(map);
        if (!(scale > 0))
            return fail(
                fmt::format("the lattice of {} is scaled, and not alike in all directions, so that "
                            "its beams are not round",
                            place_of(name)),
                "apply the scale in the program that made it");
        tell(lattice, name);
        const size_t held =
            object.vertices.size() * sizeof(Vec3d) +
            3 * (lattice.beams.size() + lattice.balls.size()) * (sizeof(Beam) + sizeof(int32_t)) +
            object.vertices.size() * 64;
        memory_bytes_ -= static_cast<int64_t>(held);
        if (memory_bytes_ < 0)
            return fail("its lattices take more memory than is allowed",
                        "allow more with `--memory`");
        ThreemfBeams out;
        out.name = unique(name);
        out.sets = lattice.sets;
        nodes_.clear();
        const std::vector<int32_t> sets = sets_of(lattice);
        std::set<std::pair<int32_t, float>> balls;
        BeamAttribute numbers{"set", true, 1, {}, {}};
        int64_t shorter = 0;
        for (size_t i = 0; i < lattice.beams.size(); ++i) {
            const ThreemfBeam& from = lattice.beams[i];
            Beam beam;
            for (size_t e = 0; e < 2; ++e) {
                beam.nodes[e] = node(object, from.vertices[e], map, &out.beams);
                beam.radii[e] = static_cast<float>(scale * static_cast<double>(from.radii[e]));
            }
            if (error_) return;
            const Vec3d along = object.vertices[static_cast<size_t>(from.vertices[1])] -
                                object.vertices[static_cast<size_t>(from.vertices[0])];
            if (!(length(along) > 0) || length(along) < lattice.least_length) {
                ++shorter;
                continue;
            }
            // Of equal radii, the hull of two balls is the cylinder with both.
            const bool capsule = from.caps[0] == ThreemfCap::kSphere &&
                                 from.caps[1] == ThreemfCap::kSphere &&
                                 from.radii[0] == from.radii[1];
            if (!capsule) beam.ends = {end_of(from.caps[0]), end_of(from.caps[1])};
            out.beams.beams.push_back(beam);
            numbers.ints.push_back(sets[i]);
            for (size_t e = 0; e < 2 && !capsule; ++e) {
                if (from.caps[e] != ThreemfCap::kSphere ||
                    !balls.insert({beam.nodes[e], beam.radii[e]}).second)
                    continue;
                out.beams.beams.push_back(
                    {{beam.nodes[e], beam.nodes[e]}, {beam.radii[e], beam.radii[e]}});
                numbers.ints.push_back(sets[i]);
            }
        }
        add_balls(object, map, scale, &balls, &out.beams, &numbers);
        if (error_) return;
        if (shorter > 0)
            told_.add("beams shorter than `minlength`", place_of(name),
                      "the specification has readers ignore them");
        if (out.beams.beams.empty()) return;
        // Without sets, too: the stock fablet reads it.
        out.beams.attributes.push_back(std::move(numbers));
        out_.lattices.push_back(std::move(out));
    }

    void add_balls(const ThreemfObject& object, const Affine3d& map, double scale,
                   std::set<std::pair<int32_t, float>>* known, Beams* out, BeamAttribute* numbers) {
        const ThreemfLattice& lattice = *object.lattice;
        const auto put = [&](int32_t n, double r) {
            const auto radius = static_cast<float>(scale * r);
            if (n < 0 || !known->insert({n, radius}).second) return;
            out->beams.push_back({{n, n}, {radius, radius}});
            numbers->ints.push_back(0);
        };
        std::set<int32_t> listed;
        if (lattice.all_balls != ThreemfLattice::Balls::kNone) {
            for (const auto& [vertex, radius] : lattice.balls) {
                const int32_t n = node(object, vertex, map, out);
                listed.insert(n);
                put(n, static_cast<double>(radius));
            }
        }
        if (lattice.all_balls != ThreemfLattice::Balls::kAll || error_) return;
        if (!(lattice.ball_radius > 0))
            return fail("a lattice has `ballmode` all, and no `ballradius`");
        for (const auto& [vertex, n] : std::map<int32_t, int32_t>(nodes_.begin(), nodes_.end())) {
            if (!listed.contains(n)) put(n, lattice.ball_radius);
        }
    }

    /// Returns the number of a vertex among the nodes, adding it on first use.
    int32_t node(const ThreemfObject& object, int32_t vertex, const Affine3d& map, Beams* out) {
        if (vertex < 0 || static_cast<size_t>(vertex) >= object.vertices.size()) {
            fail(fmt::format("a beam or ball refers to vertex {}, but there are {}", vertex,
                             object.vertices.size()));
            return 0;
        }
        const auto [it, fresh] =
            nodes_.try_emplace(vertex, static_cast<int32_t>(out->nodes.size()));
        if (!fresh) return it->second;
        const Vec3d p = map.apply(object.vertices[static_cast<size_t>(vertex)]);
        for (int a = 0; a < 3; ++a) {
            if (!(std::fabs(p[a]) <= kFarthest))
                fail(fmt::format("a node of a lattice lies at {:g}, beyond {:g}", p[a], kFarthest));
        }
        out->nodes.push_back(p);
        return it->second;
    }

    /// Returns the number of each beam's first set; 0 of none.
    static std::vector<int32_t> sets_of(const ThreemfLattice& lattice) {
        std::vector<int32_t> sets(lattice.beams.size(), 0);
        for (const auto& [beam, set] : lattice.members) {
            if (static_cast<size_t>(beam) >= sets.size()) continue;
            int32_t& of = sets[static_cast<size_t>(beam)];
            if (of == 0) of = set;
        }
        return sets;
    }

    void tell(const ThreemfLattice& lattice, const std::string& name) {
        if (!lattice.clipping.empty())
            told_.add(fmt::format("the mesh that clips a lattice, mode `{}`", lattice.clipping),
                      place_of(name), "clip the beams in the program that made them");
        if (lattice.has_representation)
            told_.add("meshes that represent lattices", place_of(name),
                      "they are for display alone");
        if (lattice.has_properties)
            told_.add("colours and materials of beams", place_of(name),
                      "put the beams in sets, which a fablet tells apart by `@nearest int set`");
    }

    ZipFile zip_;
    std::string file_;
    int64_t memory_bytes_;
    ThreemfTold told_;
    ReadThreemfBeams out_;
    std::set<std::string> names_;
    std::unordered_map<int32_t, int32_t> nodes_;  ///< of the lattice that is read, by vertex
    std::optional<Error> error_;
};

/// Adds the beams of one lattice to those of others; attributes that only some have are 0 elsewhere.
void append(const ThreemfBeams& from, Beams* to) {
    const auto first = static_cast<int32_t>(to->nodes.size());
    to->nodes.insert(to->nodes.end(), from.beams.nodes.begin(), from.beams.nodes.end());
    const size_t before = to->beams.size();
    for (Beam beam : from.beams.beams) {
        for (int32_t& node : beam.nodes)
            node += first;
        to->beams.push_back(beam);
    }
    if (!from.beams.attributes.empty() && to->attributes.empty())
        to->attributes.push_back({"set", true, 1, {}, std::vector<int32_t>(before, 0)});
    if (to->attributes.empty()) return;
    std::vector<int32_t>& numbers = to->attributes[0].ints;
    if (!from.beams.attributes.empty()) {
        const std::vector<int32_t>& more = from.beams.attributes[0].ints;
        numbers.insert(numbers.end(), more.begin(), more.end());
    }
    numbers.resize(to->beams.size(), 0);
}

}  // namespace

Result<ReadThreemfBeams> parse_threemf_beams(std::string_view bytes, const std::string& file,
                                             int64_t memory_bytes) {
    Result<ZipFile> zip = ZipFile::open(bytes, file);
    if (!zip) return zip.error();
    return LatticeReader(std::move(*zip), file, memory_bytes).read();
}

Result<ReadBeams> parse_threemf_beams(std::string_view bytes, const std::string& file,
                                      const std::string& body, int64_t memory_bytes) {
    Result<ReadThreemfBeams> read = parse_threemf_beams(bytes, file, memory_bytes);
    if (!read) return read.error();
    if (read->lattices.empty())
        return user_error(fmt::format("{}: the build places no lattice of beams", file),
                          "`file` instead of `beams` reads its meshes");
    ReadBeams out;
    out.unit_mm = read->unit_mm;
    for (const LeftOut& left : read->left_out)
        out.warnings.push_back(file + ": " + describe(left));
    std::vector<std::string> names;
    for (const ThreemfBeams& one : read->lattices) {
        names.push_back(one.name);
        if (body.empty() || one.name == body) append(one, &out.beams);
    }
    if (out.beams.beams.empty())
        return user_error(fmt::format("{}: no lattice is called `{}`", file, body.substr(0, 80)),
                          suggest(body.substr(0, 80), names));
    return out;
}

}  // namespace openfab::mesh
