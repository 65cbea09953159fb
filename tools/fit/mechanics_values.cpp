// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/fit/mechanics_values.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "base/start_program.h"
#include "base/talking_program.h"
#include "client/child.h"
#include "tools/fit/messages.h"

namespace openfab::fit {

namespace {

namespace fs = std::filesystem;
constexpr size_t kLargestResult = size_t{16} << 20;

/// The key of the mechanics' results that holds the number of a quantity.
const char* key_of(Quantity quantity) {
    switch (quantity) {
        case Quantity::kMoved:
            return "most_moved_mm";
        case Quantity::kDeflection:
        case Quantity::kWork:
            return "work_Nmm";
        case Quantity::kOhm:
            return "resistance_ohm";
        case Quantity::kKelvinPerWatt:
            return "resistance_K_W";
        case Quantity::kYoung:
            return "young_MPa";
        case Quantity::kPoisson:
            return "poisson_xy_yz_zx";
        case Quantity::kStiffness:
            return "stiffness_MPa";
        case Quantity::kShare:
        case Quantity::kVolume:
        case Quantity::kWeight:
        case Quantity::kCost:
        case Quantity::kProperty:
            break;
    }
    return "";
}

/// Of a row or a matrix the number at an entry; null where there is none.
const JsonValue* entry_of(const JsonValue* value, const Goal& goal) {
    for (const int32_t index : goal.entry) {
        if (value == nullptr || !value->is(JsonValue::Kind::kArray)) break;
        const auto at = static_cast<size_t>(index);
        value = at < value->items.size() ? &value->items[at] : nullptr;
    }
    return value != nullptr && value->is(JsonValue::Kind::kNumber) ? value : nullptr;
}

std::string sides(const Vec3d& mm) {
    return fmt::format("--voxel={}x{}x{}mm", mm.x, mm.y, mm.z);
}

}  // namespace

Result<std::unique_ptr<MechanicsValues>> MechanicsValues::create(const program::Options& print,
                                                                 const Vec3d& printer_pitch_mm) {
    Result<std::unique_ptr<TemporaryFolder>> folder = TemporaryFolder::create();
    if (!folder) return folder.error();
    const Result<fs::path> programs = program_folder();
    if (!programs) return programs.error();
    return std::unique_ptr<MechanicsValues>(
        new MechanicsValues(print, printer_pitch_mm, std::move(*folder), *programs));
}

Result<const JsonValue*> MechanicsValues::solve(const Goal& goal,
                                                const std::vector<std::string>& settings,
                                                Elements elements) {
    std::vector<std::string> words{(programs_ / "openfab-mechanics").string(), goal.solve[0],
                                   print_.input};
    const bool chosen = elements == Elements::kAsked;
    for (size_t k = 1; k < goal.solve.size(); ++k) {
        if (chosen || !goal.solve[k].starts_with("--voxel=")) words.push_back(goal.solve[k]);
    }
    if (elements == Elements::kHalf) {
        const Result<const JsonValue*> whole = solve(goal, settings, Elements::kAsked);
        if (!whole) return whole;
        const JsonMember* pitch = (*whole)->find("pitch_mm");
        if (pitch == nullptr || pitch->value.items.size() != 3)
            return internal_error(messages::kNoPitch);
        words.push_back(sides({pitch->value.items[0].number / 2, pitch->value.items[1].number / 2,
                               pitch->value.items[2].number / 2}));
    }
    if (elements == Elements::kPrinted) {
        words.insert(words.end(), {"--codes", sides(printer_pitch_mm_)});
        if (!print_.dither.empty()) words.insert(words.end(), {"--dither", print_.dither});
    }
    if (goal.solve[0] == "part") {
        words.insert(words.end(), {"--buckling", "never"});
        if (!chosen) words.emplace_back("--thin");
    }
    for (const auto* sets : {&print_.settings, &settings}) {
        for (const std::string& set : *sets)
            words.push_back("--set=" + set);
    }
    for (const std::string& allow : print_.allow)
        words.push_back(allow_argument(allow));
    if (print_.threads) words.push_back(fmt::format("--threads={}", *print_.threads));
    words.push_back(fmt::format("--memory={}B", print_.memory_bytes));
    if (const auto known = solved_.find(words); known != solved_.end()) return &known->second;
    const fs::path result = folder_->path() / "result.json", err = folder_->path() / "said";
    std::vector<std::string> all = words;
    all.insert(all.end(), {"-q", "-o", result.string()});
    if (elements == Elements::kPrinted) {
        const auto child = client::Child::start(all, folder_->path() / "out", err);
        if (!child) return child.error();
        if ((*child)->wait() != 0) {
            std::string said = client::end_of_file(err, 4096);
            if (const size_t at = said.rfind("error: "); at != std::string::npos)
                said = said.substr(at + 7);
            while (said.ends_with('\n'))
                said.pop_back();
            return user_error(said);
        }
    } else if (Result<void> done = client::run(all, folder_->path() / "out", err); !done) {
        return done.error();
    }
    const Result<std::string> text = read_text_file(result, kLargestResult);
    if (!text) return text.error();
    Result<JsonValue> read = parse_json(*text, result.string());
    if (!read) return read.error();
    return &solved_.emplace(std::move(words), std::move(*read)).first->second;
}

Result<double> MechanicsValues::value(const Goal& goal, const std::vector<std::string>& settings,
                                      Elements elements) {
    const Result<const JsonValue*> solved = solve(goal, settings, elements);
    if (!solved) return solved.error();
    const JsonMember* member = (*solved)->find(key_of(goal.quantity));
    const JsonValue* number = entry_of(member != nullptr ? &member->value : nullptr, goal);
    if (number == nullptr)
        return error_at(goal.location, fmt::format(messages::kNoNumber, goal.name));
    if (goal.quantity != Quantity::kDeflection) return number->number;
    const JsonMember* force = (*solved)->find("force_N");
    double square = 0;
    for (size_t k = 0; force != nullptr && k < force->value.items.size(); ++k)
        square += force->value.items[k].number * force->value.items[k].number;
    // The work is half of the force times the way.
    return square > 0 ? 2 * number->number / std::sqrt(square) : 0;
}

}  // namespace openfab::fit
