// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/scene/json.h"

#include <fmt/format.h>
#include <rapidjson/error/en.h>
#include <rapidjson/reader.h>

#include <algorithm>

#include "runtime/base/input_file.h"

namespace openfab::scene {
namespace {

using Kind = JsonValue::Kind;

constexpr size_t kDeepest = 32;
constexpr size_t kMostValues = 1'000'000;

/// RapidJSON's input: the text and the place in it, which its own string stream hides from
/// handlers.
class TextStream {
  public:
    using Ch = char;
    explicit TextStream(std::string_view text) : text_(text) {}
    Ch Peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }
    Ch Take() { return at_ < text_.size() ? text_[at_++] : '\0'; }
    size_t Tell() const { return at_; }
    // Writing is part of the concept but is never asked of an input.
    Ch* PutBegin() { return nullptr; }
    void Put(Ch) {}
    void Flush() {}
    size_t PutEnd(Ch*) { return 0; }

  private:
    std::string_view text_;
    size_t at_ = 0;
};

/// Turns byte offsets that never go back into lines and columns.
class Positions {
  public:
    explicit Positions(std::string_view text) : text_(text) {}
    void find(size_t offset, int32_t* line, int32_t* column) {
        for (; at_ < std::min(offset, text_.size()); ++at_) {
            if (text_[at_] == '\n') {
                ++line_;
                column_ = 1;
            } else if ((static_cast<unsigned char>(text_[at_]) & 0xC0) != 0x80) {
                ++column_;
            }
        }
        *line = line_;
        *column = column_;
    }

  private:
    std::string_view text_;
    size_t at_ = 0;
    int32_t line_ = 1;
    int32_t column_ = 1;
};

class TreeBuilder {
  public:
    TreeBuilder(std::string_view text, const TextStream& stream, const std::string& name)
        : text_(text), stream_(stream), name_(name), positions_(text) {}

    bool Null() { return add(Kind::kNull) != nullptr; }
    bool Bool(bool value) {
        JsonValue* v = add(Kind::kBool);
        if (v != nullptr) v->boolean = value;
        return v != nullptr;
    }
    bool Int(int value) { return Double(value); }
    bool Uint(unsigned value) { return Double(value); }
    bool Int64(int64_t value) { return Double(static_cast<double>(value)); }
    bool Uint64(uint64_t value) { return Double(static_cast<double>(value)); }
    bool Double(double value) {
        JsonValue* v = add(Kind::kNumber);
        if (v != nullptr) v->number = value;
        return v != nullptr;
    }
    bool RawNumber(const char*, rapidjson::SizeType, bool) { return false; }
    bool String(const char* text, rapidjson::SizeType length, bool) {
        JsonValue* v = add(Kind::kString);
        if (v != nullptr) v->text.assign(text, length);
        return v != nullptr;
    }
    bool Key(const char* text, rapidjson::SizeType length, bool) {
        JsonMember member;
        member.key.assign(text, length);
        token(&member.line, &member.column);
        JsonValue& object = *open_.back();
        if (const JsonMember* first = object.find(member.key)) {
            return fail(member.line, member.column,
                        fmt::format("duplicate key `{}`; it is first given at line {}", member.key,
                                    first->line));
        }
        object.members.push_back(std::move(member));
        return true;
    }
    bool StartObject() { return start(Kind::kObject); }
    bool StartArray() { return start(Kind::kArray); }
    bool EndObject(rapidjson::SizeType) { return end(); }
    bool EndArray(rapidjson::SizeType) { return end(); }

    JsonValue& root() { return root_; }
    const std::string& error() const { return error_; }
    /// The message for a place that RapidJSON names; it lies behind every token so far.
    std::string message_at(size_t offset, const std::string& what) {
        int32_t line = 0;
        int32_t column = 0;
        positions_.find(offset, &line, &column);
        return fmt::format("{}:{}:{}: {}", name_, line, column, what);
    }

