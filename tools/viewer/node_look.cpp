// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/node_look.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <string_view>
#include <utility>

#include "base/input_file.h"
#include "base/json_text.h"
#include "base/own_folder.h"
#include "tools/viewer/child.h"
#include "tools/viewer/fablets.h"

namespace openfab::viewer {

namespace {

namespace fs = std::filesystem;

constexpr int kSide = 44;  ///< pixels of the longer side
constexpr int kMostLines = 40'000;
constexpr int64_t kMostOutput = 256 << 20;
constexpr int64_t kMostWords = 4000;

std::string triple(const Vec3d& v) {
    return fmt::format("{:.17g},{:.17g},{:.17g}", v.x, v.y, v.z);
}

int32_t number_of(const JsonValue& json, const char* name) {
    const JsonValue* found = member_of(json, name);
    return found == nullptr ? 0 : static_cast<int32_t>(found->number);
}

std::string text_of(const JsonValue& json, const char* name) {
    const JsonValue* found = member_of(json, name);
    return found == nullptr ? std::string() : found->text;
}

struct Value {
    std::string type;
    size_t numbers = 1;
    std::map<size_t, std::vector<float>> at;  ///< by place
};

/// Lines of printf, read in their order: those of one voxel follow each other, its place first.
class Lines {
  public:
    explicit Lines(const JsonValue& printed) : has_places_(is_true(printed, "places")) {
        const JsonValue* values = member_of(printed, "values");
        if (values == nullptr) return;
        for (const JsonValue& one : values->items)
            values_[number_of(one, "node")] = {
                text_of(one, "type"), static_cast<size_t>(number_of(one, "numbers")), {}};
    }

    void read(std::string_view text) {
        for (size_t from = 0; from < text.size();) {
            const size_t to = std::min(text.find('\n', from), text.size());
            line(text.substr(from, to - from));
            from = to + 1;
        }
    }

    const std::vector<Vec3d>& places() const { return places_; }
    const std::map<int32_t, Value>& values() const { return values_; }

  private:
    static bool is_true(const JsonValue& json, const char* name) {
        const JsonValue* found = member_of(json, name);
        return found != nullptr && found->is(JsonValue::Kind::kBool) && found->boolean;
    }

    static std::vector<float> numbers(std::string_view text) {
        std::vector<float> out;
        while (!text.empty()) {
            const size_t end = std::min(text.find_first_of(", "), text.size());
            const std::string_view word = text.substr(0, end);
            if (!word.empty()) {
                float value = std::numeric_limits<float>::quiet_NaN();
                if (std::from_chars(word.data(), word.data() + word.size(), value).ec ==
                    std::errc::result_out_of_range)
                    value = 0;
                out.push_back(value);
            }
            text.remove_prefix(std::min(end + 1, text.size()));
        }
        return out;
    }

    /// `ball.fl:7: at (1, 2, 3) mm: =4 0.5`
    void line(std::string_view line) {
        constexpr std::string_view kAt = ": at (";
        constexpr std::string_view kMm = ") mm: ";
        const size_t at = line.find(kAt);
        if (at == std::string_view::npos) return;
        const size_t mm = line.find(kMm, at);
        if (mm == std::string_view::npos || mm + kMm.size() >= line.size()) return;
        const std::string_view point = line.substr(at + kAt.size(), mm - at - kAt.size());
        const std::string_view rest = line.substr(mm + kMm.size());
        const std::vector<float> read = numbers(rest.substr(1));
        if (rest[0] == '@' && read.size() == 4) {
            point_ = point;
            places_.push_back({read[1], read[2], read[3]});
        } else if (rest[0] == '=' && !read.empty()) {
            if (!has_places_ && point != point_) {
                point_ = point;
                const std::vector<float> p = numbers(point);
                if (p.size() == 3) places_.push_back({p[0], p[1], p[2]});
            }
            const auto found = values_.find(static_cast<int32_t>(read[0]));
            if (found == values_.end() || read.size() != found->second.numbers + 1 ||
                places_.empty())
                return;
            found->second.at[places_.size() - 1].assign(read.begin() + 1, read.end());
        }
    }

