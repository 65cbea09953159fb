// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/dicom/frame_values.h"

#include <cmath>

#include "tools/dicom/messages.h"

namespace openfab::tools {

namespace {

const gdcm::Tag kMappings(0x0040, 0x9096);

struct Mapping {
    double slope = 1, intercept = 0;
    std::optional<std::pair<double, double>> range;

    bool operator==(const Mapping&) const = default;
};

/// An end of the range that is mapped: of stored integers, or of numbers with a fraction.
std::optional<double> end_of_range(const gdcm::DataSet& item, const gdcm::Tag& whole,
                                   const gdcm::Tag& real, bool has_sign) {
    if (const std::optional<double> value = binary_number(bytes_of(item, real))) return value;
    const std::vector<uint64_t> bits = whole_numbers(bytes_of(item, whole), 2);
    if (bits.size() != 1) return {};
    const auto value = static_cast<uint16_t>(bits[0]);
    return has_sign ? static_cast<double>(static_cast<int16_t>(value)) : static_cast<double>(value);
}

Result<Mapping> mapping_of(const gdcm::DataSet& item, bool has_sign) {
    if (item.FindDataElement(gdcm::Tag(0x0040, 0x9212))) return user_error(messages::kMappingTable);
    Mapping out;
    const std::optional<double> slope = binary_number(bytes_of(item, {0x0040, 0x9225}));
    const std::optional<double> intercept = binary_number(bytes_of(item, {0x0040, 0x9224}));
    if (!slope || !intercept || !std::isfinite(*slope) || !std::isfinite(*intercept))
        return user_error(messages::kMappingNotANumber);
    out.slope = *slope;
    out.intercept = *intercept;
    const std::optional<double> first =
        end_of_range(item, {0x0040, 0x9216}, {0x0040, 0x9214}, has_sign);
    const std::optional<double> last =
        end_of_range(item, {0x0040, 0x9211}, {0x0040, 0x9213}, has_sign);
    if (first && last) out.range = {*first, *last};
    return out;
}

}  // namespace

FrameValues::FrameValues(const gdcm::DataSet& set, const FrameGroups& groups, DicomImage* image)
    : set_(set), groups_(groups), image_(image) {}

Result<void> FrameValues::read(int32_t frame, DicomSlice* out) {
    switch (image_->kind) {
        case DicomKind::kSegmentation:
            return read_fraction(out);
        case DicomKind::kLabelMap:
            return {};
        case DicomKind::kParametricMap:
            return read_mapping(frame, out);
        default:
            break;
    }
    if (frame == 0) {
        image_->has_other_values = groups_.items(frame, kMappings) != nullptr;
        image_->is_relative = image_->kind == DicomKind::kDose &&
                              trimmed(bytes_of(set_, {0x3004, 0x0002})) == "RELATIVE";
    }
    return read_rescale(frame, out);
}

Result<void> FrameValues::read_rescale(int32_t frame, DicomSlice* out) const {
    const gdcm::Tag group(0x0028, 0x9145);
    const std::string slope = groups_.find(frame, group, {0x0028, 0x1053});
    const std::string intercept = groups_.find(frame, group, {0x0028, 0x1052});
    const std::string dose = groups_.find(frame, group, {0x3004, 0x000e});
    if ((!trimmed(slope).empty() && !parse_decimals(slope, &out->slope, 1)) ||
        (!trimmed(intercept).empty() && !parse_decimals(intercept, &out->intercept, 1)) ||
        (!trimmed(dose).empty() && !parse_decimals(dose, &out->slope, 1)))
        return user_error(messages::kRescaleNotANumber);
    return {};
}

Result<void> FrameValues::read_mapping(int32_t frame, DicomSlice* out) const {
    const DicomItems items = groups_.items(frame, kMappings);
    if (items == nullptr) return user_error(messages::kNoMapping);
    std::optional<Mapping> first;
    for (size_t i = 1; i <= items->GetNumberOfItems(); ++i) {
        const Result<Mapping> one =
            mapping_of(items->GetItem(i).GetNestedDataSet(), image_->has_sign);
        if (!one) return one.error();
        if (first && !(*first == *one))
            return user_error(messages::kSeveralMappings, messages::kSeveralMappingsHelp);
        first = *one;
    }
    out->slope = first->slope;
    out->intercept = first->intercept;
    out->range = first->range;
    return {};
}

Result<void> FrameValues::read_fraction(DicomSlice* out) const {
    if (trimmed(bytes_of(set_, {0x0062, 0x0001})) != "FRACTIONAL") return {};
    const int32_t most = short_of(set_, {0x0062, 0x000e}, 0);
    if (most < 1) return user_error(messages::kNoHighestFraction);
    out->slope = 1.0 / most;
    return {};
}

}  // namespace openfab::tools