  private:
    /// The token that was just read starts at the first byte after what separates it from the one
    /// before. RapidJSON tells of brackets before it takes them, and of other tokens after.
    void token(int32_t* line, int32_t* column) {
        size_t start = last_end_;
        while (start < text_.size() &&
               std::string_view(" \t\r\n,:]}").find(text_[start]) != std::string_view::npos) {
            ++start;
        }
        last_end_ = std::max(stream_.Tell(), start);
        positions_.find(start, line, column);
    }
    bool fail(int32_t line, int32_t column, const std::string& what) {
        error_ = fmt::format("{}:{}:{}: {}", name_, line, column, what);
        return false;
    }
    JsonValue* add(Kind kind) {
        JsonValue fresh;
        fresh.kind = kind;
        token(&fresh.line, &fresh.column);
        if (++values_ > kMostValues) {
            fail(fresh.line, fresh.column, fmt::format("more than {} values", kMostValues));
            return nullptr;
        }
        if (open_.empty()) {
            root_ = std::move(fresh);
            return &root_;
        }
        JsonValue& parent = *open_.back();
        if (parent.is(Kind::kArray)) {
            parent.items.push_back(std::move(fresh));
            return &parent.items.back();
        }
        parent.members.back().value = std::move(fresh);
        return &parent.members.back().value;
    }
    bool start(Kind kind) {
        JsonValue* v = add(kind);
        if (v == nullptr) return false;
        if (open_.size() >= kDeepest) {
            return fail(v->line, v->column,
                        fmt::format("nested more than {} levels deep", kDeepest));
        }
        ++last_end_;
        // Stays valid: a container's parent grows again only after the container is closed.
        open_.push_back(v);
        return true;
    }
    bool end() {
        open_.pop_back();
        return true;
    }

    std::string_view text_;
    const TextStream& stream_;
    const std::string& name_;
    Positions positions_;
    size_t last_end_ = 0;
    size_t values_ = 0;
    JsonValue root_;
    std::vector<JsonValue*> open_;
    std::string error_;
};

std::string lower_first(std::string text) {
    if (!text.empty() && text[0] >= 'A' && text[0] <= 'Z')
        text[0] = static_cast<char>(text[0] + 32);
    if (!text.empty() && text.back() == '.') text.pop_back();
    return text;
}

}  // namespace

const char* JsonValue::kind_name() const {
    switch (kind) {
        case Kind::kNull:
            return "null";
        case Kind::kBool:
            return "a boolean";
        case Kind::kNumber:
            return "a number";
        case Kind::kString:
            return "a string";
        case Kind::kArray:
            return "an array";
        case Kind::kObject:
            return "an object";
    }
    return "nothing";
}

const JsonMember* JsonValue::find(std::string_view key) const {
    const auto it = std::find_if(members.begin(), members.end(),
                                 [&](const JsonMember& m) { return m.key == key; });
    return it == members.end() ? nullptr : &*it;
}

Result<JsonValue> parse_json(std::string_view text, const std::string& name) {
    constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
    if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
    if (const size_t nul = text.find('\0'); nul != std::string_view::npos) {
        int32_t line = 0;
        int32_t column = 0;
        Positions(text).find(nul, &line, &column);
        return user_error(
            fmt::format("{}:{}:{}: a zero byte; the file is not text", name, line, column));
    }
    TextStream stream(text);
    TreeBuilder builder(text, stream, name);
    rapidjson::Reader reader;
    // Iterative: depth costs heap, which the builder limits, and not stack.
    constexpr unsigned kFlags = rapidjson::kParseIterativeFlag |
                                rapidjson::kParseFullPrecisionFlag |
                                rapidjson::kParseValidateEncodingFlag;
    const rapidjson::ParseResult parsed = reader.Parse<kFlags>(stream, builder);
    if (!builder.error().empty()) return user_error(builder.error());
    if (parsed.IsError()) {
        const char* what = rapidjson::GetParseError_En(parsed.Code());
        return user_error(
            builder.message_at(parsed.Offset(), "not valid JSON; " + lower_first(what)));
    }
    return std::move(builder.root());
}

Result<std::string> read_text_file(const std::filesystem::path& file, size_t limit,
                                   const std::vector<std::filesystem::path>& roots) {
    const Result<InputFile> opened = InputFile::open(file, roots);
    Result<std::string> text =
        opened ? opened->read_all(static_cast<int64_t>(limit)) : opened.error();
    if (!text) {
        return Error{text.error().code,
                     fmt::format("cannot read {}: {}", file.string(), text.error().message)};
    }
    return text;
}

}  // namespace openfab::scene