    bool has_places_;
    std::string point_;
    std::vector<Vec3d> places_;
    std::map<int32_t, Value> values_;
};

/// Where places stand in a picture: those of a slice from above, those of a surface from the front right, above.
class Picture {
  public:
    Picture(const std::vector<Vec3d>& places, double pixel_mm, bool is_surface) {
        for (const Vec3d& p : places) {
            if (is_surface) {
                const double kHalf = std::sqrt(0.5);
                const double back = (p.y - p.x) * kHalf;
                projected_.push_back(
                    {(p.x + p.y) * kHalf, 0.8 * p.z + 0.6 * back, 0.8 * back - 0.6 * p.z});
            } else {
                projected_.push_back({p.x, p.y, 0});
            }
        }
        if (projected_.empty()) return;
        Vec3d low = projected_[0];
        Vec3d high = low;
        for (const Vec3d& p : projected_) {
            low = {std::min(low.x, p.x), std::min(low.y, p.y), 0};
            high = {std::max(high.x, p.x), std::max(high.y, p.y), 0};
        }
        // A pitch that is not that of the places must not make a picture without end.
        pixel_mm =
            std::max({pixel_mm, (high.x - low.x) / (2 * kSide), (high.y - low.y) / (2 * kSide)});
        width = static_cast<int>((high.x - low.x) / pixel_mm + 0.5) + 1;
        height = static_cast<int>((high.y - low.y) / pixel_mm + 0.5) + 1;
        nearest.assign(static_cast<size_t>(width) * static_cast<size_t>(height), -1);
        for (size_t i = 0; i < projected_.size(); ++i) {
            const auto x = static_cast<int>((projected_[i].x - low.x) / pixel_mm + 0.5);
            const auto y = static_cast<int>((high.y - projected_[i].y) / pixel_mm + 0.5);
            int64_t& there = nearest[static_cast<size_t>(std::clamp(y, 0, height - 1) * width +
                                                         std::clamp(x, 0, width - 1))];
            if (there < 0 || projected_[static_cast<size_t>(there)].z > projected_[i].z)
                there = static_cast<int64_t>(i);
        }
    }

    int width = 0, height = 0;
    std::vector<int64_t> nearest;  ///< the place in each pixel; -1: none

