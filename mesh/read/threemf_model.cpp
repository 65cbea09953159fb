// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh/read/threemf_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/color.h"
#include "base/scan_number.h"
#include "base/xml.h"

namespace openfab::mesh {
namespace {

constexpr int64_t kMaxId = INT32_MAX;
constexpr size_t kMaxTransform = 12;

std::string_view trimmed(std::string_view text) {
    constexpr std::string_view kBlanks = " \t\r\n";
    const size_t start = text.find_first_not_of(kBlanks);
    if (start == std::string_view::npos) return {};
    return text.substr(start, text.find_last_not_of(kBlanks) - start + 1);
}

std::vector<std::string_view> words_of(std::string_view text) {
    std::vector<std::string_view> words;
    for (text = trimmed(text); !text.empty(); text = trimmed(text)) {
        const size_t end = std::min(text.find_first_of(" \t\r\n"), text.size());
        words.push_back(text.substr(0, end));
        text.remove_prefix(end);
    }
    return words;
}

/// `#rrggbb` or `#rrggbbaa`, sRGB, to linear.
bool parse_color(std::string_view text, std::array<double, 3>* out) {
    text = trimmed(text);
    if ((text.size() != 7 && text.size() != 9) || text[0] != '#') return false;
    std::array<int, 8> digits{};
    for (size_t i = 1; i < text.size(); ++i) {
        const size_t digit = std::string_view("0123456789abcdef0123456789ABCDEF").find(text[i]);
        if (digit == std::string_view::npos) return false;
        digits[i - 1] = static_cast<int>(digit % 16);
    }
    for (size_t c = 0; c < 3; ++c)
        (*out)[c] = srgb_to_linear((digits[c * 2] * 16 + digits[c * 2 + 1]) / 255.0);
    return true;
}

class ModelReader : public XmlHandler {
  public:
    explicit ModelReader(int64_t* memory_bytes) : memory_bytes_(*memory_bytes) {}

    ThreemfModel model;

    Complaint start(std::string_view name, const XmlAttributes& a) override {
        Complaint wrong = read(name, a);
        if (wrong.empty() && memory_bytes_ < 0)
            return {"the model takes more memory than is allowed", "allow more with `--memory`"};
        return wrong;
    }

    Complaint read(std::string_view name, const XmlAttributes& a) {
        using Kind = ThreemfGroup::Kind;
        wrong_.clear();
        if (name == "vertex") return vertex(a);
        if (name == "triangle") return triangle(a);
        if (name == "tex2coord") return coordinate(a);
        if (name == "model") return root(a);
        if (name == "basematerials") return begin_group(a, Kind::kMaterials);
        if (name == "colorgroup") return begin_group(a, Kind::kColors);
        if (name == "texture2dgroup") return begin_group(a, Kind::kCoordinates);
        if (name == "compositematerials") return begin_group(a, Kind::kOther);
        if (name == "multiproperties") return begin_multi(a);
        if (name == "base") return base(a);
        if (name == "color") return color(a);
        if (name == "multi") return multi(a);
        if (name == "object") return begin_object(a);
        if (name == "component" && object_ != nullptr) return placement(a, &object_->components);
        if (name == "item") return placement(a, &model.build);
        if (name == "beamlattice") model.has_beams = true;
        return {};
    }

    void end(std::string_view name) override {
        if (name == "object") object_ = nullptr;
        if (name == "basematerials" || name == "colorgroup" || name == "texture2dgroup" ||
            name == "compositematerials" || name == "multiproperties")
            group_ = nullptr;
    }

    /// Checks that triangles refer to existing vertices; returns an error text, empty if none.
    std::string check_vertices() const {
        for (const auto& [id, object] : model.objects) {
            const auto count = static_cast<int32_t>(object.vertices.size());
            for (const ThreemfTriangle& t : object.triangles) {
                const int32_t most = std::max({t.vertices[0], t.vertices[1], t.vertices[2]});
                if (most >= count)
                    return fmt::format(
                        "a triangle of object {} refers to vertex {}, but there are {}", id, most,
                        count);
            }
        }
        return {};
    }

  private:
    /// Appends to a list and accounts for its memory: lists double, and are copied then.
    template <typename T>
    T& add(std::vector<T>* list, T value, size_t more = 0) {
        memory_bytes_ -= static_cast<int64_t>(3 * sizeof(T) + more);
        list->push_back(std::move(value));
        return list->back();
    }

