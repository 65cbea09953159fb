// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/vrml/wavefront.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <system_error>
#include <tuple>

#include "backends/common/output_file.h"
#include "tools/vrml/messages.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

using Color = std::array<float, 3>;
/// Colour, opacity, picture, and whether it does not repeat.
using Material = std::tuple<Color, float, std::string, bool>;

/// The colour of all corners; those of a picture are under it.
bool has_one_color(const SceneShape& shape) {
    const Color& first = shape.triangles[0][0].color;
    return std::ranges::all_of(shape.triangles, [&](const std::array<SceneCorner, 3>& t) {
        return std::ranges::all_of(t, [&](const SceneCorner& c) { return c.color == first; });
    });
}

/// Blanks would end a name, and line ends the line.
std::string word(const std::string& name) {
    std::string out;
    for (const char c : name)
        out += static_cast<unsigned char>(c) > ' ' ? c : '_';
    return out;
}

class Writer {
  public:
    std::string obj, library;
    std::vector<std::string> pictures;

    void add(const SceneShape& shape, size_t number) {
        obj += fmt::format(
            "o {}\n", shape.name.empty() ? fmt::format("shape_{}", number + 1) : word(shape.name));
        const bool plain = !shape.picture.empty() || has_one_color(shape);
        const Color color =
            shape.picture.empty() && plain ? shape.triangles[0][0].color : Color{1, 1, 1};
        obj += fmt::format("usemtl {}\n",
                           material({color, shape.opacity, shape.picture, shape.clamps}));
        std::map<std::pair<std::array<double, 3>, Color>, size_t> vertices;
        std::map<std::array<float, 2>, size_t> coordinates;
        std::string faces;
        for (const std::array<SceneCorner, 3>& triangle : shape.triangles) {
            faces += "f";
            for (const SceneCorner& c : triangle) {
                const Color own = plain ? Color{} : c.color;
                const auto [v, fresh] = vertices.try_emplace(
                    {{c.position.x, c.position.y, c.position.z}, own}, vertices_);
                if (fresh) add_vertex(c, plain);
                faces += fmt::format(" {}", v->second);
                if (shape.picture.empty()) continue;
                const auto [vt, other] = coordinates.try_emplace(c.uv, coordinates_);
                if (other) {
                    ++coordinates_;
                    obj += fmt::format("vt {:.9g} {:.9g}\n", c.uv[0], c.uv[1]);
                }
                faces += fmt::format("/{}", vt->second);
            }
            faces += "\n";
        }
        obj += faces;
    }

  private:
    void add_vertex(const SceneCorner& c, bool plain) {
        ++vertices_;
        obj += fmt::format("v {:.9g} {:.9g} {:.9g}", c.position.x, c.position.y, c.position.z);
        if (!plain) obj += fmt::format(" {:.6g} {:.6g} {:.6g}", c.color[0], c.color[1], c.color[2]);
        obj += "\n";
    }

    std::string material(const Material& wanted) {
        const auto [known, fresh] =
            materials_.try_emplace(wanted, fmt::format("material_{}", materials_.size() + 1));
        if (!fresh) return known->second;
        const auto& [color, opacity, picture, clamps] = wanted;
        library += fmt::format("newmtl {}\nKd {:.6g} {:.6g} {:.6g}\nd {:.6g}\n", known->second,
                               color[0], color[1], color[2], opacity);
        if (!picture.empty()) {
            library += fmt::format("map_Kd {}{}\n", clamps ? "-clamp on " : "", picture);
            pictures.push_back(picture);
        }
        return known->second;
    }

    std::map<Material, std::string> materials_;
    size_t vertices_ = 1, coordinates_ = 1;
};

}  // namespace

Result<void> write_wavefront(const Scene& scene, const fs::path& folder, const fs::path& obj) {
    Writer writer;
    const fs::path library = fs::path(obj).replace_extension(".mtl");
    writer.obj = fmt::format("mtllib {}\n", library.filename().string());
    for (size_t i = 0; i < scene.shapes.size(); ++i)
        writer.add(scene.shapes[i], i);
    for (const std::string& picture : writer.pictures) {
        const fs::path to = obj.parent_path() / picture;
        std::error_code trouble;
        if (fs::equivalent(folder / picture, to, trouble)) continue;
        fs::create_directories(to.parent_path(), trouble);
        fs::copy_file(folder / picture, to, fs::copy_options::overwrite_existing, trouble);
        if (trouble)
            return outside_error(
                fmt::format(messages::kCannotCopy, picture, to.string(), trouble.message()));
    }
    const auto write = [](const fs::path& file, const std::string& text) {
        return backends::write_whole_file(file, text);
    };
    if (Result<void> done = write(library, writer.library); !done) return done;
    return write(obj, writer.obj);
}

}  // namespace openfab::tools
