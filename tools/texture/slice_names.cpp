// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/texture/slice_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "base/text.h"
#include "tools/texture/guarded.h"
#include "tools/texture/messages.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

bool is_upper(char c) {
    return c >= 'A' && c <= 'Z';
}

bool is_letter(char c) {
    return is_upper(c) || (c >= 'a' && c <= 'z');
}

/// A number in a name.
struct Number {
    size_t begin = 0, end = 0;
    std::string key;  ///< the word in front of it, in small letters
};

struct Name {
    std::string text;
    std::vector<Number> numbers;

    std::string value(size_t i) const {
        const std::string_view digits(text.data() + numbers[i].begin,
                                      numbers[i].end - numbers[i].begin);
        return std::string(digits.substr(std::min(digits.find_first_not_of('0'), digits.size())));
    }
    /// The name with `numeral` for each of its numbers but those of `kept`.
    std::string with(std::string_view numeral, const std::set<size_t>& kept) const {
        std::string out;
        size_t at = 0;
        for (size_t i = 0; i < numbers.size(); ++i) {
            out.append(text, at, numbers[i].begin - at);
            out += kept.contains(i) ? std::string_view(text).substr(
                                          numbers[i].begin, numbers[i].end - numbers[i].begin)
                                    : numeral;
            at = numbers[i].end;
        }
        return out.append(text, at);
    }
};

/// Returns the word before a place: the letters in front of it and of what separates them; of `imageCh` it is `ch`.
std::string word_before(const std::string& text, size_t end) {
    while (end > 0 && std::string_view("_-. =#").find(text[end - 1]) != std::string_view::npos)
        --end;
    size_t begin = end;
    while (begin > 0 && is_letter(text[begin - 1])) {
        --begin;
        if (begin > 0 && is_upper(text[begin]) && !is_upper(text[begin - 1])) break;
    }
    return lower_ascii(text.substr(begin, end - begin));
}

/// Finds the numbers of a name; a fraction behind a point counts to its number.
Name read_name(const fs::path& file) {
    Name out;
    out.text = file.filename().string();
    const size_t end = file.stem().string().size();
    for (size_t at = 0; at < end; ++at) {
        if (!is_digit(out.text[at])) continue;
        Number number;
        number.begin = at;
        number.key = word_before(out.text, at);
        while (at < end && (is_digit(out.text[at]) ||
                            (out.text[at] == '.' && at + 1 < end && is_digit(out.text[at + 1]))))
            ++at;
        number.end = at;
        out.numbers.push_back(std::move(number));
    }
    return out;
}

/// What the number behind a word counts.
enum class Counts { kUnknown, kSlices, kChannels, kTimes };

Counts counted_by(const std::string& key) {
    constexpr std::array<std::pair<std::string_view, Counts>, 22> kWords{
        {{"z", Counts::kSlices},         {"slice", Counts::kSlices},
         {"sl", Counts::kSlices},        {"plane", Counts::kSlices},
         {"layer", Counts::kSlices},     {"section", Counts::kSlices},
         {"depth", Counts::kSlices},     {"c", Counts::kChannels},
         {"ch", Counts::kChannels},      {"chan", Counts::kChannels},
         {"channel", Counts::kChannels}, {"w", Counts::kChannels},
         {"wave", Counts::kChannels},    {"wavelength", Counts::kChannels},
         {"lambda", Counts::kChannels},  {"band", Counts::kChannels},
         {"dye", Counts::kChannels},     {"t", Counts::kTimes},
         {"tp", Counts::kTimes},         {"time", Counts::kTimes},
         {"timepoint", Counts::kTimes},  {"cycle", Counts::kTimes}}};
    for (const auto& [word, counts] : kWords) {
        if (word == key) return counts;
    }
    return Counts::kUnknown;
}

const char* word_for(Counts counts) {
    return counts == Counts::kChannels ? "channel" : counts == Counts::kTimes ? "time" : "series";
}

/// One number of each name, at the same place or behind the same word.
struct Field {
    std::string key;            ///< of the first name
    std::vector<size_t> index;  ///< of each name's numbers
    bool varies = false;
    std::optional<size_t> repeated;  ///< a name that has the number of an earlier one
    size_t first_of_it = 0;          ///< which one

    Counts counts() const { return counted_by(key); }
};

/// Returns the fields that all names have.
std::vector<Field> fields_of(const std::vector<Name>& names) {
    const std::vector<Number>& first = names.front().numbers;
    const bool alike = std::all_of(names.begin(), names.end(), [&](const Name& name) {
        return name.numbers.size() == first.size();
    });
    std::vector<Field> out;
    for (size_t i = 0; i < first.size(); ++i) {
        Field field;
        field.key = first[i].key;
        for (const Name& name : names) {
            const auto found =
                alike ? name.numbers.begin() + static_cast<std::ptrdiff_t>(i)
                      : std::find_if(name.numbers.begin(), name.numbers.end(),
                                     [&](const Number& n) { return n.key == field.key; });
            if (found == name.numbers.end()) break;
            if (found->key != field.key) field.key.clear();
            field.index.push_back(static_cast<size_t>(found - name.numbers.begin()));
        }
        if (field.index.size() != names.size()) continue;
        std::map<std::string, size_t> seen;
        for (size_t n = 0; n < names.size(); ++n) {
            const auto [at, is_new] = seen.emplace(names[n].value(field.index[n]), n);
            if (is_new || field.repeated) continue;
            field.repeated = n;
            field.first_of_it = at->second;
        }
        field.varies = seen.size() > 1;
        out.push_back(std::move(field));
    }
    return out;
}

