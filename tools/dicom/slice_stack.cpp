// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/dicom/slice_stack.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "tools/dicom/messages.h"

namespace openfab::tools {

namespace {

/// Of a length in mm: what the decimals of a file leave open.
constexpr double kSamePlace_mm = 0.01;
/// Of a texture.
constexpr double kMostPlanes = 16384;

Error of_slice(const DicomSlice& slice, const Error& error) {
    return with_context(error, slice.name() + ": ");
}

double tolerance_of(double step_mm) {
    // Scanners round positions; what is above a hundredth of a step is no rounding.
    return std::max(kSamePlace_mm, step_mm / 100);
}

bool is_one_file(const std::vector<DicomSlice>& slices) {
    return std::all_of(slices.begin(), slices.end(), [&](const DicomSlice& slice) {
        return slice.image == slices.front().image;
    });
}

/// What is wrong with a slice that lies `step_mm` above another one, where `usual_mm` is usual.
Error gap(const DicomSlice& below, const DicomSlice& slice, double step_mm, double usual_mm,
          bool one_file) {
    const double missing = std::round(step_mm / usual_mm) - 1;
    if (missing >= 1 && std::abs(step_mm - (missing + 1) * usual_mm) <= tolerance_of(usual_mm)) {
        const Vec3d &from = below.position, &to = slice.position;
        return user_error(
            fmt::format(messages::kSlicesAreMissing, missing, missing == 1 ? " is" : "s are",
                        below.name(), from.x, from.y, from.z, slice.name(), to.x, to.y, to.z,
                        step_mm, usual_mm),
            one_file ? messages::kUnequalFramesHelp : messages::kSlicesAreMissingHelp);
    }
    return of_slice(
        slice, user_error(fmt::format(messages::kSliceOutOfStep, step_mm, below.name(), usual_mm),
                          one_file ? messages::kUnequalFramesHelp : ""));
}

/// How many times `step_mm`, which is known within a tolerance, each distance is; nothing where one is off
/// by more than that, or than `most_mm`.
std::optional<std::vector<int64_t>> multiples(const std::vector<double>& steps, double step_mm,
                                              double tolerance_mm, double most_mm) {
    std::vector<int64_t> out;
    double all = 0;
    for (const double step : steps) {
        const double times = std::round(step / step_mm);
        const double off = std::abs(step - times * step_mm);
        if (!(times >= 1) || off > std::min(tolerance_mm * times, most_mm)) return {};
        all += times;
        if (!(all < kMostPlanes)) return {};
        out.push_back(static_cast<int64_t>(times));
    }
    return out;
}

/// Distances that a segmentation, which leaves empty frames out, or a dose may have.
std::optional<std::vector<int64_t>> find_multiples(const std::vector<DicomSlice>& slices,
                                                   const std::vector<double>& steps) {
    const DicomImage& image = *slices.front().image;
    if (!is_one_file(slices)) return {};
    const double least = *std::min_element(steps.begin(), steps.end());
    const double stated = std::abs(slices.front().spacing_mm);
    if (image.kind == DicomKind::kSegmentation || image.kind == DicomKind::kLabelMap) {
        std::optional<std::vector<int64_t>> found;
        constexpr double kMostPart = 0.1;
        if (stated >= kSamePlace_mm)
            found = multiples(steps, stated, tolerance_of(stated), stated * kMostPart);
        if (found) return found;
        return multiples(steps, least, tolerance_of(least), least * kMostPart);
    }
    if (!image.has_offsets) return {};
    constexpr int kMostParts = 16;
    for (int parts = 1; parts <= kMostParts && least / parts > 10 * kSamePlace_mm; ++parts) {
        constexpr double kDigits_mm = 0.002;  // which offsets leave open
        if (auto found = multiples(steps, least / parts, kDigits_mm, kDigits_mm)) return found;
    }
    return {};
}

/// The distances between slices along the normal, which must be above 0.
Result<std::vector<double>> steps_of(const std::vector<DicomSlice>& slices, const Vec3d& normal) {
    std::vector<double> steps;
    for (size_t i = 1; i < slices.size(); ++i) {
        const DicomSlice &below = slices[i - 1], &slice = slices[i];
        steps.push_back(dot(slice.position - below.position, normal));
        if (!(steps.back() >= kSamePlace_mm)) {
            return of_slice(slice,
                            user_error(fmt::format(messages::kSliceAtSamePlace, below.name()),
                                       messages::kSliceAtSamePlaceHelp));
        }
    }
    return steps;
}

/// Fails where distances are not equal.
Result<void> check_equal(const std::vector<DicomSlice>& slices, const std::vector<double>& steps) {
    std::vector<double> sorted = steps;
    // Of two in the middle the lesser one, since what is missing only makes steps longer.
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>((sorted.size() - 1) / 2);
    std::nth_element(sorted.begin(), middle, sorted.end());
    const double usual = *middle;
    for (size_t i = 0; i < steps.size(); ++i) {
        if (std::abs(steps[i] - usual) > tolerance_of(usual))
            return gap(slices[i], slices[i + 1], steps[i], usual, is_one_file(slices));
    }
    return {};
}

/// Fails where slices do not lie on the line from the first to the last.
Result<void> check_line(const std::vector<DicomSlice>& slices, const std::vector<int64_t>& times,
                        const Vec3d& step) {
    int64_t at = 0;
    for (size_t i = 1; i < slices.size(); ++i) {
        at += times[i - 1];
        const Vec3d off =
            slices[i].position - slices.front().position - step * static_cast<double>(at);
        if (length(off) > std::max(kSamePlace_mm, length(step) / 20))
            return of_slice(slices[i], user_error(messages::kSliceBesideLine));
    }
    return {};
}

/// Of slices in one place keeps the one that is not empty.
void drop_empty(std::vector<DicomSlice>* slices, const Vec3d& normal) {
    std::vector<DicomSlice> out;
    for (DicomSlice& slice : *slices) {
        const bool same =
            !out.empty() && dot(slice.position - out.back().position, normal) < kSamePlace_mm;
        if (same && slice.is_empty) continue;
        if (same && out.back().is_empty) out.pop_back();
        out.push_back(std::move(slice));
    }
    *slices = std::move(out);
}

/// A grid that moves no texel by more than a part of one when it is put along the axes is along them, and so is
/// one of any size but for the sixth decimal of its direction cosines, to which scanners write them.
void straighten(const std::array<double, 3>& size, GridFrame* frame) {
    constexpr double kPartOfTexel = 1e-4, kDecimal = 1e-6;
    double least = 0;
    for (const Vec3d& step : frame->steps)
        least = least == 0 ? length(step) : std::min(least, length(step));
    for (size_t i = 0; i < 3; ++i) {
        Vec3d& step = frame->steps[i];
        int axis = 0;
        for (int a = 1; a < 3; ++a)
            axis = std::abs(step[a]) > std::abs(step[axis]) ? a : axis;
        const double aside = std::hypot(step[(axis + 1) % 3], step[(axis + 2) % 3]);
        const bool rounded = aside <= (1 + 1e-9) * kDecimal * length(step);
        if (!rounded && !(aside * size[i] <= kPartOfTexel * least)) continue;
        Vec3d straight{};
        straight[axis] = step[axis];
        step = straight;
    }
}

void add_planes(const std::vector<int64_t>& times, bool between, SliceStack* out) {
    const auto is_there = [&](size_t i) { return !out->slices[i].is_empty; };
    for (size_t i = 0; i < out->slices.size(); ++i) {
        out->planes.push_back({is_there(i) ? static_cast<int32_t>(i) : -1, 0});
        const int64_t count = i < times.size() ? times[i] : 1;
        for (int64_t k = 1; k < count; ++k) {
            out->planes.push_back({between ? static_cast<int32_t>(i) : -1,
                                   static_cast<double>(k) / static_cast<double>(count)});
        }
    }
}

}  // namespace

Result<SliceStack> stack_slices(std::vector<DicomSlice> slices) {
    const Vec3d plane = cross(slices.front().across, slices.front().down);
    const Vec3d normal = plane * (1 / length(plane));
    std::stable_sort(slices.begin(), slices.end(), [&](const DicomSlice& a, const DicomSlice& b) {
        return dot(a.position, normal) < dot(b.position, normal);
    });
    drop_empty(&slices, normal);
    SliceStack out;
    Vec3d step;
    std::vector<int64_t> times(slices.size() - 1, 1);
    const DicomSlice& first = slices.front();
    if (slices.size() == 1) {
        const double stated = std::abs(first.spacing_mm);
        const bool is_segment = first.image->kind == DicomKind::kSegmentation ||
                                first.image->kind == DicomKind::kLabelMap;
        step = normal * (is_segment && stated >= kSamePlace_mm ? stated
                         : first.thickness_mm > 0              ? first.thickness_mm
                                                               : 1.0);
    } else {
        const Result<std::vector<double>> steps = steps_of(slices, normal);
        if (!steps) return steps.error();
        if (auto found = find_multiples(slices, *steps)) {
            times = std::move(*found);
        } else if (Result<void> equal = check_equal(slices, *steps); !equal) {
            return equal.error();
        }
        int64_t all = 0;
        for (const int64_t one : times)
            all += one;
        step = (slices.back().position - first.position) * (1 / static_cast<double>(all));
        if (Result<void> line = check_line(slices, times, step); !line) return line.error();
    }
    out.frame = {first.position, {first.across, first.down, step}};
    const bool between = first.image->has_offsets;
    const double width = first.image->width, height = first.image->height;
    out.slices = std::move(slices);
    add_planes(times, between, &out);
    straighten({width, height, static_cast<double>(out.planes.size())}, &out.frame);
    return out;
}

}  // namespace openfab::tools
