// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/color/samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/color.h"
#include "base/plain_text.h"
#include "base/scan_number.h"
#include "tools/color/cxf.h"
#include "tools/color/messages.h"
#include "tools/color/read_named.h"
#include "tools/color/stated_light.h"
#include "tools/color/table_text.h"

namespace openfab::color {

namespace {

constexpr int64_t kLargestFile = 64 << 20;
constexpr size_t kMostSamples = 4000;

class Parser {
  public:
    Parser(std::string_view text, Light light)
        : text_(text), is_cgats_(is_cgats(text)), words_left_(text), light_asked_(light) {}

    Result<SampleTable> run() {
        if (Result<void> read = is_cgats_ ? read_cgats() : read_csv(); !read) return read.error();
        if (columns_.empty()) {
            return user_error(messages::kNotATable, messages::kNotATableHelp);
        }
        if (table_.samples.empty()) return user_error(messages::kNoPatches);
        if (Result<void> percent = check_percent(); !percent) return percent.error();
        if (Result<void> seen = see_spectra(); !seen) return seen.error();
        if (light_.relative() && !spectra_.there()) table_.note = messages::kWhiteOfPaper;
        return std::move(table_);
    }

  private:
    Error error(const std::string& what, const std::string& help = {}) const {
        return user_error(fmt::format(messages::kLineOf, number_, what), help);
    }

    Result<void> read_cgats() {
        while (const std::optional<CgatsWord> word = words_left_.next()) {
            number_ = word->line;
            if (word->is("BEGIN_DATA_FORMAT")) {
                if (Result<void> named = take_format(*word); !named) return named;
            } else if (word->is("BEGIN_DATA")) {
                if (Result<void> found = find_columns(); !found) return found;
                Result<void> taken = take_sets();
                if (!taken && odd_lines_ == 1)
                    // A row that has a value too few or too many moves all behind it.
                    taken = user_error(fmt::format(
                        messages::kLineOf, odd_line_,
                        fmt::format(messages::kValuesForColumns, odd_values_, columns_.size())));
                return taken;  // further tables are of calibrations
            } else {
                std::vector<std::string_view> values;
                while (const std::optional<CgatsWord> value = words_left_.next_of_line())
                    values.push_back(value->text);
                if (Result<void> taken = take_keyword(word->text, values); !taken) return taken;
            }
        }
        return {};
    }

    /// What a head says beside its columns.
    Result<void> take_keyword(std::string_view key, const std::vector<std::string_view>& values) {
        const auto number = [&](double* value) {
            return !values.empty() && scan_number(values[0], value).empty();
        };
        double value = 0;
        if (key == "OPENFAB_COLUMNS") {
            if (!number(&value) || value < 1 || value > kMostColumns || value != std::floor(value))
                return error(messages::kColumnsNotACount);
            table_.columns = static_cast<int>(value);
        } else if (key == "NUMBER_OF_SETS") {
            if (number(&value)) sets_ = value;
        } else if (key == "SPECTRAL_START_NM" || key == "SPECTRAL_END_NM" ||
                   key == "SPECTRAL_NORM") {
            double* const to = key == "SPECTRAL_NORM"       ? &spectral_norm_
                               : key == "SPECTRAL_START_NM" ? &spectral_first_
                                                            : &spectral_last_;
            if (number(&value) && value > 0) *to = value;
        } else if (key == "CTI1" || key == "CTI2") {
            table_.is_chart = true;
        } else {
            light_.take(key, values);
        }
        return {};
    }

    /// Takes the names of columns, behind the word `begin`.
    Result<void> take_format(const CgatsWord& begin) {
        columns_.clear();
        while (const std::optional<CgatsWord> word = words_left_.next()) {
            number_ = word->line;
            if (word->is("END_DATA_FORMAT")) {
                // Between names there are blanks: then a comma in a value is its decimal point.
                const std::string_view names(begin.text.data(), word->text.data());
                if (names.find_first_of(",;") == std::string_view::npos) words_left_.keep_commas();
                break;
            }
            if (columns_.size() == kMostColumns) return error(messages::kTooManyColumns);
            columns_.emplace_back(word->text);
        }
        return {};
    }

