// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/element_writes.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "compiler/passes/element_pattern.h"

namespace openfab::passes {

namespace {

using ir::Instr;
using ir::kNoValue;
using ir::Op;
using ir::Type;
using ir::ValueId;
using Kind = ElementNode::Kind;

// Of an array of structs or vectors: the most components of an element.
constexpr int32_t kMostApart = 16;
constexpr size_t kMostSteps = 8;

/// Some states, evenly apart.
struct Range {
    int32_t first = 0, apart = 1, count = 0;

    int32_t last() const { return first + apart * (count - 1); }
    bool has(int32_t state) const {
        return state >= first && state <= last() && (state - first) % apart == 0;
    }
    bool meets(const Range& other) const {
        for (int32_t k = 0; k < count; ++k) {
            if (other.has(first + k * apart)) return true;
        }
        return false;
    }
    bool operator==(const Range&) const = default;
};

struct Guard {
    ValueId value = kNoValue;
    bool holds = true;
};

/// One step, of values of the kernel.
struct Write {
    openfab_elements_kind kind = OPENFAB_ELEMENTS_FILL;
    std::vector<Guard> guard;
    ValueId value = kNoValue;  ///< of a fill or a store
    int32_t from = 0;          ///< state, of a copy
    int32_t from_apart = 0;
    ValueId index = kNoValue;  ///< of a store: the element is its difference to `number`
    uint32_t number = 0;
    bool below = false, above = false;
};

/// Some outputs of the kernel, and what they come to.
struct Group {
    Range range;
    std::vector<size_t> outputs;
    std::vector<Write> writes;
    std::vector<Range> read;  ///< of copies
};

/// What the pattern of a group's values comes to, in order.
class Reader {
  public:
    Reader(const ElementPattern& pattern, const Range& own) : pattern_(pattern), own_(own) {}

    bool run() { return read(pattern_.root(), {}) && writes.size() <= kMostSteps; }

    std::vector<Write> writes;
    std::vector<Range> ranges;

  private:
    bool read(size_t k, const std::vector<Guard>& guard) {
        const ElementNode& node = pattern_.node(k);
        Write write;
        write.guard = guard;
        switch (node.kind) {
            case Kind::kCommon:
                write.value = node.id;
                writes.push_back(std::move(write));
                return true;
            case Kind::kState: {
                const Range from{static_cast<int32_t>(node.first), static_cast<int32_t>(node.step),
                                 own_.count};
                if (from == own_) return true;
                if (from.meets(own_)) return false;
                write.kind = OPENFAB_ELEMENTS_COPY;
                write.from = from.first;
                write.from_apart = from.apart;
                writes.push_back(std::move(write));
                ranges.push_back(from);
                return true;
            }
            case Kind::kOperation:
                if (pattern_.stage().instrs[node.id].op == Op::kSelect) return choice(node, guard);
                return false;
            case Kind::kNumber:
            case Kind::kIs:
                break;
        }
        return false;
    }

    bool choice(const ElementNode& node, std::vector<Guard> guard) {
        const ElementNode& test = pattern_.node(node.args[0]);
        if (test.kind == Kind::kCommon) {
            guard.push_back({test.id, true});
            if (!read(node.args[1], guard)) return false;
            guard.back().holds = false;
            return read(node.args[2], guard);
        }
        const ElementNode& value = pattern_.node(node.args[1]);
        if (value.kind != Kind::kCommon || !read(node.args[2], guard)) return false;
        const ElementNode* is = nullptr;
        if (!add_factors(test, &guard, &is) || is == nullptr) return false;
        Write write;
        write.kind = OPENFAB_ELEMENTS_STORE;
        write.guard = std::move(guard);
        write.value = value.id;
        write.index = pattern_.node(is->args[0]).id;
        write.number = is->first;
        write.below = is->below;
        write.above = is->above;
        writes.push_back(std::move(write));
        return true;
    }

    /// Takes a test apart: one part says which element, the others hold for all or none.
    bool add_factors(const ElementNode& test, std::vector<Guard>* guard,
                     const ElementNode** is) const {
        if (test.kind == Kind::kCommon) {
            guard->push_back({test.id, true});
            return true;
        }
        if (test.kind == Kind::kIs) return std::exchange(*is, &test) == nullptr;
        return test.kind == Kind::kOperation && pattern_.stage().instrs[test.id].op == Op::kAnd &&
               add_factors(pattern_.node(test.args[0]), guard, is) &&
               add_factors(pattern_.node(test.args[1]), guard, is);
    }

    const ElementPattern& pattern_;
    const Range own_;
};

class WriteTaker {
  public:
    WriteTaker(ir::Stage* kernel, std::vector<Type>* states)
        : stage_(*kernel), states_(*states), builder_(kernel) {}

    std::vector<openfab_elements> run() {
        for (size_t k = 0; k < stage_.outputs.size(); ++k) {
            if (stage_.outputs[k].kind == OPENFAB_ARG_STATE_OUT) writer_[stage_.outputs[k].a] = k;
        }
        find_groups();
        order_groups();
        std::vector<openfab_elements> out;
        for (const Group& group : groups_) {
            for (const Write& write : group.writes)
                out.push_back(step(group.range, write));
        }
        std::vector<bool> taken(stage_.outputs.size(), false);
        for (const Group& group : groups_) {
            for (const size_t k : group.outputs)
                taken[k] = true;
        }
        std::vector<ir::Output> rest;
        for (size_t k = 0; k < stage_.outputs.size(); ++k) {
            if (!taken[k]) rest.push_back(std::move(stage_.outputs[k]));
        }
        rest.insert(rest.end(), passed_on_.begin(), passed_on_.end());
        stage_.outputs = std::move(rest);
        ir::drop_dead_values(&stage_);
        return out;
    }

