// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab new NAME`: makes a folder with a fablet and a printable world to start from.

#include <fmt/format.h>

#include <memory>

#include "base/say.h"
#include "base/text.h"
#include "tools/openfab/commands.h"
#include "tools/openfab/stock.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

void replace_all(std::string* text, std::string_view from, const std::string& to) {
    for (size_t at = 0; (at = text->find(from, at)) != std::string::npos; at += to.size())
        text->replace(at, from.size(), to);
}

/// Converts `soft_toy` to a fablet's name, `SoftToy`.
std::string fablet_name(const std::string& name) {
    std::string out;
    bool capital = true;
    for (const char c : name) {
        const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
        if (!letter && !(c >= '0' && c <= '9')) {
            capital = true;
            continue;
        }
        out.push_back(capital && c >= 'a' && c <= 'z' ? static_cast<char>(c - 32) : c);
        capital = false;
    }
    return out;
}

}  // namespace

Result<void> make_folder(const std::string& path) {
    const fs::path folder = fs::path(path).lexically_normal();
    std::string name = folder.filename().string();
    if (name.empty()) name = folder.parent_path().filename().string();
    const std::string fablet = fablet_name(name);
    const bool plain = name.find_first_not_of(
                           "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                           "0123456789_-") == std::string::npos;
    if (!plain || fablet.empty() || (fablet[0] >= '0' && fablet[0] <= '9')) {
        return usage_error(
            fmt::format("no fablet can be named after `{}`; use letters, digits, - and _, "
                        "a letter first",
                        path));
    }
    std::error_code status;
    if (fs::exists(folder, status))
        return user_error(fmt::format("`{}` exists already; choose another name", path));
    for (const char* suffix : {".fl", ".fab.json"}) {
        std::string text(stock_text(std::string("starter") + suffix));
        replace_all(&text, "FABLET", fablet);
        replace_all(&text, "NAME", name);
        if (Result<void> done = write_file(folder / (name + suffix), text); !done) return done;
    }
    if (Result<void> done =
            write_file(folder / "fab_world.schema.json", stock_text("fab_world.schema.json"));
        !done)
        return done;
    const fs::path world = folder / (name + ".fab.json");
    say(fmt::format("made {}\nprint it: openfab print {} -o {}.ofr --preview {}.png,view=section\n",
                    world.string(), shell_word(world.string()), name, name));
    return {};
}

}  // namespace openfab::tools