    /// Takes the values of all sets. Each has as many as there are columns, on one line or several; where the head says
    /// how many sets there are, lines end anywhere.
    Result<void> take_sets() {
        int lines = 0, line = 0;
        size_t on_line = 0;
        const auto end_line = [&] {
            if (on_line == 0 || on_line == columns_.size()) return;
            if (odd_lines_++ == 0) odd_line_ = line, odd_values_ = on_line;
        };
        while (const std::optional<CgatsWord> word = words_left_.next()) {
            if (word->line != line) {
                end_line();
                line = word->line, on_line = 0;
                ++lines;
            }
            if (word->is("END_DATA")) {
                end_line();
                return check_whole(true);
            }
            ++on_line;
            if (!sets_ && words_.empty() && on_line > 1) {
                number_ = line;
                return error(
                    fmt::format(messages::kTooManyValues, columns_.size(), columns_.size()));
            }
            if (words_.empty()) number_ = line;
            words_.push_back(std::string(word->text));
            if (words_.size() < columns_.size()) continue;
            if (Result<void> taken = take_row(); !taken) return taken;
            words_.clear();
        }
        end_line();
        return check_whole(false);
    }

    /// A table that says how many rows it has has them all, and ends.
    Result<void> check_whole(bool ended) const {
        if (!words_.empty())
            return error(fmt::format(messages::kValuesForColumns, words_.size(), columns_.size()));
        if (sets_ && *sets_ != static_cast<double>(table_.samples.size()))
            return user_error(fmt::format(messages::kRowsMissing, *sets_, table_.samples.size()),
                              messages::kRowsMissingHelp);
        if (!ended) return user_error(messages::kNoEndOfData, messages::kRowsMissingHelp);
        return {};
    }

    /// Colours of XYZ and Lab are of D50 and the observer of 2 degrees, if they say what they are of.
    Result<void> check_light() const {
        if (by_camera_ || !table_.has_lab || spectra_.there()) return {};
        if (light_asked_ != Light::kD50)
            return user_error(messages::kNoSpectra, messages::kNoSpectraHelp);
        if (!light_.other().empty())
            return user_error(fmt::format(messages::kOtherLight, light_.other()),
                              messages::kOtherLightHelp);
        return {};
    }

    Result<void> check_percent() const {
        double most = 0;
        for (const Sample& sample : table_.samples)
            most = std::max(most, *std::max_element(sample.inks.begin(), sample.inks.end()));
        constexpr double kOnePercent = 0.01;
        if (!table_.has_inks || most == 0 || most > kOnePercent) return {};
        return user_error(fmt::format(messages::kInksBelowOnePercent, most * 100),
                          messages::kInksArePercent);
    }

    Result<void> read_csv() {
        CsvRows rows(text_);
        const bool named = names_columns(upper(text_));
        // What precedes the names of columns: comments, titles, and Excel's `sep=;`.
        for (; !rows.at_end(); rows.skip_line()) {
            const std::string line = upper(rows.peek());
            const bool cells = line.find_first_of(",;\t") != std::string::npos;
            if (line.starts_with('#') || line.starts_with("SEP=")) continue;
            if (cells && (names_columns(line) || !named)) break;
            CgatsWords words(rows.peek());
            std::vector<std::string_view> values;
            while (const std::optional<CgatsWord> word = words.next())
                values.push_back(word->text);
            if (values.empty()) continue;
            number_ = rows.next_line();
            const std::string_view key = values.front();
            values.erase(values.begin());
            if (Result<void> taken = take_keyword(key, values); !taken) return taken;
        }
        if (rows.at_end()) return {};
        const std::string_view line = rows.peek();
        for (const char one : {',', ';', '\t'}) {
            if (std::count(line.begin(), line.end(), one) >
                std::count(line.begin(), line.end(), rows.separator()))
                rows.set_separator(one);
        }
        rows.next(&words_);
        number_ = rows.line();
        if (words_.size() > kMostColumns) return error(messages::kTooManyColumns);
        columns_ = words_;
        if (Result<void> found = find_columns(); !found) return found;
        while (rows.next(&words_)) {
            number_ = rows.line();
            if (Result<void> taken = take_cells(); !taken) return taken;
        }
        return {};
    }

