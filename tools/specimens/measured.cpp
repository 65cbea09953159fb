// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/specimens/measured.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <system_error>
#include <utility>

#include "tools/specimens/messages.h"
#include "tools/specimens/rows_of_text.h"

namespace openfab::specimens {

namespace {

namespace fs = std::filesystem;

struct CurveFiles {
    std::map<int, fs::path> of_label;
    std::vector<std::string> unmatched;
};

/// Returns the number that a name is, else 0.
int label_of(const std::string& stem) {
    int out = 0;
    const auto end = std::from_chars(stem.data(), stem.data() + stem.size(), out);
    return end.ec == std::errc() && end.ptr == stem.data() + stem.size() && out > 0 ? out : 0;
}

Result<CurveFiles> curve_files(const List& list, const fs::path& folder) {
    constexpr std::array<std::string_view, 4> kSuffixes{".csv", ".txt", ".tsv", ".dat"};
    std::error_code failure;
    std::vector<fs::path> files;
    for (auto at = fs::directory_iterator(folder, failure);
         !failure && at != fs::directory_iterator(); at.increment(failure))
        if (at->is_regular_file()) files.push_back(at->path());
    if (failure)
        return user_error(
            fmt::format(messages::kFolderUnreadable, folder.string(), failure.message()));
    std::ranges::sort(files);
    CurveFiles out;
    for (const fs::path& file : files) {
        if (std::ranges::find(kSuffixes, file.extension().string()) == kSuffixes.end()) continue;
        const int label = label_of(file.stem().string());
        if (std::ranges::find(list.specimens, label, &Specimen::label) == list.specimens.end()) {
            out.unmatched.push_back(file.filename().string());
        } else if (const auto [before, is_new] = out.of_label.emplace(label, file); !is_new) {
            return user_error(fmt::format(messages::kTwoCurves, label,
                                          before->second.filename().string(),
                                          file.filename().string()));
        }
    }
    return out;
}

Scatter scatter_of(const std::vector<double>& values) {
    Scatter out;
    out.count = static_cast<int>(values.size());
    for (const double value : values)
        out.mean += value / out.count;
    if (out.count < 2) return out;
    double squares = 0;
    for (const double value : values)
        squares += (value - out.mean) * (value - out.mean);
    out.deviation = std::sqrt(squares / (out.count - 1));
    return out;
}

Kind kind_of(const std::vector<std::string>& values, const std::vector<Measured>& all) {
    Kind out;
    out.values = values;
    for (const auto& [member, to] : {std::pair(&Properties::modulus_MPa, &out.modulus_MPa),
                                     {&Properties::strength_MPa, &out.strength_MPa},
                                     {&Properties::strain_at_break, &out.strain_at_break}}) {
        std::vector<double> numbers;
        for (const Measured& one : all)
            if (one.specimen.values == values) numbers.push_back(one.properties.*member);
        *to = scatter_of(numbers);
    }
    return out;
}

}  // namespace

Result<Measurements> measure(const List& list, const fs::path& curves,
                             const MeasuredOptions& options) {
    const Result<CurveFiles> files = curve_files(list, curves);
    if (!files) return files.error();
    Measurements out;
    out.unmatched = files->unmatched;
    const bool disc = list.piece->is_disc();
    for (const Specimen& specimen : list.specimens) {
        const auto file = files->of_label.find(specimen.label);
        if (file == files->of_label.end()) {
            out.missing.push_back(specimen.label);
            continue;
        }
        CurveOptions of_one = options.curve;
        of_one.area_mm2 = disc ? std::numbers::pi / 4 * specimen.width_mm * specimen.width_mm
                               : specimen.width_mm * specimen.thickness_mm;
        if (of_one.length_mm == 0)
            of_one.length_mm = disc ? specimen.thickness_mm : list.piece->grips_mm;
        const Result<Curve> curve = read_curve(file->second, of_one);
        if (!curve) return curve.error();
        out.extensions |= curve->extension;
        const Result<Properties> properties = properties_of(*curve, file->second.string(), of_one);
        if (!properties) return properties.error();
        out.specimens.push_back({specimen, *properties});
    }
    if (out.specimens.empty())
        return user_error(fmt::format(messages::kNoCurves, curves.string()),
                          messages::kNoCurvesHelp);
    for (const Measured& one : out.specimens)
        if (std::ranges::find(out.kinds, one.specimen.values, &Kind::values) == out.kinds.end())
            out.kinds.push_back(kind_of(one.specimen.values, out.specimens));
    return out;
}

std::string measured_text(const List& list, const Measurements& measured) {
    std::string out = "label";
    for (const std::string& column : list.columns)
        out += "," + csv_cell(column);
    out += ",modulus_MPa,strength_MPa,strain_at_break\n";
    for (const Measured& one : measured.specimens) {
        out += fmt::format("{}", one.specimen.label);
        for (const std::string& value : one.specimen.values)
            out += "," + csv_cell(value);
        const Properties& p = one.properties;
        out += fmt::format(",{:.6g},{:.6g},{:.6g}\n", p.modulus_MPa, p.strength_MPa,
                           p.strain_at_break);
    }
    return out;
}

}  // namespace openfab::specimens
