// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/deferred.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <utility>

namespace openfab::lower {

namespace {

namespace internal = Halide::Internal;
using Halide::Expr;
using internal::Stmt;
using ir::Instr;
using ir::Op;
using ir::ValueId;

/// Computes one operation from its arguments, which may be vectors.
Value compute(const Instr& instr, const std::vector<Value>& args) {
    switch (instr.op) {
        case Op::kConst:
            return constant_bits(instr.type, instr.bits);
        case Op::kConvert:
            return convert(args[0], instr.type);
        case Op::kBitCast:
            return bit_cast(args[0], instr.type);
        default:
            return operate(instr.op, args);
    }
}

/// Lists the buffers that an expression loads from, and whether it may be computed once for all
/// places that need it.
class Effects : public internal::IRVisitor {
  public:
    explicit Effects(const Expr& e) { e.accept(this); }

    const std::set<std::string>& loads() const { return loads_; }
    bool is_pure() const { return is_pure_; }

  private:
    using internal::IRVisitor::visit;

    void visit(const internal::Load* op) override {
        loads_.insert(op->name);
        IRVisitor::visit(op);
    }
    void visit(const internal::Call* op) override {
        if (!op->is_pure()) is_pure_ = false;
        IRVisitor::visit(op);
    }

    std::set<std::string> loads_;
    bool is_pure_ = true;
};

bool is_atom(const Expr& e) {
    return e.as<internal::Variable>() != nullptr || internal::is_const(e);
}

class Expander : public internal::IRMutator {
  public:
    explicit Expander(std::shared_ptr<const Deferred> deferred) : deferred_(std::move(deferred)) {}

    /// Rewrites statements that follow each other, with lets between them.
    Stmt mutate(const Stmt& s) override {
        if (!s.defined()) return s;
        Sequence sequence;
        std::swap(sequence, now_);
        append(s);
        std::swap(sequence, now_);
        Stmt out;
        for (auto item = sequence.items.rbegin(); item != sequence.items.rend(); ++item) {
            if (item->value.defined()) {
                if (out.defined()) out = internal::LetStmt::make(item->name, item->value, out);
            } else {
                out = out.defined() ? internal::Block::make(item->stmt, out) : item->stmt;
            }
        }
        return out;
    }

    Expr mutate(const Expr& e) override { return IRMutator::mutate(e); }

  private:
    /// A statement, or a let that holds for all that follow.
    struct Item {
        std::string name;
        Expr value;
        Stmt stmt;
    };

    /// The values of one stage that are there.
    struct Known {
        std::map<ValueId, Expr> reads;
        std::map<ValueId, Value> values;
    };

    struct Sequence {
        std::vector<Item> items;
        std::map<Expr, Expr, internal::IRDeepCompare> lets;  ///< by value
        std::set<std::string> loads;  ///< buffers that those values load from
        std::map<const ir::Stage*, Known> known;
    };

    void append(const Stmt& s) {
        if (const auto* block = s.as<internal::Block>()) {
            append(block->first);
            append(block->rest);
        } else if (const auto* let = s.as<internal::LetStmt>()) {
            append(let);
        } else if (const auto* store = s.as<internal::Store>()) {
            Stmt changed = IRMutator::visit(store);
            if (now_.loads.count(store->name) != 0) forget_loads();
            now_.items.push_back({"", Expr(), std::move(changed)});
        } else {
            Stmt changed = IRMutator::mutate(s);
            forget_loads();
            now_.items.push_back({"", Expr(), std::move(changed)});
        }
    }

    void append(const internal::LetStmt* let) {
        const Expr value = mutate(let->value);
        if (value.type().is_handle()) {
            // Loads and stores name it.
            now_.items.push_back({let->name, value, Stmt()});
            append(let->body);
            return;
        }
        const Renamed renamed(this, let->name, bind(value));
        append(let->body);
    }

    /// What Halide calls a variable, while this lives.
    class Renamed {
      public:
        Renamed(Expander* expander, const std::string& name, Expr e)
            : names_(expander->names_), name_(name) {
            names_.push(name_, std::move(e));
        }
        ~Renamed() { names_.pop(name_); }
        Renamed(const Renamed&) = delete;
        Renamed& operator=(const Renamed&) = delete;

      private:
        internal::Scope<Expr>& names_;
        const std::string name_;
    };

    void forget_loads() {
        now_.lets.clear();
        now_.loads.clear();
    }

    Expr add_let(const Expr& value) {
        const std::string name = fmt::format("{}.v{}", kPrefix, lets_++);
        now_.items.push_back({name, value, Stmt()});
        return internal::Variable::make(value.type(), name);
    }

    /// Returns a variable of this value, or a constant.
    Expr bind(const Expr& value) {
        if (is_atom(value)) return value;
        const Effects effects(value);
        if (!effects.is_pure()) {
            Expr out = add_let(value);
            forget_loads();
            return out;
        }
        const auto known = now_.lets.find(value);
        if (known != now_.lets.end()) return known->second;
        Expr out = add_let(value);
        now_.lets.emplace(value, out);
        now_.loads.insert(effects.loads().begin(), effects.loads().end());
        return out;
    }

    using internal::IRMutator::visit;

