// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// Checks that everything built in is documented in compiler/OPENFL.md. Its examples are tried with
// those of the other pages (tests/scenes/pages_test.cpp).

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "compiler/check/builtins.h"
#include "compiler/check/type.h"
#include "compiler/frontend/modules.h"
#include "tests/support/places/places.h"

namespace openfab::testing {
namespace {

std::string page() {
    std::ifstream in(source_dir() / "compiler/OPENFL.md", std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
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
