// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/mutations/move_elements.h"

#include <cctype>
#include <string_view>
#include <vector>

namespace openfab::testing {

namespace {

/// What may be moved, and where something may be put; a member of an object fits into objects alone, an item into lists.
struct Child {
    size_t begin = 0, end = 0;
    char in = 0;  ///< `{`, `[` or `<`
};
struct Place {
    size_t at = 0;
    char of = 0;
    bool empty = false;
};
struct Structure {
    std::vector<Child> children;
    std::vector<Place> places;
};

Structure structure_of_xml(std::string_view text) {
    Structure out;
    std::vector<size_t> open;
    for (size_t at = text.find('<'); at != std::string_view::npos; at = text.find('<', at)) {
        const std::string_view rest = text.substr(at);
        const char* close = rest.starts_with("<!--")        ? "-->"
                            : rest.starts_with("<![CDATA[") ? "]]>"
                                                            : ">";
        const size_t end = text.find(close, at);
        if (end == std::string_view::npos) break;
        const size_t after = end + std::string_view(close).size();
        const bool is_tag =
            rest.size() > 1 && (rest[1] == '/' || rest[1] == '_' ||
                                std::isalpha(static_cast<unsigned char>(rest[1])) != 0);
        if (is_tag && rest[1] == '/') {
            if (!open.empty()) {
                out.children.push_back({open.back(), after, '<'});
                open.pop_back();
            }
        } else if (is_tag && text[end - 1] == '/') {
            out.children.push_back({at, after, '<'});
        } else if (is_tag) {
            open.push_back(at);
            out.places.push_back({after, '<'});
        }
        at = after;
    }
    // The root stays where it is.
    if (!out.children.empty()) out.children.pop_back();
    return out;
}

Structure structure_of_json(std::string_view text) {
    Structure out;
    std::vector<std::pair<char, size_t>>
        open;  // of each list or object, and where its current child begins
    const auto end_child = [&](size_t at) {
        if (open.empty()) return;
        size_t begin = open.back().second;
        while (begin < at && std::isspace(static_cast<unsigned char>(text[begin])) != 0)
            ++begin;
        while (at > begin && std::isspace(static_cast<unsigned char>(text[at - 1])) != 0)
            --at;
        if (begin < at) out.children.push_back({begin, at, open.back().first});
    };
    for (size_t at = 0; at < text.size(); ++at) {
        const char c = text[at];
        if (c == '"') {
            for (++at; at < text.size() && text[at] != '"'; ++at)
                at += text[at] == '\\' ? 1 : 0;
        } else if (c == '{' || c == '[') {
            open.emplace_back(c, at + 1);
            const size_t next = text.find_first_not_of(" \t\r\n", at + 1);
            const bool empty =
                next != std::string_view::npos && (text[next] == '}' || text[next] == ']');
            out.places.push_back({at + 1, c, empty});
        } else if (c == ',') {
            end_child(at);
            if (!open.empty()) open.back().second = at + 1;
        } else if (c == '}' || c == ']') {
            end_child(at);
            if (!open.empty()) open.pop_back();
        }
    }
    return out;
}

Structure structure_of(std::string_view text) {
    const size_t first = text.find_first_not_of(" \t\r\n");
    if (first == std::string_view::npos) return {};
    if (text[first] == '<') return structure_of_xml(text);
    if (text[first] == '{' || text[first] == '[') return structure_of_json(text);
    return {};
}

/// Removes a child, and of JSON one of the commas beside it.
void cut(std::string* text, const Child& child) {
    size_t begin = child.begin, end = child.end;
    if (child.in != '<') {
        const size_t next = text->find_first_not_of(" \t\r\n", end);
        const size_t before =
            begin == 0 ? std::string::npos : text->find_last_not_of(" \t\r\n", begin - 1);
        if (next != std::string::npos && (*text)[next] == ',')
            end = next + 1;
        else if (before != std::string::npos && (*text)[before] == ',')
            begin = before;
    }
    text->erase(begin, end - begin);
}

/// Puts a child into one of the places where it may be.
void put(std::string* text, const std::string& child, char in, std::mt19937_64* random) {
    std::vector<Place> fitting;
    for (const Place& place : structure_of(*text).places) {
        if (place.of == in) fitting.push_back(place);
    }
    if (fitting.empty()) return;
    const Place& place = fitting[(*random)() % fitting.size()];
    text->insert(place.at, in == '<' || place.empty ? child : child + ",");
}

/// Puts a child into one of its own kind, a few times.
std::string nested(const std::string& child, char in, size_t times) {
    std::string out = child;
    for (size_t i = 0; i < times; ++i) {
        if (in == '[') {
            out = "[" + out + "]";
        } else if (in == '{') {
            const size_t key = child.find(':');
            out = child.substr(0, key) + ": {" + out + "}";
        } else {
            const size_t tag = child.find('>');
            if (child[tag - 1] == '/') {
                const std::string name = child.substr(1, child.find_first_of(" \t\r\n/>", 1) - 1);
                out = child.substr(0, tag - 1) + ">" + out + "</" + name + ">";
            } else {
                out = child.substr(0, tag + 1) + out + child.substr(tag + 1);
            }
        }
    }
    return out;
}

}  // namespace

bool move_element(std::string* text, std::mt19937_64* random) {
    const Structure structure = structure_of(*text);
    if (structure.children.empty()) return false;
    const Child child = structure.children[(*random)() % structure.children.size()];
    const std::string piece = text->substr(child.begin, child.end - child.begin);
    switch ((*random)() % 4) {
        case 0:
            put(text, piece, child.in, random);
            break;
        case 1:
            text->replace(child.begin, piece.size(), nested(piece, child.in, 1 + (*random)() % 3));
            break;
        default:
            cut(text, child);
            put(text, piece, child.in, random);
    }
    return true;
}

}  // namespace openfab::testing