    Expr visit(const internal::Variable* op) override {
        return names_.contains(op->name) ? names_.get(op->name) : Expr(op);
    }

    Expr visit(const internal::Let* op) override {
        const Renamed renamed(this, op->name, bind(mutate(op->value)));
        return mutate(op->body);
    }

    Expr visit(const internal::Call* op) override {
        if (op->is_intrinsic(internal::Call::if_then_else)) {
            // What is loaded under a condition is not there without it.
            std::vector<Expr> args = {mutate(op->args[0])};
            for (size_t k = 1; k < op->args.size(); ++k)
                args.push_back(alone(op->args[k]));
            return internal::Call::make(op->type, op->name, args, op->call_type);
        }
        const DeferredValue* value = deferred_->find(op->name);
        if (value == nullptr) return IRMutator::visit(op);
        const Expr out = expand(*value, op->args);
        const int lanes = op->type.lanes();
        return out.type().lanes() == lanes ? out : internal::Broadcast::make(out, lanes);
    }

    /// Rewrites an expression whose lets stay inside it.
    Expr alone(const Expr& e) {
        Sequence sequence;
        std::swap(sequence, now_);
        Expr out = mutate(e);
        std::swap(sequence, now_);
        for (auto item = sequence.items.rbegin(); item != sequence.items.rend(); ++item)
            out = internal::Let::make(item->name, item->value, out);
        return out;
    }

    Expr expand(const DeferredValue& value, const std::vector<Expr>& args) {
        std::vector<Expr> reads;
        for (const Expr& arg : args) {
            const Expr changed = mutate(arg);
            const auto* same = changed.as<internal::Broadcast>();
            reads.push_back(bind(same != nullptr ? same->value : changed));
        }
        Known& known = now_.known[value.stage];
        for (size_t k = 0; k < reads.size(); ++k) {
            const auto before = known.reads.find(value.reads[k]);
            // Of other lanes, or of memory that was written since.
            if (before != known.reads.end() && !internal::equal(before->second, reads[k]))
                known = {};
        }
        for (size_t k = 0; k < reads.size(); ++k) {
            const ValueId id = value.reads[k];
            known.reads[id] = reads[k];
            known.values[id] = {value.stage->instrs[id].type, reads[k]};
        }
        return compute_all(*value.stage, value.id, &known.values);
    }

    /// Computes a value and what it needs, the latter just before its first use.
    Expr compute_all(const ir::Stage& stage, ValueId wanted, std::map<ValueId, Value>* values) {
        std::vector<ValueId> open = {wanted};
        while (!open.empty()) {
            const ValueId id = open.back();
            const Instr& instr = stage.instrs[id];
            const auto missing = [&](ValueId arg) { return values->count(arg) == 0; };
            const auto next = std::find_if(instr.args.begin(), instr.args.end(), missing);
            if (missing(id) && next != instr.args.end()) {
                open.push_back(*next);
                continue;
            }
            open.pop_back();
            if (!missing(id)) continue;
            std::vector<Value> args;
            for (const ValueId arg : instr.args)
                args.push_back(values->at(arg));
            Value value = compute(instr, args);
            // Of all that is inside, too: the target feature marks what Halide's passes see.
            if (!internal::is_const(value.expr) && instr.op != Op::kConst)
                value.expr = add_let(Halide::strict_float(value.expr));
            values->emplace(id, value);
        }
        return values->at(wanted).expr;
    }

    static constexpr const char* kPrefix = "openfab";

    const std::shared_ptr<const Deferred> deferred_;
    internal::Scope<Expr> names_;
    Sequence now_;
    size_t lets_ = 0;
};

}  // namespace

Value Deferred::value(const ir::Stage& stage, const std::string& prefix, ValueId id,
                      const std::vector<Value>& known) {
    const Instr& wanted = stage.instrs[id];
    if (known[id].expr.defined()) return known[id];
    if (wanted.op == Op::kConst) return constant_bits(wanted.type, wanted.bits);
    DeferredValue value{&stage, id, {}};
    std::vector<Expr> args;
    std::set<ValueId> seen = {id};
    std::vector<ValueId> open = {id};
    while (!open.empty()) {
        const ValueId next = open.back();
        open.pop_back();
        if (known[next].expr.defined()) {
            value.reads.push_back(next);
            args.push_back(known[next].expr);
            continue;
        }
        for (const ValueId arg : stage.instrs[next].args) {
            if (seen.insert(arg).second) open.push_back(arg);
        }
    }
    // The same value may be asked for before and after some of what it needs is stored.
    const std::string name = fmt::format("{}.{}", prefix, id);
    std::string unique = name;
    for (int k = 1;; ++k) {
        const auto [place, is_new] = values_.emplace(unique, value);
        if (is_new || place->second.reads == value.reads) break;
        unique = fmt::format("{}_{}", name, k);
    }
    return {wanted.type, internal::Call::make(halide_type(wanted.type), unique, args,
                                              internal::Call::PureExtern)};
}

const DeferredValue* Deferred::find(const std::string& name) const {
    const auto found = values_.find(name);
    return found == values_.end() ? nullptr : &found->second;
}

internal::IRMutator* make_expander(std::shared_ptr<const Deferred> deferred) {
    return new Expander(std::move(deferred));
}

}  // namespace openfab::lower