  private:
    std::vector<Vec3d> projected_;  ///< right, up, away
};

void write_picture(const Value& value, const Picture& picture, JsonText* out) {
    float low = std::numeric_limits<float>::infinity();
    float high = -low;
    const auto values_in = [&](int64_t place) -> const std::vector<float>* {
        if (place < 0) return nullptr;
        const auto found = value.at.find(static_cast<size_t>(place));
        return found == value.at.end() ? nullptr : &found->second;
    };
    for (const int64_t place : picture.nearest) {
        const std::vector<float>* numbers = values_in(place);
        if (numbers == nullptr) continue;
        for (const float v : *numbers) {
            if (!std::isfinite(v)) continue;
            low = std::min(low, v);
            high = std::max(high, v);
        }
    }
    const bool any = high >= low;
    if (any) out->member("low", double{low}).member("high", double{high});
    if (value.type == "MaterialComposition") {
        low = 0;
        high = 1;
    }
    // Halves of each, since the range of floats is larger than a float. What is the same everywhere is grey.
    const double range = high > low ? 0.5 * high - 0.5 * low : 0;
    out->key("values").begin_array();
    for (const int64_t place : picture.nearest) {
        const std::vector<float>* numbers = values_in(place);
        for (size_t c = 0; c < value.numbers; ++c) {
            const float v = numbers == nullptr ? 0 : (*numbers)[c];
            const bool shown = any && numbers != nullptr && std::isfinite(v);
            const double share =
                range > 0 ? std::clamp((0.5 * v - 0.5 * low) / range, 0.0, 1.0) : 0.5;
            out->value(shown ? static_cast<int32_t>(std::lround(255 * share)) : -1);
        }
    }
    out->end_array();
}

void write_voxel(const Value& value, JsonText* out) {
    out->key("values").begin_array();
    for (const float v : value.at.rbegin()->second) {
        if (std::isfinite(v)) {
            out->value(double{v});
        } else {
            out->value(std::isnan(v) ? "nan" : v > 0 ? "inf" : "-inf");
        }
    }
    out->end_array();
}

}  // namespace

Result<std::string> NodeLooker::look(const Look& of, const JsonValue& printed) {
    const std::lock_guard lock(mutex_);
    const Result<std::unique_ptr<TemporaryFolder>> folder = TemporaryFolder::create(scratch_);
    if (!folder) return folder.error();
    const Result<fs::path> source =
        put_source((*folder)->path(), of.source, text_of(printed, "text"));
    if (!source) return source.error();
    std::vector<std::string> argv{(programs_ / "openflc").string(), "run", "--prints",
                                  fmt::format("--print-lines={}", kMostLines)};
    for (const fs::path& one : of.sources)
        argv.push_back(as_argument(one == of.source ? *source : one));
    argv.push_back(as_argument(fs::absolute(of.world)));
    argv.emplace_back("--progress=none");
    const Vec3d size_mm{of.print.size.x * of.print.pitch_mm.x,
                        of.print.size.y * of.print.pitch_mm.y,
                        of.print.size.z * of.print.pitch_mm.z};
    const double pixel_mm = std::max({size_mm.x, size_mm.y, of.is_surface ? size_mm.z : 0}) / kSide;
    if (of.point_mm) {
        argv.push_back("--probe=" + triple(*of.point_mm));
        argv.push_back("--pitch=" + triple(of.print.pitch_mm));
    } else {
        const double tall = of.is_surface ? pixel_mm : of.print.pitch_mm.z;
        argv.push_back("--pitch=" + triple({pixel_mm, pixel_mm, tall}));
        argv.push_back(of.is_surface ? "--slices=0:1"
                                     : fmt::format("--slices={}:{}", of.slice, of.slice + 1));
        argv.push_back("--output=" + ((*folder)->path() / "look.ofr").string());
    }
    for (const std::string& one : of.allow)
        argv.push_back("--allow=" + one);
    for (const std::string& setting : of.settings)
        argv.push_back("--set=" + setting);
    const fs::path out = (*folder)->path() / "look.out";
    const fs::path err = (*folder)->path() / "look.err";
    Result<std::unique_ptr<Child>> child = Child::start(argv, out, err);
    if (!child) return child.error();
    if ((*child)->wait() != 0) {
        const std::string words = end_of_file(err, kMostWords);
        const size_t error = words.find("error: ");
        return user_error(words.empty() ? "openflc run failed"
                                        : words.substr(error == std::string::npos ? 0 : error));
    }
    Lines lines(printed);
    lines.read(end_of_file(err, kMostOutput));
    const Picture picture(lines.places(), pixel_mm, of.is_surface);
    JsonText json;
    json.begin_object();
    if (!of.point_mm) {
        json.member("width", picture.width).member("height", picture.height);
        json.member("pixel_mm", pixel_mm).key("inside").begin_array();
        for (const int64_t place : picture.nearest)
            json.value(place >= 0 ? 1 : 0);
        json.end_array().key("materials");
        const JsonValue* materials = member_of(printed, "materials");
        materials == nullptr ? json.begin_array().end_array() : json.value(*materials);
    }
    json.key("nodes").begin_array();
    for (const auto& [node, value] : lines.values()) {
        if (value.at.empty()) continue;
        json.begin_object().member("node", node).member("type", value.type);
        json.member("numbers", static_cast<int64_t>(value.numbers));
        of.point_mm ? write_voxel(value, &json) : write_picture(value, picture, &json);
        json.end_object();
    }
    json.end_array().end_object();
    return json.take();
}

}  // namespace openfab::viewer
