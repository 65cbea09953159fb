// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/server/reference.h"

#include <algorithm>
#include <iterator>

#include "compiler/server/language_reference.h"

namespace openfab::server {

namespace {

struct Marker {
    std::string_view name;
    std::string_view text;
};
constexpr Marker kMarkers[] = {
    {"uniform",
     "Values that the world binds once for an object: numbers, textures, materials, objects."},
    {"Surface",
     "The surface stage: runs on the vertices of the surface and returns the displacement, a "
     "`float3` in mm."},
    {"Volume", "The volume stage: runs for each voxel and returns its `MaterialComposition`."},
    {"Dither",
     "The dither rule: runs for each voxel that is a mixture and returns the number of the "
     "fraction "
     "that it becomes; 0 is void."},
    {"varying",
     "What a stage reads: the mesh's attributes in a surface stage, those of the nearest surface "
     "point in a volume stage, the voxel's in a dither rule."},
    {"nearest", "A varying of the volume stage: its value at the nearest point of the surface."},
    {"bound", "The most trips of the loop that follows, a constant."},
};

std::string_view trimmed(std::string_view text) {
    const size_t first = std::min(text.find_first_not_of(' '), text.size());
    text.remove_prefix(first);
    return text.substr(0, text.find_last_not_of(' ') + 1);
}

/// Returns the forms in backticks of a cell.
std::vector<std::string_view> forms_of(std::string_view cell) {
    std::vector<std::string_view> out;
    for (size_t at = cell.find('`'); at != std::string_view::npos; at = cell.find('`', at)) {
        const size_t end = cell.find('`', at + 1);
        if (end == std::string_view::npos) break;
        out.push_back(cell.substr(at + 1, end - at - 1));
        at = end + 1;
    }
    return out;
}

/// `t.Sample1(u, v, c)` is about `Sample1`.
std::string_view name_of(std::string_view form) {
    form = form.substr(0, form.find('('));
    const size_t dot = form.find('.');
    return dot == std::string_view::npos ? form : form.substr(dot + 1);
}

}  // namespace

std::vector<ReferenceEntry> reference_of(std::string_view name) {
    std::vector<ReferenceEntry> out;
    std::string_view text = kLanguageReference[0].text;
    const size_t begin = text.find("## 8. Built in");
    text = text.substr(std::min(begin, text.size()));
    text = text.substr(0, text.find("\n## 9."));
    // The last of `Sample1` … `Sample4` stands for those between.
    const bool sample =
        name.size() == 7 && name.starts_with("Sample") && name[6] >= '1' && name[6] <= '4';
    const std::string_view wanted = sample ? "Sample1" : name;
    for (size_t at = 0; at < text.size();) {
        const size_t end = std::min(text.find('\n', at), text.size());
        const std::string_view row = text.substr(at, end - at);
        at = end + 1;
        const size_t cell = row.starts_with("| `") ? row.find(" |", 2) : std::string_view::npos;
        if (cell == std::string_view::npos) continue;
        for (std::string_view form : forms_of(row.substr(1, cell - 1))) {
            if (name_of(form) != wanted) continue;
            std::string_view rest = row.substr(cell + 2);
            rest = trimmed(rest.substr(0, rest.rfind('|')));
            std::string shown(form);
            if (sample) shown.replace(shown.find("Sample1"), 7, name);
            out.push_back({std::move(shown), std::string(rest)});
            break;
        }
    }
    return out;
}

std::string_view marker_text(std::string_view name) {
    const auto found = std::find_if(std::begin(kMarkers), std::end(kMarkers),
                                    [&](const Marker& m) { return m.name == name; });
    return found == std::end(kMarkers) ? std::string_view() : found->text;
}

std::vector<std::string_view> markers() {
    std::vector<std::string_view> out;
    for (const Marker& marker : kMarkers)
        out.push_back(marker.name);
    return out;
}

}  // namespace openfab::server
