// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab new NAME`: makes a folder with a fablet and a printable world to start from: the starter, or a stock fablet
// on a box.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <utility>

#include "base/input_file.h"
#include "base/own_folder.h"
#include "base/say.h"
#include "base/text.h"
#include "tools/openfab/commands.h"
#include "tools/openfab/messages.h"
#include "tools/openfab/stock.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

/// The first is the one that is meant to be learnt from; the others are stock fablets that want a mesh alone.
constexpr std::array<const char*, 6> kTemplates{"starter", "solid",   "graded",
                                                "shell",   "lattice", "infill"};
constexpr int64_t kLargestText = 1 << 20;

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

struct Started {
    std::string fablet, world;  ///< their texts
};

Started starter(const std::string& name, const std::string& fablet) {
    Started out{std::string(stock_text("starter.fl")), std::string(stock_text("starter.fab.json"))};
    for (std::string* text : {&out.fablet, &out.world}) {
        replace_all(text, "FABLET", fablet);
        replace_all(text, "NAME", name);
    }
    return out;
}

/// As `openfab import` makes it of a box, with the box itself in place of its mesh.
Result<Started> stock_started(const std::string& name, const std::string& stock) {
    const Result<std::unique_ptr<TemporaryFolder>> folder = TemporaryFolder::create({});
    if (!folder) return folder.error();
    const fs::path mesh = (*folder)->path() / (name + ".obj");
    constexpr std::string_view kBox =
        "v -10 -10 0\nv 10 -10 0\nv 10 10 0\nv -10 10 0\nv -10 -10 20\nv 10 -10 20\nv 10 10 20\nv "
        "-10 10 20\n"
        "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    if (Result<void> written = write_file(mesh, kBox); !written) return written.error();
    ImportArguments import;
    import.file = mesh.string();
    import.folder = ((*folder)->path() / "made").string();
    import.unit = "mm";
    import.quiet = true;
    import.import.fablet = stock;
    const Result<fs::path> world = import_mesh(std::move(import));
    if (!world) return world.error();
    Started out;
    for (const auto& [file, text] :
         {std::pair(*world, &out.world),
          std::pair(world->parent_path() / ("stock_" + stock + ".fl"), &out.fablet)}) {
        const Result<InputFile> opened = InputFile::open(file);
        if (!opened) return opened.error();
        Result<std::string> read = opened->read_all(kLargestText);
        if (!read) return read.error();
        *text = std::move(*read);
    }
    replace_all(&out.world, fmt::format("{{\"file\": \"{}.obj\", \"unit\": \"mm\"}}", name),
                "{\"box\": [20, 20, 20]}");
    replace_all(&out.world, "stock_" + stock + ".fl", name + ".fl");
    return out;
}

}  // namespace

std::string template_names() {
    std::string out;
    for (const char* one : kTemplates)
        out += fmt::format("{}{}", out.empty() ? "" : ", ", one);
    return out;
}

std::vector<std::string> template_list() {
    return {kTemplates.begin(), kTemplates.end()};
}

Result<std::string> make_folder(const std::string& path, const std::string& from) {
    if (std::find(kTemplates.begin(), kTemplates.end(), from) == kTemplates.end()) {
        return usage_error(fmt::format(messages::kNoSuchTemplate, from, template_names()));
    }
    const fs::path folder = fs::path(path).lexically_normal();
    std::string name = folder.filename().string();
    if (name.empty()) name = folder.parent_path().filename().string();
    const std::string fablet = fablet_name(name);
    const bool plain = name.find_first_not_of(
                           "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                           "0123456789_-") == std::string::npos;
    if (!plain || fablet.empty() || (fablet[0] >= '0' && fablet[0] <= '9')) {
        return usage_error(fmt::format(messages::kNoFabletName, path));
    }
    std::error_code status;
    if (fs::exists(folder, status)) return user_error(fmt::format(messages::kNameExists, path));
    const Result<Started> made =
        from == kTemplates[0] ? Result<Started>(starter(name, fablet)) : stock_started(name, from);
    if (!made) return made.error();
    for (const auto& [suffix, text] :
         {std::pair(".fl", &made->fablet), std::pair(".fab.json", &made->world)}) {
        if (Result<void> done = write_file(folder / (name + suffix), *text); !done)
            return done.error();
    }
    if (Result<void> done =
            write_file(folder / "fab_world.schema.json", stock_text("fab_world.schema.json"));
        !done)
        return done.error();
    const fs::path world = folder / (name + ".fab.json");
    return fmt::format(
        "made {}\nprint it: openfab print {} -o {}.ofr --preview {}.png,view=model:30:30,cut=xy\n",
        world.string(), shell_word(world.string()), name, name);
}

}  // namespace openfab::tools
