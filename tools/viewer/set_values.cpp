// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/set_values.h"

#include <algorithm>

namespace openfab::viewer {

const SetValue* SetValues::List::find(const std::string& object, const std::string& uniform) const {
    const auto value = std::find_if(values.begin(), values.end(), [&](const SetValue& candidate) {
        return candidate.is_of(object, uniform);
    });
    return value == values.end() ? nullptr : &*value;
}

std::vector<std::string> SetValues::List::settings() const {
    std::vector<std::string> settings;
    for (const SetValue& value : values)
        settings.push_back(value.setting());
    return settings;
}

SetValues::List SetValues::list() const {
    const std::lock_guard lock(mutex_);
    return list_;
}

void SetValues::set(const std::string& object, const std::string& uniform,
                    const std::string& value) {
    const std::lock_guard lock(mutex_);
    std::erase_if(list_.values,
                  [&](const SetValue& other) { return other.is_of(object, uniform); });
    list_.values.push_back({object, uniform, value, {}});
    ++list_.edition;
}

void SetValues::forget_all() {
    const std::lock_guard lock(mutex_);
    list_.values.clear();
    ++list_.edition;
}

void SetValues::forget(const List& written) {
    const std::lock_guard lock(mutex_);
    std::erase_if(list_.values, [&](const SetValue& value) {
        const SetValue* same = written.find(value.object, value.uniform);
        return same != nullptr && same->value == value.value;
    });
    ++list_.edition;
}

void SetValues::rename(const std::string& object, const std::string& from, const std::string& to) {
    const std::lock_guard lock(mutex_);
    for (SetValue& value : list_.values) {
        if (value.is_of(object, from)) value.uniform = to;
    }
    ++list_.edition;
}

client::PrintWords SetValues::note_troubles(const client::PrintWords& words) {
    const std::lock_guard lock(mutex_);
    for (SetValue& value : list_.values)
        value.trouble.clear();
    client::PrintWords others{words.text, {}};
    for (const client::SettingError& error : words.settings) {
        const auto value = std::find_if(
            list_.values.begin(), list_.values.end(),
            [&](const SetValue& candidate) { return candidate.setting() == error.setting; });
        if (value == list_.values.end()) {
            others.settings.push_back(error);
        } else {
            value->trouble = error.text;
        }
    }
    return others;
}

}  // namespace openfab::viewer
