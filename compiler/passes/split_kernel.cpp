// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/passes/split_kernel.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace openfab::passes {

namespace {

using ir::Instr;
using ir::kNoValue;
using ir::Op;
using ir::ValueId;

constexpr size_t kMaxOutputs = 320;
constexpr size_t kPieceOutputs = 32;
constexpr size_t kMaxInputs = 96;  // states that it reads
constexpr size_t kPieceInputs = 48;
// The most outputs of one value.
constexpr size_t kMaxCopies = 4;

// A lookup calls an extern stage; its interval form is generated code.
constexpr size_t kSampleOperations = 100;
constexpr size_t kSampleBoundOperations = 120;

size_t operations_of(const Instr& instr) {
    if (ir::family(instr.op) == ir::Family::kLeaf) return 0;
    if (instr.op == Op::kSample) return kSampleOperations;
    return instr.op == Op::kSampleBound ? kSampleBoundOperations : 1;
}

bool is_state(const Instr& instr) {
    return instr.op == Op::kInput && instr.kind == OPENFAB_ARG_STATE;
}

/// Returns the kernel with what each output needs just before it, and of arguments the one of the
/// longest chain first: in the order of the program all elements of an array may be computed before
/// the first is written, or all tests before the first that chooses, and cross every cut.
ir::Stage in_order_of_outputs(const ir::Stage& kernel) {
    std::vector<size_t> depth(kernel.instrs.size(), 0);
    for (size_t id = 0; id < depth.size(); ++id) {
        for (const ValueId arg : kernel.instrs[id].args)
            depth[id] = std::max(depth[id], depth[arg] + 1);
    }
    ir::Stage out = kernel;
    out.instrs.clear();
    std::vector<ValueId> moved(kernel.instrs.size(), kNoValue);
    std::vector<ValueId> open;
    for (ir::Output& output : out.outputs) {
        open.push_back(output.value);
        while (!open.empty()) {
            const ValueId id = open.back();
            const std::vector<ValueId>& args = kernel.instrs[id].args;
            ValueId next = kNoValue;
            for (const ValueId arg : args) {
                if (moved[arg] == kNoValue && (next == kNoValue || depth[arg] > depth[next]))
                    next = arg;
            }
            if (next != kNoValue) {
                open.push_back(next);
                continue;
            }
            open.pop_back();
            if (moved[id] != kNoValue) continue;
            moved[id] = static_cast<ValueId>(out.instrs.size());
            out.instrs.push_back(kernel.instrs[id]);
            for (ValueId& arg : out.instrs.back().args)
                arg = moved[arg];
        }
        output.value = moved[output.value];
    }
    return out;
}

class Splitter {
  public:
    Splitter(const ir::Stage& kernel, std::vector<ir::Type>* states, size_t longest)
        : kernel_(kernel),
          states_(*states),
          live_(ir::live_values(kernel)),
          shortest_piece_(longest / 5),
          longest_piece_(2 * longest / 5) {}

    std::vector<ir::Stage> run() {
        find_rewritten();
        find_written_in_place();
        count_outputs();
        find_last_uses();
        find_cuts();
        for (size_t p = 0; p < pieces_; ++p)
            compute(p);
        write_rest();
        return std::move(out_);
    }

  private:
    const Instr& at(ValueId id) const { return kernel_.instrs[id]; }

    /// States that are both read and written: written by the last pieces, once all have read them.
    void find_rewritten() {
        std::set<int32_t> written;
        for (const ir::Output& output : kernel_.outputs) {
            if (output.kind == OPENFAB_ARG_STATE_OUT) written.insert(output.a);
        }
        for (ValueId id = 0; id < kernel_.instrs.size(); ++id) {
            const Instr& instr = at(id);
            if (live_[id] && is_state(instr) && written.count(instr.a) != 0)
                rewritten_.insert(instr.a);
        }
    }
    bool is_rewritten(int32_t state) const { return rewritten_.count(state) != 0; }

    /// Finds those of them that are written where they are computed, as the elements of an array that
    /// a loop fills: only the piece of its Input reads a state, which is that one or an earlier one,
    /// and what a kernel stores is there when it has ended.
    void find_written_in_place() {
        std::map<int32_t, ValueId> read;
        for (ValueId id = 0; id < kernel_.instrs.size(); ++id) {
            if (live_[id] && is_state(at(id))) read[at(id).a] = id;
        }
        for (const ir::Output& output : kernel_.outputs) {
            if (output.kind != OPENFAB_ARG_STATE_OUT || !is_rewritten(output.a)) continue;
            if (read.at(output.a) <= output.value) in_place_.insert(output.a);
        }
    }

