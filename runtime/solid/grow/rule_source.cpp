// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/grow/rule_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <deque>
#include <optional>
#include <string_view>

#include "base/messages.h"
#include "base/pool.h"
#include "runtime/part/node_member.h"
#include "runtime/solid/grow/body_source.h"
#include "runtime/solid/grow/rule_calls.h"
#include "runtime/solid/grow/rule_roles.h"
#include "runtime/solid/messages.h"

namespace openfab::solid {

namespace {

/// Nodes of a clump from which on whole levels become buds: with fewer, calls and bookkeeping cost more than what is
/// not grown saves; with more, most of a clump is far from where it is asked for.
constexpr size_t kClumpNodes = 20;
/// Nodes that grow at once where they are harvested: their columns stay in the second-level cache.
constexpr size_t kHarvested = 512;
constexpr int32_t kMostChildren = 1 << 16;
/// Levels of a rule without a depth; deeper ones are taken for rules that never end.
constexpr int32_t kMostLevels = 1000;

/// A component of a @nearest input: of the node at the first end, and at the second; or a default.
struct Reading {
    size_t first = 0, second = 0;
    std::optional<uint32_t> otherwise;
};

/// A level of nodes while a clump grows.
struct Level {
    NodeColumns columns;
    std::vector<size_t> nodes;  ///< that have children: their places in the columns
    std::vector<uint64_t> ids;  ///< by place
    std::vector<Box3f> bounds;  ///< likewise: what holds the children
    std::vector<int32_t> children;
    int32_t level = 0;

    void clear() {
        nodes.clear();
        ids.clear();
        bounds.clear();
        children.clear();
    }
};

/// What a thread grows clumps with; its memory is used again.
struct Bench {
    Bench(const part::ShapeStage& stage, const surface::StaticArgs& fixed, openfab_isa isa)
        : calls(stage, fixed, isa) {}

    RuleCalls calls;
    Level now, next;
    std::deque<Level> levels;  ///< of a harvest
    NodeColumns parents;
    NodePlaces places;
    std::vector<size_t> parent_of;
    Clump clump;
};

class RuleSource final : public BodySource {
  public:
    RuleSource(const part::ShapeStage& stage, const openfab_fablet& fablet, const Bodies& bodies,
               openfab_isa isa)
        : BodySource(stage, bodies, isa), stage_(stage), fixed_(stage), isa_(isa) {
        const openfab_shape& shape = *stage.fablet->shape;
        std::vector<int32_t> first;
        int32_t at = 0;
        for (int32_t i = 0; i < shape.output_count; ++i) {
            first.push_back(at);
            at += shape.outputs[i].components;
            roles_.take(shape.outputs[i], first.back());
        }
        components_ = static_cast<size_t>(at);
        for (int32_t i = 0; i < fablet.nearest_count; ++i) {
            const openfab_varying& input = fablet.nearest[i];
            const auto is_it = [&](const openfab_varying& member) {
                return std::string_view(member.name) == input.name;
            };
            const bool known =
                std::any_of(shape.outputs, shape.outputs + shape.output_count, is_it);
            for (int32_t k = 0; !known && k < input.components; ++k)
                (input.scalar == OPENFAB_FLOAT ? floats_ : ints_)
                    .push_back({0, 0, input.default_bits[k]});
            for (int32_t m = 0; m < shape.output_count; ++m) {
                const openfab_varying& member = shape.outputs[m];
                if (!is_it(member)) continue;
                for (int32_t k = 0; k < input.components; ++k) {
                    const auto one = static_cast<size_t>(first[static_cast<size_t>(m)] + k);
                    const size_t other = part::has_two_ends(member)
                                             ? one + static_cast<size_t>(input.components)
                                             : one;
                    (input.scalar == OPENFAB_FLOAT ? floats_ : ints_).push_back({one, other, {}});
                }
            }
        }
        for (const Vec3d& p : stage.mesh->positions) {
            const Vec3d at_part = p + stage.mesh->center_part_mm;
            box_.add(vec_cast<float>(at_part));
        }
    }

