#!/bin/bash
# image.sh DEBS OUT VERSION: what packaging/Dockerfile builds, without a registry:
# a root file system of Debian's packages and of those in DEBS, as an OCI image
# in the archive OUT. As root.
set -eu
cd "$(dirname "$0")/.."
debs=$1 out=$2 version=$3
[ "$(id -u)" = 0 ] || { echo "image: only root can make it" >&2; exit 1; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir "$work/debs"
for name in pelagosd pelagosctl; do
    cp "$debs/${name}_${version}"_*.deb "$work/debs"
done
# Their dependencies, the first of alternatives.
needs=$(for deb in "$work"/debs/*.deb; do
    dpkg-deb -f "$deb" Depends Pre-Depends; done |
    sed 's/^[A-Za-z-]*: //' | tr ',' '\n' |
    sed -E 's/\|.*//; s/\(.*//; s/:[a-z]+//; s/ //g' |
    sed 's/^systemd$/systemd-standalone-sysusers/' |
    grep -vx '' | sort -u | paste -sd,)
mmdebstrap --mode=root --variant=minbase --quiet \
    --include="$needs,gstreamer1.0-plugins-bad,gstreamer1.0-plugins-ugly,gstreamer1.0-nice" \
    --dpkgopt='path-exclude=/usr/share/man/*' \
    --dpkgopt='path-exclude=/usr/share/locale/*' \
    --dpkgopt='path-exclude=/usr/share/doc/*' \
    --dpkgopt='path-include=/usr/share/doc/*/copyright' \
    --customize-hook="copy-in $work/debs /tmp" \
    --customize-hook='chroot "$1" sh -c "dpkg -i /tmp/debs/*.deb"' \
    --customize-hook='rm -rf "$1"/tmp/debs "$1"/var/log/* "$1"/var/lib/apt/lists/*' \
    --customize-hook='chroot "$1" install -d -o pelagos -g pelagos -m 700 /var/lib/pelagos /var/cache/pelagos' \
    --customize-hook="copy-in packaging/image/start.sh packaging/image/health.sh /usr/libexec/pelagos" \
    bookworm "$work/root" ${MIRROR:+"$MIRROR"} >&2
mkdir -p "$(dirname "$out")"
umoci init --layout "$work/oci"
umoci new --image "$work/oci:$version"
umoci insert --image "$work/oci:$version" "$work/root" /
umoci config --image "$work/oci:$version" --config.user pelagos \
    --config.entrypoint /usr/libexec/pelagos/start.sh \
    --config.env PATH=/usr/sbin:/usr/bin:/sbin:/bin \
    --config.env MESA_SHADER_CACHE_DIR=/var/cache/pelagos \
    --config.env XDG_CACHE_HOME=/var/cache/pelagos \
    --config.env GST_REGISTRY=/var/cache/pelagos/gstreamer.bin \
    --config.exposedports 8080/tcp --config.exposedports 7878/tcp \
    --config.exposedports 8554/tcp --config.volume /var/lib/pelagos \
    --config.workingdir / --author "Pelagos contributors" --architecture "$(dpkg --print-architecture)"
umoci gc --layout "$work/oci"
tar -C "$work/oci" -cf "$out" .
echo "unpacked $(du -sm "$work/root" | cut -f 1) MB"
ls -l "$out"
