// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/algorithm/deferred.h"

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

/// Loads the elements of a table that an index names, which may be a vector.
Value load_element(const Instr& table, const Value& index, const Halide::ImageParam& values) {
    const int lanes = index.expr.type().lanes();
    const Halide::Type ints = Halide::Int(32, lanes);
    const auto number = [&](const Halide::Type& type, uint32_t value) {
        return internal::make_const(type, static_cast<int64_t>(value));
    };
    Expr at = internal::Min::make(index.expr, number(index.expr.type(), table.bits - 1));
    if (index.type == ir::Type::kInt) at = internal::Max::make(at, number(ints, 0));
    at = Halide::cast(ints, at);
    at = at * number(ints, static_cast<uint32_t>(table.b)) +
         number(ints, static_cast<uint32_t>(table.a));
    const Expr bits =
        internal::Load::make(Halide::UInt(32, lanes), values.name(), at, Halide::Buffer<>(),
                             values.parameter(), internal::const_true(lanes), {});
    const Halide::Type stored = storage_type(table.type).with_lanes(lanes);
    return from_storage(table.type,
                        stored == bits.type() ? bits : Halide::reinterpret(stored, bits));
}

/// Computes one operation from its arguments, which may be vectors.
Value compute(const Instr& instr, const std::vector<Value>& args,
              const Halide::ImageParam& values) {
    switch (instr.op) {
        case Op::kTable:
            return load_element(instr, args[0], values);
        case Op::kConst:
            return constant_bits(instr.type, instr.bits);
        case Op::kConvert:
            return convert(args[0], instr.type);
        case Op::kBitCast:
            return bit_cast(args[0], instr.type);
        case Op::kSelect:
            OPENFAB_IR_CASES(OPERATIONS)
            return operate(instr.op, args);
        case Op::kInput:
        case Op::kSample:
        case Op::kSampleBound:
        case Op::kPick:
            OPENFAB_IR_CASES(CONTROL)
            OPENFAB_IR_CASES(FUNCTIONS)
            OPENFAB_IR_CASES(DERIVATIVES)
            break;  // treated apart, or expanded before
    }
    return args[0];
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

/// The variable that a loop is written out for, if something in it is chosen by that: see
/// Deferred::one_of.
class ChoosesBy : public internal::IRVisitor {
  public:
    ChoosesBy(const Deferred& deferred, const internal::For& loop)
        : deferred_(deferred), name_(loop.name) {
        loop.body.accept(this);
    }
    bool found() const { return found_; }

  private:
    using internal::IRVisitor::visit;

    void visit(const internal::Call* op) override {
        const DeferredValue* value = deferred_.find(op->name);
        if (value != nullptr && !value->choices.empty()) {
            const Expr& first = op->args[0];
            const auto* spread = first.as<internal::Broadcast>();
            const auto* by = (spread != nullptr ? spread->value : first).as<internal::Variable>();
            found_ = found_ || (by != nullptr && by->name == name_);
        }
        IRVisitor::visit(op);
    }

    const Deferred& deferred_;
    const std::string name_;
    bool found_ = false;
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
        } else if (const auto* loop = s.as<internal::For>();
                   loop != nullptr && loop->for_type == internal::ForType::Serial &&
                   ChoosesBy(*deferred_, *loop).found() && append_each(*loop)) {
            return;
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

    /// Writes a loop out, if its trips are known.
    bool append_each(const internal::For& loop) {
        const auto* first = loop.min.as<internal::IntImm>();
        const auto* count = loop.extent.as<internal::IntImm>();
        if (first == nullptr || count == nullptr) return false;
        for (int64_t k = 0; k < count->value; ++k) {
            const Renamed renamed(this, loop.name,
                                  internal::make_const(Halide::Int(32), first->value + k));
            append(loop.body);
        }
        return true;
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
        for (size_t k = 0; k < args.size(); ++k) {
            if (value.reads[k] == ir::kNoValue) {
                reads.emplace_back();
                continue;
            }
            const Expr changed = mutate(args[k]);
            const auto* same = changed.as<internal::Broadcast>();
            reads.push_back(bind(same != nullptr ? same->value : changed));
        }
        Known& known = now_.known[value.stage];
        for (size_t k = 0; k < reads.size(); ++k) {
            if (!reads[k].defined()) continue;
            const auto before = known.reads.find(value.reads[k]);
            // Of other lanes, or of memory that was written since.
            if (before != known.reads.end() && !internal::equal(before->second, reads[k]))
                known = {};
        }
        for (size_t k = 0; k < reads.size(); ++k) {
            if (!reads[k].defined()) continue;
            const ValueId id = value.reads[k];
            known.reads[id] = reads[k];
            known.values[id] = {value.stage->instrs[id].type, reads[k]};
        }
        if (value.choices.empty()) return compute_all(*value.stage, value.id, &known.values);
        return choose(value, mutate(args[0]), &known.values);
    }

    /// Computes the bits of the one of several values that has a number; of all, where the number is
    /// not known.
    Expr choose(const DeferredValue& value, const Expr& number, std::map<ValueId, Value>* values) {
        const auto* spread = number.as<internal::Broadcast>();
        const Expr& at = spread != nullptr ? spread->value : number;
        const auto bits = [&](size_t k) {
            const ValueId id = value.choices[k];
            compute_all(*value.stage, id, values);
            const Expr stored = to_storage(values->at(id));
            const Halide::Type type = Halide::UInt(32, stored.type().lanes());
            return stored.type() == type ? stored : Halide::reinterpret(type, stored);
        };
        if (const auto* known = at.as<internal::IntImm>())
            return bits(static_cast<size_t>(known->value));
        const Expr chosen = bind(number);
        Expr out = bits(value.choices.size() - 1);
        for (size_t k = value.choices.size() - 1; k-- > 0;) {
            Expr one = bits(k);
            const int lanes =
                std::max({chosen.type().lanes(), one.type().lanes(), out.type().lanes()});
            const auto widened = [&](const Expr& e) {
                return e.type().lanes() == lanes ? e : internal::Broadcast::make(e, lanes);
            };
            const Expr by = widened(chosen);
            out = add_let(
                Halide::select(by == internal::make_const(by.type(), static_cast<int64_t>(k)),
                               widened(one), widened(out)));
        }
        return out;
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
            Value value = compute(instr, args, deferred_->object_values());
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

/// Lists what values are computed from, as far as that is known to Halide.
void Deferred::collect_reads(const ir::Stage& stage, std::vector<ValueId> open,
                             const std::vector<Value>& known, DeferredValue* value,
                             std::vector<Expr>* args) const {
    std::set<ValueId> seen(open.begin(), open.end());
    bool loads = false;
    while (!open.empty()) {
        const ValueId next = open.back();
        open.pop_back();
        if (known[next].expr.defined()) {
            value->reads.push_back(next);
            args->push_back(known[next].expr);
            continue;
        }
        loads = loads || stage.instrs[next].op == Op::kTable;
        for (const ValueId arg : stage.instrs[next].args) {
            if (seen.insert(arg).second) open.push_back(arg);
        }
    }
    if (!loads) return;
    // Halide passes on only those buffers that it sees a load of.
    value->reads.push_back(ir::kNoValue);
    args->push_back(object_values_(0));
}

/// Returns the name under which a value is kept. The same value may be asked for before and after
/// some of what it needs is stored.
std::string Deferred::add(const std::string& name, const DeferredValue& value) {
    std::string unique = name;
    for (int k = 1;; ++k) {
        const auto [place, is_new] = values_.emplace(unique, value);
        if (is_new || place->second.reads == value.reads) return unique;
        unique = fmt::format("{}_{}", name, k);
    }
}

Value Deferred::value(const ir::Stage& stage, const std::string& prefix, ValueId id,
                      const std::vector<Value>& known) {
    const Instr& wanted = stage.instrs[id];
    if (known[id].expr.defined()) return known[id];
    if (wanted.op == Op::kConst) return constant_bits(wanted.type, wanted.bits);
    DeferredValue value{&stage, id, {}, {}};
    std::vector<Expr> args;
    collect_reads(stage, {id}, known, &value, &args);
    const std::string name = add(fmt::format("{}.{}", prefix, id), value);
    return {wanted.type,
            internal::Call::make(halide_type(wanted.type), name, args, internal::Call::PureExtern)};
}

Expr Deferred::one_of(const ir::Stage& stage, const std::string& prefix, std::vector<ValueId> ids,
                      const std::vector<Value>& known, const Expr& number) {
    DeferredValue value{&stage, ir::kNoValue, ids, {ir::kNoValue}};
    std::vector<Expr> args = {number};
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
    collect_reads(stage, std::move(ids), known, &value, &args);
    const std::string name = add(fmt::format("{}.all", prefix), value);
    return internal::Call::make(Halide::UInt(32), name, args, internal::Call::PureExtern);
}

const DeferredValue* Deferred::find(const std::string& name) const {
    const auto found = values_.find(name);
    return found == values_.end() ? nullptr : &found->second;
}

internal::IRMutator* make_expander(std::shared_ptr<const Deferred> deferred) {
    return new Expander(std::move(deferred));
}

}  // namespace openfab::lower