    void set_stop(const std::atomic<bool>* stop) const override {
        BodySource::set_stop(stop);
        fixed_.set_stop(stop);
    }
    Error complaint(const std::string& what, const std::string& help) const override {
        return error_at(stage_.location,
                        fmt::format(messages::kRuleBefore, stage_.fablet->name, stage_.name, what),
                        help);
    }

    BeamValues values() const override {
        return {static_cast<int32_t>(floats_.size()), static_cast<int32_t>(ints_.size())};
    }

    Bud root(std::vector<uint32_t>* state) const override {
        state->assign(components_, 0);
        Bud bud;
        bud.bound = box_;
        bud.id = 0;
        bud.level = -1;
        bud.children = 1;
        return bud;
    }

    Result<std::shared_ptr<const Clump>> grow(const Bud& bud,
                                              std::span<const uint32_t> state) const override {
        Bench* bench = benches_.take([&] { return std::make_unique<Bench>(stage_, fixed_, isa_); });
        Result<void> done = grow(bud, state, bench);
        std::shared_ptr<const Clump> out;
        if (done) {
            bench->clump.set_seed(bud, state);
            bench->clump.finish();
            // A copy takes no more memory than it needs.
            out = std::make_shared<const Clump>(bench->clump);
        }
        benches_.give(bench);
        if (!done) return done.error();
        return out;
    }

    bool can_harvest() const override { return true; }
    Result<void> harvest(const Buds& from, Harvest* to) const override {
        Bench* bench = benches_.take([&] { return std::make_unique<Bench>(stage_, fixed_, isa_); });
        Result<bool> done = true;
        for (size_t first = 0, end = 0; first < from.buds.size() && done && *done; first = end) {
            const int32_t level = from.buds[first].level;
            while (end < from.buds.size() && from.buds[end].level == level)
                ++end;
            if (bench->levels.empty()) bench->levels.emplace_back();
            Level& now = bench->levels[0];
            now.clear();
            now.level = level;
            now.columns.assign(components_, end - first);
            for (size_t k = 0; k < end - first; ++k) {
                const Bud& bud = from.buds[first + k];
                now.nodes.push_back(k);
                now.ids.push_back(bud.id);
                now.bounds.push_back(bud.bound);
                now.children.push_back(bud.children);
                for (size_t c = 0; c < components_; ++c)
                    now.columns.column(c)[k] = from.states[bud.state + c];
            }
            done = harvest_level(0, bench, to);
        }
        benches_.give(bench);
        if (!done) return done.error();
        return {};
    }

  private:
    /// Grows what is reached below a level; returns whether more is wanted.
    Result<bool> harvest_level(size_t depth, Bench* bench, Harvest* to) const {
        if (bench->levels.size() == depth + 1) bench->levels.emplace_back();
        const Level& now = bench->levels[depth];
        Level* next = &bench->levels[depth + 1];
        for (size_t first = 0, end = 0; first < now.nodes.size(); first = end) {
            size_t more = 0;
            do {
                more += static_cast<size_t>(now.children[now.nodes[end++]]);
            } while (end < now.nodes.size() &&
                     more + static_cast<size_t>(now.children[now.nodes[end]]) <= kHarvested);
            bench->clump.clear();
            const std::span nodes = std::span(now.nodes).subspan(first, end - first);
            if (Result<void> fine = grow_level(now, nodes, more, next, bench); !fine)
                return fine.error();
            Bud of;
            of.bound = now.bounds[nodes[0]];
            of.level = now.level;
            if (!to->take(bench->clump, more, of)) return false;
            std::erase_if(next->nodes,
                          [&](size_t node) { return !to->reaches(next->bounds[node]); });
            if (next->nodes.empty()) continue;
            if (Result<bool> done = harvest_level(depth + 1, bench, to); !done || !*done)
                return done;
        }
        return true;
    }

