// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// The analysis of what loops assign, compared with running them: random programs fill an array and
// read it in nested loops, up to constants and to values, with conditions, `break` and `continue`.
// A program that reads an element without a value for some values must not be silent; one that
// never does mostly is. OPENFAB_LOOPS: how many programs.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "compiler/frontend/frontend.h"

namespace openfab::testing {
namespace {

enum class Exit { kNone, kBreak, kContinue };

/// Variables: n, k, x, c, then the counters of loops.
constexpr int kN = 0, kK = 1, kX = 2, kC = 3, kFirstCounter = 4;

struct State {
    std::array<int, 32> variables{};
    std::vector<bool> assigned;
    bool read_nothing = false;
};

struct Number {
    std::string text;
    std::function<int(const State&)> value;
};
struct Statement {
    std::string text;
    std::function<Exit(State&)> run;
};

std::string name_of(int variable) {
    if (variable < kFirstCounter) return std::string(1, "nkxc"[variable]);
    return fmt::format("i{}", variable - kFirstCounter);
}

class Generator {
  public:
    explicit Generator(uint64_t seed) : random_(seed), elements_(one_of({4, 6, 8, 9, 12})) {}

    int elements() const { return elements_; }
    Statement loop(int depth, std::vector<int> counters, bool fills);
    int one_of(const std::vector<int>& values) { return values[below(values.size())]; }
    bool chance(int percent) { return static_cast<int>(below(100)) < percent; }

  private:
    size_t below(size_t n) { return random_() % n; }
    Number bound(const std::vector<int>& counters);
    Number index(const std::vector<int>& counters);
    Number condition(const std::vector<int>& counters);
    Statement block(int depth, const std::vector<int>& counters, bool fills);
    Statement access(const std::vector<int>& counters, bool fills);

