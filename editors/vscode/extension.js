// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Starts `openflc lsp` and shows the modules of the standard library, which are part of that program.

const vscode = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

async function start() {
    const command = vscode.workspace.getConfiguration("openfl").get("compiler");
    const run = { command, args: ["lsp", "--stdio"] };
    client = new LanguageClient("openfl", "OpenFL", run, { documentSelector: [{ language: "openfl" }] });
    try {
        await client.start();
    } catch (error) {
        vscode.window.showErrorMessage(
            `OpenFL: \`${command}\` does not start (${error.message ?? error}). Set openfl.compiler to the openflc of an OpenFab build.`);
    }
}

async function stop() {
    if (client?.needsStop()) await client.stop();
}

exports.activate = async (context) => {
    context.subscriptions.push(
        vscode.workspace.registerTextDocumentContentProvider("openfl", {
            provideTextDocumentContent: (uri) => client.sendRequest("openfl/libraryText", { uri: uri.toString(true) }),
        }),
        vscode.commands.registerCommand("openfl.restart", async () => {
            await stop();
            await start();
        }),
        vscode.workspace.onDidChangeConfiguration((event) => {
            if (event.affectsConfiguration("openfl.compiler")) vscode.commands.executeCommand("openfl.restart");
        }));
    await start();
};

exports.deactivate = stop;
