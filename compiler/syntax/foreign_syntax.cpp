// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/syntax/foreign_syntax.h"

namespace openfab::syntax {

const char* varyings_form(ast::StageKind stage) {
    switch (stage) {
        case ast::StageKind::kSurface:
            return "write `@Surface(@varying { SurfaceAttributes attr })`";
        case ast::StageKind::kVolume:
            return "write `@Volume(@varying { VolumeAttributes attr })`";
        case ast::StageKind::kDither:
            break;
    }
    return "write `@Dither(@varying { DitherAttributes attr })`";
}

namespace {

struct ForeignWord {
    std::string_view word;
    const char* help;
};

constexpr const char* kFunction =
    "a function begins with the type of its result: `float f(float x) { return x; }`";
constexpr const char* kNoTypes = "there are no classes; declare a `struct`";
constexpr const char* kVector = "a vector is written `float3(1, 2, 3)`";
constexpr const char* kLoop = "a loop is written `for (int i = 0; i < 4; ++i) { … }`";
constexpr const char* kUniform = "uniforms are declared in the fablet: `@uniform { float x = 1; }`";
constexpr const char* kModule = "write `import name;` at the top of the file";

/// Help, by the unexpected word and the word before it.
constexpr ForeignWord kFound[] = {
    {"and", "write `&&`"},
    {"or", "write `||`"},
    {"mod", "the remainder is `a % b` or `fmod(a, b)`"},
    {"then", "the statement follows the condition: `if (x > 0) { … }`"},
    {"as", "a conversion is written `float(x)`"},
    {"until", "write `while` with the opposite condition"},
    {"import", kModule},
};
constexpr ForeignWord kPrevious[] = {
    {"not", "write `!`"},
    {"new", "there is no `new`: write the value itself, `float3(1, 2, 3)`"},
    {"unsigned", "write `uint`"},
    {"then", "the statement follows the condition: `if (x > 0) { … }`"},
};
/// Help, by the first word of a statement or declaration.
constexpr ForeignWord kFirst[] = {
    {"unsigned", "write `uint`"},
    {"elif", "write `else if`"},
    {"elseif", "write `else if`"},
    {"elsif", "write `else if`"},
    {"then", "the statement follows the condition: `if (x > 0) { … }`"},
    {"foreach", kLoop},
    {"loop", kLoop},
    {"repeat", kLoop},
    {"throw", "there are no exceptions; use `assert` to find faults"},
    {"try", "there are no exceptions; use `assert` to find faults"},
    {"def", kFunction},
    {"fn", kFunction},
    {"func", kFunction},
    {"function", kFunction},
    {"inline", "remove `inline`: all functions are inlined"},
    {"public", "remove `public`: all members of a fablet are public"},
    {"private", "remove `private`; names that begin with `_` are private to their module"},
    {"extern", "values from outside are uniforms: `@uniform { float x; }`"},
    {"virtual", "remove `virtual`: there is no inheritance"},
    {"template", "there are no templates: overload the function for each type"},
    {"class", kNoTypes},
    {"enum", "there are no enums: write constants, `const int RED = 0;`"},
    {"typedef", "types cannot be renamed"},
    {"using", "types cannot be renamed"},
    {"union", "there are no unions; `asuint` and `asfloat` take the bits of a number"},
    {"uniform", kUniform},
    {"varying", "varyings are declared by a stage: `@Volume(@varying { … })`"},
    {"precision", "remove it: all numbers have 32 bits"},
    {"layout", "remove it: inputs are matched by name"},
    {"from", kModule},
    {"include", kModule},
    {"use", kModule},
    {"ref", "there are no references; use an `out` parameter"},
};

template <size_t N>
const char* find_help(const ForeignWord (&table)[N], std::string_view word) {
    for (const ForeignWord& entry : table) {
        if (entry.word == word) return entry.help;
    }
    return nullptr;
}

/// Returns help for character sequences that are operators in other languages.
const char* foreign_operator_help(const Surroundings& at) {
    const auto are = [&](std::string_view previous, std::string_view found) {
        return at.previous == previous && at.found == found;
    };
    if (are("*", "*")) return "a power is written `pow(x, y)`";
    if (are("-", ">")) return "members are written with a dot: `attr.voxelCenter`";
    if (at.found == "-" && at.next == ">")
        return "a result type comes first in a function, and a stage has none";
    if (at.found == ":" && at.next == ":") return "there are no namespaces: use the name alone";
    if (at.found == ":" && at.next == "=")
        return "declare a variable with its type: `float x = 1;`";
    if (are("%", ")") || are("%", ";") || are("%", ",")) {
        return "amounts are fractions: write `0.5` for 50 %";
    }
    if (are("=", "[") || are("(", "[")) return "write a list in braces: `{1, 2, 3}`";
    if (are("=", "<")) return kVector;
    if (are("=", "if") || are("return", "if") || are("(", "if")) {
        return "a choice in an expression is written `condition ? a : b`";
    }
    if (at.found == ":" && !at.previous.empty() && at.previous[0] >= '0' && at.previous[0] <= '9') {
        return "a label is written `case 0:`";
    }
    if (are("=", "|")) return "a magnitude is written `abs(x)`";
    if (are("const", "=") || (at.first == "const" && at.found == "=")) {
        return "a constant has a type: `const float x = 1;`";
    }
    return nullptr;
}

}  // namespace

std::string foreign_syntax_help(const Surroundings& at) {
    if (const char* help = foreign_operator_help(at)) return help;
    if (const char* help = find_help(kFound, at.found)) return help;
    if (const char* help = find_help(kPrevious, at.previous)) return help;
    if (const char* help = find_help(kFirst, at.first)) return help;
    return "";
}

}  // namespace openfab::syntax