/// Refuses two files that are not slices of one volume; numbers of `kept` choose the first one's series.
Result<void> refuse(const Name& a, const Name& b, Counts differ, const std::set<size_t>& kept) {
    return user_error(fmt::format(messages::kSeveralSeries, word_for(differ), a.text, b.text),
                      fmt::format(messages::kSeveralSeriesHelp, a.with("%d", kept)));
}

/// Whether two names are alike but for the values of their numbers.
bool is_of_series(const Name& a, const Name& b) {
    return a.with("#", {}) == b.with("#", {});
}

/// Tells where the numbers of a series have a gap: the step from one to the next is mostly the same.
void tell_gaps(const std::vector<Name>& names) {
    std::vector<int64_t> numbers;
    const auto around_last = [](const Name& name) {
        std::set<size_t> others;
        for (size_t i = 0; i + 1 < name.numbers.size(); ++i)
            others.insert(i);
        return name.with("#", others);
    };
    for (const Name& name : names) {
        const Number& last = name.numbers.back();
        constexpr size_t kMostDigits = 15;
        const bool is_whole = name.text.find('.', last.begin) >= last.end;
        if (!is_whole || last.end - last.begin > kMostDigits ||
            around_last(name) != around_last(names.front()))
            return;
        numbers.push_back(std::strtoll(name.text.c_str() + last.begin, nullptr, 10));
    }
    int64_t step = INT64_MAX;
    for (size_t i = 1; i < numbers.size(); ++i)
        step = std::min(step, numbers[i] - numbers[i - 1]);
    for (size_t i = 1; i < numbers.size(); ++i) {
        if (numbers[i] - numbers[i - 1] == step) continue;
        return tell(fmt::format(messages::kSeriesHasGap, names[i - 1].text, names[i].text));
    }
}

}  // namespace

Result<void> check_slice_names(const std::vector<fs::path>& files, bool have_pages) {
    std::vector<Name> names;
    for (const fs::path& file : files)
        names.push_back(read_name(file));
    // Names without numbers say nothing.
    if (names.size() < 2 || std::any_of(names.begin(), names.end(),
                                        [](const Name& name) { return name.numbers.empty(); }))
        return {};
    const std::vector<Field> fields = fields_of(names);
    std::set<size_t> slices, beside;  // numbers of the first name
    const Field* of_slices = nullptr;
    const Field* other = nullptr;  // that varies and counts channels or times
    bool is_numbered = false;
    for (const Field& field : fields) {
        is_numbered = is_numbered || !field.repeated;
        const Counts counts = field.counts();
        if (counts == Counts::kSlices) {
            slices.insert(field.index[0]);
            if (of_slices == nullptr || field.varies) of_slices = &field;
        } else if (counts != Counts::kUnknown) {
            beside.insert(field.index[0]);
            if (field.varies && (other == nullptr || field.repeated)) other = &field;
        }
    }
    std::set<size_t> kept = beside;
    if (!slices.empty()) {
        for (size_t i = 0; i < names[0].numbers.size(); ++i) {
            if (!slices.contains(i)) kept.insert(i);
        }
    }
    const bool has_own_slices = of_slices != nullptr && !of_slices->repeated && !have_pages;
    if (other != nullptr && !has_own_slices &&
        (other->repeated || of_slices != nullptr || have_pages)) {
        const std::string value = names[0].value(other->index[0]);
        for (size_t n = 1; n < names.size(); ++n) {
            if (names[n].value(other->index[n]) != value)
                return refuse(names[0], names[n], other->counts(), kept);
        }
    }
    if (of_slices != nullptr && of_slices->varies && of_slices->repeated)
        return refuse(names[of_slices->first_of_it], names[*of_slices->repeated], Counts::kUnknown,
                      kept);
    if (!is_numbered) {
        const auto stranger = std::find_if_not(
            names.begin(), names.end(), [&](const Name& n) { return is_of_series(n, names[0]); });
        if (stranger != names.end()) return refuse(names[0], *stranger, Counts::kUnknown, kept);
        tell(fmt::format(messages::kSeriesOfSeveralNumbers, names[0].text, names[1].text,
                         names.back().text));
    } else if (other != nullptr && !has_own_slices) {
        tell(fmt::format(messages::kTakenAsSlices, names.front().text, names.back().text,
                         word_for(other->counts())));
    }
    tell_gaps(names);
    return {};
}

}  // namespace openfab::tools
