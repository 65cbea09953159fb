// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/part/program_stage.h"

#include "base/hash.h"
#include "base/input_file.h"
#include "base/talking_program.h"

namespace openfab::part {

namespace {

constexpr int64_t kLongestScript = 1 << 26;

/// A script that changes is another program.
void add_file(const std::filesystem::path& file, const std::vector<std::filesystem::path>& roots,
              Hasher* hash) {
    const Result<InputFile> opened = InputFile::open(file, roots);
    if (!opened) return;  // a word that is no file
    if (const Result<std::string> text = opened->read_all(kLongestScript); text)
        hash->add_text(*text);
}

}  // namespace

std::shared_ptr<const ProgramTable> make_program_table(
    std::shared_ptr<const world::ProgramRef> program,
    const std::vector<std::filesystem::path>& roots) {
    auto out = std::make_shared<ProgramTable>();
    out->program = std::move(program);
    const world::ProgramRef& of = *out->program;
    Hasher hash;
    hash.add_text(of.version);
    // Of who answers in this process the version tells.
    for (const std::string& word : of.command) {
        if (of.command[0] == kThisProcess) break;
        hash.add_text(word);
        add_file(of.folder / word, roots, &hash);
    }
    for (const std::string& place : of.places)
        hash.add_text(place);
    for (const world::ProgramRef::Attribute& attribute : of.attributes) {
        hash.add_text(attribute.name);
        hash.add_text(attribute.type);
        out->outputs.push_back({attribute.name.c_str(), attribute.type.c_str(),
                                attribute.is_int ? OPENFAB_INT : OPENFAB_FLOAT,
                                attribute.components, -1, nullptr});
    }
    out->shape.output_count = static_cast<int32_t>(out->outputs.size());
    out->shape.outputs = out->outputs.data();
    out->fablet.abi_version = OPENFAB_ABI_VERSION;
    out->fablet.name = "program";
    out->fablet.source_name = "";
    out->fablet.hash = hash.value();
    out->fablet.void_slot = -1;
    out->fablet.shape = &out->shape;
    return out;
}

}  // namespace openfab::part
