// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/cut_elements.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "compiler/passes/element_pattern.h"
#include "compiler/passes/element_writes.h"
#include "compiler/passes/eliminate_common_values.h"
#include "compiler/passes/simplify.h"

namespace openfab::passes {

namespace {

using ir::Instr;
using ir::kNoValue;
using ir::Op;
using ir::Type;
using ir::ValueId;

constexpr size_t kFewestOfRun = 8;

/// A value that is chosen among many by an index: element k where the index is first + k, the first
/// one below, the last one above.
struct Choice {
    ValueId index = kNoValue;
    uint32_t first = 0;
    std::vector<ValueId> elements;
};

/// Turns choices among many elements into loads of states by number: see is_element_load.
class LoadMaker {
  public:
    explicit LoadMaker(const ir::Stage& stage) : old_(stage) {}

    ir::Stage run() {
        find_choices();
        if (choices_.empty()) return old_;
        ir::Stage out;
        out.kind = old_.kind;
        ir::Builder builder(&out);
        for (ValueId id = 0; id < old_.instrs.size(); ++id) {
            const auto choice = choices_.find(id);
            const std::optional<ValueId> loaded =
                choice == choices_.end() ? std::nullopt : emit(choice->second, &builder);
            if (loaded) {
                renamed_.push_back(*loaded);
                continue;
            }
            Instr copy = old_.instrs[id];
            for (ValueId& arg : copy.args)
                arg = renamed_[arg];
            renamed_.push_back(builder.append(std::move(copy)));
        }
        for (ir::Output output : old_.outputs) {
            output.value = renamed_[output.value];
            out.outputs.push_back(std::move(output));
        }
        simplify(&out);
        eliminate_common_values(&out);
        ir::drop_dead_values(&out);
        return out;
    }

  private:
    const Instr& at(ValueId id) const { return old_.instrs[id]; }

    /// Returns the number that a choice tests its index for.
    std::optional<uint32_t> number_of(ValueId id) const {
        const Instr& choice = at(id);
        if (choice.op != Op::kSelect) return std::nullopt;
        const Instr& test = at(choice.args[0]);
        if (test.op != Op::kEq && test.op != Op::kLe) return std::nullopt;
        const Instr& number = at(test.args[1]);
        const bool counts = number.type == Type::kInt || number.type == Type::kUint;
        return number.op == Op::kConst && counts ? std::optional(number.bits) : std::nullopt;
    }

    void find_choices() {
        std::set<ValueId> inside;
        for (auto id = static_cast<ValueId>(old_.instrs.size()); id-- > 0;) {
            const std::optional<uint32_t> first = number_of(id);
            if (!first || inside.contains(id) || at(at(id).args[0]).op != Op::kLe) continue;
            Choice choice{at(at(id).args[0]).args[0], *first, {at(id).args[1]}};
            ValueId rest = at(id).args[2];
            while (number_of(rest) == *first + static_cast<uint32_t>(choice.elements.size()) &&
                   at(at(rest).args[0]).op == Op::kEq &&
                   at(at(rest).args[0]).args[0] == choice.index) {
                inside.insert(rest);
                choice.elements.push_back(at(rest).args[1]);
                rest = at(rest).args[2];
            }
            choice.elements.push_back(rest);
            if (choice.elements.size() >= kFewestElements) choices_.emplace(id, std::move(choice));
        }
    }

    /// Emits a choice by runs of elements that have a pattern, unless most have none.
    std::optional<ValueId> emit(const Choice& choice, ir::Builder* builder) {
        const std::span<const ValueId> elements = choice.elements;
        struct Run {
            size_t begin;
            std::optional<ElementPattern> pattern;
        };
        std::vector<Run> runs;
        for (size_t begin = 0; begin < elements.size();) {
            ElementPattern pattern(old_);
            const size_t found = longest_run(&pattern, elements.subspan(begin), kFewestOfRun,
                                             [](const ElementPattern&) { return true; });
            if (found > 0) {
                runs.push_back({begin, std::move(pattern)});
            } else {
                runs.push_back({begin, std::nullopt});
            }
            begin += std::max<size_t>(found, 1);
            if (runs.size() > elements.size() / 4) return std::nullopt;
        }
        const ValueId index = renamed_[choice.index];
        const Type type = builder->type(index);
        const auto numbered = [&](size_t k) { return choice.first + static_cast<uint32_t>(k); };
        ValueId out = kNoValue;
        size_t end = elements.size();
        for (auto run = runs.rbegin(); run != runs.rend(); end = run->begin, ++run) {
            const uint32_t first = numbered(run->begin), last = numbered(end - 1);
            ValueId value = renamed_[elements[run->begin]];
            if (run->pattern) {
                ValueId number = emit_clamped(index, first, last, true, true, builder);
                number = builder->binary(Op::kSub, number, builder->constant(type, first));
                value = run->pattern->emit(builder->convert(number, Type::kInt), renamed_, builder);
            }
            if (out == kNoValue) {
                out = value;
            } else {
                const ValueId here = builder->binary(Op::kLe, index, builder->constant(type, last));
                out = builder->select(here, value, out);
            }
        }
        return out;
    }

