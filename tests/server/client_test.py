#!/usr/bin/env python3
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""A client of `openflc lsp` in plain Python: a whole session over pipes, in the protocol's own terms.

    client_test.py OPENFLC [--print-times]
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
FABLET = """import shell;

// Half a millimetre is usual.
const float SKIN = 0.5;

struct Layer { float depth; Material ink; };

fablet Ball {
    @uniform {
        float3 color = float3(1, 0.5, 0) [[ string help = "of the skin" ]];
        Material core, coat;
    }

    // How far in, mm.
    float depth(float3 p, float more) { return -distance(p) + more; }

    @Volume(@varying { VolumeAttributes attr })
    {
        MaterialComposition mc;
        float t = shell(-depth(attr.voxelCenter, SKIN), SKIN);
        mc.Set(coat, t);
        mc.Set(core, 1 - t);
        return mc;
    }
}
"""


class Client:
    """A JSON-RPC client that keeps the notifications of its server."""

    def __init__(self, openflc):
        self.process = subprocess.Popen([openflc, "lsp", "--stdio"], stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.number = 0
        self.published = []

    def send(self, message):
        body = json.dumps({"jsonrpc": "2.0", **message}, ensure_ascii=False).encode()
        self.process.stdin.write(b"Content-Length: %d\r\n\r\n" % len(body) + body)
        self.process.stdin.flush()

    def receive(self):
        length = None
        while True:
            line = self.process.stdout.readline()
            if not line:
                raise SystemExit("the server ended")
            if line == b"\r\n":
                break
            name, value = line.split(b":")
            if name.lower() == b"content-length":
                length = int(value)
        return json.loads(self.process.stdout.read(length))

    def notify(self, method, params):
        self.send({"method": method, "params": params})

    def ask(self, method, params, fails=False):
        self.number += 1
        self.send({"id": self.number, "method": method, "params": params})
        while True:
            message = self.receive()
            if message.get("id") == self.number:
                assert ("error" in message) == fails, message
                return message["error"] if fails else message["result"]
            self.published.append(message["params"])

    def diagnostics(self):
        while not self.published:
            message = self.receive()
            assert message["method"] == "textDocument/publishDiagnostics", message
            self.published.append(message["params"])
        return self.published.pop(0)


def check(what, got, wanted):
    if got != wanted:
        raise SystemExit(f"{what}:\n  got    {got!r}\n  wanted {wanted!r}")


def place(text, word, skip=0, inside=0):
    """Returns the position of a word: its occurrence number `skip`, `inside` characters from its start."""
    at = -1
    for _ in range(skip + 1):
        at = text.index(word, at + 1)
    line = text.count("\n", 0, at)
    return {"line": line, "character": at - (text.rfind("\n", 0, at) + 1) + inside}


def words_of(ranges, text):
    lines = text.split("\n")
    return [lines[r["start"]["line"]][r["start"]["character"] : r["end"]["character"]] for r in ranges]


def session(openflc, print_times):
    client = Client(openflc)
    check("a request before initialize", client.ask("textDocument/hover", {}, fails=True)["code"], -32002)
    capabilities = client.ask("initialize", {"processId": None, "rootUri": None, "capabilities": {}})["capabilities"]
    check("the encoding", capabilities["positionEncoding"], "utf-16")
    client.notify("initialized", {})
    folder = pathlib.Path(tempfile.mkdtemp())
    uri = (folder / "a ball.fl").as_uri()
    document = {"textDocument": {"uri": uri}}

    def at(word, skip=0, inside=0):
        return {**document, "position": place(FABLET, word, skip, inside)}

    def value_at(*args):
        return client.ask("textDocument/hover", at(*args))["contents"]["value"]

    client.notify("textDocument/didOpen", {"textDocument": {"uri": uri, "languageId": "openfl", "version": 1, "text": FABLET}})
    check("a document without mistakes", client.diagnostics(), {"uri": uri, "version": 1, "diagnostics": []})

    hover = value_at("depth", 2, 1)
    assert "float depth(float3 p, float more)" in hover and "How far in, mm." in hover, hover
    hover = value_at("color", 0)
    assert "float3 color" in hover and "of the skin" in hover and "float3(1, 0.5, 0)" in hover, hover
    hover = value_at("SKIN", 1)
    assert "float SKIN" in hover and "Half a millimetre" in hover, hover
    hover = value_at("shell(", 0)
    assert "outermost `thickness`" in hover, hover
    assert "signed distance" in value_at("distance", 0), "the reference of distance"
    assert "float3 voxelCenter" in value_at("voxelCenter"), "a member"
    assert "import shell" in value_at("shell;"), "a module"
    check("hover in a comment", client.ask("textDocument/hover", at("usual")), None)

    location = client.ask("textDocument/definition", at("SKIN", 2))
    check("the definition of a constant", (location["uri"], words_of([location["range"]], FABLET)), (uri, ["SKIN"]))
    location = client.ask("textDocument/definition", at("shell("))
    check("the definition in the library", location["uri"], "openfl:/stdlib/shell.fl")
    library = client.ask("openfl/libraryText", {"uri": location["uri"]})
    check("the text of the library", library, (ROOT / "stdlib/shell.fl").read_text())
    check("and the place in it", words_of([location["range"]], library), ["shell"])
    places = client.ask("textDocument/references", {**at("t = "), "context": {"includeDeclaration": True}})
    check("references", [p["range"]["start"]["line"] for p in places], [19, 20, 21])

    edit = client.ask("textDocument/rename", {**at("t = "), "newName": "share"})
    check("rename", [e["newText"] for e in edit["changes"][uri]], ["share"] * 3)
    for name, why in (("coat", "clash"), ("mc", "clash"), ("float3", "not a name"), ("a b", "not a name")):
        error = client.ask("textDocument/rename", {**at("t = "), "newName": name}, fails=True)
        assert why in error["message"], error
    error = client.ask("textDocument/prepareRename", at("shell("), fails=True)
    assert "another file" in error["message"], error

    items = client.ask("textDocument/completion", at("attr.voxelCenter", 0, 5))
    check("members", sorted(i["label"] for i in items), ["buildPosition", "instance", "voxelCenter", "voxelSize"])
    labels = {i["label"] for i in client.ask("textDocument/completion", at("mc.Set(core", 0, 9))}
    for name in ("t", "mc", "attr", "core", "SKIN", "depth", "shell", "lerp", "float3", "return", "for", "Layer"):
        assert name in labels, name
    assert "more" not in labels and "_private" not in labels, "a name out of its scope"
    labels = {i["label"] for i in client.ask("textDocument/completion", at("mc.Set", 0, 3))}
    check("methods", labels, {"Set", "Add", "Get", "Total", "Clear"})
    labels = {i["label"] for i in client.ask("textDocument/completion", at("shell;"))}
    assert {"shell", "lattice", "color"} <= labels, labels
    check("nothing in a comment", client.ask("textDocument/completion", at("usual")), [])

    help_ = client.ask("textDocument/signatureHelp", at("SKIN)", 0))
    check("signature help", (help_["signatures"][0]["label"], help_["activeParameter"]),
          ("float depth(float3 p, float more)", 1))
    help_ = client.ask("textDocument/signatureHelp", at("distance(p", 0, 9))
    check("signature help of a built-in function",
          [(s["label"], [p["label"] for p in s["parameters"]]) for s in help_["signatures"]],
          [("float distance(float3 p)", ["float3 p"]), ("float distance(floatN a, floatN b)", ["floatN a", "floatN b"])])
    assert "surface" in help_["signatures"][0]["documentation"]["value"]
    check("signature help of a method",
          client.ask("textDocument/signatureHelp", at("core, 1"))["signatures"][0]["label"], "void Set(Material m, float amount)")

    symbols = client.ask("textDocument/documentSymbol", document)
    check("symbols", [s["name"] for s in symbols], ["Layer", "SKIN", "Ball"])
    check("symbols of a fablet", [s["name"] for s in symbols[2]["children"]],
          ["color", "core", "coat", "depth", "@Volume"])
    tokens = client.ask("textDocument/semanticTokens/full", document)["data"]
    legend = capabilities["semanticTokensProvider"]["legend"]["tokenTypes"]
    line = character = 0
    kinds = {}
    for down, right, length, kind, _ in zip(*[iter(tokens)] * 5):
        line, character = line + down, right if down else character + right
        kinds.setdefault(FABLET.split("\n")[line][character : character + length], set()).add(legend[kind])
    for name, kind in (("Ball", "class"), ("color", "property"), ("t", "variable"), ("p", "parameter"), ("attr", "parameter"),
                       ("shell", "namespace"), ("Set", "method"), ("Volume", "decorator"), ("float3", "type"),
                       ("depth", "function"), ("voxelCenter", "property"), ("Layer", "struct")):
        assert kind in kinds.get(name, ()), (name, kinds.get(name))

    colors = client.ask("textDocument/documentColor", document)
    check("colours", (len(colors), words_of([colors[0]["range"]], FABLET)), (1, ["float3(1, 0.5, 0)"]))
    label = client.ask("textDocument/colorPresentation",
                       {**document, "color": colors[0]["color"], "range": colors[0]["range"]})[0]["label"]
    check("a colour and back", label, "float3(1, 0.5, 0)")

    def change(version, start, end, text):
        client.notify("textDocument/didChange", {
            "textDocument": {"uri": uri, "version": version},
            "contentChanges": [{"range": {"start": start, "end": end}, "text": text}]})

    # A mistake with a fix, after characters that are two code units in UTF-16 and four bytes in UTF-8.
    end = place(FABLET, "mc.Set(coat, t);")
    change(2, end, end, "/* 𝄞𝄞 */ mc.Sett(coat, t); ")
    message = client.diagnostics()["diagnostics"][0]
    check("a mistake", (message["code"], message["range"]["start"]["character"]), ("unknown-member", end["character"] + 14))
    assert "did you mean `Set`?" in message["message"], message
    action = client.ask("textDocument/codeAction", {**document, "range": message["range"], "context": {"diagnostics": []}})[0]
    check("its fix", (action["title"], action["edit"]["changes"][uri][0]["range"]), ("Change to `Set`", message["range"]))
    error = client.ask("textDocument/rename", {**document, "position": place(FABLET, "t = "), "newName": "u"}, fails=True)
    assert "no errors" in error["message"], error
    hover = client.ask("textDocument/hover", {**document, "position": place(FABLET, "t = ")})["contents"]["value"]
    assert "float t" in hover, "types in a document with mistakes"

    # While a member is being typed the rest does not parse, and its members are offered all the same.
    change(3, end, {"line": end["line"], "character": end["character"] + len("/* 𝄞𝄞 */ mc.Sett(coat, t); ") + 2}, "attr.\n")
    check("what is half typed", client.diagnostics()["diagnostics"][0]["severity"], 1)
    items = client.ask("textDocument/completion",
                       {**document, "position": {"line": end["line"], "character": end["character"] + 5}})
    check("members of what is half typed", len(items), 4)

    # The whole text, and its layout.
    client.notify("textDocument/didChange", {"textDocument": {"uri": uri, "version": 4},
                                             "contentChanges": [{"text": FABLET.replace("1 - t", "1-t")}]})
    check("mended", client.diagnostics()["diagnostics"], [])
    edits = client.ask("textDocument/formatting", {**document, "options": {"tabSize": 4, "insertSpaces": True}})
    check("formatting", [e["newText"] for e in edits], ["        mc.Set(core, 1 - t);\n"])

    # A module that is not saved yet, in a document of its own.
    (folder / "ink.fl").write_text("float dark(float x) { return x; }\n")
    module = (folder / "ink.fl").as_uri()
    client.notify("textDocument/didChange", {"textDocument": {"uri": uri, "version": 5},
                                             "contentChanges": [{"text": "import ink;\n" + FABLET.replace("= shell", "= darker")}]})
    check("a function that the file does not have", client.diagnostics()["diagnostics"][0]["code"], "unknown-function")
    client.notify("textDocument/didOpen", {"textDocument": {
        "uri": module, "languageId": "openfl", "version": 1,
        "text": "float darker(float x, float y) { return x; }\n"}})
    published = {m["uri"]: m["diagnostics"] for m in (client.diagnostics(), client.diagnostics())}
    check("a module that is not saved", published, {uri: [], module: []})
    client.notify("textDocument/didClose", {"textDocument": {"uri": module}})
    published = {m["uri"]: len(m["diagnostics"]) for m in (client.diagnostics(), client.diagnostics())}
    check("without it", published, {uri: 1, module: 0})

    check("a document that is not open",
          client.ask("textDocument/hover", {"textDocument": {"uri": "file:///none.fl"}, "position": {}}, fails=True)["code"], -32602)
    check("a method that there is not", client.ask("openfl/none", {}, fails=True)["code"], -32601)
    check("shutdown", client.ask("shutdown", None), None)
    check("a request after shutdown", client.ask("textDocument/hover", at("SKIN"), fails=True)["code"], -32600)
    client.notify("exit", None)
    check("the exit code", client.process.wait(timeout=300), 0)
    if print_times:
        times(openflc)


def times(openflc):
    """Prints how long a keystroke takes in the largest file of the gallery, and of the library."""
    files = [max((ROOT / folder).rglob("*.fl"), key=lambda f: f.stat().st_size) for folder in ("gallery", "stdlib")]
    for file in files:
        client = Client(openflc)
        client.ask("initialize", {"capabilities": {}})
        text = file.read_text()
        uri = file.as_uri()
        client.notify("textDocument/didOpen", {"textDocument": {"uri": uri, "languageId": "openfl", "version": 0, "text": text}})
        client.diagnostics()
        taken = []
        end = place(text, text.rstrip().split("\n")[-2])
        for i in range(40):
            begun = time.perf_counter()
            client.notify("textDocument/didChange", {"textDocument": {"uri": uri, "version": i},
                                                     "contentChanges": [{"range": {"start": end, "end": end}, "text": " "}]})
            client.ask("textDocument/completion", {"textDocument": {"uri": uri}, "position": end})
            client.ask("textDocument/semanticTokens/full", {"textDocument": {"uri": uri}})
            client.published.clear() if client.published else client.diagnostics()
            taken.append((time.perf_counter() - begun) * 1e3)
        taken.sort()
        print(f"{file.relative_to(ROOT)}: a change, its messages, completion and semantic tokens: "
              f"median {taken[20]:.1f} ms, longest {taken[-1]:.1f} ms")
        client.notify("exit", None)
        client.process.wait()


session(sys.argv[1], "--print-times" in sys.argv)
