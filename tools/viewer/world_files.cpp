// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0

#include "tools/viewer/world_files.h"

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <utility>

#include "base/input_file.h"
#include "base/json.h"
#include "base/own_folder.h"
#include "base/replace_file.h"
#include "client/child.h"
#include "tools/viewer/messages.h"
#include "tools/viewer/source_text.h"
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

Result<bool> WorldFiles::change_world(const Change& change) {
    const Result<WorldLock> alone = WorldLock::take(&files_mutex_, world_);
    if (!alone) return alone.error();
    const Result<std::string> text = read_source(world_);
    if (!text) return text.error();
    const Result<std::string> changed = change(*text);
    if (!changed) return changed.error();
    if (*changed == *text) return false;
    if (Result<void> written = replace_file(world_, *changed); !written) return written.error();
    return true;
}

Result<void> WorldFiles::print_changed(const Result<bool>& changed) {
    if (!changed) return changed.error();
    if (*changed) signal_->ask();
    return {};
}

Result<void> WorldFiles::edit_part(const JsonValue& edits) {
    return print_changed(change_world([&](const std::string& text) -> Result<std::string> {
        Result<std::string> edited = part_edited(text, world_.filename().string(), edits);
        if (edited && *edited != text) part_history_.record(text, *edited);
        return edited;
    }));
}

Result<void> WorldFiles::step_part(bool forward) {
    return print_changed(change_world([&](const std::string& text) -> Result<std::string> {
        std::optional<std::string> other = part_history_.step(text, forward);
        if (!other) return user_error(messages::kNothingToUndo);
        return std::move(*other);
    }));
}

Result<void> WorldFiles::write_values(
    const std::function<Result<void>(const SetValues::List&)>& may_write) {
    const SetValues::List list = values_->list();
    const auto with_values = [&](const std::string& text) -> Result<std::string> {
        if (Result<void> may = may_write(list); !may) return may.error();
        Result<world::WorldEdit> world =
            world::WorldEdit::of_text(text, world_.filename().string());
        if (!world) return world.error();
        for (const SetValue& value : list.values) {
            if (Result<void> set = world->set_uniform(value.object, value.uniform, value.value);
                !set)
                return set.error();
        }
        return world->text();
    };
    if (const Result<bool> written = change_world(with_values); !written) return written.error();
    values_->forget(list);
    signal_->ask();
    return {};
}

Result<WorldFiles::Saved> WorldFiles::save(const WorldReading& reading, const FabletSource& source,
                                           const std::string& text, const std::string& stamp) {
    const Result<WorldLock> alone = WorldLock::take(&files_mutex_, world_);
    if (!alone) return alone.error();
    const Result<std::string> before = read_source(source.path, source.roots);
    if (!before) return before.error();
    if (stamp_of(*before) != stamp) {
        return user_error(fmt::format(messages::kChangedMeanwhile, source.path.filename().string()),
                          messages::kChangedMeanwhileHelp);
    }
    if (Result<void> written = replace_file(source.path, text); !written) return written.error();
    const Result<std::string> renamed = rename_bindings(reading, source, *before, text);
    signal_->ask();
    return Saved{stamp_of(text), renamed ? *renamed : renamed.error().text()};
}

Result<std::string> WorldFiles::rename_bindings(const WorldReading& reading,
                                                const FabletSource& source,
                                                const std::string& before,
                                                const std::string& after) {
    const Result<std::string> old_graph =
        graphs_->ask("openfl/graph", source.path, before, nullptr);
    const Result<std::string> new_graph = graphs_->ask("openfl/graph", source.path, after, nullptr);
    const std::optional<Renamed> renamed =
        old_graph && new_graph ? renamed_uniform(*old_graph, *new_graph) : std::nullopt;
    if (!renamed || reading.world == nullptr) return std::string();
    const Result<std::string> text = read_source(world_);
    if (!text) return text.error();
    Result<world::WorldEdit> world = world::WorldEdit::of_text(*text, world_.filename().string());
    if (!world) return world.error();
    const auto rename = [&](const char* section, const std::string& entry) {
        return world->rename_uniform(section, entry, renamed->from, renamed->to);
    };
    for (const auto& [entry, ref] : reading.world->fablets) {
        if (ref.source != source.path || ref.fablet != renamed->fablet) continue;
        if (Result<void> done = rename("fablets", entry); !done) return done.error();
        for (const world::Object& object : reading.world->objects) {
            if (object.fablet != entry) continue;
            if (Result<void> done = rename("objects", object.name); !done) return done.error();
            values_->rename(object.name, renamed->from, renamed->to);
        }
    }
    if (world->text() == *text) return std::string();
    if (Result<void> written = replace_file(world_, world->text()); !written)
        return written.error();
    return fmt::format(messages::kCalledNow, renamed->from, renamed->to);
}

Result<void> WorldFiles::upload(const std::string& name, int64_t at, const std::string& bytes) {
    return dropped_.add(name, at, bytes);
}

Result<Dropped::Made> WorldFiles::use_file(const std::string& name, const std::string& object,
                                           bool repair) {
    const std::lock_guard one_by_one(uses_mutex_);
    // To import it may take long, and others change the world meanwhile.
    constexpr int kTries = 3;
    for (int i = 0; i < kTries; ++i) {
        const Result<std::string> text = read_source(world_);
        if (!text) return text.error();
        Result<Dropped::Made> made = dropped_.use(name, object, world_, *text, repair);
        if (!made) return made.error();
        const Result<WorldLock> alone = WorldLock::take(&files_mutex_, world_);
        if (!alone) return alone.error();
        const Result<std::string> now = read_source(world_);
        if (!now) return now.error();
        if (*now != *text) continue;
        if (Result<void> written = replace_file(world_, made->world); !written)
            return written.error();
        signal_->ask();
        return made;
    }
    return user_error(messages::kDropOnceMore);
}

Result<void> WorldFiles::use_template(const std::string& name) {
    std::string stem = world_.filename().string();
    stem = stem.substr(0, stem.find('.'));
    const Result<std::unique_ptr<TemporaryFolder>> folder = TemporaryFolder::create(scratch_);
    if (!folder) return folder.error();
    const fs::path err = (*folder)->path() / "new.err";
    Result<std::unique_ptr<client::Child>> child =
        client::Child::start({(programs_ / "openfab").string(), "new",
                              ((*folder)->path() / stem).string(), "--template", name},
                             (*folder)->path() / "new.out", err);
    if (!child) return child.error();
    if ((*child)->wait() != 0) return user_error(client::end_of_file(err, kMostWords));
    const Result<WorldLock> alone = WorldLock::take(&files_mutex_, world_);
    if (!alone) return alone.error();
    for (const char* suffix : {".fl", ".fab.json"}) {
        const Result<std::string> text = read_source((*folder)->path() / stem / (stem + suffix));
        if (!text) return text.error();
        if (Result<void> written = replace_file(world_.parent_path() / (stem + suffix), *text);
            !written)
            return written;
    }
    values_->forget_all();
    signal_->ask();
    return {};
}

}  // namespace openfab::viewer
