// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "base/json.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>
#include <optional>
#include <unordered_map>

#include "base/input_file.h"
#include "base/keyed_hash.h"
#include "base/messages.h"
#include "base/plain_text.h"
#include "base/scan_number.h"
#include "base/text.h"

namespace openfab {
namespace {

using Kind = JsonValue::Kind;

constexpr size_t kDeepest = 32;

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

void append_utf8(uint32_t code, std::string* into) {
    const int more = code < 0x80 ? 0 : code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
    const uint32_t lead = more == 0 ? 0 : (0xFF00u >> (more + 1)) & 0xFF;
    *into += static_cast<char>(lead | code >> 6 * more);
    for (int i = more - 1; i >= 0; --i)
        *into += static_cast<char>(0x80 | (code >> 6 * i & 0x3F));
}

/// Reads a tree by recursive descent.
class TreeReader {
  public:
    TreeReader(std::string_view text, const std::string& name, int64_t memory_bytes,
               size_t most_values)
        : text_(text),
          name_(name),
          positions_(text),
          memory_left_(memory_bytes - static_cast<int64_t>(text.size())),
          most_values_(most_values) {}

    Result<JsonValue> read() {
        JsonValue root;
        if (read_value(&root)) {
            skip_blanks();
            if (at_ < text_.size()) refuse(messages::kExpectedFileEnd);
        }
        if (error_) return *error_;
        return root;
    }

  private:
    static constexpr std::string_view kBlanks = " \t\r\n";
    static constexpr std::string_view kInNumber = "0123456789+-.eE";
    /// Objects of up to so many keys are searched linearly for duplicates, larger ones by hash.
    static constexpr size_t kFewKeys = 16;

    void skip_blanks() { at_ = std::min(text_.find_first_not_of(kBlanks, at_), text_.size()); }
    /// Takes a mark after blanks, if it is there.
    bool take(char mark) {
        skip_blanks();
        if (at_ == text_.size() || text_[at_] != mark) return false;
        ++at_;
        return true;
    }
    bool fail(int32_t line, int32_t column, const std::string& what, const std::string& help) {
        error_ = error_at({name_, line, column}, what, help);
        return false;
    }
    bool fail(size_t offset, const std::string& what, const std::string& help) {
        int32_t line = 0;
        int32_t column = 0;
        // From the start: the place may be before the last value.
        Positions(text_).find(offset, &line, &column);
        return fail(line, column, what, help);
    }
    /// Says what stands here, which is not what was expected.
    bool refuse(const std::string& expected) {
        const std::string_view rest = text_.substr(at_);
        const size_t before = text_.substr(0, at_).find_last_not_of(kBlanks);
        if ((rest.starts_with('}') || rest.starts_with(']')) && before != std::string_view::npos &&
            text_[before] == ',')
            return fail(before, messages::kNotJson, fmt::format(messages::kCommaAtEnd, rest[0]));
        if (rest.starts_with("//") || rest.starts_with("/*") || rest.starts_with('#'))
            return fail(at_, messages::kNotJsonComments, messages::kNotJsonCommentsHelp);
        if (rest.starts_with('\'')) return fail(at_, messages::kNotJson, messages::kDoubleQuotes);
        if (rest.empty())
            return fail(at_, messages::kNotJson, fmt::format(messages::kFileEndsBefore, expected));
        const size_t word = std::min(rest.find_first_of(" \t\r\n,:[]{}\""), rest.size());
        return fail(at_, messages::kNotJson,
                    fmt::format(messages::kOtherExpected,
                                rest.substr(0, std::clamp<size_t>(word, 1, 40)), expected));
    }

    bool read_value(JsonValue* value) {
        skip_blanks();
        const std::string_view rest = text_.substr(at_);
        const char first = rest.empty() ? '\0' : rest[0];
        if (first == '{' || first == '[') return read_items(value, first);
        if (first == '"') {
            return begin(value, Kind::kString) && read_string(&value->text) &&
                   take_memory(*value, value->text.size());
        }
        if (first == '-' || (first >= '0' && first <= '9'))
            return begin(value, Kind::kNumber) && read_number(value);
        for (const std::string_view word : {"null", "true", "false"}) {
            if (!rest.starts_with(word)) continue;
            if (!begin(value, word[0] == 'n' ? Kind::kNull : Kind::kBool)) return false;
            value->boolean = word[0] == 't';
            at_ += word.size();
            return true;
        }
        return refuse(messages::kExpectedValue);
    }

