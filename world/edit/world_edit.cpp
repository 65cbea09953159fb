// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/edit/world_edit.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <iterator>
#include <span>
#include <utility>

#include "base/at.h"
#include "base/json_text.h"
#include "world/messages.h"
#include "world/world.h"
#include "world/world_keys.h"

namespace openfab::world {

namespace fs = std::filesystem;

namespace {

/// The end of a value, in text that was parsed.
size_t end_of_value(std::string_view text, size_t at) {
    int depth = 0;
    bool quoted = false;
    for (; at < text.size(); ++at) {
        const char c = text[at];
        if (quoted) {
            if (c == '\\') ++at;
            if (c == '"') quoted = false;
        } else if (c == '"') {
            quoted = true;
        } else if (c == '{' || c == '[') {
            ++depth;
        } else if (c == '}' || c == ']') {
            if (depth == 0) return at;
            --depth;
        } else if (depth == 0 && (c == ',' || c == ' ' || c == '\n' || c == '\r' || c == '\t')) {
            return at;
        } else {
            continue;
        }
        if (depth == 0 && !quoted) return at + 1;
    }
    return at;
}

/// Calls `each` with what a path of world_paths() leads to; `*` is any member, `[]` any item.
void find_values(const JsonValue& value, std::span<const std::string_view> path,
                 const std::function<void(const JsonValue&)>& each) {
    if (path.empty()) return each(value);
    const auto rest = path.subspan(1);
    if (path[0] == "[]") {
        for (const JsonValue& item : value.items)
            find_values(item, rest, each);
        return;
    }
    for (const JsonMember& member : value.members) {
        if (path[0] == "*" || member.key == path[0]) find_values(member.value, rest, each);
    }
}

}  // namespace

Result<WorldEdit> WorldEdit::of_text(std::string text, std::string name, int64_t memory_bytes) {
    WorldEdit out(std::move(text), std::move(name), memory_bytes);
    if (const Result<void> parsed = out.parse(); !parsed) return parsed.error();
    if (!out.tree_.is(JsonValue::Kind::kObject))
        return user_error(fmt::format(messages::kNoWorld, out.name_));
    return out;
}

Result<WorldEdit> WorldEdit::of_file(const fs::path& world, int64_t memory_bytes) {
    Result<std::string> text = read_text_file(world, kLargestWorld);
    if (!text) return text.error();
    return of_text(std::move(*text), world.string(), memory_bytes);
}

Result<void> WorldEdit::parse() {
    Result<JsonValue> tree = parse_json(text_, name_, memory_bytes_);
    if (!tree) return tree.error();
    tree_ = std::move(*tree);
    lines_ = {0};
    for (size_t at = 0; (at = text_.find('\n', at)) != std::string::npos;)
        lines_.push_back(++at);
    return {};
}

Result<void> WorldEdit::apply(std::vector<Change> changes) {
    std::ranges::sort(changes, {}, &Change::begin);
    std::string text;
    size_t at = 0;
    for (const Change& change : changes) {
        text.append(text_, at, change.begin - at);
        text += change.text;
        at = change.end;
    }
    text.append(text_, at);
    std::swap(text, text_);
    const Result<void> parsed = parse();
    if (parsed) return {};
    // A value was no JSON.
    std::swap(text, text_);
    if (const Result<void> before = parse(); !before) return before;
    return parsed;
}

/// The byte at a place of JSON's: one-based, columns in code points.
size_t WorldEdit::offset_of(int32_t line, int32_t column) const {
    size_t at = openfab::at(lines_, line - 1);
    for (int32_t c = 1; c < column; ++c) {
        ++at;
        while (at < text_.size() && (static_cast<unsigned char>(text_[at]) & 0xc0) == 0x80)
            ++at;
    }
    return at;
}

/// Puts a member before the others of an object, spaced as they are.
WorldEdit::Change WorldEdit::first_member(const JsonValue& object,
                                          const std::string& member) const {
    const size_t brace = offset_of(object.line, object.column);
    if (object.members.empty()) return {brace, end_of_value(text_, brace), "{" + member + "}"};
    const JsonMember& first = object.members.front();
    const size_t key = offset_of(first.line, first.column);
    const std::string space = text_.substr(brace + 1, key - brace - 1);
    return {key, key, member + "," + (space.empty() ? " " : space)};
}

/// Gives a member of an object that value; an object has no two of one key.
WorldEdit::Change WorldEdit::value_of_member(const JsonValue& object, std::string_view key,
                                             std::string_view value) const {
    const JsonValue* const there = member_of(object, key);
    if (there == nullptr)
        return first_member(object, fmt::format("{}: {}", json_string(key), value));
    const size_t begin = offset_of(there->line, there->column);
    return {begin, end_of_value(text_, begin), std::string(value)};
}

Result<const JsonValue*> WorldEdit::object_named(std::string_view object) const {
    const JsonValue* const objects = member_of(tree_, "objects");
    const JsonValue* const named = objects == nullptr ? nullptr : member_of(*objects, object);
    if (named == nullptr || !named->is(JsonValue::Kind::kObject))
        return user_error(fmt::format(messages::kNoObjectOfName, name_, object));
    return named;
}

Result<void> WorldEdit::set_uniform(std::string_view object, std::string_view uniform,
                                    std::string_view value) {
    const Result<const JsonValue*> named = object_named(object);
    if (!named) return named.error();
    const JsonValue* const uniforms = member_of(**named, "uniforms");
    if (uniforms == nullptr) {
        return apply({first_member(
            **named, fmt::format("\"uniforms\": {{{}: {}}}", json_string(uniform), value))});
    }
    if (!uniforms->is(JsonValue::Kind::kObject))
        return user_error(fmt::format(messages::kUniformsNoObject, name_, object));
    return apply({value_of_member(*uniforms, uniform, value)});
}

Result<void> WorldEdit::set_of_object(std::string_view object, std::string_view key,
                                      std::string_view value) {
    const Result<const JsonValue*> named = object_named(object);
    if (!named) return named.error();
    return apply({value_of_member(**named, key, value)});
}

Result<void> WorldEdit::set(std::string_view key, std::string_view value) {
    return apply({value_of_member(tree_, key, value)});
}

Result<void> WorldEdit::remove(std::string_view key) {
    if (member_of(tree_, key) == nullptr) return {};
    return apply({without_member(tree_, key)});
}

/// The object has the member.
WorldEdit::Change WorldEdit::without_member(const JsonValue& object, std::string_view key) const {
    const auto member = std::ranges::find(object.members, key, &JsonMember::key);
    const auto begin_of = [&](const JsonMember& one) { return offset_of(one.line, one.column); };
    const auto end_of = [&](const JsonMember& one) {
        return end_of_value(text_, offset_of(one.value.line, one.value.column));
    };
    // With the comma and the space to the next member, or from the last one.
    if (const auto next = std::next(member); next != object.members.end())
        return {begin_of(*member), begin_of(*next), ""};
    const bool alone = member == object.members.begin();
    return {alone ? begin_of(*member) : end_of(*std::prev(member)), end_of(*member), ""};
}

namespace {

/// A member of an object by its key, an item of a list by its number; null where there is none.
const JsonValue* step(const JsonValue& value, const std::string& key) {
    if (!value.is(JsonValue::Kind::kArray)) return member_of(value, key);
    size_t index = value.items.size();
    const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), index);
    const bool fits = error == std::errc() && end == key.data() + key.size();
    return fits && index < value.items.size() ? &value.items[index] : nullptr;
}

}  // namespace

