// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "tools/viewer/live.h"
#include "tools/viewer/source_text.h"
#include "tools/viewer/uniform_value.h"

namespace openfab::viewer {

void Live::describe(JsonText* out) const {
    constexpr const char* kNames[] = {"checking", "printing", "done", "failed"};
    const std::lock_guard lock(mutex_);
    out->begin_object().member("watch", options_.watch);
    const Phase phase = asked_ ? Phase::kChecking : phase_;
    out->member("phase", kNames[static_cast<size_t>(phase)]).member("message", message_);
    out->member("slices_done", slices_done_).member("slices_total", slices_total_);
    out->member("print", print_done_).member("mvoxels_per_second", mvoxels_per_second_);
    out->member("writable", !overrides_.empty() && values_are_taken());
    out->member("change", change_)
        .member("draft", draft_)
        .member("printed_draft", printed_draft_)
        .member("shows_full", shows_full_)
        .member("version", version_)
        .key("full_print");
    full_print_.describe(out);
    out->end_object();
}

void Live::describe_object(const world::Object& object, JsonText* out) const {
    out->begin_object().member("name", object.name).member("fablet", object.fablet);
    if (const auto ref = read_.world->fablets.find(object.fablet);
        ref != read_.world->fablets.end()) {
        // The number of its text, and its name there.
        const auto source =
            std::find(read_.sources.begin(), read_.sources.end(), ref->second.source);
        out->member("source", static_cast<int64_t>(source - read_.sources.begin()));
        out->member("fablet_name", ref->second.fablet);
    }
    out->key("uniforms").begin_array();
    const auto described = read_.described.find(object.fablet);
    const JsonValue* uniforms =
        described == read_.described.end() ? nullptr : member_of(described->second, "uniforms");
    if (uniforms != nullptr) {
        for (const JsonValue& uniform : uniforms->items) {
            const JsonValue* name = member_of(uniform, "name");
            if (name == nullptr) continue;
            out->begin_object();
            for (const JsonMember& member : uniform.members)
                out->key(member.key).value(member.value);
            const auto set =
                std::find_if(overrides_.begin(), overrides_.end(), [&](const Override& one) {
                    return one.object == object.name && one.uniform == name->text;
                });
            const auto bound = object.uniforms.find(name->text);
            if (set != overrides_.end() && !set->trouble.empty())
                out->member("trouble", set->trouble);
            out->member("changed", set != overrides_.end()).key("value");
            if (set != overrides_.end()) {
                write_override(set->value, out);
            } else if (bound != object.uniforms.end()) {
                write_binding(bound->second, out);
            } else {
                out->null();
            }
            out->end_object();
        }
    }
    out->end_array().end_object();
}

std::string Live::details() const {
    const std::lock_guard lock(mutex_);
    JsonText out;
    out.begin_object().member("version", version_).member("draft", draft_);
    out.member("changed", static_cast<int64_t>(overrides_.size()));
    out.member("message", remaining_message_).key("objects").begin_array();
    if (read_.world != nullptr) {
        for (const world::Object& object : read_.world->objects)
            describe_object(object, &out);
    }
    out.end_array().key("part");
    describe_part_of_world(&out);
    out.key("materials").begin_array();
    if (read_.world != nullptr) {
        for (const world::Material& material : read_.world->materials)
            out.value(material.name);
    }
    out.end_array().key("textures").begin_array();
    if (read_.world != nullptr) {
        for (const world::Texture& texture : read_.world->textures)
            out.value(texture.name);
    }
    out.end_array().key("fablets").begin_array();
    for (const std::filesystem::path& source : read_.sources) {
        const Result<std::string> text = read_source(source, read_.roots);
        out.begin_object().member("file", source.filename().string());
        out.member("stamp", text ? stamp_of(*text) : std::string()).end_object();
    }
    out.end_array().key("templates").begin_array();
    for (const std::string& one : options_.templates)
        out.value(one);
    out.end_array().key("diagnostics");
    write_diagnostics(read_.diagnostics, read_.sources, &out);
    out.end_object();
    return out.take();
}

}  // namespace openfab::viewer
