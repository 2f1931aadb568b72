#!/bin/bash
# What the Makefile promises of builds: other flags are other objects, another
# PREFIX another pelagos.pc, programs need only the libraries that they use, every
# package is used, and clangd is told of every source. Builds nothing of ours.
set -u
cd "$(dirname "$0")/.."
unset MAKEFLAGS MAKELEVEL
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
bin=${PELAGOS_BIN:-build/release/bin}
failed=0

fail() {
    echo "FAILED: $*"
    failed=1
}

object() { # where main.c would be compiled to
    make -n -W server/main.c "$@" build/release/bin/pelagosd |
        grep -o 'build/release/obj-[0-9a-f]*/server/main.o' | head -n 1
}
plain=$(object)
[ -n "$plain" ] || fail "nothing would be compiled"
[ "$plain" = "$(object)" ] || fail "the same flags give other objects"
seen=$plain
for flags in DEV=1 CC=clang CFLAGS=-O3 CPPFLAGS=-DX LDFLAGS=-s PKGS=glib-2.0; do
    other=$(object "$flags" 2>/dev/null)
    case " $seen " in
    *" $other "*) fail "objects of $flags are those of others" ;;
    esac
    seen="$seen $other"
done
make -n CFLAGS=-O3 build/release/bin/pelagosd | grep -q 'LINK .*pelagosd' ||
    fail "other flags do not link anew"

for prefix in /opt/one /opt/two; do
    make -s O="$work/o" PREFIX=$prefix "$work/o/pelagos.pc" ||
        fail "no pelagos.pc"
    grep -q "^prefix=$prefix$" "$work/o/pelagos.pc" ||
        fail "pelagos.pc: $(head -n 1 "$work/o/pelagos.pc") after $prefix"
done

needs() { # PROGRAM LIBRARY…: the program needs none of them
    program=$1
    shift
    for library; do
        if readelf -d "$bin/$program" | grep -q "NEEDED.*\\[$library"; then
            fail "$program needs $library"
        fi
    done
}
needs pelagosctl libmicrohttpd libmodbus libepoxy libgstrtsp libspng libgdal
needs pelagos-seabed libmicrohttpd libmodbus libepoxy libgst libglib libssl
needs pelagos-weather libmicrohttpd libmodbus libepoxy libgst libglib libssl
needs pelagos-panorama libmicrohttpd libmodbus libepoxy libgst libglib libssl libgdal
needs pelagos-model libmicrohttpd libmodbus libepoxy libgst libglib libssl libgdal
needs pelagos-spectrum libmicrohttpd libmodbus libepoxy libgst libglib libssl libgdal
needs pelagosd libgdal libcmocka libhdf5 libassimp libnetcdf

# Each package that is asked for has a library of its own that some program
# needs, of those that are built.
needed=$(for file in "$bin"/*; do
    readelf -d "$file" 2>/dev/null
done | grep -o 'NEEDED.*\[.*\]' | grep -o '\[.*\]' | sort -u)
sonames() { # -l…: what a program that is linked with them needs
    echo 'int main(void) { return 0; }' |
        gcc -x c - -o "$work/all" -Wl,--no-as-needed "$@" || return
    readelf -d "$work/all" | grep -o 'NEEDED.*\[.*\]' | grep -o '\[.*\]' |
        grep -v '\[libc\.'
}
used() { # NAME -l…: what is needed is among them
    name=$1
    shift
    sonames "$@" | grep -qxF "$needed" || fail "no program uses $name"
}
packages=$(make -s --eval='words: ; @echo $(PKGS) $(CTL_PKGS) $(READER_PKGS) $(MODEL_PKGS)' \
    words)
[ "$(wc -w <<<"$packages")" -gt 10 ] || fail "which packages? $packages"
for package in $packages; do
    # What it requires has packages of its own; openssl has no more than that.
    others=$(pkg-config --print-requires "$package" | cut -d ' ' -f 1)
    theirs=$(pkg-config --libs-only-l $others 2>/dev/null | tr ' ' '\n')
    own=$(pkg-config --libs-only-l "$package" | tr ' ' '\n' |
        grep -vxF -e "$theirs")
    # shellcheck disable=SC2046,SC2086
    used "$package" $(pkg-config --libs-only-L "$package") \
        ${own:-$(pkg-config --libs-only-l "$package")}
done
for library in $(grep -oE '^(PKG|READER|MODEL|CTL)_LIBS = .*' Makefile |
    grep -oE -e ' -l[A-Za-z]+'); do
    used "$library" "$library"
done

for source in $(git ls-files 'server/*.c' 'proto/*.c' 'clients/*.c' 2>/dev/null ||
    find server proto clients -name '*.c'); do
    grep -qF "\"file\": \"$source\"" build/compile_commands.json ||
        fail "compile_commands.json lacks $source"
done
exit $failed