Result<void> WorldEdit::set_at(std::span<const std::string> path, std::string_view value) {
    const JsonValue* at = &tree_;
    for (size_t i = 0; i < path.size(); ++i) {
        if (const JsonValue* const next = step(*at, path[i])) {
            at = next;
            continue;
        }
        if (!at->is(JsonValue::Kind::kObject))
            return user_error(fmt::format(messages::kNoSuchPlace, name_, path[i]));
        std::string made(value);
        for (size_t j = path.size(); j-- > i + 1;)
            made = fmt::format("{{{}: {}}}", json_string(path[j]), made);
        return apply({first_member(*at, fmt::format("{}: {}", json_string(path[i]), made))});
    }
    const size_t begin = offset_of(at->line, at->column);
    return apply({{begin, end_of_value(text_, begin), std::string(value)}});
}

Result<void> WorldEdit::remove_at(std::span<const std::string> path) {
    const JsonValue* at = &tree_;
    for (const std::string& key : path.first(path.size() - 1)) {
        at = step(*at, key);
        if (at == nullptr) return {};
    }
    if (!at->is(JsonValue::Kind::kObject) || member_of(*at, path.back()) == nullptr) return {};
    return apply({without_member(*at, path.back())});
}

Result<void> WorldEdit::set_entry(std::string_view section, std::string_view key,
                                  std::string_view value) {
    const JsonValue* const entries = member_of(tree_, section);
    if (entries == nullptr) {
        return apply({first_member(
            tree_, fmt::format("{}: {{{}: {}}}", json_string(section), json_string(key), value))});
    }
    if (!entries->is(JsonValue::Kind::kObject))
        return user_error(fmt::format(messages::kSectionIsNoObject, name_, section));
    return apply({value_of_member(*entries, key, value)});
}