    const ir::Stage& old_;
    std::map<ValueId, Choice> choices_;  ///< by the choice of element 0
    std::vector<ValueId> renamed_;
};

/// Cuts a kernel before each load that it has: indices come first, then the loads, then what is made
/// of them, which may be indices again.
class LoadCutter {
  public:
    LoadCutter(const ir::Stage& stage, std::vector<Type>* states)
        : stage_(stage), states_(*states) {}

    std::vector<ElementPart> run() {
        find_levels();
        size_t last = 0;
        for (ValueId id = 0; id < stage_.instrs.size(); ++id)
            last = std::max(last, level_[id]);
        parts_.resize(last + 1);
        for (Part& part : parts_)
            part.out.kernel.kind = stage_.kind;
        for (size_t p = 0; p < last; ++p) {
            for (ValueId id = 0; id < stage_.instrs.size(); ++id) {
                if (is_element_load(stage_.instrs[id]) && level_[id] == p + 1) add_load(p, id);
            }
        }
        for (ir::Output output : stage_.outputs) {
            output.value = get(last, output.value);
            parts_[last].out.kernel.outputs.push_back(std::move(output));
        }
        std::vector<ElementPart> out;
        for (Part& part : parts_)
            out.push_back(std::move(part.out));
        return out;
    }

  private:
    struct Part {
        ElementPart out;
        std::map<ValueId, ValueId> made;
    };

    int32_t new_state(Type type) {
        states_.push_back(type);
        return static_cast<int32_t>(states_.size() - 1);
    }

    /// level_[id]: the first part that can compute a value, or read what was loaded before it.
    void find_levels() {
        level_.assign(stage_.instrs.size(), 0);
        for (ValueId id = 0; id < stage_.instrs.size(); ++id) {
            for (const ValueId arg : stage_.instrs[id].args)
                level_[id] = std::max(level_[id], level_[arg]);
            if (is_element_load(stage_.instrs[id])) ++level_[id];
        }
    }

    void add_load(size_t part, ValueId id) {
        const Instr& load = stage_.instrs[id];
        const int32_t index = pass_on(part, load.args[0]);
        const int32_t to = new_state(load.type);
        state_[id] = to;
        parts_[part].out.steps.push_back({OPENFAB_ELEMENTS_LOAD, load.a, load.b,
                                          static_cast<int32_t>(load.bits), index, to, 0, -1});
    }

    /// Returns the state by which a part passes a value on.
    int32_t pass_on(size_t part, ValueId id) {
        const auto before = state_.find(id);
        if (before != state_.end()) return before->second;
        const int32_t state = new_state(stage_.instrs[id].type);
        const ValueId value = get(part, id);
        parts_[part].out.kernel.outputs.push_back(
            {fmt::format("state_{}", state), OPENFAB_ARG_STATE_OUT, state, 0, value});
        state_[id] = state;
        return state;
    }

    ValueId get(size_t part, ValueId id) {
        const auto before = parts_[part].made.find(id);
        if (before != parts_[part].made.end()) return before->second;
        const Instr& instr = stage_.instrs[id];
        ir::Builder builder(&parts_[part].out.kernel);
        builder.set_span(instr.span);
        ValueId out = kNoValue;
        const std::optional<size_t> earlier = part_that_has(part, id);
        if (is_element_load(instr) || earlier) {
            const int32_t state = earlier ? pass_on(*earlier, id) : state_.at(id);
            out = builder.input(instr.type, OPENFAB_ARG_STATE, state, 0);
        } else {
            Instr copy = instr;
            for (ValueId& arg : copy.args)
                arg = get(part, arg);
            out = builder.append(std::move(copy));
        }
        parts_[part].made.emplace(id, out);
        return out;
    }

    /// Returns an earlier part that computes a value which is more than an input.
    std::optional<size_t> part_that_has(size_t part, ValueId id) const {
        if (ir::family(stage_.instrs[id].op) == ir::Family::kLeaf ||
            is_element_load(stage_.instrs[id]))
            return std::nullopt;
        for (size_t p = level_[id]; p < part; ++p) {
            if (parts_[p].made.contains(id)) return p;
        }
        return std::nullopt;
    }

    const ir::Stage& stage_;
    std::vector<Type>& states_;
    std::vector<size_t> level_;
    std::vector<Part> parts_;
    std::map<ValueId, int32_t> state_;  ///< of values that are passed on, or loaded
};

}  // namespace

std::vector<ElementPart> cut_elements(const ir::Stage& kernel, std::vector<Type>* states) {
    ir::Stage stage = LoadMaker(kernel).run();
    std::vector<openfab_elements> writes = take_writes(&stage, states);
    std::vector<ElementPart> parts = LoadCutter(stage, states).run();
    parts.back().steps = std::move(writes);
    return parts;
}

}  // namespace openfab::passes
