// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/live.h"

namespace openfab::viewer {

Result<std::string> Live::graph(const std::string& method, int32_t fablet, const std::string& text,
                                const JsonValue* action) {
    const Result<Source> of = source_of(fablet);
    if (!of) return of.error();
    return graphs_.ask("openfl/" + method, of->path, text, action);
}

}  // namespace openfab::viewer