Result<void> WorldEdit::rename_uniform(std::string_view section, std::string_view entry,
                                       std::string_view from, std::string_view to) {
    const JsonValue* bound = member_of(tree_, section);
    for (const std::string_view key : {entry, std::string_view("uniforms")})
        bound = bound == nullptr ? nullptr : member_of(*bound, key);
    if (bound == nullptr) return {};
    for (const JsonMember& member : bound->members) {
        if (member.key != from) continue;
        const size_t begin = offset_of(member.line, member.column);
        return apply({{begin, end_of_value(text_, begin), json_string(to)}});
    }
    return {};
}

Result<void> WorldEdit::relocate(const fs::path& from, const fs::path& to) {
    // Without links, which `..` would lead out of.
    std::error_code ignored;
    const auto resolved = [&](const fs::path& folder) {
        const fs::path path = fs::weakly_canonical(fs::absolute(folder), ignored);
        return path.has_filename() ? path : path.parent_path();
    };
    const fs::path begin = resolved(from), end = resolved(to);
    if (begin == end) return {};
    if (const JsonValue* const meshes = member_of(tree_, "meshes")) {
        for (const JsonMember& mesh : meshes->members) {
            if (const JsonMember* const program = mesh.value.find("program")) {
                Error error = user_error(fmt::format(messages::kProgramStays, mesh.key),
                                         fmt::format(messages::kProgramStaysHelp, begin.string()));
                error.location = {name_, program->line, program->column};
                return error;
            }
        }
    }
    return rewrite_paths([&](const fs::path& file) {
        return (begin / file).lexically_normal().lexically_proximate(end);
    });
}

Result<void> WorldEdit::make_absolute(const fs::path& from) {
    return rewrite_paths([&](const fs::path& file) { return (from / file).lexically_normal(); });
}

Result<void> WorldEdit::rewrite_paths(const std::function<fs::path(const fs::path&)>& rewrite) {
    std::vector<Change> changes;
    for (const JsonValue* const value : path_values()) {
        if (fs::path(value->text).is_absolute()) continue;
        const size_t at = offset_of(value->line, value->column);
        changes.push_back(
            {at, end_of_value(text_, at), json_string(rewrite(value->text).string())});
    }
    return apply(std::move(changes));
}

std::vector<const JsonValue*> WorldEdit::path_values() const {
    std::vector<const JsonValue*> values;
    for (const WorldPath& path : world_paths()) {
        find_values(tree_, path.keys, [&](const JsonValue& value) {
            if (value.is(JsonValue::Kind::kString) && value.text.ends_with(path.ends))
                values.push_back(&value);
        });
    }
    return values;
}

std::vector<fs::path> WorldEdit::paths() const {
    std::vector<fs::path> paths;
    for (const JsonValue* const value : path_values())
        paths.emplace_back(value->text);
    return paths;
}

}  // namespace openfab::world
