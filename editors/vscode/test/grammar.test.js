// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The TextMate grammar against the compiler's lexer, on every fablet of the repository: each token that `openflc emit --as
// tokens` prints must have a scope of its kind, and what lies between tokens must be comments and white space.
// OPENFLC names the compiler.

const assert = require("node:assert");
const { execFileSync } = require("node:child_process");
const fs = require("node:fs");
const path = require("node:path");
const { test } = require("node:test");
const oniguruma = require("vscode-oniguruma");
const textmate = require("vscode-textmate");

const root = path.join(__dirname, "..", "..", "..");
const openflc = process.env.OPENFLC ?? path.join(root, "build/release/bin/openflc");

const expected = {
    identifier: /entity\.name|storage\.type|variable\.other|storage\.modifier\.marker/,
    keyword: /keyword\.|storage\.modifier|constant\.language/,
    int: /constant\.numeric\.(integer|hex)/,
    uint: /constant\.numeric\.(integer|hex)/,
    float: /constant\.numeric\.float/,
    string: /string\.quoted/,
    punct: /keyword\.operator|punctuation|^source\.openfl$/,
};

async function grammar() {
    const wasm = fs.readFileSync(require.resolve("vscode-oniguruma/release/onig.wasm"));
    await oniguruma.loadWASM(wasm.buffer.slice(wasm.byteOffset, wasm.byteOffset + wasm.byteLength));
    const registry = new textmate.Registry({
        onigLib: Promise.resolve({
            createOnigScanner: (patterns) => new oniguruma.OnigScanner(patterns),
            createOnigString: (text) => new oniguruma.OnigString(text),
        }),
        loadGrammar: async (scope) => {
            if (scope !== "source.openfl") return null;
            const file = path.join(__dirname, "..", "syntaxes", "openfl.tmLanguage.json");
            return textmate.parseRawGrammar(fs.readFileSync(file, "utf8"), file);
        },
    });
    return registry.loadGrammar("source.openfl");
}

/** The scopes of each character of each line. */
function scopes(of, text) {
    let state = textmate.INITIAL;
    return text.split("\n").map((line) => {
        const { tokens, ruleStack } = of.tokenizeLine(line, state);
        state = ruleStack;
        const out = new Array(line.length);
        for (const token of tokens) out.fill(token.scopes.join(" "), token.startIndex, token.endIndex);
        return out;
    });
}

test("every token of every fablet has a scope of its kind", async () => {
    const of = await grammar();
    const files = execFileSync("git", ["ls-files", "*.fl"], { cwd: root, encoding: "utf8" }).trim().split("\n");
    let tokens = 0;
    let done = 0;
    for (const file of files) {
        let listed;
        try {
            listed = execFileSync(openflc, ["emit", "--as", "tokens", path.join(root, file)], { encoding: "utf8", stdio: "pipe" });
        } catch {
            continue; // no tokens: an error of the lexer
        }
        ++done;
        const text = fs.readFileSync(path.join(root, file), "utf8");
        const lines = text.split("\n");
        const found = scopes(of, text);
        for (const row of listed.split("\n")) {
            const parts = /^(\d+):(\d+) (\w+) ?(.*)$/.exec(row);
            if (!parts || parts[3] === "end") continue;
            const line = Number(parts[1]) - 1;
            // Columns count code points.
            const column = [...lines[line]].slice(0, Number(parts[2]) - 1).join("").length;
            const scope = found[line][column];
            assert.match(scope.replace("source.openfl ", ""), expected[parts[3]], `${file}:${row}`);
            assert.doesNotMatch(scope, /comment/, `${file}:${row}`);
            if (parts[3] !== "string") assert.doesNotMatch(scope, /string/, `${file}:${row}`);
            ++tokens;
        }
        for (let i = 0; i < lines.length; ++i) {
            const at = lines[i].search(/^\s*\/\//);
            if (at >= 0) assert.match(found[i][lines[i].indexOf("//")], /comment/, `${file}:${i + 1}`);
        }
    }
    assert.ok(done > 150 && tokens > 20000, `${done} files, ${tokens} tokens`);
});
