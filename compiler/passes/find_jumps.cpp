// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/find_jumps.h"

#include <algorithm>
#include <map>

#include "abi/curve_table.h"
#include "compiler/passes/carry_changes.h"
#include "compiler/passes/eliminate_common_values.h"
#include "compiler/passes/expand_picks.h"
#include "compiler/passes/simplify.h"

namespace openfab::passes {

namespace {

using ir::Instr;
using ir::kNoValue;
using ir::Op;
using ir::Type;
using ir::ValueId;

/// Whether a number of a curve's table depends on its keys' values, not on their places alone.
bool is_value_of_curve(int32_t number, int32_t size) {
    const int32_t channels = abi::curve_channels(size);
    const int32_t header = abi::curve_header(channels);
    if (number < header) return number >= 2;
    return (number - header) % abi::curve_stride(channels) != 0;
}

/// A direction for each uniform; those beyond the last share it.
class ByUniform : public Seeds {
  public:
    explicit ByUniform(const ir::Fablet& fablet) {
        for (const ir::Uniform& u : fablet.uniforms) {
            const bool curve = u.kind == OPENFAB_UNIFORM_CURVE;
            if (!curve && (u.kind != OPENFAB_UNIFORM_VALUE || u.type != Type::kFloat)) continue;
            const size_t direction = std::min(names_.size(), size_t{31});
            names_.push_back(u.name);
            for (int32_t k = 0; k < u.components * u.array_length; ++k) {
                if (!curve || is_value_of_curve(k, u.components))
                    of_value_[u.first_index + k] = direction;
            }
        }
        for (const ir::Instr& instr : fablet.shape.instrs)
            shape_ |= of_uniform(instr);
        for (const ir::Instr& instr : fablet.surface.instrs)
            shape_ |= of_uniform(instr);
    }

    Mask active(const Instr& input) const override {
        const bool of_surface =
            input.kind == OPENFAB_ARG_DISTANCE || input.kind == OPENFAB_ARG_NEAREST;
        return of_surface ? shape_ : of_uniform(input);
    }
    ValueId change(const Instr& /*input*/, size_t /*direction*/) override { return kNoValue; }
    Mask active_result(const Instr& query, const Instr& /*result*/, Mask point) const override {
        return point | (query.a < 0 ? shape_ : 0);
    }

    std::vector<std::string> names(Mask mask) const {
        std::vector<std::string> out;
        for (size_t k = 0; k < names_.size(); ++k) {
            if ((mask >> std::min(k, size_t{31}) & 1) != 0) out.push_back(names_[k]);
        }
        return out;
    }

    Mask of_uniform(const Instr& input) const {
        if (input.op != Op::kInput || input.kind != OPENFAB_ARG_UNIFORM) return 0;
        const auto found = of_value_.find(input.a);
        return found == of_value_.end() ? 0 : Mask{1} << found->second;
    }

  private:
    std::vector<std::string> names_;
    std::map<int32_t, size_t> of_value_;
    Mask shape_ = 0;  ///< what moves the part's surface
};

class Finder {
  public:
    Finder(const ir::Stage& stage, const ByUniform& seeds)
        : stage_(stage), seeds_(seeds), active_(active_directions(stage, seeds)) {
        for (const Instr& instr : stage.instrs) {
            if (instr.op != Op::kSelect || !is_smooth(instr)) {
                for (const ValueId arg : instr.args)
                    jumps_.push_back(arg);
            } else {
                jumps_.insert(jumps_.end(), instr.args.begin() + 1, instr.args.end());
            }
        }
        for (const ir::Output& output : stage.outputs)
            jumps_.push_back(output.value);
        std::ranges::sort(jumps_);
    }

    std::vector<Jump> run() {
        for (ValueId id = 0; id < stage_.instrs.size(); ++id) {
            const Instr& instr = stage_.instrs[id];
            Mask moving = 0;
            for (const ValueId arg : instr.args)
                moving |= active_[arg];
            if (moving == 0) continue;
            if (ir::is_comparison(instr.op)) {
                if (std::ranges::binary_search(jumps_, id))
                    add(JumpKind::kComparison, instr, moving);
            } else if (ir::family(instr.op) == ir::Family::kFloatPart && instr.op != Op::kSqrt &&
                       instr.op != Op::kIsNan) {
                // x - floor(x) repeats, and is rounded all the same.
                add(JumpKind::kRounding, instr, active_[instr.args[0]]);
            } else if (instr.op == Op::kConvert && instr.type != Type::kFloat) {
                add(JumpKind::kRounding, instr, moving);
            } else if (instr.op == Op::kMod) {
                add(JumpKind::kRemainder, instr, moving);
            } else if (instr.op == Op::kCellular && instr.a == 2) {
                add(JumpKind::kCell, instr, moving);
            }
        }
        return std::move(out_);
    }

  private:
    const Instr& at(ValueId id) const { return stage_.instrs[id]; }

    bool is_negative_of(ValueId a, ValueId b) const {
        return at(a).op == Op::kNeg && at(a).args[0] == b;
    }
    bool is_zero(ValueId a) const {
        return at(a).op == Op::kConst && at(a).type == Type::kFloat && (at(a).bits << 1) == 0;
    }

    bool is_smooth(const Instr& select) const {
        const Instr& by = at(select.args[0]);
        if (!ir::is_comparison(by.op)) return false;
        const ValueId a = by.args[0], b = by.args[1], x = select.args[1], y = select.args[2];
        if ((x == a && y == b) || (x == b && y == a)) return true;
        const bool opposite = is_negative_of(x, y) || is_negative_of(y, x);
        if (!opposite) return false;
        const ValueId value = is_zero(a) ? b : is_zero(b) ? a : kNoValue;
        return value == x || value == y;
    }

    void add(JumpKind kind, const Instr& instr, Mask moving) {
        const bool known = std::ranges::any_of(
            out_, [&](const Jump& jump) { return jump.kind == kind && jump.span == instr.span; });
        if (!known) out_.push_back({kind, instr.span, seeds_.names(moving)});
    }

    const ir::Stage& stage_;
    const ByUniform& seeds_;
    const std::vector<Mask> active_;
    std::vector<ValueId> jumps_;  ///< what is used where a jump of it shows
    std::vector<Jump> out_;
};

}  // namespace

std::vector<Jump> find_jumps(const ir::Fablet& fablet) {
    ir::Stage volume = fablet.volume;
    volume.printfs.clear();
    const auto clean = [&] {
        simplify(&volume);
        eliminate_common_values(&volume);
        ir::drop_dead_values(&volume);
    };
    clean();
    expand_picks(&volume);
    clean();
    const ByUniform seeds(fablet);
    std::vector<Jump> out = Finder(volume, seeds).run();
    for (const ir::Stage* stage : {&fablet.shape, &fablet.surface}) {
        Mask known = 0;
        for (const Instr& instr : stage->instrs) {
            const Mask moving = seeds.of_uniform(instr) & ~known;
            if (moving != 0) out.push_back({JumpKind::kBorder, instr.span, seeds.names(moving)});
            known |= moving;
        }
    }
    return out;
}

}  // namespace openfab::passes
