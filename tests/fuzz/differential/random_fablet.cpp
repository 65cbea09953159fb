// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/differential/random_fablet.h"

#include <array>
#include <initializer_list>
#include <string_view>
#include <utility>

namespace openfab::testing {

namespace {

enum class Base { kBool, kInt, kUint, kFloat };

struct Type {
    Base base = Base::kFloat;
    int size = 1;
    bool operator==(const Type&) const = default;
};

constexpr Type kBool{Base::kBool, 1}, kInt{Base::kInt, 1}, kFloat{Base::kFloat, 1};

std::string spelling(const Type& type) {
    static constexpr std::array<const char*, 4> names = {"bool", "int", "uint", "float"};
    const std::string base = names[static_cast<size_t>(type.base)];
    return type.size == 1 ? base : base + std::to_string(type.size);
}

/// SplitMix64 (Steele, Lea, Flood 2014): the same numbers on every system.
class Random {
  public:
    explicit Random(uint64_t seed) : state_(seed) {}
    uint64_t bits() {
        uint64_t z = (state_ += 0x9e3779b97f4a7c15u);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return z ^ (z >> 31);
    }
    int below(int n) { return static_cast<int>(bits() % static_cast<uint64_t>(n)); }
    bool chance(int percent) { return below(100) < percent; }
    template <typename T, size_t N>
    const T& of(const std::array<T, N>& choices) {
        return choices[static_cast<size_t>(below(static_cast<int>(N)))];
    }

  private:
    uint64_t state_;
};

/// A part of a text.
struct Piece {
    std::string text;
    Piece(std::string value) : text(std::move(value)) {}
    Piece(const char* value) : text(value) {}
    Piece(int value) : text(std::to_string(value)) {}
};

/// Replaces `{}` or `{k}` in `format` by pieces, `{{` and `}}` by braces. Not fmt::format, whose
/// arguments, and with them the random choices, may be evaluated in any order; a braced list is
/// evaluated from left to right.
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

struct Variable {
    std::string name;
    Type type;
    int array = 0;  ///< elements; 0: no array
    bool writable = true;
};

struct Helper {
    std::string name;
    Type result;
    std::vector<Type> parameters;
    bool last_is_inout = false;
};

class Writer {
  public:
    explicit Writer(uint64_t seed) : random_(seed), real_loops_(seed % 8 == 0) {}

    std::string run() {
        out_ =
            "fablet Random {\n    @uniform {\n        float scale = 1.5;\n"
            "        int3 counts = int3(2, 3, -5);\n"
            "        float table[5] = {0.5, -2.0, 3.25, 0.0, 1e20};\n";
        // Of more than a few elements a varying index loads one.
        list("        ", "float wide[40]", 40, ";");
        list("        ", "int many[24]", 24, ";");
        list("        ", "float3 points[12]", 36, ";");
        for (int k = 0; k < kProgramsPerFablet; ++k)
            out_ += fill("        Material m{};\n", {k});
        out_ +=
            "    }\n    struct Pair { float a; int2 b; float3 c[2]; };\n"
            "    enum Kind { FIRST, SECOND = 5, THIRD };\n";
        list("    static const ", "float fixed[20]", 20, ";");
        list("    static const ", "int2 steps[10]", 20, ";");
        for (int k = 0; k < 4; ++k)
            write_helper();
        for (int k = 0; k < kProgramsPerFablet; ++k)
            write_program(k);
        out_ +=
            "    @Volume(@varying { VolumeAttributes attr, @nearest float4 f, @nearest int2 i }) "
            "{\n"
            "        float d = distance(attr.voxelCenter);\n"
            "        MaterialComposition mc;\n";
        for (int k = 0; k < kProgramsPerFablet; ++k)
            out_ +=
                fill("        mc.Set(m{0}, program{0}(f, i, i.y, d, attr.voxelCenter));\n", {k});
        out_ += "        return mc;\n    }\n}\n";
        return std::move(out_);
    }

  private:
    // --- names and scopes

    std::string fresh(const char* stem) { return fill("{}{}", {stem, names_++}); }

    void line(const std::string& text) {
        out_.append(static_cast<size_t>(4 * (indent_ + 1)), ' ');
        out_ += text + "\n";
    }

    void open(const std::string& text) {
        line(text);
        ++indent_;
        marks_.push_back(scope_.size());
    }
    void close(const std::string& text = "}") {
        scope_.resize(marks_.back());
        marks_.pop_back();
        --indent_;
        line(text);
    }

    std::vector<const Variable*> variables(bool writable) const {
        std::vector<const Variable*> found;
        for (const Variable& v : scope_) {
            if (v.writable || !writable) found.push_back(&v);
        }
        return found;
    }

