// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/dicom/dicom_elements.h"

#include <gdcmByteValue.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "base/scan_number.h"

namespace openfab::tools {

namespace {

/// The items of `group` in an item of `items`, from 0.
DicomItems group_of(const DicomItems& items, int32_t index, const gdcm::Tag& group) {
    if (items == nullptr || static_cast<size_t>(index) >= items->GetNumberOfItems()) return nullptr;
    return items_of(items->GetItem(static_cast<size_t>(index) + 1).GetNestedDataSet(), group);
}

/// The bytes of `tag` in the first item of `group` in an item of `items`, from 0.
std::string in_group(const DicomItems& items, int32_t index, const gdcm::Tag& group,
                     const gdcm::Tag& tag) {
    const DicomItems inner = group_of(items, index, group);
    if (inner == nullptr || inner->GetNumberOfItems() == 0) return {};
    return std::string(bytes_of(inner->GetItem(1).GetNestedDataSet(), tag));
}

}  // namespace

std::string_view bytes_of(const gdcm::DataSet& set, const gdcm::Tag& tag) {
    if (!set.FindDataElement(tag)) return {};
    const gdcm::ByteValue* const bytes = set.GetDataElement(tag).GetByteValue();
    if (bytes == nullptr || bytes->GetPointer() == nullptr) return {};
    return {bytes->GetPointer(), bytes->GetLength()};
}

std::string_view trimmed(std::string_view text) {
    constexpr std::string_view kPadding(" \0", 2);
    text.remove_prefix(std::min(text.find_first_not_of(kPadding), text.size()));
    return text.substr(0, text.find_last_not_of(kPadding) + 1);
}

bool parse_decimals(std::string_view text, double* out, size_t count) {
    for (size_t i = 0; i < count; ++i, ++out) {
        const size_t end = std::min(text.find('\\'), text.size());
        if (!scan_number(trimmed(text.substr(0, end)), out).empty() || !std::isfinite(*out))
            return false;
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return trimmed(text).empty();
}

std::vector<uint64_t> whole_numbers(std::string_view bytes, size_t each) {
    std::vector<uint64_t> out;
    for (size_t at = 0; at + each <= bytes.size(); at += each) {
        uint64_t value = 0;
        for (size_t i = 0; i < each; ++i)
            value |= uint64_t{static_cast<uint8_t>(bytes[at + i])} << (8 * i);
        out.push_back(value);
    }
    return out;
}

std::optional<double> binary_number(std::string_view bytes) {
    if (bytes.size() == sizeof(double)) {
        double value = 0;
        std::memcpy(&value, bytes.data(), sizeof value);
        return value;
    }
    if (bytes.size() != sizeof(float)) return {};
    float value = 0;
    std::memcpy(&value, bytes.data(), sizeof value);
    return static_cast<double>(value);
}

int32_t short_of(const gdcm::DataSet& set, const gdcm::Tag& tag, int32_t otherwise) {
    const std::string_view bytes = bytes_of(set, tag);
    if (bytes.size() != 2) return otherwise;
    // Of a big-endian file, too: the library has put numbers in this order.
    return static_cast<uint8_t>(bytes[0]) | static_cast<uint8_t>(bytes[1]) << 8;
}

DicomItems items_of(const gdcm::DataSet& set, const gdcm::Tag& tag) {
    if (!set.FindDataElement(tag)) return nullptr;
    return set.GetDataElement(tag).GetValueAsSQ();
}

FrameGroups::FrameGroups(const gdcm::DataSet& set)
    : set_(set),
      shared_(items_of(set, {0x5200, 0x9229})),
      frames_(items_of(set, {0x5200, 0x9230})),
      detectors_(items_of(set, {0x0054, 0x0022})) {}

std::string FrameGroups::find_own(int32_t frame, const gdcm::Tag& group,
                                  const gdcm::Tag& tag) const {
    return in_group(frames_, frame, group, tag);
}

std::string FrameGroups::find_grouped(int32_t frame, const gdcm::Tag& group,
                                      const gdcm::Tag& tag) const {
    const std::string found = find_own(frame, group, tag);
    return found.empty() ? in_group(shared_, 0, group, tag) : found;
}

std::string FrameGroups::find(int32_t frame, const gdcm::Tag& group, const gdcm::Tag& tag) const {
    std::string found = find_grouped(frame, group, tag);
    if (found.empty()) found = bytes_of(set_, tag);
    if (found.empty() && detectors_ != nullptr && detectors_->GetNumberOfItems() >= detector_)
        found = bytes_of(detectors_->GetItem(detector_).GetNestedDataSet(), tag);
    return found;
}

DicomItems FrameGroups::items(int32_t frame, const gdcm::Tag& group) const {
    for (DicomItems found :
         {group_of(frames_, frame, group), group_of(shared_, 0, group), items_of(set_, group)}) {
        if (found != nullptr && found->GetNumberOfItems() > 0) return found;
    }
    return nullptr;
}

}  // namespace openfab::tools
