// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/color/cxf.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/scan_number.h"
#include "base/xml.h"
#include "tools/color/messages.h"
#include "tools/color/stated_light.h"

namespace openfab::color {

namespace {

constexpr size_t kMostObjects = 20'000;

/// What an object was measured as.
struct Measured {
    enum class Kind { kSpectrum, kLab, kXyz } kind = Kind::kSpectrum;
    std::string specification;
    double first_nm = 0;
    std::string text;  ///< the numbers of a spectrum
    std::array<double, 3> values{};
};

struct Object {
    std::string name, type;
    std::optional<Inks> inks;  ///< in percent
    std::vector<Measured> measured;
};

/// How a measurement was made.
struct Specification {
    double first_nm = 0, step_nm = 0;
    std::string light, observer, condition;
};

/// Finds M0 to M3 in a name such as `M1_Daylight`.
std::string condition_in(std::string_view text) {
    for (size_t at = 0; at + 1 < text.size(); ++at) {
        const bool begins = at == 0 || std::isalnum(static_cast<unsigned char>(text[at - 1])) == 0;
        const bool ends =
            at + 2 == text.size() || std::isalnum(static_cast<unsigned char>(text[at + 2])) == 0;
        if (begins && ends && (text[at] == 'M' || text[at] == 'm') && text[at + 1] >= '0' &&
            text[at + 1] <= '3')
            return std::string("M") + text[at + 1];
    }
    return {};
}

class CxfHandler : public XmlHandler {
  public:
    std::vector<Object> objects;
    std::map<std::string, Specification> specifications;

    Complaint start(std::string_view name, const XmlAttributes& attributes) override {
        if (path_.empty() && name != "CxF") return messages::kNotCxf;
        path_.emplace_back(name);
        text_.clear();
        const auto text = [&](const char* key) -> std::string {
            const char* const found = attributes.find(key);
            return found == nullptr ? "" : found;
        };
        const auto number = [&](const char* key) {
            double value = 0;
            return scan_number(text(key), &value).empty() ? value : 0;
        };
        if (name == "Object") {
            if (objects.size() == kMostObjects)
                return {fmt::format(messages::kTooManyPatches, kMostObjects)};
            objects.push_back(
                {text("Name").empty() ? text("Id") : text("Name"), text("ObjectType"), {}, {}});
        } else if (name == "ColorSpecification" && !is_within("Object")) {
            specification_ = &specifications[text("Id")];
            specification_->condition = condition_in(text("Id"));
        } else if (name == "WavelengthRange" && specification_ != nullptr) {
            specification_->first_nm = number("StartWL");
            specification_->step_nm = number("Increment");
        }
        if (!is_within("ColorValues") || objects.empty()) return {};
        const bool spectrum = name == "ReflectanceSpectrum";
        if (spectrum || name == "ColorCIELab" || name == "ColorCIEXYZ") {
            Measured one;
            one.kind = spectrum                ? Measured::Kind::kSpectrum
                       : name == "ColorCIELab" ? Measured::Kind::kLab
                                               : Measured::Kind::kXyz;
            one.specification = text("ColorSpecification");
            one.first_nm = number("StartWL");
            objects.back().measured.push_back(std::move(one));
        }
        return {};
    }

    void end(std::string_view name) override {
        if (name == "Object" || path_.empty()) text_.clear();
        if (!objects.empty() && is_within("DeviceColorValues")) take_ink(name);
        if (!objects.empty() && is_within("ColorValues")) take_color(name);
        if (specification_ != nullptr) {
            if (name == "Illuminant") specification_->light = text_;
            if (name == "Observer") specification_->observer = text_;
            if (const std::string found = condition_in(text_); !found.empty())
                specification_->condition = found;
        }
        if (name == "ColorSpecification") specification_ = nullptr;
        if (!path_.empty()) path_.pop_back();
        text_.clear();
    }

    bool wants_text() const override { return true; }
    void text(std::string_view text) override { text_ += text; }

  private:
    bool is_within(std::string_view name) const {
        return std::find(path_.begin(), path_.end(), name) != path_.end();
    }

    void take_ink(std::string_view name) {
        constexpr std::array<std::string_view, 4> kNames = {"Cyan", "Magenta", "Yellow", "Black"};
        const auto found = std::find(kNames.begin(), kNames.end(), name);
        if (found == kNames.end()) return;
        std::optional<Inks>& inks = objects.back().inks;
        if (!inks) inks.emplace();
        double value = std::nan("");
        if (!scan_number(trimmed(text_), &value).empty()) value = std::nan("");
        (*inks)[static_cast<size_t>(found - kNames.begin())] = value;
    }

    void take_color(std::string_view name) {
        std::vector<Measured>& measured = objects.back().measured;
        if (measured.empty()) return;
        if (name == "ReflectanceSpectrum") measured.back().text = text_;
        constexpr std::string_view kLab = "LAB", kXyz = "XYZ";
        const bool is_lab = measured.back().kind == Measured::Kind::kLab;
        const std::string_view around = is_lab ? "ColorCIELab" : "ColorCIEXYZ";
        if (name.size() != 1 || path_.size() < 2 || path_[path_.size() - 2] != around) return;
        const size_t at = is_lab ? kLab.find(name) : kXyz.find(name);
        if (at == std::string_view::npos) return;
        double value = std::nan("");
        if (!scan_number(trimmed(text_), &value).empty()) value = std::nan("");
        measured.back().values[at] = value;
    }

