// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/dicom/choose_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "tools/dicom/messages.h"
#include "tools/dicom/series_list.h"

namespace openfab::tools {

namespace {

/// What a label says, to be compared.
using Value = std::pair<double, std::string>;
/// Numbers of slices in one place.
using Group = std::vector<size_t>;

Value value_of(const FrameLabel& label) {
    return {label.value, label.text};
}

/// The labels that the slices have, each once, the strict ones first.
std::vector<FrameLabel> kinds_of(const std::vector<DicomSlice>& slices) {
    std::vector<FrameLabel> kinds;
    std::set<uint32_t> seen;
    for (const DicomSlice& slice : slices) {
        for (const FrameLabel& label : slice.labels) {
            if (seen.insert(label.source).second) kinds.push_back(label);
        }
    }
    std::stable_sort(kinds.begin(), kinds.end(), [](const FrameLabel& a, const FrameLabel& b) {
        return a.is_strict && !b.is_strict;
    });
    return kinds;
}

std::set<Value> values_of(const std::vector<DicomSlice>& slices, uint32_t source) {
    std::set<Value> out;
    for (const DicomSlice& slice : slices) {
        if (const FrameLabel* label = slice.label(source)) out.insert(value_of(*label));
    }
    return out;
}

std::set<Value> values_of(const std::vector<DicomSlice>& slices, const Group& group,
                          uint32_t source) {
    std::set<Value> out;
    for (const size_t i : group) {
        if (const FrameLabel* label = slices[i].label(source)) out.insert(value_of(*label));
    }
    return out;
}

/// Slices by their places along the normal of the first.
std::vector<Group> places_of(const std::vector<DicomSlice>& slices) {
    const Vec3d plane = cross(slices.front().across, slices.front().down);
    const Vec3d normal = plane * (1 / length(plane));
    std::vector<std::pair<double, size_t>> along;
    for (size_t i = 0; i < slices.size(); ++i)
        along.emplace_back(dot(slices[i].position, normal), i);
    std::sort(along.begin(), along.end());
    std::vector<Group> out;
    for (size_t i = 0; i < along.size(); ++i) {
        constexpr double kRounding_mm = 0.01;
        if (i == 0 || along[i].first - along[i - 1].first >= kRounding_mm) out.emplace_back();
        out.back().push_back(along[i].second);
    }
    return out;
}

std::string segment_name(const std::vector<DicomSlice>& slices, double number) {
    for (const DicomSegment& segment : slices.front().image->segments) {
        if (segment.number == number && !segment.label.empty())
            return fmt::format("{:g} (`{}`)", number, segment.label);
    }
    return fmt::format("{:g}", number);
}

std::string list_values(const std::vector<DicomSlice>& slices, const FrameLabel& kind,
                        const std::set<Value>& values) {
    std::vector<std::string> out;
    for (const auto& [number, text] : values) {
        if (kind.key == "segment") {
            out.push_back(segment_name(slices, number));
        } else if (!text.empty()) {
            out.push_back(fmt::format("`{}`", text));
        } else if (kind.is_rank) {
            out.push_back(fmt::format("{} ({:g})", out.size() + 1, number));
        } else {
            out.push_back(fmt::format("{:g}", number));
        }
    }
    return list_some(out);
}

Error several(const std::vector<DicomSlice>& slices, const FrameLabel& kind,
              const std::set<Value>& values) {
    return user_error(
        fmt::format(messages::kFramesOfSeveral, kind.name, list_values(slices, kind, values)),
        kind.key.empty() ? std::string(messages::kFramesOfSeveralHelp)
                         : fmt::format(messages::kFramesOfSeveralChoose, kind.key));
}

/// Keeps the slices whose numbers in order are true of `keep`.
std::vector<DicomSlice> kept(std::vector<DicomSlice> slices,
                             const std::function<bool(size_t)>& keep) {
    std::vector<DicomSlice> out;
    for (size_t i = 0; i < slices.size(); ++i) {
        if (keep(i)) out.push_back(std::move(slices[i]));
    }
    return out;
}

/// The numbers of the slices whose quantity is the `wanted`th in its place, from 1; nothing where places
/// do not have the same number of different ones.
std::optional<std::set<size_t>> ranked(const std::vector<DicomSlice>& slices,
                                       const FrameLabel& kind, double wanted) {
    std::set<size_t> out;
    size_t count = 0;
    for (const Group& group : places_of(slices)) {
        std::vector<std::pair<double, size_t>> order;
        for (const size_t i : group) {
            if (const FrameLabel* label = slices[i].label(kind.source))
                order.emplace_back(label->value, i);
        }
        std::sort(order.begin(), order.end());
        for (size_t i = 1; i < order.size(); ++i) {
            if (order[i].first == order[i - 1].first) return {};
        }
        if (order.size() != group.size() || (count > 0 && order.size() != count)) return {};
        count = order.size();
        if (wanted >= 1 && wanted <= static_cast<double>(count))
            out.insert(order[static_cast<size_t>(wanted) - 1].second);
    }
    return out;
}

Error none_chosen(const std::vector<DicomSlice>& slices, const FrameLabel& kind, double wanted,
                  const std::set<Value>& values) {
    return user_error(fmt::format(messages::kNoneChosen, kind.key, wanted, kind.name,
                                  list_values(slices, kind, values)));
}

/// Keeps the slices that one key chooses by one of their labels.
Result<std::vector<DicomSlice>> choose(std::vector<DicomSlice> slices, const std::string& key,
                                       double wanted) {
    std::optional<FrameLabel> found;
    for (const FrameLabel& kind : kinds_of(slices)) {
        if (kind.key != key) continue;
        const std::set<Value> values = values_of(slices, kind.source);
        if (!kind.is_strict && values.size() > 1) {
            const std::optional<std::set<size_t>> numbers = ranked(slices, kind, wanted);
            if (!numbers) continue;
            if (!numbers->empty())
                return kept(std::move(slices), [&](size_t i) { return numbers->contains(i); });
            return none_chosen(slices, kind, wanted,
                               values_of(slices, places_of(slices).front(), kind.source));
        }
        if (!found || (values.size() > 1 && values_of(slices, found->source).size() == 1))
            found = kind;
    }
    if (!found)
        return user_error(fmt::format(messages::kNothingToChoose, key), messages::kLeaveItOut);
    const std::set<Value> values = values_of(slices, found->source);
    double value = wanted;
    if (found->is_rank) {
        const bool there = wanted >= 1 && wanted <= static_cast<double>(values.size()) &&
                           wanted == std::floor(wanted);
        value = there ? std::next(values.begin(), static_cast<std::ptrdiff_t>(wanted) - 1)->first
                      : std::nan("");
    }
    std::vector<DicomSlice> out;
    for (const DicomSlice& slice : slices) {
        const FrameLabel* label = slice.label(found->source);
        if (label != nullptr && label->value == value) out.push_back(slice);
    }
    if (out.empty()) return none_chosen(slices, *found, wanted, values);
    return out;
}

/// Finds a segment by its label, else by its number. Fails where a label is that of several.
Result<int32_t> find_segment(const std::vector<DicomSlice>& slices, const std::string& text) {
    const std::vector<DicomSegment>& segments = slices.front().image->segments;
    std::vector<std::string> all;
    std::vector<int32_t> labelled, numbered;
    for (const DicomSegment& segment : segments) {
        all.push_back(segment_name(slices, segment.number));
        if (segment.label == text) labelled.push_back(segment.number);
        if (std::to_string(segment.number) == text) numbered.push_back(segment.number);
    }
    const std::vector<int32_t>& found = labelled.empty() ? numbered : labelled;
    if (found.size() == 1) return found.front();
    if (found.size() > 1)
        return user_error(fmt::format(messages::kSegmentsOfOneName, text, list_some(all)));
    return user_error(fmt::format(messages::kNoSuchSegment, text, list_some(all)));
}

Result<std::vector<DicomSlice>> choose_segment(std::vector<DicomSlice> slices,
                                               const std::string& text) {
    const DicomKind kind = slices.front().image->kind;
    if (kind != DicomKind::kSegmentation && kind != DicomKind::kLabelMap)
        return user_error(fmt::format(messages::kNothingToChoose, "segment"),
                          messages::kLeaveItOut);
    const Result<int32_t> number = find_segment(slices, text);
    if (!number) return number.error();
    for (DicomSlice& slice : slices) {
        if (kind == DicomKind::kLabelMap) {
            slice.only = *number;
            continue;
        }
        const FrameLabel* label = slice.label(kSegmentLabel);
        slice.is_empty = label == nullptr || label->value != *number;
        if (slice.is_empty)
            std::erase_if(slice.labels,
                          [](const FrameLabel& one) { return one.source == kSegmentLabel; });
    }
    return slices;
}

/// What tells slices in one place apart, where something does.
Result<void> check_places(const std::vector<DicomSlice>& slices) {
    const std::vector<FrameLabel> kinds = kinds_of(slices);
    for (const Group& group : places_of(slices)) {
        if (group.size() < 2) continue;
        for (const FrameLabel& kind : kinds) {
            const std::set<Value> values = values_of(slices, group, kind.source);
            if (values.size() > 1) return several(slices, kind, values);
        }
        break;
    }
    return {};
}

}  // namespace

bool names_segment(const std::vector<DicomSlice>& slices, const std::string& text) {
    for (const DicomSlice& slice : slices) {
        if (slice.frame > 0) continue;
        for (const DicomSegment& segment : slice.image->segments) {
            if (segment.label == text || std::to_string(segment.number) == text) return true;
        }
    }
    return false;
}

Result<std::vector<DicomSlice>> choose_frames(std::vector<DicomSlice> slices,
                                              const texture::VolumeOptions& options) {
    if (!options.segment.empty()) {
        Result<std::vector<DicomSlice>> chosen = choose_segment(std::move(slices), options.segment);
        if (!chosen) return chosen;
        slices = std::move(*chosen);
    }
    const std::pair<const char*, std::optional<double>> keys[] = {
        {"detector", options.detector}, {"energy_window", options.energy_window},
        {"phase", options.phase},       {"echo", options.echo},
        {"time", options.time},
    };
    for (const auto& [key, wanted] : keys) {
        if (!wanted) continue;
        Result<std::vector<DicomSlice>> chosen = choose(std::move(slices), key, *wanted);
        if (!chosen) return chosen;
        slices = std::move(*chosen);
    }
    for (const FrameLabel& kind : kinds_of(slices)) {
        const std::set<Value> values = values_of(slices, kind.source);
        if (kind.is_strict && values.size() > 1) return several(slices, kind, values);
    }
    if (options.segment.empty()) {
        if (Result<void> apart = check_places(slices); !apart) return apart.error();
    }
    return slices;
}

}  // namespace openfab::tools
