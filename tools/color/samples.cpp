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
#include "tools/color/table_text.h"

namespace openfab::color {

namespace {

constexpr int64_t kLargestFile = 64 << 20;
constexpr size_t kMostSamples = 4000;

class Parser {
  public:
    Parser(std::string_view text, Light light)
        : text_(text), is_cgats_(is_cgats(text)), light_asked_(light) {}

    Result<SampleTable> run() {
        std::string_view line;
        while (next(&line)) {
            if (Result<void> taken = take_line(line); !taken) return taken.error();
        }
        if (Result<void> whole = check_whole(); !whole) return whole.error();
        if (columns_.empty()) {
            return user_error(messages::kNotATable, messages::kNotATableHelp);
        }
        if (table_.samples.empty()) return user_error(messages::kNoPatches);
        if (Result<void> seen = see_spectra(); !seen) return seen.error();
        return std::move(table_);
    }

  private:
    enum class Part { kHead, kFormat, kBetween, kData, kRows, kEnd };

    bool next(std::string_view* line) {
        if (at_ >= text_.size()) return false;
        const size_t end = std::min(text_.find('\n', at_), text_.size());
        *line = text_.substr(at_, end - at_);
        at_ = end + 1;
        ++number_;
        return true;
    }

    Error error(const std::string& what, const std::string& help = {}) const {
        return user_error(fmt::format(messages::kLineOf, number_, what), help);
    }

    /// A table that says how many rows it has, or where it ends, has them all.
    Result<void> check_whole() const {
        if (part_ == Part::kData && !words_.empty())
            return error(fmt::format(messages::kValuesForColumns, words_.size(), columns_.size()));
        if (sets_ && part_ >= Part::kData && *sets_ != static_cast<double>(table_.samples.size()))
            return user_error(fmt::format(messages::kRowsMissing, *sets_, table_.samples.size()),
                              messages::kRowsMissingHelp);
        if (!sets_ && part_ == Part::kData)
            return user_error(messages::kNoEndOfData, messages::kRowsMissingHelp);
        return {};
    }

    /// What a head says beside its columns.
    Result<void> take_keyword(std::string_view first, std::string_view rest) {
        double value = 0;
        if (first == "OPENFAB_COLUMNS") {
            if (!scan_number(take_word(&rest), &value).empty() || value < 1 ||
                value > kMostColumns || value != std::floor(value))
                return error(messages::kColumnsNotACount);
            table_.columns = static_cast<int>(value);
        } else if (first == "NUMBER_OF_SETS") {
            if (scan_number(take_word(&rest), &value).empty()) sets_ = value;
        } else if (first == "SPECTRAL_START_NM" || first == "SPECTRAL_END_NM" ||
                   first == "SPECTRAL_NORM") {
            double* const to = first == "SPECTRAL_NORM"       ? &spectral_norm_
                               : first == "SPECTRAL_START_NM" ? &spectral_first_
                                                              : &spectral_last_;
            if (scan_number(take_word(&rest), &value).empty() && value > 0) *to = value;
        } else if (first == "CTI1" || first == "CTI2") {
            table_.is_chart = true;
        } else if (first == "ILLUMINATION_NAME" || first == "ILLUMINANT") {
            light_ = take_word(&rest);
        } else if (first == "WEIGHTING_FUNCTION") {
            // `"ILLUMINANT, D65"`, `"OBSERVER, 10 degree"`
            const std::string_view text = take_word(&rest);
            const size_t comma = text.find(',');
            std::string_view what = comma < text.size() ? text.substr(comma + 1) : text;
            what.remove_prefix(std::min(what.find_first_not_of(' '), what.size()));
            if (text.starts_with("ILLUMINANT")) light_ = what;
            if (text.starts_with("OBSERVER")) observer_ = what;
        } else if (first == "MEASUREMENT_SOURCE") {
            take_source(take_word(&rest));
        } else if (first == "OBSERVER") {
            observer_ = take_word(&rest);
        }
        return {};
    }