    static std::string_view trimmed(std::string_view text) {
        constexpr std::string_view kBlanks = " \t\r\n";
        text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
        return text.substr(0, text.find_last_not_of(kBlanks) + 1);
    }

    std::vector<std::string> path_;
    std::string text_;
    Specification* specification_ = nullptr;
};

/// Puts what was measured to the amounts of ink, where programs write them into different objects.
std::vector<Object> joined(std::vector<Object> all) {
    std::vector<Object> out, inks;
    std::map<std::string, std::vector<Object*>> measured;  // by type
    for (Object& one : all) {
        if (one.inks && !one.measured.empty())
            out.push_back(one);
        else if (one.inks)
            inks.push_back(one);
        else if (!one.measured.empty())
            measured[one.type].push_back(&one);
    }
    if (!out.empty()) return out;
    for (auto& [type, objects] : measured) {
        std::map<std::string, Object*> by_name;
        for (Object* one : objects)
            by_name.emplace(one->name, one);
        const bool named = by_name.size() == objects.size() &&
                           std::all_of(inks.begin(), inks.end(), [&](const Object& one) {
                               return by_name.count(one.name) > 0;
                           });
        if (!named && objects.size() != inks.size()) continue;
        for (size_t k = 0; k < inks.size(); ++k) {
            const Object& from = named ? *by_name[inks[k].name] : *objects[k];
            for (Measured one : from.measured) {
                // The type may say the condition, which the specification leaves out.
                if (!condition_in(type).empty() && one.specification.empty())
                    one.specification = type;
                inks[k].measured.push_back(std::move(one));
            }
        }
    }
    std::erase_if(inks, [](const Object& one) { return one.measured.empty(); });
    return inks;
}

/// One kind of measurement that objects have: spectra, Lab or XYZ of one specification.
struct Choice {
    Measured::Kind kind = Measured::Kind::kSpectrum;
    std::string specification;
    bool operator==(const Choice&) const = default;
};

class Reader {
  public:
    Reader(const CxfHandler& file, const Measure& measure) : file_(file), measure_(measure) {}

    Result<SampleTable> run() {
        const std::vector<Object> objects = joined(file_.objects);
        if (objects.empty()) {
            const auto with = [&](auto has) {
                return std::count_if(file_.objects.begin(), file_.objects.end(), has);
            };
            return user_error(
                messages::kCxfNoObjects,
                fmt::format(messages::kCxfNoObjectsHelp,
                            with([](const Object& one) { return one.inks.has_value(); }),
                            with([](const Object& one) { return !one.measured.empty(); })));
        }
        SampleTable table;
        table.has_inks = table.has_lab = true;
        const Result<Choice> chosen = choose(objects.front(), &table.note);
        if (!chosen) return chosen.error();
        for (const Object& object : objects) {
            Result<Sample> sample = sample_of(object, *chosen);
            if (!sample)
                return with_context(sample.error(),
                                    fmt::format(messages::kCxfObject, object.name, ""));
            table.samples.push_back(std::move(*sample));
        }
        if (chosen->kind != Measured::Kind::kSpectrum) return table;
        const double unit = unit_of_reflectances(largest_);
        for (size_t k = 0; k < spectra_.size(); ++k) {
            for (double& value : spectra_[k].second)
                value /= unit;
            table.samples[k].lab =
                lab_of_spectrum(spectra_[k].first, spectra_[k].second, measure_.light);
        }
        return table;
    }

  private:
    std::string condition_of(const std::string& specification) const {
        const auto found = file_.specifications.find(specification);
        if (found != file_.specifications.end() && !found->second.condition.empty())
            return found->second.condition;
        return condition_in(specification);
    }

    /// Spectra count before Lab and XYZ, of several conditions the one that is asked for, else the first of
    /// M1, M0, M2.
    Result<Choice> choose(const Object& object, std::string* note) const {
        std::vector<Choice> all;
        for (const Measured& one : object.measured) {
            const Choice choice{one.kind, one.specification};
            if (std::find(all.begin(), all.end(), choice) == all.end()) all.push_back(choice);
        }
        const auto spectra = [](const Choice& c) { return c.kind == Measured::Kind::kSpectrum; };
        if (std::any_of(all.begin(), all.end(), spectra))
            std::erase_if(all, [&](const Choice& c) { return !spectra(c); });
        std::string names;
        for (const Choice& one : all)
            names += (names.empty() ? "`" : ", `") + name_of(one) + "`";
        const auto with = [&](const std::string& condition) {
            return std::find_if(all.begin(), all.end(), [&](const Choice& c) {
                return condition_of(c.specification) == condition;
            });
        };
        auto found = with(measure_.condition);
        if (!measure_.condition.empty()) {
            if (found == all.end())
                return user_error(fmt::format(messages::kCxfCondition, measure_.condition, names));
            return *found;
        }
        for (const char* condition : {"M1", "M0", "M2"}) {
            found = with(condition);
            if (found != all.end()) break;
        }
        if (found == all.end()) found = all.begin();
        if (all.size() > 1) *note = fmt::format(messages::kCxfChosen, names, name_of(*found));
        return *found;
    }

