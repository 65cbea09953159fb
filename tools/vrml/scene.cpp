// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "tools/vrml/scene.h"

#include <Inventor/SoDB.h>
#include <Inventor/SoInput.h>
#include <Inventor/SoPrimitiveVertex.h>
#include <Inventor/VRMLnodes/SoVRMLColor.h>
#include <Inventor/VRMLnodes/SoVRMLElevationGrid.h>
#include <Inventor/VRMLnodes/SoVRMLImageTexture.h>
#include <Inventor/VRMLnodes/SoVRMLInline.h>
#include <Inventor/VRMLnodes/SoVRMLMovieTexture.h>
#include <Inventor/VRMLnodes/SoVRMLPixelTexture.h>
#include <Inventor/VRMLnodes/SoVRMLShape.h>
#include <Inventor/VRMLnodes/SoVRMLText.h>
#include <Inventor/actions/SoCallbackAction.h>
#include <Inventor/elements/SoLazyElement.h>
#include <Inventor/errors/SoReadError.h>
#include <Inventor/fields/SoSFBool.h>
#include <Inventor/nodes/SoAsciiText.h>
#include <Inventor/nodes/SoComplexity.h>
#include <Inventor/nodes/SoSeparator.h>
#include <Inventor/nodes/SoShape.h>
#include <Inventor/nodes/SoTexture2.h>
#include <Inventor/nodes/SoWWWInline.h>
#include <fmt/format.h>

#include <cmath>
#include <system_error>

#include "base/text.h"
#include "tools/vrml/messages.h"

namespace openfab::tools {

namespace {

namespace fs = std::filesystem;

/// What the library says while it reads; it is asked once a process.
std::string* said = nullptr;

void keep_error(const SoError* error, void*) {
    if (said != nullptr && said->empty()) *said = error->getDebugString().getString();
}

Vec3d position_of(const SbVec3f& v) {
    return {static_cast<double>(v[0]), static_cast<double>(v[1]), static_cast<double>(v[2])};
}

class Collector {
  public:
    explicit Collector(fs::path folder) : folder_(std::move(folder)) {}

    Scene scene;
    int64_t triangles = 0, lines = 0, inlines = 0, pixels = 0, texts = 0, beyond_colors = 0;

    void visit(SoNode* root) {
        SoCallbackAction action;
        action.addPreCallback(SoNode::getClassTypeId(), begin, this);
        action.addPostCallback(SoNode::getClassTypeId(), end, this);
        action.addTriangleCallback(SoShape::getClassTypeId(), triangle, this);
        action.addLineSegmentCallback(
            SoShape::getClassTypeId(),
            [](void* self, SoCallbackAction*, const SoPrimitiveVertex*, const SoPrimitiveVertex*) {
                ++static_cast<Collector*>(self)->lines;
            },
            this);
        action.addPointCallback(
            SoShape::getClassTypeId(),
            [](void* self, SoCallbackAction*, const SoPrimitiveVertex*) {
                ++static_cast<Collector*>(self)->lines;
            },
            this);
        action.apply(root);
    }

  private:
    /// What holds for the nodes that follow in a group.
    struct Level {
        const SoNode* node = nullptr;
        std::string name, picture;
        bool clamps = false;
    };

    /// Colours of an elevation grid, which the library does not have.
    struct Grid {
        bool by_vertex = true;
        int64_t columns = 0;
        float x_step = 1, z_step = 1;
        std::vector<std::array<float, 3>> colors;
    };

    static constexpr int64_t kMostTriangles = 50'000'000;

    static SoCallbackAction::Response begin(void* self, SoCallbackAction*, const SoNode* node) {
        static_cast<Collector*>(self)->enter(node);
        // The library may have read the file that it names.
        const bool is_inline = node->isOfType(SoVRMLInline::getClassTypeId()) ||
                               node->isOfType(SoWWWInline::getClassTypeId());
        const bool is_flat = node->isOfType(SoVRMLText::getClassTypeId()) ||
                             node->isOfType(SoAsciiText::getClassTypeId());
        return is_inline || is_flat ? SoCallbackAction::PRUNE : SoCallbackAction::CONTINUE;
    }
    static SoCallbackAction::Response end(void* self, SoCallbackAction*, const SoNode* node) {
        std::vector<Level>& levels = static_cast<Collector*>(self)->levels_;
        if (levels.size() > 1 && levels.back().node == node) levels.pop_back();
        return SoCallbackAction::CONTINUE;
    }

