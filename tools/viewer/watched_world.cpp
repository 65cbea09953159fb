// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/watched_world.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "tools/viewer/messages.h"

namespace openfab::viewer {

namespace {

namespace fs = std::filesystem;

fs::file_time_type time_of(const fs::path& file) {
    std::error_code gone;
    const fs::file_time_type time = fs::last_write_time(file, gone);
    return gone ? fs::file_time_type::min() : time;
}

/// The sources and all that they could import from beside them.
std::vector<fs::path> with_modules(const std::vector<fs::path>& sources) {
    std::vector<fs::path> files = sources;
    for (const fs::path& source : sources) {
        std::error_code status;
        for (fs::directory_iterator entry(source.parent_path(), status), end;
             !status && entry != end; entry.increment(status)) {
            if (entry->path().extension() == ".fl") files.push_back(entry->path());
        }
    }
    return files;
}

std::vector<fs::path> sources_of(const world::World& world) {
    std::vector<fs::path> sources;
    for (const auto& [name, ref] : world.fablets) {
        if (std::find(sources.begin(), sources.end(), ref.source) == sources.end())
            sources.push_back(ref.source);
    }
    return sources;
}

}  // namespace

Result<FabletSource> WorldReading::source_of(int32_t fablet) const {
    if (fablet < 0 || static_cast<size_t>(fablet) >= sources.size())
        return user_error(fmt::format(messages::kNoSuchFablet, fablet));
    return FabletSource{sources[static_cast<size_t>(fablet)], roots};
}

const world::Object* WorldReading::object(const std::string& name) const {
    if (world == nullptr) return nullptr;
    const auto object =
        std::find_if(world->objects.begin(), world->objects.end(),
                     [&](const world::Object& candidate) { return candidate.name == name; });
    return object == world->objects.end() ? nullptr : &*object;
}

const JsonValue* WorldReading::uniforms_of(const std::string& fablet) const {
    const auto description = described.find(fablet);
    return description == described.end() ? nullptr : member_of(description->second, "uniforms");
}

std::shared_ptr<const WorldReading> WatchedWorld::now() const {
    const std::lock_guard lock(mutex_);
    return now_;
}

bool WatchedWorld::files_changed() const {
    const std::shared_ptr<const WorldReading> reading = now();
    return std::any_of(reading->times.begin(), reading->times.end(),
                       [](const auto& file) { return time_of(file.first) != file.second; });
}

bool WatchedWorld::read_again() {
    const std::shared_ptr<const WorldReading> before = now();
    // A value that is set or tried needs nothing to be read anew.
    if (before->world != nullptr && before->message.empty() && !files_changed()) return false;
    const auto reading = std::make_shared<const WorldReading>(read(*before));
    const std::lock_guard lock(mutex_);
    now_ = reading;
    const auto known = before->times.find(file_);
    return known == before->times.end() || known->second != reading->times.at(file_);
}

WorldReading WatchedWorld::read(const WorldReading& before) const {
    WorldReading reading;
    // Before they are read: a change from now on counts.
    std::map<fs::path, fs::file_time_type> times = before.times;
    times[file_];
    for (auto& [file, time] : times)
        time = time_of(file);
    std::vector<fs::path> files{file_};
    Result<world::World> world = world::load_world(file_, rules_);
    if (world) {
        reading.world = std::make_shared<world::World>(std::move(*world));
        reading.finder = std::make_shared<PartFinder>(reading.world);
        reading.sources = sources_of(*reading.world);
        reading.roots = reading.world->roots;
        files = reading.world->files;
    } else {
        reading.message = world.error().text();
        reading.world = before.world;
        reading.finder = before.finder;
        reading.sources = before.sources;
        reading.roots = before.roots;
    }
    for (const fs::path& file : with_modules(reading.sources))
        files.push_back(file);
    for (const fs::path& file : files) {
        const auto known = times.find(file);
        reading.times[file] = known == times.end() ? time_of(file) : known->second;
    }
    std::map<fs::path, std::map<std::string, JsonValue>> by_source;
    for (const fs::path& source : reading.sources) {
        Result<std::vector<client::Diagnostic>> diagnostics = compiler_.check(source);
        if (!diagnostics) {
            reading.message += diagnostics.error().text();
            continue;
        }
        reading.diagnostics.insert(reading.diagnostics.end(), diagnostics->begin(),
                                   diagnostics->end());
        if (client::has_errors(*diagnostics)) continue;
        Result<std::map<std::string, JsonValue>> fablets = compiler_.describe(source);
        if (fablets) by_source[source] = std::move(*fablets);
    }
    if (reading.world == nullptr) return reading;
    for (const auto& [name, ref] : reading.world->fablets) {
        const auto description = by_source[ref.source].find(ref.fablet);
        const auto known = before.described.find(name);
        if (description != by_source[ref.source].end()) {
            reading.described[name] = description->second;
        } else if (known != before.described.end()) {
            reading.described[name] = known->second;
        }
    }
    return reading;
}

}  // namespace openfab::viewer
