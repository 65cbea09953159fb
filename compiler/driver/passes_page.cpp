// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "compiler/driver/passes_page.h"

#include <fmt/format.h>

#include <algorithm>

#include "base/check.h"
#include "base/json_text.h"
#include "compiler/driver/passes_page_html.h"
#include "compiler/ir/text.h"
#include "compiler/passes/pipeline.h"

namespace openfab::driver {

namespace {

/// The name of the uniform that has a value.
std::string uniform_name(const ir::Fablet& fablet, int32_t value) {
    for (const ir::Uniform& uniform : fablet.uniforms) {
        const bool has_values =
            uniform.kind == OPENFAB_UNIFORM_VALUE || uniform.kind == OPENFAB_UNIFORM_CURVE;
        const int32_t last = uniform.first_index + uniform.components * uniform.array_length;
        if (has_values && value >= uniform.first_index && value < last) return " " + uniform.name;
    }
    return "";
}

}  // namespace

PassesPage::PassesPage(const ir::Fablet& fablet, const source::SourceManager& sources)
    : fablet_(fablet), sources_(sources) {}

int32_t PassesPage::source_of(uint32_t file) {
    if (file == 0) return -1;
    const auto at = std::ranges::find(files_, file);
    const auto number = static_cast<int32_t>(at - files_.begin());
    if (at == files_.end()) files_.push_back(file);
    return number;
}

int32_t PassesPage::value_of(const ir::Instr& instr, const std::vector<int32_t>& before) {
    Value value;
    value.text = ir::instr_text(instr);
    if (instr.op == ir::Op::kInput && instr.kind == OPENFAB_ARG_UNIFORM)
        value.text += uniform_name(fablet_, instr.a);
    std::string key = value.text;
    for (const ir::ValueId arg : instr.args) {
        value.args.push_back(before[arg]);
        key += fmt::format(" {}", before[arg]);
    }
    const auto [known, added] =
        by_text_.try_emplace(std::move(key), static_cast<int32_t>(values_.size()));
    if (!added) return known->second;
    value.source = source_of(instr.span.file);
    if (value.source >= 0) {
        value.line = static_cast<int32_t>(sources_.locate(instr.span.file, instr.span.begin).line);
    }
    values_.push_back(std::move(value));
    return known->second;
}

PassesPage::Step PassesPage::step_of(const std::string& pass, const ir::Stage& stage,
                                     const std::string& reason) {
    Step step{pass, reason, {}, {}};
    for (const ir::Instr& instr : stage.instrs)
        step.values.push_back(value_of(instr, step.values));
    for (const ir::Output& output : stage.outputs) {
        const char* const kind = ir::kind_name(output.kind);
        step.outputs.emplace_back(fmt::format("{} {} {} {}", output.name,
                                              kind == nullptr ? "" : kind, output.a, output.b),
                                  step.values[output.value]);
    }
    return step;
}

PassesPage::Track& PassesPage::track_of(const ir::Stage& stage) {
    const auto [known, added] = by_stage_.try_emplace(&stage, tracks_.size());
    if (!added) return tracks_[known->second];
    std::string name = ir::stage_name(stage.kind);
    const auto like = std::ranges::count(tracks_, stage.kind, &Track::kind);
    if (like > 0) name += fmt::format(" {}", like + 1);
    tracks_.push_back({stage.kind, std::move(name), {}});
    if (like > 0) return tracks_.back();
    // As the front end made it.
    const ir::Stage* given = nullptr;
    if (stage.kind == ir::StageKind::kVolume) given = &fablet_.volume;
    if (stage.kind == ir::StageKind::kSurface) given = &fablet_.surface;
    if (stage.kind == ir::StageKind::kDither) given = &fablet_.dither;
    if (given != nullptr) tracks_.back().steps.push_back(step_of("frontend", *given, ""));
    return tracks_.back();
}

void PassesPage::add(const std::string& pass, const ir::Stage& stage, const std::string& reason) {
    Track& track = track_of(stage);
    Step step = step_of(pass, stage, reason);
    const bool same = !track.steps.empty() && track.steps.back().values == step.values &&
                      track.steps.back().outputs == step.outputs;
    if (same && reason.empty()) return;
    if (track.steps.empty() && step.values.empty() && reason.empty()) return;
    track.steps.push_back(std::move(step));
}

std::string PassesPage::html() const {
    JsonText out;
    out.begin_object().member("fablet", fablet_.name);
    out.key("passes").begin_array();
    for (const passes::PassName& pass : passes::pass_names()) {
        out.begin_object().member("name", pass.name).member("why", pass.why);
        out.member("optional", pass.optional).end_object();
    }
    out.end_array().key("sources").begin_array();
    for (const uint32_t file : files_) {
        out.begin_object().member("name", std::string(sources_.name(file)));
        out.member("text", std::string(sources_.text(file))).end_object();
    }
    out.end_array().key("values").begin_array();
    for (const Value& value : values_) {
        out.begin_array().value(value.text).begin_array();
        for (const int32_t arg : value.args)
            out.value(arg);
        out.end_array().value(value.source).value(value.line).end_array();
    }
    out.end_array().key("stages").begin_array();
    for (const Track& track : tracks_) {
        if (track.steps.empty()) continue;
        out.begin_object().member("name", track.name).key("steps").begin_array();
        for (const Step& step : track.steps) {
            out.begin_object().member("pass", step.pass).member("reason", step.reason);
            out.key("values").begin_array();
            for (const int32_t value : step.values)
                out.value(value);
            out.end_array().key("outputs").begin_array();
            for (const auto& [name, value] : step.outputs)
                out.begin_array().value(name).value(value).end_array();
            out.end_array().end_object();
        }
        out.end_array().end_object();
    }
    out.end_array().end_object();
    // Text of the page cannot end the element that holds it.
    std::string data = out.take();
    for (size_t at = 0; (at = data.find("</", at)) != std::string::npos; at += 3)
        data.replace(at, 2, "<\\/");
    std::string page(kPassesPage[0].text);
    constexpr std::string_view kPlace = "@DATA@";
    const size_t place = page.find(kPlace);
    OPENFAB_CHECK(place != std::string::npos);
    return page.replace(place, kPlace.size(), data);
}

}  // namespace openfab::driver
