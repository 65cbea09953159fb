// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// The extension against the language server of OPENFLC, in an editor that is a stub.

const assert = require("node:assert");
const path = require("node:path");
const { test } = require("node:test");

const openflc = process.env.OPENFLC ?? path.join(__dirname, "..", "..", "..", "build/release/bin/openflc");
const vscode = require("./vscode_stub").install(openflc);
const extension = require("..");

/** Waits until `found` gives something. */
async function until(found, what) {
    for (let i = 0; i < 600; ++i) {
        const value = found();
        if (value) return value;
        await new Promise((resolve) => setTimeout(resolve, 50));
    }
    assert.fail(`${what} did not come`);
}

test("it starts the server, passes documents on and shows what the server says", async () => {
    const context = { subscriptions: [] };
    await extension.activate(context);
    assert.deepEqual(vscode.log.messages, []);
    assert.equal(context.subscriptions.length, 3);

    const text = await vscode.log.providers.get("openfl").provideTextDocumentContent(vscode.Uri.parse("openfl:/stdlib/grade.fl"));
    assert.match(text, /grade_linear/);

    const uri = vscode.Uri.parse("file:///wrong.fl");
    const source = "fablet A {";
    vscode.log.documents.fire({ uri, languageId: "openfl", version: 1, getText: () => source, isClosed: false });
    const found = await until(() => vscode.log.diagnostics.get(uri.toString()), "a message");
    assert.ok(found.length > 0);

    await vscode.log.commands.get("openfl.restart")();
    assert.deepEqual(vscode.log.messages, []);
    await extension.deactivate();
});

test("a compiler that is not there is named", async () => {
    vscode.settings.compiler = "/nowhere/openflc";
    await extension.activate({ subscriptions: [] });
    assert.match(vscode.log.messages.at(-1), /`\/nowhere\/openflc` does not start \(.*failed.*\)/);
    await extension.deactivate();
});
