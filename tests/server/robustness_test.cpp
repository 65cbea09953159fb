// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
//
// Damaged documents and damaged messages: the server answers all of them and goes on.

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "base/json_text.h"
#include "compiler/server/server.h"
#include "compiler/server/transport.h"
#include "tests/fuzz/mutations/mutate.h"
#include "tests/support/long_run.h"
#include "tests/support/places/places.h"

namespace openfab::server {
namespace {

namespace fs = std::filesystem;

// Sanitizers take ten times as long.
#ifdef OPENFAB_SANITIZED
constexpr int kLess = 10;
#else
constexpr int kLess = 1;
#endif
constexpr size_t kEvery = 3 * kLess;

constexpr const char* kPlaced[] = {"hover",      "completion", "signatureHelp",
                                   "definition", "references", "prepareRename"};
constexpr const char* kWhole[] = {"documentSymbol", "semanticTokens/full", "formatting",
                                  "documentColor"};

std::vector<std::string> documents() {
    std::vector<fs::path> files;
    for (const char* folder : {"tests/lang", "gallery", "stdlib"}) {
        for (const auto& entry : fs::recursive_directory_iterator(testing::source_dir() / folder)) {
            if (entry.path().extension() == ".fl") files.push_back(entry.path());
        }
    }
    std::sort(files.begin(), files.end());
    std::vector<std::string> out;
    for (const fs::path& file : files) {
        std::ifstream in(file, std::ios::binary);
        std::ostringstream text;
        text << in.rdbuf();
        out.push_back(text.str());
    }
    return out;
}

std::string request(int id, const std::string& method, const std::string& rest) {
    return fmt::format(
        R"({{"jsonrpc":"2.0","id":{},"method":"textDocument/{}","params":{{"textDocument":{{"uri":"untitled:a"}}{}}}}})",
        id, method, rest);
}

std::string opening(const std::string& text) {
    JsonText out;
    out.begin_object()
        .member("jsonrpc", "2.0")
        .member("method", "textDocument/didOpen")
        .key("params")
        .begin_object();
    out.key("textDocument")
        .begin_object()
        .member("uri", "untitled:a")
        .member("version", 1)
        .member("text", text);
    out.end_object().end_object().end_object();
    return out.take();
}

constexpr const char* kInitialize =
    R"({"id":0,"method":"initialize","params":{"capabilities":{}}})";

TEST(Robustness, DamagedDocumentsAreAnswered) {
    std::mt19937_64 random(20261125);
    const std::vector<std::string> texts = documents();
    const int rounds = (testing::long_run() ? 5000 : 400) / kLess;
    Server server;
    server.handle(kInitialize);
    for (int round = 0; round < rounds; ++round) {
        std::string text = texts[random() % texts.size()];
        const auto damage = random() % 3;
        if (damage == 0) text.resize(random() % (text.size() + 1));
        if (damage == 1) text = testing::mutate(text, true, &random);
        if (damage == 2) {
            // Braces, brackets and words gone: what typing looks like.
            for (int k = 0; k < 4 && !text.empty(); ++k)
                text.erase(random() % text.size(), random() % 8);
        }
        server.handle(opening(text));
        ASSERT_EQ(server.publish().size(), 1U);
        for (const char* method : kPlaced) {
            const std::string place = fmt::format(R"(,"position":{{"line":{},"character":{}}})",
                                                  random() % 60, random() % 60);
            ASSERT_EQ(server.handle(request(round, method, place)).size(), 1U) << method << "\n"
                                                                               << text;
        }
        for (const char* method : kWhole)
            ASSERT_EQ(server.handle(request(round, method, "")).size(), 1U) << method << "\n"
                                                                            << text;
        const std::string range =
            R"(,"range":{"start":{"line":0,"character":0},"end":{"line":99,"character":0}})";
        ASSERT_EQ(server.handle(request(round, "codeAction", range)).size(), 1U) << text;
    }
}

TEST(Robustness, EveryAnswerIsJsonInsideItsDocument) {
    const std::vector<std::string> texts = documents();
    for (size_t i = 0; i < texts.size(); i += kEvery) {
        const std::string& text = texts[i];
        Server server;
        server.handle(kInitialize);
        server.handle(opening(text));
        std::vector<std::string> answers = server.publish();
        for (const char* method : kWhole)
            answers.push_back(server.handle(request(1, method, "")).at(0));
        for (const std::string& answer : answers) {
            const Result<JsonValue> read = parse_json(answer, "answer");
            ASSERT_TRUE(read) << read.error().text() << "\n" << answer;
            EXPECT_EQ(read->find("error"), nullptr) << answer;
        }
    }
}

TEST(Robustness, DamagedMessagesAreAnsweredOrEndTheSession) {
    std::mt19937_64 random(20261126);
    std::string session;
    session += framed(kInitialize);
    session += framed(opening("fablet A { @Volume() { MaterialComposition mc; return mc; } }"));
    for (const char* method : kPlaced)
        session +=
            framed(request(1, method, R"(,"position":{"line":0,"character":30},"newName":"x")"));
    session +=
        framed(request(2, "rename", R"(,"position":{"line":0,"character":44},"newName":"x")"));
    session += framed(
        R"({"method":"textDocument/didChange","params":{"textDocument":{"uri":"untitled:a","version":2},"contentChanges":[{"range":{"start":{"line":0,"character":3},"end":{"line":0,"character":9}},"text":"ab"}]}})");
    session += framed(R"({"id":3,"method":"shutdown"})") + framed(R"({"method":"exit"})");
    const int rounds = (testing::long_run() ? 20000 : 1000) / kLess;
    int answered = 0;
    for (int round = 0; round < rounds; ++round) {
        Server server;
        MessageReader reader;
        reader.add(testing::mutate(session, true, &random));
        while (const auto message = reader.next()) {
            answered += static_cast<int>(server.handle(*message).size());
            server.publish();
        }
    }
    EXPECT_GT(answered, rounds);
}

}  // namespace
}  // namespace openfab::server
