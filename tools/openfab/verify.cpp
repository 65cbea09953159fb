// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// `openfab verify FILE.ofr`: every checksum, every slice, the index.

#include <fmt/format.h>

#include <memory>

#include "backends/ofr/ofr_reader.h"
#include "base/say.h"
#include "base/text.h"
#include "base/units.h"
#include "tools/openfab/commands.h"
#include "tools/openfab/messages.h"

namespace openfab::tools {

Result<void> verify(const std::string& file, const std::string& memory) {
    const Result<int64_t> bytes = parse_memory_option(memory);
    if (!bytes) return bytes.error();
    Result<std::unique_ptr<ofr::OfrReader>> reader = ofr::OfrReader::open(file, *bytes);
    if (!reader) return reader.error();
    for (;;) {
        Result<bool> more = (*reader)->next();
        if (!more) return more.error();
        if (!*more) break;
    }
    say(fmt::format(messages::kAllSlicesWhole, printable(file), (*reader)->whole_slices(),
                    (*reader)->hash()));
    return {};
}

}  // namespace openfab::tools