    std::string name_of(const Choice& choice) const {
        const std::string condition = condition_of(choice.specification);
        return condition.empty() ? choice.specification : condition;
    }

    Result<Sample> sample_of(const Object& object, const Choice& chosen) {
        Sample sample;
        sample.id = object.name;
        for (size_t i = 0; i < sample.inks.size(); ++i) {
            const double percent = (*object.inks)[i];
            if (!(percent >= -1e-6 && percent <= 100 + 1e-6))
                return user_error(
                    fmt::format(messages::kCxfValueOutside, percent, "ColorCMYK", 0.0, 100.0));
            sample.inks[i] = percent / 100;
        }
        if (const Complaint wrong = settle_inks(&sample.inks); !wrong.empty())
            return user_error(wrong.what, wrong.help);
        const auto found =
            std::find_if(object.measured.begin(), object.measured.end(), [&](const Measured& one) {
                return Choice{one.kind, one.specification} == chosen;
            });
        if (found == object.measured.end()) return user_error(messages::kCxfOtherKind);
        if (chosen.kind == Measured::Kind::kSpectrum) {
            if (Result<void> taken = take_spectrum(*found); !taken) return taken.error();
            return sample;
        }
        if (Result<void> fine = check_light(*found); !fine) return fine.error();
        const std::array<double, 3>& v = found->values;
        for (const double one : v) {
            constexpr double kMost = 200;
            if (!(std::abs(one) <= kMost))
                return user_error(
                    fmt::format(messages::kCxfValueOutside, one, "ColorValues", -kMost, kMost));
        }
        sample.lab = {v[0], v[1], v[2]};
        if (chosen.kind == Measured::Kind::kXyz)
            sample.lab = to_lab(
                {std::max(v[0], 0.0) / 100, std::max(v[1], 0.0) / 100, std::max(v[2], 0.0) / 100});
        return sample;
    }

    /// Lab and XYZ are of D50 and 2 degrees, if they say what they are of.
    Result<void> check_light(const Measured& one) const {
        if (measure_.light != Light::kD50)
            return user_error(messages::kNoSpectra, messages::kNoSpectraHelp);
        const auto found = file_.specifications.find(one.specification);
        if (found == file_.specifications.end()) return {};
        StatedLight stated;
        stated.take_light(found->second.light);
        stated.take_observer(found->second.observer);
        if (!stated.other().empty())
            return user_error(fmt::format(messages::kOtherLight, stated.other()),
                              messages::kOtherLightHelp);
        return {};
    }

    Result<void> take_spectrum(const Measured& one) {
        std::vector<double> values;
        std::string_view rest = one.text;
        constexpr std::string_view kBlanks = " \t\r\n";
        constexpr size_t kMostValues = 2000;
        while (true) {
            rest.remove_prefix(std::min(rest.find_first_not_of(kBlanks), rest.size()));
            if (rest.empty() || values.size() == kMostValues) break;
            const std::string_view word = rest.substr(0, rest.find_first_of(kBlanks));
            double value = 0;
            constexpr double kLeast = -20, kMost = 1000;
            if (!scan_number(word, &value).empty())
                return user_error(fmt::format(messages::kCxfNotNumbers, word));
            if (!(value >= kLeast && value <= kMost))
                return user_error(fmt::format(messages::kCxfValueOutside, value,
                                              "ReflectanceSpectrum", kLeast, kMost));
            values.push_back(value);
            largest_ = std::max(largest_, value);
            rest.remove_prefix(word.size());
        }
        Specification how;
        if (const auto found = file_.specifications.find(one.specification);
            found != file_.specifications.end())
            how = found->second;
        const double first = one.first_nm > 0 ? one.first_nm : how.first_nm;
        // Most files leave the step out where it is that of instruments.
        constexpr double kUsual = 10;
        const double step = how.step_nm > 0 ? how.step_nm : kUsual;
        if (!(first > 0)) return user_error(messages::kCxfNoStart);
        const Wavelengths at{first, step, values.size()};
        if (Result<void> fine = at.check(); !fine) return fine;
        spectra_.emplace_back(at, std::move(values));
        return {};
    }

    const CxfHandler& file_;
    const Measure& measure_;
    std::vector<std::pair<Wavelengths, std::vector<double>>> spectra_;
    double largest_ = 0;
};

}  // namespace

bool is_cxf(std::string_view text) {
    const size_t at = text.find_first_not_of(" \t\r\n");
    return at != std::string_view::npos && text[at] == '<';
}

Result<SampleTable> parse_cxf(std::string_view text, const Measure& measure) {
    CxfHandler file;
    if (Result<void> read = parse_xml(text, "CxF", &file); !read) return read.error();
    return Reader(file, measure).run();
}

}  // namespace openfab::color