    Result<void> grow(const Bud& bud, std::span<const uint32_t> state, Bench* bench) const {
        Clump* out = &bench->clump;
        out->clear();
        out->state_size = components_;
        Level& now = bench->now;
        now.columns.assign(components_, 1);
        for (size_t c = 0; c < components_; ++c)
            *now.columns.column(c) = state[c];
        now.nodes = {0};
        now.ids = {bud.id};
        now.bounds = {bud.bound};
        now.children = {bud.children};
        now.level = bud.level;
        size_t grown = 0;
        while (!now.nodes.empty()) {
            size_t more = 0;
            for (const size_t node : now.nodes)
                more += static_cast<size_t>(now.children[node]);
            // What the first node has is in the first clump, which is kept: of a forest all trees.
            const bool first = bud.level < 0 && grown == 1;
            if (grown > 0 && !first && grown + more > kClumpNodes) {
                keep_buds(now, out);
                return {};
            }
            grown += more;
            if (Result<void> fine = grow_level(now, now.nodes, more, &bench->next, bench); !fine)
                return fine;
            std::swap(now, bench->next);
        }
        return {};
    }

    void keep_buds(const Level& level, Clump* out) const {
        for (const size_t node : level.nodes) {
            Bud bud;
            bud.bound = level.bounds[node];
            bud.id = level.ids[node];
            bud.level = level.level;
            bud.children = level.children[node];
            bud.state = out->states.size();
            out->buds.push_back(bud);
            for (size_t c = 0; c < components_; ++c)
                out->states.push_back(level.columns.column(c)[node]);
        }
    }

    /// Makes all children, `more` of them, of some nodes of a level.
    Result<void> grow_level(const Level& now, std::span<const size_t> nodes, size_t more,
                            Level* next, Bench* bench) const {
        NodeColumns& parents = bench->parents;
        NodePlaces& places = bench->places;
        std::vector<size_t>& parent_of = bench->parent_of;
        next->clear();
        parents.assign(components_, more);
        places.child.clear();
        parent_of.clear();
        next->level = now.level + 1;
        for (const size_t node : nodes) {
            for (int32_t child = 0; child < now.children[node]; ++child) {
                parent_of.push_back(node);
                next->ids.push_back(child_id(now.ids[node], child));
                places.child.push_back(child);
            }
        }
        for (size_t c = 0; c < components_; ++c) {
            const uint32_t* const from = now.columns.column(c);
            uint32_t* const to = parents.column(c);
            for (size_t i = 0; i < more; ++i)
                to[i] = from[parent_of[i]];
        }
        places.path.assign(parents.lanes, 0);
        std::ranges::transform(next->ids, places.path.begin(),
                               [](uint64_t id) { return static_cast<uint32_t>(id); });
        places.child.resize(parents.lanes);
        places.level.assign(parents.lanes, next->level);
        if (const abi::KernelStatus status =
                bench->calls.grow(parents, places, more, &next->columns);
            !status.ok()) {
            if (status.is_stopped())
                return Error{ErrorCode::kInterrupted, openfab::messages::kInterrupted, "", {}};
            return internal_error(
                fmt::format(messages::kGrowKernelFailed, stage_.fablet->name, status.code()));
        }
        next->bounds.resize(more);
        next->children.assign(more, 0);
        for (size_t i = 0; i < more; ++i) {
            const Box3f& within = now.bounds[parent_of[i]];
            if (Result<void> fine = take_node(i, places.child[i], within, next, &bench->clump);
                !fine)
                return fine;
        }
        return {};
    }

    float number(const Level& level, int32_t component, size_t node) const {
        return std::bit_cast<float>(level.columns.column(static_cast<size_t>(component))[node]);
    }
    Vec3f point(const Level& level, int32_t component, size_t node) const {
        return {number(level, component, node), number(level, component + 1, node),
                number(level, component + 2, node)};
    }

