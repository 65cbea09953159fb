// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "program/options.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

#include "backends/formats/formats.h"
#include "backends/stream/address.h"
#include "program/option_texts.h"

namespace openfab::program {

namespace {

/// Fails where a length is no size of a voxel.
Result<void> check_pitch(const char* option, std::optional<double> mm) {
    if (!mm || (*mm >= 1e-4 && *mm <= 100)) return {};
    return bad_value(option, fmt::format("{:g}mm", *mm), "outside 0.1um to 100mm", "0.1mm");
}

/// Fails where a number is below 1 or above the most.
Result<void> check_count(const char* option, std::optional<int32_t> count, int32_t most,
                         const char* example) {
    if (!count || (*count >= 1 && *count <= most)) return {};
    return bad_value(option, fmt::format("{}", *count),
                     fmt::format("not a whole number from 1 to {}", most), example);
}

/// Fails unless a range begins at 0 or above, and before it ends.
template <typename T>
Result<void> check_range(const char* option, const std::optional<Vec2<T>>& range, const char* unit,
                         const char* example) {
    if (!range || (range->x >= 0 && range->x < range->y)) return {};
    return bad_value(option, fmt::format("{0}{2}:{1}{2}", range->x, range->y, unit),
                     "an empty or negative range", example);
}

Result<void> validate_grid(const GridOptions& o) {
    if (o.voxel_mm && (o.dpi || o.layer_mm))
        return usage_error("`--voxel` and `--dpi`/`--layer` both set the pitch; give one of them");
    if (o.mesh_pitch_mm && pitch_is_given(o)) {
        return usage_error(
            "`--mesh-pitch` and `--voxel`, `--dpi` or `--layer` both set the pitch; give one of "
            "them");
    }
    if (o.z_range_mm && o.slices) return usage_error("give one of `--z` and `--slices`");
    if (o.dpi && !(o.dpi->x >= 1 && o.dpi->y >= 1 && o.dpi->x <= 1e5 && o.dpi->y <= 1e5)) {
        return bad_value("--dpi", fmt::format("{:g}x{:g}", o.dpi->x, o.dpi->y),
                         "not a resolution between 1 and 100000 dpi", "600x300");
    }
    for (int axis = 0; o.pitch_mm && axis < 3; ++axis) {
        const Vec3d& pitch = *o.pitch_mm;
        if (pitch[axis] >= 1e-4 && pitch[axis] <= 1e5) continue;
        return bad_value("--pitch", fmt::format("{:g},{:g},{:g}", pitch.x, pitch.y, pitch.z),
                         "outside 0.1um to 100m", "0.1,0.1,0.1");
    }
    for (const Result<void>& fine : {
             check_pitch("--voxel", o.voxel_mm),
             check_pitch("--layer", o.layer_mm),
             check_pitch("--mesh-pitch", o.mesh_pitch_mm),
             check_count("--draft", o.draft, 1000, "4"),
             check_range("--z", o.z_range_mm, "mm", "3mm:5mm"),
             check_range("--slices", o.slices, "", "0:64"),
         }) {
        if (!fine) return fine;
    }
    return {};
}

Result<void> validate_output(const OutputOptions& o) {
    const backends::Format* format = backends::find_format(o.format);
    if (!o.format.empty() && format == nullptr) {
        return usage_error(fmt::format("there is no output format `{}`; choose from {}", o.format,
                                       backends::format_names()));
    }
    if (o.fractions_file.ends_with(".vdb")) {
        const std::string npy = o.fractions_file.substr(0, o.fractions_file.size() - 3) + "npy";
        return usage_error(fmt::format(
            "`--fractions {0}`: OpenVDB is written by `openfab export`; write `--fractions {1}`, "
            "and then `openfab export {1} -o {0}`",
            o.fractions_file, npy));
    }
    const bool streams = format == nullptr || format->streams;
    if (o.output == "-" && !streams) {
        return usage_error(
            fmt::format("{} {} and cannot go to standard output; use `--format ofr`", format->name,
                        format->kind == backends::FormatKind::kFolder ? "slices are a folder"
                                                                      : "is finished last"));
    }
    if (stream::is_address(o.output)) {
        if (Result<stream::Address> a = stream::parse_address(o.output); !a) return a.error();
        if (!streams)
            return usage_error(
                fmt::format("{} cannot be streamed; a receiver gets `--format ofr`", format->name));
    }
    if (o.fractions_supersample.value_or(1) > 1 && o.sample_centres)
        return usage_error("give one of `--sampling centre` and `--fractions-supersample`");
    if (o.resume && !o.fractions_file.empty()) {
        return usage_error(
            "`--fractions` needs all slices, and `--resume` does not make those again that are "
            "there; leave one of them out");
    }
    if (o.resume && (o.output.empty() || o.output == "-")) {
        return usage_error(
            "`--resume` continues a file or folder of slices; write `-o OUT` with the name of the "
            "one that was cut short");
    }
    return check_count("--fractions-supersample", o.fractions_supersample, kMostSupersampling, "4");
}

Result<void> validate_run(const RunOptions& o) {
    constexpr int32_t kMost = 1024;
    Result<void> fine = check_count("--threads", o.threads, kMost, "4");
    if (fine && o.memory_bytes < 1)
        return bad_value("--memory", fmt::format("{}B", o.memory_bytes), "no memory", "1.5GB");
    if (fine) fine = check_count("--groups-in-flight", o.slabs_in_flight, kMost, "8");
    return fine;
}

}  // namespace

Result<void> validate_options(const Options& options) {
    if (Result<void> fine = validate_grid(options); !fine) return fine;
    if (Result<void> fine = validate_run(options); !fine) return fine;
    for (const std::string& text : options.settings) {
        const size_t equals = text.find('=');
        if (equals != std::string::npos && equals > 0 && equals + 1 < text.size()) continue;
        return usage_error(fmt::format(
            "`--set`: `{}` is not a setting; write `--set OBJECT.UNIFORM=VALUE`", text));
    }
    constexpr std::array<std::string_view, 4> kBleed{"undo", "show", "both", "off"};
    if (std::find(kBleed.begin(), kBleed.end(), options.bleed) == kBleed.end())
        return bad_value("--bleed", options.bleed, "none of undo, show, both and off", "show");
    return validate_output(options);
}

}  // namespace openfab::program
