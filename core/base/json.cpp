// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/json.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <unordered_map>

#include "base/check.h"
#include "base/input_file.h"
#include "base/messages.h"
#include "base/plain_text.h"
#include "base/scan_number.h"

namespace openfab {
namespace {

using Kind = JsonValue::Kind;

constexpr size_t kDeepest = 32;
constexpr size_t kMostValues = 1'000'000;

/// The parser's input stream: the text and the position, which the parser does not pass to
/// handlers.
class TextIterator {
  public:
    using iterator_category = std::input_iterator_tag;
    using value_type = char;
    using difference_type = std::ptrdiff_t;
    using pointer = const char*;
    using reference = const char&;

    TextIterator(const char* at, const char** furthest) : at_(at), furthest_(furthest) {}
    reference operator*() const { return *at_; }
    TextIterator& operator++() {
        *furthest_ = ++at_;
        return *this;
    }
    TextIterator operator++(int) {
        TextIterator before = *this;
        ++*this;
        return before;
    }
    bool operator==(const TextIterator& other) const { return at_ == other.at_; }
    bool operator!=(const TextIterator& other) const { return at_ != other.at_; }

  private:
    const char* at_;
    const char** furthest_;
};

/// Converts ascending byte offsets to lines and columns.
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

/// The parser's event handler; its own conversion of numbers is not used.
class TreeBuilder {
  public:
    TreeBuilder(std::string_view text, const char** furthest, const std::string& name,
                int64_t memory_bytes)
        : text_(text),
          furthest_(furthest),
          name_(name),
          positions_(text),
          memory_left_(memory_bytes - static_cast<int64_t>(text.size())) {}

    // NOLINTBEGIN(readability-identifier-naming): the parser's names.
    bool null() { return add(Kind::kNull) != nullptr; }
    bool boolean(bool value) {
        JsonValue* v = add(Kind::kBool);
        if (v != nullptr) v->boolean = value;
        return v != nullptr;
    }
    bool number_integer(int64_t) { return number(); }
    bool number_unsigned(uint64_t) { return number(); }
    bool number_float(double, const std::string&) { return number(); }
    bool string(std::string& value) {
        JsonValue* v = add(Kind::kString, value.size());
        if (v != nullptr) v->text = std::move(value);
        return v != nullptr;
    }
    bool binary(nlohmann::json::binary_t&) { return false; }
    bool start_object(size_t) { return start(Kind::kObject); }
    bool start_array(size_t) { return start(Kind::kArray); }
    bool key(std::string& text) {
        JsonMember member;
        member.key = std::move(text);
        token(&member.line, &member.column);
        if (const JsonMember* first = same_key(member.key)) {
            return fail(member.line, member.column,
                        fmt::format(messages::kDuplicateKey, member.key),
                        fmt::format(messages::kDuplicateKeyHelp, first->line));
        }
        memory_left_ -= static_cast<int64_t>(member.key.size());
        open_.back()->members.push_back(std::move(member));
        return true;
    }
    bool end_object() { return end(); }
    bool end_array() { return end(); }
    bool parse_error(size_t read, const std::string& last, const nlohmann::json::exception& why);
    // NOLINTEND(readability-identifier-naming)

    JsonValue& root() { return root_; }
    const std::optional<Error>& error() const { return error_; }

  private:
    static constexpr std::string_view kBlanks = " \t\r\n";
    static constexpr std::string_view kInNumber = "0123456789+-.eE";
    /// Objects of up to so many keys are searched linearly for duplicates, larger ones by hash.
    static constexpr size_t kFewKeys = 16;