    /// Accounts for the memory of a resource's map entry and name.
    template <typename T>
    void take(const std::string& name) {
        constexpr size_t kNode = 64;
        memory_bytes_ -= static_cast<int64_t>(sizeof(T) + kNode + name.size());
    }

    static Complaint too_long(const std::string& name) {
        constexpr size_t kLongest = 1000;
        if (name.size() <= kLongest) return {};
        return {fmt::format("a name of {} bytes", name.size()),
                fmt::format("at most {} are possible", kLongest)};
    }

    double number(const XmlAttributes& a, const char* key) {
        const char* text = a.find(key);
        double value = 0;
        if (text == nullptr) {
            wrong_ = fmt::format("`{}` is missing", key);
        } else if (const std::string wrong = scan_number(trimmed(text), &value); !wrong.empty()) {
            wrong_ = wrong;
        }
        return value;
    }

    int64_t integer(const XmlAttributes& a, const char* key, int64_t otherwise) {
        const char* text = a.find(key);
        if (text == nullptr) return otherwise;
        int64_t value = otherwise;
        if (const std::string wrong = scan_integer(trimmed(text), 0, kMaxId, &value);
            !wrong.empty())
            wrong_ = fmt::format("`{}`: {}", key, wrong);
        return value;
    }

    int64_t needed_integer(const XmlAttributes& a, const char* key) {
        const int64_t value = integer(a, key, -1);
        if (value < 0 && wrong_.empty()) wrong_ = fmt::format("`{}` is missing", key);
        return value;
    }

    static std::string text(const XmlAttributes& a, const char* key) {
        const char* value = a.find(key);
        return value != nullptr ? value : "";
    }

    Complaint root(const XmlAttributes& a) {
        static constexpr std::pair<std::string_view, double> kUnits[] = {
            {"micron", 0.001}, {"millimeter", 1}, {"centimeter", 10},
            {"inch", 25.4},    {"foot", 304.8},   {"meter", 1000}};
        const std::string unit = text(a, "unit");
        bool found = unit.empty();
        for (const auto& [name, size] : kUnits) {
            if (name != unit) continue;
            model.unit_mm = size;
            found = true;
        }
        if (!found) return fmt::format("unknown unit `{}`", unit.substr(0, 40));
        // Extensions that change the surface must be known; they are listed by their prefixes.
        const std::string required = text(a, "requiredextensions");
        const std::vector<std::string_view> prefixes = words_of(required);
        // Each is searched for among all attributes.
        constexpr size_t kMostExtensions = 64;
        if (prefixes.size() > kMostExtensions)
            return fmt::format("the file requires {} extensions; at most {} are possible",
                               prefixes.size(), kMostExtensions);
        for (std::string_view prefix : prefixes) {
            const char* address = a.find_exact(fmt::format("xmlns:{}", prefix));
            const std::string_view known = address != nullptr ? address : "";
            const bool fine = known.find("/material/") != std::string_view::npos ||
                              known.find("/production/") != std::string_view::npos ||
                              known.find("/trianglesets/") != std::string_view::npos;
            if (!fine)
                return {fmt::format("the file requires the extension `{}`, which is not supported",
                                    known.empty() ? prefix : known.substr(0, 120)),
                        "export it as plain meshes"};
        }
        return {};
    }

    Complaint begin_group(const XmlAttributes& a, ThreemfGroup::Kind kind) {
        const int64_t id = needed_integer(a, "id");
        if (!wrong_.empty()) return wrong_;
        const auto [it, fresh] = model.groups.try_emplace(id);
        if (!fresh) return fmt::format("a second resource with the id {}", id);
        take<ThreemfGroup>({});
        group_ = &it->second;
        group_->kind = kind;
        return {};
    }

    Complaint begin_multi(const XmlAttributes& a) {
        Complaint wrong = begin_group(a, ThreemfGroup::Kind::kMulti);
        if (wrong.empty()) wrong = integers(text(a, "pids"), &group_->layers);
        // Each triangle searches all of them.
        constexpr size_t kMaxLayers = 16;
        if (wrong.empty() && group_->layers.size() > kMaxLayers)
            return {fmt::format("multiproperties of {} layers", group_->layers.size()),
                    fmt::format("at most {} are possible", kMaxLayers)};
        return wrong;
    }

    std::string integers(std::string_view list, std::vector<int64_t>* out) {
        for (std::string_view word : words_of(list)) {
            int64_t value = 0;
            if (std::string wrong = scan_integer(word, 0, kMaxId, &value); !wrong.empty())
                return wrong;
            add(out, value);
        }
        return {};
    }