    /// Takes a node of a new level: its beam, and what holds its children.
    Result<void> take_node(size_t node, int32_t child, const Box3f& within, Level* level,
                           Clump* out) const {
        const size_t beams_before = out->beams.size();
        GrownBeam beam;
        beam.id = level->ids[node];
        beam.level = level->level;
        for (int32_t e = 0; e < 2; ++e) {
            const auto to = static_cast<size_t>(e);
            beam.end[to] = point(*level, roles_.end + 3 * e, node);
            beam.radius[to] = number(*level, roles_.radius + (roles_.two_radii ? e : 0), node);
        }
        beam.flat =
            roles_.flat >= 0 && level->columns.column(static_cast<size_t>(roles_.flat))[node] != 0;
        const Where where{beam, child};
        for (size_t e = 0; e < 2; ++e) {
            bool finite = std::isfinite(beam.radius[e]);
            for (int a = 0; a < 3; ++a)
                finite = finite && std::isfinite(beam.end[e][a]);
            if (!finite) return error(where, messages::kNotFinite, messages::kNotFiniteHelp);
            if (beam.radius[e] < 0)
                return error(where, fmt::format(messages::kNodeRadius, beam.radius[e]),
                             messages::kNodeRadiusHelp);
        }
        if (is_visible(beam)) {
            if (const Box3f box = box_of(beam); !holds(within, box)) {
                if (is_lost(beam))
                    return error(
                        where,
                        fmt::format(messages::kLongAndOutside, box.longest_side(), beam.level),
                        messages::kLetChildrenEnd);
                return error(
                    where,
                    fmt::format(messages::kBeamOutside, text(beam.end[0]), text(beam.end[1]),
                                std::max(beam.radius[0], beam.radius[1]), text(within.lo),
                                text(within.hi)),
                    level->level == 0 ? messages::kEnlargeWorldBox : messages::kEnlargeNodeBox);
            }
            take_values(node, *level, out);
            out->beams.push_back(beam);
        }
        if (roles_.object >= 0) {
            if (Result<void> fine = take_object(node, where, within, *level, out); !fine)
                return fine;
        }
        const auto children =
            static_cast<int32_t>(level->columns.column(static_cast<size_t>(roles_.children))[node]);
        if (children <= 0) {
            out->empty += out->beams.size() == beams_before ? 1 : 0;
            return {};
        }
        if (children > kMostChildren)
            return error(where, fmt::format(messages::kTooManyChildren, children, kMostChildren),
                         messages::kTooManyChildrenHelp);
        if (level->level >= kMostLevels)
            return error(where, fmt::format(messages::kChildrenTooDeep, level->level),
                         messages::kLetChildrenEnd);
        if (Result<void> fine = bound_children(where, within, node, level); !fine) return fine;
        level->children[node] = children;
        level->nodes.push_back(node);
        return {};
    }

    struct Where {
        const GrownBeam& beam;
        int32_t child;
    };

    void take_values(size_t node, const Level& level, Clump* out) const {
        for (const Reading& r : floats_)
            out->floats.push_back(
                std::bit_cast<float>(r.otherwise.value_or(level.columns.column(r.first)[node])));
        for (const Reading& r : floats_)
            out->floats.push_back(
                std::bit_cast<float>(r.otherwise.value_or(level.columns.column(r.second)[node])));
        for (const Reading& r : ints_)
            out->ints.push_back(r.otherwise.value_or(level.columns.column(r.first)[node]));
    }

    /// Takes the object that stands at a node, if there is one.
    Result<void> take_object(size_t node, const Where& where, const Box3f& within,
                             const Level& level, Clump* out) const {
        const auto which =
            static_cast<int32_t>(level.columns.column(static_cast<size_t>(roles_.object))[node]);
        if (which == 0) return {};
        const auto count = static_cast<int32_t>(standing().size());
        if (which < 0 || which > count)
            return error(where, fmt::format(messages::kNoSuchObject, which),
                         fmt::format(messages::kNoSuchObjectHelp, count));
        GrownBody body;
        body.solid = standing()[static_cast<size_t>(which - 1)];
        body.at = vec_cast<double>(where.beam.end[0]);
        std::array<Vec3f, 3> axes{Vec3f{1, 0, 0}, Vec3f{0, 1, 0}, Vec3f{0, 0, 1}};
        for (int32_t a = 0; roles_.axes >= 0 && a < 3; ++a)
            axes[static_cast<size_t>(a)] = point(level, roles_.axes + 3 * a, node);
        if (const Complaint bad = body.set_axes(axes); !bad.empty())
            return error(where, messages::kObjectWith + bad.what, bad.help);
        if (const Box3f reached = body.reached(); !holds(within, reached))
            return error(where,
                         fmt::format(messages::kObjectOutside, text(reached.lo), text(reached.hi),
                                     text(within.lo), text(within.hi)),
                         level.level == 0 ? messages::kEnlargeWorldBox : messages::kEnlargeNodeBox);
        take_values(node, level, out);
        out->add_body(std::move(body), where.beam.id, level.level, within);
        return {};
    }

