// Copyright 2026 The OpenFab Authors
// SPDX-License-Identifier: Apache-2.0
#include "runtime/solid/kind.h"

namespace openfab::solid {

bool same_arguments(const openfab_kernel& kernel, const part::Part& a, const part::Part& b) {
    for (int32_t i = 0; i < kernel.arg_count; ++i) {
        const auto index = static_cast<size_t>(kernel.args[i].a);
        switch (kernel.args[i].kind) {
            case OPENFAB_ARG_UNIFORM:
                if (a.uniform_values[index] != b.uniform_values[index]) return false;
                break;
            case OPENFAB_ARG_VALUES:
                if (a.uniform_values != b.uniform_values) return false;
                break;
            case OPENFAB_ARG_TEXTURE:
                if (a.textures[index] != b.textures[index]) return false;
                break;
            case OPENFAB_ARG_INSTANCE:
                if (a.instance != b.instance) return false;
                break;
            default:
                break;
        }
    }
    return true;
}

}  // namespace openfab::solid
