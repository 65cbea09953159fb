# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
# cmake -DINPUT=file -DOUTPUT=header -P embed_text.cmake: the ABI header as a C++ string, for generated tables.
file(READ ${INPUT} content)
file(WRITE ${OUTPUT} "// Generated from fablet_table.h by embed_text.cmake.\n#pragma once\n\nnamespace openfab::lower {\n\ninline constexpr char kAbiHeader[] = R\"abi(${content})abi\";\n\n}  // namespace openfab::lower\n")