  private:
    const Instr& at(ValueId id) const { return stage_.instrs[id]; }

    void find_groups() {
        std::map<int32_t, size_t> open = writer_;
        while (!open.empty()) {
            const int32_t first = open.begin()->first;
            std::optional<Group> group;
            for (int32_t apart = 1; apart <= kMostApart && !group; ++apart)
                group = find_group(open, first, apart);
            if (!group) {
                open.erase(first);
                continue;
            }
            for (int32_t k = 0; k < group->range.count; ++k)
                open.erase(first + k * group->range.apart);
            groups_.push_back(std::move(*group));
        }
    }

    std::optional<Group> find_group(const std::map<int32_t, size_t>& open, int32_t first,
                                    int32_t apart) const {
        Group out;
        std::vector<ValueId> values;
        ElementPattern pattern(stage_);
        for (int32_t state = first;; state += apart) {
            const auto here = open.find(state);
            if (here == open.end()) break;
            out.outputs.push_back(here->second);
            values.push_back(stage_.outputs[here->second].value);
            if (values.size() == kFewestElements && !pattern.find(values)) return std::nullopt;
        }
        const auto fits = [&](const ElementPattern& found) {
            out.range = {first, apart, static_cast<int32_t>(found.count())};
            Reader reader(found, out.range);
            if (!reader.run()) return false;
            out.writes = std::move(reader.writes);
            out.read = std::move(reader.ranges);
            return true;
        };
        const size_t count = longest_run(&pattern, values, kFewestElements, fits);
        if (count == 0) return std::nullopt;
        out.outputs.resize(count);
        return out;
    }

    /// Puts groups that copy an array before those that write it. The kernel comes before all of them:
    /// who copies what that writes, or what others copy in a circle, stays in it.
    void order_groups() {
        std::vector<Group> ordered, open = std::move(groups_);
        while (!open.empty()) {
            const auto comes_first = [&](const Group& group) {
                return std::ranges::none_of(open, [&](const Group& other) {
                    return &other != &group && std::ranges::any_of(other.read, [&](const Range& r) {
                        return r.meets(group.range);
                    });
                });
            };
            const auto next = std::ranges::find_if(open, comes_first);
            if (next == open.end()) {
                const auto copies =
                    std::ranges::find_if(open, [](const Group& g) { return !g.read.empty(); });
                open.erase(copies);
                continue;
            }
            ordered.push_back(std::move(*next));
            open.erase(next);
        }
        groups_ = std::move(ordered);
        // What stays in the kernel is written before any group copies it.
        for (bool changed = true; changed;) {
            const auto copies_rest = [&](const Group& group) {
                return std::ranges::any_of(group.read, [&](const Range& r) {
                    return std::ranges::any_of(writer_, [&](const auto& item) {
                        return r.has(item.first) && !is_of_group(item.first);
                    });
                });
            };
            const auto found = std::ranges::find_if(groups_, copies_rest);
            changed = found != groups_.end();
            if (changed) groups_.erase(found);
        }
    }

    bool is_of_group(int32_t state) const {
        return std::ranges::any_of(groups_, [&](const Group& g) { return g.range.has(state); });
    }

    openfab_elements step(const Range& range, const Write& write) {
        openfab_elements out{write.kind, range.first, range.apart, range.count, -1, -1, 0, -1};
        std::vector<Guard> guard = write.guard;
        if (write.kind == OPENFAB_ELEMENTS_COPY) {
            out.value = write.from;
            out.value_apart = write.from_apart;
        } else {
            out.value = pass_on(write.value);
        }
        if (write.kind == OPENFAB_ELEMENTS_STORE) {
            const Type type = at(write.index).type;
            const uint32_t last = write.number + static_cast<uint32_t>(range.count - 1);
            const auto limit = [&](Op op, uint32_t number) {
                guard.push_back(
                    {builder_.binary(op, write.index, builder_.constant(type, number)), true});
            };
            if (!write.below) limit(Op::kGe, write.number);
            if (!write.above) limit(Op::kLe, last);
            ValueId number = emit_clamped(write.index, write.number, last, true, true, &builder_);
            number = builder_.binary(Op::kSub, number, builder_.constant(type, write.number));
            out.index = pass_on(builder_.convert(number, Type::kInt));
        }
        ValueId all = kNoValue;
        for (const Guard& one : guard) {
            const ValueId holds = one.holds ? one.value : builder_.emit(Op::kNot, {one.value});
            all = all == kNoValue ? holds : builder_.emit(Op::kAnd, {all, holds});
        }
        if (all != kNoValue) out.guard = pass_on(all);
        return out;
    }

    /// Returns a state that the kernel writes a value to.
    int32_t pass_on(ValueId value) {
        const auto [place, is_new] = passed_.emplace(value, static_cast<int32_t>(states_.size()));
        if (is_new) {
            states_.push_back(at(value).type);
            passed_on_.push_back({fmt::format("state_{}", place->second), OPENFAB_ARG_STATE_OUT,
                                  place->second, 0, value});
        }
        return place->second;
    }

    ir::Stage& stage_;
    std::vector<Type>& states_;
    ir::Builder builder_;
    std::map<int32_t, size_t> writer_;  ///< the output of each state
    std::vector<Group> groups_;
    std::map<ValueId, int32_t> passed_;
    std::vector<ir::Output> passed_on_;
};

}  // namespace

std::vector<openfab_elements> take_writes(ir::Stage* kernel, std::vector<Type>* states) {
    return WriteTaker(kernel, states).run();
}

}  // namespace openfab::passes