    Type random_type() {
        static constexpr std::array<Base, 8> bases = {Base::kFloat, Base::kFloat, Base::kFloat,
                                                      Base::kFloat, Base::kInt,   Base::kInt,
                                                      Base::kUint,  Base::kBool};
        static constexpr std::array<int, 6> sizes = {1, 1, 1, 2, 3, 4};
        return {random_.of(bases), random_.of(sizes)};
    }

    // --- expressions

    std::string literal(Base base) {
        static constexpr std::array<const char*, 16> floats = {
            "0.0",  "1.0",  "-1.0",  "0.5",   "2.0",          "-0.25",      "3.7",  "100.0",
            "1e-3", "1e30", "-1e30", "1e-42", "3.4028235e38", "16777217.0", "-0.0", "6.2831853"};
        static constexpr std::array<const char*, 10> ints = {
            "0", "1", "-1", "2", "3", "7", "31", "-100", "2147483647", "(-2147483647 - 1)"};
        static constexpr std::array<const char*, 7> uints = {
            "0u", "1u", "2u", "31u", "255u", "2147483648u", "4294967295u"};
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
    std::string leaf(const Type& type) {
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

    std::string swizzle(int from, int count) {
        std::string out = ".";
        for (int k = 0; k < count; ++k)
            out += "xyzw"[random_.below(from)];
        return out;
    }

    std::string construct(const Type& type, int depth) {
        if (random_.chance(20))
            return fill("({}){}", {spelling(type), atom({type.base, 1}, depth)});
        std::string parts;
        for (int k = 0; k < type.size; ++k)
            parts += (k > 0 ? ", " : "") + expression({type.base, 1}, depth - 1);
        return fill("{}({})", {spelling(type), parts});
    }

    std::string atom(const Type& type, int depth) { return "(" + expression(type, depth) + ")"; }

    std::string expression(const Type& type, int depth) {
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
    std::string index(int count, int depth) {
        if (wild_ && random_.chance(50)) return fill("(wild + {})", {expression(kInt, depth)});
        return fill("({} & {})", {expression(kInt, depth), count >= 4 ? 3 : 1});
    }

    std::string array_element(const Type& type, int depth) {
        std::vector<const Variable*> arrays;
        for (const Variable& v : scope_) {
            if (v.array > 0 && v.type == type) arrays.push_back(&v);
        }
        if (arrays.empty()) return "";
        const Variable& v =
            *arrays[static_cast<size_t>(random_.below(static_cast<int>(arrays.size())))];
        return fill("{}[{}]", {v.name, index(v.array, depth - 1)});
    }

    std::string helper_call(const Type& type, int depth) {
        std::vector<const Helper*> found;
        for (const Helper& h : helpers_) {
            if (h.result == type) found.push_back(&h);
        }
        if (found.empty()) return "";
        const Helper& h =
            *found[static_cast<size_t>(random_.below(static_cast<int>(found.size())))];
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

    std::string target_of(const Type& type) {
        std::vector<std::string> found;
        for (const Variable* v : variables(true)) {
            if (v->array == 0 && v->type == type) found.push_back(v->name);
        }
        if (found.empty()) return "";
        return found[static_cast<size_t>(random_.below(static_cast<int>(found.size())))];
    }

    std::string boolean(const Type& type, int depth) {
        const Type operand{random_.chance(60)   ? Base::kFloat
                           : random_.chance(50) ? Base::kInt
                                                : Base::kUint,
                           type.size};
        static constexpr std::array<const char*, 6> comparisons = {"<",  "<=", ">",
                                                                   ">=", "==", "!="};
        if (random_.chance(20))
            return fill("{}({}, {})", {random_.chance(50) ? "and" : "or",
                                       expression(type, depth - 1), expression(type, depth - 1)});
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
                return fill("({} && {})",
                            {expression(kBool, depth - 1), expression(kBool, depth - 1)});
            case 5:
                return fill("({} || {})",
                            {expression(kBool, depth - 1), expression(kBool, depth - 1)});
            default:
                return fill("{}({})", {random_.chance(50) ? "any" : "all",
                                       expression({Base::kBool, 2 + random_.below(3)}, depth - 1)});
        }
    }

    std::string integer(const Type& type, int depth) {
        static constexpr std::array<const char*, 11> operators = {"+", "-", "*",  "/",  "%", "&",
                                                                  "|", "^", "<<", ">>", "+"};
        switch (random_.below(8)) {
            case 0:
                return "-" + atom(type, depth - 1);
            case 1:
                return "~" + atom(type, depth - 1);
            case 2:
                return fill("{}({}, {})",
                            {random_.chance(50) ? "min" : "max", expression(type, depth - 1),
                             expression(type, depth - 1)});
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

    std::string floating(const Type& type, int depth) {
        static constexpr std::array<const char*, 15> unary = {
            "abs", "floor",    "ceil",    "round",   "trunc", "frac", "sqrt", "rsqrt",
            "rcp", "saturate", "radians", "degrees", "sin",   "exp",  "log"};
        static constexpr std::array<const char*, 5> binary = {"min", "max", "fmod", "step", "pow"};
        static constexpr std::array<const char*, 4> ternary = {"lerp", "clamp", "mad",
                                                               "smoothstep"};
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

    // --- statements

    void declare() {
        const Type type = random_type();
        if (random_.chance(15)) {
            const int count = 2 + random_.below(4);
            const std::string name = fresh("a");
            std::string values;
            for (int k = 0; k < count; ++k)
                values += (k > 0 ? ", " : "") + expression(type, 1);
            line(fill("{} {}[{}] = {{{}}};", {spelling(type), name, count, values}));
            scope_.push_back({name, type, count, true});
            return;
        }
        const std::string name = fresh("v");
        line(fill("{} {} = {};", {spelling(type), name, expression(type, 3)}));
        scope_.push_back({name, type, 0, true});
    }

    void assign() {
        const std::vector<const Variable*> targets = variables(true);
        if (targets.empty()) return declare();
        const Variable v =
            *targets[static_cast<size_t>(random_.below(static_cast<int>(targets.size())))];
        std::string target = v.name;
        Type type = v.type;
        if (v.array > 0) target += fill("[{}]", {index(v.array, 1)});
        if (type.size > 1 && random_.chance(30)) {
            if (random_.chance(50)) {
                target += fill("[{}]", {index(type.size, 1)});
                type.size = 1;
            } else {
                target += type.size == 2 ? ".yx" : ".zx";
                type.size = 2;
            }
        }
        static constexpr std::array<const char*, 4> compound = {"=", "+=", "-=", "*="};
        const char* op =
            type.base == Base::kBool || random_.chance(50) ? "=" : random_.of(compound);
        line(fill("{} {} {};", {target, op, expression(type, 3)}));
    }

    void branch(int depth, bool in_loop) {
        open(fill("if ({}) {{", {expression(kBool, 2)}));
        block(depth - 1, in_loop);
        if (random_.chance(50)) {
            scope_.resize(marks_.back());
            --indent_;
            line("} else {");
            ++indent_;
            block(depth - 1, in_loop);
        }
        close();
    }

    void choose(int depth, bool in_loop) {
        open(fill("switch ({}) {{", {expression(kInt, 2)}));
        const int first = random_.below(3) - 1;
        for (int k = 0; k < 3; ++k) {
            open(fill("case {}: {{", {first + k}));
            block(depth - 1, in_loop);
            close();
            line("break;");
        }
        if (random_.chance(60)) {
            open("default: {");
            block(depth - 1, in_loop);
            close();
            line("break;");
        }
        close();
    }

    void repeat(int depth) {
        const std::string counter = fresh("n");
        const int kind = real_loops_ ? random_.below(4) : 0;
        if (kind == 0) {
            open(fill("for (int {0} = 0; {0} < {1}; ++{0}) {{", {counter, 1 + random_.below(4)}));
        } else if (kind == 1) {
            open(fill("for (int {0} = 0; {0} < ({1} & 7); ++{0}) {{",
                      {counter, expression(kInt, 2)}));
        } else if (kind == 2) {
            line(fill("int {} = 0;", {counter}));
            line("@bound(9)");
            open(fill("while ({}) {{", {expression(kBool, 2)}));
            line(fill("{}++;", {counter}));
        } else {
            line(fill("int {} = 0;", {counter}));
            line("@bound(6)");
            open("do {");
            line(fill("{} += 1;", {counter}));
        }
        scope_.push_back({counter, kInt, 0, false});
        block(depth - 1, true);
        scope_.resize(marks_.back());  // a condition at the end sees no declarations of the body
        close(kind == 3 ? fill("}} while ({});", {expression(kBool, 2)}) : "}");
    }

    void block(int depth, bool in_loop) {
        const int count = 1 + random_.below(3);
        for (int k = 0; k < count; ++k)
            statement(depth, in_loop);
    }

    void statement(int depth, bool in_loop) {
        const int pick = random_.below(100);
        if (depth > 0 && pick < 16) return branch(depth, in_loop);
        if (depth > 0 && pick < 24 && loops_ < 2) {
            ++loops_;
            return repeat(depth);
        }
        if (depth > 0 && pick < 29) return choose(depth, in_loop);
        if (in_loop && pick < 34) {
            return line(fill("if ({}) {}",
                             {expression(kBool, 2), random_.chance(50) ? "break;" : "continue;"}));
        }
        if (pick < 38 && depth < 2)
            return line(fill("if ({}) return {};", {expression(kBool, 2), expression(result_, 2)}));
        if (pick < 60) return declare();
        assign();
    }

    void body(const Type& result) {
        result_ = result;
        loops_ = 0;
        block(2, false);
        block(2, false);
        line(fill("return {};", {expression(result, 3)}));
    }

    void write_helper() {
        Helper h;
        h.name = fresh("helper");
        h.result = random_type();
        const int count = 1 + random_.below(3);
        std::string parameters;
        scope_.clear();
        for (int k = 0; k < count; ++k) {
            h.parameters.push_back(random_type());
            const std::string name = fresh("p");
            h.last_is_inout = k + 1 == count && random_.chance(30);
            parameters += fill("{}{}{} {}", {k > 0 ? ", " : "", h.last_is_inout ? "inout " : "",
                                             spelling(h.parameters.back()), name});
            scope_.push_back({name, h.parameters.back(), 0, true});
        }
        open(fill("{} {}({}) {{", {spelling(h.result), h.name, parameters}));
        // A helper has no loops: it is called anywhere, loops of loops included.
        result_ = h.result;
        loops_ = 2;
        block(1, false);
        line(fill("return {};", {expression(h.result, 3)}));
        close();
        helpers_.push_back(std::move(h));
    }

    /// A declaration with so many small numbers.
    void list(const std::string& before, const std::string& declarator, int count,
              const char* after) {
        out_ += before + declarator + " = {";
        for (int k = 0; k < count; ++k)
            out_ += fill(k == 0 ? "{}" : ", {}", {random_.below(9) - 3});
        out_ += std::string("}") + after + "\n";
    }

    void write_program(int k) {
        scope_ = {{"f", {Base::kFloat, 4}, 0, true},
                  {"i", {Base::kInt, 2}, 0, true},
                  {"d", kFloat, 0, true},
                  {"p", {Base::kFloat, 3}, 0, true},
                  {"scale", kFloat, 0, false},
                  {"counts", {Base::kInt, 3}, 0, false},
                  {"table", kFloat, 5, false},
                  {"wide", kFloat, 40, false},
                  {"many", {Base::kInt, 1}, 24, false},
                  {"points", {Base::kFloat, 3}, 12, false},
                  {"fixed", kFloat, 20, false},
                  {"steps", {Base::kInt, 2}, 10, false}};
        open(fill("float program{}(float4 f, int2 i, int wild, float d, float3 p) {{", {k}));
        if (random_.chance(25)) {
            const std::string name = fresh("s");
            if (random_.chance(30)) {
                const std::string pairs = fresh("s");
                line(fill("Pair {}[2] = (Pair[2]){};", {pairs, random_.below(9)}));
                line(fill("Pair {0} = {1}[{2}];", {name, pairs, index(2, 1)}));
            } else {
                line(fill("Pair {};", {name}));
            }
            line(fill("{}.a = {};", {name, expression(kFloat, 2)}));
            line(fill("{}.b = {};", {name, expression({Base::kInt, 2}, 2)}));
            line(fill("{0}.c[0] = {1};", {name, expression({Base::kFloat, 3}, 2)}));
            line(fill("{0}.c[1] = {1};", {name, expression({Base::kFloat, 3}, 2)}));
            scope_.push_back({name + ".a", kFloat, 0, true});
            scope_.push_back({name + ".b", {Base::kInt, 2}, 0, true});
            scope_.push_back({name + ".c", {Base::kFloat, 3}, 2, true});
        }
        wild_ = true;
        body(kFloat);
        close();
    }

    Random random_;
    /// Loops with a voxel-dependent number of iterations: each splits the stage into more kernels,
    /// which dominate compile time, so only some fablets have them.
    bool real_loops_;
    std::string out_;
    std::vector<Variable> scope_;
    std::vector<size_t> marks_;
    std::vector<Helper> helpers_;
    Type result_;
    int names_ = 0;
    int indent_ = 0;
    int loops_ = 0;
    bool wild_ = false;  ///< `wild` is in scope
};

}  // namespace

std::string random_fablet(uint64_t seed) {
    return Writer(seed).run();
}

}  // namespace openfab::testing
