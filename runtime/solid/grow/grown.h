// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// All that grows of a source, as far as it was asked for: clumps are made on demand and kept within a budget,
// the longest unused dropped first. Threads share it. What it answers does not depend on what it keeps.

#include <atomic>
#include <cstdint>
#include <limits>
#include <mutex>
#include <optional>

#include "base/lru_cache.h"
#include "runtime/solid/beams/beam.h"
#include "runtime/solid/grow/clump.h"

namespace openfab::solid {

/// Returns how a beam is asked for its distance.
BeamRecord record_of(const GrownBeam& beam, const Vec3d& center_part_mm);

/// Beams and bodies from several clumps, with their values.
struct GatheredBeams {
    std::vector<GrownBeam> beams;
    std::vector<GrownBody> bodies;
    std::vector<float> floats;   ///< [beam][end][component]
    std::vector<uint32_t> ints;  ///< [beam][component]

    void clear() { beams.clear(), bodies.clear(), floats.clear(), ints.clear(); }
    void add(const Clump& clump, size_t beam, const BeamValues& values);
};

/// What is done with beams while they are looked through, instead of gathering them. Boxes are in part space.
class Sieve {
  public:
    virtual ~Sieve() = default;
    /// Returns whether anything of a box matters.
    virtual bool reaches(const Box3f& box) const = 0;
    /// Returns whether a beam, of which this is the box, needs no gathering any more.
    virtual bool take(const GrownBeam& beam, const Box3f& box) = 0;
};

class Grown {
  public:
    Grown(std::unique_ptr<const ClumpSource> source, const Vec3d& center_part_mm, size_t bytes);

    BeamValues values() const { return source_->values(); }
    /// Returns the box of everything, part-local.
    Box3f bounds() const;
    bool has_bodies() const { return source_->has_bodies(); }
    /// Returns part space less part-local space.
    const Vec3d& center() const { return center_; }

    /// Appends the beams whose boxes touch a box, part-local. Nothing more after an error.
    void collect(const Box3f& box, GatheredBeams* out, Sieve* sieve = nullptr) const {
        collect(box, true, kNoLimit, out, sieve);
    }
    /// Likewise, but ends once there are this many, or many more that the sieve took; returns whether there are fewer.
    bool collect_few(const Box3f& box, size_t most, GatheredBeams* out, Sieve* sieve) const {
        return collect(box, true, most, out, sieve);
    }
    /// Likewise, but makes no clumps; returns whether all were there.
    bool collect_kept(const Box3f& box, GatheredBeams* out) const {
        return collect(box, false, kNoLimit, out, nullptr);
    }
    /// Appends the beams within a signed distance of a point, part-local, and a few more.
    void collect(const Vec3f& p, float limit, GatheredBeams* out) const;
    /// Finds the nearest beam of a point, which is appended; returns its signed distance, +inf if there is none.
    /// Of beams as near the one that grows before is found.
    float nearest(const Vec3f& p, GatheredBeams* out) const;
    /// Returns by how much distances of points like this may be wrong, with a margin; `d` from there, or less.
    float slack(const Vec3f& p, float d) const;

    /// Keeps what coverage looks through: it will be asked for again.
    void keep_all() { keeps_ = true; }
    /// Makes the first clump, whose errors `status` then has.
    void begin() const { root(); }
    /// Notes an error, unless there is one.
    void note(Error error) const;
    Result<void> status() const;
    bool failed() const { return failed_.load(std::memory_order_relaxed); }
    /// Changes the budget; call while no other thread uses it.
    void set_bytes(size_t bytes) const { kept_.set_budget(source_->share_bytes(bytes)); }
    void set_stop(const std::atomic<bool>* stop) const {
        stop_ = stop;
        source_->set_stop(stop);
    }
    /// Returns how many clumps were made, those again that were dropped, too.
    int64_t made() const { return made_; }

  private:
    using ClumpPtr = std::shared_ptr<const Clump>;
    struct Search;

    /// Returns the first clump, which is kept: all searches begin there. Null after an error.
    const Clump* root() const;
    static constexpr size_t kNoLimit = std::numeric_limits<size_t>::max();
    bool collect(const Box3f& box, bool make, size_t most, GatheredBeams* out, Sieve* sieve) const;
    /// Returns the clump of a bud if it is kept.
    ClumpPtr find(const Bud& bud, std::span<const uint32_t> state) const;
    /// Returns it in any case; null after an error.
    ClumpPtr get(const Bud& bud, std::span<const uint32_t> state) const;
    template <typename Reaches, typename Open, typename Take>
    bool visit(const Clump& clump, const Reaches& reaches, const Open& open_bud,
               const Take& take) const;
    void search(const Clump& clump, Search* best) const;
    bool full(size_t beams, const GrownBeam& last) const;
    void note_crowd(const Bud& last) const;

    const std::unique_ptr<const ClumpSource> source_;
    const Vec3d center_;
    bool keeps_ = false;
    std::vector<uint32_t> root_state_;
    Bud root_;
    mutable std::once_flag begun_;
    mutable ClumpPtr first_;
    mutable LruCache<uint64_t, Clump> kept_;
    mutable std::atomic<int64_t> made_{0};
    mutable std::atomic<const std::atomic<bool>*> stop_{nullptr};
    mutable std::atomic<bool> failed_{false};
    mutable std::mutex mutex_;
    mutable std::optional<Error> error_;
};

}  // namespace openfab::solid
