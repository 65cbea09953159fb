// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/dicom/frame_labels.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>

#include "tools/dicom/messages.h"

namespace openfab::tools {

namespace {

/// Lists of nuclear medicine, a number for each frame, from 1.
struct Vector {
    uint16_t item;
    const char* key;
    const char* name;
};

constexpr std::array<Vector, 8> kVectors{{
    {0x0010, "energy_window", "energy windows"},
    {0x0020, "detector", "detectors"},
    {0x0030, "phase", "phases"},
    {0x0050, "", "rotations"},
    {0x0060, "", "R-R intervals"},
    {0x0070, "time", "times"},
    {0x0090, "", "angular views"},
    {0x0100, "time", "times"},
}};

constexpr uint16_t kNuclear = 0x0054, kSliceVector = 0x0080;

std::vector<int32_t> numbers_of(const gdcm::DataSet& set, const gdcm::Tag& tag) {
    const std::vector<uint64_t> values = whole_numbers(bytes_of(set, tag), 2);
    return {values.begin(), values.end()};
}

/// A number of what people write as text, or of 2, 4 or 8 bytes.
std::optional<double> decimal_of(std::string_view text) {
    double value = 0;
    if (trimmed(text).empty() || !parse_decimals(text, &value, 1)) return {};
    return value;
}

/// The groups in which a frame says more of itself.
struct Grouped {
    gdcm::Tag group, tag;
    enum class Form { kWhole, kReal, kText } form;
    const char* key;
    const char* name;
    bool is_rank, is_strict;
};

const std::array<Grouped, 15>& grouped() {
    using Form = Grouped::Form;
    static const std::array<Grouped, 15> table{{
        {{0x0020, 0x9111}, {0x0020, 0x9128}, Form::kWhole, "time", "times", false, true},
        {{0x0020, 0x9310}, {0x0020, 0x930d}, Form::kReal, "time", "times", true, true},
        {{0x0062, 0x000a}, {0x0062, 0x000b}, Form::kWhole, "segment", "segments", false, true},
        {{0x0018, 0x9114}, {0x0018, 0x9082}, Form::kReal, "echo", "echoes", true, true},
        {{0x0018, 0x9117}, {0x0018, 0x9087}, Form::kReal, "", "b values", false, true},
        {{0x0018, 0x9117}, {0x0018, 0x9075}, Form::kText, "", "directions", false, false},
        {{0x0018, 0x9118}, {0x0020, 0x9153}, Form::kReal, "phase", "phases", true, false},
        {{0x0018, 0x9118}, {0x0020, 0x9241}, Form::kReal, "phase", "phases", true, false},
        {{0x0018, 0x9226}, {0x0018, 0x9208}, Form::kText, "", "components", false, true},
        {{0x0018, 0x9226}, {0x0008, 0x9208}, Form::kText, "", "components", false, true},
        {{0x0018, 0x9226}, {0x0008, 0x9007}, Form::kText, "", "frame types", false, true},
        {{0x0018, 0x9329}, {0x0008, 0x9007}, Form::kText, "", "frame types", false, true},
        {{0x0018, 0x9751}, {0x0008, 0x9007}, Form::kText, "", "frame types", false, true},
        {{0x0018, 0x9807}, {0x0018, 0x9808}, Form::kText, "", "data types", false, true},
        {{0x0040, 0x9096}, {0x0040, 0x9210}, Form::kText, "", "mappings", false, true},
    }};
    return table;
}

/// Attributes that say where a frame lies.
bool is_space(const gdcm::Tag& tag) {
    static const std::array<gdcm::Tag, 9> kSpace{{{0x0020, 0x0032},
                                                  {0x0020, 0x0037},
                                                  {0x0020, 0x1041},
                                                  {0x0020, 0x9056},
                                                  {0x0020, 0x9057},
                                                  {0x0020, 0x9301},
                                                  {0x0020, 0x9302},
                                                  {0x0020, 0x930e},
                                                  {0x0020, 0x9113}}};
    return std::find(kSpace.begin(), kSpace.end(), tag) != kSpace.end();
}

gdcm::Tag tag_of(std::string_view bytes) {
    const std::vector<uint64_t> words = whole_numbers(bytes, 2);
    if (words.size() != 2) return {};
    return {static_cast<uint16_t>(words[0]), static_cast<uint16_t>(words[1])};
}

}  // namespace

Result<void> FrameIncrement::read_one(const gdcm::DataSet& set, const gdcm::Tag& tag,
                                      int32_t frames) {
    const auto count = static_cast<size_t>(frames);
    const auto wrong = [&](const char* what) {
        return user_error(fmt::format(messages::kFrameList, what, frames));
    };
    if (tag == gdcm::Tag(0x3004, 0x000c)) return {};  // the offsets of doses
    if (tag == gdcm::Tag(0x0018, 0x2005)) {
        places_mm_.resize(count);
        const bool good = parse_decimals(bytes_of(set, tag), places_mm_.data(), places_mm_.size());
        return good ? Result<void>() : wrong("slice locations");
    }
    if (tag == gdcm::Tag(kNuclear, kSliceVector)) {
        slices_ = numbers_of(set, tag);
        const bool good =
            slices_.size() == count &&
            std::all_of(slices_.begin(), slices_.end(), [](int32_t number) { return number >= 1; });
        return good ? Result<void>() : wrong("slices");
    }
    if (tag == gdcm::Tag(0x0018, 0x1063) || tag == gdcm::Tag(0x0018, 0x1065)) {
        List list{tag.GetElementTag(), "time", "times", std::vector<int32_t>(count)};
        std::iota(list.numbers.begin(), list.numbers.end(), 1);
        lists_.push_back(std::move(list));
        return {};
    }
    const auto known = std::find_if(kVectors.begin(), kVectors.end(), [&](const Vector& vector) {
        return tag == gdcm::Tag(kNuclear, vector.item);
    });
    if (known == kVectors.end()) {
        return user_error(fmt::format(messages::kFrameIncrement, tag.GetGroup(), tag.GetElement()),
                          messages::kFrameIncrementHelp);
    }
    List list{tag.GetElementTag(), known->key, known->name, numbers_of(set, tag)};
    if (list.numbers.size() != count) return wrong(known->name);
    lists_.push_back(std::move(list));
    return {};
}

Result<void> FrameIncrement::read(const gdcm::DataSet& set, int32_t frames) {
    if (frames == 1) return {};
    std::vector<gdcm::Tag> tags;
    const std::string_view pointers = bytes_of(set, {0x0028, 0x0009});
    for (size_t at = 0; at + 4 <= pointers.size(); at += 4)
        tags.push_back(tag_of(pointers.substr(at, 4)));
    // A time between frames says the same without it.
    for (const uint16_t item : {0x1063, 0x1065}) {
        const gdcm::Tag time(0x0018, item);
        if (tags.empty() && set.FindDataElement(time)) tags.push_back(time);
    }
    // So do lists of nuclear medicine.
    const auto add_list = [&](uint16_t item) {
        const gdcm::Tag tag(kNuclear, item);
        if (numbers_of(set, tag).size() == static_cast<size_t>(frames)) tags.push_back(tag);
    };
    if (tags.empty()) {
        for (const Vector& vector : kVectors)
            add_list(vector.item);
        add_list(kSliceVector);
    }
    for (const gdcm::Tag& tag : tags) {
        if (Result<void> done = read_one(set, tag, frames); !done) return done;
    }
    return {};
}

size_t FrameIncrement::detector(int32_t frame) const {
    for (const List& list : lists_) {
        if (list.key == std::string("detector"))
            return static_cast<size_t>(list.numbers[static_cast<size_t>(frame)]);
    }
    return 0;
}

void FrameIncrement::add_labels(int32_t frame, std::vector<FrameLabel>* out) const {
    for (const List& list : lists_) {
        const int32_t number = list.numbers[static_cast<size_t>(frame)];
        out->push_back(
            {list.source, list.key, list.name, static_cast<double>(number), {}, false, true});
    }
}

GroupLabels::GroupLabels(const gdcm::DataSet& set, const FrameGroups& groups) : groups_(groups) {
    const DicomItems items = items_of(set, {0x0020, 0x9222});
    const size_t count = items == nullptr ? 0 : items->GetNumberOfItems();
    for (size_t i = 1; i <= count; ++i) {
        const gdcm::DataSet& item = items->GetItem(i).GetNestedDataSet();
        const gdcm::Tag tag = tag_of(bytes_of(item, {0x0020, 0x9165}));
        const bool is_known =
            is_space(tag) || std::any_of(grouped().begin(), grouped().end(),
                                         [&](const Grouped& one) { return one.tag == tag; });
        std::string name(trimmed(bytes_of(item, {0x0020, 0x9421})));
        if (name.empty())
            name = fmt::format("values of ({:04x},{:04x})", tag.GetGroup(), tag.GetElement());
        indices_.push_back({tag.GetElementTag(), std::move(name), is_known});
    }
}

void GroupLabels::add_labels(int32_t frame, bool has_place, std::vector<FrameLabel>* out) const {
    using Form = Grouped::Form;
    for (const Grouped& one : grouped()) {
        const std::string bytes = groups_.find_grouped(frame, one.group, one.tag);
        if (bytes.empty()) continue;
        FrameLabel label{
            one.tag.GetElementTag(), one.key, one.name, 0, {}, one.is_rank, one.is_strict};
        if (one.form == Form::kText) {
            label.text = trimmed(bytes);
        } else if (one.form == Form::kReal) {
            const std::optional<double> value = binary_number(bytes);
            if (!value) continue;
            label.value = *value;
        } else {
            if (bytes.size() != 2 && bytes.size() != 4) continue;
            label.value = static_cast<double>(whole_numbers(bytes, bytes.size()).front());
        }
        out->push_back(std::move(label));
    }
    const std::vector<uint64_t> values =
        whole_numbers(groups_.find_own(frame, {0x0020, 0x9111}, {0x0020, 0x9157}), 4);
    if (values.size() != indices_.size()) return;
    for (size_t i = 0; i < values.size(); ++i) {
        if (indices_[i].is_known) continue;
        const Index& index = indices_[i];
        out->push_back(
            {index.source, "", index.name, static_cast<double>(values[i]), {}, false, !has_place});
    }
}

void add_file_labels(const gdcm::DataSet& set, std::vector<FrameLabel>* out) {
    struct Own {
        gdcm::Tag tag;
        const char* key;
        const char* name;
        bool is_rank, is_strict;
    };
    static const std::array<Own, 8> kOwn{{
        {{0x0018, 0x0086}, "echo", "echoes", false, true},
        {{0x0018, 0x0081}, "echo", "echoes", true, false},
        {{0x0020, 0x0100}, "time", "times", false, true},
        {{0x0054, 0x1300}, "time", "times", true, false},
        {{0x0018, 0x1060}, "time", "times", true, false},
        {{0x0020, 0x0012}, "time", "times", true, false},
        {{0x0008, 0x0032}, "time", "times", true, false},
        {{0x0018, 0x0060}, "", "voltages", false, false},
    }};
    for (const Own& own : kOwn) {
        if (const std::optional<double> value = decimal_of(bytes_of(set, own.tag)))
            out->push_back({own.tag.GetElementTag(),
                            own.key,
                            own.name,
                            *value,
                            {},
                            own.is_rank,
                            own.is_strict});
    }
    if (const std::optional<double> b = binary_number(bytes_of(set, {0x0018, 0x9087})))
        out->push_back({0x00189087, "", "b values", *b, {}, false, false});
    const std::string_view type = trimmed(bytes_of(set, {0x0008, 0x0008}));
    if (!type.empty())
        out->push_back({0x00080008, "", "image types", 0, std::string(type), false, false});
}

}  // namespace openfab::tools
