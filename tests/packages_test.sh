#!/bin/bash
# What is installed: all of it goes again, the shared library exports what the
# public headers declare and nothing else, pelagos.pc is right for each prefix,
# and the wheel can be installed and says its version.
set -u
cd "$(dirname "$0")/.."
unset MAKEFLAGS MAKELEVEL
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
version=$(cat VERSION)
abi=${version%.*}
failed=0
fail() {
    echo "FAILED: $*"
    failed=1
}
files() { # below a folder, folders too
    (cd "$1" && find . | sort)
}
# As what is here was built, so that nothing is built anew.
dev=
for try in '' 1; do
    [ "$(make -s DEV=$try --eval='key: ; @echo $(KEY)' key)" != \
        "$(cat build/release/flags)" ] || dev=$try
done
make_() {
    DEPS=skip make -s DEV=$dev "$@" >"$work/log" 2>&1 || fail "make $*: $(tail -n 5 "$work/log")"
}

echo "== install, uninstall"
root=$work/root
mkdir -p "$root/opt/one/share/pelagos" "$root/opt/one/lib"
echo ours >"$root/opt/one/share/pelagos/harbour.json"
echo ours >"$root/opt/one/lib/libother.so"
mkdir "$root/opt/one/bin" # empty, and not ours
files "$root" >"$work/before"
make_ PREFIX=/opt/one DESTDIR="$root" install
files "$root" >"$work/after"
[ "$(comm -13 "$work/before" "$work/after" | wc -l)" -gt 20 ] ||
    fail "installed: $(cat "$work/after")"
cp -a "$root" "$work/kept"
make_ PREFIX=/opt/one DESTDIR="$root" uninstall
diff "$work/before" <(files "$root") || fail "uninstall left or took something"
make_ PREFIX=/opt/one DESTDIR="$root" install
echo '# mine' >>"$root/etc/pelagos/pelagosd.conf"
make_ PREFIX=/opt/one DESTDIR="$root" uninstall
grep -q 'kept, since it was changed' "$work/log" ||
    fail "uninstall says nothing of the changed file"
diff <({ cat "$work/before"
    printf '%s\n' ./etc ./etc/pelagos ./etc/pelagos/pelagosd.conf; } | sort) \
    <(files "$root") || fail "uninstall took a file that was changed"
rm -r "$root"

echo "== each file has its Debian package"
make_ PREFIX=/usr SYSCONFDIR=/etc LIBDIR=/usr/lib/any-triplet \
    UNITDIR=/lib/systemd/system SYSUSERSDIR=/usr/lib/sysusers.d \
    TMPFILESDIR=/usr/lib/tmpfiles.d DESTDIR="$root" install
# debian/rules moves zsh's completions to where Debian has them, and leaves out
# what `make uninstall` alone reads.
rm "$root/usr/share/pelagos/folders"
mv "$root/usr/share/zsh/site-functions" "$root/usr/share/zsh/vendor-completions"
/usr/bin/python3 - "$root" packaging/debian/*.install <<'END' || fail "a file of make install is in no package"
import fnmatch, os, sys
root = sys.argv[1]
patterns = [line.split()[0] for name in sys.argv[2:] for line in open(name)]
bad = [path for folder, _, names in os.walk(root) for name in names
       if not any(fnmatch.fnmatch(path := os.path.relpath(
           os.path.join(folder, name), root), p + end)
           for p in patterns for end in ("", "/*"))]
sys.exit("\n".join(bad) or 0)
END
rm -r "$root"

echo "== pelagos.pc of two prefixes, the library shared and static"
mkdir -p "$work/use"
cat >"$work/use/use.c" <<'END'
#include <pelagos.h>
#include <stdio.h>
int main(void)
{
    struct pel_client *client = NULL;
    Pelagos__State state = PELAGOS__STATE__INIT;
    return puts(pel_client_code_name(PEL_CLIENT_BUSY)) < 0 ||
           pelagos__state__get_packed_size(&state) != 0 ||
           pel_client_connect("unix:/nowhere", 100, &client, NULL) !=
               PEL_CLIENT_UNREACHABLE;
}
END
for name in one two; do
    prefix=$work/$name
    make_ PREFIX="$prefix" SYSCONFDIR="$prefix/etc" install
    export PKG_CONFIG_PATH=$prefix/lib/pkgconfig
    [ "$(pkg-config --modversion pelagos)" = "$version" ] ||
        fail "pelagos.pc says $(pkg-config --modversion pelagos)"
    # shellcheck disable=SC2046
    cc "$work/use/use.c" -o "$work/use/shared" \
        $(pkg-config --cflags --libs pelagos) || fail "no use of $prefix"
    readelf -d "$work/use/shared" | grep -q "NEEDED.*\[libpelagos.so.$abi\]" ||
        fail "linked without the soname"
    LD_LIBRARY_PATH=$prefix/lib "$work/use/shared" | grep -qx BUSY ||
        fail "the shared library does not run"
    LD_LIBRARY_PATH=$prefix/lib ldd "$work/use/shared" |
        grep -q "$prefix/lib/libpelagos" || fail "another library than $prefix"
    # shellcheck disable=SC2046
    cc "$work/use/use.c" -o "$work/use/static" \
        $(pkg-config --cflags --libs --static pelagos |
            sed 's/-lpelagos/-l:libpelagos.a/') && "$work/use/static" >/dev/null ||
        fail "the static library"
done
unset PKG_CONFIG_PATH

echo "== symbols"
# By the compiler's own list of what the headers declare.
gcc -fsyntax-only -aux-info "$work/aux" -x c - -I"$work/one/include/pelagos" \
    <<<'#include <pelagos.h>' || fail "the headers"
{
    grep -E 'include/pelagos/[^ ]*:[0-9]+:' "$work/aux" |
        grep -oE '\bpel[a-z_0-9]+ \(' | tr -d ' ('
    gcc -E -x c - -I"$work/one/include/pelagos" <<<'#include <pelagos.h>' |
        grep -oE '^extern const Protobuf[A-Za-z]+ pelagos__[a-z_0-9]+' |
        awk '{ print $NF }'
} | sort -u >"$work/declared"
nm -D --defined-only "$work/one/lib/libpelagos.so" |
    awk '$2 != "A" { print $NF }' | sort -u >"$work/exported"
[ "$(wc -l <"$work/declared")" -gt 300 ] || fail "declared: $(wc -l <"$work/declared")"
diff <(sed "s/\$/@@PELAGOS_$abi/" "$work/declared") "$work/exported" ||
    fail "what is exported is not what is declared"

echo "== wheel"
make_ DIST="$work/dist" wheel
wheel=$work/dist/pelagos-$version-py3-none-any.whl
[ -e "$wheel" ] || fail "no wheel: $(ls "$work/dist")"
cp "$wheel" "$work/first"
make_ DIST="$work/dist" wheel
cmp "$wheel" "$work/first" || fail "a second wheel is another"
/usr/bin/python3 -m venv "$work/venv" &&
    "$work/venv/bin/pip" install -q --no-index --no-deps \
        --disable-pip-version-check "$wheel" || fail "the wheel does not install"
said=$(cd "$work" && venv/bin/python -c '
import importlib.metadata, pelagos
print(pelagos.__version__, importlib.metadata.version("pelagos"),
      pelagos.Sea().windSpeed, pelagos.__file__)')
case $said in
"$version $version "*"$work/venv/"*) ;;
*) fail "the wheel says $said" ;;
esac

exit $failed