    Result<void> bound_children(const Where& where, const Box3f& within, size_t node,
                                Level* level) const {
        Box3f box;
        if (roles_.box >= 0) {
            box = {point(*level, roles_.box, node), point(*level, roles_.box + 3, node)};
        } else {
            GrownBeam reached = where.beam;
            const float reach = number(*level, roles_.reach, node);
            if (!(reach >= 0) || !std::isfinite(reach))
                return error(where, fmt::format(messages::kNodeReach, reach),
                             messages::kNodeReachHelp);
            for (float& r : reached.radius)
                r = r + reach;
            box = box_of(reached);
        }
        for (int a = 0; a < 3; ++a) {
            if (!(box.lo[a] <= box.hi[a]))
                return error(where, fmt::format(messages::kNodeBox, text(box.lo), text(box.hi)),
                             messages::kLowerCornerFirst);
            box.lo[a] = std::max(box.lo[a], within.lo[a]);
            box.hi[a] = std::min(box.hi[a], within.hi[a]);
        }
        if (box.empty() && is_lost(where.beam))
            return error(where, fmt::format(messages::kChildrenOutside, where.beam.level),
                         messages::kLetChildrenEnd);
        if (box.empty())
            return error(
                where, fmt::format(messages::kGrowsOutside, text(within.lo), text(within.hi)),
                is_visible(where.beam) ? messages::kEnlargeNodeBox : messages::kEndOrEnlarge);
        level->bounds[node] = box;
        return {};
    }

    /// Returns whether there is anything of a node itself.
    static bool is_visible(const GrownBeam& beam) {
        return beam.radius[0] > 0 || beam.radius[1] > 0;
    }

    /// Returns whether a node is so small, many levels deep, that its rule rather never ends than lies about its
    /// bounds, which turns that are rounded leave at last. Of one without a beam the depth alone tells.
    static bool is_lost(const GrownBeam& beam) {
        constexpr int32_t kDeep = 20;
        if (beam.level < kDeep || !is_visible(beam)) return beam.level >= kDeep;
        const Box3f box = box_of(beam);
        float largest = 0;
        for (int a = 0; a < 3; ++a)
            largest = std::max({largest, std::fabs(box.lo[a]), std::fabs(box.hi[a])});
        return box.longest_side() <= largest * 0x1p-10f;
    }

    Error error(const Where& where, const std::string& what, const std::string& help) const {
        const std::string who = where.beam.level == 0
                                    ? std::string(messages::kFirstNode)
                                    : fmt::format(messages::kChildOnLevel, where.child,
                                                  where.beam.level, text(where.beam.end[0]));
        return complaint(fmt::format("{} {}", who, what), help);
    }

    const part::ShapeStage& stage_;
    const surface::StaticArgs fixed_;
    const openfab_isa isa_;
    RuleRoles roles_;
    std::vector<Reading> floats_, ints_;
    size_t components_ = 0;
    Box3f box_;
    mutable Pool<Bench> benches_;
};

}  // namespace

std::unique_ptr<const ClumpSource> make_rule_source(const part::ShapeStage& stage,
                                                    const openfab_fablet& fablet,
                                                    const Bodies& bodies, openfab_isa isa) {
    return std::make_unique<RuleSource>(stage, fablet, bodies, isa);
}

}  // namespace openfab::solid
