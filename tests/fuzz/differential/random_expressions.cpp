// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/differential/random_expressions.h"

namespace openfab::testing::random_text {

std::string spelling(const Type& type) {
    static constexpr std::array<const char*, 4> names = {"bool", "int", "uint", "float"};
    const std::string base = names[static_cast<size_t>(type.base)];
    return type.size == 1 ? base : base + std::to_string(type.size);
}

std::string fill(std::string_view format, std::initializer_list<Piece> pieces) {
    std::string out;
    size_t next = 0;
    for (size_t k = 0; k < format.size(); ++k) {
        const char c = format[k];
        if ((c != '{' && c != '}') || (k + 1 < format.size() && format[k + 1] == c)) {
            out += c;
            if (c == '{' || c == '}') ++k;
            continue;
        }
        size_t place = next;
        if (format[k + 1] == '}') {
            ++next;
        } else {
            place = static_cast<size_t>(format[++k] - '0');
        }
        out += pieces.begin()[place].text;
        ++k;
    }
    return out;
}

std::vector<const Variable*> RandomExpressions::variables(bool writable) const {
    std::vector<const Variable*> found;
    for (const Variable& v : scope_) {
        if (v.writable || !writable) found.push_back(&v);
    }
    return found;
}

Type RandomExpressions::random_type() {
    static constexpr std::array<Base, 8> bases = {Base::kFloat, Base::kFloat, Base::kFloat,
                                                  Base::kFloat, Base::kInt,   Base::kInt,
                                                  Base::kUint,  Base::kBool};
    static constexpr std::array<int, 6> sizes = {1, 1, 1, 2, 3, 4};
    return {random_.of(bases), random_.of(sizes)};
}

std::string RandomExpressions::literal(Base base) {
    static constexpr std::array<const char*, 16> floats = {
        "0.0",  "1.0",  "-1.0",  "0.5",   "2.0",          "-0.25",      "3.7",  "100.0",
        "1e-3", "1e30", "-1e30", "1e-42", "3.4028235e38", "16777217.0", "-0.0", "6.2831853"};
    static constexpr std::array<const char*, 10> ints = {
        "0", "1", "-1", "2", "3", "7", "31", "-100", "2147483647", "(-2147483647 - 1)"};
    static constexpr std::array<const char*, 7> uints = {"0u",   "1u",          "2u",         "31u",
                                                         "255u", "2147483648u", "4294967295u"};
    switch (base) {
        case Base::kBool:
            return random_.chance(50) ? "true" : "false";
        case Base::kInt:
            return random_.of(ints);
        case Base::kUint:
            return random_.of(uints);
        case Base::kFloat:
            break;
    }
    return random_.of(floats);
}

/// A value of exactly this type, from what is in scope.
std::string RandomExpressions::leaf(const Type& type) {
    std::vector<std::string> found;
    for (const Variable& v : scope_) {
        if (v.type.base != type.base) continue;
        const std::string value =
            v.array == 0 ? v.name : fill("{}[{}]", {v.name, random_.below(v.array)});
        if (v.type.size == type.size) {
            found.push_back(value);
        } else if (v.type.size > 1) {
            found.push_back(value + swizzle(v.type.size, type.size));
        }
    }
    if (!found.empty() && random_.chance(75))
        return found[static_cast<size_t>(random_.below(static_cast<int>(found.size())))];
    if (type.size == 1) return literal(type.base);
    return construct(type, 0);
}

std::string RandomExpressions::swizzle(int from, int count) {
    std::string out = ".";
    for (int k = 0; k < count; ++k)
        out += "xyzw"[random_.below(from)];
    return out;
}

std::string RandomExpressions::construct(const Type& type, int depth) {
    if (random_.chance(20)) return fill("({}){}", {spelling(type), atom({type.base, 1}, depth)});
    std::string parts;
    for (int k = 0; k < type.size; ++k)
        parts += (k > 0 ? ", " : "") + expression({type.base, 1}, depth - 1);
    return fill("{}({})", {spelling(type), parts});
}

std::string RandomExpressions::atom(const Type& type, int depth) {
    return "(" + expression(type, depth) + ")";
}

std::string RandomExpressions::expression(const Type& type, int depth) {
    if (depth <= 0) return leaf(type);
    const int pick = random_.below(100);
    if (pick < 10) return leaf(type);
    if (pick < 18) {
        // A condition of as many components chooses one by one.
        const Type condition{Base::kBool, random_.chance(40) ? type.size : 1};
        return fill(random_.chance(30) ? "select({}, {}, {})" : "({} ? {} : {})",
                    {expression(condition, depth - 1), expression(type, depth - 1),
                     expression(type, depth - 1)});
    }
    if (pick < 26) {
        const std::string call = helper_call(type, depth);
        if (!call.empty()) return call;
    }
    if (pick < 34 && type.size > 1) return construct(type, depth);
    if (pick < 40 && type.size == 1) {
        const Type vector{type.base, 2 + random_.below(3)};
        return fill("{}[{}]", {atom(vector, depth - 1), index(vector.size, depth - 1)});
    }
    if (pick < 46) {
        const std::string element = array_element(type, depth);
        if (!element.empty()) return element;
    }
    switch (type.base) {
        case Base::kBool:
            return boolean(type, depth);
        case Base::kInt:
        case Base::kUint:
            return integer(type, depth);
        case Base::kFloat:
            break;
    }
    return floating(type, depth);
}

/// An index of `count` elements. Out of range only if it cannot fold to a constant, which would
/// be an error: `wild` is an input that nothing changes.
std::string RandomExpressions::index(int count, int depth) {
    if (wild_ && random_.chance(50)) return fill("(wild + {})", {expression(kInt, depth)});
    return fill("({} & {})", {expression(kInt, depth), count >= 4 ? 3 : 1});
}

std::string RandomExpressions::array_element(const Type& type, int depth) {
    std::vector<const Variable*> arrays;
    for (const Variable& v : scope_) {
        if (v.array > 0 && v.type == type) arrays.push_back(&v);
    }
    if (arrays.empty()) return "";
    const Variable& v =
        *arrays[static_cast<size_t>(random_.below(static_cast<int>(arrays.size())))];
    return fill("{}[{}]", {v.name, index(v.array, depth - 1)});
}

std::string RandomExpressions::helper_call(const Type& type, int depth) {
    std::vector<const Helper*> found;
    for (const Helper& h : helpers_) {
        if (h.result == type) found.push_back(&h);
    }
    if (found.empty()) return "";
    const Helper& h = *found[static_cast<size_t>(random_.below(static_cast<int>(found.size())))];
    std::string arguments;
    for (size_t k = 0; k < h.parameters.size(); ++k) {
        if (k > 0) arguments += ", ";
        if (h.last_is_inout && k + 1 == h.parameters.size()) {
            const std::string target = target_of(h.parameters[k]);
            if (target.empty()) return "";
            arguments += target;
        } else {
            arguments += expression(h.parameters[k], depth - 1);
        }
    }
    return fill("{}({})", {h.name, arguments});
}

std::string RandomExpressions::target_of(const Type& type) {
    std::vector<std::string> found;
    for (const Variable* v : variables(true)) {
        if (v->array == 0 && v->type == type) found.push_back(v->name);
    }
    if (found.empty()) return "";
    return found[static_cast<size_t>(random_.below(static_cast<int>(found.size())))];
}

std::string RandomExpressions::boolean(const Type& type, int depth) {
    const Type operand{random_.chance(60)   ? Base::kFloat
                       : random_.chance(50) ? Base::kInt
                                            : Base::kUint,
                       type.size};
    static constexpr std::array<const char*, 6> comparisons = {"<", "<=", ">", ">=", "==", "!="};
    if (random_.chance(20))
        return fill("{}({}, {})", {random_.chance(50) ? "and" : "or", expression(type, depth - 1),
                                   expression(type, depth - 1)});
    switch (random_.below(type.size == 1 ? 7 : 4)) {
        case 0:
            return "!" + atom(type, depth - 1);
        case 1:
            return fill("{}({})", {random_.chance(50) ? "isnan" : "isfinite",
                                   expression({Base::kFloat, type.size}, depth - 1)});
        case 2:
        case 3:
            return fill("({} {} {})", {expression(operand, depth - 1), random_.of(comparisons),
                                       expression(operand, depth - 1)});
        case 4:
            return fill("({} && {})", {expression(kBool, depth - 1), expression(kBool, depth - 1)});
        case 5:
            return fill("({} || {})", {expression(kBool, depth - 1), expression(kBool, depth - 1)});
        default:
            return fill("{}({})", {random_.chance(50) ? "any" : "all",
                                   expression({Base::kBool, 2 + random_.below(3)}, depth - 1)});
    }
}

std::string RandomExpressions::integer(const Type& type, int depth) {
    static constexpr std::array<const char*, 11> operators = {"+", "-", "*",  "/",  "%", "&",
                                                              "|", "^", "<<", ">>", "+"};
    switch (random_.below(8)) {
        case 0:
            return "-" + atom(type, depth - 1);
        case 1:
            return "~" + atom(type, depth - 1);
        case 2:
            return fill("{}({}, {})", {random_.chance(50) ? "min" : "max",
                                       expression(type, depth - 1), expression(type, depth - 1)});
        case 3:
            if (type.base == Base::kInt) return fill("abs({})", {expression(type, depth - 1)});
            return fill("clamp({}, {}, {})",
                        {expression(type, depth - 1), expression(type, depth - 1),
                         expression(type, depth - 1)});
        case 4: {
            const Type from{random_.chance(60)        ? Base::kFloat
                            : random_.chance(50)      ? Base::kBool
                            : type.base == Base::kInt ? Base::kUint
                                                      : Base::kInt,
                            type.size};
            return fill("({}){}", {spelling(type), atom(from, depth - 1)});
        }
        default:
            return fill("({} {} {})", {expression(type, depth - 1), random_.of(operators),
                                       expression(type, depth - 1)});
    }
}

std::string RandomExpressions::floating(const Type& type, int depth) {
    static constexpr std::array<const char*, 15> unary = {
        "abs", "floor",    "ceil",    "round",   "trunc", "frac", "sqrt", "rsqrt",
        "rcp", "saturate", "radians", "degrees", "sin",   "exp",  "log"};
    static constexpr std::array<const char*, 5> binary = {"min", "max", "fmod", "step", "pow"};
    static constexpr std::array<const char*, 4> ternary = {"lerp", "clamp", "mad", "smoothstep"};
    static constexpr std::array<const char*, 6> operators = {"+", "-", "*", "/", "%", "*"};
    switch (random_.below(type.size == 1 ? 11 : 9)) {
        case 0:
            return "-" + atom(type, depth - 1);
        case 1:
        case 2:
            return fill("{}({})", {random_.of(unary), expression(type, depth - 1)});
        case 3:
            return fill("{}({}, {})", {random_.of(binary), expression(type, depth - 1),
                                       expression(type, depth - 1)});
        case 4:
            return fill("{}({}, {}, {})",
                        {random_.of(ternary), expression(type, depth - 1),
                         expression(type, depth - 1), expression(type, depth - 1)});
        case 5: {
            const Type from{random_.chance(40)   ? Base::kInt
                            : random_.chance(50) ? Base::kUint
                                                 : Base::kBool,
                            type.size};
            return fill("({}){}", {spelling(type), atom(from, depth - 1)});
        }
        case 9:
            return fill("{}({}, {})", {random_.chance(50) ? "dot" : "distance",
                                       expression({Base::kFloat, 3}, depth - 1),
                                       expression({Base::kFloat, 3}, depth - 1)});
        case 10:
            return random_.chance(50)
                       ? fill("noise({})", {expression({Base::kFloat, 3}, depth - 1)})
                       : fill("hash({})", {expression(kInt, depth - 1)});
        default:
            return fill("({} {} {})", {expression(type, depth - 1), random_.of(operators),
                                       expression(type, depth - 1)});
    }
}

}  // namespace openfab::testing::random_text
