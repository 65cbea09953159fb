// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/lower/schedule/directive_chain.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <iterator>
#include <utility>

#include "compiler/schedule/rules.h"

namespace openfab::lower {

int64_t number_of(const schedule::Word& word) {
    int64_t out = 0;
    std::from_chars(word.text.data(), word.text.data() + word.text.size(), out);
    return out;
}

std::optional<schedule::Fault> DirectiveChain::run() {
    func().last_word = line_.func;
    for (const schedule::Directive& directive : line_.directives) {
        current_ = &directive;
        if (!apply()) return fault_;
    }
    return std::nullopt;
}

bool DirectiveChain::apply() {
    struct Handler {
        const char* name;
        bool (DirectiveChain::*run)();
        schedule::Scope scope;
    };
    static constexpr Handler kHandlers[] = {
#define OPENFAB_DIRECTIVE(name, scope, ...) {#name, &DirectiveChain::name, schedule::Scope::scope},
#include "compiler/schedule/directives.def"
#undef OPENFAB_DIRECTIVE
    };
    const auto* handler =
        std::find_if(std::begin(kHandlers), std::end(kHandlers),
                     [&](const Handler& h) { return current_->name.text == h.name; });
    const bool needs_loops = handler->scope == schedule::Scope::kLoops;
    if (needs_loops && func().is_extern()) return fail_loopless(current_->name, func());
    if (!needs_loops && definition_ != 0)
        return fail(current_->name, "this is about the whole func: it belongs before `update()`");
    return (this->*handler->run)();
}

bool DirectiveChain::fail(const schedule::Word& word, std::string message, std::string help) {
    fault_ = schedule::fault_at(word, std::move(message), std::move(help));
    return false;
}

bool DirectiveChain::fail_loopless(const schedule::Word& word, const ScheduledFunc& func) {
    return fail(
        word, fmt::format("`{}` is computed by the runtime: it has no loops of its own", func.name),
        "it can be placed: compute_at, compute_root, store_at, store_root");
}

bool DirectiveChain::find_func(const schedule::Word& word, size_t* out) {
    const std::optional<size_t> found = kernel_->find(word.text);
    if (found) {
        *out = *found;
        return true;
    }
    return fail(word, fmt::format("this kernel has no func `{}`", word.text),
                schedule::near_or_all(word.text, kernel_->names(), "it has"));
}

bool DirectiveChain::factor(const schedule::Word& word, int64_t most, int64_t* out) {
    *out = number_of(word);
    if (*out >= 1 && *out <= most) return true;
    return fail(word, fmt::format("expected a number from 1 to {}", most));
}

}  // namespace openfab::lower
