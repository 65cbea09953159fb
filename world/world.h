// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

// A fab world as written in `NAME.fab.json`, checked for form and references, with its meshes
// loaded. It knows no compiled fablets: runtime/part/bind.h joins the two.

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/result.h"
#include "base/vec.h"
#include "mesh/model/beams.h"
#include "mesh/model/mesh.h"
#include "pieces/tree.h"
#include "world/printer.h"

namespace openfab::world {

// Keeps the locations of everything that a later check may report.

using Rgba8 = std::array<uint8_t, 4>;

struct Material {
    std::string name;
    Rgba8 key{};      ///< opaque slice colour, unique in the world
    Rgba8 preview{};  ///< colour with alpha for pictures
    double density_g_cm3 = 1.18;
    std::string channel;  ///< printer channel, may be empty
    SourceLocation location;
};

enum class Wrap : int32_t { kClamp = 0, kRepeat = 1, kMirror = 2, kBlack = 3 };
enum class Filter : int32_t { kTrilinear = 0, kAnisotropic = 1, kNearest = 2 };
enum class Space { kAuto, kSrgb, kLinear, kData };

struct Texture {
    std::string name;
    std::filesystem::path file;
    Wrap wrap = Wrap::kRepeat;    ///< of a picture along u
    Wrap wrap_v = Wrap::kRepeat;  ///< and along v; the same where the world names one
    Filter filter = Filter::kAnisotropic;
    Space space = Space::kAuto;
    bool opaque = false;     ///< without its alpha
    bool luminance = false;  ///< one channel of three, Rec. 709 weights after linearising
    /// Lowest corner and texel size of a volume; they override those of the file.
    std::optional<std::array<double, 3>> origin_mm, spacing_mm;
    /// Of a volume's file: which field, the unit of its lengths, the pitch at which it is resampled (0:
    /// left to the reader), the value where it has none and which step (texture::VolumeOptions).
    std::string field, unit;
    double pitch_mm = 0;
    std::optional<double> outside, time;
    /// Of DICOM: which segment, by label or number, and which of its frames.
    std::string segment;
    std::optional<double> echo, detector, energy_window, phase;
    /// Which of the keys that are a volume's alone the world gives, and where.
    std::vector<std::pair<std::string, SourceLocation>> of_volume;
    SourceLocation location;
};

/// A curve as bound in the world: keys, each a place and the values there.
struct Curve {
    enum class Interpolation : uint8_t { kStep, kLinear, kCubic };
    std::vector<std::vector<double>> keys;
    std::optional<Interpolation> interpolation;
};
/// Returns `step`, `linear` or `cubic`.
const char* interpolation_name(Curve::Interpolation interpolation);

/// A uniform as bound in the world: numbers, the name of a texture or material, or a curve.
struct UniformBinding {
    std::variant<std::vector<double>, std::vector<std::string>, Curve> value;
    bool boolean = false;  ///< the numbers were written as true/false
    SourceLocation location;
};
using UniformBindings = std::map<std::string, UniformBinding>;

struct FabletRef {
    std::filesystem::path source;
    std::string fablet;        ///< name of the fablet in the source
    UniformBindings uniforms;  ///< what objects have, unless they say otherwise
    SourceLocation location;   ///< of the name
    SourceLocation source_location;
};

/// A function of a module by which mixtures are dithered.
struct DitherRef {
    std::filesystem::path source;  ///< the module
    std::string rule;              ///< name of the function
    SourceLocation location;       ///< of that name
};

/// How an object is cut (pieces/tree.h), in mm of its mesh.
struct ObjectPieces {
    pieces::Tree tree;
    std::vector<pieces::Region> regions;  ///< of the pieces, then of the dowels
    SourceLocation location;
};

/// A program of the user's that makes geometry where it is asked to.
struct ProgramRef {
    struct Attribute {
        std::string name, type;  ///< `float` to `float4`, or `int`
        int32_t components = 1;
        bool is_int = false;
    };
    std::vector<std::string> command;  ///< a program and its arguments
    std::filesystem::path folder;      ///< where it runs: the world's
    std::vector<Attribute> attributes;
    std::vector<std::string> places;  ///< names of objects that it may place
    std::string version;              ///< a text that the user changes with what the program reads
    int32_t answer_ms = 60'000;
    size_t most_bytes = size_t{64} << 20;  ///< of an answer
    SourceLocation location, places_location;
};

/// The @Shape or @Grow stage of a fablet.
struct StageRef {
    std::string fablet;       ///< name in World::fablets
    SourceLocation location;  ///< of that name
};

/// What a mesh of the world stands for: itself, or what it is a box around.
using Geometry = std::variant<std::monostate, std::shared_ptr<const mesh::Beams>, StageRef,
                              std::shared_ptr<const ProgramRef>>;

/// What is asked of a geometry; each kind answers in facts_of().
struct GeometryFacts {
    const mesh::Beams* beams = nullptr;   ///< that it is
    const StageRef* stage = nullptr;      ///< that makes it
    const ProgramRef* program = nullptr;  ///< that makes it
    bool is_made = false;                 ///< it is known only once it is made
};
GeometryFacts facts_of(const Geometry& geometry);

struct Object {
    std::string name;
    int32_t mesh = 0;      ///< index in World::meshes
    std::string fablet;    ///< name in World::fablets
    int32_t priority = 0;  ///< higher wins
    double max_displacement_mm = std::numeric_limits<double>::infinity();
    UniformBindings uniforms;
    bool support = true;                         ///< support is generated below it
    std::shared_ptr<const ObjectPieces> pieces;  ///< null: it is whole
    SourceLocation location;                     ///< of its fablet's name
    SourceLocation mesh_location;
};

struct Placement {
    int32_t object = 0;  ///< index in World::objects
    Affine3d transform;  ///< mesh space (mm) to build space (mm)
    UniformBindings overrides;
    SourceLocation location;
    int32_t piece = -1;  ///< of the object's regions; -1: all of it, uncut
    /// Where its mesh is only a box around it, and a tool has asked: the boxes of what it places, as
    /// turned and scaled, less the translation, and as only scaled.
    std::optional<Box3d> extent, own_extent;
};

/// The support settings of a world.
struct SupportChoice {
    std::optional<bool> on;  ///< absent: the printer profile decides
    std::string material;    ///< a material of the world; empty: the profile's
    SourceLocation location;
};

/// The point of the printer's tray where the world's x = y = 0 is.
enum class Tray { kAnywhere, kCorner, kCenter };

struct World {
    std::filesystem::path file;
    std::map<std::string, FabletRef> fablets;
    std::vector<Material> materials;
    std::vector<Texture> textures;
    std::vector<mesh::Mesh> meshes;
    std::map<int32_t, Geometry> boxed;  ///< what meshes are boxes around, by index in meshes
    std::vector<Object> objects;
    std::vector<Placement> build;
    std::optional<DitherRef> dither;  ///< of the fablets without a rule of their own
    Tray tray = Tray::kAnywhere;
    SupportChoice support;
    std::string printer;  ///< name or file, empty where the world names none
    std::vector<std::string> warnings;
    std::vector<std::string> notes;            ///< what was assumed
    std::vector<std::filesystem::path> files;  ///< all files read, the world itself first
    /// Folders below which files may name others (base/input_file.h); empty: their own.
    std::vector<std::filesystem::path> roots;
    bool programs_allowed = false;  ///< as in FileRules

