// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/sema/check.h"

#include <fmt/format.h>

#include <algorithm>

#include "compiler/sema/check_state.h"

namespace openfab::sema {

namespace {

constexpr int32_t kMaxSlots = 256;  // a world has 64 materials

std::string annotation_text(const ast::Expr& expr) {
    if (expr.kind == ast::ExprKind::kStringLiteral) return std::string(expr.text);
    if (expr.kind == ast::ExprKind::kUnary) {
        return std::string(expr.text) + annotation_text(*expr.args[0]);
    }
    return std::string(expr.text);
}

std::string varying_list(const std::vector<ir::Varying>& list) {
    std::string out;
    for (const ir::Varying& v : list) {
        out += fmt::format("{}`{} {}`", out.empty() ? "" : ", ", v.type_name, v.name);
    }
    return out;
}

int32_t find_varying(const std::vector<ir::Varying>& list, std::string_view name) {
    for (size_t i = 0; i < list.size(); ++i) {
        if (list[i].name == name) return static_cast<int32_t>(i);
    }
    return -1;
}

}  // namespace

void Checker::report_unsupported(const ast::Scope& scope) {
    for (const ast::Unsupported& item : scope.unsupported) {
        sink_->report(item.span, diag::kUnsupported, item.what);
        declare_poisoned(item.name, item.span);
    }
}

/// A name about whose uses nothing is said.
void Checker::declare_poisoned(std::string_view name, const source::Span& span) {
    auto symbol = std::make_unique<Symbol>();
    symbol->name = name;
    symbol->span = span;
    scopes_.back().emplace(symbol->name, symbol.get());
    poisoned_.push_back(std::move(symbol));
}

Type Checker::declared_type(const ast::TypeRef& ref) {
    const TypeLookup found = find_type(ref.text);
    if (!found.type.is_error()) return found.type;
    if (!found.unsupported.empty()) {
        sink_->report(ref.span, diag::kUnsupported, found.unsupported);
    } else if (const Symbol* symbol = find(ref.text);
               symbol == nullptr || !symbol->type.is_error()) {
        diag::Diagnostic& d = sink_->report(ref.span, diag::kUnknownType, ref.text);
        if (!found.help.empty()) d.help(found.help);
    }
    return {};
}

const Symbol* Checker::find(std::string_view name) const {
    for (auto scope = scopes_.rbegin(); scope != scopes_.rend(); ++scope) {
        const auto found = scope->find(name);
        if (found != scope->end()) return found->second;
    }
    return nullptr;
}

bool Checker::declare(const Symbol* symbol) {
    const auto [known, fresh] = scopes_.back().emplace(symbol->name, symbol);
    if (!fresh) {
        diag::Diagnostic& d = sink_->report(symbol->span, diag::kRedeclared, symbol->name);
        if (known->second->span.file != 0) d.note(known->second->span, "the first one is here");
    }
    return fresh;
}

// --- constants and functions

void Checker::check_constants(const std::vector<ast::Variable>& from,
                              std::vector<std::unique_ptr<Symbol>>* to) {
    place_ = Place::kGlobal;
    for (const ast::Variable& v : from) {
        auto symbol = std::make_unique<Symbol>();
        symbol->kind = SymbolKind::kConstant;
        symbol->name = v.name;
        symbol->span = v.span;
        symbol->is_const = true;
        symbol->type = declared_type(v.type);
        if (!symbol->type.is_error() && v.is_array) {
            sink_->report(v.array_span, diag::kUnsupported, "arrays are");
            symbol->type = {};
        } else if (!symbol->type.is_error() && !symbol->type.is_numeric()) {
            sink_->report(v.type.span, diag::kBadDeclaration,
                          fmt::format("a constant cannot have type `{}`", v.type.text));
            symbol->type = {};
        } else if (!symbol->type.is_error() && !v.is_const) {
            sink_
                ->report(v.span, diag::kBadDeclaration,
                         fmt::format("`{}` is outside a function and not `const`", v.name))
                .help(
                    "nothing is kept from voxel to voxel: write `const`, or make it a `@uniform`");
        } else if (!symbol->type.is_error() && v.init == nullptr) {
            sink_->report(v.span, diag::kBadDeclaration,
                          fmt::format("constant `{}` has no value", v.name));
            symbol->type = {};
        }
        if (v.init != nullptr && !symbol->type.is_error()) {
            symbol->init = convert(expression(*v.init), symbol->type);
            if (symbol->init->type.is_error()) symbol->type = {};
        }
        declare(symbol.get());
        to->push_back(std::move(symbol));
    }
}

std::unique_ptr<Symbol> Checker::parameter(const ast::Variable& v) {
    auto symbol = std::make_unique<Symbol>();
    symbol->kind = SymbolKind::kParameter;
    symbol->name = v.name;
    symbol->span = v.span;
    symbol->is_const = v.is_const;
    symbol->is_in = v.is_in || !v.is_out;
    symbol->is_out = v.is_out;
    symbol->type = declared_type(v.type);
    const Base base = symbol->type.base;
    if (base == Base::kVoid) {
        sink_->report(v.type.span, diag::kBadDeclaration, "a parameter cannot have type `void`");
        symbol->type = {};
    } else if (base == Base::kSurfaceAttributes || base == Base::kVolumeAttributes) {
        sink_
            ->report(v.type.span, diag::kUnsupported,
                     fmt::format("parameters of type `{}` are", v.type.text))
            .help("pass what the function needs, such as `attr.voxelCenter`");
        symbol->type = {};
    } else if (v.is_array && !symbol->type.is_error()) {
        sink_->report(v.array_span, diag::kUnsupported, "arrays are");
        symbol->type = {};
    } else if (v.init != nullptr && !symbol->type.is_error()) {
        sink_->report(v.init->span, diag::kUnsupported, "default values of parameters are");
    }
    return symbol;
}

void Checker::declare_functions(const std::vector<ast::Function>& from,
                                std::vector<std::unique_ptr<Function>>* to) {
    for (const ast::Function& f : from) {
        auto function = std::make_unique<Function>();
        function->name = f.name;
        function->span = f.span;
        function->return_type = declared_type(f.return_type);
        for (const ast::Variable& v : f.parameters)
            function->parameters.push_back(parameter(v));
        for (const Function* known : visible_functions_) {
            if (known->name != f.name || !same_parameters(*known, *function)) continue;
            sink_->report(f.span, diag::kRedeclared, f.name)
                .note(known->span, "the first one is here, with the same parameters");
        }
        visible_functions_.push_back(function.get());
        to->push_back(std::move(function));
    }
}

void Checker::check_functions(const std::vector<ast::Function>& from,
                              const std::vector<std::unique_ptr<Function>>& to) {
    const size_t first = to.size() - from.size();  // before them: those of modules
    for (size_t i = 0; i < from.size(); ++i) {
        place_ = Place::kFunction;
        function_ = to[first + i].get();
        return_type_ = function_->return_type;
        loops_ = 0;
        scopes_.emplace_back();
        for (const auto& p : function_->parameters)
            declare(p.get());
        // The parameters and the body's own names share a scope, as in HLSL.
        function_->body = std::make_unique<Stmt>();
        function_->body->span = from[i].body->span;
        for (const ast::StmtPtr& child : from[i].body->body) {
            if (child->kind == ast::StmtKind::kDeclaration) {
                declaration(*child, &function_->body->body);
            } else {
                function_->body->body.push_back(statement(*child));
            }
        }
        scopes_.pop_back();
        function_ = nullptr;
    }
}

namespace {

enum class Visit : uint8_t { kOpen, kDone };

/// Reports the first call that closes a ring, for every ring that a search from `f` meets.
void visit_calls(const Function* f, std::map<const Function*, Visit>* visits, diag::Sink* sink) {
    (*visits)[f] = Visit::kOpen;
    for (const Function::CallSite& call : f->calls) {
        const auto known = visits->find(call.function);
        if (known == visits->end()) {
            visit_calls(call.function, visits, sink);
        } else if (known->second == Visit::kOpen) {
            sink->report(call.span, diag::kRecursion, call.function->name)
                .note(call.function->span,
                      fmt::format("`{}` is declared here", call.function->name))
                .help("OpenFL has no recursion: write a loop");
        }
    }
    (*visits)[f] = Visit::kDone;
}

}  // namespace

void Checker::check_recursion(const std::vector<std::unique_ptr<Function>>& functions) {
    std::map<const Function*, Visit> visits;
    for (const auto& f : functions) {
        if (visits.count(f.get()) == 0) visit_calls(f.get(), &visits, sink_);
    }
}

// --- fablets

void Checker::check_fablet(const ast::Fablet& from, Fablet* to) {
    fablet_ = to;
    to->ir.name = from.name;
    to->ir.span = from.span;
    const size_t file_functions = visible_functions_.size();
    scopes_.emplace_back();
    to->void_material = std::make_unique<Symbol>();
    to->void_material->kind = SymbolKind::kVoid;
    to->void_material->name = "VOID";
    to->void_material->type = {Base::kMaterial, 1};
    to->void_material->is_const = true;
    declare(to->void_material.get());
    scopes_.emplace_back();
    report_unsupported(from.scope);
    for (const ast::Variable& v : from.uniforms)
        check_uniform(v, to);
    declare_functions(from.scope.functions, &to->functions);
    check_constants(from.scope.constants, &to->constants);
    check_functions(from.scope.functions, to->functions);
    check_recursion(to->functions);
    check_stages(from, to);
    scopes_.pop_back();
    scopes_.pop_back();
    visible_functions_.resize(file_functions);
    fablet_ = nullptr;
}

void Checker::check_uniform(const ast::Variable& v, Fablet* to) {
    ir::Uniform uniform;
    uniform.name = v.name;
    uniform.type_name = v.type.text;
    uniform.span = v.span;
    auto symbol = std::make_unique<Symbol>();
    symbol->kind = SymbolKind::kUniform;
    symbol->name = v.name;
    symbol->span = v.span;
    symbol->index = static_cast<int32_t>(to->ir.uniforms.size());
    symbol->type = declared_type(v.type);
    if (v.is_array && !symbol->type.is_error()) {
        sink_->report(v.array_span, diag::kUnsupported, "arrays are");
        symbol->type = {};
    }
    if (symbol->type.base == Base::kTexture2D) {
        uniform.kind = OPENFAB_UNIFORM_TEXTURE2D;
        uniform.first_index = to->ir.texture_count++;
    } else if (symbol->type.base == Base::kMaterial) {
        uniform.kind = OPENFAB_UNIFORM_MATERIAL;
        uniform.first_index = to->ir.slot_count++;
        if (to->ir.slot_count == kMaxSlots + 1) {
            sink_->report(v.span, diag::kTooComplex,
                          fmt::format("more than {} uniforms of type `Material`", kMaxSlots));
        }
    } else if (symbol->type.is_numeric()) {
        uniform.type = component_type(symbol->type);
        uniform.components = symbol->type.size;
        uniform.first_index = to->ir.uniform_value_count;
        to->ir.uniform_value_count += uniform.components;
    } else if (!symbol->type.is_error()) {
        sink_->report(v.type.span, diag::kBadDeclaration,
                      fmt::format("a uniform cannot have type `{}`", v.type.text));
        symbol->type = {};
    }
    if (v.init != nullptr && symbol->type.is_numeric()) {
        place_ = Place::kGlobal;
        symbol->init = convert(expression(*v.init), symbol->type);
    } else if (v.init != nullptr && !symbol->type.is_error()) {
        sink_->report(
            v.init->span, diag::kBadDeclaration,
            fmt::format("a uniform of type `{}` has no default: the world binds it", v.type.text));
    }
    for (const ast::Annotation& a : v.annotations) {
        uniform.annotations.emplace_back(a.name,
                                         a.value == nullptr ? "" : annotation_text(*a.value));
    }
    declare(symbol.get());
    to->ir.uniforms.push_back(std::move(uniform));
    to->uniforms.push_back(std::move(symbol));
}

void Checker::check_stages(const ast::Fablet& from, Fablet* to) {
    const ast::Stage* surface = nullptr;
    const ast::Stage* volume = nullptr;
    for (const ast::Stage& stage : from.stages) {
        const ast::Stage** known = stage.surface ? &surface : &volume;
        if (*known != nullptr) {
            sink_->report(stage.span, diag::kRedeclared, stage.surface ? "@Surface" : "@Volume")
                .note((*known)->span, "the first one is here");
            continue;
        }
        *known = &stage;
    }
    if (surface != nullptr) {
        to->ir.has_surface = true;
        to->surface.span = surface->span;
        scopes_.emplace_back();
        for (const ast::Variable& v : surface->varyings)
            check_varying(v, *surface, to);
        check_stage_body(*surface, &to->surface, Place::kSurface, kFloat3Type);
        scopes_.pop_back();
    }
    if (volume == nullptr) {
        if (!from.name.empty()) sink_->report(from.span, diag::kMissingStage, from.name);
        return;
    }
    to->volume.span = volume->span;
    scopes_.emplace_back();
    for (const ast::Variable& v : volume->varyings)
        check_varying(v, *volume, to);
    check_stage_body(*volume, &to->volume, Place::kVolume, {Base::kComposition, 1});
    scopes_.pop_back();
}

void Checker::check_stage_body(const ast::Stage& from, Stage* to, Place place, const Type& result) {
    place_ = place;
    stage_span_ = from.span;
    return_type_ = result;
    loops_ = 0;
    if (from.body != nullptr) to->body = block(*from.body);
}

void Checker::check_varying(const ast::Variable& v, const ast::Stage& stage, Fablet* to) {
    const Type type = declared_type(v.type);
    const Base base = type.base;
    Stage* owner = stage.surface ? &to->surface : &to->volume;
    if (base == Base::kSurfaceAttributes || base == Base::kVolumeAttributes) {
        if ((base == Base::kSurfaceAttributes) != stage.surface) {
            sink_
                ->report(v.type.span, diag::kStageMismatch, v.type.text,
                         stage.surface ? "in a surface stage" : "in a volume stage")
                .note(stage.span, "the stage is declared here")
                .help(stage.surface ? "here it is `SurfaceAttributes`"
                                    : "here it is `VolumeAttributes`");
            return add_stage_symbol(owner, SymbolKind::kAttributes, v, {}, 0);
        }
        return add_stage_symbol(owner, SymbolKind::kAttributes, v, type, 0);
    }
    if (v.is_array && !type.is_error()) {
        sink_->report(v.array_span, diag::kUnsupported, "arrays are");
        return add_stage_symbol(owner, SymbolKind::kLocal, v, {}, 0);
    }
    if (!type.is_numeric()) {
        if (!type.is_error()) {
            sink_->report(v.type.span, diag::kBadDeclaration,
                          fmt::format("a varying cannot have type `{}`", v.type.text));
        }
        return add_stage_symbol(owner, SymbolKind::kLocal, v, {}, 0);
    }
    if (stage.surface) return check_surface_varying(v, type, to);
    check_nearest(v, type, to);
}

ir::Varying Checker::varying(const ast::Variable& v, const Type& type) const {
    ir::Varying out;
    out.name = v.name;
    out.type_name = v.type.text;
    out.type = component_type(type);
    out.components = type.size;
    out.span = v.span;
    return out;
}

void Checker::add_stage_symbol(Stage* stage, SymbolKind kind, const ast::Variable& v,
                               const Type& type, size_t index) {
    auto symbol = std::make_unique<Symbol>();
    symbol->kind = kind;
    symbol->name = v.name;
    symbol->type = type;
    symbol->span = v.span;
    symbol->index = static_cast<int32_t>(index);
    symbol->is_const = v.is_const;
    declare(symbol.get());
    stage->symbols.push_back(std::move(symbol));
}

void Checker::check_surface_varying(const ast::Variable& v, const Type& type, Fablet* to) {
    if (v.nearest) {
        sink_->report(v.span, diag::kStageMismatch, "@nearest", "in a surface stage")
            .note(to->surface.span, "stage declared `@Surface` here")
            .help("the surface stage runs on the surface: leave `@nearest` out");
    }
    if (v.is_in && v.is_out) sink_->report(v.span, diag::kUnsupported, "`inout` varyings are");
    if (v.is_out) {
        if (v.init != nullptr) {
            sink_->report(v.init->span, diag::kBadDeclaration,
                          "an output has no default: assign it in the stage");
        }
        add_stage_symbol(&to->surface, SymbolKind::kSurfaceOutput, v, type,
                         to->ir.surface_outputs.size());
        to->ir.surface_outputs.push_back(varying(v, type));
        return;
    }
    auto fallback = std::make_unique<Symbol>();
    fallback->span = v.span;
    fallback->type = type;
    if (v.init != nullptr) {
        place_ = Place::kGlobal;
        fallback->init = convert(expression(*v.init), type);
    }
    add_stage_symbol(&to->surface, SymbolKind::kSurfaceInput, v, type,
                     to->ir.surface_inputs.size());
    to->ir.surface_inputs.push_back(varying(v, type));
    to->surface_inputs.push_back(std::move(fallback));
}

void Checker::check_nearest(const ast::Variable& v, const Type& type, Fablet* to) {
    if (v.is_out) {
        sink_->report(v.span, diag::kStageMismatch, "out", "varying in a volume stage")
            .note(to->volume.span, "stage declared `@Volume` here")
            .help("the volume stage returns its result, a `MaterialComposition`");
    } else if (!v.nearest) {
        sink_->report(v.span, diag::kMissingNearest, v.name)
            .help(fmt::format("in the volume a varying comes from the nearest surface point: write "
                              "`@nearest {} {}`",
                              v.type.text, v.name));
    }
    if (v.init != nullptr)
        sink_->report(v.init->span, diag::kUnsupported, "default values of `@nearest` are");
    ir::Varying nearest = varying(v, type);
    const std::vector<ir::Varying>& outputs = to->ir.surface_outputs;
    nearest.source = find_varying(outputs, v.name);
    if (nearest.source < 0) nearest.source = find_varying(outputs, std::string(v.name) + "Out");
    if (nearest.source >= 0) {
        const ir::Varying& output = outputs[static_cast<size_t>(nearest.source)];
        if (output.type != nearest.type || output.components != nearest.components) {
            sink_
                ->report(v.type.span, diag::kVaryingMismatch, v.type.text, v.name, output.type_name,
                         output.name)
                .note(output.span,
                      fmt::format("`out {} {}` is declared here", output.type_name, output.name))
                .help("the outputs of the surface stage are " + varying_list(outputs));
        }
    }
    add_stage_symbol(&to->volume, SymbolKind::kNearest, v, type, to->ir.nearest.size());
    to->ir.nearest.push_back(std::move(nearest));
}

}  // namespace openfab::sema
