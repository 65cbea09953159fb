# Copyright 2026 The OpenFab Authors
# SPDX-License-Identifier: Apache-2.0
#
# OpenFab from its Debian package. In a clone:
#   scripts/package && docker build -t openfab .
#   docker run --rm -u "$(id -u):$(id -g)" -v "$PWD:/work" openfab print ball.fab.json -o slices
# scripts/test-image makes the same root without Docker, and works in it.
FROM debian:bookworm-slim
COPY build/package/openfab_*.deb /tmp/package/
# One layer, or what is removed would still be in the image. Fablets are compiled by openflc itself; of GCC stay the C compiler, for
# the table of a print program, and the linker. OpenImageIO depends on much that no program of ours loads: drivers of displays
# and a second LLVM for them.
RUN apt-get update -qq \
    && apt-get install -y -qq --no-install-recommends /tmp/package/*.deb > /tmp/said || { cat /tmp/said; exit 1; } \
    && dpkg-query -W -f '${Package}\n' 'libllvm15' 'libgl1-mesa-dri' 'iso-codes' '*-va-driver' '*-vdpau-driver' 'libvdpau-va-gl1' \
        'perl' 'perl-modules-5*' 'libperl5*' 'proj-data' 'shared-mime-info' 2> /dev/null \
        | xargs dpkg --purge --force-depends > /tmp/said 2>&1 || { cat /tmp/said; exit 1; } \
    && rm -f /usr/lib/gcc/*/*/cc1plus /usr/lib/gcc/*/*/lto1 /usr/lib/gcc/*/*/lib*san* \
        /usr/lib/*-linux-gnu/lib*san.so.* /usr/lib/*-linux-gnu/lib*san_* \
    && rm -rf /tmp/package /tmp/said /var/lib/apt/lists/* /var/cache/apt/* /var/cache/debconf/*-old /var/log/*.log /var/log/apt \
        /usr/share/locale/* /usr/share/man/* /usr/share/info/* \
    && find /usr/share/doc -type f ! -name copyright ! -path '*/openfab/*' -delete
# Compiled fablets; mount a volume there to keep them.
ENV OPENFAB_CACHE=/tmp/openfab-cache
WORKDIR /work
USER 1000:1000
ENTRYPOINT ["openfab"]
CMD ["--help"]