    static bool names_columns(std::string_view text) {
        for (const char* name : {"CMYK_C", "RGB_R", "LAB_L"})
            if (text.find(name) != std::string_view::npos) return true;
        return false;
    }

    /// A row of a CSV; lines without values, and comments, are none.
    Result<void> take_cells() {
        const auto filled = [](const std::string& cell) { return !cell.empty(); };
        if (std::none_of(words_.begin(), words_.end(), filled)) return {};
        if (words_.size() != columns_.size() && words_.front().starts_with('#')) return {};
        while (words_.size() > columns_.size() && words_.back().empty())
            words_.pop_back();
        if (words_.size() > columns_.size())
            return error(fmt::format(messages::kTooManyValues, columns_.size(), columns_.size()));
        if (words_.size() < columns_.size())
            return error(fmt::format(messages::kValuesForColumns, words_.size(), columns_.size()));
        return take_row();
    }

    int index_of(std::string_view name) const {
        const auto found =
            std::find_if(columns_.begin(), columns_.end(),
                         [&](const std::string& column) { return upper(column) == name; });
        return found == columns_.end() ? -1 : static_cast<int>(found - columns_.begin());
    }

    /// Finds columns that go together; an error where only some of them are there.
    template <size_t count>
    Result<void> find(const std::array<const char*, count>& names, std::array<int, count>* at,
                      bool* there) {
        size_t found = 0;
        for (size_t i = 0; i < count; ++i) {
            (*at)[i] = index_of(names[i]);
            if ((*at)[i] >= 0) ++found;
            if (std::count_if(columns_.begin(), columns_.end(), [&](const std::string& column) {
                    return upper(column) == names[i];
                }) > 1)
                return error(fmt::format(messages::kColumnTwice, names[i]),
                             messages::kColumnTwiceHelp);
        }
        *there = found == count;
        if (found == 0 || found == count) return {};
        for (size_t i = 0; i < count; ++i) {
            if ((*at)[i] < 0)
                return error(fmt::format(messages::kColumnMissing, names[i]),
                             fmt::format(messages::kColumnGoesWith, names[i == 0 ? 1 : 0]));
        }
        return {};
    }

    Result<void> find_columns() {
        Result<void> found =
            find<4>({"CMYK_C", "CMYK_M", "CMYK_Y", "CMYK_K"}, &inks_, &table_.has_inks);
        if (found) found = find<3>({"RGB_R", "RGB_G", "RGB_B"}, &rgb_, &table_.has_rgb);
        if (found) found = find<3>({"LAB_L", "LAB_A", "LAB_B"}, &lab_, &table_.has_lab);
        if (found) found = find<3>({"XYZ_X", "XYZ_Y", "XYZ_Z"}, &xyz_, &has_xyz_);
        if (!found) return found;
        for (const char* name : {"SAMPLE_ID", "SAMPLEID", "SAMPLE_NAME", "SAMPLENAME"})
            if (id_ < 0) id_ = index_of(name);
        if (!table_.has_inks && !table_.has_rgb) {
            return error(messages::kNeitherInksNorColours, messages::kNeitherInksNorColoursHelp);
        }
        Result<SpectralColumns> spectra = SpectralColumns::find(columns_);
        if (!spectra)
            return with_context(spectra.error(), fmt::format(messages::kLineOf, number_, ""));
        spectra_ = std::move(*spectra);
        const bool measured = table_.has_lab || has_xyz_ || spectra_.there();
        by_camera_ = table_.has_inks && table_.has_rgb && !measured;
        by_xyz_ = has_xyz_ && !table_.has_lab;
        table_.has_lab = measured || by_camera_;
        return check_light();
    }

    /// Reads a number in a range, or beyond it by what programs round.
    Result<double> number(int column, double lowest, double highest, const char* help = "") {
        double value = 0;
        const std::string& word = words_[static_cast<size_t>(column)];
        const std::string& name = columns_[static_cast<size_t>(column)];
        if (!read_number(word, &value))
            return error(fmt::format(messages::kValueNotANumber, word, name));
        const double slack = (highest - lowest) * 5e-4;
        if (value < lowest - slack || value > highest + slack)
            return error(fmt::format(messages::kValueOutside, word, name, lowest, highest), help);
        return value;
    }

