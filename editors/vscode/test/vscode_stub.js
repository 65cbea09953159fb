// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Stands in for the module `vscode`, which only an editor has: what the extension and vscode-languageclient use of it. Members
// that neither relies on are empty classes. `log` has what was registered and shown.

const Module = require("node:module");
const { pathToFileURL, fileURLToPath } = require("node:url");

const disposable = () => ({ dispose() {} });

class Uri {
    constructor(text) {
        this.text = text;
        this.scheme = text.slice(0, text.indexOf(":"));
        this.fsPath = this.scheme === "file" ? fileURLToPath(text) : text;
    }
    static parse(text) { return new Uri(text); }
    static file(path) { return new Uri(pathToFileURL(path).href); }
    toString() { return this.text; }
}

class CodeActionKind {
    static Empty = new CodeActionKind();
    append() { return this; }
}

class EventEmitter {
    constructor() {
        this.listeners = [];
        this.event = (listener, self) => {
            this.listeners.push(listener.bind(self));
            return disposable();
        };
    }
    fire(value) { for (const one of this.listeners) one(value); }
    dispose() {}
}

/** An object whose other members are classes that do nothing. */
function open(members) {
    return new Proxy(members, {
        get: (of, name) => (name in of || typeof name === "symbol" ? of[name] : (of[name] = class { dispose() {} })),
    });
}

/** Makes `require("vscode")` give a new editor whose setting `openfl.compiler` is `compiler`; returns it. */
exports.install = (compiler) => {
    const log = { messages: [], commands: new Map(), providers: new Map(), documents: new EventEmitter(), diagnostics: new Map() };
    // Any registration that is not looked at.
    const registering = (members) => new Proxy(members, {
        get: (of, name) => (name in of || typeof name === "symbol" ? of[name] : () => disposable()),
    });
    const settings = { compiler };
    const vscode = open({
        version: "1.82.0",
        Uri, CodeActionKind, EventEmitter, log, settings,
        CancellationTokenSource: class { token = { onCancellationRequested: () => disposable() }; cancel() {} dispose() {} },
        env: { language: "en", appName: "stub", clipboard: {} },
        extensions: { getExtension: () => undefined, all: [] },
        commands: registering({
            registerCommand: (name, run) => { log.commands.set(name, run); return disposable(); },
            executeCommand: async (name, ...rest) => log.commands.get(name)?.(...rest),
        }),
        window: registering({
            visibleTextEditors: [],
            tabGroups: { all: [], onDidChangeTabs: () => disposable(), onDidChangeTabGroups: () => disposable() },
            createOutputChannel: () => ({ append() {}, appendLine() {}, show() {}, dispose() {} }),
            showErrorMessage: async (text) => { log.messages.push(text); },
        }),
        workspace: registering({
            textDocuments: [], notebookDocuments: [], workspaceFolders: undefined,
            getConfiguration: () => ({ get: (key, otherwise) => settings[key] ?? otherwise }),
            registerTextDocumentContentProvider: (scheme, provider) => { log.providers.set(scheme, provider); return disposable(); },
            onDidOpenTextDocument: log.documents.event,
        }),
        languages: registering({
            match: (selector, document) => ([selector].flat().some((one) => one.language === document.languageId) ? 10 : 0),
            createDiagnosticCollection: () => ({
                set: (uri, found) => log.diagnostics.set(uri.toString(), found), delete() {}, clear() {}, dispose() {},
            }),
        }),
    });
    const load = Module._load;
    Module._load = function (name, ...rest) { return name === "vscode" ? vscode : load.call(this, name, ...rest); };
    return vscode;
};