    /// `Illumination=D50 ObserverAngle=2 WhiteBase=Absolute`, as X-Rite's programs have it.
    void take_source(std::string_view text) {
        constexpr std::string_view kBetween = " \t,;",
                                   kLight = "Illumination=", kObserver = "ObserverAngle=";
        while (!text.empty()) {
            const std::string_view word = text.substr(0, text.find_first_of(kBetween));
            text.remove_prefix(std::min(word.size() + 1, text.size()));
            if (word.starts_with(kLight)) light_ = word.substr(kLight.size());
            if (word.starts_with(kObserver)) observer_ = word.substr(kObserver.size());
        }
    }

    /// Colours of XYZ and Lab are of D50 and the observer of 2 degrees, if they say what they are of.
    Result<void> check_light() const {
        if (by_camera_ || !table_.has_lab || spectra_.there()) return {};
        if (light_asked_ != Light::kD50)
            return user_error(messages::kNoSpectra, messages::kNoSpectraHelp);
        const std::string light = upper(light_);
        if (!light.empty() && light.find("D50") == std::string::npos)
            return user_error(fmt::format(messages::kOtherLight, light_),
                              messages::kOtherLightHelp);
        if (observer_.find("10") != std::string::npos ||
            observer_.find("1964") != std::string::npos)
            return user_error(fmt::format(messages::kOtherLight, observer_),
                              messages::kOtherLightHelp);
        return {};
    }

    Result<void> take_line(std::string_view line) {
        std::string_view rest = line;
        const std::optional<std::string_view> word = take(&rest);
        if (part_ == Part::kRows) return take_cells(line);
        if (!word) return {};
        const std::string_view first = *word;
        switch (part_) {
            case Part::kHead:
            case Part::kBetween:
                if (first == "BEGIN_DATA_FORMAT") {
                    part_ = Part::kFormat;
                    columns_.clear();
                } else if (first == "BEGIN_DATA") {
                    part_ = Part::kData;
                    return find_columns();
                } else if (!is_cgats_ && line.find_first_of(",;\t") != std::string_view::npos) {
                    part_ = Part::kRows;
                    return take_names(line);
                }
                return take_keyword(first, rest);
            case Part::kFormat:
                if (first == "END_DATA_FORMAT") {
                    part_ = Part::kBetween;
                    return {};
                }
                return add_names(line);
            case Part::kData:
                if (first == "END_DATA") {
                    if (!words_.empty()) return check_whole();
                    part_ = Part::kEnd;
                    return {};
                }
                return take_values(line);
            case Part::kRows:
            case Part::kEnd:
                return {};  // further tables, of calibrations
        }
        return {};
    }

    Result<void> add_names(std::string_view line) {
        for (std::string_view word = take_word(&line); !word.empty(); word = take_word(&line)) {
            if (columns_.size() == kMostColumns) return error(messages::kTooManyColumns);
            columns_.emplace_back(word);
        }
        return {};
    }

    Result<void> take_names(std::string_view line) {
        for (const char one : {',', ';', '\t'}) {
            if (std::count(line.begin(), line.end(), one) >
                std::count(line.begin(), line.end(), separator_))
                separator_ = one;
        }
        const std::vector<std::string_view> cells = cells_of(line, separator_);
        if (cells.size() > kMostColumns) return error(messages::kTooManyColumns);
        columns_.assign(cells.begin(), cells.end());
        return find_columns();
    }

    /// A row of a CSV; lines without values, and comments, are none.
    Result<void> take_cells(std::string_view line) {
        words_ = cells_of(line, separator_);
        const auto filled = [](std::string_view cell) { return !cell.empty(); };
        if (std::none_of(words_.begin(), words_.end(), filled)) return {};
        if (words_.size() != columns_.size() && line.starts_with('#')) return {};
        while (words_.size() > columns_.size() && words_.back().empty())
            words_.pop_back();
        if (words_.size() > columns_.size())
            return error(fmt::format(messages::kTooManyValues, columns_.size(), columns_.size()));
        if (words_.size() < columns_.size())
            return error(fmt::format(messages::kValuesForColumns, words_.size(), columns_.size()));
        return take_row();
    }