    template <size_t count>
    Result<void> numbers(const std::array<int, count>& columns, double lowest, double highest,
                         double one, std::array<double, count>* out, const char* help = "") {
        for (size_t i = 0; i < count; ++i) {
            const Result<double> value = number(columns[i], lowest, highest, help);
            if (!value) return value.error();
            (*out)[i] = *value / one;
        }
        return {};
    }

    /// Keeps a patch's reflectances until the unit of all of them is known.
    Result<void> take_spectrum() {
        std::vector<double> one;
        for (const int column : spectra_.columns()) {
            constexpr double kLeast = -20, kMost = 1000;  // of percent
            const Result<double> value = number(column, kLeast, kMost);
            if (!value) return value.error();
            largest_ = std::max(largest_, *value);
            one.push_back(*value);
        }
        reflected_.push_back(std::move(one));
        return {};
    }

    /// Computes the colours of spectra.
    Result<void> see_spectra() {
        if (!spectra_.there()) return {};
        Wavelengths at = spectra_.wavelengths();
        // Names of columns are rounded to whole nanometres.
        if (spectral_first_ > 0 && std::abs(spectral_first_ - at.first) < 1) {
            const double last = at.first + at.step * static_cast<double>(at.count - 1);
            const double end = std::abs(spectral_last_ - last) < 1 ? spectral_last_ : last;
            at.first = spectral_first_;
            at.step = (end - at.first) / static_cast<double>(at.count - 1);
        }
        const double unit = spectral_norm_ > 0
                                ? spectral_norm_
                                : spectra_.unit().value_or(unit_of_reflectances(largest_));
        for (size_t k = 0; k < reflected_.size(); ++k) {
            for (double& value : reflected_[k])
                value /= unit;
            table_.samples[k].lab = lab_of_spectrum(at, reflected_[k], light_asked_);
        }
        return {};
    }

    /// Takes a patch of the words.
    Result<void> take_row() {
        if (table_.samples.size() == kMostSamples)
            return error(fmt::format(messages::kTooManyPatches, kMostSamples));
        Sample sample;
        sample.id =
            id_ >= 0 ? words_[static_cast<size_t>(id_)] : std::to_string(table_.samples.size() + 1);
        Result<void> read;
        if (table_.has_inks)
            read = numbers(inks_, 0, 100, 100, &sample.inks, messages::kInksArePercent);
        if (read && table_.has_rgb) read = numbers(rgb_, 0, 255, 255, &sample.rgb);
        if (!read) return read;
        if (const Complaint wrong = settle_inks(&sample.inks); !wrong.empty())
            return error(wrong.what, wrong.help);
        if (spectra_.there()) {
            if (Result<void> got = take_spectrum(); !got) return got;
            table_.samples.push_back(std::move(sample));
            return {};
        }
        std::array<double, 3> v{};
        if (by_camera_) {
            Rgb linear;
            for (size_t i = 0; i < 3; ++i)
                linear[i] = srgb_to_linear(std::clamp(sample.rgb[i], 0.0, 1.0));
            sample.lab = to_lab(xyz_of_linear(linear));
        } else if (by_xyz_) {
            // Instruments measure a little less than nothing.
            if (Result<void> xyz = numbers(xyz_, -0.5, 200, 100, &v); !xyz) return xyz;
            sample.lab = to_lab({std::max(v[0], 0.0), std::max(v[1], 0.0), std::max(v[2], 0.0)});
        } else if (table_.has_lab) {
            if (Result<void> lab = numbers(lab_, -200, 200, 1, &v); !lab) return lab;
            if (const Result<double> l = number(lab_[0], -0.5, 150); !l) return l.error();
            sample.lab = {std::max(v[0], 0.0), v[1], v[2]};
        }
        table_.samples.push_back(std::move(sample));
        return {};
    }