    /// Counts a value that begins here.
    bool begin(JsonValue* value, Kind kind) {
        value->kind = kind;
        positions_.find(at_, &value->line, &value->column);
        if (++values_ > most_values_) {
            return fail(value->line, value->column,
                        fmt::format(messages::kTooManyValues, most_values_), {});
        }
        // Vectors double their capacity, and old and new coexist while they grow.
        return take_memory(*value, 3 * sizeof(JsonMember));
    }
    bool take_memory(const JsonValue& value, size_t bytes) {
        memory_left_ -= static_cast<int64_t>(bytes);
        return memory_left_ >= 0 ||
               fail(value.line, value.column, fmt::format(messages::kValuesTakeTooMuch, values_),
                    messages::kAllowMoreMemory);
    }

    bool read_number(JsonValue* value) {
        const size_t end = std::min(text_.find_first_not_of(kInNumber, at_), text_.size());
        const std::string_view number = text_.substr(at_, end - at_);
        const auto is_digit = [&](size_t i) {
            return i < number.size() && number[i] >= '0' && number[i] <= '9';
        };
        const size_t first = number[0] == '-' ? 1 : 0;
        if (number.substr(first).starts_with('0') && is_digit(first + 1))
            return fail(at_, messages::kNotJson, messages::kLeadingZero);
        const size_t point = number.find('.');
        Decimal kind = read_decimal(number, &value->number);
        if (!is_digit(first) || (point != std::string_view::npos && !is_digit(point + 1)))
            kind = Decimal::kNoNumber;
        const std::string_view shown = number.substr(0, 40);
        if (kind == Decimal::kNoNumber)
            return fail(at_, messages::kNotJson, fmt::format(messages::kNotANumber, shown));
        if (kind == Decimal::kTooLarge) {
            const char* cut = shown.size() < number.size() ? "…" : "";
            return fail(at_, fmt::format(messages::kNumberTooLarge, shown, cut),
                        messages::kLargestNumber);
        }
        value->is_whole = number.find_first_of(".eE") == std::string_view::npos;
        at_ = end;
        return true;
    }

    bool read_string(std::string* into) {
        const size_t start = at_++;
        const auto wrong = [&](size_t offset, const std::string& what) {
            return fail(offset, messages::kNotJson, fmt::format(messages::kInString, what));
        };
        const auto is_plain = [](char c) { return c >= ' ' && c != '"' && c != '\\'; };
        while (at_ < text_.size()) {
            const size_t from = at_;
            while (at_ < text_.size() && is_plain(text_[at_]))
                ++at_;
            into->append(text_.substr(from, at_ - from));
            if (at_ == text_.size()) break;
            const size_t special = at_;
            const char c = text_[at_];
            const size_t bytes = code_point_bytes(text_.substr(at_));
            at_ += std::max<size_t>(bytes, 1);
            if (c == '"') return true;
            if (bytes == 0) return wrong(special, messages::kNotUtf8InString);
            if (bytes > 1) {
                into->append(text_.substr(special, bytes));
            } else if (c != '\\') {
                return wrong(special, fmt::format(messages::kControlInString, int{c}));
            } else if (!read_escape(into)) {
                return wrong(special, messages::kEscapeInString);
            }
        }
        return fail(start, messages::kNotJson, messages::kNoClosingQuote);
    }
    /// Reads what follows a backslash.
    bool read_escape(std::string* into) {
        constexpr std::string_view kLetters = "\"\\/bfnrt", kMeant = "\"\\/\b\f\n\r\t";
        if (at_ == text_.size()) return false;
        const char letter = text_[at_++];
        if (const size_t which = kLetters.find(letter); which != std::string_view::npos) {
            *into += kMeant[which];
            return true;
        }
        uint32_t code = 0;
        if (letter != 'u' || !read_hex(&code)) return false;
        if (code >= 0xD800 && code < 0xDC00) {
            uint32_t low = 0;
            if (text_.substr(at_, 2) != "\\u") return false;
            at_ += 2;
            if (!read_hex(&low) || low < 0xDC00 || low > 0xDFFF) return false;
            code = 0x10000 + ((code - 0xD800) << 10) + (low - 0xDC00);
        } else if (code >= 0xDC00 && code < 0xE000) {
            return false;
        }
        append_utf8(code, into);
        return true;
    }
    bool read_hex(uint32_t* code) {
        const std::string_view digits = text_.substr(at_, 4);
        const char* end = digits.data() + digits.size();
        at_ += digits.size();
        return digits.size() == 4 && std::from_chars(digits.data(), end, *code, 16).ptr == end;
    }

