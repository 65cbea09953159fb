// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <string>

#include "base/say.h"
#include "compiler/driver/commands.h"
#include "compiler/driver/one_fablet.h"
#include "compiler/frontend/frontend.h"
#include "compiler/ir/grows.h"
#include "compiler/syntax/parser.h"

namespace openfab::driver {

namespace {

std::string tokens_text(const source::SourceManager& sources,
                        const std::vector<syntax::Token>& tokens) {
    std::string out;
    for (const syntax::Token& token : tokens) {
        const source::Location at = sources.locate(token.span.file, token.span.begin);
        out += fmt::format("{}:{} {}{}{}\n", at.line, at.column, syntax::spelling(token.kind),
                           token.text.empty() ? "" : " ", token.text);
    }
    return out;
}

/// Emits tokens or the tree, of the whole file: there are no stages yet.
int emit_syntax(const EmitOptions& options, const CommonOptions& common) {
    source::SourceManager sources;
    diag::Sink sink;
    std::string fault;
    const std::optional<uint32_t> file = sources.load(options.file, &fault);
    if (!file) return fail(fault, unread_exit_code(options.file));
    const std::vector<syntax::Token> tokens = syntax::lex(sources, *file, &sink);
    if (options.form == "tokens") {
        show(tokens_text(sources, tokens));
    } else if (sink.errors() == 0) {
        const ast::File tree = syntax::parse(sources, tokens, &sink);
        if (sink.errors() == 0) show(ast::dump(tree));
    }
    print_diagnostics(sink, sources, common);
    return sink.errors() == 0 ? kExitDone : kExitUserInput;
}

}  // namespace

int emit(const EmitOptions& options, const CommonOptions& common) {
    if (options.form == "tokens" || options.form == "ast") return emit_syntax(options, common);
    source::SourceManager sources;
    OneFablet one;
    if (const int code = read_fablet(options.file, options.fablet, options.enable_printf, common,
                                     &sources, &one);
        code != kExitDone)
        return code;
    const ir::Fablet* const fablet = one.fablet;
    if (options.form == "ir" && options.stage.empty()) {
        show(ir::dump(*fablet));
        return kExitDone;
    }
    if (options.stage.empty())
        return fail("`--stage` is missing; write `--stage surface` or `--stage slab`", kExitUsage);
    const bool surface = options.stage.starts_with("surface");
    const bool bounds = options.stage.ends_with("_bounds");
    if (surface && !fablet->has_surface) {
        return fail("fablet `" + fablet->name + "` has no @Surface stage", kExitUserInput);
    }
    if (options.stage == "grow" && !ir::grows(*fablet))
        return fail("fablet `" + fablet->name + "` has no @Grow stage", kExitUserInput);
    if (options.stage == "grow" && options.form == "ir") {
        show(ir::dump(fablet->shape));
        return kExitDone;
    }
    if (options.stage == "grow")
        return emit_lowered(*fablet, ir::StageKind::kShapeAttributes, options, &sources, common);
    if (options.stage.starts_with("shape") && (!fablet->has_shape || ir::grows(*fablet)))
        return fail("fablet `" + fablet->name + "` has no @Shape stage", kExitUserInput);
    if (options.stage == "shape" && options.form == "ir") {
        show(ir::dump(fablet->shape));
        return kExitDone;
    }
    if (options.stage.starts_with("shape")) {
        const ir::StageKind kind = bounds ? ir::StageKind::kShapeBounds
                                   : options.stage == "shape_attributes"
                                       ? ir::StageKind::kShapeAttributes
                                       : ir::StageKind::kShape;
        return emit_lowered(*fablet, kind, options, &sources, common);
    }
    if (options.stage == "dither" && !fablet->has_dither)
        return fail("fablet `" + fablet->name + "` has no @Dither stage", kExitUserInput);
    if (options.stage == "dither" && options.form != "ir")
        return fail("the rule is inside the kernel of `--stage slab`", kExitUsage);
    if (options.stage == "dither") {
        show(ir::dump(fablet->dither));
        return kExitDone;
    }
    const bool demand = options.stage == "volume_demand";
    if (options.form == "ir" && !bounds && !demand) {
        show(ir::dump(surface ? fablet->surface : fablet->volume));
        return kExitDone;
    }
    const ir::StageKind kind =
        demand    ? ir::StageKind::kVolumeDemand
        : surface ? (bounds ? ir::StageKind::kSurfaceBounds : ir::StageKind::kSurface)
                  : (bounds ? ir::StageKind::kVolumeBounds : ir::StageKind::kVolume);
    return emit_lowered(*fablet, kind, options, &sources, common);
}

}  // namespace openfab::driver
