// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/pipeline/provenance.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "base/hash.h"
#include "runtime/dither/dither_rule.h"
#include "runtime/part/shape_stage.h"

namespace openfab::pipeline {

namespace {

/// A hasher with the kinds of lists that a print is made from.
class Hash : public Hasher {
  public:
    using Hasher::add;
    void add(const Vec3d& v) { add(v.x), add(v.y), add(v.z); }
    void add(const std::string& text) { add_text(text); }
    template <typename T>
    void add_all(const T& list) {
        add(list.size());
        for (const auto& value : list)
            add(value);
    }
    /// Hashes a value in one call.
    template <typename T>
    void add_all(const std::vector<Vec3<T>>& list) {
        static_assert(sizeof(Vec3<T>) == 3 * sizeof(T));
        add(list.size());
        add_bytes(list.data(), list.size() * sizeof list[0]);
    }
    std::string text() const { return fmt::format("{:016x}", value()); }
};

void add_floats(Hash* hash, std::span<const float> values) {
    hash->add(values.size());
    hash->add_bytes(values.data(), values.size_bytes());
}

uint64_t hash_of(const part::PartMesh& mesh) {
    Hash hash;
    hash.add_all(mesh.positions);
    hash.add(mesh.triangles.size());
    hash.add_bytes(mesh.triangles.data(), mesh.triangles.size() * sizeof mesh.triangles[0]);
    hash.add(mesh.center_part_mm);
    for (const auto* attributes : {&mesh.inputs, &mesh.nearest_attributes}) {
        hash.add(attributes->size());
        for (const part::PartAttribute& attribute : *attributes) {
            hash.add(static_cast<int32_t>(attribute.scalar));
            hash.add(attribute.components);
            add_floats(&hash, attribute.corner_values);
            hash.add_all(attribute.face_values);
        }
    }
    hash.add_all(mesh.corner_normals);
    add_floats(&hash, mesh.corner_uv);
    return hash.value();
}

uint64_t hash_of(const mesh::Beams& beams) {
    Hash hash;
    hash.add_all(beams.nodes);
    hash.add(beams.beams.size());
    for (const mesh::Beam& beam : beams.beams) {
        for (size_t e = 0; e < 2; ++e) {
            hash.add(beam.nodes[e]);
            hash.add(beam.radii[e]);
            hash.add(static_cast<int32_t>(beam.ends[e]));
        }
    }
    for (const mesh::BeamAttribute& attribute : beams.attributes) {
        hash.add(attribute.name);
        add_floats(&hash, attribute.values);
        hash.add_all(attribute.ints);
    }
    return hash.value();
}

void add_shape(Hash* hash, const pieces::Shape& shape) {
    hash->add(static_cast<int32_t>(shape.kind));
    for (const Vec3d& v : {shape.at, shape.u, shape.v, shape.n})
        hash->add(v);
    for (const double size :
         {shape.radius, shape.lo, shape.hi, shape.half_width, shape.slope, shape.half_length})
        hash->add(size);
    hash->add(shape.strokes.size());
    for (const auto& stroke : shape.strokes) {
        for (const double at : stroke)
            hash->add(at);
    }
}

void add_piece(Hash* hash, const part::Piece& piece) {
    const pieces::Region& region = piece.region;
    hash->add(int32_t{region.shapes_only});
    hash->add(region.sides.size());
    for (const pieces::Side& side : region.sides) {
        hash->add(side.normal);
        hash->add(side.offset);
        hash->add(int32_t{side.front});
    }
    for (const auto* shapes : {&region.added, &region.removed}) {
        hash->add(shapes->size());
        for (const pieces::Shape& shape : *shapes)
            add_shape(hash, shape);
    }
    for (const pieces::Filled& filled : region.filled)
        add_shape(hash, filled.shape);
    hash->add_all(piece.filled_codes);
}

/// The finest level determines the others.
uint64_t hash_of(const texture::Pyramid& pyramid) {
    Hash hash;
    const std::span<const int32_t> info = pyramid.info();
    hash.add_bytes(info.data(), info.size_bytes());
    const int32_t header = pyramid.is_volume() ? texture::kVolumeInfoHeader : texture::kInfoHeader;
    const int32_t* level = info.data() + header;
    size_t values = static_cast<size_t>(level[1]) * static_cast<size_t>(level[2]) *
                    static_cast<size_t>(pyramid.channels());
    if (pyramid.is_volume()) values *= static_cast<size_t>(level[3]);
    add_floats(&hash, pyramid.texels().subspan(static_cast<size_t>(level[0]), values));
    return hash.value();
}

/// By address, so that what many parts share is hashed once; the order has no effect.
template <typename T>
class Shared {
  public:
    uint64_t of(const T* thing) {
        if (thing == nullptr) return 0;
        const auto [entry, fresh] = known_.try_emplace(thing, 0);
        if (fresh) entry->second = hash_of(*thing);
        return entry->second;
    }