    std::mt19937_64 random_;
    int elements_;
    int loops_ = 0;
};

Number Generator::bound(const std::vector<int>& counters) {
    const int most = 1 + static_cast<int>(below(5));
    const auto least = [most](int variable) {
        return [=](const State& s) { return std::min(s.variables[variable], most); };
    };
    switch (below(10)) {
        case 0:
        case 1:
        case 2:
        case 3:
            return {fmt::format("{}", most), [=](const State&) { return most; }};
        case 4:
        case 5:
            return {fmt::format("min(n, {})", most), least(kN)};
        case 6:
        case 7:
            return {"c", [](const State& s) { return s.variables[kC]; }};
        case 8:
            return {"(n & 3)", [](const State& s) { return s.variables[kN] & 3; }};
        default:
            break;
    }
    if (counters.empty()) return {fmt::format("min(k, {})", most), least(kK)};
    const int counter = one_of(counters);
    return {name_of(counter), [=](const State& s) { return s.variables[counter]; }};
}

/// A sum of multiples of counters, clamped as every index is.
Number Generator::index(const std::vector<int>& counters) {
    const int offset = one_of({0, 0, 0, 1, -1, 2, elements_ - 1});
    std::vector<std::pair<int, int>> terms;
    std::string text = fmt::format("{}", offset);
    for (const int counter : counters) {
        if (chance(15)) continue;
        terms.emplace_back(counter, one_of({1, 1, 1, 2, 3, 4, -1}));
        text += fmt::format(" + {} * {}", name_of(counter), terms.back().second);
    }
    const int last = elements_ - 1;
    return {text, [=](const State& s) {
                int sum = offset;
                for (const auto& [counter, factor] : terms)
                    sum += s.variables[counter] * factor;
                return std::clamp(sum, 0, last);
            }};
}

Number Generator::condition(const std::vector<int>& counters) {
    std::vector<int> variables = counters;
    variables.insert(variables.end(), {kN, kK, kX});
    const int variable = one_of(variables), number = static_cast<int>(below(5));
    const size_t op = below(4);
    constexpr std::array<const char*, 4> kOps{"<", ">=", "==", ">"};
    return {fmt::format("{} {} {}", name_of(variable), kOps[op], number), [=](const State& s) {
                const int value = s.variables[variable];
                const std::array<bool, 4> holds{
                    value<number, value >= number, value == number, value> number};
                return holds[op] ? 1 : 0;
            }};
}

/// Dear enough for a loop not to be unrolled.
Statement Generator::access(const std::vector<int>& counters, bool fills) {
    const Number at = index(counters);
    const std::string dear = fmt::format("fbm(float3(x + {}), 9) + fbm(float3(x), 9)",
                                         name_of(counters.empty() ? kN : counters.back()));
    if (fills && chance(85)) {
        return {fmt::format("w[{}] = {};", at.text, dear), [=](State& s) {
                    s.assigned[static_cast<size_t>(at.value(s))] = true;
                    return Exit::kNone;
                }};
    }
    return {fmt::format("s += w[{}] + {};", at.text, dear), [=](State& s) {
                if (!s.assigned[static_cast<size_t>(at.value(s))]) s.read_nothing = true;
                return Exit::kNone;
            }};
}

Statement Generator::block(int depth, const std::vector<int>& counters, bool fills) {
    std::vector<Statement> list;
    for (int count = one_of({1, 1, 2}); count > 0; --count) {
        if (depth > 0 && chance(50)) {
            list.push_back(loop(depth, counters, fills));
        } else if (chance(30)) {
            const Number test = condition(counters);
            const Exit exit = chance(50) ? Exit::kBreak : Exit::kContinue;
            list.push_back(
                {fmt::format("if ({}) {};", test.text, exit == Exit::kBreak ? "break" : "continue"),
                 [=](State& s) { return test.value(s) != 0 ? exit : Exit::kNone; }});
        } else if (chance(30)) {
            const Number test = condition(counters);
            const Statement inner = access(counters, fills);
            list.push_back({fmt::format("if ({}) {{ {} }}", test.text, inner.text), [=](State& s) {
                                return test.value(s) != 0 ? inner.run(s) : Exit::kNone;
                            }});
        } else {
            list.push_back(access(counters, fills));
        }
    }
    std::string text;
    for (const Statement& statement : list)
        text += statement.text + " ";
    return {text, [=](State& s) {
                for (const Statement& statement : list) {
                    if (const Exit exit = statement.run(s); exit != Exit::kNone) return exit;
                }
                return Exit::kNone;
            }};
}

Statement Generator::loop(int depth, std::vector<int> counters, bool fills) {
    const Number end = bound(counters);
    const int counter = kFirstCounter + loops_++;
    const int begin = one_of({0, 0, 0, 0, 1}), step = one_of({1, 1, 1, 1, 2});
    const bool closed = chance(15);
    counters.push_back(counter);
    const Statement body = block(depth - 1, counters, fills);
    const std::string name = name_of(counter);
    return {fmt::format("for (int {0} = {1}; {0} {2} {3}; {0} += {4}) {{ {5}}}\n", name, begin,
                        closed ? "<=" : "<", end.text, step, body.text),
            [=](State& s) {
                for (int i = begin; i < end.value(s) + (closed ? 1 : 0); i += step) {
                    s.variables[static_cast<size_t>(counter)] = i;
                    if (body.run(s) == Exit::kBreak) break;
                }
                return Exit::kNone;
            }};
}

/// Runs the loops for many values of the uniforms.
bool reads_nothing(const std::vector<Statement>& loops, int elements, int least_c, int most_c) {
    for (int n = -1; n < 8; ++n) {
        for (int k = -1; k < 6; ++k) {
            for (const int x : {-1, 0, 1, 2, 3, 4, 9}) {
                State state;
                state.variables = {n, k, x, std::clamp(n, least_c, most_c)};
                state.assigned.resize(static_cast<size_t>(elements));
                for (const Statement& loop : loops)
                    loop.run(state);
                if (state.read_nothing) return true;
            }
        }
    }
    return false;
}

TEST(RandomLoops, AreNeverSilentWhereAReadFindsNoValue) {
    const char* asked = std::getenv("OPENFAB_LOOPS");
    const uint64_t programs = asked != nullptr ? std::strtoull(asked, nullptr, 10) : 150;
    int sound = 0, silent = 0;
    for (uint64_t seed = 1; seed <= programs; ++seed) {
        Generator generator(seed);
        std::vector<Statement> loops;
        for (int fills = generator.chance(40) ? 2 : 1; fills > 0; --fills)
            loops.push_back(generator.loop(2, {}, true));
        loops.push_back(generator.loop(2, {}, false));
        const int least_c = generator.chance(50) ? -1 : 1, most_c = 3 + least_c;
        std::string program = fmt::format(
            "fablet A {{ @uniform {{ Material m; int k; float x; int n; }}\n"
            "@Volume(@varying {{ VolumeAttributes attr }}) {{ MaterialComposition mc; float s = "
            "0;\n"
            "int c = clamp(n, {}, {}); float w[{}];\n",
            least_c, most_c, generator.elements());
        for (const Statement& loop : loops)
            program += loop.text;
        program += "mc.Set(m, s); return mc; } }\n";
        source::SourceManager sources;
        diag::Sink sink;
        (void)frontend::compile_to_ir(sources, sources.add("t.fl", program), sink);
        const bool says = !sink.sorted().empty();
        const bool reads = reads_nothing(loops, generator.elements(), least_c, most_c);
        EXPECT_TRUE(says || !reads) << "seed " << seed << "\n" << program;
        sound += reads ? 0 : 1;
        silent += says ? 0 : 1;
    }
    // About one in 20 sound ones is not proven, or has more trips than the compiler sees an end of.
    EXPECT_GT(sound, static_cast<int>(programs / 8));
    EXPECT_GT(silent, sound * 3 / 4);
    fmt::print("{} of {} sound programs are silent\n", silent, sound);
}

}  // namespace
}  // namespace openfab::testing
