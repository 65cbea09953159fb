// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/frontend/modules.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <iterator>

#include "base/input_file.h"
#include "compiler/frontend/library_modules.h"
#include "compiler/syntax/parser.h"

namespace openfab::frontend {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSuffix = ".fl";

const EmbeddedText* find_in_library(const std::string& name) {
    const std::string file = name + std::string(kSuffix);
    const EmbeddedText* module =
        std::find_if(std::begin(kLibraryModules), std::end(kLibraryModules),
                     [&](const EmbeddedText& text) { return text.name == file; });
    return module == std::end(kLibraryModules) ? nullptr : module;
}

/// Returns the module of each name that the standard library exports.
std::map<std::string, std::string, std::less<>> names_of_library() {
    std::map<std::string, std::string, std::less<>> out;
    for (const EmbeddedText& module : kLibraryModules) {
        source::SourceManager sources;
        diag::Sink quiet;
        const uint32_t file = sources.add(std::string(module.name), std::string(module.text));
        const ast::File tree = syntax::parse(sources, syntax::lex(sources, file, &quiet), &quiet);
        const std::string name(module.name.substr(0, module.name.size() - kSuffix.size()));
        const auto add = [&](const auto& list) {
            for (const auto& item : list) {
                if (!item.name.starts_with('_')) out.emplace(item.name, name);
            }
        };
        add(tree.scope.functions);
        add(tree.scope.constants);
        add(tree.scope.structs);
    }
    return out;
}

std::string listed(const std::vector<std::string>& names) {
    std::string out;
    for (const std::string& name : names)
        out += fmt::format("{}`{}`", out.empty() ? "" : ", ", name);
    return out;
}

}  // namespace

std::vector<std::string> library_modules() {
    std::vector<std::string> out;
    for (const EmbeddedText& module : kLibraryModules)
        out.emplace_back(module.name.substr(0, module.name.size() - kSuffix.size()));
    return out;
}

std::string library_text(std::string_view name) {
    const EmbeddedText* module = find_in_library(std::string(name));
    return module == nullptr ? std::string() : std::string(module->text);
}

std::string library_module_of(std::string_view name) {
    static const std::map<std::string, std::string, std::less<>> known = names_of_library();
    const auto found = known.find(name);
    return found == known.end() ? std::string() : found->second;
}

std::vector<std::string> modules_beside(const fs::path& folder) {
    std::vector<std::string> out;
    std::error_code error;
    if (folder.empty()) return out;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
        if (entry.path().extension() == ".fl") out.push_back(entry.path().stem().string());
    }
    return out;
}

const std::vector<check::Unit>& Modules::load(uint32_t program) {
    // A program may not be imported by its own modules.
    const fs::path path(std::string(sources_->name(program)));
    std::error_code error;
    if (!sources_->folder(program).empty()) {
        const fs::path full = fs::weakly_canonical(sources_->folder(program) / path.filename());
        known_.emplace(full.string(), Entry{program, 0, false});
    }
    parse(program, "");
    return units_;
}

std::optional<size_t> Modules::parse(uint32_t file, const std::string& name) {
    const size_t errors = sink_->errors();
    syntax::Lost lost;
    const std::vector<syntax::Token> tokens = syntax::lex(*sources_, file, sink_, &lost);
    const bool stop = on_error_ == OnError::kStop;
    const bool program = name.empty();
    if (stop && sink_->errors() != errors && !(program && lost.whole)) return std::nullopt;
    ast::File& tree = files_.emplace_back(syntax::parse(*sources_, tokens, sink_));
    tree.damaged.insert(tree.damaged.end(), lost.lines.begin(), lost.lines.end());
    check::Unit unit{&tree, name, {}};
    for (const ast::Import& item : tree.imports) {
        if (const std::optional<size_t> at = import(item, file)) unit.imports.push_back(*at);
    }
    if (stop && !program && sink_->errors() != errors) return std::nullopt;
    can_check_ = program && unit.imports.size() == tree.imports.size();
    units_.push_back(std::move(unit));
    return units_.size() - 1;
}

std::optional<uint32_t> Modules::find(const ast::Import& import, uint32_t from, std::string* key) {
    const std::string name(import.name);
    const fs::path folder = sources_->folder(from);
    const fs::path path = folder / (name + ".fl");
    std::error_code error;
    // Where something else has that name, loading says what it is.
    if (!folder.empty() && fs::exists(fs::symlink_status(path, error))) {
        *key = fs::weakly_canonical(path, error).string();
        if (const auto known = known_.find(*key); known != known_.end()) return known->second.file;
        std::string fault;
        // A module belongs to the fablet: a symbolic link may not lead out of its folder or
        // project.
        const std::optional<uint32_t> file = sources_->load(path, &fault, {reading_root(folder)});
        if (!file) sink_->report(import.span, diag::kBadModule, name, "cannot be read").help(fault);
        return file;
    }
    const EmbeddedText* module = find_in_library(name);
    if (module == nullptr) {
        report_unknown(import, from);
        return std::nullopt;
    }
    *key = "library " + name;
    if (const auto known = known_.find(*key); known != known_.end()) return known->second.file;
    return sources_->add("stdlib/" + name + ".fl", std::string(module->text));
}

std::optional<size_t> Modules::import(const ast::Import& import, uint32_t from) {
    std::string key;
    const std::optional<uint32_t> file = find(import, from, &key);
    if (!file) return std::nullopt;
    if (const auto known = known_.find(key); known != known_.end()) {
        if (known->second.done) return known->second.unit;
        // The notes of a message inside a module lead back to the start of the cycle.
        sink_->report(import.span, diag::kBadModule, import.name, "imports itself");
        return std::nullopt;
    }
    const std::string name(import.name);
    sink_->set_origin(*file, import.span, fmt::format("`{}` is imported here", name));
    return parse_module(*file, key, name, import.span);
}

std::optional<size_t> Modules::load_module(const fs::path& path, std::string* fault) {
    const std::optional<uint32_t> file = sources_->load(path, fault);
    if (!file) return std::nullopt;
    std::error_code error;
    return parse_module(*file, fs::weakly_canonical(path, error).string(), path.stem().string(),
                        {});
}

/// Parses a module that is known by `key` from here on.
std::optional<size_t> Modules::parse_module(uint32_t file, const std::string& key,
                                            const std::string& name,
                                            std::optional<source::Span> import) {
    Entry& entry = known_[key];
    entry.file = file;
    const std::optional<size_t> unit = parse(file, name);
    if (!unit) return std::nullopt;
    entry.done = true;
    entry.unit = *unit;
    const ast::File& tree = *units_[*unit].file;
    if (!tree.fablets.empty()) {
        sink_
            ->report(import.value_or(tree.fablets[0].span), diag::kBadModule, name,
                     "holds a fablet")
            .note(tree.fablets[0].span, "the fablet is here")
            .help(
                "a module has functions, constants and structs: move those to a file of their own");
        return std::nullopt;
    }
    return unit;
}

void Modules::report_unknown(const ast::Import& import, uint32_t from) {
    const std::vector<std::string> library = library_modules();
    std::vector<std::string> names = modules_beside(sources_->folder(from));
    names.insert(names.end(), library.begin(), library.end());
    sink_->report(import.span, diag::kUnknownModule, import.name)
        .suggest(import.span, import.name, names,
                 fmt::format("it is neither a file `{}.fl` beside this one nor one of the standard "
                             "library, which has {}",
                             import.name, listed(library)));
}

}  // namespace openfab::frontend
