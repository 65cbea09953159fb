# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
"""Sessions of `openflc lsp` with pytest-lsp, which checks every message against the protocol's types.

scripts/test-editors runs it; OPENFLC names the compiler. tests/server/client_test.py has the answers in detail.
"""

import os
import pathlib

import pytest
import pytest_lsp
from lsprotocol import types
from pytest_lsp import ClientServerConfig, LanguageClient, client_capabilities

ROOT = pathlib.Path(__file__).resolve().parents[2]
FILES = sorted([*ROOT.glob("gallery/*/*.fl"), *ROOT.glob("stdlib/*.fl")])


@pytest_lsp.fixture(
    scope="module",
    config=ClientServerConfig(server_command=[os.environ.get("OPENFLC", str(ROOT / "build/release/bin/openflc")), "lsp"]),
)
async def client(lsp_client: LanguageClient):
    parameters = types.InitializeParams(capabilities=client_capabilities("visual-studio-code"), root_uri=ROOT.as_uri())
    await lsp_client.initialize_session(parameters)
    yield
    await lsp_client.shutdown_session()


def opened(client, file):
    uri = file.as_uri()
    client.text_document_did_open(
        types.DidOpenTextDocumentParams(types.TextDocumentItem(uri, "openfl", 1, file.read_text())))
    return types.TextDocumentIdentifier(uri)


@pytest.mark.parametrize("file", FILES, ids=lambda f: f.name)
@pytest.mark.asyncio(loop_scope="module")
async def test_a_fablet_of_the_repository(client, file):
    document = opened(client, file)
    while document.uri not in client.diagnostics:
        await client.wait_for_notification(types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
    assert not client.diagnostics[document.uri]
    symbols = await client.text_document_document_symbol_async(types.DocumentSymbolParams(document))
    assert symbols
    first = symbols[0].selection_range.start
    tokens = await client.text_document_semantic_tokens_full_async(types.SemanticTokensParams(document))
    assert len(tokens.data) % 5 == 0 and tokens.data
    assert not await client.text_document_formatting_async(
        types.DocumentFormattingParams(document, types.FormattingOptions(4, True)))
    await client.text_document_document_color_async(types.DocumentColorParams(document))
    await client.text_document_hover_async(types.HoverParams(document, first))
    await client.text_document_definition_async(types.DefinitionParams(document, first))
    items = await client.text_document_completion_async(types.CompletionParams(document, types.Position(9999, 0)))
    assert any(item.label == "lerp" for item in items)
    client.text_document_did_close(types.DidCloseTextDocumentParams(document))


@pytest.mark.asyncio(loop_scope="module")
async def test_a_mistake_and_its_fix(client, tmp_path):
    file = tmp_path / "wrong.fl"
    file.write_text("float f(float3 p) { return lenght(p); }\n")
    document = opened(client, file)
    while not client.diagnostics.get(document.uri):
        await client.wait_for_notification(types.TEXT_DOCUMENT_PUBLISH_DIAGNOSTICS)
    found = client.diagnostics[document.uri][0]
    assert found.code == "unknown-function"
    actions = await client.text_document_code_action_async(
        types.CodeActionParams(document, found.range, types.CodeActionContext([found])))
    assert actions[0].edit.changes[document.uri][0].new_text == "length"
    fix = actions[0].edit.changes[document.uri][0]
    client.text_document_did_change(types.DidChangeTextDocumentParams(
        types.VersionedTextDocumentIdentifier(2, document.uri),
        [types.TextDocumentContentChangePartial(fix.range, fix.new_text)]))
    renamed = await client.text_document_rename_async(
        types.RenameParams(document, types.Position(0, 15), "point"))
    assert [edit.new_text for edit in renamed.changes[document.uri]] == ["point", "point"]
