// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/syntax/foreign_syntax.h"

#include <algorithm>

namespace openfab::syntax {

const char* varyings_form(ast::StageKind stage) {
    switch (stage) {
        case ast::StageKind::kSurface:
            return "write `@Surface(@varying { SurfaceAttributes attr })`";
        case ast::StageKind::kVolume:
            return "write `@Volume(@varying { VolumeAttributes attr })`";
        case ast::StageKind::kDither:
            return "write `@Dither(@varying { DitherAttributes attr })`";
        case ast::StageKind::kShape:
            return "write `@Shape(@varying { ShapeAttributes attr })`";
        case ast::StageKind::kGrow:
            break;
    }
    return "write `@Grow(@varying { GrowAttributes attr, Node parent })`, of a struct `Node`";
}

namespace {

struct ForeignWord {
    std::string_view word;
    const char* help;
    const char* ours = nullptr;  ///< stands in its place, if nothing else changes
};

constexpr const char* kFunction =
    "a function begins with the type of its result: `float f(float x) { return x; }`";
constexpr const char* kNoTypes = "there are no classes; declare a `struct`";
constexpr const char* kVector = "a vector is written `float3(1, 2, 3)`";
constexpr const char* kLoop = "a loop is written `for (int i = 0; i < 4; ++i) { … }`";
constexpr const char* kUniform = "uniforms are declared in the fablet: `@uniform { float x = 1; }`";
constexpr const char* kPrecision = "leave it out: all numbers have 32 bits";
constexpr const char* kModule = "write `import name;` at the top of the file";

/// Help, by the unexpected word and the word before it.
constexpr ForeignWord kFound[] = {
    {"and", "write `&&`", "&&"},
    {"or", "write `||`", "||"},
    {"mod", "the remainder is `a % b` or `fmod(a, b)`"},
    {"then", "the statement follows the condition: `if (x > 0) { … }`", ""},
    {"as", "a conversion is written `float(x)`"},
    {"until", "write `while` with the opposite condition"},
    {"import", kModule},
};
constexpr ForeignWord kPrevious[] = {
    {"assert", "it is called as a function: `assert(condition)`"},
    {"print", "write `printf(\"%g\\n\", x)`"},
    {"printf", "write `printf(\"%g\\n\", x)`"},
    {"not", "write `!`", "!"},
    {"new", "there is no `new`: write the value itself, `float3(1, 2, 3)`", ""},
    {"unsigned", "write `uint`", "uint"},
    {"then", "the statement follows the condition: `if (x > 0) { … }`"},
};
/// Help, by the first word of a statement or declaration.
constexpr ForeignWord kFirst[] = {
    {"unsigned", "write `uint`"},
    {"highp", kPrecision, ""},
    {"mediump", kPrecision, ""},
    {"lowp", kPrecision, ""},
    {"closure", "nothing is lit: a stage returns what a voxel is made of, a `MaterialComposition`"},
    {"cbuffer", kUniform},
    {"tbuffer", kUniform},
    {"pass", "an empty block is written `{ }`"},
    {"elif", "write `else if`", "else if"},
    {"elseif", "write `else if`", "else if"},
    {"elsif", "write `else if`", "else if"},
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
    {"inline", "remove `inline`: all functions are inlined", ""},
    {"public", "remove `public`: all members of a fablet are public", ""},
    {"private", "remove `private`; names that begin with `_` are private to their module", ""},
    {"extern", "values from outside are uniforms: `@uniform { float x; }`"},
    {"virtual", "remove `virtual`: there is no inheritance", ""},
    {"template", "there are no templates: overload the function for each type"},
    {"class", kNoTypes, "struct"},
    {"typedef", "types cannot be renamed"},
    {"using", "types cannot be renamed"},
    {"union", "there are no unions; `asuint` and `asfloat` take the bits of a number"},
    {"uniform", kUniform},
    {"varying", "varyings are declared by a stage: `@Volume(@varying { … })`"},
    {"precision", kPrecision},
    {"layout", "remove it: inputs are matched by name"},
    {"from", kModule},
    {"include", kModule},
    {"use", kModule},
    {"ref", "there are no references; use an `out` parameter"},
};

template <size_t N>
const ForeignWord* find(const ForeignWord (&table)[N], std::string_view word) {
    for (const ForeignWord& entry : table) {
        if (entry.word == word) return &entry;
    }
    return nullptr;
}

using Fix = ForeignSyntax::Fix;

/// `TEXCOORD0`, `SV_Target`
bool is_semantic(std::string_view word) {
    const auto upper = [](char c) { return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9'); };
    return word.starts_with("SV_") || (word.size() > 3 && std::ranges::all_of(word, upper));
}

/// Returns what to write for character sequences that are operators in other languages.
ForeignSyntax foreign_operator(const Surroundings& at) {
    const auto are = [&](std::string_view previous, std::string_view found) {
        return at.previous == previous && at.found == found;
    };
    const auto digit = [](std::string_view text) {
        return !text.empty() && text[0] >= '0' && text[0] <= '9';
    };
    if (are("*", "*")) return {"a power is written `pow(x, y)`"};
    if (are("-", ">"))
        return {"members are written with a dot: `attr.voxelCenter`", Fix::kBoth, "."};
    if (are("<", ">") || are("!=", "=")) return {"write `!=`", Fix::kBoth, "!="};
    if (are("==", "=")) return {"write `==`", Fix::kBoth, "=="};
    if (at.found == "-" && at.next == ">")
        return {"a result type comes first in a function, and a stage has none"};
    if (at.found == "=" && at.next == ">")
        return {"a function's body stands in braces: `{ return x; }`"};
    if (at.found == ":" && at.next == ":")
        return {"there are no namespaces: use the name alone", Fix::kNamespace, ""};
    if (at.found == ":" && at.next == "=")
        return {"declare a variable with its type: `float x = 1;`", Fix::kDefinition, "="};
    if (are("%", ")") || are("%", ";") || are("%", ",")) {
        return {"amounts are fractions: write `0.5` for 50 %", Fix::kPercent, ""};
    }
    if (are("=", "[") || are("(", "[") || are("return", "[")) {
        return {"write a list in braces: `{1, 2, 3}`", Fix::kBrackets, ""};
    }
    if (are("=", "<")) return {kVector};
    if (are("=", "&") || are("return", "&"))
        return {"there are no pointers or references: write the value itself"};
    if (at.first == "struct" && (at.next == ";" || at.next == "="))
        return {"the name of a struct is its type: `Point p;`"};
    if (at.found == ":" && is_semantic(at.next))
        return {"there are no semantics: inputs and outputs are matched by name"};
    const bool in_expression =
        at.previous == "=" || at.previous == "(" || at.previous == "," || at.previous == "return";
    if (in_expression && at.found == "@" &&
        (at.next == "Surface" || at.next == "Volume" || at.next == "Dither" || at.next == "Shape" ||
         at.next == "Grow"))
        return {"a stage cannot be called: put what two of them need into a function"};
    if (are("=", "if") || are("return", "if") || are("(", "if") ||
        (at.found == "if" && at.same_line && at.previous != ")" && at.previous != "else")) {
        return {"a choice in an expression is written `condition ? a : b`"};
    }
    if (are("=", "lambda") || at.previous == "lambda")
        return {"there are no functions in expressions: define it outside of the stage"};
    if (at.found == ":" && digit(at.previous)) return {"a label is written `case 0:`"};
    if (are("=", "|")) return {"a magnitude is written `abs(x)`"};
    if (are("const", "=") || (at.first == "const" && at.found == "=")) {
        return {"a constant has a type: `const float x = 1;`"};
    }
    return {};
}

}  // namespace

ForeignSyntax foreign_syntax(const Surroundings& at) {
    if (ForeignSyntax found = foreign_operator(at); !found.help.empty()) return found;
    const auto made = [](const ForeignWord& word, Fix fix) {
        return word.ours == nullptr ? ForeignSyntax{word.help}
                                    : ForeignSyntax{word.help, fix, word.ours};
    };
    if (const ForeignWord* word = find(kFound, at.found)) return made(*word, Fix::kFound);
    if (const ForeignWord* word = find(kPrevious, at.previous)) return made(*word, Fix::kPrevious);
    if (const ForeignWord* word = find(kFirst, at.first)) return made(*word, Fix::kFirst);
    return {};
}

}  // namespace openfab::syntax
