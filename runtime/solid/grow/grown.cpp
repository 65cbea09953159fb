// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/grow/grown.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/infinity.h"
#include "runtime/solid/messages.h"

namespace openfab::solid {

namespace {

/// Beams of one tile of voxels; more are finer than the voxels by far.
constexpr size_t kMostGathered = size_t{1} << 19;
/// What is looked through for them; more takes seconds a tile, and is mostly a rule that never ends.
constexpr size_t kMostOpened = size_t{1} << 23;
constexpr size_t kShards = 4;  // few: a clump may be large

}  // namespace

BeamRecord record_of(const GrownBeam& beam, const Vec3d& center_part_mm) {
    mesh::Beam as;
    as.radii = beam.radius;
    if (beam.flat) as.ends = {mesh::BeamEnd::kFlat, mesh::BeamEnd::kFlat};
    return make_record(as, 0, vec_cast<double>(beam.end[0]) - center_part_mm,
                       vec_cast<double>(beam.end[1]) - center_part_mm, 1);
}

void GatheredBeams::add(const Clump& clump, size_t beam, const BeamValues& values) {
    beams.push_back(clump.beams[beam]);
    if (int32_t& body = beams.back().body; body >= 0) {
        bodies.push_back(clump.bodies[static_cast<size_t>(body)]);
        body = static_cast<int32_t>(bodies.size()) - 1;
    }
    const auto take = [&](auto& to, const auto& from, int32_t count) {
        const auto n = static_cast<size_t>(count);
        to.insert(to.end(), from.begin() + static_cast<ptrdiff_t>(beam * n),
                  from.begin() + static_cast<ptrdiff_t>((beam + 1) * n));
    };
    take(floats, clump.floats, 2 * values.floats);
    take(ints, clump.ints, values.ints);
}

Grown::Grown(std::unique_ptr<const ClumpSource> source, const Vec3d& center_part_mm, size_t bytes)
    : source_(std::move(source)),
      center_(center_part_mm),
      root_(source_->root(&root_state_)),
      kept_([&] {
          const size_t budget = source_->share_bytes(bytes);
          return LruCache<uint64_t, Clump>(budget, std::max<size_t>(budget / kShards, 1),
                                           LargeValues::kAreKeptAlone);
      }()) {}

Box3f Grown::bounds() const {
    Box3f out;
    for (int a = 0; a < 3; ++a) {
        out.lo[a] = std::nextafter(
            static_cast<float>(static_cast<double>(root_.bound.lo[a]) - center_[a]), -kInfinity);
        out.hi[a] = std::nextafter(
            static_cast<float>(static_cast<double>(root_.bound.hi[a]) - center_[a]), kInfinity);
    }
    return out;
}

const Clump* Grown::root() const {
    std::call_once(begun_, [&] { first_ = get(root_, root_state_); });
    return failed() ? nullptr : first_.get();
}

Grown::ClumpPtr Grown::find(const Bud& bud, std::span<const uint32_t> state) const {
    ClumpPtr kept = kept_.find(bud.id);
    return kept != nullptr && kept->grew_of(bud, state) ? kept : nullptr;
}

Grown::ClumpPtr Grown::get(const Bud& bud, std::span<const uint32_t> state) const {
    const std::atomic<bool>* stop = stop_;
    if (failed() || (stop != nullptr && stop->load(std::memory_order_relaxed))) return nullptr;
    if (ClumpPtr kept = find(bud, state); kept != nullptr) return kept;
    Result<ClumpPtr> made = source_->grow(bud, state);
    if (!made) {
        if (made.error().code != ErrorCode::kInterrupted) note(made.error());
        return nullptr;
    }
    ++made_;
    // Of another thread that was quicker, or of another bud with the same id, what is kept stays.
    kept_.insert(bud.id, *made);
    return *made;
}

/// Calls `take` for the beams whose boxes are reached. Returns whether `open_bud` had the clumps of all buds.
template <typename Reaches, typename Open, typename Take>
bool Grown::visit(const Clump& clump, const Reaches& reaches, const Open& open_bud,
                  const Take& take) const {
    if (clump.nodes().empty()) return true;
    std::array<int32_t, 64> stack;
    size_t open = 0;
    stack[open++] = 0;
    while (open > 0) {
        const int32_t at = stack[--open];
        const Clump::Node& node = clump.nodes()[static_cast<size_t>(at)];
        if (!reaches(node.box)) continue;
        if (node.count == 0) {
            stack[open++] = node.first;
            stack[open++] = at + 1;
            continue;
        }
        for (int32_t i = node.first; i < node.first + node.count; ++i) {
            const size_t item = clump.item(i);
            if (item < clump.beams.size()) {
                take(clump, item);
                continue;
            }
            const Bud& bud = clump.buds[item - clump.beams.size()];
            if (!reaches(bud.bound)) continue;
            const ClumpPtr more = open_bud(bud, clump.state(bud));
            if (more == nullptr || !visit(*more, reaches, open_bud, take)) return false;
        }
    }
    return true;
}

void Grown::note_crowd(const Bud& last) const {
    const Vec3f at = last.bound.center();
    note(source_->complaint(
        fmt::format(messages::kTooManyNodesAtOnce, kMostOpened, at.x, at.y, at.z, last.level + 1),
        messages::kTooManyNodesAtOnceHelp));
}

/// Returns whether these are too many for one place, after an error.
bool Grown::full(size_t beams, const GrownBeam& last) const {
    if (beams < kMostGathered) return false;
    note(source_->complaint(fmt::format(messages::kTooManyBeamsAtOnce, kMostGathered, last.end[0].x,
                                        last.end[0].y, last.end[0].z, last.level),
                            messages::kTooManyBeamsAtOnceHelp));
    return true;
}

namespace {

/// A harvest that gives each beam away.
template <typename Reaches, typename Take, typename More>
class Reaped final : public Harvest {
  public:
    Reaped(const Reaches& reaches, const Take& take, const More& more)
        : reaches_(reaches), take_(take), more_(more) {}
    bool reaches(const Box3f& box) const override { return reaches_(box); }
    bool take(const Clump& there, size_t nodes, const Bud& of) override {
        for (size_t beam = 0; beam < there.beams.size(); ++beam)
            take_(there, beam);
        all_ = more_(nodes, of);
        return all_;
    }
    /// Returns whether all was taken.
    bool all() const { return all_; }

