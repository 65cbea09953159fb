// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/stock.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "base/check.h"
#include "tools/openfab/stock_texts.h"

namespace openfab::tools {

std::string_view stock_text(std::string_view name) {
    const auto* const found = std::ranges::find(kStockTexts, name, &EmbeddedText::name);
    OPENFAB_CHECK(found != std::end(kStockTexts));  // tools/openfab/CMakeLists.txt has all names
    return found->text;
}

bool is_stock_fablet(std::string_view name) {
    return std::find(kStockFablets.begin(), kStockFablets.end(), name) != kStockFablets.end();
}

std::string stock_fablet_names() {
    std::string text;
    for (const char* name : kStockFablets)
        text += fmt::format("{}`{}`", text.empty() ? "" : ", ", name);
    return text;
}

Result<void> write_file(const std::filesystem::path& file, std::string_view text) {
    std::error_code status;
    std::filesystem::create_directories(file.parent_path(), status);
    std::FILE* out = std::fopen(file.c_str(), "wb");
    const bool written =
        out != nullptr && std::fwrite(text.data(), 1, text.size(), out) == text.size();
    int failed = errno;
    if (out != nullptr && std::fclose(out) != 0 && written) {
        failed = errno;
    } else if (written) {
        return {};
    }
    return outside_error(
        fmt::format("cannot write `{}`: {}", file.string(), std::strerror(failed)));
}

Result<std::filesystem::path> stock_source(const std::string& fablet,
                                           const std::filesystem::path& folder) {
    const std::string name = fmt::format("stock_{}.fl", fablet);
    const std::filesystem::path file = folder / name;
    const std::string_view text = stock_text(name);
    std::error_code status;
    // Another print may be reading it, so it is replaced only if it differs.
    if (std::filesystem::file_size(file, status) == text.size() && !status) {
        std::string found(text.size(), '\0');
        std::FILE* in = std::fopen(file.c_str(), "rb");
        const bool read = in != nullptr && std::fread(found.data(), 1, found.size(), in) > 0;
        if (in != nullptr) std::fclose(in);
        if (read && found == text) return file;
    }
    if (Result<void> written = write_file(file, text); !written) return written.error();
    return file;
}

}  // namespace openfab::tools