    /// Returns the start of the token that was just read, skipping separators after the previous
    /// one, and advances past it.
    size_t token(int32_t* line, int32_t* column) {
        const size_t start =
            std::min(text_.find_first_not_of(" \t\r\n,:]}", last_end_), text_.size());
        last_end_ = std::max(static_cast<size_t>(*furthest_ - text_.data()), start);
        positions_.find(start, line, column);
        return start;
    }
    bool fail(int32_t line, int32_t column, const std::string& what, const std::string& help = {}) {
        if (!error_) error_ = error_at({name_, line, column}, what, help);
        return false;
    }
    bool fail_at(size_t offset, const std::string& what, const std::string& help = {}) {
        int32_t line = 0;
        int32_t column = 0;
        // From the start: the location may be before the last token.
        Positions(text_).find(offset, &line, &column);
        return fail(line, column, what, help);
    }
    /// Adds a value, with text_bytes of text, located at the token that was just read.
    JsonValue* add(Kind kind, size_t text_bytes = 0, std::string_view* read = nullptr) {
        JsonValue fresh;
        fresh.kind = kind;
        const size_t start = token(&fresh.line, &fresh.column);
        if (read != nullptr) {
            // The parser reads one byte past a number to find its end.
            const size_t end = std::min(text_.find_first_not_of(kInNumber, start), text_.size());
            *read = text_.substr(start, end - start);
            last_end_ = end;
        }
        if (++values_ > kMostValues) {
            fail(fresh.line, fresh.column, fmt::format(messages::kTooManyValues, kMostValues));
            return nullptr;
        }
        // Vectors double their capacity, and old and new coexist while they grow.
        memory_left_ -= static_cast<int64_t>(text_bytes + 3 * sizeof(JsonMember));
        if (memory_left_ < 0) {
            fail(fresh.line, fresh.column, fmt::format(messages::kValuesTakeTooMuch, values_),
                 messages::kAllowMoreMemory);
            return nullptr;
        }
        if (open_.empty()) {
            root_ = std::move(fresh);
            return &root_;
        }
        JsonValue& parent = *open_.back();
        OPENFAB_CHECK(parent.is(Kind::kArray) || !parent.members.empty());
        if (parent.is(Kind::kArray)) {
            parent.items.push_back(std::move(fresh));
            return &parent.items.back();
        }
        parent.members.back().value = std::move(fresh);
        return &parent.members.back().value;
    }
    bool number() {
        std::string_view read;
        JsonValue* v = add(Kind::kNumber, 0, &read);
        if (v == nullptr) return false;
        const std::string_view digits = read.substr(read.starts_with('-') ? 1 : 0);
        if (digits.size() > 1 && digits[0] == '0' && digits[1] >= '0' && digits[1] <= '9')
            return fail(v->line, v->column, messages::kNotJson, messages::kLeadingZero);
        const Decimal kind = read_decimal(read, &v->number);
        if (kind == Decimal::kFine) return true;
        if (kind == Decimal::kTooLarge)
            return fail(v->line, v->column, too_large(read), messages::kLargestNumber);
        return fail(v->line, v->column, messages::kNotJson,
                    fmt::format(messages::kNotANumber, read.substr(0, 40)));
    }
    static std::string too_large(std::string_view read) {
        return fmt::format(messages::kNumberTooLarge, read.substr(0, 40),
                           read.size() > 40 ? "…" : "");
    }
    bool start(Kind kind) {
        JsonValue* v = add(kind);
        if (v == nullptr) return false;
        if (open_.size() >= kDeepest) {
            return fail(v->line, v->column, fmt::format(messages::kNestedTooDeep, kDeepest));
        }
        // Stays valid: a container's parent grows again only after the container is closed.
        open_.push_back(v);
        keys_.emplace_back();
        return true;
    }
    bool end() {
        OPENFAB_CHECK(!open_.empty());
        sort_keys(open_.back());
        open_.pop_back();
        keys_.pop_back();
        return true;
    }
    void sort_keys(JsonValue* object) {
        const std::vector<JsonMember>& members = object->members;
        if (members.size() < kFewKeys) return;
        memory_left_ -= static_cast<int64_t>(members.size() * sizeof(int32_t));
        object->by_key.resize(members.size());
        std::iota(object->by_key.begin(), object->by_key.end(), 0);
        std::sort(object->by_key.begin(), object->by_key.end(),
                  [&](int32_t x, int32_t y) { return members[x].key < members[y].key; });
    }
    const JsonMember* same_key(const std::string& key) {
        const std::vector<JsonMember>& members = open_.back()->members;
        if (members.size() < kFewKeys) return open_.back()->find(key);
        std::unordered_map<std::string, size_t>& indices = keys_.back();
        for (size_t i = indices.size(); i < members.size(); ++i)
            indices.emplace(members[i].key, i);
        const auto known = indices.find(key);
        return known == indices.end() ? nullptr : &members[known->second];
    }