  private:
    const Reaches& reaches_;
    const Take& take_;
    const More& more_;
    bool all_ = true;
};

}  // namespace

bool Grown::collect(const Box3f& box, bool make, size_t most, GatheredBeams* out,
                    Sieve* sieve) const {
    Box3f asked;
    for (int a = 0; a < 3; ++a) {
        asked.lo[a] = std::nextafter(
            static_cast<float>(static_cast<double>(box.lo[a]) + center_[a]), -kInfinity);
        asked.hi[a] = std::nextafter(
            static_cast<float>(static_cast<double>(box.hi[a]) + center_[a]), kInfinity);
    }
    const Clump* root = this->root();
    if (root == nullptr) return false;
    const BeamValues values = source_->values();
    size_t opened = 0, taken = 0;
    const auto count = [&] { return out->beams.size() + taken; };
    // What is taken needs neither memory nor a tree.
    constexpr size_t kMoreTaken = 16;
    const size_t most_taken = most == kNoLimit ? kNoLimit : kMoreTaken * most;
    const auto few = [&] { return out->beams.size() < most && taken < most_taken; };
    const auto reaches = [&](const Box3f& b) {
        return b.overlaps(asked) && (sieve == nullptr || sieve->reaches(b)) && few() && !failed();
    };
    const auto take = [&](const Clump& clump, size_t beam) {
        if (!few()) return;
        const GrownBeam& of = clump.beams[beam];
        const Box3f around = box_of(of);
        if (!around.overlaps(asked) || full(count(), of)) return;
        if (sieve != nullptr && of.body < 0 && sieve->take(of, around))
            ++taken;
        else
            out->add(clump, beam, values);
    };
    // What is no larger than the box is seldom asked for again.
    const bool harvests = !keeps_ && make && sieve != nullptr && source_->can_harvest();
    const float small = box.longest_side();
    static const auto kNothing = std::make_shared<const Clump>();
    Buds small_buds;
    const bool all = visit(
        *root, reaches,
        [&](const Bud& bud, std::span<const uint32_t> state) {
            if (harvests && bud.bound.longest_side() <= small) {
                small_buds.add(bud, state);
                return kNothing;
            }
            ClumpPtr clump = make ? get(bud, state) : find(bud, state);
            if (clump != nullptr) opened += clump->nodes_made();
            if (opened > kMostOpened) note_crowd(bud);
            return clump;
        },
        take);
    if (!all || !few() || small_buds.buds.empty()) return all && few();
    const auto more = [&](size_t nodes, const Bud& of) {
        opened += nodes;
        if (opened > kMostOpened) note_crowd(of);
        const std::atomic<bool>* stop = stop_;
        return few() && !failed() && (stop == nullptr || !stop->load(std::memory_order_relaxed));
    };
    Reaped reaped(reaches, take, more);
    if (const Result<void> done = source_->harvest(small_buds, &reaped); !done) {
        if (done.error().code != ErrorCode::kInterrupted) note(done.error());
        return false;
    }
    return reaped.all() && few();
}

float Grown::slack(const Vec3f& p, float d) const {
    const Box3f box = bounds();
    float largest = 0;
    for (int a = 0; a < 3; ++a)
        largest = std::max({largest, std::fabs(p[a]), std::fabs(box.lo[a]), std::fabs(box.hi[a]),
                            std::fabs(static_cast<float>(center_[a]))});
    const float of_bodies = source_->has_bodies() && d < kInfinity ? body_slack(d, 0) : 0;
    return largest * 0x1p-18f + of_bodies;
}

namespace {

/// Returns the signed distance of a point, part-local, to a beam or body.
float distance_to(const Clump& clump, size_t item, const Vec3d& center, const Vec3f& p) {
    const GrownBeam& beam = clump.beams[item];
    if (beam.body >= 0)
        return clump.bodies[static_cast<size_t>(beam.body)].distance(vec_cast<double>(p) + center);
    return beam_distance(record_of(beam, center), p);
}

}  // namespace

void Grown::collect(const Vec3f& p, float limit, GatheredBeams* out) const {
    const Vec3f asked = vec_cast<float>(vec_cast<double>(p) + center_);
    const float most = limit + slack(p, std::fabs(limit));
    const Clump* root = this->root();
    if (root == nullptr) return;
    const BeamValues values = source_->values();
    size_t opened = 0;
    visit(
        *root, [&](const Box3f& b) { return box_distance(b, asked) <= most && !failed(); },
        [&](const Bud& bud, std::span<const uint32_t> state) {
            ClumpPtr clump = get(bud, state);
            if (clump != nullptr) opened += clump->nodes_made();
            if (opened > kMostOpened) note_crowd(bud);
            return clump;
        },
        [&](const Clump& clump, size_t beam) {
            const GrownBeam& of = clump.beams[beam];
            if (box_distance(box_of(of), asked) > most) return;
            if (distance_to(clump, beam, center_, p) <= most &&
                !full(out->beams.size(), clump.beams[beam]))
                out->add(clump, beam, values);
        });
}

struct Grown::Search {
    Vec3f local, part;
    float slack = 0;      ///< of coordinates
    float of_bodies = 0;  ///< of distances to bodies, as a share
    /// Returns how far boxes may be to hold what is nearer.
    float reach() const {
        return distance < kInfinity ? distance + slack + of_bodies * std::fabs(distance) : distance;
    }
    size_t compared = 0;  ///< beams
    size_t opened = 0;    ///< nodes
    float distance = kInfinity;
    ClumpPtr clump;  ///< of the nearest so far; null: none
    size_t beam = 0;
    ClumpPtr current;
};

/// Looks into a clump, its nearer half first.
void Grown::search(const Clump& clump, Search* best) const {
    if (clump.nodes().empty()) return;
    const ClumpPtr mine = best->current;
    struct Open {
        int32_t node;
        float bound;
    };
    std::array<Open, 64> stack;
    size_t open = 0;
    const auto bound = [&](const Box3f& box) { return box_distance(box, best->part); };
    stack[open++] = {0, bound(clump.nodes()[0].box)};
    while (open > 0) {
        const Open at = stack[--open];
        if (at.bound > best->reach() || failed()) continue;
        const Clump::Node& node = clump.nodes()[static_cast<size_t>(at.node)];
        if (node.count == 0) {
            Open halves[2] = {{at.node + 1, 0}, {node.first, 0}};
            for (Open& half : halves)
                half.bound = bound(clump.nodes()[static_cast<size_t>(half.node)].box);
            if (halves[0].bound < halves[1].bound) std::swap(halves[0], halves[1]);
            for (const Open& half : halves) {
                if (half.bound <= best->reach()) stack[open++] = half;
            }
            continue;
        }
        for (int32_t i = node.first; i < node.first + node.count; ++i) {
            const size_t item = clump.item(i);
            if (item < clump.beams.size()) {
                const GrownBeam& beam = clump.beams[item];
                if (full(best->compared++, beam)) return;
                if (beam.body >= 0 && bound(box_of(beam)) > best->reach()) continue;
                const float d = distance_to(clump, item, center_, best->local);
                const bool nearer =
                    d < best->distance || (d == best->distance && best->clump != nullptr &&
                                           grows_before(beam, best->clump->beams[best->beam]));
                if (!nearer) continue;
                best->distance = d;
                best->clump = mine;
                best->beam = item;
                continue;
            }
            const Bud& bud = clump.buds[item - clump.beams.size()];
            if (bound(bud.bound) > best->reach()) continue;
            const ClumpPtr more = get(bud, clump.state(bud));
            if (more == nullptr) continue;
            best->opened += more->nodes_made();
            if (best->opened > kMostOpened) return note_crowd(bud);
            best->current = more;
            search(*more, best);
            best->current = mine;
        }
    }
}

float Grown::nearest(const Vec3f& p, GatheredBeams* out) const {
    Search best;
    best.local = p;
    best.part = vec_cast<float>(vec_cast<double>(p) + center_);
    best.slack = slack(p, kInfinity);
    best.of_bodies = source_->has_bodies() ? body_slack(1, 0) : 0;
    if (root() == nullptr) return kInfinity;
    best.current = first_;
    search(*first_, &best);
    if (best.clump != nullptr && out != nullptr)
        out->add(*best.clump, best.beam, source_->values());
    return best.distance;
}

void Grown::note(Error error) const {
    const std::lock_guard lock(mutex_);
    if (!error_) error_ = std::move(error);
    failed_ = true;
}

Result<void> Grown::status() const {
    const std::lock_guard lock(mutex_);
    if (error_) return *error_;
    return source_->status();
}

}  // namespace openfab::solid
