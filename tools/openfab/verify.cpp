// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab verify FILE.ofr`: every checksum, every slice, the index.

#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "backends/ofr/ofr_reader.h"
#include "tools/openfab/commands.h"

namespace openfab::tool {

namespace {

Result<void> verify(const std::string& file) {
    Result<std::unique_ptr<ofr::OfrReader>> reader = ofr::OfrReader::open(file);
    if (!reader) return reader.error();
    for (;;) {
        Result<bool> more = (*reader)->next();
        if (!more) return more.error();
        if (!*more) break;
    }
    fmt::print(stderr, "{}: all {} slices are whole, hash {:016x}\n", file,
               (*reader)->whole_slices(), (*reader)->hash());
    return {};
}

}  // namespace

void add_verify(CLI::App& app, Action* action) {
    CLI::App* command =
        app.add_subcommand("verify", "check every slice of an .ofr file, or - for standard input");
    auto file = std::make_shared<std::string>();
    command->add_option("FILE", *file, "an .ofr file")->required();
    command->callback([file, action] { *action = [file] { return verify(*file); }; });
}

}  // namespace openfab::tool