    /// Values of CGATS: a set has as many as there are columns, on one line or several.
    Result<void> take_values(std::string_view line) {
        const size_t before = words_.size();
        for (std::optional<std::string_view> word = take(&line); word; word = take(&line)) {
            if (words_.size() == columns_.size()) {
                return before > 0 ? error(fmt::format(messages::kValuesForColumns, before,
                                                      columns_.size()))
                                  : error(fmt::format(messages::kTooManyValues, columns_.size(),
                                                      columns_.size()));
            }
            words_.push_back(*word);
        }
        if (words_.size() < columns_.size()) return {};
        Result<void> taken = take_row();
        words_.clear();
        return taken;
    }

    int index_of(const char* name) const {
        const auto found = std::find(columns_.begin(), columns_.end(), name);
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
        id_ = index_of("SAMPLE_ID");
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

    Result<double> number(int column, double lowest, double highest) {
        double value = 0;
        const std::string_view word = words_[static_cast<size_t>(column)];
        if (!scan_number(word, &value).empty() || !std::isfinite(value)) {
            return error(fmt::format(messages::kValueNotANumber, word,
                                     columns_[static_cast<size_t>(column)]));
        }
        if (value < lowest || value > highest) {
            return error(fmt::format(messages::kValueOutside, word,
                                     columns_[static_cast<size_t>(column)], lowest, highest));
        }
        return value;
    }

    template <size_t count>
    Result<void> numbers(const std::array<int, count>& columns, double lowest, double highest,
                         double one, std::array<double, count>* out) {
        for (size_t i = 0; i < count; ++i) {
            const Result<double> value = number(columns[i], lowest, highest);
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
        sample.id = id_ >= 0 ? std::string(words_[static_cast<size_t>(id_)])
                             : std::to_string(table_.samples.size() + 1);
        Result<void> read;
        if (table_.has_inks) read = numbers(inks_, -1e-6, 100 + 1e-6, 100, &sample.inks);
        if (read && table_.has_rgb) read = numbers(rgb_, -1e-6, 255 + 1e-6, 255, &sample.rgb);
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
            sample.lab = {v[0], v[1], v[2]};
        }
        table_.samples.push_back(std::move(sample));
        return {};
    }

    std::string_view text_;
    bool is_cgats_;
    size_t at_ = 0;
    int number_ = 0;
    Part part_ = Part::kHead;
    std::vector<std::string> columns_;
    std::vector<std::string_view> words_;
    std::array<int, 4> inks_{};
    std::array<int, 3> rgb_{}, lab_{}, xyz_{};
    char separator_ = ',';  ///< of a CSV
    std::optional<double> sets_;
    std::string_view light_, observer_;
    Light light_asked_;
    SpectralColumns spectra_;
    std::vector<std::vector<double>> reflected_;  ///< of each patch, as the table has them
    double largest_ = 0, spectral_norm_ = 0, spectral_first_ = 0, spectral_last_ = 0;
    int id_ = -1;
    bool has_xyz_ = false, by_xyz_ = false, by_camera_ = false;
    SampleTable table_;
};

/// Returns a word as CGATS text has it: in quotes where it is empty, or holds what ends one.
std::string quoted(std::string word) {
    std::replace(word.begin(), word.end(), '"', '\'');
    if (!word.empty() && word.find_first_of(" \t,;#'") == std::string::npos) return word;
    return '"' + word + '"';
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
    std::string out = fmt::format(
        "{}\n\nDESCRIPTOR \"{}\"\nORIGINATOR \"OpenFab\"\n{}KEYWORD \"OPENFAB_COLUMNS\"\n",
        ti3 ? "CTI3" : "CGATS.17", description,
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
