// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/crossings/numbers.h"

#include <rapidjson/document.h>

#include "tests/support/process/process.h"

namespace openfab::testing {

namespace {

void add(const rapidjson::Value& value, const std::string& name,
         std::map<std::string, double>* out) {
    const std::string before = name.empty() ? "" : name + "/";
    if (value.IsNumber()) (*out)[name] = value.GetDouble();
    if (value.IsBool()) (*out)[name] = value.GetBool() ? 1 : 0;
    if (value.IsObject()) {
        for (const auto& member : value.GetObject())
            add(member.value, before + member.name.GetString(), out);
    }
    if (value.IsArray()) {
        for (rapidjson::SizeType i = 0; i < value.Size(); ++i)
            add(value[i], before + std::to_string(i), out);
    }
}

}  // namespace

std::map<std::string, double> numbers_of(const std::filesystem::path& json) {
    std::map<std::string, double> out;
    rapidjson::Document document;
    document.Parse(read_file(json).c_str());
    if (!document.HasParseError()) add(document, "", &out);
    return out;
}

}  // namespace openfab::testing