    std::string_view text_;
    const char** furthest_;
    const std::string& name_;
    Positions positions_;
    int64_t memory_left_;
    size_t last_end_ = 0;
    size_t values_ = 0;
    JsonValue root_;
    std::vector<JsonValue*> open_;
    std::vector<std::unordered_map<std::string, size_t>> keys_;  ///< as open_: indices of its keys
    std::optional<Error> error_;
};

/// Returns what the parser expected where it stopped, from its own message.
std::string expected(std::string_view why) {
    static constexpr std::pair<std::string_view, std::string_view> kWords[] = {
        {"expected string literal", messages::kExpectedKey},
        {"expected ':'", "`:`"},
        {"expected '}'", messages::kExpectedMemberEnd},
        {"expected ']'", messages::kExpectedItemEnd},
        {"expected '[', '{', or a literal", messages::kExpectedValue},
        {"expected end of input", messages::kExpectedFileEnd},
        {"expected value", messages::kExpectedValue}};
    for (const auto& [known, ours] : kWords) {
        if (why.ends_with(known)) return std::string(ours);
    }
    return messages::kExpectedValue;
}

bool TreeBuilder::parse_error(size_t read, const std::string&,
                              const nlohmann::json::exception& why) {
    constexpr int kTooLarge = 406;
    constexpr std::string_view kMarks = ",:[]{}";
    constexpr std::string_view kInString = "invalid string: ";
    const std::string_view what = why.what();
    // The parser stopped after the token and reports no punctuation before it.
    size_t start = std::min(text_.find_first_not_of(kBlanks, last_end_), text_.size());
    while (start + 1 < read && start < text_.size() &&
           kMarks.find(text_[start]) != std::string_view::npos)
        start = std::min(text_.find_first_not_of(kBlanks, start + 1), text_.size());
    const std::string_view rest = text_.substr(start);
    const size_t word = std::min(rest.find_first_of(" \t\r\n,:[]{}\""), rest.size());
    const std::string_view shown = rest.substr(0, std::clamp<size_t>(word, 1, 40));
    if (why.id == kTooLarge)
        return fail_at(start, too_large(rest.substr(0, word)), messages::kLargestNumber);
    if (const size_t reason = what.find(kInString); reason != std::string_view::npos) {
        if (what.find("missing closing quote") != std::string_view::npos)
            return fail_at(start, messages::kNotJson, messages::kNoClosingQuote);
        const size_t from = reason + kInString.size();
        return fail_at(
            read - 1, messages::kNotJson,
            fmt::format(messages::kInString, what.substr(from, what.find("; last read") - from)));
    }
    const size_t before = text_.substr(0, start).find_last_not_of(kBlanks);
    if ((rest.starts_with('}') || rest.starts_with(']')) && before != std::string_view::npos &&
        text_[before] == ',') {
        return fail_at(before, messages::kNotJson, fmt::format(messages::kCommaAtEnd, rest[0]));
    }
    if (rest.starts_with("//") || rest.starts_with("/*") || rest.starts_with('#'))
        return fail_at(start, messages::kNotJsonComments, messages::kNotJsonCommentsHelp);
    if (rest.starts_with('\'')) return fail_at(start, messages::kNotJson, messages::kDoubleQuotes);
    if (rest.empty())
        return fail_at(start, messages::kNotJson,
                       fmt::format(messages::kFileEndsBefore, expected(what)));
    return fail_at(start, messages::kNotJson,
                   fmt::format(messages::kOtherExpected, shown, expected(what)));
}

}  // namespace

const char* JsonValue::kind_name() const {
    switch (kind) {
        case Kind::kNull:
            return "null";
        case Kind::kBool:
            return messages::kKindBoolean;
        case Kind::kNumber:
            return messages::kKindNumber;
        case Kind::kString:
            return messages::kKindString;
        case Kind::kArray:
            return messages::kKindArray;
        case Kind::kObject:
            return messages::kKindObject;
    }
    return "nothing";
}

const JsonMember* JsonValue::find(std::string_view key) const {
    // by_key is stale if members were added to the tree.
    if (!members.empty() && by_key.size() == members.size()) {
        const auto key_of = [&](int32_t index) -> std::string_view { return members[index].key; };
        const auto found = std::partition_point(by_key.begin(), by_key.end(),
                                                [&](int32_t index) { return key_of(index) < key; });
        return found != by_key.end() && key_of(*found) == key
                   ? &members[static_cast<size_t>(*found)]
                   : nullptr;
    }
    const auto it = std::find_if(members.begin(), members.end(),
                                 [&](const JsonMember& m) { return m.key == key; });
    return it == members.end() ? nullptr : &*it;
}

int64_t json_bytes(const JsonValue& value) {
    int64_t bytes = static_cast<int64_t>(sizeof value + value.text.capacity());
    // A tree is at most kDeepest levels deep.
    for (const JsonValue& item : value.items)
        bytes += json_bytes(item);
    for (const JsonMember& member : value.members) {
        bytes += json_bytes(member.value) +
                 static_cast<int64_t>(sizeof member - sizeof member.value + member.key.capacity());
    }
    bytes += static_cast<int64_t>(value.by_key.capacity() * sizeof(int32_t) +
                                  (value.items.capacity() - value.items.size()) * sizeof value +
                                  (value.members.capacity() - value.members.size()) *
                                      sizeof(JsonMember));
    return bytes;
}

Result<JsonValue> parse_json(std::string_view text, const std::string& name, int64_t memory_bytes) {
    if (const Complaint wide = not_utf8(text); !wide.empty()) return wide.at({name, 1, 1});
    if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
    if (const size_t nul = text.find('\0'); nul != std::string_view::npos) {
        int32_t line = 0;
        int32_t column = 0;
        Positions(text).find(nul, &line, &column);
        return error_at({name, line, column}, messages::kZeroByte, messages::kZeroByteHelp);
    }
    const char* furthest = text.data();
    TreeBuilder builder(text, &furthest, name, memory_bytes);
    const bool whole =
        nlohmann::json::sax_parse(TextIterator(text.data(), &furthest),
                                  TextIterator(text.data() + text.size(), &furthest), &builder);
    if (builder.error()) return *builder.error();
    if (!whole) return internal_error(fmt::format("{}: the JSON parser gave no reason", name));
    return std::move(builder.root());
}

Result<std::string> read_text_file(const std::filesystem::path& file, size_t limit,
                                   const std::vector<std::filesystem::path>& roots) {
    const Result<InputFile> opened = InputFile::open(file, roots);
    Result<std::string> text =
        opened ? opened->read_all(static_cast<int64_t>(limit)) : opened.error();
    if (!text) {
        return with_context(text.error(), fmt::format(messages::kCannotRead, file.string()));
    }
    return text;
}

}  // namespace openfab
