// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/check/checker.h"

#include <fmt/format.h>

#include <map>
#include <string>
#include <string_view>
#include <utility>

namespace openfab::check {

namespace {

/// True for names that a module does not export.
bool is_private(std::string_view name) {
    return name.substr(0, 1) == "_";
}

/// A visible name and the import that it comes from.
struct Origin {
    size_t import = 0;
    source::Span span;
};

}  // namespace

bool same_parameters(const Function& a, const Function& b) {
    if (a.parameters.size() != b.parameters.size()) return false;
    for (size_t i = 0; i < a.parameters.size(); ++i) {
        if (a.parameters[i]->type != b.parameters[i]->type) return false;
    }
    return true;
}

Program check(const std::vector<Unit>& units, const CheckOptions& options, diag::Sink* sink) {
    Program program;
    Checker(options, &program, sink).run(units, options);
    return program;
}

void Checker::run(const std::vector<Unit>& units, const CheckOptions& options) {
    std::vector<Exports> done;
    for (size_t i = 0; i < units.size(); ++i) {
        check_unit(units[i], &done);
        if (!options.rule.name.empty() && i == options.rule.unit)
            find_rule(units[i], done[i], options.rule.name);
    }
    const ast::File& file = *units.back().file;
    const bool empty = done.back().names.empty() && done.back().functions.empty();
    if (file.fablets.empty() && (options.need_fablet || empty) && sink_->errors() == 0) {
        sink_->report(file.end, diag::kNoFablet);
    }
}

void Checker::check_unit(const Unit& unit, std::vector<Exports>* done) {
    const ast::File& file = *unit.file;
    names_.begin_file();
    unknown_.begin_file(file);
    import_names(unit, *done);
    names_.open();
    declarations_.scope(file.scope, {}, {}, &program_.constants, &program_.functions);
    done->push_back({names_.scopes().back(), names_.functions()});
    check_fablets(file);
    check_recursion(program_.functions, sink_);
}

/// Adds the exports of the modules that `unit` imports, as an outermost scope.
void Checker::import_names(const Unit& unit, const std::vector<Exports>& done) {
    std::map<std::string, Origin, std::less<>> known;
    const auto clash = [&](const std::string& name, size_t import, const source::Span& span) {
        const Origin& first = known.at(name);
        const std::vector<ast::Import>& imports = unit.file->imports;
        sink_
            ->report(imports[import].span, diag::kModuleClash, name, imports[first.import].name,
                     imports[import].name)
            .note(first.span, "the first one is here")
            .note(span, "the second one is here");
    };
    for (size_t i = 0; i < unit.imports.size(); ++i) {
        const Exports& module = done[unit.imports[i]];
        for (const auto& [name, symbol] : module.names) {
            if (is_private(name)) {
                names_.add_private(name, std::string(unit.file->imports[i].name));
                continue;
            }
            const bool fresh = known.try_emplace(name, Origin{i, symbol->span}).second;
            const auto [at, added] = names_.imports().emplace(name, symbol);
            if (!fresh && (added || at->second != symbol)) clash(name, i, symbol->span);
        }
        for (const Function* f : module.functions) {
            if (is_private(f->name)) {
                names_.add_private(f->name, std::string(unit.file->imports[i].name));
                continue;
            }
            known.try_emplace(f->name, Origin{i, f->span});
            bool again = false;
            bool other = names_.imports().count(f->name) != 0;
            for (const Function* g : names_.imported()) {
                again = again || f == g;
                other = other || (f->name == g->name && same_parameters(*f, *g));
            }
            if (other && !again) clash(f->name, i, f->span);
            if (!again) names_.import(f);
        }
    }
}

/// Finds the function of a module that is the dither rule of fablets without one.
void Checker::find_rule(const Unit& unit, const Exports& exports, const std::string& name) {
    std::vector<std::string> rules;
    const Function* other = nullptr;
    for (const Function* f : exports.functions) {
        if (is_private(f->name)) continue;
        const bool fits = f->return_type == kIntType && f->parameters.size() == 1 &&
                          f->parameters[0]->type.is(Base::kDitherAttributes);
        if (fits) rules.push_back(f->name);
        if (f->name != name) continue;
        if (fits) {
            fablets_.set_rule(f);
            return;
        }
        other = f;
    }
    if (other != nullptr) {
        sink_
            ->report(
                other->span, diag::kBadDeclaration,
                fmt::format("`{}` is to be a dither rule, but is not of the form of one", name))
            .help(fmt::format("a rule is `int {}(DitherAttributes voxel)`", name));
        return;
    }
    diag::Diagnostic& d = sink_->report(unit.file->end, diag::kUnknownFunction, name);
    if (rules.empty()) {
        d.help(fmt::format("module `{}` has no dither rule: write `int {}(DitherAttributes voxel)`",
                           unit.name, name));
        return;
    }
    std::string list;
    for (const std::string& rule : rules)
        list += fmt::format("{}`{}`", list.empty() ? "" : ", ", rule);
    d.help(fmt::format("the dither rules of module `{}` are {}", unit.name, list));
}

void Checker::check_fablets(const ast::File& file) {
    std::map<std::string_view, source::Span> names;
    for (const ast::Fablet& fablet : file.fablets) {
        const auto [known, fresh] = names.emplace(fablet.name, fablet.span);
        if (!fresh && !fablet.name.empty()) {
            sink_->report(fablet.span, diag::kRedeclared, fablet.name)
                .note(known->second, "the first one is here");
        }
        program_.fablets.emplace_back();
        fablets_.check(fablet, &program_.fablets.back());
    }
}

}  // namespace openfab::check
