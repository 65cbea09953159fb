// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The grammar of compiler/OPENFL.md, section 11, for tree-sitter.

/// <reference types="tree-sitter-cli/dsl" />

const PRECEDENCE = {
    assign: 1,
    conditional: 2,
    binary: 3, // + level
    unary: 14,
    cast: 14,
    postfix: 15,
};

const BINARY = [["||"], ["&&"], ["|"], ["^"], ["&"], ["==", "!="], ["<", ">", "<=", ">="], ["<<", ">>"], ["+", "-"], ["*", "/", "%"]];

const SIDES = ["1", "2", "3", "4"];
const PRIMITIVE_TYPES = ["bool", "int", "uint", "float"].flatMap((base) =>
    ["", ...SIDES, ...SIDES.flatMap((rows) => SIDES.map((columns) => `${rows}x${columns}`))].map((size) => base + size));

const list = (rule) => seq(rule, repeat(seq(",", rule)));
const optionalList = (rule) => optional(seq(list(rule), optional(",")));

module.exports = grammar({
    name: "openfl",
    extras: ($) => [/\s/, "\uFEFF", $.comment],
    word: ($) => $.identifier,
    supertypes: ($) => [$._statement, $._expression],
    conflicts: ($) => [[$._named_type, $._expression]],

    rules: {
        source_file: ($) => repeat(choice($.import, $.fablet, $._declaration, ";")),

        import: ($) => seq("import", field("module", $.identifier), ";"),
        fablet: ($) => seq("fablet", field("name", $.identifier), field("body", $.fablet_body)),
        fablet_body: ($) => seq("{", repeat(choice($.uniforms, $.stage, $._declaration, ";")), "}"),
        uniforms: ($) => seq("@", alias("uniform", $.marker), "{", repeat($.uniform), "}"),
        uniform: ($) => seq(field("type", $._type), list($.declarator), ";"),
        stage: ($) =>
            seq("@", field("kind", alias($.identifier, $.marker)), "(", optional($.varyings), ")",
                optional($.claims), field("body", $.block)),
        claims: ($) => seq("[[", list($.identifier), "]", "]"),
        varyings: ($) => seq("@", alias("varying", $.marker), "{", optionalList($.varying), "}"),
        varying: ($) =>
            seq(optional(seq("@", alias("nearest", $.marker))), repeat($.qualifier), field("type", $._type), $.declarator),

        _declaration: ($) => choice($.function, $.struct, $.enum, $.declaration),
        struct: ($) =>
            seq(repeat($.qualifier), "struct", field("name", alias($.identifier, $.type_identifier)), "{", repeat($.member), "}",
                optional(list($.declarator)), ";"),
        enum: ($) =>
            seq("enum", field("name", alias($.identifier, $.type_identifier)), "{", optionalList($.enumerator), "}", ";"),
        enumerator: ($) =>
            seq(field("name", $.identifier), optional(seq("=", field("value", $._expression))), optional($.annotations)),
        member: ($) => seq(field("type", $._type), list($.declarator), ";"),
        function: ($) =>
            seq(repeat($.qualifier), field("type", $._type), field("name", $.identifier), field("parameters", $.parameters),
                field("body", $.block)),
        parameters: ($) => seq("(", optionalList($.parameter), ")"),
        parameter: ($) => seq(repeat($.qualifier), field("type", $._type), $.declarator),
        declaration: ($) => seq(repeat($.qualifier), field("type", $._type), list($.declarator), ";"),
        declarator: ($) =>
            seq(field("name", $.identifier), repeat($.extent), optional(seq("=", field("value", $._initializer))),
                optional($.annotations)),
        extent: ($) => seq("[", optional($._expression), "]"),
        annotations: ($) => seq("[[", optionalList($.annotation), "]", "]"),
        annotation: ($) => seq(field("type", $._type), field("name", $.identifier), "=", field("value", $._expression)),
        qualifier: () => choice("const", "static", "in", "out", "inout"),
        _type: ($) => choice($.primitive_type, $._named_type),
        _named_type: ($) => alias($.identifier, $.type_identifier),
        primitive_type: () => choice("void", "string", ...PRIMITIVE_TYPES),

        block: ($) => seq("{", repeat($._statement), "}"),
        _statement: ($) =>
            choice($.block, $.if, $.for, $.while, $.do, $.switch, $.case, $.bounded, $.return, $.break, $.continue, $.struct,
                $.declaration, $.expression_statement, $.empty),
        empty: () => ";",
        if: ($) =>
            prec.right(seq("if", "(", field("condition", $._any_expression), ")", field("then", $._statement),
                optional(seq("else", field("else", $._statement))))),
        for: ($) =>
            seq("for", "(", choice($.declaration, seq(optional($._any_expression), ";")), optional(field("condition", $._any_expression)),
                ";", optional(field("step", $._any_expression)), ")", field("body", $._statement)),
        while: ($) => seq("while", "(", field("condition", $._any_expression), ")", field("body", $._statement)),
        do: ($) =>
            seq("do", field("body", $._statement), "while", "(", field("condition", $._any_expression), ")", ";"),
        switch: ($) => seq("switch", "(", field("value", $._any_expression), ")", "{", repeat($._statement), "}"),
        case: ($) => seq(choice(seq("case", field("value", $._expression)), "default"), ":"),
        bounded: ($) => seq("@", alias("bound", $.marker), "(", field("trips", $._expression), ")", choice($.for, $.while, $.do)),
        return: ($) => seq("return", optional(choice($._any_expression, $.list)), ";"),
        break: () => seq("break", ";"),
        continue: () => seq("continue", ";"),
        expression_statement: ($) => seq($._any_expression, ";"),

        _any_expression: ($) => choice($._expression, $.comma),
        comma: ($) => prec.left(seq($._any_expression, ",", $._expression)),
        _initializer: ($) => choice($._expression, $.list),
        list: ($) => seq("{", optionalList($._initializer), "}"),

        _expression: ($) =>
            choice($.identifier, $.primitive_type, $.number, $.string, $.boolean, $.parenthesized, $.unary, $.update, $.binary, $.conditional,
                $.assignment, $.cast, $.call, $.index, $.field),
        parenthesized: ($) => seq("(", $._any_expression, ")"),
        unary: ($) => prec(PRECEDENCE.unary, seq(field("operator", choice("+", "-", "!", "~")), $._expression)),
        update: ($) =>
            choice(prec(PRECEDENCE.unary, seq(choice("++", "--"), $._expression)),
                prec(PRECEDENCE.postfix, seq($._expression, choice("++", "--")))),
        binary: ($) =>
            choice(...BINARY.map((operators, level) =>
                prec.left(PRECEDENCE.binary + level,
                    seq(field("left", $._expression), field("operator", operators.length > 1 ? choice(...operators) : operators[0]), field("right", $._expression))))),
        conditional: ($) =>
            prec.right(PRECEDENCE.conditional, seq(field("condition", $._expression), "?", $._expression, ":", $._expression)),
        assignment: ($) =>
            prec.right(PRECEDENCE.assign,
                seq(field("left", $._expression),
                    field("operator", choice("=", "+=", "-=", "*=", "/=", "%=", "&=", "|=", "^=", "<<=", ">>=")),
                    field("right", $._initializer))),
        // `(T)-x` and `(T)(x)` are casts where T is built in, else a difference and a call.
        cast: ($) =>
            choice(...[[0, $.primitive_type], [-1, $._named_type]].map(([likely, type]) =>
                prec.dynamic(likely, prec(PRECEDENCE.cast, seq("(", field("type", type), repeat($.extent), ")", field("value", $._expression)))))),
        call: ($) => prec(PRECEDENCE.postfix, seq(field("function", $._expression), field("arguments", $.arguments))),
        arguments: ($) => seq("(", optionalList($._initializer), ")"),
        index: ($) => prec(PRECEDENCE.postfix, seq($._expression, "[", $._any_expression, "]")),
        field: ($) => prec(PRECEDENCE.postfix, seq($._expression, ".", field("member", alias($.identifier, $.field_identifier)))),

        identifier: () => /[A-Za-z_][A-Za-z0-9_]*/,
        number: () =>
            token(choice(/0[xX][0-9a-fA-F]+[uU]?/, /[0-9]+[uUfFhH]?/, /([0-9]+\.[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?[fFhH]?/,
                /[0-9]+[eE][-+]?[0-9]+[fFhH]?/)),
        string: () => token(seq('"', repeat(choice(/[^"\\\n]/, /\\./)), '"')),
        boolean: () => choice("true", "false"),
        comment: () => token(choice(seq("//", /[^\n]*/), seq("/*", /[^*]*\*+([^/*][^*]*\*+)*/, "/"))),
    },
});