    std::string_view text_;
    bool is_cgats_;
    CgatsWords words_left_;
    int number_ = 0;  ///< of the line
    std::vector<std::string> columns_, words_;
    std::array<int, 4> inks_{};
    std::array<int, 3> rgb_{}, lab_{}, xyz_{};
    std::optional<double> sets_;
    int odd_lines_ = 0, odd_line_ = 0;  ///< whose values are not those of one set
    size_t odd_values_ = 0;
    StatedLight light_;
    Light light_asked_;
    SpectralColumns spectra_;
    std::vector<std::vector<double>> reflected_;  ///< of each patch, as the table has them
    double largest_ = 0, spectral_norm_ = 0, spectral_first_ = 0, spectral_last_ = 0;
    int id_ = -1;
    bool has_xyz_ = false, by_xyz_ = false, by_camera_ = false;
    SampleTable table_;
};

/// Returns a text on one line in quotes, with others for those that it has.
std::string in_quotes(std::string text) {
    std::replace(text.begin(), text.end(), '"', '\'');
    std::replace_if(
        text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
    return '"' + text + '"';
}

/// Returns a word as CGATS text has it: in quotes where it is empty, or holds what ends one.
std::string quoted(const std::string& word) {
    const bool plain = !word.empty() && word.find_first_of(" \t\r\n,;#'\"") == std::string::npos;
    return plain ? word : in_quotes(word);
}

}  // namespace

Complaint settle_inks(Inks* inks) {
    double sum = 0;
    for (double& ink : *inks) {
        ink = std::clamp(ink, 0.0, 1.0);
        sum += ink;
    }
    constexpr double kSlack = 4 * 0.5 / 255 + 1e-4;  // of four amounts of 8 bits
    if (sum > 1 + kSlack)
        return {fmt::format(messages::kInksAddUp, sum * 100), messages::kInksAddUpHelp};
    constexpr double kThreeDecimals = 1e-3;
    if (sum > 1 + kThreeDecimals)
        for (double& ink : *inks)
            ink /= sum;
    return {};
}

Result<SampleTable> parse_samples(std::string_view text, const Measure& measure) {
    if (const Complaint wide = not_utf8(text); !wide.empty())
        return user_error(wide.what, wide.help);
    const PlainText plain(text);
    if (is_cxf(plain.text())) return parse_cxf(plain.text(), measure);
    return Parser(plain.text(), measure.light).run();
}

Result<SampleTable> read_samples(const std::filesystem::path& file, const Measure& measure) {
    return read_named(file, kLargestFile,
                      [&](const std::string& text) { return parse_samples(text, measure); });
}

std::string format_samples(const SampleTable& table, const std::string& description) {
    // What is measured is a `.ti3`, as Argyll reads it.
    const bool ti3 = table.has_inks && table.has_lab;
    std::string out =
        fmt::format("{}\n\nDESCRIPTOR {}\nORIGINATOR \"OpenFab\"\n{}KEYWORD \"OPENFAB_COLUMNS\"\n",
                    ti3 ? "CTI3" : "CGATS.17", in_quotes(description),
                    ti3 ? "DEVICE_CLASS \"OUTPUT\"\nCOLOR_REP \"CMYK_LAB\"\n" : "");
    if (table.columns > 0) out += fmt::format("OPENFAB_COLUMNS {}\n", table.columns);
    std::string names = "SAMPLE_ID";
    int fields = 1;
    const auto add = [&](bool there, const char* columns, int count) {
        if (!there) return;
        names += columns;
        fields += count;
    };
    add(table.has_inks, " CMYK_C CMYK_M CMYK_Y CMYK_K", 4);
    add(table.has_rgb, " RGB_R RGB_G RGB_B", 3);
    add(table.has_lab, " LAB_L LAB_A LAB_B", 3);
    out +=
        fmt::format("NUMBER_OF_FIELDS {}\nBEGIN_DATA_FORMAT\n{}\nEND_DATA_FORMAT\n", fields, names);
    out += fmt::format("NUMBER_OF_SETS {}\nBEGIN_DATA\n", table.samples.size());
    for (const Sample& s : table.samples) {
        out += quoted(s.id);
        if (table.has_inks) {
            for (const double ink : s.inks)
                out += fmt::format(" {:.3f}", ink * 100);
        }
        if (table.has_rgb) {
            for (const double value : s.rgb)
                out += fmt::format(" {:.2f}", value * 255);
        }
        if (table.has_lab) out += fmt::format(" {:.3f} {:.3f} {:.3f}", s.lab.l, s.lab.a, s.lab.b);
        out += '\n';
    }
    return out + "END_DATA\n";
}

}  // namespace openfab::color