    void enter(const SoNode* node) {
        const std::string name = node->getName().getString();
        const bool scopes = node->isOfType(SoSeparator::getClassTypeId()) ||
                            node->isOfType(SoVRMLShape::getClassTypeId()) || !name.empty();
        if (scopes) {
            Level level = levels_.back();
            level.node = node;
            if (!name.empty()) level.name = name;
            levels_.push_back(std::move(level));
        }
        if (node->isOfType(SoVRMLImageTexture::getClassTypeId())) {
            const auto* const texture = static_cast<const SoVRMLImageTexture*>(node);
            std::vector<std::string> names;
            for (int i = 0; i < texture->url.getNum(); ++i)
                names.emplace_back(texture->url[i].getString());
            set_picture(names, !texture->repeatS.getValue() && !texture->repeatT.getValue());
        } else if (node->isOfType(SoTexture2::getClassTypeId())) {
            const auto* const texture = static_cast<const SoTexture2*>(node);
            set_picture({texture->filename.getValue().getString()},
                        texture->wrapS.getValue() == SoTexture2::CLAMP &&
                            texture->wrapT.getValue() == SoTexture2::CLAMP);
        } else if (node->isOfType(SoVRMLPixelTexture::getClassTypeId()) ||
                   node->isOfType(SoVRMLMovieTexture::getClassTypeId())) {
            ++pixels;
        } else if (node->isOfType(SoVRMLText::getClassTypeId()) ||
                   node->isOfType(SoAsciiText::getClassTypeId())) {
            ++texts;
        } else if (node->isOfType(SoVRMLInline::getClassTypeId()) ||
                   node->isOfType(SoWWWInline::getClassTypeId())) {
            ++inlines;
        }
        if (node->isOfType(SoShape::getClassTypeId())) begin_shape(*node);
    }

    /// A texture counts for what follows in the group around it, a shape's own too.
    /// Of several names, the first that is there counts.
    void set_picture(const std::vector<std::string>& urls, bool clamps) {
        if (urls.empty() || urls[0].empty()) return;
        std::string found;
        for (const std::string& url : urls) {
            if (url.empty() || !found.empty()) continue;
            const fs::path name = fs::path(url).lexically_normal();
            std::error_code ignored;
            const bool below = name.is_relative() && *name.begin() != "..";
            if (below && fs::is_regular_file(folder_ / name, ignored)) found = name.string();
        }
        if (found.empty())
            scene.notes.push_back(
                fmt::format(messages::kPictureElsewhere, folder_.string(), printable(urls[0])));
        levels_.back().picture = found;
        levels_.back().clamps = clamps;
        // A named texture is a level of its own, which ends with it.
        for (size_t i = levels_.size() - 1; i > 0; --i) {
            const SoNode* const node = levels_[i].node;
            levels_[i].picture = found;
            levels_[i].clamps = clamps;
            if (node->isOfType(SoSeparator::getClassTypeId()) ||
                node->isOfType(SoVRMLShape::getClassTypeId()))
                return;
        }
        levels_[0].picture = found;
        levels_[0].clamps = clamps;
    }

    void begin_shape(const SoNode& node) {
        const SoField* const field = node.getField("ccw");
        clockwise_ = field != nullptr && field->isOfType(SoSFBool::getClassTypeId()) &&
                     !static_cast<const SoSFBool*>(field)->getValue();
        scene.shapes.emplace_back();
        scene.shapes.back().name = levels_.back().name;
        scene.shapes.back().picture = levels_.back().picture;
        scene.shapes.back().clamps = levels_.back().clamps;
        grid_ = {};
        if (node.isOfType(SoVRMLElevationGrid::getClassTypeId()))
            begin_grid(static_cast<const SoVRMLElevationGrid&>(node));
    }

    void begin_grid(const SoVRMLElevationGrid& node) {
        grid_.by_vertex = node.colorPerVertex.getValue();
        grid_.columns = node.xDimension.getValue();
        grid_.x_step = node.xSpacing.getValue();
        grid_.z_step = node.zSpacing.getValue();
        const SoNode* const colors = node.color.getValue();
        if (colors == nullptr || !colors->isOfType(SoVRMLColor::getClassTypeId())) return;
        const SoMFColor& held = static_cast<const SoVRMLColor*>(colors)->color;
        for (int i = 0; i < held.getNum(); ++i)
            grid_.colors.push_back({held[i][0], held[i][1], held[i][2]});
    }

    /// The colour of a corner by its place, or of the quadrangle that has the lowest of the three.
    std::array<float, 3> color_of_grid(const std::array<const SoPrimitiveVertex*, 3>& corners,
                                       size_t corner) {
        const auto column = [&](size_t c) {
            return std::llround(corners[c]->getPoint()[0] / grid_.x_step);
        };
        const auto row = [&](size_t c) {
            return std::llround(corners[c]->getPoint()[2] / grid_.z_step);
        };
        int64_t at = row(corner) * grid_.columns + column(corner);
        if (!grid_.by_vertex)
            at = std::min({row(0), row(1), row(2)}) * (grid_.columns - 1) +
                 std::min({column(0), column(1), column(2)});
        if (at >= 0 && at < static_cast<int64_t>(grid_.colors.size()))
            return grid_.colors[static_cast<size_t>(at)];
        ++beyond_colors;
        return {1, 1, 1};
    }

    static void triangle(void* self, SoCallbackAction* action, const SoPrimitiveVertex* a,
                         const SoPrimitiveVertex* b, const SoPrimitiveVertex* c) {
        static_cast<Collector*>(self)->add(*action, {a, b, c});
    }