    /// True for values that each piece recomputes for itself.
    bool is_made_again(ValueId id) const {
        const Instr& instr = at(id);
        if (instr.op == Op::kConst) return true;
        return instr.op == Op::kInput &&
               (instr.kind != OPENFAB_ARG_STATE || !is_rewritten(instr.a));
    }
    /// Returns whether an output goes into the last pieces: those states, and outputs that any
    /// piece can write.
    bool is_written_last(const ir::Output& output) const {
        if (output.kind == OPENFAB_ARG_STATE_OUT && is_rewritten(output.a) &&
            in_place_.count(output.a) == 0)
            return true;
        return is_made_again(output.value) || copies_[output.value] > kMaxCopies;
    }

    void count_outputs() {
        copies_.assign(kernel_.instrs.size(), 0);
        for (const ir::Output& output : kernel_.outputs)
            ++copies_[output.value];
    }

    void find_last_uses() {
        const size_t count = kernel_.instrs.size();
        last_use_.assign(count, 0);
        due_.assign(count, 0);
        for (ValueId id = 0; id < count; ++id) {
            if (!live_[id]) continue;
            for (const ValueId arg : at(id).args)
                last_use_[arg] = id;
        }
        for (const ir::Output& output : kernel_.outputs) {
            if (is_written_last(output)) {
                last_use_[output.value] = count;
            } else {
                ++due_[output.value];
            }
        }
    }

    /// Returns the outputs that the piece of a value has for it wherever the cuts are: what the
    /// last pieces write crosses to them.
    size_t outputs_of(ValueId id) const {
        const bool last = last_use_[id] == kernel_.instrs.size() && !is_made_again(id);
        return due_[id] + (last ? 1 : 0);
    }

    /// Adds the states that a piece, which begins at a value, reads for another of its values.
    void add_inputs(ValueId begin, ValueId id, std::set<ValueId>* inputs) const {
        if (is_state(at(id)) && is_rewritten(at(id).a)) inputs->insert(id);
        for (const ValueId arg : at(id).args) {
            if (is_made_again(arg) ? is_state(at(arg)) : arg < begin) inputs->insert(arg);
        }
    }

    /// piece_[id]: the piece that computes a value.
    void find_cuts() {
        const size_t count = kernel_.instrs.size();
        // How many values cross a cut before each instruction.
        std::vector<int64_t> change(count + 2, 0);
        for (ValueId id = 0; id < count; ++id) {
            if (!live_[id] || is_made_again(id) || last_use_[id] <= id) continue;
            ++change[id + 1];
            --change[last_use_[id] + 1];
        }
        std::vector<int64_t> crossing(count + 1, 0);
        for (size_t k = 1; k <= count; ++k)
            crossing[k] = crossing[k - 1] + change[k];
        piece_.assign(count, 0);
        for (ValueId begin = 0; begin < count; ++pieces_) {
            size_t operations = 0, outputs = 0;
            std::set<ValueId> inputs;
            ValueId best = static_cast<ValueId>(count), id = begin;
            int64_t fewest = -1;
            for (; id < count; ++id) {
                if (operations >= shortest_piece_ && (fewest < 0 || crossing[id] < fewest)) {
                    fewest = crossing[id];
                    best = id;
                }
                const bool wide =
                    outputs + outputs_of(id) > kPieceOutputs || inputs.size() >= kPieceInputs;
                if (id > begin && wide && operations > 0) {
                    best = id;
                    break;
                }
                if (operations >= longest_piece_) break;
                if (!live_[id]) continue;
                operations += operations_of(at(id));
                outputs += outputs_of(id);
                add_inputs(begin, id, &inputs);
            }
            if (id == count) best = id;
            for (; begin < best; ++begin)
                piece_[begin] = pieces_;
        }
    }

    /// One piece, while it is built.
    struct Piece {
        ir::Stage stage;
        std::vector<std::pair<ValueId, ValueId>> made;  ///< of the kernel, of the piece; sorted
    };

    ValueId* known(Piece* piece, ValueId id) {
        const auto less = [](const auto& a, ValueId b) { return a.first < b; };
        const auto found = std::lower_bound(piece->made.begin(), piece->made.end(), id, less);
        const bool here = found != piece->made.end() && found->first == id;
        return here ? &found->second : nullptr;
    }

    ValueId get(Piece* piece, size_t number, ValueId id) {
        if (const ValueId* made = known(piece, id)) return *made;
        Instr instr = at(id);
        if (!is_made_again(id) && piece_[id] != number) {
            instr = {};
            instr.op = Op::kInput;
            instr.type = at(id).type;
            instr.kind = OPENFAB_ARG_STATE;
            instr.a = crossing_state(id);
        } else {
            for (ValueId& arg : instr.args)
                arg = get(piece, number, arg);
        }
        const auto value = static_cast<ValueId>(piece->stage.instrs.size());
        piece->stage.instrs.push_back(std::move(instr));
        const auto less = [](const auto& a, ValueId b) { return a.first < b; };
        const auto at_id = std::lower_bound(piece->made.begin(), piece->made.end(), id, less);
        piece->made.insert(at_id, {id, value});
        return value;
    }

