// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Compiles each block of compiler/OPENFL.md that is marked `openfl`: a whole file; with
// `statements` the body of a volume stage; with `wrong id` code that gives exactly that message.
// Also checks that everything built in is documented there.

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "compiler/check/builtins.h"
#include "compiler/check/type.h"
#include "compiler/diag/render.h"
#include "compiler/frontend/frontend.h"
#include "compiler/frontend/modules.h"

namespace openfab::testing {
namespace {

struct Block {
    int line = 0;
    std::string kind;  ///< the words after `openfl`
    std::string text;
};

std::string page() {
    std::ifstream in(std::string(OPENFAB_SOURCE_DIR) + "/compiler/OPENFL.md", std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

std::vector<Block> blocks() {
    std::vector<Block> out;
    std::ifstream in(std::string(OPENFAB_SOURCE_DIR) + "/compiler/OPENFL.md");
    bool open = false;
    int number = 0;
    for (std::string line; std::getline(in, line);) {
        ++number;
        if (line.rfind("```", 0) == 0) {
            open = !open && line.rfind("```openfl", 0) == 0;
            if (open) out.push_back({number, line.substr(std::min<size_t>(line.size(), 10)), ""});
        } else if (open) {
            out.back().text += line + '\n';
        }
    }
    return out;
}

TEST(Reference, ItsExamplesCompile) {
    const std::vector<Block> all = blocks();
    EXPECT_GE(all.size(), 10u);
    for (const Block& block : all) {
        std::string text = block.text;
        if (block.kind == "statements") {
            text.insert(0,
                        "fablet A { @Volume(@varying { VolumeAttributes attr }) { "
                        "MaterialComposition mc;\n");
            text += "return mc; } }";
        }
        source::SourceManager sources;
        diag::Sink sink;
        const uint32_t file = sources.add("example.fl", text);
        (void)frontend::compile_to_ir(sources, file, sink,
                                      {.need_fablet = false, .enable_printf = true});
        const std::string messages = diag::render_text(sink, sources);
        if (block.kind.rfind("wrong ", 0) != 0) {
            EXPECT_EQ(messages, "") << "the block at line " << block.line;
            continue;
        }
        EXPECT_FALSE(sink.sorted().empty()) << "the block at line " << block.line;
        for (const diag::Diagnostic& d : sink.sorted())
            EXPECT_EQ(diag::id_text(d.id), block.kind.substr(6)) << messages;
    }
}

TEST(Reference, NamesAllThatIsBuiltIn) {
    const std::string text = page();
    const auto named = [&](const std::string& word) {
        return text.find("`" + word + "`") != std::string::npos ||
               text.find("`" + word + "(") != std::string::npos ||
               text.find(" " + word + "(") != std::string::npos;
    };
    for (const std::string& name : check::function_names())
        EXPECT_TRUE(named(name)) << name;
    for (const std::string& name : frontend::library_modules())
        EXPECT_TRUE(named(name)) << name;
    for (const std::string& name : check::type_names())
        EXPECT_NE(text.find(name.substr(0, name.find_first_of("234"))), std::string::npos) << name;
}

}  // namespace
}  // namespace openfab::testing
