// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/openfab/machine_materials.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>
#include <utility>

#include "base/input_file.h"
#include "base/json_text.h"
#include "base/text.h"
#include "tools/openfab/stock.h"

namespace openfab::tools {

namespace {

constexpr int64_t kLargestProfile = 1 << 20;

struct MaterialLook {
    std::string_view word;  ///< in the name of a material
    const char* key;
    const char* preview;
};
/// Also the names of materials for profiles that list none.
constexpr std::array<MaterialLook, 6> kLooks{{{"white", "#ffffff", "#f4f2ecff"},
                                              {"black", "#000000", "#161616ff"},
                                              {"cyan", "#00a0e0", "#0098dc90"},
                                              {"magenta", "#e0007f", "#dc1478a0"},
                                              {"yellow", "#ffe000", "#ffe60090"},
                                              {"clear", "#c8e6f0", "#fafdff05"}}};

}  // namespace

bool is_called(const std::string& name, std::string_view word) {
    const std::string small = lower_ascii(name);
    constexpr std::array<std::pair<std::string_view, std::string_view>, 4> kShort{
        {{"white", "-wt"}, {"black", "-bk"}, {"clear", "-cl"}, {"clear", "clr"}}};
    return small.find(word) != std::string::npos ||
           std::ranges::any_of(kShort, [&](const auto& each) {
               return each.first == word && small.find(each.second) != std::string::npos;
           });
}

std::vector<std::string> names_by_look() {
    std::vector<std::string> out;
    for (const MaterialLook& look : kLooks)
        out.emplace_back(look.word);
    return out;
}

void put_material_first(std::vector<std::string>* names, size_t place, std::string_view word) {
    const auto begin = names->begin() + static_cast<std::ptrdiff_t>(std::min(place, names->size()));
    const auto called = std::find_if(
        begin, names->end(), [&](const std::string& name) { return is_called(name, word); });
    if (called != names->end()) std::rotate(begin, called, called + 1);
}

std::string materials_text(const std::vector<std::string>& names, const world::Printer& printer) {
    std::array<bool, kLooks.size()> used{};
    std::string out = "{";
    for (size_t i = 0; i < names.size(); ++i) {
        size_t look = 0;
        while (look < kLooks.size() && (used[look] || !is_called(names[i], kLooks[look].word)))
            ++look;
        const std::string other = fmt::format("#{:02x}{:02x}60", 0x50 + 0x20 * i, 0xd0 - 0x18 * i);
        const bool known = look < kLooks.size();
        if (known) used[look] = true;
        out += fmt::format(
            R"({}
        {}: {{"key": "{}", "preview": "{}")",
            i == 0 ? "" : ",", json_string(names[i]), known ? kLooks[look].key : other,
            known ? kLooks[look].preview : other + "ff");
        const auto ink = std::ranges::find(printer.inks, names[i], &world::Ink::name);
        if (ink != printer.inks.end() && ink->density_g_cm3 > 0)
            out += fmt::format(R"(, "density_g_cm3": {})", ink->density_g_cm3);
        out += "}";
    }
    return out + "\n    }";
}

Result<void> copy_profile(const std::string& printer, const std::filesystem::path& folder) {
    if (!printer.ends_with(".json")) return {};
    const std::filesystem::path profile = printer;
    const Result<InputFile> file = InputFile::open(profile);
    if (!file) return file.error();
    const Result<std::string> text = file->read_all(kLargestProfile);
    if (!text) return text.error();
    return write_file(folder / profile.filename(), *text);
}

}  // namespace openfab::tools
