// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/differential/random_fablet.h"

#include <array>
#include <utility>

#include "tests/fuzz/differential/random_expressions.h"

namespace openfab::testing {

namespace random_text {

namespace {

class Writer : RandomExpressions {
  public:
    explicit Writer(uint64_t seed) : RandomExpressions(seed), real_loops_(seed % 8 == 0) {}

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

    /// Loops with a voxel-dependent number of iterations: each splits the stage into more kernels,
    /// which dominate compile time, so only some fablets have them.
    bool real_loops_;
    std::string out_;
    std::vector<size_t> marks_;
    Type result_;
    int names_ = 0;
    int indent_ = 0;
    int loops_ = 0;
};

}  // namespace

}  // namespace random_text

std::string random_fablet(uint64_t seed) {
    return random_text::Writer(seed).run();
}

}  // namespace openfab::testing
