// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "world/dither_ref.h"

#include "world/world_keys.h"

namespace openfab::world {

DitherRef read_dither(const JsonValue& value, JsonReader* json, WorldFiles* files) {
    DitherRef out;
    if (!json->object(value, world_keys("dither"), "`dither`")) return out;
    out.source = files->existing(value.find("source")->value, "the source of `dither`");
    out.rule = json->string(value.find("rule")->value, "`rule` of `dither`");
    out.location = json->location(value.find("rule")->value);
    return out;
}

}  // namespace openfab::world
