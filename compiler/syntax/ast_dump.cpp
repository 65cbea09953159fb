// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/syntax/ast.h"

namespace openfab::ast {

namespace {

constexpr const char* kExprNames[] = {
#define OPENFAB_AST_EXPR(name) #name,
#include "compiler/syntax/nodes.def"
};

constexpr const char* kStmtNames[] = {
#define OPENFAB_AST_STMT(name) #name,
#include "compiler/syntax/nodes.def"
};

class Printer {
  public:
    std::string run(const File& file) {
        for (const Import& import : file.imports)
            line(0, "Import " + std::string(import.name));
        print_scope(file.scope, 0);
        for (const Fablet& fablet : file.fablets)
            print_fablet(fablet);
        return std::move(out_);
    }

  private:
    void line(int depth, const std::string& text) {
        out_ += std::string(static_cast<size_t>(depth) * 2, ' ') + text + '\n';
    }
    static std::string words(const char* kind, std::string_view text) {
        return text.empty() ? kind : std::string(kind) + ' ' + std::string(text);
    }

    void print_expr(const Expr* expr, int depth) {
        if (expr == nullptr) return;
        const bool literal = expr->kind == ExprKind::kCall || expr->kind == ExprKind::kIndex ||
                             expr->kind == ExprKind::kInitList;
        line(depth, words(kExprNames[static_cast<size_t>(expr->kind)],
                          literal ? std::string_view{} : expr->text));
        for (const ExprPtr& arg : expr->args)
            print_expr(arg.get(), depth + 1);
    }

    void print_variable(const char* role, const Variable& v, int depth) {
        std::string text = role;
        if (v.is_const) text += " const";
        if (v.nearest) text += " nearest";
        if (v.is_in) text += " in";
        if (v.is_out) text += " out";
        text += ' ' + std::string(v.type.text) + ' ' + std::string(v.name);
        line(depth, text);
        for (const ExprPtr& extent : v.extents) {
            line(depth + 1, "Extent");
            print_expr(extent.get(), depth + 2);
        }
        print_expr(v.init.get(), depth + 1);
        for (const Annotation& a : v.annotations) {
            line(depth + 1, "Annotation " + std::string(a.type.text) + ' ' + std::string(a.name));
            print_expr(a.value.get(), depth + 2);
        }
    }

    void print_struct(const Struct& record, int depth) {
        line(depth, "Struct " + std::string(record.name));
        for (const Variable& v : record.members)
            print_variable("Member", v, depth + 1);
    }

    void print_stmt(const Stmt* stmt, int depth) {
        if (stmt == nullptr) return;
        line(depth, words(kStmtNames[static_cast<size_t>(stmt->kind)], stmt->text));
        if (stmt->bound != nullptr) line(depth + 1, "Bound");
        print_expr(stmt->bound.get(), depth + 2);
        if (stmt->record != nullptr) print_struct(*stmt->record, depth + 1);
        for (const Variable& v : stmt->variables)
            print_variable("Variable", v, depth + 1);
        print_stmt(stmt->init.get(), depth + 1);
        print_expr(stmt->expr.get(), depth + 1);
        print_expr(stmt->step.get(), depth + 1);
        for (const StmtPtr& child : stmt->body)
            print_stmt(child.get(), depth + 1);
    }

    void print_scope(const Scope& scope, int depth) {
        for (const Struct& record : scope.structs)
            print_struct(record, depth);
        for (const Enum& item : scope.enums) {
            line(depth, "Enum " + std::string(item.name));
            for (const Variable& v : item.items)
                print_variable("Name", v, depth + 1);
        }
        for (const Variable& v : scope.constants)
            print_variable("Constant", v, depth);
        for (const Function& f : scope.functions) {
            line(depth, "Function " + std::string(f.return_type.text) + ' ' + std::string(f.name));
            for (const Variable& v : f.parameters)
                print_variable("Parameter", v, depth + 1);
            print_stmt(f.body.get(), depth + 1);
        }
    }

    void print_fablet(const Fablet& fablet) {
        line(0, "Fablet " + std::string(fablet.name));
        for (const Variable& v : fablet.uniforms)
            print_variable("Uniform", v, 1);
        print_scope(fablet.scope, 1);
        for (const Stage& stage : fablet.stages) {
            line(1, std::string("Stage ") + stage_name(stage.kind));
            for (const Variable& v : stage.varyings)
                print_variable("Varying", v, 2);
            for (const TypeRef& claim : stage.claims)
                line(2, "Claim " + std::string(claim.text));
            print_stmt(stage.body.get(), 2);
        }
    }

    std::string out_;
};

}  // namespace

const char* stage_name(StageKind kind) {
    switch (kind) {
        case StageKind::kSurface:
            return "Surface";
        case StageKind::kVolume:
            return "Volume";
        case StageKind::kDither:
            return "Dither";
        case StageKind::kShape:
            return "Shape";
        case StageKind::kGrow:
            break;
    }
    return "Grow";
}

std::string dump(const File& file) {
    return Printer().run(file);
}

}  // namespace openfab::ast
