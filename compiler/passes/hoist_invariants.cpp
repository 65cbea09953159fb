// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/hoist_invariants.h"

#include <algorithm>
#include <map>
#include <utility>

namespace openfab::passes {

namespace {

using ir::kNoValue;
using ir::Op;
using ir::ValueId;

class Hoister {
  public:
    explicit Hoister(ir::Stage* stage) : old_(std::move(*stage)), builder_(&new_) {
        new_.kind = old_.kind;
        new_.printfs = old_.printfs;
    }

    ir::Stage run() {
        find_homes();
        renamed_.assign(old_.instrs.size(), kNoValue);
        for (ValueId id = 0; id < old_.instrs.size(); ++id) {
            if (home_[id] != inside_[id]) continue;  // emitted before a loop
            if (old_.instrs[id].op == Op::kLoop) {
                for (const ValueId moved : before_[id])
                    emit(moved);
            }
            emit(id);
        }
        for (ir::Output output : old_.outputs) {
            output.value = renamed_[output.value];
            new_.outputs.push_back(std::move(output));
        }
        return std::move(new_);
    }

  private:
    size_t depth(ValueId loop) const { return loop == kNoValue ? 0 : depth_.at(loop); }

    /// The innermost loop that an instruction must stay in: the deepest of its arguments'.
    void find_homes() {
        std::vector<ValueId> open;
        for (ValueId id = 0; id < old_.instrs.size(); ++id) {
            const ir::Instr& instr = old_.instrs[id];
            if (instr.op == Op::kLoopEnd) open.pop_back();
            inside_.push_back(open.empty() ? kNoValue : open.back());
            if (instr.op == Op::kLoop) {
                open.push_back(id);
                depth_[id] = open.size();
            }
            home_.push_back(inside_[id]);
            if (inside_[id] == kNoValue || ir::is_effectful(instr.op)) continue;
            ValueId home = deepest(instr);
            // The guard of a lookup is combined with those of the loops that it leaves.
            if (instr.op == Op::kSample) {
                for (ValueId loop = inside_[id]; depth(loop) > depth(home); loop = inside_[loop]) {
                    const ValueId needed = home_[old_.instrs[loop].args[0]];
                    if (depth(needed) > depth(home)) home = needed;
                }
            }
            if (depth(home) >= depth(inside_[id])) continue;
            home_[id] = home;
            ValueId outermost = inside_[id];
            while (inside_[outermost] != home)
                outermost = inside_[outermost];
            before_[outermost].push_back(id);
        }
    }

    ValueId deepest(const ir::Instr& instr) const {
        ValueId home = kNoValue;
        for (const ValueId arg : instr.args) {
            if (depth(home_[arg]) > depth(home)) home = home_[arg];
        }
        return home;
    }

    void emit(ValueId id) {
        ir::Instr copy = old_.instrs[id];
        for (ValueId& arg : copy.args)
            arg = renamed_[arg];
        builder_.set_span(copy.span);
        if (copy.op == Op::kSample) {
            for (ValueId loop = inside_[id]; loop != home_[id]; loop = inside_[loop]) {
                const ValueId guard = renamed_[old_.instrs[loop].args[0]];
                copy.args[0] = builder_.emit(Op::kAnd, {copy.args[0], guard});
            }
        }
        renamed_[id] = builder_.append(std::move(copy));
    }

    const ir::Stage old_;
    ir::Stage new_;
    ir::Builder builder_;
    std::vector<ValueId> inside_;  ///< innermost loop around each instruction, before and after
    std::vector<ValueId> home_;
    std::map<ValueId, size_t> depth_;                 ///< of what is inside a loop
    std::map<ValueId, std::vector<ValueId>> before_;  ///< instructions that move before a loop
    std::vector<ValueId> renamed_;
};

}  // namespace

void hoist_invariants(ir::Stage* stage) {
    const bool loops = std::any_of(stage->instrs.begin(), stage->instrs.end(),
                                   [](const ir::Instr& i) { return i.op == Op::kLoop; });
    if (loops) *stage = Hoister(stage).run();
}

}  // namespace openfab::passes