    bool read_items(JsonValue* value, char mark) {
        if (!begin(value, mark == '{' ? Kind::kObject : Kind::kArray)) return false;
        if (++depth_ > kDeepest) {
            return fail(value->line, value->column, fmt::format(messages::kNestedTooDeep, kDeepest),
                        {});
        }
        ++at_;
        const bool read = mark == '{' ? read_members(value) : read_elements(value);
        --depth_;
        return read;
    }
    bool read_elements(JsonValue* array) {
        if (take(']')) return true;
        do {
            if (!read_value(&array->items.emplace_back())) return false;
        } while (take(','));
        return take(']') || refuse(messages::kExpectedItemEnd);
    }
    bool read_members(JsonValue* object) {
        if (take('}')) return true;
        std::unordered_map<std::string, size_t, KeyedHash> indices;  // of many keys
        do {
            skip_blanks();
            if (!text_.substr(at_).starts_with('"')) return refuse(messages::kExpectedKey);
            JsonMember member;
            positions_.find(at_, &member.line, &member.column);
            if (!read_string(&member.key)) return false;
            if (const JsonMember* first = same_key(*object, member.key, &indices)) {
                return fail(member.line, member.column,
                            fmt::format(messages::kDuplicateKey, member.key),
                            fmt::format(messages::kDuplicateKeyHelp, first->line));
            }
            memory_left_ -= static_cast<int64_t>(member.key.size());
            if (!take(':')) return refuse("`:`");
            object->members.push_back(std::move(member));
            if (!read_value(&object->members.back().value)) return false;
        } while (take(','));
        if (!take('}')) return refuse(messages::kExpectedMemberEnd);
        sort_keys(object);
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
    static const JsonMember* same_key(const JsonValue& object, const std::string& key,
                                      std::unordered_map<std::string, size_t, KeyedHash>* indices) {
        const std::vector<JsonMember>& members = object.members;
        if (members.size() < kFewKeys) return object.find(key);
        for (size_t i = indices->size(); i < members.size(); ++i)
            indices->emplace(members[i].key, i);
        const auto known = indices->find(key);
        return known == indices->end() ? nullptr : &members[known->second];
    }

    std::string_view text_;
    const std::string& name_;
    Positions positions_;
    int64_t memory_left_;
    const size_t most_values_;
    size_t at_ = 0;
    size_t values_ = 0;
    size_t depth_ = 0;
    std::optional<Error> error_;
};

}  // namespace

std::optional<int64_t> JsonValue::whole() const {
    constexpr double kExact = 9e15;
    if (!is_whole || std::abs(number) > kExact) return {};
    return static_cast<int64_t>(number);
}

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

Result<JsonValue> parse_json(std::string_view text, const std::string& name, int64_t memory_bytes,
                             size_t most_values) {
    if (const Complaint wide = not_utf8(text); !wide.empty()) return wide.at({name, 1, 1});
    if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
    if (const size_t nul = text.find('\0'); nul != std::string_view::npos) {
        int32_t line = 0;
        int32_t column = 0;
        Positions(text).find(nul, &line, &column);
        return error_at({name, line, column}, messages::kZeroByte, messages::kZeroByteHelp);
    }
    return TreeReader(text, name, memory_bytes, most_values).read();
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
