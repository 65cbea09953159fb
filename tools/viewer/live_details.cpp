// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "tools/viewer/live.h"
#include "tools/viewer/source_text.h"
#include "tools/viewer/uniform_value.h"

namespace openfab::viewer {

namespace {

void describe_uniform(const world::Object& object, const JsonValue& uniform,
                      const SetValues::List& values, JsonText* out) {
    const JsonValue* name = member_of(uniform, "name");
    if (name == nullptr) return;
    out->begin_object();
    for (const JsonMember& member : uniform.members)
        out->key(member.key).value(member.value);
    const SetValue* set = values.find(object.name, name->text);
    const auto bound = object.uniforms.find(name->text);
    if (set != nullptr && !set->trouble.empty()) out->member("trouble", set->trouble);
    out->member("changed", set != nullptr).key("value");
    if (set != nullptr) {
        write_override(set->value, out);
    } else if (bound != object.uniforms.end()) {
        write_binding(bound->second, out);
    } else {
        out->null();
    }
    out->end_object();
}

void describe_object(const WorldReading& reading, const world::Object& object,
                     const SetValues::List& values, JsonText* out) {
    out->begin_object().member("name", object.name).member("fablet", object.fablet);
    if (const auto ref = reading.world->fablets.find(object.fablet);
        ref != reading.world->fablets.end()) {
        // The number of its text, and its name there.
        const auto source =
            std::find(reading.sources.begin(), reading.sources.end(), ref->second.source);
        out->member("source", static_cast<int64_t>(source - reading.sources.begin()));
        out->member("fablet_name", ref->second.fablet);
    }
    out->key("uniforms").begin_array();
    if (const JsonValue* uniforms = reading.uniforms_of(object.fablet)) {
        for (const JsonValue& uniform : uniforms->items)
            describe_uniform(object, uniform, values, out);
    }
    out->end_array().end_object();
}

/// Writes what a world has, if there is one.
void describe_world(const WorldReading& reading, const std::string& file,
                    const SetValues::List& values, JsonText* out) {
    static const world::World nothing;
    const world::World& world = reading.world == nullptr ? nothing : *reading.world;
    out->key("objects").begin_array();
    for (const world::Object& object : world.objects)
        describe_object(reading, object, values, out);
    out->end_array().key("part");
    const Result<std::string> text = read_source(file);
    describe_part(text ? *text : "{}", reading.world.get(), out);
    out->key("materials").begin_array();
    for (const world::Material& material : world.materials)
        out->value(material.name);
    out->end_array().key("textures").begin_array();
    for (const world::Texture& texture : world.textures)
        out->value(texture.name);
    out->end_array().key("fablets").begin_array();
    for (const std::filesystem::path& source : reading.sources) {
        const Result<std::string> fablet = read_source(source, reading.roots);
        out->begin_object().member("file", source.filename().string());
        out->member("stamp", fablet ? stamp_of(*fablet) : std::string()).end_object();
    }
    out->end_array();
}

}  // namespace

void Live::describe(JsonText* out) const {
    constexpr const char* kNames[] = {"checking", "printing", "done", "failed"};
    const ChangeSignal::Counts counts = signal_.counts();
    const SetValues::List values = values_.list();
    const DraftPrint::State draft = draft_.state();
    const DraftPrint::Phase phase = counts.asked ? DraftPrint::Phase::kChecking : draft.phase;
    out->begin_object().member("watch", options_.watch);
    out->member("phase", kNames[static_cast<size_t>(phase)]).member("message", draft.message);
    out->member("slices_done", draft.slices_done).member("slices_total", draft.slices_total);
    out->member("print", draft.done_number)
        .member("mvoxels_per_second", draft.mvoxels_per_second)
        .member("writable", !values.values.empty() && has_taken(draft, values, counts))
        .member("change", counts.change)
        .member("draft", draft.draft)
        .member("printed_draft", draft.printed_draft)
        .member("shows_full", view_.shows_full())
        .member("version", counts.details)
        .key("full_print");
    full_print_.describe(out);
    out->end_object();
}

std::string Live::details() const {
    const ChangeSignal::Counts counts = signal_.counts();
    const std::shared_ptr<const WorldReading> reading = world_.now();
    const SetValues::List values = values_.list();
    const DraftPrint::State draft = draft_.state();
    JsonText out;
    out.begin_object().member("version", counts.details).member("draft", draft.draft);
    out.member("changed", static_cast<int64_t>(values.values.size()));
    out.member("message", draft.other_message);
    describe_world(*reading, options_.file, values, &out);
    out.key("templates").begin_array();
    for (const std::string& name : options_.templates)
        out.value(name);
    out.end_array().key("diagnostics");
    write_diagnostics(reading->diagnostics, reading->sources, &out);
    out.end_object();
    return out.take();
}

}  // namespace openfab::viewer
