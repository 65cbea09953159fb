// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "texture/xdmf_steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "base/scan_number.h"
#include "base/text.h"
#include "base/xml.h"
#include "texture/messages.h"

namespace openfab::texture {

namespace {

/// A Temporal collection.
struct Series {
    std::vector<std::optional<double>> times;  ///< of each step
    std::string kind, list;                    ///< of times that stand before the steps
    std::vector<std::string> fields;           ///< of the first step

    Result<std::vector<double>> each_time() const {
        std::vector<double> listed;
        std::string_view left = list;
        for (std::string_view word = take_word(&left); !word.empty(); word = take_word(&left)) {
            if (!scan_number(word, &listed.emplace_back()).empty())
                return user_error(messages::kTimesNotNumbers);
        }
        const bool is_range = kind == "hyperslab" && listed.size() == 3;  // start, step, count
        std::vector<double> out;
        for (size_t i = 0; i < times.size(); ++i) {
            const auto number = static_cast<double>(i);
            out.push_back(times[i]                              ? *times[i]
                          : is_range                            ? listed[0] + listed[1] * number
                          : i < listed.size() && kind == "list" ? listed[i]
                                                                : number);
        }
        return out;
    }
};

/// Receives the elements.
class Steps final : public XmlHandler {
  public:
    Complaint start(std::string_view name, const XmlAttributes& a) override {
        ++depth_;
        if (name == "Grid") {
            if (series_ > 0 && depth_ == series_ + 1) {
                step_ = depth_;
                all_.back().times.emplace_back();
            } else if (step_ == 0 && xdmf_word(a, "GridType", "Type") == "collection" &&
                       xdmf_word(a, "CollectionType") == "temporal") {
                all_.emplace_back();
                series_ = depth_;
            }
        } else if (name == "Attribute" && step_ > 0 && all_.back().times.size() == 1) {
            if (const char* field = a.find("Name")) all_.back().fields.emplace_back(field);
        } else if (name == "Time" && step_ > 0 && depth_ == step_ + 1) {
            return own_time(a);
        } else if (name == "Time" && step_ == 0 && series_ > 0 && depth_ == series_ + 1) {
            listed_ = depth_;
            all_.back().kind = xdmf_word(a, "TimeType", "Type");
        } else if (name == "DataItem" && listed_ > 0 && depth_ == listed_ + 1) {
            item_ = is_text(xdmf_word(a, "Format")) ? depth_ : 0;
        }
        return {};
    }
    void end(std::string_view) override {
        for (int* at : {&step_, &series_, &listed_, &item_}) {
            if (*at == depth_) *at = 0;
        }
        --depth_;
    }
    bool wants_text() const override { return true; }
    bool allows_document_type() const override { return true; }
    void text(std::string_view piece) override {
        if (item_ > 0 && item_ == depth_) all_.back().list += piece;
    }

    const std::vector<Series>& all() const { return all_; }

  private:
    static bool is_text(const std::string& format) { return format.empty() || format == "xml"; }
    Complaint own_time(const XmlAttributes& a) {
        const char* const value = a.find("Value");
        double time = 0;
        if (value == nullptr) return {};
        if (!scan_number(value, &time).empty())
            return {fmt::format(messages::kTimeNotNumber, value)};
        all_.back().times.back() = time;
        return {};
    }

    int depth_ = 0;
    int series_ = 0, step_ = 0, listed_ = 0, item_ = 0;  ///< depth of the element; 0: in none
    std::vector<Series> all_;
};

/// Returns the index of the series that has the field.
Result<size_t> series_of(const std::vector<Series>& all, const std::string& field) {
    if (all.size() == 1) return size_t{0};
    std::vector<std::string> names;
    for (size_t i = 0; i < all.size(); ++i) {
        for (const std::string& name : all[i].fields) {
            if (name == field && !field.empty()) return i;
            if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
        }
    }
    const std::string shown = fmt::format("`{}`", fmt::join(names, "`, `"));
    return user_error(field.empty() ? fmt::format(messages::kSeveralSeries, shown)
                                    : fmt::format(messages::kNoSeriesOfField, field, shown));
}

/// Returns the index of the step of a time.
Result<int> step_at(const Series& series, double time) {
    const Result<std::vector<double>> times = series.each_time();
    if (!times) return times.error();
    double most = 0;
    for (const double t : *times)
        most = std::max(most, std::abs(t));
    constexpr double kNear = 1e-6;  // solvers add up steps, and writers round them
    for (size_t i = 0; i < times->size(); ++i) {
        if (std::abs((*times)[i] - time) <= kNear * most) return static_cast<int>(i);
    }
    constexpr size_t kShown = 8;
    const std::vector<double> first(
        times->begin(),
        times->begin() + static_cast<std::ptrdiff_t>(std::min(kShown, times->size())));
    std::string shown = fmt::format("{:g}", fmt::join(first, ", "));
    if (times->size() > kShown) shown += fmt::format(", ..., {:g}", times->back());
    return user_error(fmt::format(messages::kNoStepAtTime, times->size(), time, shown));
}

}  // namespace

std::string xdmf_word(const XmlAttributes& attributes, std::string_view name,
                      std::string_view other) {
    const char* value = attributes.find(name);
    if (value == nullptr && !other.empty()) value = attributes.find(other);
    return value == nullptr ? std::string() : lower_ascii(std::string(value));
}

Result<XdmfStep> find_xdmf_step(std::string_view text, std::optional<double> time,
                                const std::string& field) {
    Steps steps;
    if (Result<void> parsed = parse_xml(text, {}, &steps); !parsed) return parsed.error();
    const bool has_steps = std::any_of(steps.all().begin(), steps.all().end(),
                                       [](const Series& s) { return !s.times.empty(); });
    if (!has_steps) {
        if (time) return user_error(messages::kNoSteps, messages::kNoStepsHelp);
        return XdmfStep{};
    }
    const Result<size_t> series = series_of(steps.all(), field);
    if (!series) return series.error();
    XdmfStep out{static_cast<int>(*series), 0};
    if (!time) return out;
    const Result<int> step = step_at(steps.all()[*series], *time);
    if (!step) return step.error();
    out.step = *step;
    return out;
}

}  // namespace openfab::texture
