// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/viewer/live.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

#include "base/run_main.h"
#include "tools/viewer/messages.h"
#include "tools/viewer/source_text.h"
#include "tools/viewer/uniform_value.h"

namespace openfab::viewer {

namespace {

namespace fs = std::filesystem;

constexpr auto kPoll = std::chrono::milliseconds(80);
/// While a print runs, whose slices are waited for.
constexpr auto kBusyPoll = std::chrono::milliseconds(10);
/// Of pages that wait for a change.
constexpr auto kLongestWait = std::chrono::milliseconds(10'000);
constexpr auto kShortWait = std::chrono::milliseconds(400);

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
      world_(options_.file, world::rules_of(options_.allow, options_.memory_bytes),
             options_.programs, folder_->path() / "loop"),
      tried_(folder_->path() / "tried"),
      view_(fs::path(options_.file).filename().string(), session_),
      draft_(options_, folder_->path(), &signal_, &values_, &view_),
      full_print_(options_.programs, folder_->path()),
      graphs_(options_.programs),
      files_(options_.file, options_.programs, folder_->path() / "dropped", &graphs_, &values_,
             &signal_),
      prober_(options_.programs, folder_->path()),
      looker_(options_.programs, folder_->path()),
      page_compiler_(options_.programs, folder_->path() / "page") {
    thread_ = std::thread([this] { run_thread([this] { run(); }); });
}

Live::~Live() {
    signal_.stop();
    thread_.join();
}

void Live::run() {
    print_again();
    while (!signal_.stopped()) {
        draft_.follow();
        if (const std::optional<PrintOfValues> full = full_print_.done_now()) {
            if (view_.show_full(*full)) signal_.tell();
        }
        const bool asked = signal_.counts().asked;
        if (!asked && draft_.refines()) {
            draft_.begin(*world_.now(), tried_.now());
            continue;
        }
        signal_.wait_until_asked(draft_.makes_slices() ? kBusyPoll : kPoll);
        if (signal_.stopped()) return;
        if (signal_.counts().asked) {
            print_again();
        } else if (options_.watch && world_.files_changed()) {
            tried_.end();
            print_again();
        }
    }
}

/// Of what is asked for until it begins, nothing is asked for any more; in this order, no state says that a print has
/// taken what it has not.
void Live::print_again() {
    draft_.end();
    signal_.begin_what_was_asked();
    if (world_.read_again()) draft_.forget_size();
    draft_.begin(*world_.now(), tried_.now());
}

std::optional<std::string> Live::part_at(const Vec3d& point_mm) const {
    const std::shared_ptr<const PartFinder> finder = world_.now()->finder;
    return finder == nullptr ? std::nullopt : std::optional(finder->at(point_mm));
}

Result<std::vector<double>> Live::fractions_at(const pipeline::PrintInfo& info,
                                               const Vec3d& point_mm) {
    const ProbedWorld world{options_.file, {}, options_.allow, view_.settings()};
    return prober_.fractions(world, info, point_mm);
}

std::string Live::asked() const {
    JsonText out;
    out.begin_object().member("change", signal_.ask()).end_object();
    return out.take();
}

Result<std::string> Live::source(int32_t fablet) const {
    const Result<FabletSource> source = world_.now()->source_of(fablet);
    if (!source) return source.error();
    const Result<std::string> text = read_source(source->path, source->roots);
    if (!text) return text.error();
    JsonText out;
    out.begin_object().member("text", *text).member("stamp", stamp_of(*text)).end_object();
    return out.take();
}

Result<std::string> Live::check(int32_t fablet, const std::string& text) {
    const std::shared_ptr<const WorldReading> reading = world_.now();
    const Result<FabletSource> source = reading->source_of(fablet);
    if (!source) return source.error();
    Result<std::vector<client::Diagnostic>> diagnostics = std::vector<client::Diagnostic>();
    {
        const std::lock_guard lock(check_mutex_);
        diagnostics = page_compiler_.check_text(source->path, text);
    }
    if (!diagnostics) return diagnostics.error();
    JsonText out;
    out.begin_object().key("diagnostics");
    write_diagnostics(*diagnostics, reading->sources, &out);
    out.end_object();
    return out.take();
}

Result<std::string> Live::save(int32_t fablet, const std::string& text, const std::string& stamp) {
    const std::shared_ptr<const WorldReading> reading = world_.now();
    const Result<FabletSource> source = reading->source_of(fablet);
    if (!source) return source.error();
    const Result<WorldFiles::Saved> saved = files_.save(*reading, *source, text, stamp);
    if (!saved) return saved.error();
    end_try();
    JsonText out;
    out.begin_object().member("stamp", saved->stamp).member("notes", saved->notes).end_object();
    return out.take();
}

Result<std::string> Live::set(const std::string& object, const std::string& uniform,
                              const JsonValue& value) {
    if (!is_uniform_value(value)) return user_error(messages::kValueKinds);
    const std::shared_ptr<const WorldReading> reading = world_.now();
    const world::Object* of_object = reading->object(object);
    if (of_object == nullptr) return user_error(fmt::format(messages::kNoSuchObject, object));
    const JsonValue* uniforms = reading->uniforms_of(of_object->fablet);
    const bool known =
        uniforms != nullptr && std::any_of(uniforms->items.begin(), uniforms->items.end(),
                                           [&](const JsonValue& described) {
                                               const JsonValue* name = member_of(described, "name");
                                               return name != nullptr && name->text == uniform;
                                           });
    if (!known) return user_error(fmt::format(messages::kNoSuchUniform, object, uniform));
    JsonText json;
    json.value(value);
    values_.set(object, uniform, json.take());
    return asked();
}

Result<std::string> Live::try_value(int32_t fablet, const std::string& text,
                                    const std::string& name, const std::string& uniform,
                                    const JsonValue& value) {
    const std::shared_ptr<const WorldReading> reading = world_.now();
    const Result<FabletSource> source = reading->source_of(fablet);
    if (!source) return source.error();
    if (Result<void> put = tried_.put(*reading, *source, text, name, uniform, value); !put)
        return put.error();
    return asked();
}

void Live::end_try() {
    if (tried_.end()) signal_.ask();
}

Result<std::string> Live::use_file(const std::string& name, const std::string& object,
                                   bool repair) {
    const Result<Dropped::Made> made = files_.use_file(name, object, repair);
    if (!made) return made.error();
    JsonText out;
    out.begin_object().member("name", made->entry).member("mesh", made->is_mesh);
    out.member("notes", made->notes).end_object();
    return out.take();
}

Result<void> Live::begin_full_print() {
    std::vector<std::string> settings = options_.settings;
    for (const std::string& setting : values_.list().settings())
        settings.push_back(setting);
    Result<void> begun = full_print_.begin(fs::absolute(options_.file), options_.allow, settings);
    signal_.tell();
    return begun;
}

void Live::stop_full_print() {
    full_print_.stop();
    signal_.tell();
}

Result<void> Live::show_full_print(bool full) {
    Result<void> shown = full ? view_.show_full(full_print_.last()) : view_.show_draft_again();
    if (shown) signal_.tell();
    return shown;
}

Result<void> Live::use_template(const std::string& name) {
    const bool known = std::find(options_.templates.begin(), options_.templates.end(), name) !=
                       options_.templates.end();
    if (!known) return user_error(fmt::format(messages::kNoSuchTemplate, name));
    return files_.use_template(name);
}

void Live::set_draft(int32_t draft) {
    draft_.set_draft(draft);
    signal_.ask();
}

void Live::revert() {
    values_.forget_all();
    signal_.ask();
}

bool Live::has_taken(const DraftPrint::State& draft, const SetValues::List& values,
                     const ChangeSignal::Counts& counts) {
    return !counts.asked && draft.values_edition == values.edition &&
           (draft.phase == DraftPrint::Phase::kDone ||
            (draft.phase == DraftPrint::Phase::kPrinting && draft.slices_done > 0));
}

Result<void> Live::write() {
    return files_.write_values([&](const SetValues::List& values) -> Result<void> {
        const ChangeSignal::Counts counts = signal_.counts();
        const DraftPrint::State draft = draft_.state();
        if (has_taken(draft, values, counts)) return {};
        return user_error(draft.phase == DraftPrint::Phase::kFailed ? messages::kValuesFailed
                                                                    : messages::kValuesNotPrinted);
    });
}

void Live::wait_for_change(int64_t known) const {
    // The whole print has its own process, of which nobody tells.
    signal_.wait_for_change(known, full_print_.runs() ? kShortWait : kLongestWait);
}

}  // namespace openfab::viewer