  private:
    std::map<const T*, uint64_t> known_;
};

/// Hashes of what parts are made from, list by list.
struct MadeFrom {
    Hash fablets, meshes, uniforms, textures, placements;
    Shared<part::PartMesh> mesh_hashes;
    Shared<mesh::Beams> beam_hashes;
    Shared<texture::Pyramid> texture_hashes;

    /// `is_body`: of a part without a volume, which another's stage asks.
    void add_geometry(const part::Part& part, bool is_body) {
        meshes.add(mesh_hashes.of(part.mesh.get()));
        std::visit([&](const auto& of) { add(of, is_body); }, part.geometry);
    }
    /// Without derived values, which depend on passes.
    void add_uniforms(const part::Part& of) {
        uniforms.add_all(std::span(of.uniform_values)
                             .first(static_cast<size_t>(of.fablet->uniform_value_count)));
    }
    void add_textures(const part::Part& of) {
        for (const auto& pyramid : of.textures)
            textures.add(texture_hashes.of(pyramid.get()));
    }

  private:
    void add(const part::MeshGeometry& /*of*/, bool /*is_body*/) {}
    void add(const part::BeamGeometry& of, bool is_body) {
        meshes.add(beam_hashes.of(of.beams->beams.get()));
        if (is_body) return;
        meshes.add(of.beams->scale);
        meshes.add_all(of.beams->attributes);
    }
    void add(const part::ShapeGeometry& of, bool is_body) { add(*of.stage, is_body); }
    void add(const part::GrownGeometry& of, bool is_body) { add(*of.stage, is_body); }
    void add(const part::ShapeStage& stage, bool is_body) {
        if (!is_body) fablets.add(std::string(stage.fablet->name));
        fablets.add(stage.fablet->hash);
        add_uniforms(stage);
        add_textures(stage);
        for (const auto& body : stage.bodies) {
            if (body != nullptr) add_geometry(*body, true);
        }
    }
};

/// Returns the name of the dither; where no fablet has a rule of its own it is the default one's.
std::string dither_of(const PrintInput& input, const PrintOptions& options) {
    const bool any = std::any_of(input.parts.begin(), input.parts.end(),
                                 [](const part::Part& p) { return p.fablet->has_dither != 0; });
    return !any && options.dither == dither::kOwnDitherName ? dither::kDefaultDitherName
                                                            : options.dither;
}

}  // namespace

std::vector<std::pair<std::string, std::string>> provenance(const PrintInput& input,
                                                            const PrintOptions& options) {
    MadeFrom from;
    for (const part::Part& part : input.parts) {
        from.fablets.add(std::string(part.fablet->name));
        from.fablets.add(part.fablet->hash);
        from.add_geometry(part, false);
        from.add_uniforms(part);
        from.uniforms.add_all(part.slot_material);
        from.uniforms.add(part.max_displacement_mm);
        from.textures.add(part.textures.size());
        from.add_textures(part);
        from.placements.add_all(part.local_to_build.m);
        from.placements.add(part.local_to_build.t);
        from.placements.add(part.priority);
        from.placements.add(part.instance);
        from.placements.add(int32_t{part.support});
        for (const std::vector<int32_t>& objects : part.objects)
            from.placements.add_all(objects);
        if (part.piece != nullptr) add_piece(&from.placements, *part.piece);
    }
    std::vector<std::pair<std::string, std::string>> made_from = {
        {"version of openfab", OPENFAB_VERSION},
        {"dither", dither_of(input, options)},
        {"support",
         input.support_code == 0 ? "none" : input.materials[input.support_code - 1].name},
        {"fablets", from.fablets.text()},
        {"meshes", from.meshes.text()},
        {"uniforms", from.uniforms.text()},
        {"textures", from.textures.text()},
        {"placements", from.placements.text()}};
    made_from.insert(made_from.end(), input.process.begin(), input.process.end());
    return made_from;
}

}  // namespace openfab::pipeline
