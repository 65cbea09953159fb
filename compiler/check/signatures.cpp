// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/check/signatures.h"

#include <algorithm>

namespace openfab::check {

const std::vector<Signature>& signatures() {
    static const std::vector<Signature> all = {
#define OPENFAB_SIGNATURE(name, form, text) {name, form, text},
#include "compiler/check/signatures.def"
    };
    return all;
}

std::vector<Signature> signatures_of(std::string_view name) {
    std::vector<Signature> out;
    for (const Signature& one : signatures()) {
        if (one.name == name) out.push_back(one);
    }
    return out;
}

std::vector<std::string_view> parameters_of(std::string_view form) {
    std::vector<std::string_view> out;
    const size_t open = form.find('(');
    if (open == std::string_view::npos) return out;
    std::string_view list = form.substr(open + 1, form.rfind(')') - open - 1);
    while (!list.empty()) {
        const size_t comma = std::min(list.find(", "), list.size());
        out.push_back(list.substr(0, comma));
        list.remove_prefix(std::min(comma + 2, list.size()));
    }
    return out;
}

}  // namespace openfab::check
