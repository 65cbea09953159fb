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
#include "tools/openfab/messages.h"
#include "tools/openfab/stock_texts.h"

namespace openfab::tools {

std::string_view stock_text(std::string_view name) {
    const auto* const found = std::ranges::find(kStockTexts, name, &EmbeddedText::name);
    OPENFAB_CHECK(found != std::end(kStockTexts));  // tools/openfab/CMakeLists.txt has all names
    return found->text;
}

void set_stock_constant(const std::string& name, size_t value, std::string* source) {
    const std::string one = fmt::format("const int {} = 1;", name);
    const size_t at = source->find(one);
    if (at == std::string::npos) return;
    source->replace(at, one.size(), fmt::format("const int {} = {};", name, value));
    const std::string list = fmt::format("[{}] = {{", name);
    for (size_t begin = 0; (begin = source->find(list, begin)) != std::string::npos;) {
        begin += list.size();
        const size_t end = source->find('}', begin);
        const std::string usual = source->substr(begin, end - begin);
        std::string more;
        for (size_t i = 1; i < value; ++i)
            more += ", " + usual;
        source->insert(end, more);
    }
}

void mix_by_profile(std::string* source) {
    const auto replace = [&](const std::string& from, const std::string& until,
                             const std::string& by) {
        const size_t begin = source->find(from);
        OPENFAB_CHECK_NE(begin, std::string::npos);
        const size_t end = source->find(until, begin);
        OPENFAB_CHECK_NE(end, std::string::npos);
        source->replace(begin, end + until.size() - begin, by);
    };
    replace("float density", ";",
            "ImageTexture3D profile [[ string help = \"inks by colour, a table of `openfab color "
            "bake`\" ]];");
    replace("ink_limit(rgb_to_cmyk(rgb", ", 1)", "ink_amounts(profile, rgb)");
}

const StockFablet* find_stock_fablet(std::string_view name) {
    const auto* const found = std::ranges::find(kStockFablets, name, &StockFablet::name);
    return found == std::end(kStockFablets) ? nullptr : found;
}

std::string stock_fablet_names() {
    std::string text;
    for (const StockFablet& fablet : kStockFablets)
        text += fmt::format("{}`{}`", text.empty() ? "" : ", ", fablet.name);
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
    return outside_error(fmt::format(messages::kCannotWrite, file.string(), std::strerror(failed)));
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
