// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/prober.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "base/input_file.h"
#include "base/json.h"
#include "base/json_text.h"
#include "base/talking_program.h"
#include "client/child.h"
#include "tools/viewer/messages.h"

namespace openfab::viewer {

namespace {

constexpr int64_t kMostOutput = 1 << 20;

/// Exact to the last bit.
std::string triple(const Vec3d& v) {
    return fmt::format("{:.17g},{:.17g},{:.17g}", v.x, v.y, v.z);
}

/// Returns what a print was made of that its world has changed since, or an empty text. How it was
/// dithered and supported has no effect on fractions.
std::string what_changed(const pipeline::PrintInfo& info, const JsonValue& provenance) {
    constexpr std::array<std::string_view, 2> kNoMatter{"dither", "support"};
    for (const auto& [name, value] : info.provenance) {
        if (std::find(kNoMatter.begin(), kNoMatter.end(), name) != kNoMatter.end()) continue;
        const JsonValue* now = member_of(provenance, name);
        if (now == nullptr || now->text != value) return name;
    }
    return {};
}

}  // namespace

Result<std::vector<double>> Prober::fractions(const ProbedWorld& world,
                                              const pipeline::PrintInfo& info,
                                              const Vec3d& point_mm) {
    if (info.provenance.empty()) return user_error(messages::kSourcesNotKnown);
    std::vector<std::string> argv{(programs_ / "openfab").string(),
                                  "print",
                                  as_argument(world.file),
                                  "--probe=" + triple(point_mm),
                                  "--pitch=" + triple(info.pitch_mm),
                                  "--progress=none"};
    if (!world.fablet.empty()) argv.push_back("--fablet=" + world.fablet);
    for (const std::string& folder : world.allow)
        argv.push_back(allow_argument(folder));
    for (const std::string& setting : world.settings)
        argv.push_back("--set=" + setting);
    const std::lock_guard lock(mutex_);
    const std::filesystem::path out = scratch_ / "probe.out", err = scratch_ / "probe.err";
    for (const std::string& word : client::memory_words())
        argv.push_back(word);
    Result<std::unique_ptr<client::Child>> child = client::Child::start(argv, out, err);
    if (!child) return child.error();
    if ((*child)->wait() != 0) {
        const std::string text = client::end_of_file(err, kMostOutput);
        return user_error(text.empty() ? messages::kProbeFailed : text);
    }
    const Result<JsonValue> json =
        parse_json(client::end_of_file(out, kMostOutput), "openfab print");
    if (!json) return json.error();
    const JsonValue* provenance = member_of(*json, "provenance");
    const JsonValue* fractions = member_of(*json, "fractions");
    if (provenance == nullptr || fractions == nullptr)
        return internal_error(messages::kProbeWithoutFractions);
    if (const std::string changed = what_changed(info, *provenance); !changed.empty())
        return user_error(fmt::format(messages::kWorldChanged, changed));
    std::vector<double> out_fractions;
    for (const pipeline::SliceMaterial& material : info.materials) {
        const JsonValue* fraction = member_of(*fractions, material.name);
        out_fractions.push_back(fraction == nullptr ? 0 : fraction->number);
    }
    return out_fractions;
}

}  // namespace openfab::viewer
