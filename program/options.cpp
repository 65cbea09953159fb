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
#include "base/sample_parts.h"
#include "program/messages.h"
#include "program/option_texts.h"
#include "runtime/process/kinds/kinds.h"

namespace openfab::program {

namespace {

/// Fails where a length is no size of a voxel.
Result<void> check_pitch(const char* option, std::optional<double> mm) {
    if (!mm || (*mm >= 1e-4 && *mm <= 100)) return {};
    return bad_value(option, fmt::format("{:g}mm", *mm), messages::kPitchOutside, "0.1mm");
}

/// Fails where a number is below 1 or above the most.
Result<void> check_count(const char* option, std::optional<int32_t> count, int32_t most,
                         const char* example) {
    if (!count || (*count >= 1 && *count <= most)) return {};
    return bad_value(option, fmt::format("{}", *count), fmt::format(messages::kNotACount, most),
                     example);
}

/// Fails unless a range begins at 0 or above, and before it ends.
template <typename T>
Result<void> check_range(const char* option, const std::optional<Vec2<T>>& range, const char* unit,
                         const char* example) {
    if (!range || (range->x >= 0 && range->x < range->y)) return {};
    return bad_value(option, fmt::format("{0}{2}:{1}{2}", range->x, range->y, unit),
                     messages::kEmptyRange, example);
}

Result<void> validate_grid(const GridOptions& o) {
    if (o.voxel_mm && (o.dpi || o.layer_mm)) return usage_error(messages::kVoxelAndDpi);
    if (o.mesh_pitch_mm && pitch_is_given(o)) {
        return usage_error(messages::kMeshPitchAndOthers);
    }
    if (o.z_range_mm && o.slices) return usage_error(messages::kHeightsAndSlices);
    if (o.part && (o.z_range_mm || o.slices)) return usage_error(messages::kPartAndRange);
    if (o.part && !(o.part->x >= 1 && o.part->x <= o.part->y)) {
        return bad_value("--part", fmt::format("{}/{}", o.part->x, o.part->y), messages::kNotAPart,
                         "3/4");
    }
    if (o.dpi && !(o.dpi->x >= 1 && o.dpi->y >= 1 && o.dpi->x <= 1e5 && o.dpi->y <= 1e5)) {
        return bad_value("--dpi", fmt::format("{:g}x{:g}", o.dpi->x, o.dpi->y),
                         messages::kDpiOutside, "600x300");
    }
    for (int axis = 0; o.pitch_mm && axis < 3; ++axis) {
        const Vec3d& pitch = *o.pitch_mm;
        if (pitch[axis] >= 1e-4 && pitch[axis] <= 1e5) continue;
        return bad_value("--pitch", fmt::format("{:g},{:g},{:g}", pitch.x, pitch.y, pitch.z),
                         messages::kPitchOfPrintOutside, "0.1,0.1,0.1");
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
        return usage_error(
            fmt::format(messages::kNoSuchFormat, o.format, backends::format_names()));
    }
    if (o.fractions_file.ends_with(".zarr")) {
        const std::string npy = o.fractions_file.substr(0, o.fractions_file.size() - 4) + "npy";
        return usage_error(fmt::format(messages::kFractionsNoZarr, o.fractions_file, npy));
    }
    if (o.fractions_file.ends_with(".vdb")) {
        const std::string npy = o.fractions_file.substr(0, o.fractions_file.size() - 3) + "npy";
        return usage_error(fmt::format(messages::kFractionsNoVdb, o.fractions_file, npy));
    }
    const bool streams = format == nullptr || format->streams;
    if (o.output == "-" && !streams) {
        return usage_error(fmt::format(messages::kNotToStandardOutput, format->name,
                                       format->kind == backends::FormatKind::kFolder
                                           ? messages::kSlicesAreAFolder
                                           : messages::kIsFinishedLast));
    }
    if (stream::is_address(o.output)) {
        if (Result<stream::Address> a = stream::parse_address(o.output); !a) return a.error();
        if (!streams) return usage_error(fmt::format(messages::kNotStreamed, format->name));
    }
    if (o.fractions_supersample.value_or(1) > 1 && o.sample_centres)
        return usage_error(messages::kCentreAndSupersample);
    if (o.resume && !o.fractions_file.empty()) {
        return usage_error(messages::kFractionsAndResume);
    }
    if (o.resume && (o.output.empty() || o.output == "-")) {
        return usage_error(messages::kResumeWithoutOutput);
    }
    return check_count("--fractions-supersample", o.fractions_supersample, kMostSupersampling, "4");
}

Result<void> validate_run(const RunOptions& o) {
    constexpr int32_t kMost = 1024;
    Result<void> fine = check_count("--threads", o.threads, kMost, "4");
    if (fine && o.memory_bytes < 1)
        return bad_value("--memory", fmt::format("{}B", o.memory_bytes), messages::kNoMemory,
                         "1.5GB");
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
        return usage_error(fmt::format(messages::kNoSetting, text));
    }
    for (const auto& [name, value] : options.effects) {
        const process::Kind* kind = process::find_option(name);
        if (kind == nullptr) return usage_error(fmt::format(messages::kNoSuchEffect, name));
        const auto& choices = kind->option.choices;
        if (choices.empty() || std::ranges::find(choices, value) != choices.end()) continue;
        return bad_value(name.c_str(), value,
                         fmt::format(messages::kNoneOfChoices, fmt::join(choices, ", ")),
                         choices[1]);
    }
    if (const int32_t around = options.altered.around; around < 0 || around > kMostAround)
        return bad_value("--around", fmt::format("{}", around),
                         fmt::format(messages::kNotACount, kMostAround), "1");
    return validate_output(options);
}

}  // namespace openfab::program
