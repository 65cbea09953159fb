// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// What grows, in clumps: a clump is some hundreds of beams and bodies of one branch, with buds from which more grow.
// It is made when something comes near its bud's box, and may be dropped and made again at any time: it
// follows from its bud alone.

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/at.h"
#include "base/result.h"
#include "base/vec.h"
#include "runtime/solid/grow/standing.h"

namespace openfab::solid {

/// A beam in part space, mm, or the place of a body.
struct GrownBeam {
    std::array<Vec3f, 2> end;  ///< of a body: the corners of its box, and its radii are 0
    std::array<float, 2> radius{};
    uint64_t id = 0;    ///< of its node: a hash of the numbers of children from the root on
    int32_t level = 0;  ///< how many parents its node has
    bool flat = false;  ///< cut across at its ends; else balls are there
    int32_t body = -1;  ///< among the bodies; -1: it is a beam
};

/// Returns whether one goes before another where both are as near: a beam, or the one of fewer parents.
inline bool grows_before(const GrownBeam& a, const GrownBeam& b) {
    if ((a.body < 0) != (b.body < 0)) return a.body < 0;
    return a.level != b.level ? a.level < b.level : a.id < b.id;
}

/// Returns the id of a child of a node.
uint64_t child_id(uint64_t node, int32_t child);

/// A node whose children are not there yet.
struct Bud {
    Box3f bound;  ///< that holds all of them, part space
    uint64_t id = 0;
    int32_t level = 0;
    int32_t children = 0;
    size_t state = 0;  ///< where what its rule knows of it begins, in Clump::states
};

/// What a clump says of its beams beside where they are. A body has the values of a first end.
struct BeamValues {
    int32_t floats = 0;  ///< at each end of a beam
    int32_t ints = 0;    ///< of a beam
};

class Clump {
  public:
    std::vector<GrownBeam> beams;
    std::vector<float> floats;   ///< [beam][end][component]
    std::vector<uint32_t> ints;  ///< [beam][component], bits
    std::vector<GrownBody> bodies;
    std::vector<Bud> buds;
    std::vector<uint32_t> states;  ///< of the buds

    /// Returns what a rule knows of a bud.
    std::span<const uint32_t> state(const Bud& bud) const {
        return std::span(states).subspan(bud.state, state_size);
    }
    size_t state_size = 0;
    /// Notes what it grows of, after its buds.
    void set_seed(const Bud& bud, std::span<const uint32_t> state) {
        seed_level_ = bud.level;
        seed_ = states.size();
        states.insert(states.end(), state.begin(), state.end());
    }
    /// Returns whether it grew of this bud, and not of another with the same id.
    bool grew_of(const Bud& bud, std::span<const uint32_t> state) const {
        return bud.level == seed_level_ &&
               std::ranges::equal(std::span(states).subspan(seed_), state);
    }
    size_t own_bytes = 0;  ///< of solids that are this clump's alone
    size_t empty = 0;      ///< nodes that were made, and of which there is nothing here
    /// Returns how many nodes were looked through for what is here.
    size_t nodes_made() const { return beams.size() + buds.size() + empty; }

    /// Adds a body, but for its values; `within`: what holds it.
    void add_body(GrownBody body, uint64_t id, int32_t level, const Box3f& within);
    /// Makes the tree of boxes. Call once all are there.
    void finish();
    /// Removes all; keeps its memory.
    void clear();
    size_t bytes() const;

    /// A node of the tree of boxes: of a leaf, items [first, first + count), which are beams, then buds;
    /// else the next node, and `first`.
    struct Node {
        Box3f box;
        int32_t first = 0;
        int32_t count = 0;
    };
    std::span<const Node> nodes() const { return nodes_; }
    /// Returns an item: the number of a beam, or beams.size() and more of a bud.
    size_t item(int32_t i) const { return static_cast<size_t>(at(items_, i)); }

  private:
    struct Item {
        Box3f box;
        Vec3f centre;
        int32_t number = 0;
    };
    void build(std::span<Item> items, int32_t first);

    std::vector<Node> nodes_;
    std::vector<int32_t> items_;
    int32_t seed_level_ = 0;
    size_t seed_ = 0;  ///< in states
};

/// Returns the box of a beam, a little larger.
inline Box3f box_of(const GrownBeam& beam) {
    // More than these sums are rounded by.
    constexpr float kRelative = 0x1p-23f, kLeast = 1e-30f;
    Box3f box;
    for (int a = 0; a < 3; ++a) {
        const float lo0 = beam.end[0][a] - beam.radius[0], hi0 = beam.end[0][a] + beam.radius[0];
        const float lo1 = beam.end[1][a] - beam.radius[1], hi1 = beam.end[1][a] + beam.radius[1];
        box.lo[a] = std::min(lo0 - (std::fabs(lo0) * kRelative + kLeast),
                             lo1 - (std::fabs(lo1) * kRelative + kLeast));
        box.hi[a] = std::max(hi0 + (std::fabs(hi0) * kRelative + kLeast),
                             hi1 + (std::fabs(hi1) * kRelative + kLeast));
    }
    return box;
}

/// Buds in no clump, with what rules know of them.
struct Buds {
    std::vector<Bud> buds;
    std::vector<uint32_t> states;

    void add(const Bud& bud, std::span<const uint32_t> state) {
        buds.push_back(bud);
        buds.back().state = states.size();
        states.insert(states.end(), state.begin(), state.end());
    }
};

/// What is done with nodes as they grow, instead of keeping them.
class Harvest {
  public:
    virtual ~Harvest() = default;
    /// Returns whether anything of a box matters.
    virtual bool reaches(const Box3f& box) const = 0;
    /// Takes what there is of some nodes; `of` is one of their parents. Returns whether more is wanted.
    virtual bool take(const Clump& there, size_t nodes, const Bud& of) = 0;
};

/// Makes clumps. Threads share it.
class ClumpSource {
  public:
    virtual ~ClumpSource() = default;
    virtual BeamValues values() const = 0;
    /// Returns whether there may be bodies.
    virtual bool has_bodies() const { return false; }
    /// As of a Solid, of what bodies are made of.
    virtual Result<void> status() const { return {}; }
    /// Returns an error of the user's, with the place that this was made of.
    virtual Error complaint(const std::string& what, const std::string& help) const {
        return user_error(what, help);
    }
    virtual void set_stop(const std::atomic<bool>* /*stop*/) const {}
    /// Takes a budget, of which bodies may need a part; returns the rest, for clumps.
    virtual size_t share_bytes(size_t bytes) const { return bytes; }
    /// Returns the bud of everything, and what is known of it.
    virtual Bud root(std::vector<uint32_t>* state) const = 0;
    /// Makes what grows of a bud.
    virtual Result<std::shared_ptr<const Clump>> grow(const Bud& bud,
                                                      std::span<const uint32_t> state) const = 0;
    virtual bool can_harvest() const { return false; }
    /// Grows what is reached of buds, many of them at once, and keeps none of it: where each is wanted once or twice, this
    /// takes a third of the time that clumps take.
    virtual Result<void> harvest(const Buds& /*from*/, Harvest* /*to*/) const { return {}; }
};

}  // namespace openfab::solid