    bool in(ThreemfGroup::Kind kind) const { return group_ != nullptr && group_->kind == kind; }

    Complaint base(const XmlAttributes& a) {
        if (!in(ThreemfGroup::Kind::kMaterials)) return {};
        std::string name = text(a, "name");
        if (name.empty()) name = fmt::format("material {}", group_->names.size());
        const size_t length = name.size();
        return too_long(add(&group_->names, std::move(name), length));
    }

    Complaint color(const XmlAttributes& a) {
        if (!in(ThreemfGroup::Kind::kColors)) return {};
        std::array<double, 3> value{};
        const std::string written = text(a, "color");
        if (!parse_color(written, &value))
            return {fmt::format("`{}` is not a colour", written.substr(0, 40)),
                    "write it as #rrggbb"};
        add(&group_->values, value);
        return {};
    }

    Complaint coordinate(const XmlAttributes& a) {
        if (!in(ThreemfGroup::Kind::kCoordinates)) return {};
        add(&group_->values, {number(a, "u"), number(a, "v"), 0});
        return wrong_;
    }

    Complaint multi(const XmlAttributes& a) {
        if (!in(ThreemfGroup::Kind::kMulti)) return {};
        return integers(text(a, "pindices"), &add(&group_->picks, {}));
    }

    Complaint begin_object(const XmlAttributes& a) {
        const int64_t id = needed_integer(a, "id");
        const int64_t group = integer(a, "pid", -1);
        const int64_t property = integer(a, "pindex", 0);
        if (!wrong_.empty()) return wrong_;
        const auto [it, fresh] = model.objects.try_emplace(id);
        if (!fresh) return fmt::format("a second object with the id {}", id);
        object_ = &it->second;
        object_->name = text(a, "name");
        take<ThreemfObject>(object_->name);
        if (Complaint wrong = too_long(object_->name); !wrong.empty()) return wrong;
        if (const char* type = a.find("type")) object_->type = type;
        object_->group = group;
        object_->property = property;
        return {};
    }

    Complaint vertex(const XmlAttributes& a) {
        if (object_ == nullptr) return {};
        add(&object_->vertices, {number(a, "x"), number(a, "y"), number(a, "z")});
        return wrong_;
    }

    Complaint triangle(const XmlAttributes& a) {
        if (object_ == nullptr) return {};
        ThreemfTriangle t;
        t.vertices = {static_cast<int32_t>(needed_integer(a, "v1")),
                      static_cast<int32_t>(needed_integer(a, "v2")),
                      static_cast<int32_t>(needed_integer(a, "v3"))};
        t.group = integer(a, "pid", -1);
        t.properties[0] = integer(a, "p1", -1);
        // One for all corners unless the others have their own.
        t.properties[1] = integer(a, "p2", t.properties[0]);
        t.properties[2] = integer(a, "p3", t.properties[0]);
        add(&object_->triangles, t);
        return wrong_;
    }

    Complaint placement(const XmlAttributes& a, std::vector<ThreemfPlacement>* out) {
        ThreemfPlacement p;
        p.object = needed_integer(a, "objectid");
        p.path = text(a, "path");
        if (const char* written = a.find("transform")) {
            std::array<double, kMaxTransform> m{};
            const std::vector<std::string_view> words = words_of(written);
            if (words.size() != m.size()) return "`transform` must have 12 numbers";
            for (size_t i = 0; i < m.size(); ++i) {
                if (std::string wrong = scan_number(words[i], &m[i]); !wrong.empty()) return wrong;
            }
            // Written for row vectors: the columns of our matrix, one after another.
            p.transform = {{m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]},
                           {m[9], m[10], m[11]}};
        }
        const size_t length = p.path.size();
        add(out, std::move(p), length);
        return wrong_;
    }

    int64_t& memory_bytes_;
    std::string wrong_;
    ThreemfGroup* group_ = nullptr;    ///< the one that is open
    ThreemfObject* object_ = nullptr;  ///< the one that is open
};

}  // namespace

Result<ThreemfModel> parse_threemf_model(std::string_view text, const std::string& file,
                                         int64_t* memory_bytes) {
    ModelReader reader(memory_bytes);
    if (Result<void> parsed = parse_xml(text, file, &reader); !parsed) return parsed.error();
    if (const std::string wrong = reader.check_vertices(); !wrong.empty())
        return user_error(fmt::format("{}: {}", file, wrong));
    return std::move(reader.model);
}

}  // namespace openfab::mesh