    int32_t crossing_state(ValueId id) {
        if (state_.empty()) state_.assign(kernel_.instrs.size(), -1);
        if (state_[id] < 0) {
            state_[id] = static_cast<int32_t>(states_.size());
            states_.push_back(at(id).type);
        }
        return state_[id];
    }

    bool crosses(ValueId id) const {
        return !is_made_again(id) && (last_use_[id] == kernel_.instrs.size() ||
                                      (last_use_[id] > id && piece_[last_use_[id]] != piece_[id]));
    }

    static void write_state(int32_t state, ValueId value, ir::Stage* to) {
        to->outputs.push_back(
            {fmt::format("state_{}", state), OPENFAB_ARG_STATE_OUT, state, 0, value});
    }

    void compute(size_t number) {
        Piece piece;
        piece.stage.kind = kernel_.kind;
        for (ValueId id = 0; id < kernel_.instrs.size(); ++id) {
            if (!live_[id] || piece_[id] != number) continue;
            if (crosses(id)) {
                const ValueId value = get(&piece, number, id);
                write_state(crossing_state(id), value, &piece.stage);
            }
            if (due_[id] == 0) continue;
            for (ir::Output output : kernel_.outputs) {
                if (output.value != id || is_written_last(output)) continue;
                output.value = get(&piece, number, id);
                piece.stage.outputs.push_back(std::move(output));
            }
        }
        if (!piece.stage.outputs.empty()) out_.push_back(std::move(piece.stage));
    }

    /// Writes the states that all other pieces have read, and that none of these pieces reads.
    void write_rest() {
        std::vector<ir::Output> rest;
        for (const ir::Output& output : kernel_.outputs) {
            if (is_written_last(output)) rest.push_back(output);
        }
        for (size_t first = 0; first < rest.size(); first += kPieceOutputs) {
            Piece piece;
            piece.stage.kind = kernel_.kind;
            const size_t end = std::min(rest.size(), first + kPieceOutputs);
            for (size_t k = first; k < end; ++k) {
                ir::Output output = rest[k];
                output.value = get(&piece, pieces_, output.value);
                piece.stage.outputs.push_back(std::move(output));
            }
            out_.push_back(std::move(piece.stage));
        }
    }

    const ir::Stage& kernel_;
    std::vector<ir::Type>& states_;
    const std::vector<bool> live_;
    // A cut is made where the fewest values cross it between these.
    const size_t shortest_piece_, longest_piece_;
    std::set<int32_t> rewritten_;
    std::set<int32_t> in_place_;    ///< of those, written where they are computed
    std::vector<size_t> last_use_;  ///< beyond the end: by the pieces that come last
    std::vector<size_t> copies_;    ///< outputs that store each value
    std::vector<size_t> due_;       ///< outputs that are written where the value is computed
    std::vector<size_t> piece_;
    std::vector<int32_t> state_;
    size_t pieces_ = 0;
    std::vector<ir::Stage> out_;
};

}  // namespace

bool is_wide(const ir::Stage& kernel) {
    const auto inputs = std::count_if(kernel.instrs.begin(), kernel.instrs.end(), is_state);
    return kernel.outputs.size() > kMaxOutputs || static_cast<size_t>(inputs) > kMaxInputs;
}

size_t kernel_operations(const ir::Stage& stage) {
    size_t sum = 0;
    for (const Instr& instr : stage.instrs)
        sum += operations_of(instr);
    return sum;
}

ir::ValueId first_beyond(const ir::Stage& stage, size_t operations) {
    size_t sum = 0;
    for (size_t id = 0; id < stage.instrs.size(); ++id) {
        sum += operations_of(stage.instrs[id]);
        if (sum > operations) return static_cast<ir::ValueId>(id);
    }
    return ir::kNoValue;
}

bool needs_splitting(const ir::Stage& stage, size_t longest) {
    return kernel_operations(stage) > longest || is_wide(stage);
}

std::vector<ir::Stage> split_kernel(const ir::Stage& kernel, std::vector<ir::Type>* states,
                                    size_t longest) {
    if (!is_wide(kernel)) return Splitter(kernel, states, longest).run();
    const ir::Stage ordered = in_order_of_outputs(kernel);
    return Splitter(ordered, states, longest).run();
}

}  // namespace openfab::passes
