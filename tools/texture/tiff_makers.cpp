// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/tiff_makers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <optional>
#include <string_view>

#include "base/json.h"
#include "base/scan_number.h"
#include "base/text.h"
#include "tools/texture/messages.h"

namespace openfab::tools {

namespace {

Error by_turns(const char* maker) {
    return user_error(fmt::format(messages::kPagesByTurns, maker), messages::kWriteAsPagesHelp);
}

/// What stands behind one of the keys, `KEY = VALUE` or `KEY=VALUE`, up to the end of its line.
std::optional<std::string_view> value_of(std::string_view text,
                                         std::initializer_list<std::string_view> keys) {
    for (const std::string_view key : keys) {
        const size_t at = text.find(key);
        if (at == std::string_view::npos) continue;
        std::string_view rest = text.substr(at + key.size());
        rest = rest.substr(0, rest.find_first_of("\r\n"));
        const size_t sign = rest.find('=');
        if (sign == std::string_view::npos) continue;
        rest.remove_prefix(sign + 1);
        rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
        return rest;
    }
    return {};
}

/// How many numbers a list has, as `[1;2]` or `[1 2]`.
int64_t count_numbers(std::string_view list) {
    int64_t count = 0;
    bool in_number = false;
    for (const char letter : list) {
        const bool digit = std::isdigit(static_cast<unsigned char>(letter)) != 0;
        if (digit && !in_number) ++count;
        in_number = digit;
    }
    return count;
}

/// ScanImage: pages are channels, then slices or times.
Result<void> check_scan_image(const TiffDirectory& first, int64_t pages) {
    const std::string text = first.description + "\n" + first.software;
    const bool is_one = text.find("SI.VERSION_") != std::string::npos ||
                        text.find("scanimage.SI") != std::string::npos ||
                        text.find("state.acq.") != std::string::npos;
    if (!is_one) return {};
    int64_t channels = 1, slices = 0;
    if (const auto list = value_of(text, {"hChannels.channelSave", "SI4.channelsSave"}))
        channels = count_numbers(*list);
    if (const auto count = value_of(text, {"acq.numberOfChannelsSave"}))
        (void)scan_integer(*count, 1, INT32_MAX, &channels);
    if (channels > 1) return by_turns("ScanImage");
    const auto count = value_of(text, {"hStackManager.actualNumSlices", "hStackManager.numSlices",
                                       "SI4.stackNumSlices", "acq.numberOfZSlices"});
    if (!count || !scan_integer(*count, 1, INT32_MAX, &slices).empty() || slices == pages)
        return {};
    return user_error(fmt::format(messages::kFramesInTime, pages / slices),
                      messages::kFramesInTimeHelp);
}

/// Olympus FluoView: ten dimensions of the whole file, with their names.
Result<void> check_fluoview(const std::string& header) {
    constexpr size_t kBegin = 284, kEach = 100, kName = 16, kMost = 10;
    for (size_t i = 0; i < kMost && kBegin + (i + 1) * kEach <= header.size(); ++i) {
        const std::string_view one = std::string_view(header).substr(kBegin + i * kEach, kEach);
        const std::string_view name = one.substr(0, std::min(one.find('\0'), kName));
        int32_t size = 0;
        std::memcpy(&size, one.data() + kName, sizeof size);
        const std::string kind = lower_ascii(std::string(name));
        if (size > 1 && kind != "x" && kind != "y" && kind != "z") return by_turns("FluoView");
    }
    return {};
}

}  // namespace

Result<void> check_maker(const TiffDirectory& first, int64_t pages) {
    if (pages == 1) return {};
    if (!first.fluoview.empty()) return check_fluoview(first.fluoview);
    if (first.description.find("PerkinElmer-QPI") != std::string::npos)
        return by_turns("PerkinElmer");
    return check_scan_image(first, pages);
}

Result<void> check_micro_manager(const TiffDirectory& last, int64_t pages) {
    const std::string text = last.micro_manager.substr(0, last.micro_manager.find('\0'));
    const Result<JsonValue> json = parse_json(text, "");
    const JsonMember* const slice =
        json && json->is(JsonValue::Kind::kObject) ? json->find("SliceIndex") : nullptr;
    if (slice != nullptr && slice->value.number == static_cast<double>(pages - 1)) return {};
    return by_turns("Micro-Manager");
}

}  // namespace openfab::tools
