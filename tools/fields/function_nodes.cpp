// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/fields/function_nodes.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <string_view>

#include "abi/fablet_table.h"
#include "tools/fields/messages.h"

namespace openfab::tools {

namespace {

using ir::Op;
using ir::Type;

/// Programs that read such files take a text of nodes, which none wants larger.
constexpr size_t kMostNodes = 50'000;
/// Numbers of integers are exact as floats up to here.
constexpr float kMostInteger = 1 << 24;

struct Node {
    const char* kind = nullptr;     ///< null: none does the operation
    bool may_be_undefined = false;  ///< for some numbers that are defined
};

/// The node that does an operation of floats. What is put together of several is defined wherever its arguments are.
Node node_of(Op op) {
    switch (op) {
        case Op::kAdd:
            return {"addition"};
        case Op::kSub:
            return {"subtraction"};
        case Op::kMul:
            return {"multiplication"};
        case Op::kDiv:
            return {"division", true};
        case Op::kMod:
            return {"fmod", true};
        case Op::kMin:
            return {"min"};
        case Op::kMax:
            return {"max"};
        case Op::kAbs:
            return {"abs"};
        case Op::kSqrt:
            return {"sqrt", true};
        case Op::kFloor:
            return {"floor"};
        case Op::kCeil:
            return {"ceil"};
        case Op::kRound:
            return {"round"};
        case Op::kSin:
            return {"sin"};
        case Op::kCos:
            return {"cos"};
        case Op::kTan:
            return {"tan", true};
        case Op::kAsin:
            return {"arcsin", true};
        case Op::kAcos:
            return {"arccos", true};
        case Op::kAtan:
            return {"arctan"};
        case Op::kAtan2:
            return {"arctan2"};
        case Op::kSinh:
            return {"sinh"};
        case Op::kCosh:
            return {"cosh"};
        case Op::kTanh:
            return {"tanh"};
        case Op::kExp:
            return {"exp"};
        case Op::kLog:
            return {"log", true};
        case Op::kLog2:
            return {"log2", true};
        case Op::kLog10:
            return {"log10", true};
        case Op::kPow:
            return {"pow", true};
        case Op::kNeg:
        case Op::kTrunc:
        case Op::kIsNan:
        case Op::kExp2:
        case Op::kCbrt:
            OPENFAB_IR_CASES(LEAVES)
            OPENFAB_IR_CASES(BITS)
            OPENFAB_IR_CASES(LOGIC)
            OPENFAB_IR_CASES(COMPARISONS)
            OPENFAB_IR_CASES(CHOICES)
            OPENFAB_IR_CASES(LOOKUPS)
            OPENFAB_IR_CASES(CONTROL)
            OPENFAB_IR_CASES(HASHES)
            OPENFAB_IR_CASES(NOISES)
            OPENFAB_IR_CASES(DERIVATIVES)
            return {};
    }
    return {};
}

/// A condition, which decides between two values and is a number only where it is asked for one.
bool decides(const IrLine& line) {
    switch (line.op) {
        OPENFAB_IR_CASES(LOGIC)
        OPENFAB_IR_CASES(COMPARISONS)
        case Op::kIsNan:
            return true;
        default:
            return false;  // a number, or what is refused
    }
}

/// What a user calls an operation that no node does.
std::string called(const IrLine& line) {
    switch (line.op) {
        OPENFAB_IR_CASES(NOISES)
        return messages::kUsesNoise;
        OPENFAB_IR_CASES(DERIVATIVES)
        return messages::kAsksDerivative;
        OPENFAB_IR_CASES(HASHES)
        return messages::kUsesRandomNumbers;
        case Op::kSample:
        case Op::kSampleBound:
            return messages::kLooksUpTexture;
        case Op::kLoop:
        case Op::kLoopVar:
        case Op::kLoopEnd:
        case Op::kLoopResult:
            return messages::kVaryingLoop;
        case Op::kQuery:
        case Op::kQueryResult:
            return messages::kAsksNearestPoint;
        default:
            return messages::kCalculatesWithBits;
    }
}

std::string called_input(const std::string& input) {
    if (input == "distance" || input.starts_with("shape_distance")) return messages::kAsksDistance;
    if (input.starts_with("nearest")) return messages::kReadsAttributes;
    if (input == "instance") return messages::kDependsOnPlacement;
    if (input == "frame") return messages::kDependsOnVoxels;
    return fmt::format(messages::kReadsThePrints, input);
}

NodeValue number(float x) {
    return {true, x, {}, false};
}

}  // namespace

void FunctionNodes::fail(const std::string& what) {
    if (fault_.empty()) fault_ = what;
}

std::string FunctionNodes::ref(const NodeValue& value) {
    if (!value.is_number) return value.ref;
    std::string& known = constants_[std::bit_cast<uint32_t>(value.number)];
    if (!known.empty()) return known;
    if (!std::isfinite(value.number)) fail(messages::kFunctionNumberNotFinite);
    const std::string name = fmt::format("c{}", constants_.size());
    fmt::format_to(std::back_inserter(nodes_),
                   "<i:constant identifier=\"{}\" value=\"{}\"><i:out><i:scalar "
                   "identifier=\"value\"/></i:out></i:constant>\n",
                   name, value.number);
    ++count_;
    return known = name + ".value";
}

NodeValue FunctionNodes::node(const char* kind,
                              const std::vector<std::pair<const char*, NodeValue>>& inputs) {
    std::string in;
    for (const auto& [name, from] : inputs)
        in += fmt::format("<i:scalarref identifier=\"{}\" ref=\"{}\"/>", name, ref(from));
    const auto [it, is_new] = known_.try_emplace(kind + in);
    if (!is_new) return it->second;
    const std::string name = fmt::format("n{}", known_.size());
    fmt::format_to(std::back_inserter(nodes_),
                   "<i:{0} identifier=\"{1}\"><i:in>{2}</i:in><i:out><i:scalar "
                   "identifier=\"result\"/></i:out></i:{0}>\n",
                   kind, name, in);
    if (++count_ > kMostNodes) fail(fmt::format(messages::kTooManyNodes, kMostNodes));
    return it->second = {false, 0, name + ".result", false};
}

NodeValue FunctionNodes::unary(const char* kind, const NodeValue& a) {
    return node(kind, {{"A", a}});
}

NodeValue FunctionNodes::binary(const char* kind, const NodeValue& a, const NodeValue& b) {
    const std::string_view of = kind;
    if (a.is_number && b.is_number) {
        if (of == "addition") return number(a.number + b.number);
        if (of == "subtraction") return number(a.number - b.number);
        if (of == "multiplication") return number(a.number * b.number);
        if (of == "division") return number(a.number / b.number);
        if (of == "min") return number(a.number < b.number ? a.number : b.number);
        if (of == "max") return number(a.number > b.number ? a.number : b.number);
    }
    // What leaves a number as it is, but for the sign of a 0.
    if (of == "addition" && a.is(0)) return b;
    if ((of == "addition" || of == "subtraction") && b.is(0)) return a;
    if (of == "multiplication" && a.is(1)) return b;
    if ((of == "multiplication" || of == "division") && b.is(1)) return a;
    return node(kind, {{"A", a}, {"B", b}});
}

NodeValue FunctionNodes::vector(const std::array<NodeValue, 3>& parts) {
    std::string in;
    for (size_t i = 0; i < parts.size(); ++i)
        in += fmt::format("<i:scalarref identifier=\"{}\" ref=\"{}\"/>", "xyz"[i], ref(parts[i]));
    const std::string name = fmt::format("v{}", ++count_);
    fmt::format_to(std::back_inserter(nodes_),
                   "<i:composevector identifier=\"{}\"><i:in>{}</i:in><i:out><i:vector "
                   "identifier=\"result\"/></i:out></i:composevector>\n",
                   name, in);
    return {false, 0, name + ".result", true};
}

NodeValue FunctionNodes::select(const NodeValue& a, const NodeValue& b, const NodeValue& c,
                                const NodeValue& d) {
    if (a.is_number && b.is_number) return a.number < b.number ? c : d;
    if (c.is_number && d.is_number && c.number == d.number) return c;
    return node("select", {{"A", a}, {"B", b}, {"C", c}, {"D", d}});
}

NodeValue FunctionNodes::coordinate(int32_t axis, bool scaled) {
    constexpr const char* kAxes[] = {"x", "y", "z"};
    const auto index = static_cast<size_t>(std::clamp(axis, 0, 2));
    const auto [it, is_new] = known_.try_emplace("pos");
    if (is_new) {
        nodes_ +=
            "<i:decomposevector identifier=\"point\"><i:in><i:vectorref identifier=\"A\" "
            "ref=\"inputs.pos\"/></i:in><i:out><i:scalar identifier=\"x\"/><i:scalar "
            "identifier=\"y\"/><i:scalar identifier=\"z\"/></i:out></i:decomposevector>\n";
        ++count_;
    }
    const NodeValue plain{false, 0, fmt::format("point.{}", kAxes[index]), false};
    return scaled ? binary("multiplication", plain, number(static_cast<float>(place_.scale[index])))
                  : plain;
}

/// The voxel that a volume stage is at has the function's point as its coordinates.
NodeValue FunctionNodes::frame(int32_t index) const {
    if (index < OPENFAB_FRAME_ORIGIN) return number(index % 4 == 0 ? 1 : 0);
    return number(0);
}

/// An integer, if a float can say it and its neighbours.
NodeValue FunctionNodes::whole(Type type, uint32_t bits) {
    const double exact = type == Type::kInt ? static_cast<double>(static_cast<int32_t>(bits))
                                            : static_cast<double>(bits);
    if (std::fabs(exact) > static_cast<double>(kMostInteger)) fail(messages::kCalculatesWithBits);
    return number(static_cast<float>(exact));
}

/// Whether a line's value is within these bounds wherever the function is asked; roundings of floats may add a little.
bool FunctionNodes::is_within(uint32_t index, double lo, double hi) {
    constexpr double kRounding = 1 + 1e-5;
    const std::vector<bool>& undefined = all_undefined();
    if (bounds_.empty()) bounds_ = stage_bounds(*stage_, uniforms_, place_, undefined);
    const ValueBounds& of = bounds_[index];
    return of.lo * kRounding >= lo && of.hi * kRounding <= hi;
}

NodeValue FunctionNodes::input(const IrLine& line) {
    const int32_t which = line.numbers.empty() ? 0 : line.numbers[0];
    const std::string& of = line.input;
    if (of == "uniform" && which >= 0 && static_cast<size_t>(which) < uniforms_.size()) {
        const uint32_t bits = uniforms_[static_cast<size_t>(which)];
        if (line.type == Type::kFloat) return number(std::bit_cast<float>(bits));
        return whole(line.type, bits);
    }
    if (of == "shape_point") return coordinate(which, false);
    if (of == "voxel_coord") return coordinate(which, true);
    if (of == "frame" && which < OPENFAB_FRAME_VOXEL_SIZE) return frame(which);
    if (of == "distance" && distance_) return *distance_;
    fail(called_input(of));
    return {};
}

NodeValue FunctionNodes::value(uint32_t index) {
    return decides(stage_->lines[index]) ? choose(index, number(1), number(0)) : values_[index];
}

/// By line, whether its value may be undefined: a node compares with `<` alone, which is then false.
const std::vector<bool>& FunctionNodes::all_undefined() {
    if (!undefined_.empty()) return undefined_;
    for (const IrLine& one : stage_->lines) {
        const bool any = std::ranges::any_of(
            one.args, [&](uint32_t a) { return a < undefined_.size() && undefined_[a]; });
        // Integers and truths always are something.
        undefined_.push_back(one.type == Type::kFloat && (any || node_of(one.op).may_be_undefined));
    }
    return undefined_;
}

bool FunctionNodes::may_be_undefined(uint32_t index) {
    return all_undefined()[index];
}

/// `same` where two values that are neither less nor more are equal, `other` where one is undefined.
NodeValue FunctionNodes::if_equal(const IrLine& c, const NodeValue& same, const NodeValue& other) {
    if (!may_be_undefined(c.args[0]) && !may_be_undefined(c.args[1])) return same;
    return select(binary("subtraction", value(c.args[0]), value(c.args[1])), number(1), same,
                  other);
}

NodeValue FunctionNodes::choose(uint32_t condition, const NodeValue& yes, const NodeValue& no) {
    const IrLine& c = stage_->lines[condition];
    const auto arg = [&](size_t i) { return value(c.args[i]); };
    if (c.op == Op::kLt) return select(arg(0), arg(1), yes, no);
    if (c.op == Op::kGt) return select(arg(1), arg(0), yes, no);
    const bool or_equal = c.op == Op::kGe || c.op == Op::kLe;
    if (or_equal && (may_be_undefined(c.args[0]) || may_be_undefined(c.args[1]))) {
        const NodeValue less = arg(c.op == Op::kGe ? 0 : 1), more = arg(c.op == Op::kGe ? 1 : 0);
        return select(more, less, yes, select(less, more, no, if_equal(c, yes, no)));
    }
    if (c.op == Op::kGe) return select(arg(0), arg(1), no, yes);
    if (c.op == Op::kLe) return select(arg(1), arg(0), no, yes);
    if (c.op == Op::kEq || c.op == Op::kNe) {
        const NodeValue& same = c.op == Op::kEq ? yes : no;
        const NodeValue& other = c.op == Op::kEq ? no : yes;
        return select(arg(0), arg(1), other,
                      select(arg(1), arg(0), other, if_equal(c, same, other)));
    }
    if (c.op == Op::kNot) return choose(c.args[0], no, yes);
    if (c.op == Op::kAnd) return choose(c.args[0], choose(c.args[1], yes, no), no);
    if (c.op == Op::kOr) return choose(c.args[0], yes, choose(c.args[1], yes, no));
    // Not a number is neither less than one nor more than none.
    if (c.op == Op::kIsNan)
        return select(arg(0), number(1), no, select(number(0), arg(0), no, yes));
    return select(number(0.5F), value(condition), yes, no);
}

/// The element that an index names, the nearest one where it names none.
NodeValue FunctionNodes::pick(const IrLine& line) {
    const NodeValue index = value(line.args[0]);
    NodeValue out = value(line.args.back());
    for (size_t i = line.args.size() - 2; i >= 1; --i)
        out = select(index, number(static_cast<float>(i) - 0.5F), value(line.args[i]), out);
    return out;
}

NodeValue FunctionNodes::line(uint32_t index) {
    const IrLine& line = stage_->lines[index];
    const auto arg = [&](size_t i) { return value(line.args[i]); };
    const bool is_float = line.type == Type::kFloat;
    if (line.op == Op::kConst) {
        return is_float ? number(std::bit_cast<float>(line.bits)) : whole(line.type, line.bits);
    }
    if (line.op == Op::kInput) return input(line);
    if (line.op == Op::kSelect) return choose(line.args[0], arg(1), arg(2));
    if (line.op == Op::kPick) return pick(line);
    if (line.op == Op::kConvert) {
        const Type from = stage_->lines[line.args[0]].type;
        if (line.type == Type::kBool) return choose(line.args[0], number(1), number(0));
        // A negative number becomes one near 2^32.
        if (line.type == Type::kUint && !is_within(line.args[0], 0, 0x1p32))
            fail(messages::kCalculatesWithBits);
        if (is_float || from != Type::kFloat) return arg(0);
        if (line.type == Type::kInt && !is_within(line.args[0], -0x1p31, 0x1p31))
            fail(messages::kCalculatesWithBits);
        const NodeValue cut =
            select(arg(0), number(0), unary("ceil", arg(0)), unary("floor", arg(0)));
        // What is undefined is 0.
        if (!may_be_undefined(line.args[0])) return cut;
        return select(arg(0), number(0), cut, select(number(0), arg(0), cut, number(0)));
    }
    if (line.type == Type::kBool) {
        fail(called(line));
        return {};
    }
    if (line.op == Op::kTrunc)
        return select(arg(0), number(0), unary("ceil", arg(0)), unary("floor", arg(0)));
    if (line.op == Op::kNeg && line.type != Type::kUint)
        return binary("multiplication", arg(0), number(-1));
    if (line.op == Op::kExp2) return binary("pow", number(2), arg(0));
    if (line.op == Op::kCbrt)
        return binary("multiplication", unary("sign", arg(0)),
                      binary("pow", unary("abs", arg(0)), number(1.0F / 3.0F)));
    const char* const kind = node_of(line.op).kind;
    if (kind != nullptr && line.args.size() == 2) {
        // Quotients of integers are cut, and unsigned ones wrap at 0.
        const bool exact = is_float || line.op == Op::kMin || line.op == Op::kMax ||
                           (line.type == Type::kInt &&
                            (line.op == Op::kAdd || line.op == Op::kSub || line.op == Op::kMul));
        // What wraps, or needs more digits than a number of a function has: sums and products of hashes.
        if (!is_float && !is_within(index, -kMostInteger, kMostInteger))
            fail(messages::kCalculatesWithBits);
        if (is_float && (line.op == Op::kMin || line.op == Op::kMax) &&
            may_be_undefined(line.args[0])) {
            // The second one where the first is undefined; a node has no value there.
            const bool less = line.op == Op::kMin;
            return select(arg(less ? 0 : 1), arg(less ? 1 : 0), arg(0), arg(1));
        }
        if (exact) return binary(kind, arg(0), arg(1));
    }
    if (kind != nullptr && line.args.size() == 1 && (is_float || line.op == Op::kAbs))
        return unary(kind, arg(0));
    fail(called(line));
    return {};
}

Result<std::vector<NodeValue>> FunctionNodes::add(const IrStage& stage,
                                                  const std::vector<uint32_t>& outputs,
                                                  const std::optional<NodeValue>& distance) {
    stage_ = &stage;
    undefined_.clear();
    bounds_.clear();
    distance_ = distance;
    std::vector<bool> needed(stage.lines.size(), false);
    for (const uint32_t one : outputs)
        needed[one] = true;
    for (size_t i = stage.lines.size(); i-- > 0;) {
        if (!needed[i]) continue;
        for (const uint32_t a : stage.lines[i].args)
            needed[a] = true;
    }
    values_.assign(stage.lines.size(), {});
    for (size_t i = 0; i < stage.lines.size() && fault_.empty(); ++i) {
        if (needed[i] && !decides(stage.lines[i])) values_[i] = line(static_cast<uint32_t>(i));
    }
    if (!fault_.empty()) return user_error(fault_);
    std::vector<NodeValue> out;
    out.reserve(outputs.size());
    for (const uint32_t one : outputs)
        out.push_back(value(one));
    return out;
}

std::string FunctionNodes::text(int id, const std::string& name,
                                const std::vector<std::pair<std::string, NodeValue>>& outputs) {
    std::string out;
    for (const auto& [port, from] : outputs)
        out += fmt::format("<i:{}ref identifier=\"{}\" ref=\"{}\"/>",
                           from.is_vector ? "vector" : "scalar", port, ref(from));
    return fmt::format(
        "<i:implicitfunction id=\"{}\" displayname=\"{}\"><i:in><i:vector "
        "identifier=\"pos\"/></i:in>\n{}<i:out>{}</i:out></i:implicitfunction>\n",
        id, name, nodes_, out);
}

}  // namespace openfab::tools