    const Geometry& geometry_of(int32_t mesh) const {
        static const Geometry kItself;
        const auto found = boxed.find(mesh);
        return found == boxed.end() ? kItself : found->second;
    }
    /// Returns the beams that a mesh stands for; null of others.
    const mesh::Beams* beams_of(int32_t mesh) const { return facts_of(geometry_of(mesh)).beams; }
    /// Returns the stage, or the program, that makes what a mesh is a box around; null of others.
    const StageRef* stage_of(int32_t mesh) const { return facts_of(geometry_of(mesh)).stage; }
    const ProgramRef* program_of(int32_t mesh) const { return facts_of(geometry_of(mesh)).program; }
    /// Whether a mesh is the box of what is known only once it is made.
    bool is_made(int32_t mesh) const { return facts_of(geometry_of(mesh)).is_made; }
};

/// Returns the box of what a placement places, by its transform, of a world that has all but its build:
/// of a shape what is solid, where its mesh is a box around that.
using ExtentOf = std::function<Result<Box3d>(const World& world, const Placement& placement)>;

constexpr size_t kLargestWorld = 256'000'000;  ///< bytes

/// Limits for reading a world.
struct FileRules {
    /// Allowed folders besides the world's own or that of its project (world_files.h).
    std::vector<std::filesystem::path> allowed = {};
    /// Memory for reading the world and for its meshes; more is an error.
    int64_t memory_bytes = mesh::kDefaultReadingBytes;
    /// Whether programs that it names may run. Reading it runs none.
    bool programs = false;
    /// By what solids are put on the bed, in grids and in rows whose mesh is only a box around them;
    /// without it, by that box.
    ExtentOf extent_of = nullptr;
};

/// Makes rules of folders, of which one may be kProgramsWord.
FileRules rules_of(const std::vector<std::string>& allow,
                   int64_t memory_bytes = mesh::kDefaultReadingBytes);

/// Whether load_world reads files of meshes. Without them these meshes are empty, placements that go
/// by their boxes are wrong, and World::files lacks what they name: enough for what is compiled of a
/// world, with all of its own mistakes.
enum class MeshFiles { kRead, kSkip };

/// Reads a world and the meshes it names. Every error has a location.
Result<World> load_world(const std::filesystem::path& file, const FileRules& rules = {},
                         MeshFiles mesh_files = MeshFiles::kRead);

}  // namespace openfab::world
