// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/algorithm/value_lowering.h"

#include <array>
#include <string>

#include "compiler/lower/algorithm/sample_parts.h"
#include "texture/sample.h"

namespace openfab::lower {

namespace {

using Halide::Expr;
using ir::Op;

// More values than these are stored before a lookup, rather than computed before and after it.
constexpr size_t kMostComputedTwice = 6;

}  // namespace

void ValueLowering::run() {
    const std::vector<bool> live = ir::live_values(stage_);
    const std::vector<size_t> last_use = last_uses(live);
    const size_t last_picture = last_picture_sample(live);
    values_.resize(stage_.instrs.size());
    for (size_t id = 0; id < stage_.instrs.size(); ++id) {
        const Op op = stage_.instrs[id].op;
        if (!live[id] || values_[id].expr.defined()) continue;
        const bool is_sample = op == Op::kSample || op == Op::kSampleBound;
        context_->feeds_sample = id <= last_picture;
        if (is_sample && chunk_.size() >= kMostComputedTwice) store_chunk(id, last_use);
        if (op == Op::kInput) {
            values_[id] = inputs_.value(stage_.instrs[id]);
        } else if (op == Op::kSample) {
            lower_sample_group(id, live);
        } else if (op == Op::kSampleBound) {
            lower_bound_pair(id, live);
        } else if (op != Op::kConst) {
            chunk_.push_back(id);
        }
    }
}

size_t ValueLowering::last_picture_sample(const std::vector<bool>& live) const {
    size_t out = 0;
    for (size_t id = 0; id < stage_.instrs.size(); ++id) {
        const ir::Instr& instr = stage_.instrs[id];
        if (live[id] && instr.op == Op::kSample && !is_volume_sample(instr.args.size())) out = id;
    }
    return out;
}

std::vector<size_t> ValueLowering::last_uses(const std::vector<bool>& live) const {
    std::vector<size_t> out(stage_.instrs.size(), 0);
    for (size_t id = 0; id < stage_.instrs.size(); ++id) {
        if (!live[id]) continue;
        for (const ir::ValueId arg : stage_.instrs[id].args)
            out[arg] = id;
    }
    for (const ir::Output& output : stage_.outputs)
        out[output.value] = stage_.instrs.size();
    return out;
}

void ValueLowering::store_chunk(size_t next, const std::vector<size_t>& last_use) {
    std::vector<size_t> kept;
    std::vector<Expr> stored;
    for (const size_t id : chunk_) {
        if (last_use[id] < next) continue;
        kept.push_back(id);
        stored.push_back(to_storage(value(id)));
    }
    chunk_.clear();
    if (kept.empty()) return;
    const std::string name = func_name(*context_, name_, chunks_++);
    const Halide::Func func = new_func(context_, name, context_->vars).func;
    func(context_->vars) = Halide::Tuple(stored);
    const std::vector<Expr> here(context_->vars.begin(), context_->vars.end());
    for (size_t k = 0; k < kept.size(); ++k) {
        const Expr loaded = kept.size() == 1 ? Expr(func(here)) : func(here)[static_cast<int>(k)];
        values_[kept[k]] = from_storage(stage_.instrs[kept[k]].type, loaded);
    }
}

std::vector<Value> ValueLowering::arguments(const ir::Instr& instr) {
    std::vector<Value> out;
    for (ir::ValueId arg : instr.args)
        out.push_back(value(arg));
    return out;
}

Value ValueLowering::value(size_t id) {
    return deferred_->value(stage_, name_, static_cast<ir::ValueId>(id), values_);
}

void ValueLowering::lower_sample_group(size_t id, const std::vector<bool>& live) {
    const ir::Instr& instr = stage_.instrs[id];
    std::vector<size_t> members;
    std::vector<int32_t> channels;
    for (size_t other = id;
         other < stage_.instrs.size() && members.size() < texture::kMaxSampleResults; ++other) {
        const ir::Instr& candidate = stage_.instrs[other];
        if (live[other] && candidate.op == Op::kSample && candidate.a == instr.a &&
            candidate.args == instr.args) {
            members.push_back(other);
            channels.push_back(candidate.b);
        }
    }
    const std::vector<Value> results = lower_sample(context_, instr.a, channels, arguments(instr));
    for (size_t k = 0; k < members.size(); ++k)
        values_[members[k]] = results[k];
}

void ValueLowering::lower_bound_pair(size_t id, const std::vector<bool>& live) {
    const ir::Instr& instr = stage_.instrs[id];
    const std::array<Value, 2> ends =
        lower_sample_bound(context_, instr.a, instr.b, arguments(instr));
    for (size_t other = id; other < stage_.instrs.size(); ++other) {
        const ir::Instr& candidate = stage_.instrs[other];
        if (live[other] && candidate.op == Op::kSampleBound && candidate.a == instr.a &&
            candidate.b == instr.b && candidate.args == instr.args) {
            values_[other] = ends[candidate.bits & 1u];
        }
    }
}

Expr ValueLowering::one_of(const std::vector<ir::ValueId>& ids, const Expr& number) {
    return deferred_->one_of(stage_, name_, ids, values_, number);
}

}  // namespace openfab::lower
