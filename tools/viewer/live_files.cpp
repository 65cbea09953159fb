// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

// What the page does to the files of the world's folder.

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "base/input_file.h"
#include "base/json.h"
#include "base/replace_file.h"
#include "tools/viewer/live.h"
#include "tools/viewer/messages.h"
#include "tools/viewer/world_lock.h"
#include "world/edit/world_edit.h"

namespace openfab::viewer {

namespace fs = std::filesystem;

namespace {

constexpr int64_t kMostWords = 4000;

struct Renamed {
    std::string fablet, from, to;
};

/// Of what two graphs say of uniforms, the one that is called differently: of the same type, at the same place.
std::optional<Renamed> renamed_uniform(const std::string& before, const std::string& after) {
    const Result<JsonValue> old_graph = parse_json(before, "openflc");
    const Result<JsonValue> new_graph = parse_json(after, "openflc");
    if (!old_graph || !new_graph) return {};
    const JsonValue* had = member_of(*old_graph, "uniforms");
    const JsonValue* has = member_of(*new_graph, "uniforms");
    if (had == nullptr || has == nullptr || had->items.size() != has->items.size()) return {};
    const auto text = [](const JsonValue& one, const char* name) {
        const JsonValue* found = member_of(one, name);
        return found == nullptr ? std::string() : found->text;
    };
    std::optional<Renamed> out;
    for (size_t i = 0; i < had->items.size(); ++i) {
        const JsonValue& a = had->items[i];
        const JsonValue& b = has->items[i];
        if (text(a, "name") == text(b, "name")) continue;
        if (out || text(a, "type") != text(b, "type") || text(a, "fablet") != text(b, "fablet"))
            return {};
        out = Renamed{text(a, "fablet"), text(a, "name"), text(b, "name")};
    }
    return out;
}

}  // namespace

Result<std::string> Live::rename_bindings(const Source& source, const std::string& before,
                                          const std::string& after) {
    const Result<std::string> old_graph = graphs_.ask("openfl/graph", source.path, before, nullptr);
    const Result<std::string> new_graph = graphs_.ask("openfl/graph", source.path, after, nullptr);
    const std::optional<Renamed> renamed =
        old_graph && new_graph ? renamed_uniform(*old_graph, *new_graph) : std::nullopt;
    if (!renamed) return std::string();
    const std::string name = fs::path(options_.file).filename().string();
    const Result<std::string> text = read_source(options_.file);
    if (!text) return text.error();
    Result<world::WorldEdit> world = world::WorldEdit::of_text(*text, name);
    if (!world) return world.error();
    const std::lock_guard lock(mutex_);
    if (read_.world == nullptr) return std::string();
    const auto rename = [&](const char* section, const std::string& entry) {
        return world->rename_uniform(section, entry, renamed->from, renamed->to);
    };
    for (const auto& [entry, ref] : read_.world->fablets) {
        if (ref.source != source.path || ref.fablet != renamed->fablet) continue;
        if (Result<void> done = rename("fablets", entry); !done) return done.error();
        for (const world::Object& object : read_.world->objects) {
            if (object.fablet != entry) continue;
            if (Result<void> done = rename("objects", object.name); !done) return done.error();
            for (Override& one : overrides_) {
                if (one.object == object.name && one.uniform == renamed->from)
                    one.uniform = renamed->to;
            }
        }
    }
    if (world->text() == *text) return std::string();
    if (Result<void> written = replace_file(options_.file, world->text()); !written)
        return written.error();
    return fmt::format(messages::kCalledNow, renamed->from, renamed->to);
}

Result<void> Live::upload(const std::string& name, int64_t at, const std::string& bytes) {
    return dropped_.add(name, at, bytes);
}

Result<std::string> Live::use_file(const std::string& name, const std::string& object,
                                   bool repair) {
    const fs::path world = fs::absolute(options_.file);
    const std::lock_guard one_by_one(uses_mutex_);
    // To import it may take long, and others change the world meanwhile.
    constexpr int kTries = 3;
    for (int i = 0; i < kTries; ++i) {
        const Result<std::string> text = read_source(world);
        if (!text) return text.error();
        const Result<Dropped::Made> made = dropped_.use(name, object, world, *text, repair);
        if (!made) return made.error();
        const Result<WorldLock> alone = WorldLock::take(&files_mutex_, world);
        if (!alone) return alone.error();
        const Result<std::string> now = read_source(world);
        if (!now) return now.error();
        if (*now != *text) continue;
        if (Result<void> written = replace_file(world, made->world); !written)
            return written.error();
        const std::lock_guard lock(mutex_);
        touch();
        JsonText out;
        out.begin_object().member("name", made->entry).member("mesh", made->is_mesh);
        out.member("notes", made->notes).end_object();
        return out.take();
    }
    return user_error(messages::kDropOnceMore);
}

Result<void> Live::begin_full_print() {
    std::vector<std::string> settings = options_.settings;
    {
        const std::lock_guard lock(mutex_);
        for (const Override& one : overrides_)
            settings.push_back(one.setting());
    }
    Result<void> begun = full_print_.begin(fs::absolute(options_.file), options_.allow, settings);
    const std::lock_guard lock(mutex_);
    if (begun) full_settings_ = settings;
    tell_of_change();
    return begun;
}

void Live::stop_full_print() {
    full_print_.stop();
    const std::lock_guard lock(mutex_);
    tell_of_change();
}

Result<void> Live::use_template(const std::string& name) {
    const bool known = std::find(options_.templates.begin(), options_.templates.end(), name) !=
                       options_.templates.end();
    if (!known) return user_error(fmt::format(messages::kNoSuchTemplate, name));
    const fs::path world = fs::absolute(options_.file);
    std::string stem = world.filename().string();
    stem = stem.substr(0, stem.find('.'));
    const Result<std::unique_ptr<TemporaryFolder>> folder =
        TemporaryFolder::create(folder_->path());
    if (!folder) return folder.error();
    const fs::path err = (*folder)->path() / "new.err";
    Result<std::unique_ptr<client::Child>> child =
        client::Child::start({(options_.programs / "openfab").string(), "new",
                              ((*folder)->path() / stem).string(), "--template", name},
                             (*folder)->path() / "new.out", err);
    if (!child) return child.error();
    if ((*child)->wait() != 0) return user_error(client::end_of_file(err, kMostWords));
    const Result<WorldLock> alone = WorldLock::take(&files_mutex_, world);
    if (!alone) return alone.error();
    for (const char* suffix : {".fl", ".fab.json"}) {
        const Result<std::string> text = read_source((*folder)->path() / stem / (stem + suffix));
        if (!text) return text.error();
        if (Result<void> written = replace_file(world.parent_path() / (stem + suffix), *text);
            !written)
            return written;
    }
    const std::lock_guard lock(mutex_);
    overrides_.clear();
    touch();
    return {};
}

}  // namespace openfab::viewer
