#!/bin/bash
# deb.sh OUT BUILD_PACKAGES SITE_PACKAGES THIRD EMBEDDED...: Debian packages into
# the folder OUT, built in OUT/pelagos-VERSION, whose objects are kept for the next
# time. The sources are those of the commit, with what the page embeds (NAME=FILE)
# from the folder THIRD. The changelog is made of VERSION and of CHANGELOG.md;
# DEBFULLNAME and DEBEMAIL sign it.
#
# PELAGOS_AS_BUILT=1, for tests: the files as they lie here, the programs as
# they lie in build/release, and no package of debug symbols.
set -eu
cd "$(dirname "$0")/.."
out=$1
version=$(cat VERSION)
abi=${version%.*}
tree=$out/pelagos-$version
mkdir -p "$tree"
out=$(cd "$out" && pwd)
tree=$out/pelagos-$version

sources() { # their names, each with a zero
    if [ -n "${PELAGOS_AS_BUILT:-}" ] && git rev-parse -q HEAD >/dev/null 2>&1; then
        git ls-files -z --cached --others --exclude-standard --deduplicate
    else
        find . -path ./build -prune -o -path ./.git -prune -o -type f -print0
    fi
}
fresh=$(mktemp -d "$out/fresh.XXXXXX")
trap 'rm -rf "$fresh"' EXIT
if [ -z "${PELAGOS_AS_BUILT:-}" ] && git rev-parse -q HEAD >/dev/null 2>&1; then
    [ -z "$(git status --porcelain)" ] ||
        echo "deb: what is not committed is not in the packages" >&2
    git archive HEAD | tar -x -C "$fresh"
else
    sources | while IFS= read -r -d '' file; do
        [ ! -f "$file" ] || printf '%s\0' "$file"
    done | tar -c --null -T - | tar -x -C "$fresh"
fi
from=$4
third=$fresh/third-party
for each in "${@:5}"; do
    file=${each#*=}
    if [ -f "$from/$file" ]; then
        mkdir -p "$third/$(dirname "$file")"
        cp -p "$from/$file" "$third/$file"
    fi
done
# What Debian calls sources without sources: the scripts as they were written.
for file in uplot/dist/uPlot.iife.js hls.js/dist/hls.light.js; do
    [ ! -d "$third/${file%%/*}" ] || [ ! -f "$from/$file" ] ||
        cp -p "$from/$file" "$third/$file"
done
mkdir -p "$fresh/debian"
cp -R packaging/debian/. "$fresh/debian"

# --- what is told in one place only -------------------------------------------
date=$(sed -n "s/^## $version – \([0-9-]*\)\$/\1/p" CHANGELOG.md)
[ -n "$date" ] || { echo "CHANGELOG.md has no date of $version" >&2; exit 1; }
cat >"$fresh/debian/changelog" <<END
pelagos ($version) unstable; urgency=medium

  * Version $version; CHANGELOG.md says what is new.

 -- ${DEBFULLNAME:-Pelagos contributors} <${DEBEMAIL:-pelagos@example.org}>  $(LC_ALL=C date -u -R -d "$date")
END
fill() { # a template of packaging/debian; gcc, libc and make need no naming
    /usr/bin/python3 - "packaging/debian/$1" "$abi" "$2" "$3" "$third" <<'END'
import sys
template, abi, build, site, third = sys.argv[1:]
packages = [[p for p in names.split() if p not in ("gcc", "libc6-dev", "make")]
            for names in (build, site)]
licence = open("LICENSE").read().split("\n\n", 2)[2].strip().split("\n")
text = open(template).read().replace("@ABI@", abi)
embedded = ""
for package, terms in (("uplot", "MIT"), ("hls.js", "Apache-2.0")):
    try:  # what the page embeds
        words = open(f"{third}/{package}/LICENSE").read()
    except FileNotFoundError:
        continue
    owner = next(line for line in words.split("\n") if "Copyright" in line)
    embedded += (f"\nFiles: third-party/{package}/*\nCopyright:" +
                 owner.split("(c)")[1] + f"\nLicense: {terms}\n")
    if terms == "Apache-2.0":
        embedded += (" On Debian systems the text of this licence is in\n"
                     " /usr/share/common-licenses/Apache-2.0.\n")
text = text.replace("@EMBEDDED@\n", embedded)
for name, names in zip(("BUILD", "SITE"), packages):
    need = " <!nodoc>" if name == "SITE" else ""
    text = text.replace(f"@{name}_PACKAGES@",
                        ",\n".join(" " * 15 + p + need for p in names))
print(text.replace("@LICENSE@", "\n".join(" " + (line or ".")
                                         for line in licence)), end="")
END
}
for file in control copyright; do
    fill $file "$2" "$3" >"$fresh/debian/$file"
done
fill libpelagos.symbols "$2" "$3" >"$fresh/debian/libpelagos$abi.symbols"
mv "$fresh/debian/libpelagos.install" "$fresh/debian/libpelagos$abi.install"
rm "$fresh/debian/libpelagos.symbols"

# --- the tree: files that are the same keep their time, so that make does too ---
(cd "$tree" && find . -path ./build -prune -o -type f -print0) |
    while IFS= read -r -d '' file; do
        [ -e "$fresh/$file" ] || rm -f "${tree:?}/$file"
    done
rm -rf "$tree/debian"
(cd "$fresh" && find . -type f -print0) | while IFS= read -r -d '' file; do
    if ! cmp -s "$fresh/$file" "$tree/$file"; then
        mkdir -p "$(dirname "$tree/$file")"
        mv "$fresh/$file" "$tree/$file"
        [ -n "${PELAGOS_AS_BUILT:-}" ] || touch "$tree/$file"
    fi
done
chmod +x "$tree/debian/rules"
options=
if [ -n "${PELAGOS_AS_BUILT:-}" ]; then
    mkdir -p "$tree/build/release/bin"
    objects=build/release/obj-$(cat build/release/flags)
    cp -a build/release/gen build/release/flags build/release/libpelagos.* \
        "$tree/build/release"
    for program in build/release/bin/pelagos*; do
        case $program in *_test | *-starved) ;; *)
            cp -a "$program" "$tree/build/release/bin" ;;
        esac
    done
    rm -rf "${tree:?}/$objects"
    cp -al $objects "$tree/build/release" 2>/dev/null ||
        cp -a $objects "$tree/build/release"
    options=noautodbgsym
fi

cd "$tree"
env -u MAKEFLAGS -u MAKELEVEL -u MFLAGS \
    DEB_BUILD_OPTIONS="$options parallel=$(nproc) ${DEB_BUILD_OPTIONS:-}" \
    dpkg-buildpackage -us -uc -nc ${DEB_BUILD_KIND:--F} >"$out/build.log" 2>&1 || {
    tail -n 40 "$out/build.log" >&2
    exit 1
}
cd "$out"
ls -l ./*.deb
