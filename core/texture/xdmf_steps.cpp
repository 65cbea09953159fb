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

/// Receives the elements.
class Steps final : public XmlHandler {
  public:
    Complaint start(std::string_view name, const XmlAttributes& a) override {
        ++depth_;
        if (name == "Grid") {
            if (series_ > 0 && depth_ == series_ + 1) {
                step_ = depth_;
                times_.emplace_back();
            } else if (step_ == 0 && xdmf_word(a, "GridType", "Type") == "collection" &&
                       xdmf_word(a, "CollectionType") == "temporal") {
                if (++count_ > 1) return {messages::kSeveralSeries};
                series_ = depth_;
            }
        } else if (name == "Time" && step_ > 0 && depth_ == step_ + 1) {
            return own_time(a);
        } else if (name == "Time" && step_ == 0 && series_ > 0 && depth_ == series_ + 1) {
            listed_ = depth_;
            kind_ = xdmf_word(a, "TimeType", "Type");
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
        if (item_ > 0 && item_ == depth_) list_ += piece;
    }

    Result<std::vector<double>> times() const {
        std::vector<double> listed;
        std::string_view left = list_;
        for (std::string_view word = take_word(&left); !word.empty(); word = take_word(&left)) {
            if (!scan_number(word, &listed.emplace_back()).empty())
                return user_error(messages::kTimesNotNumbers);
        }
        const bool is_range = kind_ == "hyperslab" && listed.size() == 3;  // start, step, count
        std::vector<double> out;
        for (size_t i = 0; i < times_.size(); ++i) {
            const auto number = static_cast<double>(i);
            out.push_back(times_[i]                              ? *times_[i]
                          : is_range                             ? listed[0] + listed[1] * number
                          : i < listed.size() && kind_ == "list" ? listed[i]
                                                                 : number);
        }
        return out;
    }

  private:
    static bool is_text(const std::string& format) { return format.empty() || format == "xml"; }
    Complaint own_time(const XmlAttributes& a) {
        const char* const value = a.find("Value");
        double time = 0;
        if (value == nullptr) return {};
        if (!scan_number(value, &time).empty())
            return {fmt::format(messages::kTimeNotNumber, value)};
        times_.back() = time;
        return {};
    }

    int depth_ = 0, count_ = 0;
    int series_ = 0, step_ = 0, listed_ = 0, item_ = 0;  ///< depth of the element; 0: in none
    std::vector<std::optional<double>> times_;
    std::string kind_, list_;
};

}  // namespace

std::string xdmf_word(const XmlAttributes& attributes, std::string_view name,
                      std::string_view other) {
    const char* value = attributes.find(name);
    if (value == nullptr && !other.empty()) value = attributes.find(other);
    return value == nullptr ? std::string() : lower_ascii(std::string(value));
}

Result<int> find_xdmf_step(std::string_view text, double time) {
    Steps steps;
    if (Result<void> parsed = parse_xml(text, {}, &steps); !parsed) return parsed.error();
    const Result<std::vector<double>> times = steps.times();
    if (!times) return times.error();
    if (times->empty()) return user_error(messages::kNoSteps, messages::kNoStepsHelp);
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

}  // namespace openfab::texture
