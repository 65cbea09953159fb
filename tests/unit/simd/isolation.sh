#!/usr/bin/env bash
# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
#
# isolation.sh NM COUNT OBJECTS…: fails if an object defines a symbol that the linker may share, as inline functions
# are: those of an object that is compiled for a wider instruction set would run on machines that do not have it. COUNT:
# the number of objects.
nm=$1 count=$2
shift 2
if [ $# -ne "$count" ]; then
    echo "isolation.sh: $# objects, not $count: $*" >&2
    exit 1
fi
status=0
for object in "$@"; do
    if ! symbols=$("$nm" -C --defined-only "$object"); then
        status=1
    elif shared=$(grep -E ' [WVu] ' <<< "$symbols"); then
        printf '%s defines shared symbols:\n%s\n' "$object" "$shared" >&2
        status=1
    fi
done
exit "$status"
