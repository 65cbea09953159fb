// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/graph/picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <map>
#include <optional>

#include "abi/fablet_table.h"
#include "compiler/frontend/frontend.h"
#include "compiler/interp/evaluate.h"

namespace openfab::graph {

namespace {

constexpr int kSide = 32;
constexpr float kSize_mm = 24;
/// Above the middle: lattices have planes of symmetry at z = 0, in which they look like less than they are.
constexpr float kHeight_mm = 0.8F;
constexpr auto kLongest = std::chrono::milliseconds(300);

struct Picture {
    int side = kSide, channels = 1;
    std::vector<int32_t> values;
};

/// A place, as the three floats of the only uniform that is read.
class Place : public interp::Environment {
  public:
    std::array<float, 3> at{};
    uint32_t input(int32_t kind, int32_t a, int32_t) const override {
        return kind == OPENFAB_ARG_UNIFORM && a >= 0 && a < 3
                   ? std::bit_cast<uint32_t>(at[static_cast<size_t>(a)])
                   : 0;
    }
    interp::TextureView texture(int32_t) const override { return {}; }
};

/// A call of a built-in function that shows something; empty if there is none.
std::string call_of(const Entry& entry) {
    if (!entry.call.empty()) return entry.call;
    if (entry.kind != Entry::Kind::kBuiltIn) return {};
    for (const char* name : {"noise", "simplex", "cellular", "hash"}) {
        if (entry.name == name)
            return entry.name == "hash" ? "hash(floor(p / 2))" : entry.name + "(p / 4)";
    }
    if (entry.name == "fbm" || entry.name == "turbulence") return entry.name + "(p / 6, 4)";
    if (entry.name == "curl") return "length(curl(p / 6))";
    const bool curve = entry.parameters.size() == 1 && entry.parameters[0].type == "floatN" &&
                       entry.result == "floatN" && !entry.name.starts_with("dd") &&
                       entry.name != "fwidth";
    if (curve) return entry.name + "(p.x / 3)";
    if (entry.name == "smoothstep") return "smoothstep(-6, 6, p.x)";
    if (entry.name == "step") return "step(0, p.x)";
    if (entry.name == "length") return "length(p.xy)";
    return {};
}

std::optional<Picture> drawn(const Entry& entry) {
    const std::string call = call_of(entry);
    const std::string result = entry.result == "floatN" ? "float" : entry.result;
    const bool scalar =
        result == "float" || result == "int" || result == "bool" || result == "uint";
    if (call.empty() || (!scalar && result != "float3")) return std::nullopt;
    Picture out;
    out.channels = scalar ? 1 : 3;
    std::string text = entry.module.empty() ? "" : "import " + entry.module + ";\n";
    text += fmt::format(
        "fablet Shown {{ @uniform {{ float3 p; Material a, b, c; }}\n{} shown() {{ float t = "
        "saturate(p.x / {} + 0.5);\n"
        "float d = length(p) - 8; float3 unit = saturate(p / {} + 0.5); return {}; }}\n"
        "@Volume() {{ MaterialComposition mc; {} v = shown(); ",
        result, kSize_mm, kSize_mm, call, result);
    text += scalar ? "mc.Set(a, v); return mc; } }"
                   : "mc.Set(a, v.x); mc.Set(b, v.y); mc.Set(c, v.z); return mc; } }";
    source::SourceManager sources;
    diag::Sink sink;
    const auto module = frontend::compile_to_ir(sources, sources.add("picture", text), sink);
    if (!module || module->fablets.empty()) return std::nullopt;
    const ir::Stage& stage = module->fablets[0].volume;
    std::vector<float> values;
    Place place;
    const auto begin = std::chrono::steady_clock::now();
    for (int y = 0; y < out.side; ++y) {
        for (int x = 0; x < out.side; ++x) {
            const auto side = static_cast<float>(out.side);
            place.at = {((static_cast<float>(x) + 0.5F) / side - 0.5F) * kSize_mm,
                        (0.5F - (static_cast<float>(y) + 0.5F) / side) * kSize_mm, kHeight_mm};
            const std::vector<uint32_t> bits = interp::evaluate(stage, place);
            for (int c = 0; c < out.channels; ++c)
                values.push_back(std::bit_cast<float>(bits.at(static_cast<size_t>(c))));
        }
        const auto spent = std::chrono::steady_clock::now() - begin;
        if (out.side == kSide && spent * (kSide / (y + 1)) > kLongest) {
            // Coarse, but at once.
            out.side = kSide / 4;
            values.clear();
            y = -1;
        }
    }
    float low = INFINITY;
    float high = -INFINITY;
    for (const float v : values) {
        if (!std::isfinite(v)) continue;
        low = std::min(low, v);
        high = std::max(high, v);
    }
    if (!(high >= low)) return std::nullopt;
    const float range = high > low ? high - low : 1;
    for (const float v : values)
        out.values.push_back(std::isfinite(v) ? static_cast<int32_t>(255 * (v - low) / range) : 0);
    return out;
}

}  // namespace

Result<void> write_picture(const std::string& signature, const std::string& module, JsonText* out) {
    static std::map<std::string, std::optional<Picture>> known;
    static const server::Analysis nothing({}, "", {});
    static const std::vector<Entry> entries = entries_of(nothing);
    const std::string key = module + "/" + signature;
    const auto entry = std::find_if(entries.begin(), entries.end(), [&](const Entry& one) {
        return one.signature == signature && one.module == module;
    });
    if (entry == entries.end()) return user_error("there is no such function");
    if (!known.contains(key)) known[key] = drawn(*entry);
    const std::optional<Picture>& picture = known[key];
    out->begin_object();
    if (picture) {
        out->member("side", picture->side).member("channels", picture->channels);
        out->key("values").begin_array();
        for (const int32_t v : picture->values)
            out->value(v);
        out->end_array();
    }
    out->end_object();
    return {};
}

}  // namespace openfab::graph