    void add(const SoCallbackAction& action,
             const std::array<const SoPrimitiveVertex*, 3>& corners) {
        if (++triangles > kMostTriangles) return;
        const SbMatrix& place = action.getModelMatrix();
        const SbMatrix& of_texture = action.getTextureMatrix();
        SceneShape& shape = scene.shapes.back();
        std::array<SceneCorner, 3> made;
        for (size_t i = 0; i < 3; ++i) {
            SbVec3f at;
            place.multVecMatrix(corners[i]->getPoint(), at);
            made[i].position = position_of(at);
            SbColor ambient, diffuse, specular, emissive;
            float shine = 0, clear = 0;
            // The library looks at its colours without asking how many there are.
            const int32_t number = corners[i]->getMaterialIndex();
            const int32_t count = SoLazyElement::getInstance(action.getState())->getNumDiffuse();
            const bool held = number >= 0 && number < count;
            if (!held && grid_.colors.empty()) ++beyond_colors;
            action.getMaterial(ambient, diffuse, specular, emissive, shine, clear,
                               held ? number : 0);
            const bool glows = diffuse.length() == 0 && emissive.length() > 0;
            const SbColor& color = glows ? emissive : diffuse;
            made[i].color = {color[0], color[1], color[2]};
            if (!grid_.colors.empty()) made[i].color = color_of_grid(corners, i);
            shape.opacity = std::min(shape.opacity, 1 - clear);
            const SbVec4f& uv = corners[i]->getTextureCoords();
            SbVec4f turned;
            of_texture.multVecMatrix(uv, turned);
            const float w = turned[3] == 0 ? 1 : turned[3];
            made[i].uv = {turned[0] / w, turned[1] / w};
        }
        // What mirrors turns the order of corners, as faces that are clockwise do.
        const bool mirrors = place.det3() < 0;
        const bool clockwise = clockwise_ || action.getVertexOrdering() == SoShapeHints::CLOCKWISE;
        if (mirrors != clockwise) std::swap(made[1], made[2]);
        shape.triangles.push_back(made);
    }

    fs::path folder_;
    std::vector<Level> levels_{{}};
    bool clockwise_ = false;  ///< as the shape says of its faces
    Grid grid_;
};

}  // namespace

Result<Scene> read_scene(const fs::path& file) {
    SoDB::init();
    SoReadError::setHandlerCallback(keep_error, nullptr);
    SoError::setHandlerCallback(keep_error, nullptr);
    // Nothing is fetched from elsewhere.
    SoVRMLInline::setFetchURLCallBack([](const SbString&, void*, SoVRMLInline*) {}, nullptr);
    SoWWWInline::setFetchURLCallBack([](const SbString&, void*, SoWWWInline*) {}, nullptr);
    std::string errors;
    said = &errors;
    const auto failed = [&](const char* otherwise) {
        const bool foreign = errors.empty() || errors.find("Not a valid") != std::string::npos;
        Error error = user_error(
            fmt::format("{}: {}", file.string(),
                        foreign ? std::string(otherwise)
                                : fmt::format(messages::kCannotRead, printable(errors))));
        if (foreign) error.help = messages::kNotVrmlHelp;
        return error;
    };
    SoInput input;
    if (!input.openFile(file.c_str())) return failed(messages::kNotVrml);
    SoSeparator* const root = SoDB::readAll(&input);
    if (root == nullptr || (!input.isFileVRML1() && !input.isFileVRML2()))
        return failed(messages::kNotVrml);
    root->ref();
    // Round shapes of forty sides: a chord is 0.3 % of the radius from the arc.
    auto* const finer = new SoComplexity;
    finer->value = 1;
    root->insertChild(finer, 0);
    Collector collector(file.parent_path().empty() ? "." : file.parent_path());
    collector.visit(root);
    root->unref();
    said = nullptr;
    constexpr int64_t kMostTriangles = 50'000'000;
    if (collector.triangles > kMostTriangles)
        return user_error(fmt::format("{}: {}", file.string(),
                                      fmt::format(messages::kMoreThanTriangles, kMostTriangles)));
    Scene& scene = collector.scene;
    std::erase_if(scene.shapes, [](const SceneShape& shape) { return shape.triangles.empty(); });
    const std::string name = file.filename().string();
    if (collector.lines > 0)
        scene.notes.push_back(fmt::format(messages::kLinesLeftOut, name, collector.lines));
    if (collector.inlines > 0)
        scene.notes.push_back(fmt::format(messages::kOtherFilesLeftOut, name, collector.inlines));
    if (collector.texts > 0)
        scene.notes.push_back(fmt::format(messages::kTextsLeftOut, name, collector.texts));
    if (collector.beyond_colors > 0)
        return user_error(fmt::format("{}: {}", file.string(), messages::kNoSuchColour));
    if (collector.pixels > 0)
        scene.notes.push_back(fmt::format(messages::kPixelsLeftOut, name, collector.pixels));
    if (scene.shapes.empty())
        return user_error(fmt::format("{}: {}", file.string(), messages::kNoFaces));
    return std::move(scene);
}

}  // namespace openfab::tools
