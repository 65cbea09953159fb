// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/threemf_lattice_beams.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <unordered_map>
#include <utility>

#include "base/similarity.h"
#include "mesh/read/messages.h"

namespace openfab::mesh {

namespace {

constexpr double kFarthest = 1e6;

BeamEnd end_of(ThreemfCap cap) {
    return cap == ThreemfCap::kButt ? BeamEnd::kFlat : BeamEnd::kDome;
}

class LatticeBeams {
  public:
    LatticeBeams(std::string file, int64_t* memory_bytes, ThreemfTold* told)
        : file_(std::move(file)), memory_bytes_(memory_bytes), told_(told) {}

    Result<ThreemfBeams> read(const ThreemfObject& object, const Affine3d& map,
                              const std::string& name) {
        ThreemfBeams out;
        out.sets = object.lattice->sets;
        add(object, map, name, &out.beams);
        if (error_) return *error_;
        return out;
    }

  private:
    void fail(const std::string& what, const std::string& help = {}) {
        if (!error_) error_ = user_error(fmt::format("{}: {}", file_, what), help);
    }

    void add(const ThreemfObject& object, const Affine3d& map, const std::string& name,
             Beams* out) {
        const ThreemfLattice& lattice = *object.lattice;
        const double scale = even_scale(map);
        if (!(scale > 0))
            return fail(fmt::format(messages::kLatticeScaledUnevenly, lattice_place(name)),
                        messages::kLatticeScaledUnevenlyHelp);
        tell(lattice, name);
        const size_t held =
            object.vertices.size() * sizeof(Vec3d) +
            3 * (lattice.beams.size() + lattice.balls.size()) * (sizeof(Beam) + sizeof(int32_t)) +
            object.vertices.size() * 64;
        *memory_bytes_ -= static_cast<int64_t>(held);
        if (*memory_bytes_ < 0)
            return fail(messages::kLatticesTakeTooMuch, messages::kAllowMoreMemory);
        const std::vector<int32_t> sets = sets_of(lattice);
        std::set<std::pair<int32_t, float>> balls;
        BeamAttribute numbers{"set", true, 1, {}, {}};
        int64_t shorter = 0;
        for (size_t i = 0; i < lattice.beams.size(); ++i) {
            const ThreemfBeam& from = lattice.beams[i];
            Beam beam;
            for (size_t e = 0; e < 2; ++e) {
                beam.nodes[e] = node(object, from.vertices[e], map, out);
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
            out->beams.push_back(beam);
            numbers.ints.push_back(sets[i]);
            for (size_t e = 0; e < 2 && !capsule; ++e) {
                if (from.caps[e] != ThreemfCap::kSphere ||
                    !balls.insert({beam.nodes[e], beam.radii[e]}).second)
                    continue;
                out->beams.push_back(
                    {{beam.nodes[e], beam.nodes[e]}, {beam.radii[e], beam.radii[e]}});
                numbers.ints.push_back(sets[i]);
            }
        }
        add_balls(object, map, scale, &balls, out, &numbers);
        if (error_) return;
        if (shorter > 0)
            told_->add(messages::kShortBeams, lattice_place(name), messages::kShortBeamsHelp);
        if (out->beams.empty()) return;
        // Without sets, too: the stock fablet reads it.
        out->attributes.push_back(std::move(numbers));
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
        if (!(lattice.ball_radius > 0)) return fail(messages::kNoBallRadius);
        for (const auto& [vertex, n] : std::map<int32_t, int32_t>(nodes_.begin(), nodes_.end())) {
            if (!listed.contains(n)) put(n, lattice.ball_radius);
        }
    }

    /// Returns the number of a vertex among the nodes, adding it on first use.
    int32_t node(const ThreemfObject& object, int32_t vertex, const Affine3d& map, Beams* out) {
        if (vertex < 0 || static_cast<size_t>(vertex) >= object.vertices.size()) {
            fail(fmt::format(messages::kBeamOfNoVertex, vertex, object.vertices.size()));
            return 0;
        }
        const auto [it, fresh] =
            nodes_.try_emplace(vertex, static_cast<int32_t>(out->nodes.size()));
        if (!fresh) return it->second;
        const Vec3d p = map.apply(object.vertices[static_cast<size_t>(vertex)]);
        for (int a = 0; a < 3; ++a) {
            if (!(std::fabs(p[a]) <= kFarthest))
                fail(fmt::format(messages::kNodeLatticeLiesBeyond, p[a], kFarthest));
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
            told_->add(fmt::format(messages::kMeshThatClips, lattice.clipping), lattice_place(name),
                       messages::kMeshThatClipsHelp);
        if (lattice.has_representation)
            told_->add(messages::kMeshesOfLattices, lattice_place(name),
                       messages::kMeshesOfLatticesHelp);
        if (lattice.has_properties)
            told_->add(messages::kColoursOfBeams, lattice_place(name),
                       messages::kColoursOfBeamsHelp);
    }

    std::string file_;
    int64_t* memory_bytes_;
    ThreemfTold* told_;
    std::unordered_map<int32_t, int32_t> nodes_;  ///< of the lattice, by vertex
    std::optional<Error> error_;
};

}  // namespace

std::string lattice_place(const std::string& name) {
    return name.empty() ? messages::kObjectWithoutName : fmt::format("object `{}`", name);
}

Result<ThreemfBeams> lattice_beams(const ThreemfObject& object, const Affine3d& map,
                                   const std::string& name, const std::string& file,
                                   int64_t* memory_bytes, ThreemfTold* told) {
    return LatticeBeams(file, memory_bytes, told).read(object, map, name);
}

}  // namespace openfab::mesh
