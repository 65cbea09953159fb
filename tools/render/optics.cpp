// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/render/optics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string_view>

#include "backends/preview/picture.h"
#include "base/check.h"
#include "base/color.h"
#include "base/json.h"
#include "tools/render/half_space.h"
#include "tools/render/messages.h"
#include "tools/render/polyjet_optics.h"

namespace openfab::render {

namespace {

constexpr double kMostExtinction = 1e4;  ///< per mm: a mean free path of 0.1 um

std::string lower(std::string_view text) {
    std::string out(text);
    std::transform(out.begin(), out.end(), out.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return out;
}

/// Reads one file; the first error counts.
class Reader {
  public:
    explicit Reader(const std::string& name) : name_(name) {}

    Result<OpticsTable> read(const JsonValue& root) {
        OpticsTable table = builtin_surface();
        if (!root.is(JsonValue::Kind::kObject))
            fail(root.line, root.column, messages::kFileMustHoldObject);
        const JsonMember* const version = root.find("openfab_optics");
        if (version == nullptr || version->value.number != 1) {
            fail(root.line, root.column, messages::kNotOptics, messages::kNotOpticsHelp);
        }
        known(root, {"openfab_optics", "source", "surface", "materials"});
        if (const JsonMember* surface = root.find("surface")) read_surface(surface->value, &table);
        if (const JsonMember* materials = root.find("materials"))
            read_materials(materials->value, &table);
        if (failed_) return error_;
        return table;
    }

  private:
    static OpticsTable builtin_surface() { return {{1.5, 0}, {}}; }

    void fail(int32_t line, int32_t column, std::string what, std::string help = {}) {
        if (failed_) return;
        failed_ = true;
        error_ = error_at({name_, line, column}, std::move(what), std::move(help));
    }
    void fail(const JsonValue& at, std::string what, std::string help = {}) {
        fail(at.line, at.column, std::move(what), std::move(help));
    }
    void known(const JsonValue& object, const std::vector<std::string>& keys) {
        for (const JsonMember& member : object.members) {
            if (std::find(keys.begin(), keys.end(), member.key) != keys.end()) continue;
            fail(member.line, member.column, fmt::format(messages::kUnknownKey, member.key),
                 fmt::format(messages::kKnownKeys, fmt::join(keys, ", ")));
        }
    }
    double number(const JsonValue& value, double least, double most, const char* what) {
        if (value.is(JsonValue::Kind::kNumber) && value.number >= least && value.number <= most)
            return value.number;
        fail(value, fmt::format(messages::kNumberBetween, what, least, most));
        return least;
    }
    /// A number for all channels, or three.
    Rgb channels(const JsonValue& object, const char* key, double most) {
        const JsonMember* const member = object.find(key);
        if (member == nullptr) {
            fail(object, fmt::format(messages::kKeyMissing, key));
            return {};
        }
        const JsonValue& value = member->value;
        const std::string what = fmt::format("`{}`", key);
        if (value.is(JsonValue::Kind::kNumber)) {
            const double all = number(value, 0, most, what.c_str());
            return {all, all, all};
        }
        if (!value.is(JsonValue::Kind::kArray) || value.items.size() != 3) {
            fail(value, fmt::format(messages::kNumberOrThree, key));
            return {};
        }
        Rgb out{};
        for (size_t c = 0; c < 3; ++c)
            out[c] = number(value.items[c], 0, most, what.c_str());
        return out;
    }
    void read_surface(const JsonValue& value, OpticsTable* table) {
        if (!value.is(JsonValue::Kind::kObject)) return fail(value, messages::kSurfaceIsObject);
        known(value, {"refractive_index", "roughness"});
        if (const JsonMember* index = value.find("refractive_index"))
            table->surface.refractive_index = number(index->value, 1, 3, "`refractive_index`");
        if (const JsonMember* roughness = value.find("roughness"))
            table->surface.roughness = number(roughness->value, 0, 1, "`roughness`");
    }
    void read_materials(const JsonValue& value, OpticsTable* table) {
        if (!value.is(JsonValue::Kind::kObject)) return fail(value, messages::kMaterialsIsObject);
        for (const JsonMember& member : value.members) {
            const JsonValue& m = member.value;
            if (!m.is(JsonValue::Kind::kObject))
                return fail(m, fmt::format(messages::kIsAnObject, member.key));
            known(m, {"source", "also", "extinction_per_mm", "albedo", "anisotropy"});
            OpticsTable::Entry entry;
            entry.names.push_back(member.key);
            if (const JsonMember* also = m.find("also")) {
                for (const JsonValue& name : also->value.items) {
                    if (!name.is(JsonValue::Kind::kString)) fail(name, messages::kAlsoIsAList);
                    entry.names.push_back(name.text);
                }
            }
            entry.optics.extinction = channels(m, "extinction_per_mm", kMostExtinction);
            entry.optics.albedo = channels(m, "albedo", 1);
            if (const JsonMember* g = m.find("anisotropy"))
                entry.optics.anisotropy = number(g->value, -0.99, 0.99, "`anisotropy`");
            table->entries.push_back(std::move(entry));
        }
    }

    std::string name_;
    bool failed_ = false;
    Error error_;
};

}  // namespace

const MaterialOptics* OpticsTable::find(const std::string& name) const {
    for (const Entry& entry : entries) {
        for (const std::string& known : entry.names) {
            if (lower(known) == lower(name)) return &entry.optics;
        }
    }
    return nullptr;
}

Result<OpticsTable> parse_optics(const std::string& text, const std::string& name) {
    constexpr int64_t kMostBytes = 64 << 20;
    Result<JsonValue> json = parse_json(text, name, kMostBytes);
    if (!json) return json.error();
    return Reader(name).read(*json);
}

const OpticsTable& builtin_optics() {
    static const OpticsTable table = [] {
        Result<OpticsTable> read =
            parse_optics(std::string(kOpticsFiles[0].text), std::string(kOpticsFiles[0].name));
        OPENFAB_CHECK(read.has_value());
        return std::move(*read);
    }();
    return table;
}

MaterialOptics guess_optics(const std::array<uint8_t, 4>& preview, const SurfaceOptics& surface) {
    MaterialOptics optics;
    // Opaque ones as dense as a white ink; clear ones as the model previews see them, s = a / (1 - a)
    // per mm (backends/preview/model_view.h).
    constexpr double kOpaquePerMm = 10;
    const double alpha = preview[3] / 255.0;
    const double strength = alpha < 1 ? std::min(kOpaquePerMm, alpha / (1 - alpha)) : kOpaquePerMm;
    for (size_t c = 0; c < 3; ++c) {
        optics.albedo[c] =
            albedo_of_look(srgb_to_linear(preview[c] / 255.0), surface.refractive_index);
        optics.extinction[c] = strength;
    }
    return optics;
}

Optics optics_of(const pipeline::PrintInfo& info, const OpticsTable* own) {
    Optics optics;
    const OpticsTable& builtin = builtin_optics();
    optics.surface = own != nullptr ? own->surface : builtin.surface;
    optics.by_code.emplace_back();
    for (const pipeline::SliceMaterial& material : info.materials) {
        const MaterialOptics* found = own != nullptr ? own->find(material.name) : nullptr;
        if (found == nullptr) found = builtin.find(material.name);
        optics.by_code.push_back(found != nullptr ? *found
                                                  : guess_optics(material.preview, optics.surface));
        const bool is_support =
            info.support_code == static_cast<int32_t>(optics.by_code.size()) - 1;
        if (found == nullptr && !is_support) optics.guessed.push_back(material.name);
    }
    return optics;
}

Optics optics_of_mixtures(const Optics& optics, const std::vector<uint8_t>& codes,
                          const std::vector<std::vector<uint8_t>>& mixtures) {
    Optics out{optics.surface, {}, optics.guessed};
    for (const std::vector<uint8_t>& parts : mixtures) {
        MaterialOptics mean;
        double all = 0;
        for (const uint8_t part : parts)
            all += part;
        Rgb scattering{};
        double forward = 0;
        for (size_t m = 0; m < parts.size(); ++m) {
            const MaterialOptics& one = optics.by_code[codes[m]];
            for (size_t c = 0; c < 3; ++c) {
                const double share = parts[m] / all * one.extinction[c];
                mean.extinction[c] += share;
                scattering[c] += share * one.albedo[c];
                forward += share * one.albedo[c] * one.anisotropy;
            }
        }
        for (size_t c = 0; c < 3; ++c)
            mean.albedo[c] = mean.extinction[c] > 0 ? scattering[c] / mean.extinction[c] : 0;
        const double scattered = scattering[0] + scattering[1] + scattering[2];
        mean.anisotropy = scattered > 0 ? forward / scattered : 0;
        out.by_code.push_back(mean);
    }
    return out;
}

}  // namespace openfab::render
