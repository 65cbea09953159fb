// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/live.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "base/input_file.h"
#include "base/replace_file.h"
#include "base/run_main.h"
#include "tools/viewer/messages.h"
#include "tools/viewer/uniform_value.h"
#include "tools/viewer/world_lock.h"
#include "world/edit/world_edit.h"

namespace openfab::viewer {

namespace {

namespace fs = std::filesystem;

constexpr auto kPoll = std::chrono::milliseconds(80);
/// While a print runs, whose slices are waited for.
constexpr auto kBusyPoll = std::chrono::milliseconds(10);

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

}  // namespace

Result<std::unique_ptr<Live>> Live::start(const ViewOptions& options, Session* session) {
    Result<std::unique_ptr<TemporaryFolder>> folder = TemporaryFolder::create();
    if (!folder) return folder.error();
    for (const char* name : {"loop", "page", "dropped", "tried"}) {
        std::error_code status;
        fs::create_directory((*folder)->path() / name, status);
        if (status) return outside_error(messages::kCannotMakeFolder + status.message());
    }
    return std::unique_ptr<Live>(new Live(options, session, std::move(*folder)));
}

Live::Live(ViewOptions options, Session* session, std::unique_ptr<TemporaryFolder> folder)
    : options_(std::move(options)),
      session_(session),
      folder_(std::move(folder)),
      compiler_(options_.programs, folder_->path() / "loop"),
      page_compiler_(options_.programs, folder_->path() / "page"),
      graphs_(options_.programs),
      prober_(options_.programs, folder_->path()),
      looker_(options_.programs, folder_->path()),
      dropped_(options_.programs, folder_->path() / "dropped"),
      full_print_(options_.programs, folder_->path()),
      draft_(options_.draft) {
    thread_ = std::thread([this] { run_thread([this] { run(); }); });
}

Live::~Live() {
    stop_ = true;
    changed_.notify_all();
    thread_.join();
}

void Live::run() {
    bool again = true;
    while (!stop_) {
        if (again) {
            set_phase(Phase::kChecking, {});
            child_.reset();
            {
                const std::lock_guard lock(mutex_);
                refines_ = false;
            }
            if (must_read()) {
                Read read = this->read();
                const std::lock_guard lock(mutex_);
                keep_known(read_, &read);
                // Another mesh may be of any size.
                if (read.times[options_.file] != read_.times[options_.file]) full_voxels_ = 0;
                read_ = std::move(read);
                if (read_.world != nullptr) finder_ = std::make_shared<PartFinder>(read_.world);
            }
            begin_print();
        }
        follow_print();
        show_done_print();
        if (refine()) {
            again = false;
            continue;
        }
        std::unique_lock lock(mutex_);
        const auto pause = child_ != nullptr && !is_over_ ? kBusyPoll : kPoll;
        changed_.wait_for(lock, pause, [&] { return asked_ || stop_; });
        again = std::exchange(asked_, false);
        lock.unlock();
        if (options_.watch && !again && files_changed()) {
            end_try();
            again = true;
        }
    }
    child_.reset();
}

/// From the files; called by the loop alone.
Live::Read Live::read() const {
    Read made;
    std::vector<fs::path> files{options_.file};
    // Before they are read: a change from now on counts.
    std::map<fs::path, fs::file_time_type> before;
    {
        const std::lock_guard lock(mutex_);
        made.sources = read_.sources;
        before = read_.times;
    }
    for (auto& [file, time] : before)
        time = time_of(file);
    before[options_.file] = time_of(options_.file);
    Result<world::World> world =
        world::load_world(options_.file, world::rules_of(options_.allow, options_.memory_bytes));
    if (world) {
        made.world = std::make_shared<world::World>(std::move(*world));
        made.sources.clear();
        for (const auto& [name, ref] : made.world->fablets) {
            if (std::find(made.sources.begin(), made.sources.end(), ref.source) ==
                made.sources.end())
                made.sources.push_back(ref.source);
        }
        made.roots = made.world->roots;
        files = made.world->files;
    } else {
        made.message = world.error().text();
    }
    for (const fs::path& file : with_modules(made.sources))
        files.push_back(file);
    for (const fs::path& file : files) {
        const auto found = before.find(file);
        made.times[file] = found == before.end() ? time_of(file) : found->second;
    }
    std::map<fs::path, std::map<std::string, JsonValue>> described;
    for (const fs::path& source : made.sources) {
        Result<std::vector<client::Diagnostic>> found = compiler_.check(source);
        if (!found) {
            made.message += found.error().text();
            continue;
        }
        const bool broken = client::has_errors(*found);
        made.diagnostics.insert(made.diagnostics.end(), found->begin(), found->end());
        if (broken) continue;
        Result<std::map<std::string, JsonValue>> all = compiler_.describe(source);
        if (all) described[source] = std::move(*all);
    }
    if (made.world == nullptr) return made;
    for (const auto& [name, ref] : made.world->fablets) {
        const auto found = described[ref.source].find(ref.fablet);
        if (found != described[ref.source].end()) made.described[name] = found->second;
    }
    return made;
}

/// What cannot be read now is shown as it was: a mistake while typing takes no control away.
void Live::keep_known(const Read& before, Read* now) {
    if (now->world == nullptr) {
        now->world = before.world;
        now->roots = before.roots;
    }
    if (now->world == nullptr) return;
    for (const auto& [name, ref] : now->world->fablets) {
        const auto known = before.described.find(name);
        if (known != before.described.end()) now->described.emplace(name, known->second);
    }
}

/// A value that is set or tried needs nothing to be read anew.
bool Live::must_read() const {
    {
        const std::lock_guard lock(mutex_);
        if (read_.world == nullptr || !read_.message.empty()) return true;
    }
    return files_changed();
}

bool Live::files_changed() const {
    const std::lock_guard lock(mutex_);
    return std::any_of(read_.times.begin(), read_.times.end(),
                       [](const auto& file) { return time_of(file.first) != file.second; });
}

std::optional<std::string> Live::part_at(const Vec3d& point_mm) const {
    std::shared_ptr<const PartFinder> finder;
    {
        const std::lock_guard lock(mutex_);
        finder = finder_;
    }
    return finder == nullptr ? std::nullopt : std::optional(finder->at(point_mm));
}

Result<std::vector<double>> Live::fractions_at(const pipeline::PrintInfo& info,
                                               const Vec3d& point_mm) {
    ProbedWorld world{options_.file, {}, options_.allow, {}};
    {
        const std::lock_guard lock(mutex_);
        world.settings = shown_settings_;
    }
    return prober_.fractions(world, info, point_mm);
}

void Live::touch() {
    asked_ = true;
    ++version_;
    changed_.notify_all();
    tell_of_change();
}

Result<Live::Source> Live::source_of(int32_t fablet) const {
    const std::lock_guard lock(mutex_);
    if (fablet < 0 || static_cast<size_t>(fablet) >= read_.sources.size())
        return user_error(fmt::format(messages::kNoSuchFablet, fablet));
    return Source{read_.sources[static_cast<size_t>(fablet)], read_.roots};
}

Result<std::string> Live::source(int32_t fablet) const {
    const Result<Source> of = source_of(fablet);
    if (!of) return of.error();
    const Result<std::string> text = read_source(of->path, of->roots);
    if (!text) return text.error();
    JsonText out;
    out.begin_object().member("text", *text).member("stamp", stamp_of(*text)).end_object();
    return out.take();
}

Result<std::string> Live::check(int32_t fablet, const std::string& text) {
    const Result<Source> of = source_of(fablet);
    if (!of) return of.error();
    Result<std::vector<client::Diagnostic>> found = std::vector<client::Diagnostic>();
    {
        const std::lock_guard lock(check_mutex_);
        found = page_compiler_.check_text(of->path, text);
    }
    if (!found) return found.error();
    const std::lock_guard lock(mutex_);
    JsonText out;
    out.begin_object().key("diagnostics");
    write_diagnostics(*found, read_.sources, &out);
    out.end_object();
    return out.take();
}

Result<std::string> Live::save(int32_t fablet, const std::string& text, const std::string& stamp) {
    const Result<Source> of = source_of(fablet);
    if (!of) return of.error();
    const fs::path& path = of->path;
    const Result<WorldLock> alone = WorldLock::take(&files_mutex_, options_.file);
    if (!alone) return alone.error();
    const Result<std::string> there = read_source(path, of->roots);
    if (!there) return there.error();
    if (stamp_of(*there) != stamp) {
        return user_error(fmt::format(messages::kChangedMeanwhile, path.filename().string()),
                          messages::kChangedMeanwhileHelp);
    }
    if (Result<void> written = replace_file(path, text); !written) return written.error();
    const Result<std::string> renamed = rename_bindings(*of, *there, text);
    end_try();
    const std::lock_guard lock(mutex_);
    touch();
    JsonText out;
    out.begin_object().member("stamp", stamp_of(text));
    out.member("notes", renamed ? *renamed : renamed.error().text()).end_object();
    return out.take();
}

Result<std::string> Live::set(const std::string& object, const std::string& uniform,
                              const JsonValue& value) {
    if (!is_uniform_value(value)) return user_error(messages::kValueKinds);
    const std::lock_guard lock(mutex_);
    const auto found =
        read_.world == nullptr
            ? std::vector<world::Object>::const_iterator()
            : std::find_if(read_.world->objects.begin(), read_.world->objects.end(),
                           [&](const world::Object& one) { return one.name == object; });
    if (read_.world == nullptr || found == read_.world->objects.end())
        return user_error(fmt::format(messages::kNoSuchObject, object));
    const auto described = read_.described.find(found->fablet);
    const JsonValue* uniforms =
        described == read_.described.end() ? nullptr : member_of(described->second, "uniforms");
    const bool known =
        uniforms != nullptr &&
        std::any_of(uniforms->items.begin(), uniforms->items.end(), [&](const JsonValue& one) {
            const JsonValue* name = member_of(one, "name");
            return name != nullptr && name->text == uniform;
        });
    if (!known) return user_error(fmt::format(messages::kNoSuchUniform, object, uniform));
    JsonText json;
    json.value(value);
    std::erase_if(overrides_, [&](const Override& one) {
        return one.object == object && one.uniform == uniform;
    });
    overrides_.push_back({object, uniform, json.take(), {}});
    touch();
    JsonText out;
    out.begin_object().member("change", change_).end_object();
    return out.take();
}

void Live::set_draft(int32_t draft) {
    const std::lock_guard lock(mutex_);
    draft_ = draft;
    touch();
}

void Live::revert() {
    const std::lock_guard lock(mutex_);
    overrides_.clear();
    touch();
}

/// The caller holds the lock.
bool Live::values_are_taken() const {
    return !asked_ && (phase_ == Phase::kDone || (phase_ == Phase::kPrinting && slices_done_ > 0));
}

Result<void> Live::write() {
    const Result<WorldLock> alone = WorldLock::take(&files_mutex_, options_.file);
    if (!alone) return alone.error();
    const std::lock_guard lock(mutex_);
    if (!values_are_taken()) {
        return user_error(phase_ == Phase::kFailed ? messages::kValuesFailed
                                                   : messages::kValuesNotPrinted);
    }
    Result<std::string> text = read_source(options_.file);
    if (!text) return text.error();
    Result<world::WorldEdit> world = world::WorldEdit::of_text(std::move(*text), options_.file);
    if (!world) return world.error();
    for (const Override& one : overrides_) {
        if (Result<void> set = world->set_uniform(one.object, one.uniform, one.value); !set)
            return set;
    }
    if (Result<void> written = replace_file(options_.file, world->text()); !written) return written;
    overrides_.clear();
    touch();
    return {};
}

}  // namespace openfab::viewer
